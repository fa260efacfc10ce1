// Densities and pressures of the samples of quasi-fluid walls, s times as dense as the fluid at rest: rho_k/s = own_k rho0 + (m/(s S)) sum_a W_ak and
// P_k = p(rho_k/s) / rho_k^2 (freshet_core::wall_method::QuasiFluid).
// Or what images of the fluid in walls add to its densities, and the pressures that follow (freshet_core::wall_method::ghosts).

#import freshet::bindings as fields
#import freshet::equation_of_state
#import freshet::grid
#import freshet::kernels
#import freshet::threads
#ifdef WALL_GHOSTS
#import freshet::compression
#import freshet::ghosts
#import freshet::wall_planes
#endif

// Sum of the kernel's shapes over the particles around a place.
fn shapes_around(position: vec3<f32>) -> f32 {
    let place = grid::place_of(position);
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    var shapes = 0.0;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let around = grid::row_of(0u, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let x = grid::difference(position, fields::sorted_position(grid::member(around, t)));
            shapes += kernels::shape(length(x) * inverse_radius);
        }
    }
    return shapes;
}

#ifdef WALL_GHOSTS
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn wall_density(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let position = fields::sorted_position(a);
        let place = grid::place_of(position);
        var density = fields::density(a);
        if (grid::is_near_walls(place.cell)) {
            var planes = wall_planes::planes_at(position, place);
            var shapes = 0.0;
            for (var mask = 1u; mask < (1u << planes.count); mask++) {
                if (ghosts::is_image(&planes, mask)) {
                    shapes += shapes_around(position + ghosts::way(&planes, mask));
                }
            }
            density = fields::density(a) + fields::parameters.fluid_density_scale * shapes;
            fields::set_density(a, density, equation_of_state::pressure_term(density));
            fields::set_velocity_and_density(a, fields::velocity_before(a), density);
        }
        compression::add(density);
    }
    compression::finish(local);
}
#else
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn wall_density(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k >= fields::parameters.wall_samples) {
        return;
    }
    let shapes = shapes_around(fields::sample(k).position);
    let relative = fields::parameters.wall_relative_density;
    let rest_density = fields::parameters.rest_density;
    let own = fields::wall_own_density(k) * rest_density;
    let density = max(own + fields::parameters.fluid_density_scale * shapes / relative, 1e-3 * rest_density);
    fields::set_wall_pressure(k, equation_of_state::pressure_term(density) / (relative * relative));
}
#endif
