//! Integrators as solvers have them: from one evaluation of the acceleration to the next, with steps that differ in length.
//!
//! A solver finds the acceleration `a` of a particle at its position and velocity, then the length `h` of the step, and moves the particle. What
//! of the literature's step comes before its evaluation is made here after it, at the end of the substep before. So the velocity that a
//! particle has between substeps is the one that `f` sees: of Verlet, velocity Verlet and Beeman that of one substep before, of
//! leapfrog and modified velocity Verlet that of half a substep before. These two are the same in a solver, and so are Verlet and
//! velocity Verlet but for what they keep. Clavet's `y` is the particle's position.
//!
//! With `r = h / h0` of a step `h` after one of `h0`:
//! - velocities of half steps change by `a (h0 + h)/2`;
//! - `x' = x + v h + a h^2/2 + s h^3/6` with the slope `s = (a - a0)/h0`;
//! - a velocity changes in a step by `(a + a') h/2 - c h^3/6`, with the curvature `c = 2 (s' - s)/(h0 + h)`. Half of the last term would make the change
//!   exact to third order; Beeman's takes twice as much, which makes his positions those of Verlet.
//!
//! A particle that is new has made no step, `h0 = 0`: it begins as if its acceleration had been the same before, and so does one after a step of no
//! length.

use super::Integrator;

/// What a particle keeps of its last steps, along one axis. All zero for a particle that is new.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Past {
    /// Length of the last step, s; zero if there was none.
    pub step: f32,
    /// Of Verlet the way in the last step over its length, m/s; of others the acceleration at its start, m/s2.
    pub first: f32,
    /// Length of the step before, s; zero if there was none.
    pub step_before: f32,
    /// The acceleration at the start of that, m/s2.
    pub second: f32,
}

impl Past {
    /// Most that the ratio of a step to the one before counts as: a slope is not carried further than ten times the way that it was taken over.
    const MOST_RATIO: f32 = 10.0;

    /// Length over that of the step before; zero if there was none.
    fn ratio(length: f32, before: f32) -> f32 {
        if before > 0.0 { (length / before).min(Self::MOST_RATIO) } else { 0.0 }
    }

    /// Slope of the acceleration times the square of the step to come, m/s.
    fn slope(&self, a: f32, h: f32) -> f32 {
        Self::ratio(h, self.step) * (a - self.first) * h
    }

    /// What Beeman's velocity changes by in the last step.
    fn beeman(&self, a: f32) -> f32 {
        let Self { step, first, step_before, second } = *self;
        let turn = a - first - Self::ratio(step, step_before) * (first - second);
        // As if there had been one as long, without a change of the acceleration.
        let share = if step_before > 0.0 { step / (step + step_before) } else { 0.5 };
        (0.5 * (a + first) - turn * share / 3.0) * step
    }

    /// What a particle with a velocity changed to at a time that was expected to be `h` on, from the start of a step of that length.
    fn expected(&self, a: f32, h: f32) -> f32 {
        a * h + 0.5 * self.slope(a, h)
    }
}

impl Integrator {
    /// Most numbers that one of them keeps of a particle.
    pub const MOST_WORDS: usize = 8;

    /// Numbers that solvers keep of each particle, in this order: [`Past::step`], `first` of the three axes, `step_before`, `second` of the three axes.
    pub const fn words(self) -> usize {
        match self {
            Self::ForwardEuler | Self::SemiImplicitEuler | Self::Clavet => 0,
            Self::ModifiedVelocityVerlet | Self::Leapfrog => 1,
            Self::Verlet | Self::VelocityVerlet => 4,
            Self::Beeman | Self::VelocityCorrectedBeeman | Self::PositionCorrectedBeeman => 8,
        }
    }

