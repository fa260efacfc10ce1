// Pressure from density, as freshet_core::equation_of_state.
#define_import_path freshet::equation_of_state

#import freshet::bindings as fields

fn equation(density: f32) -> f32 {
#ifdef EQUATION_IDEAL_GAS
    return fields::parameters.stiffness * density;
#endif
#ifdef EQUATION_LINEAR
    // Desbrun, Harada and the linear one: reference pressure plus stiffness times excess density.
    return fields::parameters.reference_pressure
        + fields::parameters.stiffness * (density - fields::parameters.rest_density);
#endif
#ifdef EQUATION_TAIT
    let ratio = density * fields::parameters.inverse_rest_density;
#ifdef EXPONENT_SEVEN
    // pow() is exp2(n log2 x) on a GPU: slower, and with an error that grows with n.
    let square = ratio * ratio;
    return fields::parameters.stiffness * (square * square * square * ratio - 1.0);
#else
    return fields::parameters.stiffness * (pow(ratio, fields::parameters.exponent) - 1.0);
#endif
#endif
}

// p / rho^2: what the pressure force takes of a particle.
fn pressure_term(density: f32) -> f32 {
    return pressure(density) / (density * density);
}

fn pressure(density: f32) -> f32 {
#ifdef CLAMP_NEGATIVE_PRESSURE
    let unclamped = equation(density);
    // Not max(): it may turn not-a-number into zero, and such a particle would not be noticed.
    return select(unclamped, 0.0, unclamped < 0.0);
#else
    return equation(density);
#endif
}
