//! Walls that move: bodies that nothing stops, whose pose and velocity come from their entity.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::leaks::{LeakWatch, WallPose};
use freshet_core::plan::Plan;
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_core::scene::{Body, Boundary, BoundaryShape, Friction};
use freshet_core::step::BodyInput;

use super::gather::rigid_frame;
use super::problems::Problem;
use super::recipe::is_moved;
use super::walls::stretch::{is_same_stretch, stretched_frame};

/// Speed over the expected speed above which a wall has been put elsewhere. By then sound, ten times the expected speed by default, lets what it
/// hits be pressed by a sixth, `(v / c)^2`: nothing is meant to move like that.
const PUT: f32 = 4.0;

/// A wall that moves, as it is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Mover {
    pub(crate) entity: Entity,
    pub(crate) component: &'static str,
    pub(crate) shape: BoundaryShape,
    pub(crate) friction: Friction,
    /// How its vertices were stretched; none if it may have no scale.
    pub(crate) stretch: Option<Mat3>,
    /// Where it is now, in the domain's frame.
    pub(crate) pose: Isometry3d,
    /// Where it stood until now, likewise, if it has been moved for the first time.
    pub(crate) from: Option<Isometry3d>,
    /// Whether it moves because it has been moved, not because it was asked to.
    pub(crate) is_auto: bool,
}

impl Mover {
    /// The same as a wall that stands where it is now.
    pub(crate) fn boundary(&self) -> Boundary {
        let (center, rotation) = (self.pose.translation.into(), self.pose.rotation);
        Boundary { rotation, friction: self.friction, ..Boundary::new(self.shape.clone(), center) }
    }

    /// What its user may not expect of it.
    pub(crate) fn note(&self) -> Option<String> {
        let Self { entity, component, .. } = self;
        let message = || {
            format!(
                "{component} of entity {entity} moves because it has been moved (motion: Auto): from here on its friction and a viscosity_model \
                 drag fluid along, artificial viscosity and viscous_faces do not; motion: Still keeps those, Moving leaves this note out"
            )
        };
        self.is_auto.then(message)
    }

    /// Lowest and highest corner of the space that its samples take, m in the domain's frame.
    pub(crate) fn extent(&self, body: &Body) -> (Vec3, Vec3) {
        let samples = body.samples.iter().map(|&sample| self.pose * sample);
        samples.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
    }
}

/// The samples of walls that move: made when their shape or the domain's spacing and kernel change.
#[derive(Default)]
pub(crate) struct MoverBodies(HashMap<Entity, MadeBody>);

struct MadeBody {
    shape: BoundaryShape,
    layer: WallLayer,
    body: Result<Body, InvalidInput>,
}

impl MoverBodies {
    /// The body of a wall.
    pub(crate) fn body(&mut self, mover: &Mover, layer: &WallLayer) -> Result<Body, InvalidInput> {
        mover.friction.validate().map_err(|error| error.inside("friction"))?;
        let is_made = |made: &MadeBody| made.layer == *layer && made.shape == mover.shape;
        if let Some(made) = self.0.get(&mover.entity).filter(|made| is_made(made)) {
            return made.body.clone().map(|body| Body { friction: mover.friction, ..body });
        }
        // Solvers know bodies of successive plans by their names.
        let name = format!("{} of entity {}", mover.component, mover.entity);
        let body = Body::of_shape(&name, mover.shape.clone(), layer).map(|body| Body { at_once: true, ..body });
        let made = MadeBody { shape: mover.shape.clone(), layer: *layer, body: body.clone() };
        self.0.insert(mover.entity, made);
        body.map(|body| Body { friction: mover.friction, ..body })
    }

    /// Forgets those of other walls.
    pub(crate) fn keep(&mut self, movers: &[Mover]) {
        self.0.retain(|entity, _| movers.iter().any(|mover| mover.entity == *entity));
    }
}

/// A wall that moves, while it does.
#[derive(Clone, Debug)]
pub(crate) struct MovingWall {
    pub(crate) entity: Entity,
    component: &'static str,
    stretch: Option<Mat3>,
    /// The farthest of its samples from its centre, m.
    reach: f32,
    /// Where the last tick left it, in the domain's frame; none if it has not been simulated yet.
    pub(crate) pose: Option<Isometry3d>,
    /// Whether the solver has met it.
    is_known: bool,
    /// Where the leak count takes its way from: where it was at the last look, or has been put since, in the domain's frame.
    looked: Option<Isometry3d>,
    /// Whether it has been put elsewhere since the last look.
    is_put: bool,
    /// Whether it has been put elsewhere since the last tick.
    is_placed: bool,
    /// Whether the last tick left it wholly within the bounds.
    is_within: bool,
}

