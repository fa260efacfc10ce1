// Which particles of an incompressible fluid touch which bodies, and what that adds to their equations.
//
// body_touch: who touches whom, and the sum of sizes of each body.
// divergence_bodies: the bodies' part of how fast densities change, and of the diagonal.
// left_at_bodies: what the first iteration of the divergence solve leaves around each body; in the others it is found with the step.

#import freshet::bindings as fields
#import freshet::threads
#import freshet::touch
#ifdef LEFT_AT_BODIES
#import freshet::left_of_bodies
#endif

#ifdef BODY_TOUCH
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_touch(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    var word = touch::NOBODY;
    var swells = false;
    var found = touch::after(a, 0u);
    while (found.body != touch::NOBODY) {
        word = select(touch::SEVERAL, found.body, word == touch::NOBODY);
        let body = found.body - 1u;
        swells = swells || fields::body_swollen(body) < 1.0;
        let unit = touch::unit_of(body);
        let units = touch::size(found) / unit;
        let counts = unit > 0.0 && threads::is_finite(units);
        fields::add_touch(body, u32(select(0.0, min(units, 4e9), counts)));
        if (!found.more) {
            break;
        }
        found = touch::after(a, found.body);
    }
    fields::set_touch(a, word | select(0u, touch::SWELLS, swells));
}
#endif

#ifdef DIVERGENCE_BODIES
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn divergence_bodies(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    var rate = 0.0;
    var stiffness = 0.0;
    if (fields::touch(a) != touch::NOBODY) {
        let dt = fields::control.substep;
        var found = touch::after(a, 0u);
        while (found.body != touch::NOBODY) {
            let body = found.body - 1u;
            // With which it leaves the substep, if pressures stay as they are.
            let push = fields::body_force(body) * fields::body_inverse_mass(body) + fields::body_acceleration(body);
            let velocity = fields::body_linear_velocity(body) + fields::body_drift(body) + dt * push;
            let turning = fields::body_inverse_inertia(body) * fields::body_torque(body);
            let spin = fields::body_angular_velocity(body) + fields::body_turn(body) + dt * turning;
            rate -= dot(velocity, found.push) + dot(spin, found.turn);
            stiffness += touch::size(found) * (fields::sum_of_sizes(body) * touch::unit_of(body));
            if (!found.more) {
                break;
            }
            found = touch::after(a, found.body);
        }
    }
    fields::set_source(a, rate);
    fields::set_stiffness(a, fields::parameters.stiffness_scale * stiffness);
}
#endif

#ifdef LEFT_AT_BODIES
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn left_at_bodies(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        left_of_bodies::add(a, 0.0, fields::left(a), -fields::solved_pressure(a));
    }
}
#endif
