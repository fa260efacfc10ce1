//! What walls do to a fluid beside standing in its sums.
//!
//! The default, [`WallMethod::VolumeWeights`], has walls in the density of the fluid and pushes with the gradient of that density: see
//! [`wall_layer`](crate::sampling::wall_layer). So do [quasi-fluid walls](WallMethod::QuasiFluid), whose samples have densities and pressures of their own. The others leave
//! walls out of all sums: they push particles that come near, whatever the pressure of the fluid is. They know nothing of the fluid behind a
//! particle, so that densities fall towards a wall as towards a free surface.
//!
//! It is a choice of the scene and not of each boundary: whether walls are in the sums and how deep their samples lie decides what passes,
//! buffers and shaders a plan has.
//!
//! Samples of the others lie where fluid at rest stands half a spacing off the face, see [`WallMethod::depth`]. All are accelerations, along `x_ak = x_a - x_k` from the sample to the particle or along the normal
//! of the face, to the fluid; fluid slips along the walls. They need the substeps of a weakly compressible fluid.

mod faces;
mod forces;
pub mod ghosts;
mod penalty;
mod quasi_fluid;

use serde::{Deserialize, Serialize};

pub(crate) use self::faces::face_of;
pub use self::faces::{Face, MOST_PLANES, Plane};
pub use self::penalty::{Penalty, Reflection};
pub use self::quasi_fluid::QuasiFluid;
use crate::error::{InvalidInput, check_range};

/// How walls act on a fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum WallMethod {
    /// Akinci et al. 2012: one layer of samples in the densities, whose volumes stand for the whole wall, pushing with the particle's own pressure.
    #[default]
    VolumeWeights,
    /// Three layers of samples that stand in density and pressure as fluid does (Pirovano 2011, section 3.5.3, after Crespo et al. 2007).
    QuasiFluid(QuasiFluid),
    /// Mirror images of the fluid behind plane faces, see [`ghosts`] (Randles & Libersky 1996; Pirovano 2011, section 3.5.4).
    Ghosts,
    /// Lennard-Jones forces of the samples (Monaghan 1994; Pirovano 2011, eq. 3.13): `K x_ak/r^2 ((d/r)^12 - (d/r)^6)` where `r < d`, the
    /// spacing, with `K = v^2` of the expected speed.
    LennardJones,
    /// Pirovano's cheaper variant (2011, section 3.5.2), after the kernel: `K d^3 W(r) x_ak/r`, with `K = 8 v^2/d`.
    KernelForcing,
    /// Monaghan 2005 (Becker, Tessendorf & Teschner 2009; Enneking 2018, eq. 12 put right): `0.01 c^2 x_ak/r^2` times 2/3 for `q < 2/3`, `2 q - 3/2 q^2`
    /// for `q < 1`, `(2 - q)^2/2` for `q < 2`, with `q = r/h`.
    MonaghanRepulsion,
    /// A damped spring at the face (Amada 2006; Krog 2010, eq. 7.1), with Coulomb's friction where a boundary [has it](crate::scene::Boundary::friction).
    SpringDamper(SpringDamper),
    /// Collisions with the face after each substep (Pirovano 2011, section 3.5.1): no force at all.
    Penalty(Penalty),
}

/// A damped spring that pushes what is nearer than half a spacing to a face: `w^2 s - 2 z w v.n` along the normal `n`, with `s` how much
/// nearer it is, never pulling.
///
/// The face is the plane through its place nearest to the nearest sample, across the normal there; above ground that is what Krog's height
/// difference times `n_y` is. In an edge each of the faces that meet there pushes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringDamper {
    /// `w`, rad/s, 1e-3 to 1e6; none takes four times the expected speed over the spacing: what comes with that speed gets half way to the face.
    pub frequency: Option<f32>,
    /// `z`, no unit, 0 to 2: 0 gives all energy back, with 1 nothing oscillates.
    pub damping_ratio: f32,
}

impl SpringDamper {
    /// Critically damped.
    pub const DEFAULT: Self = Self { frequency: None, damping_ratio: 1.0 };
}

impl Default for SpringDamper {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl WallMethod {
    /// All, with their default numbers.
    pub const ALL: [Self; 11] = [
        Self::VolumeWeights,
        Self::QuasiFluid(QuasiFluid::Adapted),
        Self::QuasiFluid(QuasiFluid::PLAIN),
        Self::Ghosts,
        Self::LennardJones,
        Self::KernelForcing,
        Self::MonaghanRepulsion,
        Self::SpringDamper(SpringDamper::DEFAULT),
        Self::Penalty(Penalty::DEFAULT),
        Self::Penalty(Penalty::SHARE),
        Self::Penalty(Penalty::MIRRORED),
    ];

    /// Name, as in plans and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::VolumeWeights => "volume weights",
            Self::QuasiFluid(QuasiFluid::Adapted) => "quasi-fluid, adapted",
            Self::QuasiFluid(QuasiFluid::Plain { .. }) => "quasi-fluid, plain",
            Self::Ghosts => "ghost particles",
            Self::LennardJones => "Lennard-Jones",
            Self::KernelForcing => "kernel forcing",
            Self::MonaghanRepulsion => "Monaghan's repulsion",
            Self::SpringDamper(_) => "spring and damper",
            Self::Penalty(penalty) => match penalty.reflection {
                Reflection::Whole => "penalty",
                Reflection::Share => "penalty by share",
                Reflection::Mirrored => "mirrored penalty",
            },
        }
    }

    /// Whether samples of walls are in the sums of the fluid.
    pub fn is_in_sums(self) -> bool {
        matches!(self, Self::VolumeWeights | Self::QuasiFluid(_))
    }

    /// Whether it pushes by a force of its own.
    pub fn is_force(self) -> bool {
        !self.is_in_sums() && !self.collides()
    }

    /// Whether samples need the [face](Face) they stand for.
    pub fn needs_faces(self) -> bool {
        matches!(self, Self::Ghosts | Self::SpringDamper(_) | Self::Penalty(_))
    }

    /// Whether particles that get into walls are put back after each substep.
    pub fn collides(self) -> bool {
        self.collision().is_some()
    }

    /// How they are, and how near to a face they get, spacings.
    pub fn collision(self) -> Option<(Penalty, f32)> {
        match self {
            Self::Penalty(penalty) => Some((penalty, 0.5)),
            Self::Ghosts => Some((Penalty::DEFAULT, ghosts::CONTACT)),
            _ => None,
        }
    }

    /// How near a particle has to be to a sample, and to its normal, to be held by its [plane](Plane), m.
    pub fn reach_of_planes(self, spacing: f32, support_radius: f32) -> [f32; 2] {
        match self {
            Self::Ghosts => [support_radius, ghosts::LATERAL_REACH * spacing],
            _ => [Plane::REACH * spacing, Plane::LATERAL_REACH * spacing],
        }
    }

    /// Whether boundaries may have friction.
    pub fn has_friction(self) -> bool {
        matches!(self, Self::VolumeWeights | Self::SpringDamper(_))
    }

    pub(crate) fn validate(self) -> Result<(), InvalidInput> {
        match self {
            Self::SpringDamper(SpringDamper { frequency, damping_ratio }) => {
                if let Some(frequency) = frequency {
                    check_range("frequency", frequency, 1e-3, 1e6, "rad/s")?;
                }
                check_range("damping_ratio", damping_ratio, 0.0, 2.0, "")
            }
            Self::Penalty(penalty) => penalty.validate(),
            Self::QuasiFluid(walls) => walls.validate(),
            _ => Ok(()),
        }
    }
}
