// How wide the support of each particle is, see freshet_core::variable_support: w_a = (rho0 / rho_a)^(1/3) within limits, with
// rho_a = (1/S) (m sum_b W(r_ab, w_a H) + rho0 sum_k V_k W(r_ak, H)), from 1 on. Then which candidates may be neighbours, whatever
// the width of theirs: in place of the density pass, see library/hits.wgsl.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::hits
#import freshet::kernels
#import freshet::threads

const EVALUATIONS: u32 = #{WIDTH_EVALUATIONS}u;

// m A / (S H^3) sum_b f(r_ab / (w H)), a itself among the b.
fn fluid_around(position: vec3<f32>, place: grid::Place, extent: grid::Shape, width: f32) -> f32 {
    let inverse_radius = fields::parameters.inverse_support_radius / width;
    var sum = 0.0;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let around = grid::row_of(0u, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let x = grid::difference(position, fields::sorted_position(grid::member(around, t)));
            sum += kernels::shape(length(x) * inverse_radius);
        }
    }
    return fields::parameters.fluid_density_scale * sum;
}

#ifdef SAMPLES
// rho0 A / (S H^3) sum_k V_k f(r_ak / H)
fn samples_around(position: vec3<f32>, place: grid::Place, extent: grid::Shape) -> f32 {
    let inverse_radius = fields::parameters.inverse_support_radius;
    var sum = 0.0;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let cells = grid::cells_of(extent, place.cell, row, reached.x, reached.y);
#ifdef WALLS
        let walls = grid::row_of(fields::parameters.wall_starts, cells);
        for (var t = 0u; t < walls.count; t++) {
            let wall = fields::sample(grid::member(walls, t));
            sum += wall.weight * kernels::shape(length(grid::difference(position, wall.position)) * inverse_radius);
        }
#endif
#ifdef BODIES
        let bodies = grid::row_of(fields::parameters.body_starts, cells);
        for (var t = 0u; t < bodies.count; t++) {
            let body = fields::sample(grid::member(bodies, t));
            sum += body.weight * kernels::shape(length(grid::difference(position, body.position)) * inverse_radius);
        }
#endif
    }
    return fields::parameters.sample_density_scale * sum;
}
#endif

// Neighbours have at most the widest support.
fn find_hits(a: u32, position: vec3<f32>, place: grid::Place, extent: grid::Shape, width: f32) {
    let relative = 0.5 * (width + fields::parameters.widest_support);
    let squared_reach = relative * relative * fields::parameters.squared_support_radius;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let cells = grid::cells_of(extent, place.cell, row, reached.x, reached.y);
        let around = grid::row_of(0u, cells);
        var found = reached.x | select(0u, hits::MORE, around.count > hits::PLACES);
        // Shifted out after the last place that has a bit.
        var bit = hits::FIRST_PLACE;
        for (var t = 0u; t < min(around.count, hits::PLACES); t++) {
            let x = grid::difference(position, fields::sorted_position(grid::member(around, t)));
            let r_squared = dot(x, x);
            found |= select(0u, bit, r_squared < squared_reach && r_squared > 0.0);
            bit <<= 1u;
        }
#ifdef WALLS
        found |= select(0u, hits::SAMPLES, grid::row_of(fields::parameters.wall_starts, cells).count > 0u);
#endif
#ifdef BODIES
        found |= select(0u, hits::SAMPLES, grid::row_of(fields::parameters.body_starts, cells).count > 0u);
#endif
        if (row == hits::OWN_ROW) {
            fields::set_hits_of_own_row(a, found);
        } else {
            fields::set_hits(a, hits::word_of(row), found);
        }
    }
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn support(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let position = fields::sorted_position(a);
    let place = grid::place_of(position);
    let extent = grid::shape();
#ifdef SAMPLES
    let samples = samples_around(position, place, extent);
#else
    let samples = 0.0;
#endif
    var width = 1.0;
    for (var evaluation = 0u; evaluation < EVALUATIONS; evaluation++) {
        let fluid = fluid_around(position, place, extent, width);
        let density = fluid / (width * width * width) + samples;
        width = clamp(pow(fields::parameters.rest_density / density, 1.0 / 3.0), 1.0, fields::parameters.widest_support);
    }
    fields::set_width(a, width);
    find_hits(a, position, place, extent, width);
}
