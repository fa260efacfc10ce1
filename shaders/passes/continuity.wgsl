// Densities that particles carry, as e = rho/rho0 - 1 (freshet_core::density_form):
// e_a' = max(e_a + dt/(G rho0) [m sum_b v_ab . grad W_ab + rho0 sum_k V_k v_a . grad W_ak], least), the gradients at x_ab - v_ab dt/2, in the middle of the way of the last
// substep, which took dt. Then what the density pass makes of a density.

#import freshet::bindings as fields
#import freshet::threads

#ifdef CONTINUITY
#import freshet::grid
#import freshet::hits
#import freshet::kernels

// f'(q) / q x . v half a substep ago, of a difference of places and one of velocities
fn parting(x: vec3<f32>, v: vec3<f32>, half: f32, inverse_radius: f32) -> f32 {
    let between = x - half * v;
    return kernels::slope_over_q(length(between) * inverse_radius) * dot(between, v);
}

// d rho_a/dt over rho0
fn rate_of(a: u32, half: f32) -> f32 {
    let position = fields::sorted_position(a);
    let velocity = fields::velocity_before(a);
    let place = grid::place_of(position);
    // Uniforms that the loops need: see grid::Shape.
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    let squared_radius = fields::parameters.squared_support_radius;
#ifdef WALLS
    let wall_starts = fields::parameters.wall_starts;
    let near_walls = grid::is_near_walls(place.cell);
    var samples = 0.0;
#endif
    var fluid = 0.0;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let cells = grid::cells_of(extent, place.cell, row, reached.x, reached.y);
        let around = grid::row_of(0u, cells);
        var found = reached.x | select(0u, hits::MORE, around.count > hits::PLACES);
        // Shifted out after the last place that has a bit.
        var bit = hits::FIRST_PLACE;
        for (var t = 0u; t < around.count; t++) {
            let b = grid::member(around, t);
            let x = grid::difference(position, fields::sorted_position(b));
            let r_squared = dot(x, x);
            let parts = parting(x, velocity - fields::velocity_before(b), half, inverse_radius);
            fluid += select(0.0, parts, r_squared < squared_radius);
            // Not the particle itself, nor one at the same place: they exert no force.
            found |= select(0u, bit, r_squared < squared_radius && r_squared > 0.0);
            bit <<= 1u;
        }
#ifdef WALLS
        if (near_walls) {
            let walls = grid::row_of(wall_starts, cells);
            found |= select(0u, hits::SAMPLES, walls.count > 0u);
            for (var t = 0u; t < walls.count; t++) {
                let wall = fields::sample(grid::member(walls, t));
                let x = grid::difference(position, wall.position);
                let parts = wall.weight * parting(x, velocity, half, inverse_radius);
                samples += select(0.0, parts, dot(x, x) < squared_radius);
            }
        }
#endif
        if (row == hits::OWN_ROW) {
            fields::set_hits_of_own_row(a, found);
        } else {
            fields::set_hits(a, hits::word_of(row), found);
        }
    }
    var rate = fields::parameters.fluid_force_scale * fluid;
#ifdef WALLS
    rate += fields::parameters.sample_force_scale * samples;
#endif
    return rate * fields::parameters.inverse_rest_density;
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn continuity(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let dt = fields::control.last_substep;
        let excess = fields::excess_before(a) + dt * rate_of(a, 0.5 * dt);
        fields::set_excess(a, max(excess, fields::parameters.least_excess));
    }
}
#endif

#ifdef CARRIED_DENSITY
#import freshet::compression
#import freshet::equation_of_state

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn carried_density(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let density = fields::parameters.rest_density * (1.0 + fields::excess(a));
        fields::set_density(a, density, equation_of_state::pressure_term(density));
        fields::set_velocity_and_density(a, fields::velocity_before(a), density);
        compression::add(density);
    }
    compression::finish(local);
}
#endif
