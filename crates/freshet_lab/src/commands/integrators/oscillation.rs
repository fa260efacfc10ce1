//! What an integrator makes of an oscillator.

use freshet_core::integrator::Integrator;
use freshet_core::integrator::oscillator::State;

use crate::measure::spectral_radius::{is_within, spectral_radius};
use crate::measure::statistics::order;
use crate::reference::integrators::Oscillator;

/// A spectral radius up to which an integrator is stable.
pub const STABLE: f64 = 1.0 + 1e-9;
/// Steps of a run that confirms a limit.
pub const STEPS: u32 = 100_000;
/// Such a run is made this much below the limit and above it, as a share of the limit.
pub const BESIDE: f64 = 1e-3;
/// Amplitude over that of the start up to which a run is taken for stable. Near a limit amplitudes come and go as in a beat.
pub const BOUNDED: f64 = 1e3;
/// Amplitude from which on a run is ended as unstable.
const GONE: f64 = 1e12;
/// The largest `omega h` looked at.
const MOST: f64 = 2.5;
/// Limits below this are none: what grows with each step however short, by less than the 1e-9 that a spectral radius is granted if the step is
/// short enough.
pub const NONE: f64 = 0.02;

/// What is found for one integrator, without damping or with critical damping.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Which.
    pub integrator: Integrator,
    /// Whether the oscillator is critically damped.
    pub damped: bool,
    /// Largest `omega h` up to which all steps are stable.
    pub limit: f64,
    /// Amplitude over that of the start of a run just below the limit; none if there is no limit.
    pub below: Option<f64>,
    /// Of a run just above it, or, if there is none, at [`SHORT`].
    pub above: f64,
    /// Largest error of the position, m, from an amplitude of 1 m, over `omega h`.
    pub errors: Vec<(f64, f64)>,
    /// Of the velocity at its own time, over the frequency.
    pub velocity_errors: Vec<(f64, f64)>,
    /// Energy after [`PERIODS`] over that at the start, each the mean of ten periods, at [`DRIFT_STEP`]; none with damping.
    pub energy: Option<f64>,
}

/// The `omega h` at which what has no stable step at all is shown to grow.
pub const SHORT: f64 = 0.3;
/// The `omega h` at which energies are compared: about 31 steps a period.
pub const DRIFT_STEP: f64 = 0.2;
/// Periods over which energies are compared.
pub const PERIODS: f64 = 1000.0;

impl Found {
    /// All integrators, without damping and then with it.
    pub fn all() -> Vec<Self> {
        let of = |damped| Integrator::ALL.map(|integrator| Self::of(integrator, damped));
        [of(false), of(true)].concat()
    }

    /// Looks at one integrator.
    pub fn of(integrator: Integrator, damped: bool) -> Self {
        let limit = limit(integrator, damped);
        let has_limit = limit >= NONE;
        let below = has_limit.then(|| amplitude(integrator, damped, limit * (1.0 - BESIDE)));
        let above = amplitude(integrator, damped, if has_limit { limit * (1.0 + BESIDE) } else { SHORT });
        let (errors, velocity_errors) = [1u32, 2, 4, 8, 16, 32]
            .into_iter()
            .map(|halvings| {
                let step = 0.2 / f64::from(halvings);
                let [of_position, of_velocity] = errors(integrator, damped, step);
                ((step, of_position), (step, of_velocity))
            })
            .unzip();
        let energy = (!damped).then(|| energy_ratio(integrator));
        Self { integrator, damped, limit, below, above, errors, velocity_errors, energy }
    }

    /// Observed order of the position and of the velocity, between the two shortest steps.
    pub fn orders(&self) -> [f64; 2] {
        [&self.errors, &self.velocity_errors].map(|errors| {
            let resolved = |&(step, error): &(f64, f64)| (1.0 / step, error);
            match &errors[..] {
                [.., coarse, fine] => order(resolved(coarse), resolved(fine)).unwrap_or(f64::NAN),
                _ => f64::NAN,
            }
        })
    }
}

fn damping(damped: bool) -> f64 {
    if damped { 1.0 } else { 0.0 }
}

/// Spectral radius of a step.
pub fn radius(integrator: Integrator, damped: bool, step: f64) -> f64 {
    spectral_radius(&integrator.one_step_matrix(step, damping(damped)), integrator.state_len())
}

/// The `omega h` up to which the spectral radius is 1 + 1e-9 or less, in the units of the frequency.
fn limit(integrator: Integrator, damped: bool) -> f64 {
    let stable =
        |step: f64| is_within(&integrator.one_step_matrix(step, damping(damped)), integrator.state_len(), STABLE);
    let scan = 1e-3;
    let steps = (MOST / scan) as u32;
    let Some(first) = (1..=steps).map(|n| f64::from(n) * scan).find(|&step| !stable(step)) else { return MOST };
    let (mut low, mut high) = (first - scan, first);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}

/// Largest distance from rest in [`STEPS`] steps over that of the start, which is at rest.
fn amplitude(integrator: Integrator, damped: bool, step: f64) -> f64 {
    let oscillator = Oscillator { frequency: step, damped };
    let f = |x: f64, v: f64| oscillator.acceleration(x, v);
    let mut state = integrator.start(f, 1.0, 0.0, 1.0);
    let mut most: f64 = 1.0;
    for _ in 0..STEPS {
        state = integrator.step(f, state, 1.0);
        most = most.max(state.x.abs());
        if most > GONE {
            break;
        }
    }
    most
}

/// Largest errors of position and velocity in `omega t` from 0 to 4 with a step of this `omega h`.
fn errors(integrator: Integrator, damped: bool, step: f64) -> [f64; 2] {
    let oscillator = Oscillator { frequency: 1.0, damped };
    let f = |x: f64, v: f64| oscillator.acceleration(x, v);
    let mut state = integrator.start(f, 1.0, 0.0, step);
    let mut worst = [0.0f64; 2];
    for n in 1..=(4.0 / step).round() as u32 {
        state = integrator.step(f, state, step);
        let at = |steps: f64| oscillator.exact(steps * step);
        let time = f64::from(n);
        worst[0] = worst[0].max((state.x - at(time).0).abs());
        worst[1] = worst[1].max((state.v - at(time + integrator.velocity_time()).1).abs());
    }
    worst
}

/// Mean energy of ten periods after [`PERIODS`] over that of the first ten.
fn energy_ratio(integrator: Integrator) -> f64 {
    let oscillator = Oscillator { frequency: DRIFT_STEP, damped: false };
    let f = |x: f64, v: f64| oscillator.acceleration(x, v);
    let period = std::f64::consts::TAU / DRIFT_STEP;
    let ten = (10.0 * period).round() as u32;
    let mean = |state: &mut State| {
        let mut sum = 0.0;
        for _ in 0..ten {
            *state = integrator.step(f, *state, 1.0);
            sum += 0.5 * (state.v * state.v + (DRIFT_STEP * state.x).powi(2));
        }
        sum / f64::from(ten)
    };
    let mut state = integrator.start(f, 1.0, 0.0, 1.0);
    let first = mean(&mut state);
    for _ in 0..(PERIODS * period).round() as u32 - 2 * ten {
        state = integrator.step(f, state, 1.0);
    }
    mean(&mut state) / first
}
