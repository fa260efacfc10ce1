// Semi-implicit Euler: v += a dt, x += v dt. Reads the sorted copy, writes the state at the same index, so that whoever
// draws always reads the same buffers. With XSPH particles also move with what that pass found, x += (v + e) dt; those of an
// incompressible fluid move by the trapezoidal rule, x += (v + lead a) dt.

#import freshet::bindings as fields
#import freshet::threads

#ifdef PERIODIC
// What leaves a period through one end comes back through the other.
fn wrapped(position: vec3<f32>) -> vec3<f32> {
    let low = fields::parameters.period_low;
    let high = fields::parameters.period_high;
    let turns = floor((position - low) * fields::parameters.inverse_period);
    let moved = position - fields::parameters.period * turns;
    let image = select(low, moved, (moved >= low) & (moved < high));
    return select(image, position, (position >= low) & (position < high));
}
#endif

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn integrate(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let dt = fields::control.substep;
    let acceleration = fields::acceleration(a);
    let velocity = fields::velocity_and_density(a).xyz + acceleration * dt;
    var motion = velocity;
#ifdef XSPH_DRIFT
    motion += fields::drift(a);
#endif
#ifdef INCOMPRESSIBLE
    motion += acceleration * fields::control.lead;
#endif
    var position = fields::sorted_position(a) + motion * dt;
#ifdef INCOMPRESSIBLE
    // What the density solve found changes positions only.
    if (fields::control.correction > 0.0) {
        let way = fields::motion(a) * fields::control.correction;
        position += way * min(1.0, fields::parameters.longest_correction / max(length(way), 1e-30));
    }
#endif
#ifdef PERIODIC
    position = wrapped(position);
#endif
    fields::set_particle(a, position, fields::sorted_id(a), velocity, fields::sorted_remaining_life(a) - dt);
}
