//! The state of a fluid as plain data: save, load, send.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_finite, check_range};
use crate::integrator::Integrator;
use crate::plan::Parameters;
use crate::pressure_solver::PressureSolver;
use crate::step::{Impulse, StepInput};

/// The state a solver starts from and can return to.
///
/// Particles are in the order of their ids.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Number of the last tick made plus one, 0 to 2^63: what the next tick's number should be.
    pub tick: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Time asked for but not covered yet, s.
    pub carry: f32,
    /// Latest time at which particles were said to be where they were spawned
    /// ([`NewParticles::at`](crate::step::NewParticles::at)), s: emitters go on behind it. None if there was none.
    pub emitted: Option<f64>,
    /// The id the next particle gets.
    pub next_id: u32,
    /// Gravity, m/s2.
    pub gravity: Vec3,
    /// Ids.
    pub ids: Vec<u32>,
    /// Positions, m.
    pub positions: Vec<Vec3>,
    /// Velocities, m/s.
    pub velocities: Vec<Vec3>,
    /// Remaining lifetimes, s.
    pub remaining_lives: Vec<f32>,
    /// `p / rho^2` of the last substep, m5/(kg s2), from which an incompressible fluid goes on; empty for others, zero if there was no
    /// substep.
    pub pressures: Vec<f32>,
    /// `rho/rho0 - 1` that particles [carry](crate::density_form), no unit; empty where densities are summed: a plan that carries
    /// them goes on from such a state with the density at rest.
    pub excesses: Vec<f32>,
    /// Length of the last substep, s, for pressures, for densities that are carried and for a
    /// [position-based](crate::position_based) fluid, which is still to be moved apart; zero for none.
    pub last_substep: f32,
    /// Which integrator made it: with another one [`histories`](Self::histories) mean nothing.
    pub integrator: Integrator,
    /// What the integrator [keeps](Integrator::words) of each particle, one after the other; empty if nothing, zero for what is new.
    pub histories: Vec<f32>,
    /// For each body, the impulses of ticks its engine may not have heard of yet.
    pub exchanges: Vec<[Exchange; 4]>,
    /// Where the last tick left each body, in the plan's order; none, or beyond the end, for a body that is new.
    pub poses: Vec<Option<BodyPose>>,
}

/// Where a tick left a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyPose {
    /// Centre of mass, m.
    pub position: Vec3,
    /// Orientation.
    pub rotation: Quat,
    /// How far it has [swollen](crate::swelling), 0 to 1: wholly there.
    pub swollen: f32,
}

/// What passed between the fluid and a body in one tick, and what the body's engine forecast of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Exchange {
    /// Number of the tick plus one; zero for none.
    pub tick_plus_one: u64,
    /// The true impulse minus the forecast.
    pub error: Impulse,
}

/// Why a snapshot could not be read or used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The bytes do not begin as a snapshot does.
    #[error("not a Freshet snapshot: the file begins with {found:?} instead of {expected:?}")]
    NotASnapshot {
        /// The first bytes.
        found: Vec<u8>,
        /// What a snapshot begins with.
        expected: &'static [u8],
    },
    /// The bytes end early or hold something else.
    #[error("damaged snapshot: {0}")]
    Damaged(String),
    /// The bytes are not those that were saved.
    #[error("damaged snapshot: the checksum of its bytes is {found:08x} instead of {expected:08x}")]
    Checksum {
        /// CRC-32 of the bytes that are there.
        found: u32,
        /// CRC-32 of those that were saved.
        expected: u32,
    },
    /// The arrays have different lengths, or a value is not finite.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
}

/// First bytes of a saved snapshot; the last is the version of the format.
const MAGIC: &[u8] = b"FRESHET\x06";

/// What is known of bodies, for the bodies of another plan: `before` is what
/// [`Plan::bodies_of`](crate::plan::Plan::bodies_of) says.
pub fn carried_over<T: Copy + Default>(known: &[T], before: &[Option<usize>]) -> Vec<T> {
    before.iter().map(|index| index.and_then(|index| known.get(index).copied()).unwrap_or_default()).collect()
}

