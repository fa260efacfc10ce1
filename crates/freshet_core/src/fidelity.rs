//! Settings by naming an accuracy: what `freshet_lab pareto` found to be the cheapest way to it.
//!
//! Every [configuration](crate::configuration) was run on five scenes with exact or measured references (a dam break, a column at rest, a ball that is
//! drawn out, a viscous channel, a standing wave), at two resolutions. Its error is that of the scene it does worst on; its cost is wall seconds per simulated second, the geometric
//! mean of the five. Settings go with any spacing, so that what counts is the error at the worse of both resolutions, and what fails at one of them is not offered. [`MEASURED`] holds what
//! nothing else was both faster and better than, and what each did on a sixth scene that took no part in the choice.

mod measured;

pub use self::measured::{ACCURATE, BALANCED, FAST, MEASURED};

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::configuration::Configuration;
use crate::error::{InvalidInput, check_range};
use crate::plan::{Plan, SceneError};
use crate::scene::{FluidScene, Settings, Shape};

/// How accurate a fluid is to be: chooses all [`Settings`] that say how it is simulated.
///
/// ```
/// use freshet_core::prelude::*;
/// let mut scene = FluidScene {
///     volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
///     ..FluidScene::with_spacing(0.1)
/// };
/// scene.settings.fidelity = Some(FluidFidelity::Balanced);
/// println!("{}", Plan::new(&scene)?); // What was chosen and why is in its notes.
/// let error = FluidFidelity::within(1e-6).unwrap_err().to_string();
/// assert!(error.starts_with("fidelity: 0.000001 is not allowed; allowed: "), "{error}");
/// # Ok::<(), SceneError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FluidFidelity {
    /// The cheapest whose error is at most a tenth.
    Fast,
    /// Between both, if there is anything: the smallest product of cost and error.
    Balanced,
    /// The smallest error.
    Accurate,
    /// The cheapest whose error is at most this, a share: 0.05 for 5 %. See [`within`](Self::within).
    Within(f32),
}

/// A configuration that nothing measured was both faster and better than.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Name of the [`Configuration`].
    pub configuration: &'static str,
    /// Fewest particles across the fluid that it was measured with.
    pub coarsest: u32,
    /// Most of them.
    pub finest: u32,
    /// Error of the worst of the five scenes at the worse resolution, a share.
    pub error: f32,
    /// Wall seconds per simulated second on one thread at the finest resolution, the geometric mean of the five; of use for comparison only.
    pub cost: f32,
    /// Error of the sixth scene at the finest resolution, a share; infinite if it failed there.
    pub held_out: f32,
}

impl FluidFidelity {
    /// The presets.
    pub const PRESETS: [Self; 3] = [Self::Fast, Self::Balanced, Self::Accurate];

    /// The cheapest whose error is at most `error`, a share: 0.05 for 5 %.
    ///
    /// # Errors
    /// If no configuration reaches it.
    pub fn within(error: f32) -> Result<Self, InvalidInput> {
        let fidelity = Self::Within(error);
        fidelity.choice()?;
        Ok(fidelity)
    }

    /// Name, as in notes and tables.
    pub fn name(self) -> Cow<'static, str> {
        match self {
            Self::Fast => "fast".into(),
            Self::Balanced => "balanced".into(),
            Self::Accurate => "accurate".into(),
            Self::Within(error) => format!("within {} %", error * 100.0).into(),
        }
    }

    /// What was measured of what it chooses.
    ///
    /// # Errors
    /// If [no configuration reaches](Self::within) the error asked for.
    pub fn choice(self) -> Result<&'static Measured, InvalidInput> {
        let most = match self {
            Self::Fast => return Ok(&FAST),
            Self::Balanced => return Ok(&BALANCED),
            Self::Accurate => return Ok(&ACCURATE),
            Self::Within(most) => most,
        };
        check_range("fidelity", most, ACCURATE.error, 1.0, "(a share; the least is what was measured)")?;
        let reached = MEASURED.iter().filter(|known| known.error <= most);
        Ok(reached.min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or(&ACCURATE))
    }

    /// What it chooses, by name.
    ///
    /// # Errors
    /// As [`choice`](Self::choice).
    pub fn configuration(self) -> Result<&'static Configuration, InvalidInput> {
        Configuration::named(self.choice()?.configuration)
    }
}

