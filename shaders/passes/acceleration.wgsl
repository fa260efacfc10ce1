// a_a = g - (1/G) [ m sum_b (P_a + P_b + Pi_ab) F x_ab + rho0 sum_k V_k (P_a + Pi_ak) F x_ak ] + Morris' viscosity
// and, where the plan has a near pressure, -(m/G) sum_b (2 k/rho0) F_near x_ab (freshet_core::near_pressure).
// Samples of quasi-fluid walls and bodies have a pressure of their own: P_a + P_k.
// P_a of an incompressible fluid is that of the last substep.
// Pressure form: Monaghan 1992, eq. 3.3, or that of Mueller et al. 2003. Pi_ab: Monaghan 1992, eq. 4.1, with beta = 0, for all pairs (Monaghan 2005).
// Where supports vary, pairs of the fluid have the mean of both (freshet_core::variable_support).
// Pi_ak is that of a particle at rest with the density of a, for samples of viscous faces only; Morris' viscosity acts there in
// its stead. The b come from the bits that the density pass left, see library/hits.wgsl.

#import freshet::bindings as fields
#import freshet::equation_of_state
#import freshet::grid
#import freshet::hits
#import freshet::pressure_kernels
#import freshet::threads
#import freshet::viscosity_kernels

#ifdef INCOMPRESSIBLE
var<workgroup> group_speed: atomic<u32>;
var<workgroup> group_pressure: atomic<u32>;
#else
var<workgroup> group_acceleration: atomic<u32>;
#endif

// What every pair of a particle needs: of the particle itself, and of the uniforms, see grid::Shape.
struct Own {
    position: vec3<f32>,
    pressure_term: f32,
    inverse_radius: f32,
#ifdef PAIR_VELOCITIES
    velocity: vec3<f32>,
    density: f32,
    softening: f32,
#endif
#ifdef ARTIFICIAL_VISCOSITY
    artificial_scale: f32,
#endif
#ifdef MORRIS_VISCOSITY
    pair_viscosity: f32,
#endif
#ifdef NEAR_PRESSURE
    near_pressure: f32,
#endif
#ifdef TENSILE_CORRECTION
    tensile_correction: f32,
    inverse_shape: f32,
#endif
#ifdef WIDTHS
    width: f32,
#endif
}

#ifdef INCOMPRESSIBLE
fn pressure_term(i: u32, density: f32) -> f32 {
    return fields::sorted_pressure(i);
}
#else ifdef MOVED_APART
// What pressures do is done.
fn pressure_term(i: u32, density: f32) -> f32 {
    return 0.0;
}
#else
#ifdef PAIR_VELOCITIES
// Follows from the density, which comes with the velocity.
fn pressure_term(i: u32, density: f32) -> f32 {
    return equation_of_state::pressure_term(density);
}
#else
fn pressure_term(i: u32, density: f32) -> f32 {
    return fields::pressure_term(i);
}
#endif
#endif

fn own_of(a: u32) -> Own {
    var own: Own;
    own.position = fields::sorted_position(a);
    own.inverse_radius = fields::parameters.inverse_support_radius;
#ifdef PAIR_VELOCITIES
    let motion = fields::velocity_and_density(a);
    own.pressure_term = pressure_term(a, motion.w);
    own.velocity = motion.xyz;
    own.density = motion.w;
    own.softening = fields::parameters.viscosity_softening;
#else
    own.pressure_term = pressure_term(a, 0.0);
#endif
#ifdef ARTIFICIAL_VISCOSITY
    own.artificial_scale = fields::parameters.viscosity_scale;
#endif
#ifdef MORRIS_VISCOSITY
    own.pair_viscosity = fields::parameters.pair_viscosity;
#endif
#ifdef NEAR_PRESSURE
    own.near_pressure = fields::parameters.near_pressure;
#endif
#ifdef TENSILE_CORRECTION
    own.tensile_correction = fields::parameters.tensile_correction;
    own.inverse_shape = fields::parameters.inverse_shape;
#endif
#ifdef WIDTHS
    own.width = fields::width(a);
#endif
    return own;
}

#ifdef TENSILE_CORRECTION
// R f^4 (freshet_core::tensile_correction)
fn tensile(own: Own, term: f32, q: f32) -> f32 {
    let pulls = -own.tensile_correction * (min(own.pressure_term, 0.0) + min(term, 0.0));
    let strength = select(pulls, 0.01 * (own.pressure_term + term), min(own.pressure_term, term) > 0.0);
    let ratio = pressure_kernels::shape(q) * own.inverse_shape;
    return strength * ratio * ratio * ratio * ratio;
}
#endif

#ifdef NEAR_PRESSURE
// f'(q) / q of f(q) = (1 - q)^4
fn near_slope(q: f32) -> f32 {
    let left = max(1.0 - q, 0.0);
    return -4.0 * left * left * left / max(q, 1e-6);
}
#endif