/// What a tick is told of a wall, and whether its scale is that of its shape.
pub(crate) struct Told {
    pub(crate) input: BodyInput,
    pub(crate) has_changed: bool,
}

impl MovingWall {
    /// One that goes on from where it is, if it is not new.
    pub(crate) fn new(mover: &Mover, samples: &[Vec3], before: &[Self]) -> Self {
        let before = before.iter().find(|wall| wall.entity == mover.entity);
        let reach = samples.iter().map(|sample| sample.length()).fold(0.0, f32::max);
        let pose = before.and_then(|wall| wall.pose).or(mover.from);
        let looked = before.and_then(|wall| wall.looked).or(mover.from);
        let is_put = before.is_some_and(|wall| wall.is_put);
        let is_placed = before.is_some_and(|wall| wall.is_placed);
        let is_known = before.is_some_and(|wall| wall.is_known);
        let is_within = before.is_some_and(|wall| wall.is_within);
        let Mover { entity, component, stretch, .. } = *mover;
        Self { entity, component, stretch, reach, pose, is_known, looked, is_put, is_placed, is_within }
    }

    /// Has a watch that has just been given the plan's walls take its way from where it was at the last look.
    pub(crate) fn go_on(&self, index: usize, watch: &mut LeakWatch) {
        if let Some(looked) = self.looked {
            watch.put_wall(index, wall_pose(looked));
        }
    }

    /// Tells a watch of its way since the last look; there is none for a watch that has not looked yet.
    pub(crate) fn show(&mut self, index: usize, watch: &mut LeakWatch, is_first: bool) {
        let Some(pose) = self.pose else { return };
        if is_first {
            self.looked = Some(pose);
        }
        if (is_first || self.is_put)
            && let Some(looked) = self.looked
        {
            watch.put_wall(index, wall_pose(looked));
        }
        watch.move_wall(index, wall_pose(pose));
        (self.looked, self.is_put) = (Some(pose), false);
    }

    /// It stands still until it is moved again: while no ticks are sent.
    pub(crate) fn pause(&mut self) {
        self.pose = None;
    }

    /// Puts it where its entity is, if that is not where the last tick left it.
    pub(crate) fn place(&mut self, transforms: &TransformHelper, frame: Isometry3d) {
        let Ok((pose, _)) = self.find(transforms) else { return };
        let now = frame.inverse() * pose;
        if self.pose.is_some_and(|before| is_moved(before, now)) {
            self.put(now);
        }
    }

    /// What is wrong if it has gone out of the bounds of a plan, where its body has these samples, since it was last asked.
    pub(crate) fn goes_out(&mut self, plan: &Plan, samples: &[Vec3]) -> Option<Problem> {
        let pose = self.pose?;
        let (min, max) = (plan.parameters.bounds_min, plan.parameters.bounds_max);
        let is_in = |point: Vec3, margin: f32| (point - min).min(max - point).min_element() >= margin;
        // Most are far from the bounds.
        let is_within = is_in(pose.translation.into(), self.reach) || samples.iter().all(|&at| is_in(pose * at, 0.0));
        let was_within = std::mem::replace(&mut self.is_within, is_within);
        let message = || {
            format!(
                "Transform: it has gone out of the domain's bounds, {min} to {max} m, and fluid that goes with it is removed; allowed: within \
                 FluidSettings::bounds, which can be set around its whole way"
            )
        };
        (was_within && !is_within).then(|| Problem::new(self.entity, self.component, message()))
    }

    /// It has been put elsewhere.
    fn put(&mut self, now: Isometry3d) {
        (self.pose, self.looked) = (Some(now), Some(now));
        (self.is_put, self.is_placed) = (true, true);
    }

    /// Where its entity is in the world, and whether its scale is that of its shape.
    fn find(&self, transforms: &TransformHelper) -> Result<(Isometry3d, bool), String> {
        match self.stretch {
            Some(planned) => stretched_frame(transforms, self.entity)
                .map(|(pose, stretch)| (pose, is_same_stretch(stretch, planned))),
            None => rigid_frame(transforms, self.entity).map(|pose| (pose, true)),
        }
    }

