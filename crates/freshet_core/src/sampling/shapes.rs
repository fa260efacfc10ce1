//! Layers of walls that are neither boxes nor planes.
//!
//! They lie as deep behind the face that the fluid touches as [`WallLayer::depth`] says, on the face itself where fluid is on both
//! sides of it. No two samples are nearer than two thirds of a spacing, and no point of the layer is farther than 0.75 spacings from
//! one; there are 1.0 to 1.4 samples for each spacing squared, in the same order from the same input.

use glam::Vec3;

use super::boundary::sample_sphere_surface;
use super::level_set::{Surface, sample_level_set};
use super::surface::sample_surface;
use super::too_thin;
use super::wall_layer::WallLayer;
use crate::error::InvalidInput;
use crate::geometry::round::Profile;
use crate::geometry::{HeightField, TriangleMesh};
use crate::scene::FluidSide;

impl WallLayer {
    /// Samples of a sphere, m; in a solid ball smaller than twice the depth they lie half way to its centre.
    ///
    /// # Errors
    /// As [`sample_sphere_surface`].
    pub fn sphere(&self, radius: f32, fluid: FluidSide) -> Result<Vec<Vec3>, InvalidInput> {
        let half = 0.5 * self.spacing();
        match fluid {
            FluidSide::Outside => self.sphere_surface(radius),
            FluidSide::Inside => {
                sample_sphere_surface(radius, self.spacing())?;
                sample_sphere_surface(radius + self.depth + half, self.spacing())
            }
            FluidSide::Both => {
                sample_sphere_surface(radius, self.spacing())?;
                sample_sphere_surface(radius + half, self.spacing())
            }
        }
    }

