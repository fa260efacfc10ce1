// Density sum and pressure: rho_a = (1/S) (m sum_b W_ab + rho0 sum_k V_k W_ak), a itself among the b. Where supports vary, W_ab
// has the mean of both, and the support pass has left the neighbours.
// Keeps P_a = p_a / rho_a^2 beside rho_a, which is what the pressure force needs; of an incompressible fluid the solves find it.

#import freshet::bindings as fields
#import freshet::compression
#import freshet::equation_of_state
#import freshet::grid
#import freshet::hits
#import freshet::kernels
#import freshet::threads

fn density_of(a: u32) -> f32 {
    let position = fields::sorted_position(a);
    let place = grid::place_of(position);
    // Uniforms that the loops need: see grid::Shape.
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
#ifdef WIDTHS
    let width = fields::width(a);
#else
    let squared_radius = fields::parameters.squared_support_radius;
#endif
#ifdef WALLS
    let wall_starts = fields::parameters.wall_starts;
    let near_walls = grid::is_near_walls(place.cell);
#endif
#ifdef BODIES
    let body_starts = fields::parameters.body_starts;
#endif
    var fluid = 0.0;
#ifdef SAMPLES
    var samples = 0.0;
#endif
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let cells = grid::cells_of(extent, place.cell, row, reached.x, reached.y);
        let around = grid::row_of(0u, cells);
#ifndef WIDTHS
        var found = reached.x | select(0u, hits::MORE, around.count > hits::PLACES);
        // Shifted out after the last place that has a bit.
        var bit = hits::FIRST_PLACE;
#endif
        for (var t = 0u; t < around.count; t++) {
            let b = grid::member(around, t);
            let x = grid::difference(position, fields::sorted_position(b));
            let r_squared = dot(x, x);
#ifdef WIDTHS
            let inverse_width = 2.0 / (width + fields::width(b));
            let shape = kernels::shape(sqrt(r_squared) * inverse_radius * inverse_width);
            fluid += inverse_width * inverse_width * inverse_width * shape;
#else
            fluid += kernels::shape(sqrt(r_squared) * inverse_radius);
            // Not the particle itself, nor one at the same place: they exert no force.
            found |= select(0u, bit, r_squared < squared_radius && r_squared > 0.0);
            bit <<= 1u;
#endif
        }
#ifdef WALLS
        if (near_walls) {
            let walls = grid::row_of(wall_starts, cells);
#ifndef WIDTHS
            found |= select(0u, hits::SAMPLES, walls.count > 0u);
#endif
            for (var t = 0u; t < walls.count; t++) {
                let wall = fields::sample(grid::member(walls, t));
                let distance = length(grid::difference(position, wall.position));
                samples += wall.weight * kernels::shape(distance * inverse_radius);
            }
        }
#endif
#ifdef BODIES
        let bodies = grid::row_of(body_starts, cells);
#ifndef WIDTHS
        found |= select(0u, hits::SAMPLES, bodies.count > 0u);
#endif
        for (var t = 0u; t < bodies.count; t++) {
            let body = fields::sample(grid::member(bodies, t));
            let distance = length(grid::difference(position, body.position));
            samples += body.weight * kernels::shape(distance * inverse_radius);
        }
#endif
#ifndef WIDTHS
        if (row == hits::OWN_ROW) {
            fields::set_hits_of_own_row(a, found);
        } else {
            fields::set_hits(a, hits::word_of(row), found);
        }
#endif
    }
#ifdef SAMPLES
    return fields::parameters.fluid_density_scale * fluid + fields::parameters.sample_density_scale * samples;
#else
    return fields::parameters.fluid_density_scale * fluid;
#endif
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn density(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let density = density_of(a);
#ifndef INCOMPRESSIBLE
        fields::set_density(a, density, equation_of_state::pressure_term(density));
#endif
        fields::set_velocity_and_density(a, fields::velocity_before(a), density);
#ifndef WALL_GHOSTS
        compression::add(density);
#endif
    }
    compression::finish(local);
}
