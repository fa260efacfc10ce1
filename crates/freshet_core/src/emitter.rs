//! Fluid that flows in through a disc at a constant speed.

use std::f64::consts::PI;
use std::ops::Range;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};
use crate::scene::{MAX_PARTICLES, check_position};
use crate::step::{NewParticles, StepInput};

/// A disc through which fluid flows in.
///
/// The flow is `pi radius^2 speed`, whatever the spacing d: layers of particles cross the disc one after the other, and the
/// gap between them makes up for a layer being a whole number of particles. From a radius of 2 d on the gap is d within 4 %; below,
/// it is 0.85 d or more. A disc narrower than a particle (0.56 d) drips: a particle each time its volume has flowed in.
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

    /// Checks that the flow is one that can be simulated: at most [`MAX_PARTICLES`] a second, and in a layer.
    pub fn check_flow(&self, spacing: f32) -> Result<(), InvalidInput> {
        let flow = self.cells(spacing) * f64::from(self.speed) / f64::from(spacing);
        if flow > f64::from(MAX_PARTICLES) {
            let allowed = format!(
                "up to {MAX_PARTICLES} particles a second; this one sends {flow:.3e}, with radius {} m and spacing {spacing} m",
                self.radius
            );
            return Err(InvalidInput::new("speed", self.speed, allowed));
        }
        let layer = self.cells(spacing);
        if layer > f64::from(MAX_PARTICLES) {
            let allowed = format!(
                "up to {MAX_PARTICLES} particles across the disc; this one has {layer:.3e}, with spacing {spacing} m"
            );
            return Err(InvalidInput::new("radius", self.radius, allowed));
        }
        Ok(())
    }

    /// Area of the disc over that of a particle, `spacing^2`.
    fn cells(&self, spacing: f32) -> f64 {
        PI * (f64::from(self.radius) / f64::from(spacing)).powi(2)
    }

    /// Particles in a layer: as many as the disc has cells, rounded, and so many that layers are 0.85 spacings apart or more.
    fn layer_count(&self, spacing: f32) -> u64 {
        let cells = self.cells(spacing);
        cells.round().max((0.85 * cells).ceil()).max(1.0) as u64
    }

    /// Time between layers, s: that in which as much flows through the disc as a layer stands for.
    pub fn interval(&self, spacing: f32) -> f64 {
        self.layer_count(spacing) as f64 / self.cells(spacing) * f64::from(spacing) / f64::from(self.speed)
    }

    /// Points of one layer, relative to the centre, at least one and none nearer to another than a spacing.
    ///
    /// Those cells of a square lattice that are closest to its origin, which is the middle of a cell, of an edge or a
    /// corner: whichever keeps the layer most compact. The outermost lie up to 0.22 spacings outside of the disc.
    pub fn layer(&self, spacing: f32) -> Vec<Vec3> {
        let count = self.layer_count(spacing) as usize;
        let candidates = [[0.0, 0.0], [0.5, 0.5], [0.5, 0.0]].map(|origin| closest_cells(origin, count));
        let [mut best, others @ ..] = candidates;
        for other in others {
            // Up to rounding the first of equals, so that every machine takes the same.
            if spread(&other) < spread(&best) - 1e-6 {
                best = other;
            }
        }
        let middle = mean(&best);
        let frame = Quat::from_rotation_arc(Vec3::Y, self.direction.normalize());
        let place = |[x, z]: [f64; 2]| Vec3::new((x - middle[0]) as f32, 0.0, (z - middle[1]) as f32) * spacing;
        best.into_iter().map(|point| frame * place(point)).collect()
    }

    /// Most particles alive at once, whatever the ticks are; none if they live for ever.
    ///
    /// Layers are made up to [`StepInput::MAX_DURATION`] before they cross the disc, and their lifetime begins there.
    pub fn steady_count(&self, spacing: f32) -> Option<u64> {
        let time = f64::from(self.lifetime) + f64::from(StepInput::MAX_DURATION);
        // One for the layer at either end, one for those who outlive their time by a substep.
        let layers = (time / self.interval(spacing)).ceil() + 2.0;
        self.lifetime.is_finite().then(|| self.layer_count(spacing).saturating_mul(layers as u64))
    }

    /// The layers that cross the disc before the end of `span` (simulated time, s) and have not been sent, in order.
    ///
    /// Each is stamped with the time of its crossing ([`NewParticles::at`]), so that consecutive layers are a gap apart in the
    /// fluid even if less or more time is simulated than was expected; some may have crossed it already. A flow that is new
    /// starts with a layer at its own start; one whose emitter got another speed goes on where the last layer leaves room.
    pub fn layers(&self, spacing: f32, flow: &mut EmitterFlow, span: &Range<f64>) -> Vec<NewParticles> {
        let interval = self.interval(spacing);
        if flow.interval != interval {
            *flow = EmitterFlow { origin: flow.next_layer(), interval, sent: 0 };
        }
        let mut layers = Vec::new();
        if flow.next_layer() < span.end {
            let positions: Vec<Vec3> = self.layer(spacing).into_iter().map(|point| self.center + point).collect();
            let velocities = vec![self.direction.normalize() * self.speed; positions.len()];
            let layer = NewParticles { positions, velocities, lifetime: self.lifetime, at: None };
            while flow.next_layer() < span.end {
                let at = flow.next_layer();
                // After time was made up for, a layer may come so late that its life is over.
                if at + f64::from(self.lifetime) > span.start {
                    layers.push(NewParticles { at: Some(at), ..layer.clone() });
                }
                flow.sent += 1;
            }
        }
        layers
    }
}

