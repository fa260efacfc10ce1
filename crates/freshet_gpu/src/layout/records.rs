//! The structs that buffers hold. SI units, as in `freshet_core`.

use glam::{UVec3, Vec3};

use super::wgsl::{Atomic, wgsl_struct};

wgsl_struct! {
    /// Numbers that stay the same over many ticks: a uniform.
    pub struct Parameters {
        /// Number of cells along each axis minus one.
        cell_mask: UVec3,
        /// Number of cells; also the index of the cell of those that fall out.
        cells: u32,
        /// Lower corner of where particles may be, m.
        bounds_min: Vec3,
        /// 1 / H as the kernel uses it, 1/m.
        inverse_support_radius: f32,
        /// Upper corner of where particles may be, m.
        bounds_max: Vec3,
        /// H^2, m2.
        squared_support_radius: f32,
        /// One over the edge lengths of a cell, 1/m.
        inverse_cell_size: Vec3,
        /// Depth behind their face of wall samples that fluid sticks to, m.
        wall_depth: f32,
        /// Lower corner of cell zero, m.
        grid_origin: Vec3,
        /// Nearest a particle is taken to be to a face it sticks to, m.
        nearest_wall: f32,
        /// Cells in the widest support along each axis.
        cells_per_radius: Vec3,
        /// 2 mu G / G', Pa s: Morris' viscosity between particles.
        pair_viscosity: f32,
        /// Length of each period, m; zero for none.
        period: Vec3,
        /// mu, Pa s: between particles and walls, twice of it over their relative density if they are quasi-fluid.
        wall_viscosity: f32,
        /// One over it, 1/m; zero for none.
        inverse_period: Vec3,
        /// Widest support over H; 1 where all are the same.
        widest_support: f32,
        /// Lower ends of the periods, m.
        period_low: Vec3,
        /// Unused.
        pad_low: u32,
        /// Upper ends of the periods, m.
        period_high: Vec3,
        /// Binary logarithm of the number of cells along x.
        log_cells_x: u32,
        /// The same along x and y together.
        log_cells_xy: u32,
        /// m A / (S H^3): density from the fluid's kernel shapes.
        fluid_density_scale: f32,
        /// rho0 A / (S H^3): density from samples' kernel shapes times volumes.
        sample_density_scale: f32,
        /// m A / (G H^5): acceleration from the fluid's kernel slopes.
        fluid_force_scale: f32,
        /// 2 rho0 A / (G H^5): acceleration from samples' kernel slopes.
        sample_force_scale: f32,
        /// 2 m rho0 A / (G H^5): force on a sample.
        body_force_scale: f32,
        /// kg/m3.
        rest_density: f32,
        /// m3/kg.
        inverse_rest_density: f32,
        /// Factor of the equation of state: Pa for Tait's, m2/s2 for the others.
        stiffness: f32,
        /// Pressure at rest, Pa.
        reference_pressure: f32,
        /// Exponent of Tait's equation.
        exponent: f32,
        /// 2 alpha c h: artificial viscosity over twice the mean density.
        viscosity_scale: f32,
        /// 0.01 h^2, m2.
        viscosity_softening: f32,
        /// h, m.
        smoothing_length: f32,
        /// c, m/s.
        sound_speed: f32,
        /// Step over h / (c + v).
        courant_factor: f32,
        /// Step over sqrt(h / a).
        force_factor: f32,
        /// Longest step that viscosity and springs of walls allow, s.
        steady_limit: f32,
        /// Most time that one tick leaves to the next, s.
        longest_tick: f32,
        /// Most substeps in a tick.
        max_substeps: u32,
        /// Samples of walls; their velocities come after them, if some move.
        wall_samples: u32,
        /// Where the samples of bodies begin, behind those of walls.
        first_body_sample: u32,
        /// Samples of bodies.
        body_samples: u32,
        /// Bodies.
        bodies: u32,
        /// Where the counts of body samples begin in the table of counts.
        body_counts: u32,
        /// Where the starts of wall samples begin in the table of starts.
        wall_starts: u32,
        /// Where the starts of body samples begin in the table of starts.
        body_starts: u32,
        /// Where the totals of blocks begin in the table of starts.
        block_sums: u32,
        /// Fastest drift of a body to its place, m/s.
        expected_speed: f32,
        /// From further away it jumps, m.
        body_reach: f32,
        /// m A / (S H^5 rho0): rate of a relative density from the fluid's kernel slopes.
        rate_scale: f32,
        /// rho0 / m, 1/m3.
        number_density: f32,
        /// (m A / H^5)^2 / (S G rho0): `K` of an incompressible fluid from kernel slopes.
        diagonal_scale: f32,
        /// Least `K`.
        least_diagonal: f32,
        /// Of Jacobi steps.
        relaxation: f32,
        /// How far a particle of an incompressible fluid may go in a substep, m.
        longest_way: f32,
        /// Substep times sqrt(p/rho) up to which pressures hold particles in their places, m.
        pressure_limit: f32,
        /// Shortest substep that is solved, s.
        shortest_substep: f32,
        /// Mean compression at which density iterations end.
        compression: f32,
        /// Mean divergence at which divergence iterations of a fast flow end.
        divergence: f32,
        /// The same of a flow at rest.
        least_divergence: f32,
        /// Least momentum of Jacobi steps.
        least_momentum: f32,
        /// Lack of density of a fluid that is a little uneven.
        lack: f32,
        /// Share of it that is made up for in a slow flow.
        filling: f32,
        /// Most iterations of a solve.
        max_iterations: u32,
        /// 2 k/rho0 A_near/A: near pressure in units of the fluid's force scale.
        near_pressure: f32,
        /// 2 epsilon m A / (S H^3): XSPH from the fluid's kernel shapes over sums of densities.
        xsph_scale: f32,
        /// Of a product of sizes of touches, what bodies that answer add to `K`.
        stiffness_scale: f32,
        /// How fast samples of a body that swells go outwards, m/s.
        push_out_speed: f32,
        /// Up to which rate velocities correct a density beside it, 1/s.
        push_out_rate: f32,
        /// Up to which rate velocities correct a density too large, 1/s.
        by_velocity_rate: f32,
        /// Farthest that positions are corrected in a substep, m.
        longest_correction: f32,
        /// How far they go in a substep in which they reach no particle, m.
        swelling_way: f32,
        /// From this far on a body that jumps is elsewhere, m.
        elsewhere: f32,
        /// kg.
        particle_mass: f32,
        /// 2 mu d: what a sample of a body is dragged by, N s/m.
        sample_drag: f32,
        /// Least `rho/rho0 - 1` that particles carry.
        least_excess: f32,
        /// What the position-based solver adds to `K`.
        softness: f32,
        /// d, m: of walls that push by themselves.
        wall_spacing: f32,
        /// How hard they push: m2/s2, of a spring 1/s2.
        wall_strength: f32,
        /// How much a spring takes of velocities, 1/s.
        wall_damping: f32,
        /// Share of the speed into a wall that comes back.
        wall_bounce: f32,
        /// Monaghan's epsilon against clumping.
        tensile_correction: f32,
        /// One over the kernel's shape at a spacing.
        inverse_shape: f32,
        /// Along this walls stop particles, if they do it one way only.
        wall_way: Vec3,
        /// Share of the speed along a wall that stays.
        wall_slip: f32,
        /// How far sound of a pressure-corrected fluid goes in a substep at most, m.
        longest_sound: f32,
        /// The least that neighbours count for in the mean of their pressures, relative density.
        fewest_around: f32,
        /// 2 m A / (S H^5): weights of a Poisson equation from kernel slopes, with the other sign.
        poisson_scale: f32,
        /// Density of a free surface, kg/m3.
        surface_density: f32,
        /// Density of quasi-fluid walls over the fluid's.
        wall_relative_density: f32,
        /// Depth behind their face of bodies' samples, m.
        body_depth: f32,
        /// mu, Pa s: between particles and bodies.
        body_viscosity: f32,
        /// How near a particle has to be to a sample to be held by its plane, m.
        wall_reach: f32,
    }

    /// What the GPU decides from substep to substep, and what it reports.
    pub struct StepControl {
        /// In this tick, m/s2.
        gravity: Vec3,
        /// Length of the substep, s.
        substep: f32,
        /// Time the tick is to cover, with what the last left over, s.
        asked: f32,
        /// Time of it not covered yet, s.
        remaining: f32,
        /// Shortest substep of the tick, s.
        smallest_substep: f32,
        /// Largest mean compression of the tick's substeps.
        mean_compression: f32,
        /// Largest speed of a particle in the last substep, m/s.
        fastest: f32,
        /// 1 if another substep follows, else 0.
        going: u32,
        /// Substeps made in this tick.
        substeps: u32,
        /// Particles in the buffers of the state, those included that fall out in the next sort.
        count: u32,
        /// Particles that the last sort kept.
        live: u32,
        /// The id the next particle gets.
        next_id: u32,
        /// Particles not spawned in this tick.
        refused: u32,
        /// The tick's number modulo four.
        tick_slot: u32,
        /// Particles removed in this tick.
        removed: Atomic,
        /// Particles retired in this tick.
        retired: Atomic,
        /// Bits of the largest speed in this substep.
        max_speed: Atomic,
        /// Bits of the largest acceleration in this substep.
        max_acceleration: Atomic,
        /// Bits of the largest density over rest density in this tick.
        max_ratio: Atomic,
        /// Sum of compressions in this substep in units of 2^-20, lower half.
        compression_low: Atomic,
        /// Its upper half.
        compression_high: Atomic,
        /// Simulated time before this tick, in units of 2^-24 s, from zero again after 256 s: differences are what counts.
        clock: u32,
        /// Length of the last substep that was solved, s; zero if there was none.
        last_substep: f32,
        /// Share of a density too large that velocities correct.
        share: f32,
        /// Mean divergence at which this substep's iterations end.
        divergence: f32,
        /// What is to be multiplied with the solve's accelerations for the way that corrects positions, s2.
        correction: f32,
        /// Where the substep is, see `library/solve.wgsl`.
        solve_phase: u32,
        /// Iterations of the solve so far.
        iterations: u32,
        /// Nesterov's `t`.
        pace: f32,
        /// What the iteration before left.
        last_left: f32,
        /// Share of the last step that is taken again.
        momentum: f32,
        /// Iterations of divergence solves in this tick.
        divergence_iterations: u32,
        /// Iterations of density solves in this tick.
        density_iterations: u32,
        /// The most of a divergence solve in this tick.
        most_divergence: u32,
        /// The most of a density solve in this tick.
        most_density: u32,
        /// Solves of this tick that ended before they were as exact as asked for.
        unsolved: u32,
        /// Bits of the largest `p / rho^2` in this substep.
        max_pressure: Atomic,
        /// Sum of what an iteration left, in units of 2^-30, lower half.
        left_low: Atomic,
        /// Its upper half.
        left_high: Atomic,
        /// How far ahead of the end of the substep the velocities are that particles move with, s.
        lead: f32,
        /// Those of the removed that were not finite.
        not_finite: Atomic,
        /// What Poisson solves of this tick left at most of what they began with.
        residual: f32,
        /// Of plans that make substeps again: 1 if the last substep is still to be judged by the state it left, else 0.
        judged_next: u32,
        /// How often the substep that is made now has been taken back.
        redos: u32,
        /// Length with which it is made again, s; zero for one that is not.
        redo_substep: f32,
        /// Substeps taken back in this tick.
        redone: u32,
        /// Bits of the largest speed of the state, where another one is in `max_speed`.
        state_speed: Atomic,
        /// What the fields of these names were when the substep began.
        remaining_before: f32,
        /// Likewise.
        smallest_before: f32,
        /// Likewise.
        last_before: f32,
        /// Likewise.
        live_before: u32,
        /// Likewise.
        removed_before: u32,
        /// Likewise.
        retired_before: u32,
        /// Likewise.
        not_finite_before: u32,
        /// Likewise, of `max_ratio`.
        ratio_before: u32,
        /// Unused.
        pad_b: u32,
        /// Unused.
        pad_c: u32,
        /// Unused.
        pad_d: u32,
    }

    /// What a tick is told.
    pub struct TickRecord {
        /// m/s2.
        gravity: Vec3,
        /// s.
        duration: f32,
        /// The tick's number, lower half first.
        tick: [u32; 2],
        /// The number after it.
        tick_plus_one: [u32; 2],
        /// Where the tick's bodies begin in the ring of body inputs.
        first_body: u32,
        /// Unused.
        pad_a: u32,
        /// Unused.
        pad_b: [u32; 2],
    }

    /// One command.
    pub struct CommandRecord {
        /// Lower corner of a box, m.
        low: Vec3,
        /// First id, or first particle in the upload.
        first: u32,
        /// Upper corner of a box, m.
        high: Vec3,
        /// How many ids or particles.
        count: u32,
        /// Most particles there may be.
        capacity: u32,
        /// 1 if the ages of the particles to spawn count, else 0.
        timed: u32,
        /// What the control's clock was when those were their ages.
        clock: u32,
        /// Unused.
        pad: u32,
    }

    /// The state of a particle.
    pub struct ParticleRecord {
        /// m.
        position: Vec3,
        /// Stable number.
        id: u32,
        /// m/s.
        velocity: Vec3,
        /// Time until it is retired, s; infinite for never.
        remaining_life: f32,
    }

    /// What moves a particle.
    pub struct AccelerationRecord {
        /// m/s2. Scratch between the sort and the density pass: the velocity, m/s.
        acceleration: Vec3,
        /// Scratch: which candidates of its own row are neighbours, see `library/hits.wgsl`.
        own_row: u32,
    }

    /// A particle to spawn.
    pub struct SpawnRecord {
        /// m.
        position: Vec3,
        /// s.
        lifetime: f32,
        /// m/s.
        velocity: Vec3,
        /// Time since it was at its position, s; negative if it will be there.
        age: f32,
    }

    /// A sample of a body, as planned.
    pub struct BodySampleRecord {
        /// From the centre of mass in the body's frame, m.
        offset: Vec3,
        /// Weight, m3.
        volume: f32,
        /// Where it swells from, likewise.
        root: Vec3,
        /// Whose it is.
        body: u32,
        /// What its body's own samples add to its density, over the density at rest; negative for samples of a single layer.
        own_density: f32,
        /// Unused.
        pad_a: u32,
        /// Unused.
        pad_b: [u32; 2],
    }

    /// What the fluid does to a sample.
    pub struct SampleLoadRecord {
        /// N.
        force: Vec3,
        /// One if a particle is within the support radius, otherwise zero.
        wet: f32,
        /// About the body's centre of mass, N m.
        torque: Vec3,
        /// Unused.
        pad_a: f32,
    }

    /// A particle that is moved apart from others.
    pub struct PlaceRecord {
        /// Where it has been moved to, m.
        place: Vec3,
        /// `dt^2 P` of an iteration.
        push: f32,
        /// Sum of these; of a Poisson equation that of the next.
        sum: f32,
        /// Neighbours in its own row, as the density pass left them.
        own_row: u32,
        /// Of a Poisson equation: what the last step came to, before momentum.
        stepped: f32,
        /// Its diagonal, zero at a free surface.
        diagonal: f32,
    }

    /// What of a particle sticks to a body or rubs on it.
    pub struct ContactRecord {
        /// Force on the body over the sum of `V_k F`, N/m3 in the units of kernel slopes.
        force: Vec3,
        /// Which body, counted from one; zero for none.
        body: u32,
    }

    /// What passed between the fluid and a body in one tick, minus what was forecast.
    pub struct ExchangeRecord {
        /// N s.
        linear: Vec3,
        /// Unused.
        pad_a: f32,
        /// N m s.
        angular: Vec3,
        /// Unused.
        pad_b: f32,
        /// Number of the tick plus one, lower half first; zero for none.
        tick_plus_one: [u32; 2],
        /// Unused.
        pad_c: [u32; 2],
    }

    /// A body at the start of a tick, as its engine knows it.
    pub struct BodyInputRecord {
        /// m.
        position: Vec3,
        /// 1/kg.
        inverse_mass: f32,
        /// Unit quaternion.
        rotation: [f32; 4],
        /// m/s.
        linear_velocity: Vec3,
        /// Whether displacements are corrected.
        is_free: u32,
        /// rad/s.
        angular_velocity: Vec3,
        /// Whether it has been put at `position` since the last tick.
        is_put: u32,
        /// First column of the inverse inertia, 1/(kg m2).
        inertia_x: Vec3,
        /// Whether it is wholly there at once.
        is_whole: u32,
        /// Second column.
        inertia_y: Vec3,
        /// Unused.
        pad_b: u32,
        /// Third column.
        inertia_z: Vec3,
        /// Unused.
        pad_c: u32,
        /// m/s2.
        acceleration: Vec3,
        /// Unused.
        pad_d: u32,
        /// N s.
        forecast_linear: Vec3,
        /// Unused.
        pad_e: u32,
        /// N m s.
        forecast_angular: Vec3,
        /// Unused.
        pad_f: u32,
        /// The engine has been corrected for all ticks before this one.
        corrected_before: [u32; 2],
        /// Unused.
        pad_g: [u32; 2],
    }

    /// A body during a tick.
    pub struct BodyRecord {
        /// m.
        position: Vec3,
        /// 1/kg.
        inverse_mass: f32,
        /// Unit quaternion.
        rotation: [f32; 4],
        /// m/s.
        linear_velocity: Vec3,
        /// Number of its first sample.
        first_sample: u32,
        /// rad/s.
        angular_velocity: Vec3,
        /// Number of its samples.
        sample_count: u32,
        /// First column of the inverse inertia in world axes, kept from the tick's start, 1/(kg m2).
        inertia_x: Vec3,
        /// Whether a tick has left it at `position`.
        is_placed: u32,
        /// Second column.
        inertia_y: Vec3,
        /// The largest distance of a sample from the centre of mass, m.
        reach: f32,
        /// Third column.
        inertia_z: Vec3,
        /// Samples that the fluid reaches in this substep.
        wetted: u32,
        /// From everything but the fluid, m/s2.
        acceleration: Vec3,
        /// How far it has swollen, 0 to 1.
        swollen: f32,
        /// Of the fluid in this substep, N.
        force: Vec3,
        /// The largest distance of a sample from where it swells from, m.
        swelling_reach: f32,
        /// Of the fluid in this substep, N m.
        torque: Vec3,
        /// Coefficient of friction of what sticks.
        friction_at_rest: f32,
        /// Of the fluid in this tick so far, N s.
        impulse_linear: Vec3,
        /// Coefficient of friction of what slides.
        friction_sliding: f32,
        /// Of the fluid in this tick so far, N m s.
        impulse_angular: Vec3,
        /// Unused.
        pad_h: u32,
        /// Velocity from where the last tick left it to where it should be, m/s.
        drift: Vec3,
        /// Unused.
        pad_i: u32,
        /// The same for its orientation, rad/s.
        turn: Vec3,
        /// Unused.
        pad_j: u32,
        /// The last four ticks, at their number modulo four.
        exchanges: [ExchangeRecord; 4],
    }

    /// How a body answers to the divergence solve of an incompressible fluid.
    pub struct BodyAnswerRecord {
        /// Acceleration by the change of pressures that an iteration is about, m/s2.
        linear: Vec3,
        /// 1 if forces move it, else 0.
        moves: u32,
        /// The same about its centre of mass, rad/s2.
        angular: Vec3,
        /// Particles that touch it.
        touching: Atomic,
        /// By the change of pressures, N.
        force: Vec3,
        /// Sum of the sizes of touches, in units of its own, lower half; see `library/touch.wgsl`.
        sizes_low: Atomic,
        /// By the change of pressures, about its centre of mass, N m.
        torque: Vec3,
        /// Upper half.
        sizes_high: Atomic,
        /// Sum of what an iteration left around it, in units of 2^-30, lower half.
        left_low: Atomic,
        /// Its upper half.
        left_high: Atomic,
        /// Unused.
        pad: [u32; 2],
    }
}
