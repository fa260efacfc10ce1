// Pressures of quasi-fluid samples of bodies: see freshet_core::sampling::quasi_fluid.
#define_import_path freshet::quasi_fluid

#import freshet::bindings as fields
#import freshet::equation_of_state
#import freshet::swelling

// p / rho^2 of a sample from the sum of the kernel's shapes over the particles around it; zero for one of a single layer, whose own density is
// negative. Samples of a body that has not begun to swell weigh nothing.
fn pressure_term(k: u32, body: u32, shapes: f32) -> f32 {
    let own = fields::sample_own_density(k);
    if (own < 0.0) {
        return 0.0;
    }
    let swollen = fields::body_swollen(body);
    let rest_density = fields::parameters.rest_density;
    let density = swollen * swollen * own * rest_density + fields::parameters.fluid_density_scale * shapes;
    return equation_of_state::pressure_term(max(density, 1e-3 * rest_density));
}
