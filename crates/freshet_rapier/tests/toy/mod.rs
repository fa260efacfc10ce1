//! A fluid that is a spring: what a solver does with bodies (`docs/substep.md`) without the particles.
#![allow(dead_code)]

use std::collections::VecDeque;

use freshet_core::step::{BodyInput, Impulse, StepInput, StepReport};
use freshet_rapier::{Coupling, RapierView};
use glam::{Quat, Vec3};
use rapier3d::prelude::*;

pub const TICK: f32 = 1.0 / 60.0;

/// Pulls a body to the origin and upright, as buoyancy does, and takes part in its acceleration, as the water around it
/// does.
#[derive(Clone)]
pub struct Spring {
    /// kg, of the body.
    pub mass: f32,
    /// kg m2, of the body.
    pub inertia: f32,
    /// Mass of water that moves along, kg.
    pub added_mass: f32,
    /// Angular frequency of heave with that water, rad/s.
    pub frequency: f32,
    /// Share of critical damping.
    pub damping: f32,
    /// Angular frequency of roll, rad/s.
    pub roll_frequency: f32,
    pub substeps: u32,
    memory: VecDeque<(u64, Impulse)>,
}

impl Spring {
    pub fn new(mass: f32, inertia: f32) -> Self {
        Self {
            mass,
            inertia,
            added_mass: 0.5 * mass,
            frequency: 7.0,
            damping: 0.0,
            roll_frequency: 7.0,
            substeps: 40,
            memory: VecDeque::new(),
        }
    }

    /// Force and torque on the body; `acceleration` is what moves it otherwise (its weight, at rest held by buoyancy).
    fn load(&self, position: Vec3, rotation: Quat, velocity: Vec3, acceleration: Vec3) -> (Vec3, Vec3) {
        let total = self.mass + self.added_mass;
        let spring =
            -total * (self.frequency * self.frequency * position + 2.0 * self.damping * self.frequency * velocity);
        // m a = F + m g and F = -m g + spring - added a.
        let answer = spring / total;
        let force = -self.mass * acceleration + self.mass * answer;
        let torque = -self.inertia * self.roll_frequency * self.roll_frequency * rotation.to_scaled_axis();
        (force, torque)
    }

    /// A tick of one body.
    pub fn step(&mut self, input: &StepInput) -> StepReport {
        let body = &input.bodies[0];
        let BodyInput { mut position, mut rotation, mut linear_velocity, mut angular_velocity, .. } = *body;
        for &(tick, error) in &self.memory {
            if tick >= body.corrected_before && tick < input.tick {
                let (push, spin) = (error.linear * body.inverse_mass, body.inverse_inertia * error.angular);
                linear_velocity += push;
                angular_velocity += spin;
                if body.free {
                    let time = ((input.tick - tick) as f32 - LATE_START) * input.duration;
                    position += push * time;
                    rotation = (Quat::from_scaled_axis(spin * time) * rotation).normalize();
                }
            }
        }
        let mut impulse = Impulse::default();
        let substep = input.duration / self.substeps as f32;
        for _ in 0..self.substeps {
            let (force, torque) = self.load(position, rotation, linear_velocity, body.acceleration);
            impulse = impulse + Impulse { linear: force * substep, angular: torque * substep };
            linear_velocity += (force * body.inverse_mass + body.acceleration) * substep;
            angular_velocity += body.inverse_inertia * torque * substep;
            position += linear_velocity * substep;
            rotation = (Quat::from_scaled_axis(angular_velocity * substep) * rotation).normalize();
        }
        self.memory.push_back((input.tick, impulse - body.forecast));
        if self.memory.len() > 4 {
            self.memory.pop_front();
        }
        StepReport { tick: input.tick, bodies: vec![impulse], ..StepReport::default() }
    }
}

/// Part of its own tick after which an impulse is taken to act.
pub const LATE_START: f32 = 0.5;

/// When rapier hears of a tick's impulse, and what it does with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exchange {
    /// Before its own step of that tick.
    Lockstep,
    /// This many ticks later, forecast and corrected.
    Corrected(u64),
    /// This many ticks later, as an impulse like any other.
    Plain(u64),
}

/// A ball in a spring.
pub struct Toy {
    pub world: PhysicsWorld,
    pub ball: RigidBodyHandle,
    pub spring: Spring,
    pub coupling: Coupling,
}

impl Toy {
    /// A ball of radius 0.15 m and density 500 at `start`.
    pub fn new(start: Vec3) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vec3::new(0.0, -9.81, 0.0);
        world.integration_parameters.dt = TICK;
        let (ball, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(start).can_sleep(false),
            ColliderBuilder::ball(0.15).density(500.0),
        );
        let body = &world.bodies[ball];
        let inertia = body.mass_properties().local_mprops.principal_inertia().x;
        let spring = Spring::new(body.mass(), inertia);
        let coupling = Coupling::new([ball], 0);
        Self { world, ball, spring, coupling }
    }

    /// Runs ticks; calls `each` after every one.
    pub fn run(&mut self, exchange: Exchange, ticks: u64, mut each: impl FnMut(u64, &RigidBody)) {
        let mut late: VecDeque<StepReport> = VecDeque::new();
        for tick in 0..ticks {
            match exchange {
                Exchange::Lockstep | Exchange::Corrected(_) => {
                    let latency = if let Exchange::Corrected(latency) = exchange { latency } else { 0 };
                    while late.front().is_some_and(|report| report.tick + latency <= tick) {
                        let report = late.pop_front().unwrap();
                        self.coupling.receive(&report, &mut self.world.bodies).unwrap();
                    }
                    let bodies = self.coupling.begin_tick(tick, &RapierView::from(&self.world)).unwrap();
                    let report = self.spring.step(&StepInput { tick, duration: TICK, bodies, commands: vec![] });
                    if latency == 0 {
                        self.coupling.receive(&report, &mut self.world.bodies).unwrap();
                    } else {
                        late.push_back(report);
                    }
                    self.coupling.apply_forecast(&mut self.world.bodies).unwrap();
                    self.world.step();
                    self.coupling.complete(&mut self.world.bodies).unwrap();
                }
                Exchange::Plain(latency) => {
                    let body = &self.world.bodies[self.ball];
                    let input = BodyInput {
                        position: body.center_of_mass(),
                        rotation: *body.rotation(),
                        linear_velocity: body.linvel(),
                        angular_velocity: body.angvel(),
                        inverse_mass: 1.0 / body.mass(),
                        inverse_inertia: glam::Mat3::IDENTITY / self.spring.inertia,
                        acceleration: self.world.gravity,
                        ..BodyInput::default()
                    };
                    late.push_back(self.spring.step(&StepInput {
                        tick,
                        duration: TICK,
                        bodies: vec![input],
                        commands: vec![],
                    }));
                    if late.front().is_some_and(|report| report.tick + latency <= tick) {
                        let impulse = late.pop_front().unwrap().bodies[0];
                        let body = &mut self.world.bodies[self.ball];
                        body.apply_impulse(impulse.linear, true);
                        body.apply_torque_impulse(impulse.angular, true);
                    }
                    self.world.step();
                }
            }
            each(tick, &self.world.bodies[self.ball]);
        }
    }
}
