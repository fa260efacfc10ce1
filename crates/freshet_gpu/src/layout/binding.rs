//! The registry of buffers: number, type and accessors of each. Passes reach fields only through these accessors.

use super::records;

/// Texels in a row of the textures that hold particles: with WebGPU's default of 8192 rows, as many particles as the state's
/// buffer holds by default.
pub(crate) const TEXTURE_WIDTH: u32 = 512;

/// How a pass uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Reads only.
    Read,
    /// Writes, and may read.
    Write,
}

/// A buffer that shaders see. The number is the binding in group 0, the same in every pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
pub enum Binding {
    /// [`Parameters`](records::Parameters).
    Parameters,
    /// [`TickRecord`](records::TickRecord), a ring with a dynamic offset.
    Input,
    /// [`CommandRecord`](records::CommandRecord).
    Command,
    /// [`StepControl`](records::StepControl).
    Control,
    /// Arguments of indirect dispatches and of drawing.
    Arguments,
    /// [`ParticleRecord`](records::ParticleRecord): the state.
    Particles,
    /// Which candidates of a particle are its neighbours, in the memory of the state: between the sort, which copies the
    /// state, and the motion, which writes it anew, that memory is free.
    Hits,
    /// Positions and ids in the order of the last sort, four words each. A buffer or a texture, see
    /// [`NeighbourMemory`](crate::NeighbourMemory).
    SortedPositions,
    /// Velocities in the order of the last sort, each with the density that the density pass finds: what viscosity needs
    /// of a neighbour in one load. The pressure it needs follows from that density. A buffer or a texture, as the positions.
    SortedVelocities,
    /// Remaining lives in the order of the last sort.
    SortedLives,
    /// Density and `p / rho^2`.
    Densities,
    /// [`AccelerationRecord`](records::AccelerationRecord). Between the sort and the density pass: velocities.
    Accelerations,
    /// Accelerations by a change of the pressures of an incompressible fluid, m/s2; of a position-based one places, m. A buffer or a texture, as the positions.
    Motions,
    /// What the solves of an incompressible fluid keep, eight words a particle, ten with bodies, each word in a section of its own.
    Solves,
    /// The particle in each slot, before ordering by id.
    Slots,
    /// Number of particles in each cell, then of body samples.
    CellCounts,
    /// First particle of each cell, then first wall sample, first body sample, totals of blocks.
    CellStarts,
    /// Wall samples, then body samples, each sorted: position, and volume, negative for samples of viscous faces. Between them, if
    /// walls move, the velocities of wall samples. At the end, if the fluid is incompressible or sticks to them, where body samples are from the centre of
    /// mass of which body. A buffer or a texture, as the positions.
    Samples,
    /// [`BodyRecord`](records::BodyRecord).
    Bodies,
    /// [`BodyInputRecord`](records::BodyInputRecord), a ring.
    BodyInputs,
    /// [`BodySampleRecord`](records::BodySampleRecord).
    BodySamples,
    /// The sample in each slot, before ordering by number.
    BodySlots,
    /// [`SampleLoadRecord`](records::SampleLoadRecord).
    SampleLoads,
    /// [`SpawnRecord`](records::SpawnRecord).
    Spawned,
    /// Coefficients of friction of wall samples: of what sticks and of what slides.
    WallFrictions,
    /// Normals of the faces that wall samples stand for, and how far behind them samples lie, m, of plans whose walls push along them.
    WallFaces,
    /// Of plans whose walls are quasi-fluid: what walls' samples add to the density of each over that at rest, and its `p / rho^2`.
    WallDensities,
    /// What particles move with beside their velocity, of plans with XSPH: four words each, the last unused.
    Drifts,
    /// [`BodyAnswerRecord`](records::BodyAnswerRecord): how bodies answer to the solves of an incompressible fluid.
    Answers,
    /// Supports over the support radius, of plans where they vary.
    Widths,
    /// [`ContactRecord`](records::ContactRecord), of plans in which fluid sticks to bodies or rubs on them.
    Contacts,
    /// What the integrator keeps of particles and the density that they carry, one after the other: in the order of the state, then in that of the last sort.
    Histories,
    /// [`PlaceRecord`](records::PlaceRecord), of position-based plans: where particles are moved to. Others see it in the motions, m.
    Places,
    /// The state that a substep starts from, of plans that make substeps again: words one after the other, of each particle its record, its density and what
    /// is kept of it besides.
    Befores,
    /// Bodies in that state.
    BodiesBefore,
}