// (P_a + P_b + Pi_ab) f'(q) / q x_ab, and Morris' term (1997, eq. 22) in the same units
fn from_particle(own: Own, b: u32) -> vec3<f32> {
    let x = grid::difference(own.position, fields::sorted_position(b));
    let r_squared = dot(x, x);
    let q = sqrt(r_squared) * own.inverse_radius;
#ifdef WIDTHS
    let inverse_width = 2.0 / (own.width + fields::width(b));
    let square = inverse_width * inverse_width;
    let slope = square * square * inverse_width * pressure_kernels::slope_over_q(q * inverse_width);
#else
    let slope = pressure_kernels::slope_over_q(q);
#endif
#ifdef NEAR_PRESSURE
    let near = own.near_pressure * near_slope(q);
#else
    let near = 0.0;
#endif
#ifdef PAIR_VELOCITIES
    let motion = fields::velocity_and_density(b);
    let velocity = own.velocity - motion.xyz;
    let term = pressure_term(b, motion.w);
    var factor = own.pressure_term + term;
#ifdef TENSILE_CORRECTION
    factor += tensile(own, term, q);
#endif
#ifdef MUELLER_FORCE
    // (p_a + p_b) / (rho_a rho_b), see freshet_core::pressure_force
    let harder = own.pressure_term * own.density - term * motion.w;
    factor += (own.density - motion.w) * harder / (own.density * motion.w);
#endif
#ifdef ARTIFICIAL_VISCOSITY
    factor -= own.artificial_scale * dot(velocity, x) / ((r_squared + own.softening) * (own.density + motion.w));
#endif
#ifdef MORRIS_VISCOSITY
    let exchange = own.pair_viscosity * r_squared / ((r_squared + own.softening) * (own.density * motion.w));
#ifdef OWN_VISCOSITY_KERNEL
    return (factor * slope + near) * x - (exchange * viscosity_kernels::slope_over_q(q)) * velocity;
#else
    return (factor * slope + near) * x - (exchange * slope) * velocity;
#endif
#else
    return (factor * slope + near) * x;
#endif
#else
    let term = pressure_term(b, 0.0);
    var factor = own.pressure_term + term;
#ifdef TENSILE_CORRECTION
    factor += tensile(own, term, q);
#endif
    return (factor * slope + near) * x;
#endif
}

#ifdef SAMPLES
// V_k P_a f'(q) / q x_ak
fn from_sample(own: Own, sample: fields::Sample) -> vec3<f32> {
    let x = grid::difference(own.position, sample.position);
    let factor = sample.weight * own.pressure_term;
    return (factor * pressure_kernels::slope_over_q(length(x) * own.inverse_radius)) * x;
}
#endif

#ifdef SAMPLES
// V_k (P_a + P_k) f'(q) / q x_ak, P_k being zero for samples of a single layer
fn from_quasi_fluid(own: Own, sample: fields::Sample, term: f32) -> vec3<f32> {
    let x = grid::difference(own.position, sample.position);
    let factor = sample.weight * (own.pressure_term + term);
    return (factor * pressure_kernels::slope_over_q(length(x) * own.inverse_radius)) * x;
}
#endif

#ifdef WALLS
// P_k of a wall's sample
fn wall_term(k: u32) -> f32 {
#ifdef QUASI_FLUID_WALLS
    return fields::wall_pressure(k);
#else
    return 0.0;
#endif
}
#endif

#ifdef DRAGGING_WALLS
// V_k (P_a + P_k + Pi_ak) f'(q) / q x_ak, P_k being `term`
fn from_wall(own: Own, k: u32, sample: fields::Sample, term: f32) -> vec3<f32> {
    let x = grid::difference(own.position, sample.position);
    let r_squared = dot(x, x);
#ifdef MOVING_WALLS
    let velocity = own.velocity - fields::wall_velocity(k);
#else
    let velocity = own.velocity;
#endif
    let approach = sample.viscous_weight * dot(velocity, x);
    let drag = own.artificial_scale * approach / ((r_squared + own.softening) * (2.0 * own.density));
    let factor = sample.weight * (own.pressure_term + term) - drag;
    return (factor * pressure_kernels::slope_over_q(sqrt(r_squared) * own.inverse_radius)) * x;
}
#endif

#ifdef STICKING_WALLS
// Sums over samples of viscous faces, see `sticking`: of V_k F, V_k F x_ak and V_k F v_k.
struct Contact {
    strength: f32,
    slope: vec3<f32>,
    velocity: vec3<f32>,
}

fn touch(own: Own, k: u32, sample: fields::Sample, contact: ptr<function, Contact>) {
    let x = grid::difference(own.position, sample.position);
    let slope = -viscosity_kernels::slope_over_q(length(x) * own.inverse_radius);
    let weight = fields::parameters.sample_force_scale * sample.viscous_weight * slope;
    (*contact).strength += weight;
    (*contact).slope += weight * x;
#ifdef MOVING_WALLS
    (*contact).velocity += weight * fields::wall_velocity(k);
#endif
}