    /// Moves it to where its entity is, in a tick of so many seconds.
    pub(crate) fn advance(
        &mut self,
        transforms: &TransformHelper,
        frame: Isometry3d,
        duration: f32,
        plan: &Plan,
    ) -> Told {
        // One whose transform is of no use stays where it is, until planning says what is wrong.
        let (now, is_same) = match (self.find(transforms), self.pose) {
            (Ok((pose, is_same)), _) => (frame.inverse() * pose, is_same),
            (Err(_), Some(pose)) => (pose, false),
            (Err(_), None) => (Isometry3d::IDENTITY, false),
        };
        let before = self.pose.unwrap_or(now);
        let (away, turn) = difference(before, now);
        let way = away.length() + turn.length() * self.reach;
        let (expected, reach) = (plan.parameters.expected_speed, plan.parameters.body_reach());
        let is_put = self.pose.is_none() || way > (PUT * expected * duration).max(plan.parameters.support_radius);
        if is_put {
            self.put(now);
        }
        self.pose = Some(now);
        let was_known = std::mem::replace(&mut self.is_known, true);
        let placed = std::mem::take(&mut self.is_placed);
        let (position, rotation) = (now.translation.into(), now.rotation);
        let still = BodyInput { position, rotation, free: false, placed, ..default() };
        let input = if is_put || duration <= 0.0 || (away, turn) == (Vec3::ZERO, Vec3::ZERO) {
            still
        } else {
            // A solver runs a tick for longer where the one before fell behind: a velocity takes the wall too far then. To a place it
            // drifts from where it is, just as fast, up to the speeds and ways that solvers allow; of those, half is left for what it lags
            // behind. Only a budget leaves out time for good: a wall may then be faster in the fluid's time than it could drift.
            let drifts = was_known && !placed && plan.budget_milliseconds.is_none();
            let most = if drifts { expected.min(0.5 * reach / duration) } else { 0.0 };
            let (speed, spin) = (away / duration, turn / duration);
            let (drift, turning) = (speed.clamp_length_max(most), spin.clamp_length_max(most / reach));
            let position = Vec3::from(before.translation) + duration * drift;
            let rotation = (Quat::from_scaled_axis(duration * turning) * before.rotation).normalize();
            BodyInput { position, rotation, linear_velocity: speed - drift, angular_velocity: spin - turning, ..still }
        };
        Told { input, has_changed: !is_same }
    }
}

fn wall_pose(pose: Isometry3d) -> WallPose {
    WallPose { center: pose.translation.into(), rotation: pose.rotation }
}

