//! What a thread needs beside a task's own data, kept from task to task and from substep to substep.

use glam::Vec3;

use crate::candidates::Candidates;
use crate::lanes::Sums;
use crate::packed::Packed;
use crate::passes::body_contact::Contact;

/// Candidates of one cell packed in the ways of the passes, and its particles' sums. What a plan does not use takes no memory.
#[derive(Default)]
pub struct Workspace {
    /// Positions.
    pub places: Packed<3>,
    /// With a pressure term or a volume.
    pub calm: Packed<4>,
    /// With a motion.
    pub moving: Packed<6>,
    /// Samples that drag by artificial viscosity, with friction, or with a pressure.
    pub dragging: Packed<5>,
    /// Samples that drag by a physical viscosity, or rub and move; fluid with its motion and density.
    pub sticking: Packed<7>,
    /// Fluid with a viscosity; samples of bodies with their arms; samples that drag by artificial viscosity and move.
    pub viscous: Packed<8>,
    /// The same with the width of its support.
    pub wide: Packed<9>,
    /// Of particles.
    pub sums: Sums,
    /// Of particles, over the walls.
    pub wall_sums: Sums,
    /// Of particles, with bodies they stick to or rub on.
    pub contacts: Vec<Contact>,
    /// Around a body's samples.
    pub candidates: Candidates,
    /// Samples of walls near a particle, with the ways from them, m.
    pub near_walls: Vec<(usize, Vec3)>,
}

impl Workspace {
    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let Self {
            places,
            calm,
            moving,
            dragging,
            sticking,
            viscous,
            wide,
            sums,
            wall_sums,
            contacts,
            candidates,
            near_walls,
        } = self;
        let packed =
            places.bytes() + calm.bytes() + moving.bytes() + dragging.bytes() + sticking.bytes() + viscous.bytes();
        let contacts = (size_of::<Contact>() * contacts.capacity()) as u64;
        packed
            + wide.bytes()
            + sums.bytes()
            + wall_sums.bytes()
            + contacts
            + candidates.bytes()
            + (size_of::<(usize, Vec3)>() * near_walls.capacity()) as u64
    }
}
