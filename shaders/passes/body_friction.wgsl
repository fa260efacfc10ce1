// Coulomb friction of bodies that the fluid does not move: as that of walls, see friction.wgsl, with D = sum_k V_k F x_ak over the samples of a
// body and the velocity that it has at the end of the substep where the particle is. What the body gets is summed up over its samples, to each its
// share of sum_k V_k F, as in body_load.wgsl; that adds it to the body's load.

#import freshet::bindings as fields
#ifdef BODY_FRICTION
#import freshet::contacts
#import freshet::coulomb
#ifndef INCOMPRESSIBLE
#import freshet::equation_of_state
#endif
#endif
#ifdef FRICTION_LOAD
#import freshet::grid
#import freshet::pressure_kernels
#import freshet::swelling
#endif
#import freshet::threads

#ifdef CONTACT_PRESSURE
// The pressures of an incompressible fluid to where the next pass has them: with all it needs there is no room for the solve's own buffer.
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn contact_pressure(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        fields::set_contact(a, 0u, vec3<f32>(fields::solved_pressure(a), 0.0, 0.0));
    }
}
#endif

#ifdef BODY_FRICTION
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_friction(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let motion = fields::velocity_and_density(a);
#ifdef INCOMPRESSIBLE
    let pressure = fields::contact_force(a).x;
#else
    let pressure = equation_of_state::pressure_term(motion.w);
#endif
    let contact = contacts::contact_of(fields::sorted_position(a));
    // What does not press is not held.
    if (pressure <= 0.0 || !(contact.strength < 0.0)) {
        fields::set_contact(a, contacts::NOBODY, vec3<f32>(0.0));
        return;
    }
    let body = contact.body - 1u;
    let dt = fields::control.substep;
    let linear = fields::body_linear_velocity(body) + fields::body_drift(body) + dt * fields::body_acceleration(body);
    let surface = linear + cross(fields::body_angular_velocity(body) + fields::body_turn(body), contacts::arm_of(contact));
    let push = (-fields::parameters.sample_force_scale * pressure) * contact.slope;
    let coefficients = fields::body_friction(body);
    let before = fields::acceleration(a);
    let velocity = motion.xyz + dt * before - surface;
    let taken = coulomb::taken(velocity, coefficients.x * push, coefficients.y * length(push), dt);
    fields::set_acceleration(a, before - taken);
    fields::set_contact(a, contact.body, (fields::parameters.particle_mass / contact.strength) * taken);
}
#endif

#ifdef FRICTION_LOAD
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn friction_load(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k >= fields::parameters.body_samples) {
        return;
    }
    let body = fields::body_of_sample(k);
    let arm = swelling::arm(k, body);
    let position = fields::body_position(body) + arm;
    if (!threads::all_finite(position)) {
        fields::set_sample_load(k, vec3<f32>(0.0), vec3<f32>(0.0), 0.0);
        return;
    }
    let place = grid::place_of(position);
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    var force = vec3<f32>(0.0);
    var torque = vec3<f32>(0.0);
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let around = grid::row_of(0u, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let a = grid::member(around, t);
            if (fields::contact_body(a) != body + 1u) {
                continue;
            }
            let x = grid::difference(fields::sorted_position(a), position);
            let share = pressure_kernels::slope_over_q(length(x) * inverse_radius) * fields::contact_force(a);
            force += share;
            torque += cross(arm + x, share);
        }
    }
    let weight = swelling::weight(k, body);
    fields::set_sample_load(k, weight * force, weight * torque, 0.0);
}
#endif
