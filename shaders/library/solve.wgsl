// What the passes of an incompressible fluid share: where its two solves are, the sum of what is left, the pace. Formulas:
// freshet_core::pressure_solver::DivergenceFree.
#define_import_path freshet::solve

#import freshet::bindings as fields
#import freshet::threads

// Where a substep is: in none of its solves, in the divergence solve, between the two, in the density solve.
const NONE: u32 = 0u;
const DIVERGENCE: u32 = 1u;
const BETWEEN: u32 = 2u;
const DENSITY: u32 = 3u;
// In that of a Poisson equation.
const POISSON: u32 = 4u;

// What is left is summed in integers, so that its mean has the same bits whatever the order. In 64 bits: a million particles
// with all of their density left make 2^50.
const LEFT_UNIT: f32 = 1073741824.0;

// More than can be left.
const MUCH: f32 = 3.0e38;

var<workgroup> group_low: atomic<u32>;
var<workgroup> group_high: atomic<u32>;

fn left_units(wrong: f32) -> u32 {
    return u32(min(select(0.0, wrong, threads::is_finite(wrong)), 1.0) * LEFT_UNIT);
}

// Adds to the group's sum: a group of 256 times 2^16 fits into either half.
fn add_left(wrong: f32) {
    let units = left_units(wrong);
    atomicAdd(&group_low, units & 0xffffu);
    atomicAdd(&group_high, units >> 16u);
}

// Adds the group's sum to that of all; after a barrier, by one thread.
fn publish_left() {
    let low = atomicLoad(&group_low);
    let high = atomicLoad(&group_high) + (low >> 16u);
    let added = (high << 16u) | (low & 0xffffu);
    let before = atomicAdd(&fields::control.left_low, added);
    atomicAdd(&fields::control.left_high, (high >> 16u) + select(0u, 1u, before + added < before));
}

// Takes the sum of all away and gives the mean; single threads only.
fn take_mean_left() -> f32 {
    let low = atomicExchange(&fields::control.left_low, 0u);
    let high = atomicExchange(&fields::control.left_high, 0u);
    return in_ones(vec2<u32>(low, high)) / f32(max(fields::control.live, 1u));
}

// A sum of what is left, lower half first.
fn in_ones(sum: vec2<u32>) -> f32 {
    return f32(sum.y) * 4.0 + f32(sum.x) / LEFT_UNIT;
}

// Single threads: a solve begins, before its first `set_momentum`.
fn start_pace() {
    fields::control.iterations = 0u;
    fields::control.pace = 1.0;
    fields::control.last_left = MUCH;
}

// Single threads: Nesterov's momentum for the next step.
fn set_momentum() {
    let pace = fields::control.pace;
    let next = 0.5 * (1.0 + sqrt(1.0 + 4.0 * pace * pace));
    fields::control.pace = next;
    fields::control.momentum = max((pace - 1.0) / next, fields::parameters.least_momentum);
}
