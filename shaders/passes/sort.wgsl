// Counting sort of the particles by cell, by id within a cell. Reads the state, writes the sorted copy.
//
// Particles that are dead, not finite or out of bounds are sorted into one cell past the last, whose start is therefore
// the number of live particles; nothing after that start is read again.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::threads

fn is_retired(i: u32) -> bool {
    return fields::remaining_life(i) <= 0.0;
}

fn is_finite(i: u32) -> bool {
    return threads::all_finite(fields::position(i)) && threads::all_finite(fields::velocity(i));
}

fn is_inside(i: u32) -> bool {
    let position = fields::position(i);
    return all(position >= fields::parameters.bounds_min) && all(position <= fields::parameters.bounds_max);
}

fn sorting_cell(i: u32) -> u32 {
    if (is_retired(i) || !is_finite(i) || !is_inside(i)) {
        return fields::parameters.cells;
    }
    return grid::cell_index(grid::cell_of(fields::position(i)));
}

#ifdef SORT_COUNT
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn sort_count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = threads::thread_index(group, local);
    if (i >= fields::control.count) {
        return;
    }
    let cell = sorting_cell(i);
    fields::add_to_cell_count(cell, 1u);
    if (cell == fields::parameters.cells) {
        if (is_retired(i)) {
            atomicAdd(&fields::control.retired, 1u);
        } else {
            atomicAdd(&fields::control.removed, 1u);
            if (!is_finite(i)) {
                atomicAdd(&fields::control.not_finite, 1u);
            }
        }
    }
}
#endif

#ifdef SORT_SCAN_BLOCKS
#import freshet::scan

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn sort_scan_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    scan::sum_block(threads::group_index(group), local, 0u, fields::parameters.cells + 1u);
}
#endif

#ifdef SORT_SCAN_CELLS
#import freshet::scan

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn sort_scan_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = threads::group_index(group);
    let cells = fields::parameters.cells + 1u;
    let before = scan::sum_before(block, local, 0u, cells);
    scan::write_starts(block, local, 0u, 0u, cells, before);
}
#endif

#ifdef SORT_SCATTER
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn sort_scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = threads::thread_index(group, local);
    if (i >= fields::control.count) {
        return;
    }
    let cell = sorting_cell(i);
    // Counting down leaves the counts at zero for the next substep: no pass to clear them.
    let remaining = fields::take_from_cell_count(cell);
    fields::set_slot(fields::cell_start(cell) + remaining, i);
}
#endif

#ifdef SORT_REORDER
#ifdef SPEEDS_OF_STATE
var<workgroup> group_speed: atomic<u32>;
#endif

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn sort_reorder(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = threads::thread_index(group, local);
    let live = fields::cell_start(fields::parameters.cells);
    if (slot == 0u) {
        fields::control.live = live;
    }
    if (slot < live) {
        let i = fields::slot(slot);
        let id = fields::id(i);
        let position = fields::position(i);
        let cell = grid::cell_index(grid::cell_of(position));
        let first = fields::cell_start(cell);
        let end = fields::cell_start(cell + 1u);
        // Scattering leaves a cell's particles in any order; counting the smaller ids puts them in order of id.
        var rank = 0u;
        for (var other = first; other < end; other++) {
            rank += select(0u, 1u, fields::id(fields::slot(other)) < id);
        }
        let velocity = fields::velocity(i);
        fields::set_sorted_position(first + rank, position, id);
        fields::set_velocity_before(first + rank, velocity);
        fields::set_sorted_remaining_life(first + rank, fields::remaining_life(i));
#ifdef HISTORIES
        for (var word = 0u; word < #{HISTORY_WORDS}u; word++) {
            fields::set_sorted_history(first + rank, word, fields::history(i, word));
        }
#endif
#ifdef INCOMPRESSIBLE
        fields::set_sorted_pressure(first + rank, fields::solved_pressure(i));
#endif
#ifdef SPEEDS_OF_STATE
        atomicMax(&group_speed, threads::ordered_bits(length(velocity)));
#endif
    }
#ifdef SPEEDS_OF_STATE
    workgroupBarrier();
    if (local == 0u) {
#ifdef INCOMPRESSIBLE
        atomicMax(&fields::control.state_speed, atomicLoad(&group_speed));
#else
        atomicMax(&fields::control.max_speed, atomicLoad(&group_speed));
#endif
    }
#endif
}
#endif
