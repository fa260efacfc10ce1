//! Each integrator as an exact step of an oscillator, `x'' = f(x, x')`, in double precision and with equal steps.

use super::Integrator;

/// Where an oscillator is, and what an integrator keeps of the past.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Position, m.
    pub x: f64,
    /// Velocity, m/s, at [`Integrator::velocity_time`].
    pub v: f64,
    /// Of Verlet the last position, m; of the velocity Verlets the acceleration, m/s2; of the Beemans the acceleration and the one before.
    pub kept: [f64; 2],
}

impl State {
    fn of(numbers: [f64; 4]) -> Self {
        let [x, v, first, second] = numbers;
        Self { x, v, kept: [first, second] }
    }

    fn numbers(self) -> [f64; 4] {
        [self.x, self.v, self.kept[0], self.kept[1]]
    }
}

impl Integrator {
    /// When a state's velocity is that of the oscillator, in steps after its position.
    pub fn velocity_time(self) -> f64 {
        match self {
            Self::Verlet => -1.0,
            Self::Clavet => -0.5,
            Self::Leapfrog => 0.5,
            Self::ForwardEuler
            | Self::SemiImplicitEuler
            | Self::VelocityVerlet
            | Self::ModifiedVelocityVerlet
            | Self::Beeman
            | Self::VelocityCorrectedBeeman
            | Self::PositionCorrectedBeeman => 0.0,
        }
    }

    /// Numbers of a state that its next step depends on, 2 to 4: position, velocity, and of [`State::kept`] the first ones.
    pub fn state_len(self) -> usize {
        match self {
            Self::ForwardEuler | Self::SemiImplicitEuler | Self::Leapfrog | Self::Clavet => 2,
            Self::Verlet | Self::VelocityVerlet | Self::ModifiedVelocityVerlet => 3,
            Self::Beeman | Self::VelocityCorrectedBeeman | Self::PositionCorrectedBeeman => 4,
        }
    }

    /// The state that steps of `h` seconds begin with at position `x` and velocity `v`: as if the acceleration had been the same before.
    pub fn start(self, f: impl Fn(f64, f64) -> f64, x: f64, v: f64, h: f64) -> State {
        let a = f(x, v);
        match self {
            Self::ForwardEuler | Self::SemiImplicitEuler | Self::Clavet => State { x, v, kept: [0.0; 2] },
            Self::Verlet => State { x, v, kept: [x - v * h + 0.5 * a * h * h, 0.0] },
            Self::VelocityVerlet | Self::ModifiedVelocityVerlet => State { x, v, kept: [a, 0.0] },
            Self::Leapfrog => State { x, v: v + 0.5 * a * h, kept: [0.0; 2] },
            Self::Beeman | Self::VelocityCorrectedBeeman | Self::PositionCorrectedBeeman => {
                State { x, v, kept: [a, a] }
            }
        }
    }

    /// The state `h` seconds later. Linear in the state if `f` is linear.
    pub fn step(self, f: impl Fn(f64, f64) -> f64, State { x, v, kept }: State, h: f64) -> State {
        match self {
            Self::ForwardEuler => State { x: x + v * h, v: v + f(x, v) * h, kept },
            Self::SemiImplicitEuler => {
                let v = v + f(x, v) * h;
                State { x: x + v * h, v, kept }
            }
            Self::Verlet => {
                let before = kept[0];
                let next = 2.0 * x - before + f(x, v) * h * h;
                State { x: next, v: (next - before) / (2.0 * h), kept: [x, 0.0] }
            }
            Self::VelocityVerlet => {
                let a = kept[0];
                let x = x + v * h + 0.5 * a * h * h;
                let next = f(x, v);
                State { x, v: v + 0.5 * (a + next) * h, kept: [next, 0.0] }
            }
            Self::ModifiedVelocityVerlet => {
                let u = v + 0.5 * kept[0] * h;
                let x = x + u * h;
                let next = f(x, u);
                State { x, v: u + 0.5 * next * h, kept: [next, 0.0] }
            }
            Self::Leapfrog => {
                let x = x + v * h;
                State { x, v: v + f(x, v) * h, kept }
            }
            Self::Clavet => {
                let predicted = x + v * h;
                let next = predicted + f(predicted, v) * h * h;
                State { x: next, v: (next - x) / h, kept }
            }
            Self::Beeman | Self::VelocityCorrectedBeeman | Self::PositionCorrectedBeeman => {
                let [a, before] = kept;
                let predicted = x + v * h + (4.0 * a - before) * h * h / 6.0;
                let seen = if self == Self::Beeman { v } else { v + 0.5 * (3.0 * a - before) * h };
                let next = f(predicted, seen);
                let kept = [next, a];
                if self == Self::PositionCorrectedBeeman {
                    let x = x + v * h + (next + 2.0 * a) * h * h / 6.0;
                    return State { x, v: v + (5.0 * next + 8.0 * a - before) * h / 12.0, kept };
                }
                State { x: predicted, v: v + (2.0 * next + 5.0 * a - before) * h / 6.0, kept }
            }
        }
    }

    /// The matrix of a step of `x'' = -x omega^2 - 2 damping omega x'` for `omega_h = omega h`: of its first [`state_len`](Self::state_len)
    /// rows and columns, the rest being zero; times in units of the step. Damping 0 is none, 1 is critical.
    pub fn one_step_matrix(self, omega_h: f64, damping: f64) -> [[f64; 4]; 4] {
        let f = |x: f64, v: f64| -omega_h * omega_h * x - 2.0 * damping * omega_h * v;
        let mut matrix = [[0.0; 4]; 4];
        for column in 0..self.state_len() {
            let mut unit = [0.0; 4];
            unit[column] = 1.0;
            let next = self.step(f, State::of(unit), 1.0).numbers();
            for row in 0..self.state_len() {
                matrix[row][column] = next[row];
            }
        }
        matrix
    }
}
