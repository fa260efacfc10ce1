//! From components to a plan and a stream of ticks, in the app's fixed schedule.
//!
//! `changes` notices that components were touched, `gather` reads them, `walls` makes shapes of meshes, `recipe` is what they ask for, `planning` turns
//! it into plans, `orders` into orders, `movers` are walls that move, `ticking` sends the ticks, `collecting` takes the results, `leaks` counts.

mod attempt;
mod backend;
mod changes;
pub(crate) mod collecting;
mod gather;
mod leaks;
mod movers;
mod orders;
mod planning;
mod pours;
mod problems;
mod reading;
mod recipe;
mod room;
pub mod sets;
pub(crate) mod state;
pub(crate) mod ticking;
mod walls;

use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;

use crate::components::body::{FluidBody, FluidBodySampling};
use crate::components::boundary::FluidBoundary;
use crate::components::container::FluidContainer;
use crate::components::domain::FluidDomain;
use crate::components::emitter::FluidEmitter;
use crate::components::material::Fluid;
use crate::components::membership::{FluidDomainMembers, FluidInDomain};
use crate::components::problem::FluidProblem;
use crate::components::readback::FluidReadback;
use crate::components::stats::FluidStats;
use crate::components::volume::FluidVolume;
use sets::FreshetSystems;

/// Simulates the fluids: everything but rapier and drawing.
pub struct FluidSimulationPlugin;

impl Plugin for FluidSimulationPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<FluidDomain>()
            .register_type::<Fluid>()
            .register_type::<FluidVolume>()
            .register_type::<FluidEmitter>()
            .register_type::<FluidContainer>()
            .register_type::<FluidBoundary>()
            .register_type::<FluidBody>()
            .register_type::<FluidBodySampling>()
            .register_type::<FluidInDomain>()
            .register_type::<FluidDomainMembers>()
            .register_type::<FluidStats>()
            .register_type::<FluidReadback>()
            .add_message::<FluidProblem>()
            .init_resource::<state::DefaultGravity>()
            .init_resource::<problems::Problems>()
            .init_resource::<walls::WallShapes>()
            .register_required_components::<FluidDomain, state::DomainState>()
            .add_observer(pours::remove_particles)
            .add_observer(pours::forget_domain)
            .configure_sets(
                FixedUpdate,
                (
                    FreshetSystems::Plan,
                    FreshetSystems::Collect,
                    FreshetSystems::Prepare,
                    FreshetSystems::Step,
                    FreshetSystems::Apply,
                )
                    .chain()
                    // Rapier must know of bodies that were spawned or moved, and must not have stepped them yet.
                    .after(PhysicsSet::SyncBackend)
                    .before(PhysicsSet::StepSimulation),
            )
            .configure_sets(
                FixedUpdate,
                // Rapier has stepped the bodies, and not told Bevy yet, so that a correction is seen in the same tick.
                FreshetSystems::Complete.after(PhysicsSet::StepSimulation).before(PhysicsSet::Writeback),
            )
            .add_systems(
                FixedUpdate,
                (
                    (walls::notice_assets, planning::plan_domains.run_if(changes::is_anything_touched))
                        .chain()
                        .in_set(FreshetSystems::Plan),
                    collecting::collect_known.in_set(FreshetSystems::Collect),
                    (ticking::send_ticks, leaks::count_leaks, reading::read_fields)
                        .chain()
                        .in_set(FreshetSystems::Step),
                ),
            );
        // After whatever an app moves in a frame.
        app.add_systems(Last, ticking::place_walls.run_if(ticking::time_stands_still));
        app.add_plugins(crate::gpu::GpuDriverPlugin);
    }
}
