// Densities and pressures of the samples of quasi-fluid walls, s times as dense as the fluid at rest: rho_k/s = own_k rho0 + (m/(s S)) sum_a W_ak and
// P_k = p(rho_k/s) / rho_k^2 (freshet_core::wall_method::QuasiFluid).

#import freshet::bindings as fields
#import freshet::equation_of_state
#import freshet::grid
#import freshet::kernels
#import freshet::threads

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn wall_density(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k >= fields::parameters.wall_samples) {
        return;
    }
    let position = fields::sample(k).position;
    let place = grid::place_of(position);
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    var shapes = 0.0;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let around = grid::row_of(0u, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let x = grid::difference(fields::sorted_position(grid::member(around, t)), position);
            shapes += kernels::shape(length(x) * inverse_radius);
        }
    }
    let relative = fields::parameters.wall_relative_density;
    let rest_density = fields::parameters.rest_density;
    let own = fields::wall_own_density(k) * rest_density;
    let density = max(own + fields::parameters.fluid_density_scale * shapes / relative, 1e-3 * rest_density);
    fields::set_wall_pressure(k, equation_of_state::pressure_term(density) / (relative * relative));
}
