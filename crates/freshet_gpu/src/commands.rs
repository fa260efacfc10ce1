//! A tick's commands as uploads and dispatches.

use freshet_core::misplaced::Misplaced;
use freshet_core::plan::Plan;
use freshet_core::solver::SolverError;
use freshet_core::step::Command;
use glam::Vec3;
use wgpu::util::DeviceExt;

use crate::buffers::Buffers;
use crate::errors::guarded;
use crate::layout::{Binding, CommandRecord, SpawnRecord};
use crate::passes::{Dispatch, command_passes};
use crate::pipelines::Pipeline;
use crate::shader::MAX_WORKGROUPS;

/// Distance of commands in their uniform buffer: WebGPU's alignment.
const STRIDE: usize = 256;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Edit {
    Spawn { first: u32, count: u32, timed: bool },
    RemoveIds { first: u32, count: u32 },
    RemoveInBox { min: Vec3, max: Vec3 },
}

/// Lifetime of particles that are never simulated, s: over, whenever they are said to be where they are spawned.
const OVER: f32 = f32::MIN;

/// Particles of a tick that are inside or beside a wall or a body: they fall out at its first sort.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LeftOut {
    /// Particles of the start, by id, in order.
    pub started: Vec<Misplaced>,
    /// Particles that commands spawn, by their place among all that the tick's commands do, in order.
    pub spawned: Vec<Misplaced>,
}

impl LeftOut {
    /// How many there were inside, and how many beside, in a tick that was to spawn `asked` particles and had no room for the
    /// last `refused` of them.
    pub fn count(&self, asked: u32, refused: u32) -> [u32; 2] {
        let made = asked.saturating_sub(refused);
        let spawned = self.spawned.iter().take_while(|one| one.index < made);
        spawned.chain(&self.started).fold(
            [0; 2],
            |[inside, beside], one| {
                if one.inside { [inside + 1, beside] } else { [inside, beside + 1] }
            },
        )
    }
}

/// The changes to particles that a tick asks for, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Edits {
    list: Vec<Edit>,
    spawned: Vec<SpawnRecord>,
    /// The GPU's clock at the time up to which ages count.
    clock: u32,
    /// Particles that are never simulated.
    pub left_out: LeftOut,
    /// Latest of the times at which particles were said to be where they are spawned, s.
    pub emitted: Option<f64>,
}

impl Edits {
    /// Reads commands; `gravity` is set by those that set it. The GPU's clock was at `clock` at the simulated time `time`, s.
    pub fn of(commands: &[Command], left_out: LeftOut, gravity: &mut Vec3, (time, clock): (f64, u32)) -> Self {
        let mut edits = Self { clock, ..Self::default() };
        for &Misplaced { index: id, .. } in &left_out.started {
            match edits.list.last_mut() {
                Some(Edit::RemoveIds { first, count }) if *first + *count == id => *count += 1,
                _ => edits.list.push(Edit::RemoveIds { first: id, count: 1 }),
            }
        }
        for command in commands {
            match command {
                Command::Spawn(particles) if particles.positions.is_empty() => {}
                Command::Spawn(particles) => {
                    let (first, count) = (edits.spawned.len() as u32, particles.positions.len() as u32);
                    let timed = particles.at.is_some();
                    let age = particles.at.map_or(0.0, |at| (time - at) as f32);
                    edits.emitted = edits.emitted.into_iter().chain(particles.at).reduce(f64::max);
                    edits.spawned.extend(particles.positions.iter().zip(&particles.velocities).map(
                        |(&position, &velocity)| SpawnRecord { position, lifetime: particles.lifetime, velocity, age },
                    ));
                    match edits.list.last_mut() {
                        // One after the other is one.
                        Some(Edit::Spawn { count: before, timed: same, .. }) if *same == timed => *before += count,
                        _ => edits.list.push(Edit::Spawn { first, count, timed }),
                    }
                }
                &Command::RemoveIds { first, count } => edits.list.push(Edit::RemoveIds { first, count }),
                &Command::RemoveInBox { min, max } => edits.list.push(Edit::RemoveInBox { min, max }),
                &Command::SetGravity(set) => *gravity = set,
            }
        }
        for one in &left_out.spawned {
            edits.spawned[one.index as usize].lifetime = OVER;
        }
        edits.left_out = left_out;
        edits
    }

    /// Particles to spawn.
    pub fn spawned(&self) -> u32 {
        self.spawned.len() as u32
    }

