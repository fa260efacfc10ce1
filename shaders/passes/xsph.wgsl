// XSPH, see freshet_core::xsph: e_a = epsilon (m/S) sum_b 2 (v_b - v_a) / (rho_a + rho_b) W_ab over the fluid, of the
// velocities that particles leave the substep with. The b come from the bits that the density pass left, see library/hits.wgsl.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::hits
#import freshet::integrator
#import freshet::kernels
#import freshet::threads

// What every pair of a particle needs.
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
    velocity: vec3<f32>,
    density: f32,
    substep: f32,
}

// The velocity that a particle leaves the substep with.
fn velocity_after(i: u32, velocity: vec3<f32>, substep: f32) -> vec3<f32> {
#ifdef INTEGRATOR
    return integrator::velocity_after(integrator::past_of(i), velocity, fields::acceleration(i), substep);
#else
    return velocity + fields::acceleration(i) * substep;
#endif
}

fn own_of(a: u32) -> Own {
    let motion = fields::velocity_and_density(a);
    let substep = fields::control.substep;
    return Own(
        fields::sorted_position(a),
        fields::parameters.inverse_support_radius,
        velocity_after(a, motion.xyz, substep),
        motion.w,
        substep,
    );
}

// f(q) (v_b - v_a) / (rho_a + rho_b)
fn from_particle(own: Own, b: u32) -> vec3<f32> {
    let q = length(grid::difference(own.position, fields::sorted_position(b))) * own.inverse_radius;
    let motion = fields::velocity_and_density(b);
    let velocity = velocity_after(b, motion.xyz, own.substep);
    return kernels::shape(q) / (own.density + motion.w) * (velocity - own.velocity);
}

fn drift_of(a: u32) -> vec3<f32> {
    let own = own_of(a);
    let center = grid::cell_of(own.position);
    let extent = grid::shape();
    var sum = vec3<f32>(0.0);
    for (var row = 0u; row < 9u; row++) {
        var found = 0u;
        if (row == hits::OWN_ROW) {
            found = fields::hits_of_own_row(a);
        } else {
            found = fields::hits_of(a, hits::word_of(row));
        }
        if (hits::is_empty(found)) {
            continue;
        }
        let cells = grid::cells_of(extent, center, row, found & hits::BEGIN, grid::ROW_CELLS);
        let around = grid::open_row_of(0u, cells);
        for (var places = hits::places_of(found); places != 0u; places &= places - 1u) {
            sum += from_particle(own, grid::member(around, hits::first_of(places)));
        }
        if ((found & hits::MORE) != 0u) {
            let all = grid::row_of(0u, cells);
            for (var t = hits::PLACES; t < all.count; t++) {
                sum += from_particle(own, grid::member(around, t));
            }
        }
    }
    return fields::parameters.xsph_scale * sum;
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn xsph(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        fields::set_drift(a, drift_of(a));
    }
}
