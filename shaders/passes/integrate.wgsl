// Semi-implicit Euler: v += a dt, x += v dt. Reads the sorted copy, writes the state at the same index, so that whoever
// draws always reads the same buffers.

#import freshet::bindings as fields
#import freshet::threads

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn integrate(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let dt = fields::control.substep;
    let velocity = fields::sorted_velocity(a) + fields::acceleration(a) * dt;
    let position = fields::sorted_position(a) + velocity * dt;
    fields::set_particle(a, position, fields::sorted_id(a), velocity, fields::sorted_remaining_life(a) - dt);
}