impl Settings {
    /// Refuses settings beside a fidelity that would be its to choose.
    pub(crate) fn check_fidelity(&self) -> Result<(), InvalidInput> {
        let Some(fidelity) = self.fidelity else { return Ok(()) };
        fidelity.choice()?;
        if *self != self.without_method() {
            let allowed = "none, with settings that are not the default beside it: it chooses all but expected_speed, viscosity_model, relaxation, \
                           max_substeps, budget_milliseconds, max_particles and bounds";
            return Err(InvalidInput::new("fidelity", fidelity.name(), allowed));
        }
        Ok(())
    }

    /// The defaults with what is no matter of method.
    fn without_method(&self) -> Self {
        Self {
            fidelity: self.fidelity,
            expected_speed: self.expected_speed,
            viscosity_model: self.viscosity_model,
            relaxation: self.relaxation,
            max_substeps: self.max_substeps,
            budget_milliseconds: self.budget_milliseconds,
            max_particles: self.max_particles,
            bounds: self.bounds,
            ..Self::default()
        }
    }
}

impl FluidScene {
    /// The scene as its [`Settings::fidelity`] has it sampled, speeds of sound left open; itself without one.
    pub(crate) fn as_sampled(&self) -> Result<Cow<'_, Self>, InvalidInput> {
        let Some(fidelity) = self.settings.fidelity else { return Ok(Cow::Borrowed(self)) };
        Ok(Cow::Owned(fidelity.configuration()?.at_speed(&self.plain(), 1.0)))
    }

    /// The plan that its fidelity chooses, with a note on it; none without one.
    pub(crate) fn plan_of_fidelity(&self) -> Result<Option<Plan>, SceneError> {
        let Some(fidelity) = self.settings.fidelity else { return Ok(None) };
        let (choice, configuration) = (fidelity.choice()?, fidelity.configuration()?);
        let mut plan = Plan::new(&configuration.on(&self.plain())?)?;
        let changes = configuration.changes()?;
        let changes = if changes.is_empty() { "all defaults".to_owned() } else { changes.join(", ") };
        let Measured { coarsest, finest, error, held_out, .. } = choice;
        plan.notes.insert(
            0,
            format!(
                "fidelity {}: configuration {} ({changes}); nothing faster had an error as small: {:.1} % on the worst of five scenes, with \
                 {coarsest} to {finest} particles across the fluid, {:.1} % on a sixth",
                fidelity.name(),
                configuration.name,
                100.0 * error,
                100.0 * held_out
            ),
        );
        let here = self.volumes.iter().map(|volume| narrowest(volume.shape)).fold(f32::INFINITY, f32::min);
        let here = here / plan.parameters.spacing;
        if here < *coarsest as f32 * 0.99 {
            plan.notes.insert(
                1,
                format!(
                    "coarser than that was measured: {here:.1} particles across the narrowest volume, not {coarsest}"
                ),
            );
        }
        Ok(Some(plan))
    }

    fn plain(&self) -> Self {
        let mut scene = self.clone();
        scene.settings.fidelity = None;
        scene
    }
}

