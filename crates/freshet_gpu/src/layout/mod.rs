//! What the solver's buffers hold, declared once in Rust: the WGSL is generated from here.

mod binding;
mod records;
mod wgsl;

pub use binding::{Access, Binding};
pub use records::{
    AccelerationRecord, BodyAnswerRecord, BodyInputRecord, BodyRecord, BodySampleRecord, CommandRecord, ExchangeRecord,
    Parameters, ParticleRecord, SampleLoadRecord, SpawnRecord, StepControl, TickRecord,
};
pub use wgsl::{Atomic, WgslStruct, WgslType};

pub(crate) use binding::{TEXTURE_WIDTH, bindings_module};
