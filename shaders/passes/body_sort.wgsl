// Moves the bodies' samples to where the bodies are and sorts them by cell, by their number within a cell, on the grid of
// the particles. The same counting sort as sort.wgsl, on another section of the cell tables. Then densities and pressures of quasi-fluid
// samples: rho_k = own_k rho0 + (m/S) sum_a W_ak (freshet_core::sampling::quasi_fluid).

#import freshet::bindings as fields
#import freshet::grid
#import freshet::kernels
#import freshet::swelling
#import freshet::threads

// A sample where its body is now, m; samples of a body that is nowhere are kept out of the grid by `sample_cell`.
fn place(k: u32) -> vec3<f32> {
    let body = fields::body_of_sample(k);
    return fields::body_position(body) + swelling::arm(k, body);
}

fn sample_cell(k: u32) -> u32 {
    let position = place(k);
    if (!threads::all_finite(position)) {
        return fields::parameters.cells;
    }
    return grid::cell_index(grid::cell_of(position));
}

#ifdef BODY_SORT_COUNT
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sort_count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k < fields::parameters.body_samples) {
        fields::add_to_cell_count(fields::parameters.body_counts + sample_cell(k), 1u);
    }
}
#endif

#ifdef BODY_SORT_SCAN_BLOCKS
#import freshet::scan

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sort_scan_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    scan::sum_block(threads::group_index(group), local, fields::parameters.body_counts, fields::parameters.cells + 1u);
}
#endif

#ifdef BODY_SORT_SCAN_CELLS
#import freshet::scan

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sort_scan_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = threads::group_index(group);
    let counts = fields::parameters.body_counts;
    let cells = fields::parameters.cells + 1u;
    // The samples of walls come first in the buffer of samples.
    let before = fields::parameters.first_body_sample + scan::sum_before(block, local, counts, cells);
    scan::write_starts(block, local, counts, fields::parameters.body_starts, cells, before);
}
#endif

#ifdef BODY_SORT_SCATTER
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sort_scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k < fields::parameters.body_samples) {
        let cell = sample_cell(k);
        let remaining = fields::take_from_cell_count(fields::parameters.body_counts + cell);
        fields::set_body_slot(fields::cell_start(fields::parameters.body_starts + cell) - fields::parameters.first_body_sample + remaining, k);
    }
}
#endif

// Where a sample is among the sorted ones; NOWHERE for one that is kept out of the grid.
const NOWHERE: u32 = 0xffffffffu;

fn sorted_place(k: u32) -> u32 {
    let cell = sample_cell(k);
    if (cell == fields::parameters.cells) {
        return NOWHERE;
    }
    let first = fields::cell_start(fields::parameters.body_starts + cell);
    let end = fields::cell_start(fields::parameters.body_starts + cell + 1u);
    var rank = 0u;
    for (var other = first; other < end; other++) {
        rank += select(0u, 1u, fields::body_slot(other - fields::parameters.first_body_sample) < k);
    }
    return first + rank;
}

#ifdef BODY_SORT_REORDER
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sort_reorder(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = threads::thread_index(group, local);
    if (slot >= fields::parameters.body_samples) {
        return;
    }
    let k = fields::body_slot(slot);
    let sorted = sorted_place(k);
    if (sorted == NOWHERE) {
        return;
    }
    let body = fields::body_of_sample(k);
    fields::set_sample(sorted, vec4<f32>(place(k), swelling::weight(k, body)));
#ifdef SAMPLE_ARMS
    fields::set_sample_arm(sorted, swelling::arm(k, body), body);
#endif
}
#endif

#ifdef BODY_DENSITY
#import freshet::quasi_fluid

// Pressures of quasi-fluid samples, and zeros for the others, beside the sorted samples.
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_density(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k >= fields::parameters.body_samples) {
        return;
    }
    let sorted = sorted_place(k);
    if (sorted == NOWHERE) {
        return;
    }
    let position = place(k);
    let start = grid::place_of(position);
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    var shapes = 0.0;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(start, row);
        let around = grid::row_of(0u, grid::cells_of(extent, start.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let x = grid::difference(fields::sorted_position(grid::member(around, t)), position);
            shapes += kernels::shape(length(x) * inverse_radius);
        }
    }
    fields::set_sample_pressure(sorted, quasi_fluid::pressure_term(k, fields::body_of_sample(k), shapes));
}
#endif