    /// The largest stable `c h` of a particle in a solver that a drag `-c v` slows down and nothing else; viscous limits of substeps go with it.
    ///
    /// By the spectral radius of `z^3 - z^2 + c h (2 z^2 + 5 z - 1)/6` for Beeman's, and of that plus `c h (3 z - 1)(z - 1)/2` for the velocity-corrected one.
    pub const fn drag_limit(self) -> f32 {
        match self {
            Self::Beeman => 1.291,
            Self::VelocityCorrectedBeeman | Self::PositionCorrectedBeeman => 0.6,
            Self::ForwardEuler
            | Self::SemiImplicitEuler
            | Self::Verlet
            | Self::VelocityVerlet
            | Self::ModifiedVelocityVerlet
            | Self::Leapfrog
            | Self::Clavet => 2.0,
        }
    }

    /// The velocity that a particle has after a substep of `h` seconds, m/s, from the velocity `v` and acceleration `a` that it had before.
    #[inline(always)]
    pub fn velocity(self, v: f32, a: f32, past: Past, h: f32) -> f32 {
        match self {
            Self::ForwardEuler | Self::SemiImplicitEuler | Self::Clavet => v + a * h,
            Self::ModifiedVelocityVerlet | Self::Leapfrog => v + 0.5 * (past.step + h) * a,
            Self::Verlet => (if past.step > 0.0 { past.first } else { v }) + 0.5 * past.step * a,
            Self::VelocityVerlet => v + 0.5 * past.step * (past.first + a),
            Self::Beeman | Self::PositionCorrectedBeeman => v + past.beeman(a),
            Self::VelocityCorrectedBeeman => {
                // The velocity before was expected for now; what it was expected from is known again.
                let before = Past { step: past.step_before, first: past.second, ..Past::default() };
                v - before.expected(past.first, past.step) + past.beeman(a) + past.expected(a, h)
            }
        }
    }

    /// What a particle moves with in the substep, m/s; `v` is its velocity after it.
    #[inline(always)]
    pub fn motion(self, v: f32, a: f32, past: Past, h: f32) -> f32 {
        match self {
            Self::ForwardEuler => v - a * h,
            Self::SemiImplicitEuler | Self::ModifiedVelocityVerlet | Self::Leapfrog => v,
            Self::Clavet => v + a * h,
            Self::Verlet | Self::VelocityVerlet => v + 0.5 * h * a,
            Self::Beeman | Self::PositionCorrectedBeeman => v + 0.5 * h * a + past.slope(a, h) / 6.0,
            Self::VelocityCorrectedBeeman => v - 0.5 * h * a - past.slope(a, h) / 3.0,
        }
    }