/// The way from one pose to another, m, and the shorter way round, radians about the domain's axes.
fn difference(before: Isometry3d, now: Isometry3d) -> (Vec3, Vec3) {
    let turned = now.rotation * before.rotation.inverse();
    let turned = if turned.w < 0.0 { -turned } else { turned };
    // Exactly none if it has not turned, where rounding would make 1e-7.
    let turn = if now.rotation == before.rotation { Vec3::ZERO } else { turned.normalize().to_scaled_axis() };
    ((now.translation - before.translation).into(), turn)
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::SystemState;
    use freshet_core::prelude::{FluidScene, FluidSolver, StepInput, Volume};
    use freshet_cpu::{CpuOptions, CpuSolver};

    use super::*;

    /// A plate that moves along y in a world of its own, and a watch on it and on a particle.
    struct Plate {
        world: World,
        mover: Mover,
        wall: MovingWall,
        watch: LeakWatch,
        layer: WallLayer,
        plan: Plan,
    }

    impl Plate {
        fn new() -> Self {
            let mut world = World::new();
            let entity = world.spawn(Transform::default()).id();
            let mut scene = FluidScene::with_spacing(0.1);
            scene.settings.expected_speed = Some(6.0);
            let (layer, plan) = (scene.wall_layer().unwrap(), Plan::new(&scene).unwrap());
            let shape = BoundaryShape::Box { half_extents: Vec3::new(1.0, 0.02, 1.0) };
            let mover = Mover {
                entity,
                component: "",
                shape,
                friction: Friction::default(),
                stretch: None,
                pose: Isometry3d::IDENTITY,
                from: None,
                is_auto: false,
            };
            let watch = LeakWatch::new(&layer, &[mover.boundary()]);
            Self { world, wall: MovingWall::new(&mover, &[], &[]), mover, watch, layer, plan }
        }

        fn move_to(&mut self, y: f32) {
            self.advance(y, 1.0 / 64.0);
        }

        fn advance(&mut self, y: f32, duration: f32) -> Told {
            *self.world.get_mut::<Transform>(self.mover.entity).unwrap() = Transform::from_xyz(0.0, y, 0.0);
            self.mover.pose = Isometry3d::from_translation(Vec3::Y * y);
            let mut system = SystemState::<TransformHelper>::new(&mut self.world);
            let transforms = system.get(&self.world).unwrap();
            self.wall.advance(&transforms, Isometry3d::IDENTITY, duration, &self.plan)
        }

        /// As a new plan does, made when the plate is where it goes next.
        fn replan(&mut self, y: f32) {
            self.mover.pose = Isometry3d::from_translation(Vec3::Y * y);
            self.wall = MovingWall::new(&self.mover, &[], std::slice::from_ref(&self.wall));
            self.watch.set_walls(&self.layer, &[self.mover.boundary()]);
            self.wall.go_on(0, &mut self.watch);
        }

        fn look(&mut self, y: f32) -> u32 {
            self.wall.show(0, &mut self.watch, false);
            self.watch.look(&[0], &[Vec3::Y * y])
        }
    }

    #[test]
    fn a_watch_sees_the_way_of_a_wall_through_ticks_left_out_and_new_plans() {
        let far = 10.0;
        for (is_looked_at, is_planned) in [(true, false), (false, false), (true, true), (false, true)] {
            let case = format!("looked at: {is_looked_at}, planned: {is_planned}");
            let mut plate = Plate::new();
            plate.move_to(0.0);
            assert_eq!(plate.look(0.1), 0);
            // It is put beyond the particle, and goes on from there.
            plate.move_to(far);
            if is_looked_at {
                assert_eq!(plate.look(0.1), 0, "{case}");
            }
            if is_planned {
                plate.replan(far + 0.2);
            }
            plate.move_to(far + 0.2);
            assert_eq!(plate.look(0.1), 0, "{case}: it was put");
            // The particle is now beside it, it pushes it along farther than it is thick, and at last sweeps over it.
            let mut plate = Plate::new();
            plate.move_to(0.0);
            assert_eq!(plate.look(0.1), 0);
            plate.move_to(0.2);
            if is_looked_at {
                assert_eq!(plate.look(0.3), 0, "{case}");
            }
            if is_planned {
                plate.replan(0.4);
            }
            plate.move_to(0.4);
            assert_eq!(plate.look(0.5), 0, "{case}: it is pushed");
            plate.move_to(0.5);
            if is_planned {
                plate.replan(0.6);
            }
            plate.move_to(0.6);
            assert_eq!(plate.look(0.5), 1, "{case}: it is swept over");
        }
    }

    #[test]
    fn a_wall_that_fell_behind_is_at_its_place_when_the_fluid_has_caught_up() {
        for speed in [0.5, 4.0, 9.0] {
            let mut plate = Plate::new();
            let mut scene = FluidScene::with_spacing(0.1);
            scene.gravity = Vec3::ZERO;
            scene.volumes.push(Volume::block(Vec3::splat(0.1), Vec3::X * 3.0));
            let shape = BoundaryShape::Box { half_extents: Vec3::new(1.0, 0.05, 1.0) };
            scene.bodies.push(Body::of_shape("plate", shape, &plate.layer).unwrap());
            (scene.settings.expected_speed, scene.settings.max_substeps) = (Some(6.0), 24);
            plate.plan = Plan::new(&scene).unwrap();
            let options = CpuOptions { threads: Some(1), ..CpuOptions::default() };
            let mut solver = CpuSolver::new(plate.plan.clone(), options).unwrap();
            let (mut y, mut was_behind, mut caught_up) = (0.0, false, 0);
            for (tick, share) in
                [1.0, 1.0, 3.0, 0.25, 0.25, 0.5, 0.25, 1.0, 3.0, 0.25, 0.25, 0.5, 1.0].iter().enumerate()
            {
                let duration = share / 64.0;
                y += speed * duration;
                let bodies = vec![plate.advance(y, duration).input];
                let input = StepInput { tick: tick as u64, duration, bodies, ..StepInput::default() };
                let report = solver.step(&input).unwrap();
                let lag = y - solver.snapshot().unwrap().poses[0].unwrap().position.y;
                println!("{speed} m/s, tick {tick}: {} covered, {lag} m behind", report.time_scale);
                assert!(lag > -1e-4, "{speed} m/s, tick {tick}: it is {} m ahead", -lag);
                if report.time_scale > 0.999 {
                    assert!(lag < 1e-4, "{speed} m/s, tick {tick}: it is {lag} m behind");
                    caught_up += u32::from(was_behind);
                }
                was_behind = report.time_scale < 0.999;
            }
            assert!(caught_up > 0, "{speed} m/s: no tick fell behind, or it never caught up");
        }
    }

    #[test]
    fn a_difference_takes_one_pose_to_the_other_by_the_shorter_way() {
        let from = Isometry3d::new(Vec3::new(1.0, 2.0, 3.0), Quat::from_euler(EulerRot::YXZ, 0.7, -0.3, 2.0));
        for (way, turn) in [(Vec3::X, Vec3::Y * 0.01), (Vec3::ZERO, Vec3::new(1.0, -2.0, 0.5)), (Vec3::Z, Vec3::ZERO)] {
            let rotation = Quat::from_scaled_axis(turn) * from.rotation;
            for rotation in [rotation, -rotation] {
                let to = Isometry3d::new(Vec3::from(from.translation) + way, rotation);
                let (found, turned) = difference(from, to);
                assert!(found.distance(way) < 1e-6 && turned.distance(turn) < 1e-5, "{found} {turned}");
            }
        }
        assert_eq!(difference(from, from), (Vec3::ZERO, Vec3::ZERO));
    }
}