    fn records(&self, capacity: u32) -> Vec<u8> {
        let mut bytes = vec![0; STRIDE * self.list.len()];
        for (edit, chunk) in self.list.iter().zip(bytes.chunks_exact_mut(STRIDE)) {
            let record = match *edit {
                Edit::Spawn { first, count, timed } => CommandRecord {
                    first,
                    count,
                    capacity,
                    timed: u32::from(timed),
                    clock: self.clock,
                    ..Default::default()
                },
                Edit::RemoveIds { first, count } => CommandRecord { first, count, capacity, ..Default::default() },
                Edit::RemoveInBox { min, max } => CommandRecord { low: min, high: max, capacity, ..Default::default() },
            };
            chunk[..size_of::<CommandRecord>()].copy_from_slice(bytemuck::bytes_of(&record));
        }
        bytes
    }
}

/// A dispatch that carries out a command.
pub(crate) struct EditDispatch<'a> {
    /// What to run.
    pub pipeline: &'a Pipeline,
    /// On what.
    pub group: wgpu::BindGroup,
    /// With how many groups.
    pub groups: (u32, u32),
}

/// Pipelines of commands.
#[derive(Clone, Debug)]
pub(crate) struct CommandPipelines {
    pipelines: [Pipeline; 4],
    workgroup_size: u32,
}

impl CommandPipelines {
    /// Compiles them.
    pub fn new(
        plan: &Plan,
        workgroup_size: u32,
        mut compile: impl FnMut(crate::passes::Pass) -> Result<Pipeline, SolverError>,
    ) -> Result<Self, SolverError> {
        let [spawn, finish, ids, volume] = command_passes(plan);
        Ok(Self { pipelines: [compile(spawn)?, compile(finish)?, compile(ids)?, compile(volume)?], workgroup_size })
    }

    /// The dispatches of a tick's edits. Uploads are buffers of the tick's own, so that ticks in flight do not meet.
    ///
    /// `bound`: no fewer particles than there can be before the edits.
    pub fn dispatches(
        &self,
        device: &wgpu::Device,
        buffers: &Buffers,
        edits: &Edits,
        most: u32,
        bound: u32,
    ) -> Result<Vec<EditDispatch<'_>>, SolverError> {
        if edits.list.is_empty() {
            return Ok(Vec::new());
        }
        guarded(device, "uploading commands", || {
            let upload = |name: &str, contents: &[u8], usage| {
                device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some(&format!("freshet:buffer:{name}")),
                    contents,
                    usage,
                })
            };
            let records = upload("commands", &edits.records(most.min(buffers.capacity)), wgpu::BufferUsages::UNIFORM);
            let empty = [SpawnRecord::default()];
            let spawned = if edits.spawned.is_empty() { &empty[..] } else { &edits.spawned };
            let spawned = upload("spawned", bytemuck::cast_slice(spawned), wgpu::BufferUsages::STORAGE);
            let bound = bound.saturating_add(edits.spawned());
            let mut dispatches = Vec::new();
            for (index, edit) in edits.list.iter().enumerate() {
                let record = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &records,
                    offset: (STRIDE * index) as u64,
                    size: wgpu::BufferSize::new(STRIDE as u64),
                });
                let own = [(Binding::Command, record), (Binding::Spawned, spawned.as_entire_binding())];
                let [spawn, finish, ids, volume] = &self.pipelines;
                let steps: &[(&Pipeline, u32)] = match *edit {
                    Edit::Spawn { count, .. } => &[(spawn, count), (finish, 1)],
                    Edit::RemoveIds { .. } => &[(ids, bound)],
                    Edit::RemoveInBox { .. } => &[(volume, bound)],
                };
                for &(pipeline, threads) in steps {
                    let group = pipeline.bind(device, buffers, &own);
                    let single = pipeline.pass.dispatch == Dispatch::Single;
                    let groups = if single { (1, 1) } else { group_grid(threads.div_ceil(self.workgroup_size)) };
                    dispatches.push(EditDispatch { pipeline, group, groups });
                }
            }
            dispatches
        })
    }
}

/// Groups along x and y of a direct dispatch, as in `threads.wgsl`.
pub(crate) fn group_grid(groups: u32) -> (u32, u32) {
    (groups.min(MAX_WORKGROUPS), groups.div_ceil(MAX_WORKGROUPS))
}
