//! Fluid that flows in through a disc at a constant speed.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};
use crate::scene::{MAX_PARTICLES, check_position};
use crate::step::{NewParticles, StepInput};

/// A disc through which fluid flows in.
///
/// Layers of particles, a spacing apart, cross the disc at `speed`: the flow is `rest_density * area * speed`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Emitter {
    /// Centre of the disc, m.
    pub center: Vec3,
    /// Direction of the flow; need not be of unit length, but 1e-6 to 1e6 long.
    pub direction: Vec3,
    /// Radius of the disc, m, 1e-5 to 1e4.
    pub radius: f32,
    /// Speed of the flow, m/s, 1e-3 to 1e3.
    pub speed: f32,
    /// Time after which a particle is retired, s; infinite for ever.
    #[serde(default = "forever")]
    pub lifetime: f32,
}

fn forever() -> f32 {
    f32::INFINITY
}

impl Emitter {
    /// Checks every number.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        check_position("center", self.center)?;
        let length = self.direction.length();
        if !(1e-6..=1e6).contains(&length) {
            return Err(InvalidInput::new("direction", self.direction, "a vector 1e-6 to 1e6 long"));
        }
        check_range("radius", self.radius, 1e-5, 1e4, "m")?;
        check_range("speed", self.speed, 1e-3, 1e3, "m/s")?;
        if self.lifetime.is_nan() || self.lifetime <= 0.0 {
            return Err(InvalidInput::new("lifetime", self.lifetime, "more than 0 s, infinite for ever"));
        }
        Ok(())
    }

    /// Checks that the flow is one that can be simulated: at most [`MAX_PARTICLES`] a second.
    pub fn check_flow(&self, spacing: f32) -> Result<(), InvalidInput> {
        let radius = f64::from(self.radius) / f64::from(spacing);
        let layer = (std::f64::consts::PI * radius * radius).max(1.0);
        let flow = layer * f64::from(self.speed) / f64::from(spacing);
        if flow > f64::from(MAX_PARTICLES) {
            let allowed = format!(
                "up to {MAX_PARTICLES} particles a second; this one sends {flow:.3e}, with radius {} m and spacing {spacing} m",
                self.radius
            );
            return Err(InvalidInput::new("speed", self.speed, allowed));
        }
        Ok(())
    }

    /// Points of one layer, relative to the centre: a square lattice of cell centres within the disc, at least one.
    pub fn layer(&self, spacing: f32) -> Vec<Vec3> {
        let frame = Quat::from_rotation_arc(Vec3::Y, self.direction.normalize());
        let reach = (self.radius / spacing).ceil() as i32;
        let mut points = Vec::new();
        for k in -reach..reach {
            for i in -reach..reach {
                let point = Vec3::new(i as f32 + 0.5, 0.0, k as f32 + 0.5) * spacing;
                if point.length() <= self.radius {
                    points.push(frame * point);
                }
            }
        }
        if points.is_empty() {
            points.push(Vec3::ZERO);
        }
        points
    }

    /// Most particles alive at once, whatever the ticks are; none if they live for ever.
    ///
    /// Layers are made at the start of the tick in which they cross the disc, and live from then on: a tick's worth of them
    /// is there before its time.
    pub fn steady_count(&self, spacing: f32) -> Option<u64> {
        let time = f64::from(self.lifetime) + f64::from(StepInput::MAX_DURATION);
        // One for the layer at either end, one for those who outlive their time by a substep.
        let layers = (time * f64::from(self.speed) / f64::from(spacing)).ceil() + 2.0;
        self.lifetime.is_finite().then(|| (self.layer(spacing).len() as u64).saturating_mul(layers as u64))
    }

    /// Particles that cross the disc in `start .. start + duration`, both s since the emitter began.
    ///
    /// They are returned where they are at `start`: up to `duration * speed` upstream of the disc, so that consecutive
    /// layers are exactly a spacing apart whatever the ticks are.
    pub fn emit(&self, spacing: f32, start: f64, duration: f64) -> NewParticles {
        let interval = f64::from(spacing) / f64::from(self.speed);
        let direction = self.direction.normalize();
        let layer = self.layer(spacing);
        let mut particles = NewParticles { lifetime: self.lifetime, ..NewParticles::default() };
        // The same expression at the end of one tick and the start of the next: no layer is lost or made twice.
        let (first, end) = ((start / interval).ceil() as u64, ((start + duration) / interval).ceil() as u64);
        for index in first..end {
            let upstream = ((index as f64 * interval - start) * f64::from(self.speed)) as f32;
            let center = self.center - direction * upstream;
            particles.positions.extend(layer.iter().map(|point| center + *point));
            particles.velocities.extend(layer.iter().map(|_| direction * self.speed));
        }
        particles
    }
}