impl Binding {
    /// Every buffer.
    pub const ALL: [Binding; 35] = [
        Binding::Parameters,
        Binding::Input,
        Binding::Command,
        Binding::Control,
        Binding::Arguments,
        Binding::Particles,
        Binding::Hits,
        Binding::SortedPositions,
        Binding::SortedVelocities,
        Binding::SortedLives,
        Binding::Densities,
        Binding::Accelerations,
        Binding::Motions,
        Binding::Solves,
        Binding::Slots,
        Binding::CellCounts,
        Binding::CellStarts,
        Binding::Samples,
        Binding::Bodies,
        Binding::BodyInputs,
        Binding::BodySamples,
        Binding::BodySlots,
        Binding::SampleLoads,
        Binding::Spawned,
        Binding::WallFrictions,
        Binding::WallFaces,
        Binding::WallDensities,
        Binding::Drifts,
        Binding::Answers,
        Binding::Widths,
        Binding::Contacts,
        Binding::Histories,
        Binding::Places,
        Binding::Befores,
        Binding::BodiesBefore,
    ];

    /// Number in group 0.
    pub fn number(self) -> u32 {
        self as u32
    }

    /// Whether it is a uniform.
    pub fn is_uniform(self) -> bool {
        matches!(self, Binding::Parameters | Binding::Input | Binding::Command)
    }

