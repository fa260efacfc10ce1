// Moves the bodies' samples to where the bodies are and sorts them by cell, by their number within a cell, on the grid of
// the particles. The same counting sort as sort.wgsl, on another section of the cell tables.

#import freshet::bindings as fields
#import freshet::grid
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

#ifdef BODY_SORT_REORDER
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sort_reorder(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = threads::thread_index(group, local);
    if (slot >= fields::parameters.body_samples) {
        return;
    }
    let k = fields::body_slot(slot);
    let cell = sample_cell(k);
    if (cell == fields::parameters.cells) {
        return;
    }
    let first = fields::cell_start(fields::parameters.body_starts + cell);
    let end = fields::cell_start(fields::parameters.body_starts + cell + 1u);
    var rank = 0u;
    for (var other = first; other < end; other++) {
        rank += select(0u, 1u, fields::body_slot(other - fields::parameters.first_body_sample) < k);
    }
    let body = fields::body_of_sample(k);
    fields::set_sample(first + rank, vec4<f32>(place(k), swelling::weight(k, body)));
#ifdef SAMPLE_ARMS
    fields::set_sample_arm(first + rank, swelling::arm(k, body), body);
#endif
}
#endif