/// Which of its layers an emitter has sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterFlow {
    /// Simulated time of layer 0, s.
    origin: f64,
    /// Time between layers, s; zero as long as none was sent.
    interval: f64,
    /// Layers sent.
    sent: u64,
}

impl EmitterFlow {
    /// A flow whose first layer crosses the disc at `start`, s of simulated time.
    pub fn new(start: f64) -> Self {
        Self { origin: start, interval: 0.0, sent: 0 }
    }

    /// The flow of an emitter with a layer every `interval` seconds since time 0, from the first one at or after `from` on.
    pub(crate) fn in_phase(interval: f64, from: f64) -> Self {
        let mut flow = Self { origin: 0.0, interval, sent: (from / interval).max(0.0) as u64 };
        // The quotient may be rounded to either side of a whole number; the product is what is sent.
        while flow.next_layer() < from {
            flow.sent += 1;
        }
        flow
    }

    /// Lets time pass up to `until`, s, without a layer: the emitter is switched off.
    pub fn pause(&mut self, until: f64) {
        if self.next_layer() < until {
            *self = Self::new(until);
        }
    }

    /// Simulated time at which the next layer crosses the disc, s.
    fn next_layer(&self) -> f64 {
        self.origin + self.sent as f64 * self.interval
    }
}

/// The `count` points of a square lattice of spacing 1, with a point at `origin`, that are closest to zero; row by row.
fn closest_cells(origin: [f64; 2], count: usize) -> Vec<[f64; 2]> {
    let reach = (count as f64 / PI).sqrt().ceil() as i64 + 1;
    let offsets = || (-reach..=reach).map(|index| index as f64);
    let mut points: Vec<[f64; 2]> =
        offsets().flat_map(|z| offsets().map(move |x| [origin[0] + x, origin[1] + z])).collect();
    let by_place = |a: &[f64; 2], b: &[f64; 2]| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]));
    // Squared distances are exact: of equals, the same ones on every machine.
    let distance = |point: &[f64; 2]| point[0] * point[0] + point[1] * point[1];
    let by_distance = |a: &[f64; 2], b: &[f64; 2]| distance(a).total_cmp(&distance(b)).then(by_place(a, b));
    points.select_nth_unstable_by(count - 1, by_distance);
    points.truncate(count);
    points.sort_unstable_by(by_place);
    points
}

fn mean(points: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64)
}

/// Sum of squared distances from the mean.
fn spread(points: &[[f64; 2]]) -> f64 {
    let [x, z] = mean(points);
    points.iter().map(|point| (point[0] - x).powi(2) + (point[1] - z).powi(2)).sum()
}
