// Smoothing kernels, as freshet_core::kernel: q = r / H, W = A / H^3 f(q). The scales are in the parameters; here are
// `shape` = f(q) and `slope_over_q` = f'(q) / q, both exactly zero for q >= 1. `(dW/dr) / r = A / H^5 f'(q) / q`.
// Sources of the formulas: freshet_core::kernel::KernelKind.
// Made of this text are also freshet::pressure_kernels and freshet::viscosity_kernels, with definitions of their own: the kernels of those terms.
#define_import_path freshet::kernels

#ifdef KERNEL_GAUSSIAN
fn shape(q: f32) -> f32 {
    return select(0.0, exp(-9.0 * q * q) - 1.2340980408667956e-4, q < 1.0);
}
fn slope_over_q(q: f32) -> f32 {
    return select(0.0, -18.0 * exp(-9.0 * q * q), q < 1.0);
}
#endif

#ifdef KERNEL_CUBIC_SPLINE
fn shape(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    return select(2.0 * p * p * p, 1.0 - 6.0 * q * q * p, q < 0.5);
}
fn slope_over_q(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    return select(-6.0 * p * p / max(q, 0.5), -12.0 + 18.0 * q, q < 0.5);
}
#endif

#ifdef KERNEL_QUINTIC_SPLINE
fn fourth(x: f32) -> f32 {
    return (x * x) * (x * x);
}
fn shape(q: f32) -> f32 {
    let a = max(3.0 - 3.0 * q, 0.0);
    let b = max(2.0 - 3.0 * q, 0.0);
    let c = max(1.0 - 3.0 * q, 0.0);
    return fourth(a) * a - 6.0 * fourth(b) * b + 15.0 * fourth(c) * c;
}
fn slope_over_q(q: f32) -> f32 {
    let s = 3.0 * q;
    let a = max(3.0 - s, 0.0);
    let b = max(2.0 - s, 0.0);
    // Near the centre the three brackets are multiplied out: their terms without s cancel, which the division needs.
    let near = 9.0 * (-120.0 + s * s * (120.0 - 50.0 * s));
    let far = 9.0 * (-5.0 * fourth(a) + 30.0 * fourth(b)) / max(s, 1.0);
    return select(far, near, s < 1.0);
}
#endif

#ifdef KERNEL_QUADRATIC
fn shape(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    return p * p;
}
fn slope_over_q(q: f32) -> f32 {
    return select(-2.0 * max(1.0 - q, 0.0) / q, 0.0, q == 0.0);
}
#endif

#ifdef KERNEL_QUARTIC
fn shape(q: f32) -> f32 {
    return select(0.0, 0.6666666666666666 + q * q * (-4.5 + q * (6.333333333333333 - 2.5 * q)), q < 1.0);
}
fn slope_over_q(q: f32) -> f32 {
    return -max(1.0 - q, 0.0) * (9.0 - 10.0 * q);
}
#endif

#ifdef KERNEL_WENDLAND_C2
fn shape(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    let square = p * p;
    return square * square * (4.0 * q + 1.0);
}
fn slope_over_q(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    return -20.0 * p * p * p;
}
#endif

#ifdef KERNEL_WENDLAND_NOTCH
fn shape(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    let square = p * p;
    var sum = 32.0 * q - 103.0;
    sum = sum * q + 144.81697612732097;
    sum = sum * q - 99.33421750663129;
    sum = sum * q + 28.714927987954603;
    sum = sum * q - 2.6902954358364584;
    sum = sum * q + 2.0905233977583744;
    return square * square * (sum * q + 0.5226308494395936);
}
fn slope_over_q(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    var sum = -352.0 * q + 1254.0;
    sum = sum * q - 1921.352785145889;
    sum = sum * q + 1518.7586206896553;
    sum = sum * q - 598.3413659422073;
    sum = sum * q + 102.28655657888257;
    return p * p * p * (sum * q - 15.83320786046479);
}
#endif

#ifdef KERNEL_POLY6
fn shape(q: f32) -> f32 {
    let p = max(1.0 - q * q, 0.0);
    return p * p * p;
}
fn slope_over_q(q: f32) -> f32 {
    let p = max(1.0 - q * q, 0.0);
    return -6.0 * p * p;
}
#endif

#ifdef KERNEL_SPIKY
fn shape(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    return p * p * p;
}
fn slope_over_q(q: f32) -> f32 {
    let p = max(1.0 - q, 0.0);
    return select(-3.0 * p * p / q, 0.0, q == 0.0);
}
#endif

#ifdef KERNEL_VISCOSITY
// In viscous forces only: half the Laplacian with the other sign, freshet_core::kernel::Kernel::viscous_over_r
fn slope_over_q(q: f32) -> f32 {
    return -3.0 * max(1.0 - q, 0.0);
}
#endif