/// m.
fn narrowest(shape: Shape) -> f32 {
    match shape {
        Shape::Box { half_extents } => 2.0 * half_extents.min_element(),
        Shape::Sphere { radius } => 2.0 * radius,
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::pressure_force::PressureForce;
    use crate::scene::Volume;

    fn scene(fidelity: FluidFidelity) -> FluidScene {
        let mut scene = FluidScene {
            volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::ZERO)],
            ..FluidScene::with_spacing(0.125)
        };
        scene.settings.fidelity = Some(fidelity);
        scene
    }

    #[test]
    fn the_table_is_a_front_and_the_presets_are_on_it() {
        assert!(MEASURED.is_sorted_by(|a, b| a.cost < b.cost && a.error > b.error), "{MEASURED:?}");
        let presets = [FAST, BALANCED, ACCURATE];
        assert!(presets.iter().all(|preset| MEASURED.contains(preset)), "{presets:?}");
        assert!(presets.is_sorted_by(|a, b| a.cost <= b.cost), "{presets:?}");
        assert_eq!(MEASURED.last(), Some(&ACCURATE));
    }

    #[test]
    fn an_error_asked_for_gets_the_cheapest_that_keeps_it() -> Result<(), InvalidInput> {
        for (index, row) in MEASURED.iter().enumerate() {
            assert_eq!(FluidFidelity::within(row.error)?.choice()?, row);
            let finer = FluidFidelity::within(row.error * 0.999);
            match MEASURED.get(index + 1) {
                Some(next) => assert_eq!(finer?.choice()?, next),
                None => assert!(finer.is_err(), "nothing is finer than {row:?}"),
            }
        }
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 1.5] {
            let error = FluidFidelity::within(bad).map_err(|error| error.to_string());
            assert!(error.as_ref().is_err_and(|text| text.contains(" to 1 ")), "{error:?}");
        }
        Ok(())
    }

    #[test]
    fn plans_are_those_of_the_configuration_and_say_so() -> Result<(), SceneError> {
        for fidelity in FluidFidelity::PRESETS {
            let plan = Plan::new(&scene(fidelity))?;
            let by_hand = Plan::new(&fidelity.configuration()?.on(&scene(fidelity).plain())?)?;
            assert_eq!(plan.parameters, by_hand.parameters);
            assert_eq!(plan.stages, by_hand.stages);
            let note = format!("fidelity {}: configuration {} (", fidelity.name(), fidelity.choice()?.configuration);
            assert!(plan.to_string().contains(&note), "{plan}");
            assert!(plan.notes[1].starts_with("coarser than that was measured: 8.0 "), "{:?}", plan.notes);
            let layer = scene(fidelity).wall_layer()?;
            assert_eq!((layer.gamma, layer.depth), (plan.parameters.boundary_gamma, plan.parameters.boundary_depth));
        }
        Ok(())
    }

    #[test]
    fn what_it_chooses_cannot_be_set_beside_it() -> Result<(), SceneError> {
        let mut scene = scene(FluidFidelity::Fast);
        scene.settings.expected_speed = Some(3.0);
        scene.settings.max_substeps = 10;
        assert_eq!(Plan::new(&scene)?.parameters.expected_speed, 3.0);
        scene.settings.pressure_force = PressureForce::Mueller;
        let error = Plan::new(&scene).map_err(|error| error.to_string());
        assert!(
            error.as_ref().is_err_and(|text| text.starts_with("settings.fidelity: fast is not allowed; allowed: none")),
            "{error:?}"
        );
        Ok(())
    }

    #[test]
    fn scene_files_have_it_and_their_mistakes_have_a_line() -> Result<(), SceneError> {
        let text = |fidelity: &str| {
            format!("(\n  resolution: Spacing(0.1),\n  settings: (\n    fidelity: {fidelity},\n  ),\n)")
        };
        assert_eq!(FluidScene::from_ron(&text("Balanced"))?.settings.fidelity, Some(FluidFidelity::Balanced));
        let within = FluidScene::from_ron(&text("Within(0.5)"))?;
        assert_eq!(FluidScene::from_ron(&within.to_ron()?)?, within);
        for (bad, says) in [("Within(0)", "line 4: settings.fidelity: 0 is not allowed"), ("Best", "line 4")] {
            let error = FluidScene::from_ron(&text(bad)).map_err(|error| error.to_string());
            assert!(error.as_ref().is_err_and(|text| text.starts_with(says)), "{error:?}");
        }
        Ok(())
    }
}
