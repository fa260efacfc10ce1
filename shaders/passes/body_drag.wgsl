// Fluid sticks to bodies and drags them along, by Morris' viscosity as at walls: (mu rho0 / rho_a^2) (1/G) |D| (u - v_a) / y, with
// s = sum_k V_k F, D = sum_k V_k F x_ak and y = |D| / s - depth over the samples of a body, and u the velocity that it would have where
// the particle is. Derived in crates/freshet_cpu/src/passes/body_drag.rs and morris1997.rs.
//
// Of several bodies a particle sticks to that with the largest s. What the body gets, the pass body_load sums up over its samples, to each
// its share of s.

#import freshet::bindings as fields
#import freshet::contacts
#import freshet::threads

#ifdef BODY_DRAG
// m/s2
fn drag(contact: contacts::Contact, velocity: vec3<f32>, density: f32) -> vec3<f32> {
    let distance = length(contact.slope / contact.strength);
    let y = max(distance - fields::parameters.body_depth, fields::parameters.nearest_wall);
    let arm = contacts::arm_of(contact);
    let body = contact.body - 1u;
    let linear = fields::body_linear_velocity(body) + fields::body_drift(body);
    let surface = linear + cross(fields::body_angular_velocity(body) + fields::body_turn(body), arm);
    let strength = -fields::parameters.sample_force_scale * contact.strength;
    let rate = fields::parameters.body_viscosity / (density * density) * strength * distance / y;
    return rate * (surface - velocity);
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_drag(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let contact = contacts::contact_of(fields::sorted_position(a));
    // Of what touches none, or of samples of no weight, nothing.
    if (!(contact.strength < 0.0)) {
        fields::set_contact(a, contacts::NOBODY, vec3<f32>(0.0));
        return;
    }
    let motion = fields::velocity_and_density(a);
    let drag = drag(contact, motion.xyz, motion.w);
    fields::set_acceleration(a, fields::acceleration(a) + drag);
    fields::set_contact(a, contact.body, (-fields::parameters.particle_mass / contact.strength) * drag);
}
#endif
