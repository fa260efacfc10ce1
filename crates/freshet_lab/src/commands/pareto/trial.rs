//! One run of one scene, watched: what it costs, how far it is off, or how it failed.

use std::time::{Duration, Instant};

use freshet_core::field::Field;
use freshet_core::plan::{Parameters, Plan};
use freshet_core::scene::FluidScene;
use freshet_core::solver::SolverError;
use freshet_core::step::StepReport;
use glam::Vec3;

use super::scenes::Job;
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::containment::escaped;

/// How a run failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Failure {
    /// The plan or the backend refused it: `docs/methods.md` says why.
    Refused,
    /// A number that is not finite.
    NotFinite,
    /// A particle lost, or beyond a wall.
    Lost,
    /// Kinetic energy and energy of height above 1.05 of the start.
    Energy,
    /// Mean compression above 5 % in a substep.
    Compression,
    /// Longer than the wall time allowed, or substeps too many for a tick.
    TooSlow,
    /// Nothing to measure, or more than wholly wrong: an error above 100 %.
    Wrong,
}

impl Failure {
    /// All, in the order of legends.
    pub const ALL: [Self; 7] =
        [Self::Refused, Self::NotFinite, Self::Lost, Self::Energy, Self::Compression, Self::TooSlow, Self::Wrong];

    /// Name, as in files, tables and charts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::NotFinite => "not finite",
            Self::Lost => "particle lost",
            Self::Energy => "energy",
            Self::Compression => "compression",
            Self::TooSlow => "too slow",
            Self::Wrong => "wholly wrong",
        }
    }
}

/// What is known of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The parts of its error, shares, or how it failed.
    pub parts: Result<Vec<f64>, Failure>,
    /// Wall seconds per simulated second, as far as it came; none if it did not start.
    pub cost: Option<f64>,
}

impl Trial {
    /// Its error, a share: the root of the sum of the squares of its parts. None if it failed.
    pub fn error(&self) -> Option<f64> {
        let parts = self.parts.as_ref().ok()?;
        Some(parts.iter().map(|part| part * part).sum::<f64>().sqrt())
    }

    /// How it failed.
    pub fn failure(&self) -> Option<Failure> {
        self.parts.as_ref().err().copied()
    }
}

/// What a run comes to, if nothing but the run itself fails.
pub type Outcome = Result<Trial, LabError>;

/// Why a run ended early.
#[derive(Debug)]
pub enum Stopped {
    /// A result in itself.
    Failed(Failure),
    /// None.
    Broken(LabError),
}

impl From<LabError> for Stopped {
    fn from(error: LabError) -> Self {
        match error {
            LabError::Scene(_) | LabError::Invalid(_) => Self::Failed(Failure::Refused),
            LabError::Solver(SolverError::Unsupported { .. } | SolverError::Invalid(_)) => {
                Self::Failed(Failure::Refused)
            }
            LabError::Measure { .. } => Self::Failed(Failure::Wrong),
            error => Self::Broken(error),
        }
    }
}

/// Plans a scene in the job's configuration and follows it; the wall time is that of the stepping alone.
pub fn watch(job: &Job, scene: &FluidScene, follow: impl FnOnce(&mut Watched) -> Result<Vec<f64>, Stopped>) -> Outcome {
    let mut cost = None;
    let parts = Watched::open(job, scene).and_then(|mut run| {
        let parts = follow(&mut run);
        let account = run.drive.account();
        cost = (account.simulated > 0.0).then(|| account.wall_per_simulated());
        parts
    });
    let parts = match parts {
        Ok(parts) if parts.iter().all(|part| part.is_finite() && *part <= 1.0) => Ok(parts),
        Ok(_) => Err(Failure::Wrong),
        Err(Stopped::Failed(failure)) => Err(failure),
        Err(Stopped::Broken(error)) => return Err(error),
    };
    Ok(Trial { parts, cost })
}

/// A run that ends as soon as it has failed.
pub struct Watched {
    drive: Drive,
    particles: usize,
    begin: Instant,
    cap: Duration,
    tank: Option<(Vec3, Vec3)>,
    /// What there may be, of a particle over its mass, m2/s2.
    energy: Option<f64>,
    /// Largest mean compression of any substep, a share.
    compression: f32,
}

impl Watched {
    fn open(job: &Job, scene: &FluidScene) -> Result<Self, Stopped> {
        let plan = Plan::new(&job.configuration.on(scene).map_err(LabError::from)?).map_err(LabError::from)?;
        let particles = plan.positions.len();
        let drive = Drive::open(job.backend, plan, Some(1), Vec::new())?;
        Ok(Self { drive, particles, begin: Instant::now(), cap: job.cap, tank: None, energy: None, compression: 0.0 })
    }