/// Checks that so many particles are no more than a plan allows; solvers ask before they take a snapshot or another plan.
pub fn check_room(particles: usize, max_particles: u32) -> Result<(), InvalidInput> {
    if particles > max_particles as usize {
        let allowed = format!("at most {max_particles}, the plan's max_particles");
        return Err(InvalidInput::new("ids", format_args!("{particles} particles"), allowed));
    }
    Ok(())
}

impl Snapshot {
    /// Whether it was taken before the first tick: what bodies [have inside](crate::plan::Plan::started_inside) is then still
    /// to be found out. For solvers.
    pub fn is_start(&self) -> bool {
        self.tick == 0
    }

    /// What an integrator keeps of each particle, if it made the snapshot; empty otherwise. For solvers.
    pub fn histories_for(&self, integrator: Integrator) -> &[f32] {
        if self.integrator == integrator { &self.histories } else { &[] }
    }

    /// Length of the last substep, s, for a plan: zero if another method left what is here, as far as the snapshot tells. One of a
    /// position-based fluid has neither pressures nor densities; one that has neither from another plan has a last substep of zero. For solvers.
    pub fn substep_for(&self, parameters: &Parameters) -> f32 {
        let count = self.ids.len();
        let is_known = match parameters.pressure_solver {
            PressureSolver::DivergenceFree(_) => self.pressures.len() == count,
            PressureSolver::PositionBased(_)
            | PressureSolver::PressureCorrected(_)
            | PressureSolver::PressurePoisson(_) => self.pressures.is_empty() && self.excesses.is_empty(),
            PressureSolver::WeaklyCompressible => {
                parameters.density.is_carried() && self.excesses.len() == count && self.pressures.is_empty()
            }
        };
        if is_known { self.last_substep } else { 0.0 }
    }

    /// The snapshot as bytes: eight bytes of magic and version, the CRC-32 of what follows (four bytes, the lowest first),
    /// then postcard.
    pub fn to_bytes(&self) -> Result<Vec<u8>, SnapshotError> {
        let body = postcard::to_stdvec(self).map_err(|error| SnapshotError::Damaged(error.to_string()))?;
        Ok([MAGIC, &crc32fast::hash(&body).to_le_bytes(), &body].concat())
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote, and checks it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let Some(sealed) = bytes.strip_prefix(MAGIC) else {
            let found = bytes[..bytes.len().min(MAGIC.len())].to_vec();
            return Err(SnapshotError::NotASnapshot { found, expected: MAGIC });
        };
        let Some((&checksum, body)) = sealed.split_first_chunk() else {
            return Err(SnapshotError::Damaged("it ends within its checksum".to_owned()));
        };
        let (found, expected) = (crc32fast::hash(body), u32::from_le_bytes(checksum));
        if found != expected {
            return Err(SnapshotError::Checksum { found, expected });
        }
        let (snapshot, rest): (Self, _) =
            postcard::take_from_bytes(body).map_err(|error| SnapshotError::Damaged(error.to_string()))?;
        if !rest.is_empty() {
            return Err(SnapshotError::Damaged(format!("{} bytes too many at its end", rest.len())));
        }
        snapshot.validate()?;
        Ok(snapshot)
    }

