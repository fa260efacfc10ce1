//! Configurations: every method there is as a named change of a scene, so that all can be charted, compared and chosen by name.
//!
//! `freshet_lab pareto` runs all of [`CONFIGURATIONS`] and charts what each costs and how far it is off; `docs/methods.md` is the same list as
//! text; [`FluidFidelity`](crate::fidelity::FluidFidelity) chooses among them.

mod registry;

pub use self::registry::CONFIGURATIONS;

use crate::error::InvalidInput;
use crate::plan::{Plan, SceneError};
use crate::scene::{FluidScene, Settings};
use crate::viscosity::ViscosityModel;

/// What a configuration is a variation of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Pressure from density.
    EquationOfState,
    /// How fast its sound is.
    SpeedOfSound,
    /// How pressures become forces.
    PressureForce,
    /// Pressure as what keeps the fluid from being compressed.
    PressureSolver,
    /// How densities are found.
    Density,
    /// How walls act on the fluid.
    Walls,
    /// Smoothing kernel.
    Kernel,
    /// How many neighbours a particle has.
    Neighbours,
    /// How accelerations become velocities and positions.
    Integrator,
    /// How long a substep is.
    Step,
    /// What takes energy.
    Viscosity,
    /// What keeps particles apart, or together, beside pressure.
    Cohesion,
}

impl Family {
    /// All, in the order of charts and tables.
    pub const ALL: [Self; 12] = [
        Self::EquationOfState,
        Self::SpeedOfSound,
        Self::PressureForce,
        Self::PressureSolver,
        Self::Density,
        Self::Walls,
        Self::Kernel,
        Self::Neighbours,
        Self::Integrator,
        Self::Step,
        Self::Viscosity,
        Self::Cohesion,
    ];

    /// Name, as in charts and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::EquationOfState => "equation of state",
            Self::SpeedOfSound => "speed of sound",
            Self::PressureForce => "pressure force",
            Self::PressureSolver => "pressure solver",
            Self::Density => "density",
            Self::Walls => "walls",
            Self::Kernel => "kernel",
            Self::Neighbours => "neighbours",
            Self::Integrator => "integrator",
            Self::Step => "step",
            Self::Viscosity => "viscosity",
            Self::Cohesion => "cohesion",
        }
    }
}

/// A way to simulate any scene.
#[derive(Clone, Copy, Debug)]
pub struct Configuration {
    /// Name, as in charts and on the command line: lower-case words joined by dashes.
    pub name: &'static str,
    /// What it varies.
    pub family: Family,
    /// What it is for.
    pub purpose: &'static str,
    /// Where it fails, or what it lacks.
    pub weakness: &'static str,
    /// Changes a scene of [`Settings::default`], given the largest speed that is expected in it, m/s.
    change: fn(&mut FluidScene, f32),
}

/// By name: no two have the same.
impl PartialEq for Configuration {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Configuration {
    /// The configuration of a name.
    ///
    /// # Errors
    /// If none has it.
    pub fn named(name: &str) -> Result<&'static Self, InvalidInput> {
        CONFIGURATIONS.iter().find(|known| known.name == name).ok_or_else(|| {
            let names: Vec<&str> = CONFIGURATIONS.iter().map(|known| known.name).collect();
            InvalidInput::new("configuration", name, names.join(", "))
        })
    }

    /// A scene simulated so. What its settings say of other things stays: they are changed, not replaced.
    ///
    /// # Errors
    /// Those of [`Plan::new`] for the scene as it is, where the configuration depends on how fast it is expected to be.
    pub fn on(&self, scene: &FluidScene) -> Result<FluidScene, SceneError> {
        let speed = match scene.settings.expected_speed {
            Some(speed) => speed,
            None if self.depends_on_speed() => Plan::new(scene)?.parameters.expected_speed,
            None => 1.0,
        };
        Ok(self.at_speed(scene, speed))
    }