// Morris' viscosity between a particle and viscous faces: (mu rho0 / rho_a^2) (1/G) |D| (u - v_a) / y, with y = |D| / |s| minus
// the depth of the samples behind the face. Derived in crates/freshet_cpu/src/passes/morris1997.rs.
fn sticking(own: Own, contact: Contact) -> vec3<f32> {
    if (contact.strength <= 0.0) {
        return vec3<f32>(0.0);
    }
    let slope = length(contact.slope);
    let distance = max(slope / contact.strength - fields::parameters.wall_depth, fields::parameters.nearest_wall);
    let rate = fields::parameters.wall_viscosity / (own.density * own.density) * slope / distance;
    return rate * (contact.velocity / contact.strength - own.velocity);
}
#endif

fn acceleration_of(a: u32) -> vec3<f32> {
    let own = own_of(a);
    let center = grid::cell_of(own.position);
    let extent = grid::shape();
#ifdef WALLS
    let wall_starts = fields::parameters.wall_starts;
#endif
#ifdef BODIES
    let body_starts = fields::parameters.body_starts;
#endif
    var fluid = vec3<f32>(0.0);
#ifdef SAMPLES
    var samples = vec3<f32>(0.0);
#endif
#ifdef STICKING_WALLS
    var contact: Contact;
#endif
    for (var row = 0u; row < 9u; row++) {
        var found = 0u;
        if (row == hits::OWN_ROW) {
            found = fields::hits_of_own_row(a);
        } else {
            found = fields::hits_of(a, hits::word_of(row));
        }
        if (hits::is_empty(found)) {
            continue;
        }
        // Up to the row's end, not only as far as it is reached: what is further away exerts no force.
        let cells = grid::cells_of(extent, center, row, found & hits::BEGIN, grid::ROW_CELLS);
        let around = grid::open_row_of(0u, cells);
        for (var places = hits::places_of(found); places != 0u; places &= places - 1u) {
            fluid += from_particle(own, grid::member(around, hits::first_of(places)));
        }
        if ((found & hits::MORE) != 0u) {
            let all = grid::row_of(0u, cells);
            for (var t = hits::PLACES; t < all.count; t++) {
                fluid += from_particle(own, grid::member(around, t));
            }
        }
#ifdef SAMPLES
        if ((found & hits::SAMPLES) == 0u) {
            continue;
        }
#endif
#ifdef WALLS
        let walls = grid::row_of(wall_starts, cells);
        for (var t = 0u; t < walls.count; t++) {
            let k = grid::member(walls, t);
            let sample = fields::sample(k);
#ifdef DRAGGING_WALLS
            samples += from_wall(own, k, sample, wall_term(k));
#else ifdef QUASI_FLUID_WALLS
            samples += from_quasi_fluid(own, sample, wall_term(k));
#else
            samples += from_sample(own, sample);
#endif
#ifdef STICKING_WALLS
            touch(own, k, sample, &contact);
#endif
        }
#endif
#ifdef BODIES
        let bodies = grid::row_of(body_starts, cells);
        for (var t = 0u; t < bodies.count; t++) {
            let k = grid::member(bodies, t);
#ifdef QUASI_FLUID
            samples += from_quasi_fluid(own, fields::sample(k), fields::sample_pressure(k));
#else
            samples += from_sample(own, fields::sample(k));
#endif
        }
#endif
    }
    var result = fields::control.gravity - fields::parameters.fluid_force_scale * fluid;
#ifdef SAMPLES
    result -= fields::parameters.sample_force_scale * samples;
#endif
#ifdef STICKING_WALLS
    result += sticking(own, contact);
#endif
    return result;
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn acceleration(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let result = acceleration_of(a);
        fields::set_acceleration(a, result);
#ifdef INCOMPRESSIBLE
        // The speed it is expected to leave the substep with: pressures that hold it are in the acceleration already.
        let ahead = fields::velocity_and_density(a).xyz + fields::control.last_substep * result;
        let pressure = fields::sorted_pressure(a);
        fields::set_solved_pressure(a, pressure);
        fields::set_own_row(a, fields::hits_of_own_row(a));
        atomicMax(&group_speed, threads::ordered_bits(length(ahead)));
        atomicMax(&group_pressure, threads::ordered_bits(pressure));
    }
    workgroupBarrier();
    if (local == 0u) {
        atomicMax(&fields::control.max_speed, atomicLoad(&group_speed));
        atomicMax(&fields::control.max_pressure, atomicLoad(&group_pressure));
    }
#else
        atomicMax(&group_acceleration, threads::ordered_bits(length(result)));
    }
    workgroupBarrier();
    if (local == 0u) {
        atomicMax(&fields::control.max_acceleration, atomicLoad(&group_acceleration));
    }
#endif
}
