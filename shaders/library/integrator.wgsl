// How velocities and positions change in a substep: the rules of freshet_core::integrator::past, with its names.
#define_import_path freshet::integrator

#import freshet::bindings as fields

// What a particle keeps of its last steps. Words that its integrator does not keep are zero.
struct Past {
    step: f32,
    first: vec3<f32>,
    step_before: f32,
    second: vec3<f32>,
}

fn past_of(a: u32) -> Past {
    var past = Past(0.0, vec3<f32>(0.0), 0.0, vec3<f32>(0.0));
#ifdef PASTS
    past.step = fields::sorted_history(a, 0u);
#if PAST_WORDS >= 4
    past.first = vec3<f32>(fields::sorted_history(a, 1u), fields::sorted_history(a, 2u), fields::sorted_history(a, 3u));
#endif
#if PAST_WORDS >= 8
    past.step_before = fields::sorted_history(a, 4u);
    past.second = vec3<f32>(fields::sorted_history(a, 5u), fields::sorted_history(a, 6u), fields::sorted_history(a, 7u));
#endif
#endif
    return past;
}

// A slope is not carried further than ten times the way that it was taken over.
const MOST_RATIO: f32 = 10.0;

// Length of a step over that of the one before; zero if there was none.
fn ratio(length: f32, before: f32) -> f32 {
    return select(0.0, min(length / before, MOST_RATIO), before > 0.0);
}

// Slope of the acceleration times the square of a step h, where `first` was the acceleration a step of length `last` before.
fn slope(a: vec3<f32>, first: vec3<f32>, last: f32, h: f32) -> vec3<f32> {
    return ratio(h, last) * (a - first) * h;
}

// What a velocity is expected to change by in a step h.
fn expected(a: vec3<f32>, first: vec3<f32>, last: f32, h: f32) -> vec3<f32> {
    return a * h + 0.5 * slope(a, first, last, h);
}

// What Beeman's velocity changes by in the last step.
fn beeman(past: Past, a: vec3<f32>) -> vec3<f32> {
    let turn = a - past.first - ratio(past.step, past.step_before) * (past.first - past.second);
    // As if there had been one as long, without a change of the acceleration.
    let share = select(0.5, past.step / (past.step + past.step_before), past.step_before > 0.0);
    return (0.5 * (a + past.first) - turn * share / 3.0) * past.step;
}

// The velocity after a substep of h seconds, from velocity and acceleration before.
fn velocity_after(past: Past, v: vec3<f32>, a: vec3<f32>, h: f32) -> vec3<f32> {
#ifdef INTEGRATOR_LEAPFROG
    return v + 0.5 * (past.step + h) * a;
#else ifdef INTEGRATOR_VERLET
    return select(v, past.first, past.step > 0.0) + 0.5 * past.step * a;
#else ifdef INTEGRATOR_VELOCITY_VERLET
    return v + 0.5 * past.step * (past.first + a);
#else ifdef INTEGRATOR_BEEMAN
    return v + beeman(past, a);
#else ifdef INTEGRATOR_VELOCITY_CORRECTED_BEEMAN
    // The velocity before was expected for now; what it was expected from is known again.
    return v - expected(past.first, past.second, past.step_before, past.step) + beeman(past, a)
        + expected(a, past.first, past.step, h);
#else
    return v + a * h;
#endif
}

// What a particle moves with in the substep; v is its velocity after it.
fn motion_in(past: Past, v: vec3<f32>, a: vec3<f32>, h: f32) -> vec3<f32> {
#ifdef INTEGRATOR_CLAVET
    return v + a * h;
#else ifdef INTEGRATOR_VERLET
    return v + 0.5 * h * a;
#else ifdef INTEGRATOR_VELOCITY_VERLET
    return v + 0.5 * h * a;
#else ifdef INTEGRATOR_BEEMAN
    return v + 0.5 * h * a + slope(a, past.first, past.step, h) / 6.0;
#else ifdef INTEGRATOR_VELOCITY_CORRECTED_BEEMAN
    return v - 0.5 * h * a - slope(a, past.first, past.step, h) / 3.0;
#else
    return v;
#endif
}