    /// Particles beyond a face of this box, but for its top, are lost.
    pub fn within(&mut self, low: Vec3, high: Vec3) {
        self.tank = Some((low, high));
    }

    /// From now on there may be a twentieth more energy, of motion and height, than there is.
    pub fn keeps_energy(&mut self) {
        self.energy = self.energy_now().ok().map(|energy| 1.05 * energy);
    }

    /// Simulates `duration` seconds and looks at what has become of it.
    pub fn tick(&mut self, duration: f64) -> Result<(), Stopped> {
        let report = self.drive.tick(duration)?;
        self.compression = self.compression.max(report.mean_compression);
        if let Some(failure) = failure(&report, self.particles) {
            return Err(Stopped::Failed(failure));
        }
        if self.begin.elapsed() > self.cap {
            return Err(Stopped::Failed(Failure::TooSlow));
        }
        if let Some((low, high)) = self.tank
            && escaped(&self.drive.positions()?, low, high) > 0
        {
            return Err(Stopped::Failed(Failure::Lost));
        }
        if let Some(most) = self.energy {
            let energy = self.energy_now()?;
            if !energy.is_finite() {
                return Err(Stopped::Failed(Failure::NotFinite));
            }
            if energy > most {
                return Err(Stopped::Failed(Failure::Energy));
            }
        }
        Ok(())
    }

    fn energy_now(&mut self) -> Result<f64, LabError> {
        let gravity = self.parameters().gravity.as_dvec3();
        let (positions, velocities) = (self.drive.positions()?, self.drive.vectors(Field::Velocity)?);
        let of = |(x, v): (&Vec3, &Vec3)| 0.5 * v.as_dvec3().length_squared() - gravity.dot(x.as_dvec3());
        Ok(positions.iter().zip(&velocities).map(of).sum())
    }

    /// The largest mean compression of any substep so far, a share.
    pub fn compression(&self) -> f64 {
        self.compression.into()
    }

    /// Numbers of the plan.
    pub fn parameters(&self) -> &Parameters {
        &self.drive.solver().plan().parameters
    }

    /// Time simulated, s.
    pub fn time(&self) -> f64 {
        self.drive.time()
    }

    /// As of a [`Drive`].
    pub fn positions(&mut self) -> Result<Vec<Vec3>, LabError> {
        self.drive.positions()
    }

    /// As of a [`Drive`].
    pub fn vectors(&mut self, field: Field) -> Result<Vec<Vec3>, LabError> {
        self.drive.vectors(field)
    }

    /// As of a [`Drive`].
    pub fn scalars(&mut self, field: Field) -> Result<Vec<f32>, LabError> {
        self.drive.scalars(field)
    }

    /// As of a [`Drive`].
    pub fn set_velocities(&mut self, velocity: impl Fn(Vec3) -> Vec3) -> Result<(), LabError> {
        self.drive.set_velocities(velocity)
    }
}

fn failure(report: &StepReport, particles: usize) -> Option<Failure> {
    if report.not_finite > 0 || !report.max_speed.is_finite() || !report.mean_compression.is_finite() {
        Some(Failure::NotFinite)
    } else if report.removed > 0 || report.particles as usize != particles {
        Some(Failure::Lost)
    } else if report.mean_compression > 0.05 {
        Some(Failure::Compression)
    } else if report.time_scale < 0.999 {
        Some(Failure::TooSlow)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_failure_is_told_from_the_others() {
        let report = StepReport { particles: 100, time_scale: 1.0, ..StepReport::default() };
        let of = |report: StepReport| failure(&report, 100);
        assert_eq!(of(report.clone()), None);
        assert_eq!(of(StepReport { not_finite: 1, removed: 1, ..report.clone() }), Some(Failure::NotFinite));
        assert_eq!(of(StepReport { removed: 1, ..report.clone() }), Some(Failure::Lost));
        assert_eq!(of(StepReport { mean_compression: 0.051, ..report.clone() }), Some(Failure::Compression));
        assert_eq!(of(StepReport { time_scale: 0.9, ..report }), Some(Failure::TooSlow));
    }

    #[test]
    fn errors_are_the_root_of_the_sum_of_squares() {
        let trial = Trial { parts: Ok(vec![0.03, 0.04]), cost: Some(1.0) };
        assert!(trial.error().is_some_and(|error| (error - 0.05).abs() < 1e-12));
        assert_eq!(Trial { parts: Err(Failure::Lost), cost: None }.error(), None);
    }
}