    /// Name, in WGSL and in labels.
    pub fn name(self) -> &'static str {
        match self {
            Binding::Parameters => "parameters",
            Binding::Input => "input",
            Binding::Command => "command",
            Binding::Control => "control",
            Binding::Arguments => "arguments",
            Binding::Particles => "particles",
            Binding::Hits => "hits",
            Binding::SortedPositions => "sorted_positions",
            Binding::SortedVelocities => "sorted_velocities",
            Binding::SortedLives => "sorted_lives",
            Binding::Densities => "densities",
            Binding::Accelerations => "accelerations",
            Binding::Motions => "motions",
            Binding::Solves => "solves",
            Binding::Slots => "slots",
            Binding::CellCounts => "cell_counts",
            Binding::CellStarts => "cell_starts",
            Binding::Samples => "samples",
            Binding::Bodies => "bodies",
            Binding::BodyInputs => "body_inputs",
            Binding::BodySamples => "body_samples",
            Binding::BodySlots => "body_slots",
            Binding::SampleLoads => "sample_loads",
            Binding::Spawned => "spawned",
            Binding::WallFrictions => "wall_frictions",
            Binding::WallFaces => "wall_faces",
            Binding::WallDensities => "wall_densities",
            Binding::Drifts => "drifts",
            Binding::Answers => "answers",
            Binding::Widths => "widths",
            Binding::Contacts => "contacts",
            Binding::Histories => "histories",
            Binding::Places => "places",
            Binding::Befores => "befores",
            Binding::BodiesBefore => "bodies_before",
        }
    }

    /// Bytes of one particle's part, without that of plans with bodies, of histories the most, of states kept the least; none for buffers that do not hold particles.
    pub fn particle_bytes(self) -> Option<u64> {
        match self {
            Binding::Particles | Binding::Hits | Binding::Solves | Binding::Places => Some(32),
            Binding::SortedPositions
            | Binding::SortedVelocities
            | Binding::Accelerations
            | Binding::Motions
            | Binding::Contacts
            | Binding::Drifts => Some(16),
            Binding::Histories => Some(64),
            Binding::Befores => Some(36),
            Binding::Densities => Some(8),
            Binding::SortedLives | Binding::Slots | Binding::Widths => Some(4),
            _ => None,
        }
    }

    /// The binding whose memory this one has.
    pub fn memory(self) -> Self {
        if self == Binding::Hits { Binding::Particles } else { self }
    }

    fn element(self) -> &'static str {
        match self {
            Binding::Parameters => "Parameters",
            Binding::Input => "TickRecord",
            Binding::Command => "CommandRecord",
            Binding::Control => "StepControl",
            Binding::Arguments | Binding::Slots | Binding::CellStarts | Binding::BodySlots => "array<u32>",
            Binding::Particles => "array<ParticleRecord>",
            Binding::Hits => "array<array<u32, 8>>",
            Binding::SortedPositions | Binding::SortedVelocities | Binding::Motions | Binding::Samples => {
                "array<vec4<u32>>"
            }
            Binding::Solves | Binding::Befores => "array<u32>",
            Binding::SortedLives | Binding::Widths | Binding::Histories => "array<f32>",
            Binding::Densities => "array<vec2<f32>>",
            Binding::Accelerations => "array<AccelerationRecord>",
            Binding::WallFrictions | Binding::WallDensities => "array<vec2<f32>>",
            Binding::Drifts | Binding::WallFaces => "array<vec4<f32>>",
            Binding::CellCounts => "array<atomic<u32>>",
            Binding::Bodies | Binding::BodiesBefore => "array<BodyRecord>",
            Binding::BodyInputs => "array<BodyInputRecord>",
            Binding::BodySamples => "array<BodySampleRecord>",
            Binding::SampleLoads => "array<SampleLoadRecord>",
            Binding::Spawned => "array<SpawnRecord>",
            Binding::Answers => "array<BodyAnswerRecord>",
            Binding::Places => "array<PlaceRecord>",
            Binding::Contacts => "array<ContactRecord>",
        }
    }

    /// Whether WGSL wants it writable even where a pass only reads it: atomics.
    pub fn is_atomic(self) -> bool {
        matches!(self, Binding::Control | Binding::CellCounts | Binding::Answers)
    }

    /// Whether passes read it of every neighbour of a particle: four words each, in a buffer or in a texture.
    pub fn is_of_neighbours(self) -> bool {
        matches!(self, Binding::SortedPositions | Binding::SortedVelocities | Binding::Motions | Binding::Samples)
    }

    fn declaration(self, writes: bool, is_texture: bool) -> String {
        let (space, element) = match (self.is_uniform(), writes || self.is_atomic(), is_texture) {
            (_, false, true) => ("", "texture_storage_2d<rgba32uint, read>"),
            (_, true, true) => ("", "texture_storage_2d<rgba32uint, write>"),
            (true, _, _) => ("<uniform>", self.element()),
            (false, true, _) => ("<storage, read_write>", self.element()),
            (false, false, _) => ("<storage, read>", self.element()),
        };
        format!("@group(0) @binding({}) var{space} {}: {element};\n", self.number(), self.name())
    }

    /// Accessors of the four words.
    fn words(self, writes: bool, is_texture: bool) -> String {
        let name = self.name();
        let read = match is_texture {
            true => format!("textureLoad({name}, texel(i))"),
            false => format!("{name}[i]"),
        };
        let write = match is_texture {
            true => format!("textureStore({name}, texel(i), words)"),
            false => format!("{name}[i] = words"),
        };
        let reader = format!("fn {name}_words(i: u32) -> vec4<u32> {{ return {read}; }}\n");
        let writer = format!("fn set_{name}_words(i: u32, words: vec4<u32>) {{ {write}; }}\n");
        match (writes, is_texture) {
            (false, _) => reader,
            (true, false) => reader + &writer,
            (true, true) => writer,
        }
    }

    fn readers(self) -> &'static str {
        match self {
            Binding::Parameters | Binding::Input | Binding::Command | Binding::Control | Binding::Arguments => "",
            Binding::Particles => {
                "fn position(i: u32) -> vec3<f32> { return particles[i].position; }
fn id(i: u32) -> u32 { return particles[i].id; }
fn velocity(i: u32) -> vec3<f32> { return particles[i].velocity; }
fn remaining_life(i: u32) -> f32 { return particles[i].remaining_life; }
"
            }
            Binding::Hits => "fn hits_of(i: u32, word: u32) -> u32 { return hits[i][word]; }\n",
            Binding::SortedPositions => {
                "fn sorted_position(i: u32) -> vec3<f32> { return bitcast<vec3<f32>>(sorted_positions_words(i).xyz); }
fn sorted_id(i: u32) -> u32 { return sorted_positions_words(i).w; }
"
            }
            Binding::SortedVelocities => {
                "fn velocity_and_density(i: u32) -> vec4<f32> { return bitcast<vec4<f32>>(sorted_velocities_words(i)); }
"
            }
            Binding::SortedLives => "fn sorted_remaining_life(i: u32) -> f32 { return sorted_lives[i]; }\n",
            Binding::Densities => {
                "fn density(i: u32) -> f32 { return densities[i].x; }
fn pressure_term(i: u32) -> f32 { return densities[i].y; }
"
            }
            Binding::Accelerations => {
                "fn acceleration(i: u32) -> vec3<f32> { return accelerations[i].acceleration; }
fn velocity_before(i: u32) -> vec3<f32> { return accelerations[i].acceleration; }
fn hits_of_own_row(i: u32) -> u32 { return accelerations[i].own_row; }
"
            }
            Binding::Motions => "fn motion(i: u32) -> vec3<f32> { return bitcast<vec3<f32>>(motions_words(i).xyz); }\n",
            // The pressures first: they stay from tick to tick, also in larger buffers. In their order of the last sort they
            // are where changes come later.
            Binding::Solves => {
                "fn solve_word(section: u32, i: u32) -> u32 { return section * (arrayLength(&solves) / #{SOLVE_WORDS}u) + i; }
fn solved_pressure(i: u32) -> f32 { return bitcast<f32>(solves[i]); }
fn sorted_pressure(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(1u, i)]); }
fn change(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(1u, i)]); }
fn stepped(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(2u, i)]); }
fn source(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(3u, i)]); }
fn left(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(4u, i)]); }
fn inverse_diagonal(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(5u, i)]); }
fn taken(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(6u, i)]); }
fn own_row(i: u32) -> u32 { return solves[solve_word(7u, i)]; }
fn touch(i: u32) -> u32 { return solves[solve_word(8u, i)]; }
fn stiffness(i: u32) -> f32 { return bitcast<f32>(solves[solve_word(9u, i)]); }
"
            }
            Binding::Slots => "fn slot(i: u32) -> u32 { return slots[i]; }\n",
            Binding::CellCounts => "fn cell_count(i: u32) -> u32 { return atomicLoad(&cell_counts[i]); }\n",
            Binding::CellStarts => "fn cell_start(i: u32) -> u32 { return cell_starts[i]; }\n",
            Binding::Samples => {
                "struct Sample { position: vec3<f32>, weight: f32, viscous_weight: f32 }
fn sample(k: u32) -> Sample {
    let words = bitcast<vec4<f32>>(samples_words(k));
    return Sample(words.xyz, abs(words.w), max(-words.w, 0.0));
}
fn wall_velocity(k: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(samples_words(parameters.wall_samples + k).xyz);
}
fn sample_pressure(k: u32) -> f32 { return bitcast<f32>(samples_words(parameters.body_samples + k).x); }
struct SampleArm { offset: vec3<f32>, body: u32 }
fn sample_arm(k: u32) -> SampleArm {
    let words = samples_words(parameters.body_samples + k);
    return SampleArm(bitcast<vec3<f32>>(words.xyz), words.w);
}
"
            }
            Binding::WallFrictions => "fn wall_friction(k: u32) -> vec2<f32> { return wall_frictions[k]; }\n",
            Binding::Places => {
                "fn place(i: u32) -> vec3<f32> { return places[i].place; }
fn push(i: u32) -> f32 { return places[i].push; }
fn sum_of_pushes(i: u32) -> f32 { return places[i].sum; }
fn stepped_push(i: u32) -> f32 { return places[i].stepped; }
fn push_diagonal(i: u32) -> f32 { return places[i].diagonal; }
fn place_own_row(i: u32) -> u32 { return places[i].own_row; }
"
            }
            Binding::Befores => "fn before(i: u32, word: u32) -> u32 { return befores[i * #{BEFORE_WORDS}u + word]; }\n",
            Binding::BodiesBefore => "",
            Binding::WallFaces => "fn wall_face(k: u32) -> vec4<f32> { return wall_faces[k]; }\n",
            Binding::WallDensities => {
                "fn wall_own_density(k: u32) -> f32 { return wall_densities[k].x; }
fn wall_pressure(k: u32) -> f32 { return wall_densities[k].y; }
"
            }
            Binding::Drifts => "fn drift(i: u32) -> vec3<f32> { return drifts[i].xyz; }\n",
            Binding::Widths => "fn width(i: u32) -> f32 { return widths[i]; }\n",
            Binding::Histories => {
                "fn history_place(order: u32, i: u32, word: u32) -> u32 {
    return order * (arrayLength(&histories) / 2u) + i * #{HISTORY_WORDS}u + word;
}
fn history(i: u32, word: u32) -> f32 { return histories[history_place(0u, i, word)]; }
fn sorted_history(i: u32, word: u32) -> f32 { return histories[history_place(1u, i, word)]; }
fn excess(i: u32) -> f32 { return history(i, #{PAST_WORDS}u); }
fn excess_before(i: u32) -> f32 { return sorted_history(i, #{PAST_WORDS}u); }
"
            }
            Binding::Contacts => {
                "fn contact_force(i: u32) -> vec3<f32> { return contacts[i].force; }
fn contact_body(i: u32) -> u32 { return contacts[i].body; }
"
            }
            Binding::Bodies => {
                "fn body_position(i: u32) -> vec3<f32> { return bodies[i].position; }
fn body_rotation(i: u32) -> vec4<f32> { return bodies[i].rotation; }
fn body_linear_velocity(i: u32) -> vec3<f32> { return bodies[i].linear_velocity; }
fn body_angular_velocity(i: u32) -> vec3<f32> { return bodies[i].angular_velocity; }
fn body_inverse_mass(i: u32) -> f32 { return bodies[i].inverse_mass; }
fn body_inverse_inertia(i: u32) -> mat3x3<f32> {
    return mat3x3<f32>(bodies[i].inertia_x, bodies[i].inertia_y, bodies[i].inertia_z);
}
fn body_acceleration(i: u32) -> vec3<f32> { return bodies[i].acceleration; }
fn body_first_sample(i: u32) -> u32 { return bodies[i].first_sample; }
fn body_sample_count(i: u32) -> u32 { return bodies[i].sample_count; }
fn body_force(i: u32) -> vec3<f32> { return bodies[i].force; }
fn body_torque(i: u32) -> vec3<f32> { return bodies[i].torque; }
fn body_reach(i: u32) -> f32 { return bodies[i].reach; }
fn body_is_placed(i: u32) -> bool { return bodies[i].is_placed != 0u; }
fn body_drift(i: u32) -> vec3<f32> { return bodies[i].drift; }
fn body_turn(i: u32) -> vec3<f32> { return bodies[i].turn; }
fn body_swollen(i: u32) -> f32 { return bodies[i].swollen; }
fn body_swelling_reach(i: u32) -> f32 { return bodies[i].swelling_reach; }
fn body_wetted(i: u32) -> u32 { return bodies[i].wetted; }
fn body_friction(i: u32) -> vec2<f32> { return vec2<f32>(bodies[i].friction_at_rest, bodies[i].friction_sliding); }
fn body_exchange(i: u32, slot: u32) -> ExchangeRecord { return bodies[i].exchanges[slot]; }
"
            }
            Binding::BodyInputs => "fn body_input(i: u32) -> BodyInputRecord { return body_inputs[i]; }\n",
            Binding::BodySamples => {
                "fn sample_offset(k: u32) -> vec3<f32> { return body_samples[k].offset; }
fn sample_root(k: u32) -> vec3<f32> { return body_samples[k].root; }
fn sample_volume(k: u32) -> f32 { return body_samples[k].volume; }
fn sample_own_density(k: u32) -> f32 { return body_samples[k].own_density; }
fn body_of_sample(k: u32) -> u32 { return body_samples[k].body; }
"
            }
            Binding::BodySlots => "fn body_slot(i: u32) -> u32 { return body_slots[i]; }\n",
            Binding::SampleLoads => {
                "fn sample_force(k: u32) -> vec3<f32> { return sample_loads[k].force; }
fn sample_torque(k: u32) -> vec3<f32> { return sample_loads[k].torque; }
fn sample_wet(k: u32) -> f32 { return sample_loads[k].wet; }
"
            }
            Binding::Spawned => {
                "fn spawned_position(i: u32) -> vec3<f32> { return spawned[i].position; }
fn spawned_velocity(i: u32) -> vec3<f32> { return spawned[i].velocity; }
fn spawned_life(i: u32) -> f32 { return spawned[i].lifetime; }
fn spawned_age(i: u32) -> f32 { return spawned[i].age; }
"
            }
            Binding::Answers => {
                "fn answer_linear(i: u32) -> vec3<f32> { return answers[i].linear; }
fn answer_angular(i: u32) -> vec3<f32> { return answers[i].angular; }
fn answer_force(i: u32) -> vec3<f32> { return answers[i].force; }
fn answer_torque(i: u32) -> vec3<f32> { return answers[i].torque; }
fn touching(i: u32) -> u32 { return atomicLoad(&answers[i].touching); }
fn sum_of_sizes(i: u32) -> f32 {
    return f32(atomicLoad(&answers[i].sizes_high)) * 4294967296.0 + f32(atomicLoad(&answers[i].sizes_low));
}
"
            }
        }
    }

    fn writers(self) -> &'static str {
        match self {
            Binding::Arguments => {
                "fn set_arguments(dispatch: u32, groups: vec3<u32>) {
    arguments[3u * dispatch] = groups.x;
    arguments[3u * dispatch + 1u] = groups.y;
    arguments[3u * dispatch + 2u] = groups.z;
}
fn set_instances(count: u32) {
    arguments[#{ARGUMENTS_DRAW}u] = 4u;
    arguments[#{ARGUMENTS_DRAW}u + 1u] = count;
    arguments[#{ARGUMENTS_DRAW}u + 2u] = 0u;
    arguments[#{ARGUMENTS_DRAW}u + 3u] = 0u;
}
"
            }
            Binding::Particles => {
                "fn set_particle(i: u32, x: vec3<f32>, particle: u32, v: vec3<f32>, life: f32) {
    particles[i] = ParticleRecord(x, particle, v, life);
}
fn set_remaining_life(i: u32, life: f32) { particles[i].remaining_life = life; }
"
            }
            Binding::Hits => "fn set_hits(i: u32, word: u32, value: u32) { hits[i][word] = value; }\n",
            Binding::SortedPositions => {
                "fn set_sorted_position(i: u32, x: vec3<f32>, particle: u32) {
    set_sorted_positions_words(i, vec4<u32>(bitcast<vec3<u32>>(x), particle));
}
"
            }
            Binding::SortedVelocities => {
                "fn set_velocity_and_density(i: u32, v: vec3<f32>, value: f32) {
    set_sorted_velocities_words(i, bitcast<vec4<u32>>(vec4<f32>(v, value)));
}
"
            }
            Binding::SortedLives => "fn set_sorted_remaining_life(i: u32, life: f32) { sorted_lives[i] = life; }\n",
            Binding::Densities => {
                "fn set_density(i: u32, value: f32, term: f32) { densities[i] = vec2<f32>(value, term); }\n"
            }
            Binding::Accelerations => {
                "fn set_acceleration(i: u32, a: vec3<f32>) { accelerations[i].acceleration = a; }
fn set_velocity_before(i: u32, v: vec3<f32>) { accelerations[i].acceleration = v; }
fn set_hits_of_own_row(i: u32, value: u32) { accelerations[i].own_row = value; }
"
            }
            Binding::Motions => {
                "fn set_motion(i: u32, a: vec3<f32>) {
    set_motions_words(i, bitcast<vec4<u32>>(vec4<f32>(a, 0.0)));
}
"
            }
            Binding::Solves => {
                "fn set_solved_pressure(i: u32, value: f32) { solves[i] = bitcast<u32>(value); }
fn set_sorted_pressure(i: u32, value: f32) { solves[solve_word(1u, i)] = bitcast<u32>(value); }
fn set_change(i: u32, value: f32) { solves[solve_word(1u, i)] = bitcast<u32>(value); }
fn set_stepped(i: u32, value: f32) { solves[solve_word(2u, i)] = bitcast<u32>(value); }
fn set_source(i: u32, value: f32) { solves[solve_word(3u, i)] = bitcast<u32>(value); }
fn set_left(i: u32, value: f32) { solves[solve_word(4u, i)] = bitcast<u32>(value); }
fn set_inverse_diagonal(i: u32, value: f32) { solves[solve_word(5u, i)] = bitcast<u32>(value); }
fn set_taken(i: u32, value: f32) { solves[solve_word(6u, i)] = bitcast<u32>(value); }
fn set_own_row(i: u32, value: u32) { solves[solve_word(7u, i)] = value; }
fn set_touch(i: u32, value: u32) { solves[solve_word(8u, i)] = value; }
fn set_stiffness(i: u32, value: f32) { solves[solve_word(9u, i)] = bitcast<u32>(value); }
"
            }
            Binding::Slots => "fn set_slot(i: u32, particle: u32) { slots[i] = particle; }\n",
            Binding::CellCounts => {
                "fn add_to_cell_count(i: u32, n: u32) { atomicAdd(&cell_counts[i], n); }
fn take_from_cell_count(i: u32) -> u32 { return atomicSub(&cell_counts[i], 1u) - 1u; }
"
            }
            Binding::WallDensities => "fn set_wall_pressure(k: u32, term: f32) { wall_densities[k].y = term; }\n",
            Binding::CellStarts => "fn set_cell_start(i: u32, start: u32) { cell_starts[i] = start; }\n",
            Binding::Samples => {
                "fn set_sample(k: u32, value: vec4<f32>) { set_samples_words(k, bitcast<vec4<u32>>(value)); }
fn set_sample_pressure(k: u32, value: f32) {
    set_samples_words(parameters.body_samples + k, vec4<u32>(bitcast<u32>(value), 0u, 0u, 0u));
}
fn set_sample_arm(k: u32, offset: vec3<f32>, body: u32) {
    set_samples_words(parameters.body_samples + k, vec4<u32>(bitcast<vec3<u32>>(offset), body));
}
"
            }
            Binding::Bodies => {
                "fn start_body(i: u32, given: BodyInputRecord) {
    bodies[i].inverse_mass = given.inverse_mass;
    bodies[i].inertia_x = given.inertia_x;
    bodies[i].inertia_y = given.inertia_y;
    bodies[i].inertia_z = given.inertia_z;
    bodies[i].acceleration = given.acceleration;
    bodies[i].is_placed = 1u;
    bodies[i].impulse_linear = vec3<f32>(0.0);
    bodies[i].impulse_angular = vec3<f32>(0.0);
}
fn restore_body(i: u32) { bodies[i] = bodies_before[i]; }
fn set_body_pose(i: u32, x: vec3<f32>, q: vec4<f32>) { bodies[i].position = x; bodies[i].rotation = q; }
fn set_body_velocity(i: u32, v: vec3<f32>, w: vec3<f32>) { bodies[i].linear_velocity = v; bodies[i].angular_velocity = w; }
fn set_body_drift(i: u32, v: vec3<f32>, w: vec3<f32>) { bodies[i].drift = v; bodies[i].turn = w; }
fn set_body_load(i: u32, f: vec3<f32>, t: vec3<f32>) { bodies[i].force = f; bodies[i].torque = t; }
fn set_body_swollen(i: u32, share: f32) { bodies[i].swollen = share; }
fn set_body_wetted(i: u32, count: u32) { bodies[i].wetted = count; }
fn set_body_exchange(i: u32, slot: u32, tick_plus_one: vec2<u32>, linear: vec3<f32>, angular: vec3<f32>) {
    bodies[i].exchanges[slot].linear = linear;
    bodies[i].exchanges[slot].angular = angular;
    bodies[i].exchanges[slot].tick_plus_one = tick_plus_one;
}
fn add_body_impulse(i: u32, slot: u32, linear: vec3<f32>, angular: vec3<f32>) {
    bodies[i].impulse_linear += linear;
    bodies[i].impulse_angular += angular;
    bodies[i].exchanges[slot].linear += linear;
    bodies[i].exchanges[slot].angular += angular;
}
"
            }
            Binding::Contacts => {
                "fn set_contact(i: u32, body: u32, force: vec3<f32>) { contacts[i] = ContactRecord(force, body); }
"
            }
            Binding::Histories => {
                "fn set_history(i: u32, word: u32, value: f32) { histories[history_place(0u, i, word)] = value; }
fn set_excess(i: u32, value: f32) { set_history(i, #{PAST_WORDS}u, value); }
fn set_sorted_history(i: u32, word: u32, value: f32) { histories[history_place(1u, i, word)] = value; }
"
            }
            Binding::Widths => "fn set_width(i: u32, value: f32) { widths[i] = value; }\n",
            Binding::Places => {
                "fn begin_place(i: u32, x: vec3<f32>, hits_there: u32) { places[i] = PlaceRecord(x, 0.0, 0.0, hits_there, 0.0, 0.0); }
fn set_place(i: u32, x: vec3<f32>) { places[i].place = x; }
fn set_push(i: u32, value: f32) {
    places[i].push = value;
    places[i].sum += value;
}
fn set_push_diagonal(i: u32, value: f32) { places[i].diagonal = value; }
fn set_next_push(i: u32, stepped: f32, next: f32) {
    places[i].stepped = stepped;
    places[i].sum = next;
}
fn take_next_push(i: u32) { places[i].push = places[i].sum; }
fn take_stepped_push(i: u32) {
    places[i].push = places[i].stepped;
    places[i].sum = places[i].stepped;
}
"
            }
            Binding::Befores => {
                "fn set_before(i: u32, word: u32, value: u32) { befores[i * #{BEFORE_WORDS}u + word] = value; }\n"
            }
            Binding::BodiesBefore => "fn keep_body(i: u32) { bodies_before[i] = bodies[i]; }\n",
            Binding::Drifts => "fn set_drift(i: u32, e: vec3<f32>) { drifts[i] = vec4<f32>(e, 0.0); }\n",
            Binding::BodySlots => "fn set_body_slot(i: u32, k: u32) { body_slots[i] = k; }\n",
            Binding::SampleLoads => {
                "fn set_sample_load(k: u32, f: vec3<f32>, t: vec3<f32>, wet: f32) {
    sample_loads[k] = SampleLoadRecord(f, wet, t, 0.0);
}
"
            }
            Binding::Answers => {
                "fn begin_answer(i: u32, moves: bool) {
    answers[i].moves = select(0u, 1u, moves);
    set_answer(i, vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
    atomicStore(&answers[i].touching, 0u);
    atomicStore(&answers[i].sizes_low, 0u);
    atomicStore(&answers[i].sizes_high, 0u);
    atomicStore(&answers[i].left_low, 0u);
    atomicStore(&answers[i].left_high, 0u);
}
fn set_answer(i: u32, f: vec3<f32>, t: vec3<f32>, linear: vec3<f32>, angular: vec3<f32>) {
    answers[i].force = f;
    answers[i].torque = t;
    answers[i].linear = linear;
    answers[i].angular = angular;
}
fn add_touch(i: u32, units: u32) {
    atomicAdd(&answers[i].touching, 1u);
    let before = atomicAdd(&answers[i].sizes_low, units);
    if (before + units < before) {
        atomicAdd(&answers[i].sizes_high, 1u);
    }
}
fn add_body_left(i: u32, units: u32) {
    if (answers[i].moves == 0u) {
        return;
    }
    let before = atomicAdd(&answers[i].left_low, units);
    if (before + units < before) {
        atomicAdd(&answers[i].left_high, 1u);
    }
}
fn take_body_left(i: u32) -> vec2<u32> {
    return vec2<u32>(atomicExchange(&answers[i].left_low, 0u), atomicExchange(&answers[i].left_high, 0u));
}
"
            }
            _ => "",
        }
    }
}

/// The module `freshet::bindings` for a pass: structs, buffers or textures, accessors. Setters exist only for what it
/// writes; a texture that it writes it cannot read.
pub(crate) fn bindings_module(uses: &[(Binding, Access)], textures: bool) -> String {
    let mut text = format!("#define_import_path freshet::bindings\n\n{}\n", records::declarations());
    text +=
        &format!("fn texel(i: u32) -> vec2<u32> {{ return vec2<u32>(i % {TEXTURE_WIDTH}u, i / {TEXTURE_WIDTH}u); }}\n");
    for binding in Binding::ALL {
        let writes = uses.contains(&(binding, Access::Write));
        let is_texture = textures && binding.is_of_neighbours();
        text += &binding.declaration(writes, is_texture);
        if binding.is_of_neighbours() {
            text += &binding.words(writes, is_texture);
        }
        if !(is_texture && writes) {
            text += binding.readers();
        }
        if writes {
            text += binding.writers();
        }
    }
    text
}
