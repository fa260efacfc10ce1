//! What is run: the tank at a ladder of sizes, and the scenes of two theses.

use clap::ValueEnum;
use freshet_core::scene::FluidScene;

use crate::reference::published_time::PublishedTime;
use crate::reference::{krog_2010, pirovano_2011};
use crate::scenes::{krog, pirovano, tank};

/// Value of `--scene`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum BenchScene {
    /// The benchmark tank: a cubic metre of water in a corner of 2.0 x 1.5 x 1.0 m.
    Tank,
    /// Pirovano 2011: a cube without gravity or walls.
    Pirovano,
    /// Krog 2010: a cube of soft fluid falls into a shallow pool.
    Krog,
}

/// Size at which the aims are stated.
pub const AIM_PARTICLES: u32 = 64_000;
/// Up to this size a run is as long as at any smaller one.
const LONG_UP_TO: u32 = 131_072;

impl BenchScene {
    /// Every scene, in the order of the tables.
    pub const ALL: [Self; 3] = [Self::Tank, Self::Pirovano, Self::Krog];

    /// Name, as in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tank => "tank",
            Self::Pirovano => "pirovano",
            Self::Krog => "krog",
        }
    }

    /// Head line of its chart.
    pub fn title(self) -> &'static str {
        match self {
            Self::Tank => "tank, six walls, first 0.1 s",
            Self::Pirovano => "Pirovano's cube, no walls",
            Self::Krog => "Krog's pool, support 1.74 d",
        }
    }

    /// Sizes that are run by default, ascending: powers of two from 4K to 512K, of the tank the cubes next to them.
    pub fn sizes(self) -> &'static [u32] {
        match self {
            Self::Tank => &[4_096, 8_000, 15_625, 32_768, AIM_PARTICLES, 125_000, 262_144, 512_000],
            Self::Pirovano => &[4_096, 32_768],
            Self::Krog => &[32_768, 65_536, 131_072, 262_144, 524_288],
        }
    }

    /// Sizes of the short form.
    pub fn quick_sizes(self) -> &'static [u32] {
        match self {
            Self::Tank => &[8_000],
            Self::Pirovano => &[4_096],
            Self::Krog => &[32_768],
        }
    }

    /// The scene with about so many particles.
    pub fn scene(self, particles: u32) -> FluidScene {
        match self {
            Self::Tank => tank::scene(particles),
            Self::Pirovano => pirovano::scene(particles),
            Self::Krog => krog::scene(particles),
        }
    }

    /// Length of a tick, s: 60 a second, as a game asks for them; of Pirovano's cube his step.
    pub fn tick(self) -> f64 {
        match self {
            Self::Tank | Self::Krog => 1.0 / 60.0,
            Self::Pirovano => pirovano::STEP,
        }
    }

    /// Time to simulate, s, whole ticks: half a second where the aims are stated, otherwise so long that the flow has begun,
    /// and for large sizes less, as a step and the number of steps grow.
    pub fn seconds(self, particles: u32, quick: bool) -> f64 {
        let long = match self {
            Self::Tank if particles == AIM_PARTICLES && !quick => 0.5,
            Self::Tank | Self::Pirovano => 0.1,
            // The cube meets the pool at 0.13 s.
            Self::Krog => 0.25,
        };
        let ticks = long / self.tick() * (f64::from(LONG_UP_TO) / f64::from(particles)).min(1.0);
        ticks.round().max(1.0) * self.tick()
    }

    /// About how long a substep is, s: for estimates before anything was measured.
    pub fn expected_substep(self, particles: u32) -> f64 {
        let coarser = (65_536.0 / f64::from(particles)).cbrt();
        match self {
            Self::Tank => 1.4e-4 * coarser,
            Self::Pirovano => pirovano::STEP,
            Self::Krog => 9e-4 * coarser,
        }
    }

    /// What others published.
    pub fn published(self) -> &'static [PublishedTime] {
        match self {
            Self::Tank => &[],
            Self::Pirovano => &pirovano_2011::TIMES,
            Self::Krog => &krog_2010::TIMES,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_times_are_of_sizes_that_are_run() {
        for scene in BenchScene::ALL {
            for time in scene.published() {
                assert!(scene.sizes().contains(&time.particles), "{scene:?} {time:?}");
                assert!((10.0..100_000.0).contains(&time.nanoseconds()), "{time:?}");
                assert!(!time.hardware.is_empty() && !time.source.is_empty());
            }
        }
        assert!(BenchScene::Tank.published().is_empty());
    }

    #[test]
    fn large_sizes_are_run_for_less_time() {
        let seconds = |particles| BenchScene::Tank.seconds(particles, false);
        assert!((seconds(64_000) - 0.5).abs() < 1e-9);
        for size in [4_096, 8_000, 32_768, 125_000] {
            assert!((seconds(size) - 0.1).abs() < 1e-9, "{size}");
        }
        assert!((seconds(262_144) - 0.05).abs() < 1e-9);
        assert!((BenchScene::Tank.seconds(64_000, true) - 0.1).abs() < 1e-9);
        assert!((BenchScene::Pirovano.seconds(4_096, false) - 0.1).abs() < 1e-9);
    }
}