    /// Checks lengths and numbers.
    pub fn validate(&self) -> Result<(), SnapshotError> {
        if self.tick > StepInput::MAX_TICK + 1 {
            return Err(InvalidInput::new("tick", self.tick, "0 to 2^63").into());
        }
        if !(self.time.is_finite() && self.time >= 0.0) {
            return Err(InvalidInput::new("time", self.time, "0 s or more").into());
        }
        check_range("carry", self.carry, 0.0, StepInput::MAX_DURATION, "s")?;
        if let Some(emitted) = self.emitted
            && !emitted.is_finite()
        {
            return Err(InvalidInput::new("emitted", emitted, "a finite number of seconds, or none").into());
        }
        check_finite("gravity", self.gravity)?;
        let count = self.ids.len();
        for (field, len) in [
            ("positions", self.positions.len()),
            ("velocities", self.velocities.len()),
            ("remaining_lives", self.remaining_lives.len()),
        ] {
            if len != count {
                return Err(InvalidInput::new(field, len, format_args!("{count}, one for each id")).into());
            }
        }
        for (field, values) in [("positions", &self.positions), ("velocities", &self.velocities)] {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                return Err(InvalidInput::new(format_args!("{field}[{index}]"), values[index], "finite numbers").into());
            }
        }
        if !self.pressures.is_empty() && self.pressures.len() != count {
            let allowed = format!("none or {count}, one for each id");
            return Err(InvalidInput::new("pressures", self.pressures.len(), allowed).into());
        }
        if let Some(index) = self.pressures.iter().position(|pressure| !(pressure.is_finite() && *pressure >= 0.0)) {
            let field = format!("pressures[{index}]");
            return Err(InvalidInput::new(field, self.pressures[index], "0 or more").into());
        }
        if !self.excesses.is_empty() && self.excesses.len() != count {
            let allowed = format!("none or {count}, one for each id");
            return Err(InvalidInput::new("excesses", self.excesses.len(), allowed).into());
        }
        if let Some(index) = self.excesses.iter().position(|excess| !(excess.is_finite() && *excess > -1.0)) {
            let field = format!("excesses[{index}]");
            return Err(InvalidInput::new(field, self.excesses[index], "more than -1").into());
        }
        let words = count * self.integrator.words();
        if !self.histories.is_empty() && self.histories.len() != words {
            let each = self.integrator.words();
            let allowed = format!("none or {words}, {each} for each id as {} keeps", self.integrator.name());
            return Err(InvalidInput::new("histories", self.histories.len(), allowed).into());
        }
        if let Some(index) = self.histories.iter().position(|value| !value.is_finite()) {
            let field = format!("histories[{index}]");
            return Err(InvalidInput::new(field, self.histories[index], "finite numbers").into());
        }
        check_range("last_substep", self.last_substep, 0.0, StepInput::MAX_DURATION, "s")?;
        if let Some(index) = self.remaining_lives.iter().position(|life| life.is_nan()) {
            return Err(InvalidInput::new(format_args!("remaining_lives[{index}]"), f32::NAN, "a number").into());
        }
        for (index, pose) in self.poses.iter().enumerate() {
            let Some(BodyPose { position, rotation, swollen }) = pose else { continue };
            check_finite(&format!("poses[{index}].position"), *position)?;
            check_range(&format!("poses[{index}].swollen"), *swollen, 0.0, 1.0, "of its size")?;
            if !rotation.is_finite() || !rotation.is_normalized() {
                return Err(
                    InvalidInput::new(format_args!("poses[{index}].rotation"), rotation, "a unit quaternion").into()
                );
            }
        }
        for (index, exchange) in self.exchanges.iter().flatten().enumerate() {
            if !exchange.error.linear.is_finite() || !exchange.error.angular.is_finite() {
                let field = format!("exchanges[{}][{}].error", index / 4, index % 4);
                return Err(InvalidInput::new(field, format_args!("{:?}", exchange.error), "finite numbers").into());
            }
        }
        if let Some(index) = self.ids.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(InvalidInput::new(
                format_args!("ids[{}]", index + 1),
                self.ids[index + 1],
                format_args!("more than the one before, {}", self.ids[index]),
            )
            .into());
        }
        if let Some(index) = self.ids.iter().position(|&id| id >= self.next_id) {
            return Err(InvalidInput::new(
                format_args!("ids[{index}]"),
                self.ids[index],
                format_args!("less than next_id = {}", self.next_id),
            )
            .into());
        }
        Ok(())
    }
}
