//! The registry of particle fields: one door for colouring, read-back, export, charts and tests.

use serde::{Deserialize, Serialize};

/// Number that stays with a particle from birth to removal; ids of one spawn are consecutive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ParticleId(pub u32);

/// A quantity every particle carries or that follows from those it carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Field {
    /// Stable number of the particle.
    Id,
    /// Position in the domain's frame, m.
    Position,
    /// Velocity, m/s.
    Velocity,
    /// Density from the calibrated sum, kg/m3, at the start of the last substep.
    Density,
    /// Pressure from the equation of state, Pa, at the start of the last substep.
    Pressure,
    /// Acceleration by pressure, viscosity and gravity, m/s2, in the last substep.
    Acceleration,
    /// Magnitude of the velocity, m/s.
    Speed,
    /// Time until the particle is retired, s; infinite for particles without a lifetime.
    RemainingLife,
}

/// How a field's values are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// One unsigned integer.
    Integer,
    /// One real number.
    Scalar,
    /// Three real numbers.
    Vector,
}

/// Who makes a field's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldOrigin {
    /// Kept in memory from substep to substep.
    State,
    /// Written by a stage in every substep.
    Stage,
    /// Computed from other fields where it is asked for; costs nothing otherwise.
    Derived,
}

impl Field {
    /// All registered fields.
    pub const ALL: [Field; 8] = [
        Field::Id,
        Field::Position,
        Field::Velocity,
        Field::Density,
        Field::Pressure,
        Field::Acceleration,
        Field::Speed,
        Field::RemainingLife,
    ];

    /// Stable name, as used in files, shaders and panels.
    pub fn name(self) -> &'static str {
        match self {
            Field::Id => "id",
            Field::Position => "position",
            Field::Velocity => "velocity",
            Field::Density => "density",
            Field::Pressure => "pressure",
            Field::Acceleration => "acceleration",
            Field::Speed => "speed",
            Field::RemainingLife => "remaining_life",
        }
    }

    /// Finds a field by its [`name`](Self::name).
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|field| field.name() == name)
    }

    /// SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Field::Id => "1",
            Field::Position => "m",
            Field::Velocity | Field::Speed => "m/s",
            Field::Density => "kg/m3",
            Field::Pressure => "Pa",
            Field::Acceleration => "m/s2",
            Field::RemainingLife => "s",
        }
    }

    /// Layout of the values.
    pub fn kind(self) -> FieldKind {
        match self {
            Field::Id => FieldKind::Integer,
            Field::Position | Field::Velocity | Field::Acceleration => FieldKind::Vector,
            Field::Density | Field::Pressure | Field::Speed | Field::RemainingLife => FieldKind::Scalar,
        }
    }

    /// Who makes the values.
    pub fn origin(self) -> FieldOrigin {
        match self {
            Field::Id | Field::Position | Field::Velocity | Field::RemainingLife => FieldOrigin::State,
            Field::Density | Field::Pressure | Field::Acceleration => FieldOrigin::Stage,
            Field::Speed => FieldOrigin::Derived,
        }
    }
}

/// Values of one field for all particles, in the solver's current order.
///
/// Order differs between substeps and backends: sort by [`Field::Id`] to compare.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldData {
    /// Values of an [`FieldKind::Integer`] field.
    Integer(Vec<u32>),
    /// Values of a [`FieldKind::Scalar`] field.
    Scalar(Vec<f32>),
    /// Values of a [`FieldKind::Vector`] field.
    Vector(Vec<glam::Vec3>),
}

impl FieldData {
    /// Number of particles.
    pub fn len(&self) -> usize {
        match self {
            FieldData::Integer(values) => values.len(),
            FieldData::Scalar(values) => values.len(),
            FieldData::Vector(values) => values.len(),
        }
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values of a scalar field, none if it is of another kind.
    pub fn scalars(self) -> Option<Vec<f32>> {
        if let FieldData::Scalar(values) = self { Some(values) } else { None }
    }

    /// The values of a vector field, none if it is of another kind.
    pub fn vectors(self) -> Option<Vec<glam::Vec3>> {
        if let FieldData::Vector(values) = self { Some(values) } else { None }
    }

    /// The values of an integer field, none if it is of another kind.
    pub fn integers(self) -> Option<Vec<u32>> {
        if let FieldData::Integer(values) = self { Some(values) } else { None }
    }

    /// The same values in the order of `ids`, so that two solvers can be compared particle by particle.
    ///
    /// `ids` holds the ids in the current order, as read from [`Field::Id`].
    #[must_use]
    pub fn sorted_by_id(self, ids: &[u32]) -> Self {
        let mut order: Vec<usize> = (0..ids.len()).collect();
        order.sort_unstable_by_key(|&i| ids[i]);
        match self {
            FieldData::Integer(values) => FieldData::Integer(order.into_iter().map(|i| values[i]).collect()),
            FieldData::Scalar(values) => FieldData::Scalar(order.into_iter().map(|i| values[i]).collect()),
            FieldData::Vector(values) => FieldData::Vector(order.into_iter().map(|i| values[i]).collect()),
        }
    }
}
