// Which body a particle sticks to or rubs on: of several that with the largest sum of V_k F, for friction times its coefficient.
#define_import_path freshet::contacts

#import freshet::bindings as fields
#import freshet::grid
#import freshet::pressure_kernels
#import freshet::viscosity_kernels

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
#ifdef BODY_FRICTION
            let weight = sample.weight * pressure_kernels::slope_over_q(sqrt(r_squared) * inverse_radius);
#else
            let weight = sample.weight * viscosity_kernels::slope_over_q(sqrt(r_squared) * inverse_radius);
#endif
            found.strength += weight;
            found.slope += weight * x;
            found.arms += weight * arm.offset;
        }
    }
    return found;
}

// What of several bodies the one is chosen by.
fn size_of(contact: Contact) -> f32 {
#ifdef BODY_FRICTION
    return select(0.0, fields::body_friction(max(contact.body, 1u) - 1u).x, contact.body != NOBODY) * contact.strength;
#else
    return contact.strength;
#endif
}

// The body that a particle sticks to or rubs on.
fn contact_of(position: vec3<f32>) -> Contact {
    var found = after(position, NOBODY);
    var best = found;
    while (found.more) {
        found = after(position, found.body);
        if (size_of(found) < size_of(best)) {
            best = found;
        }
    }
    return best;
}

// From the body's centre of mass to the particle, m.
fn arm_of(contact: Contact) -> vec3<f32> {
    return (contact.arms + contact.slope) / contact.strength;
}