    /// The same for a scene whose largest speed is known, m/s. What walls and bodies are sampled by does not depend on it.
    pub(crate) fn at_speed(&self, scene: &FluidScene, speed: f32) -> FluidScene {
        let mut scene = scene.clone();
        (self.change)(&mut scene, speed);
        scene
    }

    fn depends_on_speed(&self) -> bool {
        let plain = plain();
        self.at_speed(&plain, 1.0) != self.at_speed(&plain, 2.0)
    }

    /// What it changes, as in a scene file, with speeds over the largest that is expected; empty where it is all defaults.
    ///
    /// # Errors
    /// If a value of it cannot be written.
    pub fn changes(&self) -> Result<Vec<String>, InvalidInput> {
        let plain = plain();
        let (before, after) = (fields(&plain.settings)?, fields(&self.at_speed(&plain, 1.0).settings)?);
        Ok(after.into_iter().filter(|line| !before.contains(line)).collect())
    }
}

/// A scene in which everything that a configuration may change is there to be changed.
fn plain() -> FluidScene {
    let mut scene = FluidScene::with_spacing(1.0);
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene
}

/// Each field of settings in a line.
fn fields(settings: &Settings) -> Result<Vec<String>, InvalidInput> {
    let config = ron::ser::PrettyConfig::new().depth_limit(1);
    let text = ron::Options::default()
        .to_string_pretty(settings, config)
        .map_err(|error| InvalidInput::new("settings", error, "what RON can write"))?;
    Ok(text.lines().map(|line| line.trim().trim_end_matches(',').to_owned()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_each_says_what_it_is_for_and_where_it_fails() {
        for (index, configuration) in CONFIGURATIONS.iter().enumerate() {
            let Configuration { name, purpose, weakness, .. } = configuration;
            assert!(CONFIGURATIONS[..index].iter().all(|other| other.name != *name), "{name}");
            assert!(name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "-.".contains(c)), "{name}");
            assert!(purpose.len() > 15 && weakness.len() > 15, "{name}");
            assert!(!purpose.contains('|') && !weakness.contains('|'), "{name} would break its table");
        }
        for family in Family::ALL {
            assert!(CONFIGURATIONS.iter().any(|known| known.family == family), "{}", family.name());
        }
    }

    #[test]
    fn each_changes_something_of_its_own() -> Result<(), InvalidInput> {
        let all = CONFIGURATIONS.iter().map(Configuration::changes).collect::<Result<Vec<_>, _>>()?;
        for (index, changes) in all.iter().enumerate() {
            assert_eq!(changes.is_empty(), index == 0, "only the first is the default: {}", CONFIGURATIONS[index].name);
            assert!(!all[..index].contains(changes), "{} is another's double", CONFIGURATIONS[index].name);
        }
        let linear = Configuration::named("linear")?;
        assert_eq!(linear.changes()?, ["equation_of_state: Some(Linear(sound_speed: 10.0))"]);
        Ok(())
    }

    #[test]
    fn speeds_are_those_of_the_scene() -> Result<(), SceneError> {
        use crate::scene::{Boundary, Volume};
        use glam::Vec3;
        let scene = FluidScene {
            volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
            boundaries: vec![Boundary::open_box(Vec3::splat(2.0), Vec3::ONE)],
            ..FluidScene::with_spacing(0.1)
        };
        let plain = Plan::new(&scene)?.parameters;
        let linear = Configuration::named("linear")?;
        let found = Plan::new(&linear.on(&scene)?)?.parameters;
        assert!((found.sound_speed / plain.sound_speed - 1.0).abs() < 1e-5, "{} m/s", found.sound_speed);
        assert!(linear.depends_on_speed() && !Configuration::named("dfsph")?.depends_on_speed());
        let error = Configuration::named("tate").map(|known| known.name).unwrap_err().to_string();
        assert!(error.starts_with("configuration: tate is not allowed; allowed: tait, linear"), "{error}");
        Ok(())
    }
}
