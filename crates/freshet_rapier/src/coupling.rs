//! The exchange for all bodies of a plan.

use freshet_core::step::{BodyInput, StepReport};
use rapier3d::dynamics::{RigidBodyHandle, RigidBodySet};

use crate::body_coupling::BodyCoupling;
use crate::error::CouplingError;
use crate::world::RapierView;

/// Exchanges momentum between a fluid and rapier bodies, in the order of the plan's bodies.
#[derive(Clone, Debug, Default)]
pub struct Coupling {
    bodies: Vec<BodyCoupling>,
}

impl Coupling {
    /// Couples `bodies`, in the plan's order, from `first_tick` on.
    pub fn new(bodies: impl IntoIterator<Item = RigidBodyHandle>, first_tick: u64) -> Self {
        Self { bodies: bodies.into_iter().map(|handle| BodyCoupling::new(handle, first_tick)).collect() }
    }

    /// The exchange of each body.
    pub fn bodies(&self) -> &[BodyCoupling] {
        &self.bodies
    }

    /// The exchange of each body, to change its settings.
    pub fn bodies_mut(&mut self) -> &mut [BodyCoupling] {
        &mut self.bodies
    }

    /// The inputs of the next tick, for [`StepInput::bodies`](freshet_core::step::StepInput::bodies).
    ///
    /// # Errors
    /// See [`BodyCoupling::begin_tick`]; the coupling must then be made anew.
    pub fn begin_tick(&mut self, tick: u64, world: &RapierView<'_>) -> Result<Vec<BodyInput>, CouplingError> {
        self.bodies.iter_mut().map(|body| body.begin_tick(tick, world)).collect()
    }

    /// Takes the impulses of a finished tick; see [`BodyCoupling::receive`].
    ///
    /// # Errors
    /// Another number of bodies, or what `BodyCoupling::receive` refuses.
    pub fn receive(&mut self, report: &StepReport, bodies: &mut RigidBodySet) -> Result<(), CouplingError> {
        if report.bodies.len() != self.bodies.len() {
            return Err(CouplingError::WrongCount { given: report.bodies.len(), expected: self.bodies.len() });
        }
        let mut pairs = self.bodies.iter_mut().zip(&report.bodies);
        pairs.try_for_each(|(body, &impulse)| body.receive(report.tick, impulse, bodies))
    }

    /// Call it right before rapier's step; see [`BodyCoupling::apply_forecast`].
    ///
    /// # Errors
    /// See [`BodyCoupling::apply_forecast`].
    pub fn apply_forecast(&mut self, bodies: &mut RigidBodySet) -> Result<(), CouplingError> {
        self.bodies.iter_mut().try_for_each(|body| body.apply_forecast(bodies))
    }

    /// Call it right after rapier's step; see [`BodyCoupling::complete`].
    ///
    /// # Errors
    /// See [`BodyCoupling::complete`].
    pub fn complete(&mut self, bodies: &mut RigidBodySet) -> Result<(), CouplingError> {
        self.bodies.iter_mut().try_for_each(|body| body.complete(bodies))
    }
}
