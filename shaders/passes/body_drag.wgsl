// Fluid sticks to bodies and drags them along, by Morris' viscosity as at walls: (mu rho0 / rho_a^2) (1/G) |D| (u - v_a) / y, with
// s = sum_k V_k F, D = sum_k V_k F x_ak and y = |D| / s - depth over the samples of a body, and u the velocity that it would have where
// the particle is. Derived in crates/freshet_cpu/src/passes/body_drag.rs and morris1997.rs.
//
// Of several bodies a particle sticks to that with the largest s. What the body gets, the pass body_load sums up over its samples, to each
// its share of s.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::kernels
#import freshet::threads

#ifdef BODY_DRAG
// Sums over the samples of one body, without their factor: s and D with the sign of f', and of where samples are from its centre of mass.
struct Contact {
    body: u32,
    // Whether there is another body with a higher number.
    more: bool,
    strength: f32,
    slope: vec3<f32>,
    arms: vec3<f32>,
}

// Bodies are counted from one here.
const NOBODY: u32 = 0u;

// The first body after `last` that a particle touches. One time round for each body of a particle, of which there is seldom more than one.
fn after(position: vec3<f32>, last: u32) -> Contact {
    let place = grid::place_of(position);
    let extent = grid::shape();
    let body_starts = fields::parameters.body_starts;
    let inverse_radius = fields::parameters.inverse_support_radius;
    let squared_radius = fields::parameters.squared_support_radius;
    var found: Contact;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let samples = grid::row_of(body_starts, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < samples.count; t++) {
            let k = grid::member(samples, t);
            let sample = fields::sample(k);
            let x = grid::difference(position, sample.position);
            let r_squared = dot(x, x);
            if (r_squared >= squared_radius) {
                continue;
            }
            let arm = fields::sample_arm(k);
            let body = arm.body + 1u;
            if (body <= last) {
                continue;
            }
            if (found.body != NOBODY && body != found.body) {
                if (body > found.body) {
                    found.more = true;
                    continue;
                }
                found = Contact(NOBODY, true, 0.0, vec3<f32>(0.0), vec3<f32>(0.0));
            }
            found.body = body;
            let weight = sample.weight * kernels::slope_over_q(sqrt(r_squared) * inverse_radius);
            found.strength += weight;
            found.slope += weight * x;
            found.arms += weight * arm.offset;
        }
    }
    return found;
}

// The body that a particle sticks to.
fn contact_of(position: vec3<f32>) -> Contact {
    var found = after(position, NOBODY);
    var best = found;
    while (found.more) {
        found = after(position, found.body);
        if (found.strength < best.strength) {
            best = found;
        }
    }
    return best;
}

// m/s2
fn drag(contact: Contact, velocity: vec3<f32>, density: f32) -> vec3<f32> {
    let away = contact.slope / contact.strength;
    let distance = length(away);
    let y = max(distance - fields::parameters.body_depth, fields::parameters.nearest_wall);
    let arm = contact.arms / contact.strength + away;
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
    let contact = contact_of(fields::sorted_position(a));
    // Of what touches none, or of samples of no weight, nothing.
    if (!(contact.strength < 0.0)) {
        fields::set_contact(a, NOBODY, vec3<f32>(0.0));
        return;
    }
    let motion = fields::velocity_and_density(a);
    let drag = drag(contact, motion.xyz, motion.w);
    fields::set_acceleration(a, fields::acceleration(a) + drag);
    fields::set_contact(a, contact.body, (-fields::parameters.particle_mass / contact.strength) * drag);
}
#endif