    /// Samples of a cylinder about the y axis, m; in a solid smaller than twice the depth they lie half way to its middle.
    ///
    /// # Errors
    /// Radius or half height less than half a spacing; more samples than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn cylinder(&self, radius: f32, half_height: f32, fluid: FluidSide) -> Result<Vec<Vec3>, InvalidInput> {
        self.require("radius", radius)?;
        self.require("half_height", half_height)?;
        let profile = Profile::cylinder(f64::from(radius), f64::from(half_height));
        self.round(&profile, f64::from(radius.min(half_height)), fluid)
    }

    /// Samples of a capsule about the y axis, m, of half the height of its straight part; as [`cylinder`](Self::cylinder).
    ///
    /// # Errors
    /// A radius less than half a spacing; more samples than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn capsule(&self, radius: f32, half_height: f32, fluid: FluidSide) -> Result<Vec<Vec3>, InvalidInput> {
        self.require("radius", radius)?;
        let profile = Profile::capsule(f64::from(radius), f64::from(half_height));
        self.round(&profile, f64::from(radius), fluid)
    }

    /// Samples of a cone about the y axis with its tip up, m, its centre half way up; as [`cylinder`](Self::cylinder).
    ///
    /// # Errors
    /// If the largest ball in it has a radius less than half a spacing; more samples than
    /// [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn cone(&self, radius: f32, half_height: f32, fluid: FluidSide) -> Result<Vec<Vec3>, InvalidInput> {
        let largest_ball = self.ball_in_cone(radius, half_height, 0.0)?;
        self.round(&Profile::cone(f64::from(radius), f64::from(half_height)), largest_ball, fluid)
    }

    /// Samples of a solid cylinder with round edges, m: a [`cylinder`](Self::cylinder) thickened all round by `rounding`.
    ///
    /// # Errors
    /// Radius or half height with the rounding less than half a spacing; more samples than
    /// [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn round_cylinder(&self, radius: f32, half_height: f32, rounding: f32) -> Result<Vec<Vec3>, InvalidInput> {
        self.require("radius", radius + rounding)?;
        self.require("half_height", half_height + rounding)?;
        let profile = Profile::cylinder(f64::from(radius), f64::from(half_height));
        let largest_ball = f64::from(radius.min(half_height) + rounding);
        self.rounded(&profile, self.depth_in(largest_ball), rounding)
    }

    /// Samples of a solid cone with round edges and a round tip, m: a [`cone`](Self::cone) thickened all round by `rounding`.
    ///
    /// # Errors
    /// If the largest ball in it has a radius less than half a spacing; more samples than
    /// [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn round_cone(&self, radius: f32, half_height: f32, rounding: f32) -> Result<Vec<Vec3>, InvalidInput> {
        let largest_ball = self.ball_in_cone(radius, half_height, rounding)?;
        let profile = Profile::cone(f64::from(radius), f64::from(half_height));
        self.rounded(&profile, self.depth_in(largest_ball), rounding)
    }

    /// Samples of a vessel about the y axis without a lid: radius and half height of the room in it, and the thickness of its wall
    /// and its bottom, m. In a wall thinner than twice the depth they are one layer in its middle.
    ///
    /// # Errors
    /// Radius or half height less than half a spacing; more samples than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn cup(&self, radius: f32, half_height: f32, thickness: f32) -> Result<Vec<Vec3>, InvalidInput> {
        self.require("radius", radius)?;
        self.require("half_height", half_height)?;
        let (r, half, thick) = (f64::from(radius), f64::from(half_height), f64::from(thickness));
        let d = f64::from(self.spacing());
        if thickness < 2.0 * self.depth {
            return sample_level_set(Surface::Sheet(&Profile::cup_middle(r, half, thick)), 0.0, true, d);
        }
        sample_level_set(Surface::Round(&Profile::cup(r, half, thick)), f64::from(self.depth), true, d)
    }

    /// Samples of a mesh. Parts of a solid thinner than twice the depth have one layer in their middle, and no point of the mesh is
    /// farther from a sample than 1.74 depths and 0.75 spacings together.
    ///
    /// # Errors
    /// More samples than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn mesh(&self, mesh: &TriangleMesh, fluid: FluidSide) -> Result<Vec<Vec3>, InvalidInput> {
        let (d, depth) = (f64::from(self.spacing()), f64::from(self.depth));
        match fluid {
            FluidSide::Both => sample_surface(mesh, d),
            _ => sample_level_set(Surface::Mesh(mesh), depth, fluid == FluidSide::Outside, d),
        }
    }

    /// Samples of a solid with round edges, m: what a closed convex mesh encloses, thickened all round by `rounding`. Where it is
    /// thinner than twice the depth they are one layer in its middle.
    ///
    /// # Errors
    /// More samples than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn round_mesh(&self, mesh: &TriangleMesh, rounding: f32) -> Result<Vec<Vec3>, InvalidInput> {
        let d = f64::from(self.spacing());
        match self.below_core(f64::from(self.depth), rounding) {
            Some(below) => sample_level_set(Surface::Mesh(mesh), below.abs(), below > 0.0, d),
            None => sample_surface(mesh, d),
        }
    }

    /// Samples of ground with the fluid above it.
    ///
    /// # Errors
    /// More samples than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
    pub fn height_field(&self, field: &HeightField) -> Result<Vec<Vec3>, InvalidInput> {
        sample_level_set(Surface::Ground(field), f64::from(self.depth), true, f64::from(self.spacing()))
    }

    fn round(&self, profile: &Profile, largest_ball: f64, fluid: FluidSide) -> Result<Vec<Vec3>, InvalidInput> {
        let (d, depth) = (f64::from(self.spacing()), f64::from(self.depth));
        match fluid {
            FluidSide::Outside => sample_level_set(Surface::Round(profile), self.depth_in(largest_ball), true, d),
            FluidSide::Inside => sample_level_set(Surface::Round(profile), depth, false, d),
            FluidSide::Both => sample_level_set(Surface::Sheet(profile), 0.0, true, d),
        }
    }

    /// The layer of a core that is thickened by `rounding`: its points are as far from the core as they are less deep than that.
    fn rounded(&self, core: &Profile, depth: f64, rounding: f32) -> Result<Vec<Vec3>, InvalidInput> {
        let d = f64::from(self.spacing());
        match self.below_core(depth, rounding) {
            Some(below) => sample_level_set(Surface::Round(core), below.abs(), below > 0.0, d),
            None => sample_level_set(Surface::Sheet(core), 0.0, true, d),
        }
    }

    /// How much deeper than the surface of its core the layer of a rounded solid lies, m; none where it is the same but for a
    /// twentieth of a spacing.
    fn below_core(&self, depth: f64, rounding: f32) -> Option<f64> {
        let below = depth - f64::from(rounding);
        (below.abs() > 0.05 * f64::from(self.spacing())).then_some(below)
    }

    /// Radius of the largest ball in a cone that is thickened by `rounding`, m; refuses one that is smaller than a particle.
    fn ball_in_cone(&self, radius: f32, half_height: f32, rounding: f32) -> Result<f64, InvalidInput> {
        let (r, height) = (f64::from(radius), 2.0 * f64::from(half_height));
        let largest_ball = r * height / (r + r.hypot(height)) + f64::from(rounding);
        if largest_ball < 0.5 * f64::from(self.spacing()) {
            let (field, value) = if radius < half_height { ("radius", radius) } else { ("half_height", half_height) };
            let allowed = format!("more: a ball of radius {} m has to fit in at this spacing", 0.5 * self.spacing());
            return Err(InvalidInput::new(field, value, allowed));
        }
        Ok(largest_ball)
    }

    /// Refuses what is smaller than a particle.
    fn require(&self, field: &str, value: f32) -> Result<(), InvalidInput> {
        let least = 0.5 * self.spacing();
        if value < least * (1.0 - 1e-6) {
            return Err(too_thin(field, f64::from(value), f64::from(least)));
        }
        Ok(())
    }
}