    /// What the particle keeps of the substep; `motion` is what it moved with.
    #[inline(always)]
    pub fn keep(self, a: f32, motion: f32, past: Past, h: f32) -> Past {
        let first = if self == Self::Verlet { motion } else { a };
        Past { step: h, first, step_before: past.step, second: past.first }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solvers have these.
    const STEPPED: [Integrator; 8] = [
        Integrator::SemiImplicitEuler,
        Integrator::Verlet,
        Integrator::VelocityVerlet,
        Integrator::ModifiedVelocityVerlet,
        Integrator::Leapfrog,
        Integrator::Clavet,
        Integrator::Beeman,
        Integrator::VelocityCorrectedBeeman,
    ];

    /// A step as a solver makes it.
    fn advance(integrator: Integrator, f: impl Fn(f32, f32) -> f32, state: &mut (f32, f32, Past), h: f32) {
        let (x, v, past) = *state;
        let a = f(x, v);
        let velocity = integrator.velocity(v, a, past, h);
        let motion = integrator.motion(velocity, a, past, h);
        *state = (x + motion * h, velocity, integrator.keep(a, motion, past, h));
    }

    /// A damped oscillator over some hundred equal steps: the positions of a solver are those of the literature's step, for Clavet the predicted ones.
    #[test]
    fn equal_steps_are_those_of_the_literature() {
        let (omega, damping, h) = (3.0, 0.05, 0.07);
        let f = |x: f64, v: f64| -omega * omega * x - 2.0 * damping * omega * v;
        for integrator in STEPPED {
            let mut state = integrator.start(f, 1.0, 0.4, h);
            let mut solver = (1.0, 0.4, Past::default());
            if integrator == Integrator::Clavet {
                solver.0 += 0.4 * h as f32;
            }
            let mut worst = 0.0f64;
            for _ in 0..300 {
                state = integrator.step(f, state, h);
                advance(integrator, |x, v| f(f64::from(x), f64::from(v)) as f32, &mut solver, h as f32);
                let expected = if integrator == Integrator::Clavet { state.x + state.v * h } else { state.x };
                worst = worst.max((f64::from(solver.0) - expected).abs());
            }
            // Rounding in single precision over 300 steps.
            assert!(worst < 2e-5, "{}: {worst}", integrator.name());
        }
    }

    /// Largest error of the position under `x'' = -cos t` in steps that are long and short by turns, from rest at 1: `x = cos t`.
    fn forced(integrator: Integrator, steps: u32, ratio: f64) -> f64 {
        let (mut t, mut state, mut worst) = (0.0f64, (1.0, 0.0, Past::default()), 0.0f64);
        let pair = 4.0 / f64::from(steps);
        for n in 0..2 * steps {
            let share = if n % 2 == 0 { 1.0 } else { ratio };
            let h = pair * share / (1.0 + ratio);
            advance(integrator, |_, _| -t.cos() as f32, &mut state, h as f32);
            t += h;
            worst = worst.max((f64::from(state.0) - t.cos()).abs());
        }
        worst
    }

    /// The order stays when steps differ: positions of all but the first-order two are of second order and Beeman's, whose slope sees more of
    /// a force that depends on time alone, of as much.
    #[test]
    fn steps_of_different_length_keep_the_order() {
        for integrator in STEPPED {
            let order = |ratio: f64| (forced(integrator, 20, ratio) / forced(integrator, 40, ratio)).log2();
            let expected = match integrator {
                Integrator::SemiImplicitEuler | Integrator::Clavet => 0.9..1.1,
                _ => 1.9..3.2,
            };
            for ratio in [1.0, 0.4] {
                assert!(expected.contains(&order(ratio)), "{}, ratio {ratio}: {}", integrator.name(), order(ratio));
            }
        }
    }

    /// A drag stops a particle in steps a little shorter than the limit; in longer ones its velocity grows.
    #[test]
    fn drags_are_borne_up_to_their_limits() {
        for integrator in STEPPED {
            let left = |share: f32| {
                let drag = share * integrator.drag_limit();
                let mut state = (0.0, 1.0, Past::default());
                for _ in 0..3000 {
                    advance(integrator, |_, v: f32| -drag * v.clamp(-1e6, 1e6), &mut state, 1.0);
                }
                state.1.abs()
            };
            assert!(left(0.98) < 1e-3 && left(1.02) > 1e3, "{}: {} {}", integrator.name(), left(0.98), left(1.02));
        }
    }

    /// After a step of no length, and for a particle that is new, a constant acceleration is followed exactly.
    #[test]
    fn free_fall_is_exact_whatever_the_steps() {
        for integrator in STEPPED {
            if matches!(integrator, Integrator::SemiImplicitEuler | Integrator::Clavet) {
                continue;
            }
            let (mut t, mut state) = (0.0, (0.0, 2.0, Past::default()));
            for h in [0.1, 0.03, 0.0, 0.2, 0.2, 1e-6, 0.1] {
                advance(integrator, |_, _| -10.0, &mut state, h);
                t += h;
            }
            let expected = 2.0 * t - 5.0 * t * t;
            assert!(
                (state.0 - expected).abs() < 2e-6,
                "{}: {} after {t} s, not {expected}",
                integrator.name(),
                state.0
            );
        }
    }
}
