// Changes to the particles before a tick: each is a dispatch of its own, in the order the commands came.

#import freshet::bindings as fields
#import freshet::threads

#ifdef SPAWN
// Copies new particles behind the live ones. What does not fit is refused: `finish_spawn` counts it.
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn spawn(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k >= fields::command.count || fields::control.count + k >= fields::command.capacity) {
        return;
    }
    let source = fields::command.first + k;
    let target_index = fields::control.count + k;
    // How long ago it was where it is said to be; negative if it will be.
    var age = 0.0;
    if (fields::command.timed != 0u) {
        // The ticks whose reports were missing when the command was written, in units of 2^-24 s.
        age = fields::spawned_age(source) + f32(i32(fields::control.clock - fields::command.clock)) / 16777216.0;
    }
    fields::set_particle(
        target_index,
        fields::spawned_position(source) + fields::spawned_velocity(source) * age,
        fields::control.next_id + k,
        fields::spawned_velocity(source),
        fields::spawned_life(source) - age,
    );
    fields::set_density(target_index, 0.0, 0.0);
    fields::set_acceleration(target_index, vec3<f32>(0.0));
#ifdef INCOMPRESSIBLE
    fields::set_solved_pressure(target_index, 0.0);
#endif
#ifdef HISTORIES
    for (var word = 0u; word < #{HISTORY_WORDS}u; word++) {
        fields::set_history(target_index, word, 0.0);
    }
#endif
}
#endif

#ifdef FINISH_SPAWN
#import freshet::arguments

@compute @workgroup_size(1)
fn finish_spawn() {
    let room = fields::command.capacity - min(fields::control.count, fields::command.capacity);
    let accepted = min(fields::command.count, room);
    fields::control.count += accepted;
    fields::control.live = fields::control.count;
    fields::control.next_id += accepted;
    fields::control.refused += fields::command.count - accepted;
    arguments::write_arguments(fields::control.going != 0u);
}
#endif

// A removed particle keeps its place until the next sort, with a lifetime that is over.
#ifdef REMOVE_IDS
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn remove_ids(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = threads::thread_index(group, local);
    if (i < fields::control.count && fields::id(i) - fields::command.first < fields::command.count) {
        fields::set_remaining_life(i, -1.0);
    }
}
#endif

#ifdef REMOVE_IN_BOX
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn remove_in_box(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = threads::thread_index(group, local);
    if (i < fields::control.count) {
        let position = fields::position(i);
        if (all(position >= fields::command.low) && all(position <= fields::command.high)) {
            fields::set_remaining_life(i, -1.0);
        }
    }
}
#endif
