// The sums of the stages divergence_solve and density_solve: freshet_core::pressure_solver::DivergenceFree.
//
// divergence_first: what velocities compress, the diagonal of the system, and the first step.
// pressure_change, project: an iteration. Accelerations by the change of pressures, then how fast densities change by them, what
// that leaves, and the next change. The b come from the bits that the density pass left, see library/hits.wgsl. Bodies answer to a
// change of pressures in body_load.wgsl, between the two.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::hits
#import freshet::kernels
#import freshet::solve
#import freshet::threads
#ifdef BODIES
#ifdef PROJECT
#import freshet::left_of_bodies
#else
#import freshet::touch
#endif
#endif

#ifndef PRESSURE_CHANGE
// What a step multiplies a compression over K with, 1/s2.
fn step_scale() -> f32 {
    return fields::parameters.relaxation / (fields::control.substep * fields::control.substep);
}

#ifndef DENSITY_BEGIN
#ifdef BODIES
// Of a solve in which bodies answer.
fn inverse_diagonal(a: u32) -> f32 {
    let inverse = fields::inverse_diagonal(a);
    let stiffness = select(0.0, fields::stiffness(a), fields::control.solve_phase == solve::DIVERGENCE);
    return inverse / (1.0 + stiffness * inverse);
}

#else
fn inverse_diagonal(a: u32) -> f32 {
    return fields::inverse_diagonal(a);
}
#endif

// A step from `change` by what it leaves, then momentum; nothing goes below `least`. Returns what counts as wrong.
fn take_step(a: u32, change: f32, stepped: f32, left: f32, least: f32) -> f32 {
    let free = change + step_scale() * left * inverse_diagonal(a);
    let reached = max(free, least);
    fields::set_change(a, max(reached + fields::control.momentum * (reached - stepped), least));
    fields::set_stepped(a, reached);
    fields::set_taken(a, change);
    fields::set_left(a, left);
    // Where there is no pressure left to take away, a fluid that parts is as it should be.
    return select(abs(left), 0.0, free < least);
}
#endif
#endif

#ifdef DIVERGENCE_FIRST
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
    velocity: vec3<f32>,
}

struct Sums {
    // sum_b F x_ab . (v_a - v_b), the same over samples with their volumes, sum_b F x_ab, the same of samples, sum_b |F x_ab|^2
    fluid: f32,
    samples: f32,
    gradient: vec3<f32>,
    sample_gradient: vec3<f32>,
    squares: f32,
}

// With which a particle leaves the substep, if pressures stay as they are.
fn velocity_after(i: u32) -> vec3<f32> {
    return fields::velocity_and_density(i).xyz + fields::control.substep * fields::acceleration(i);
}

fn own_of(a: u32) -> Own {
    return Own(fields::sorted_position(a), fields::parameters.inverse_support_radius, velocity_after(a));
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::sorted_position(b));
    let along = kernels::slope_over_q(length(x) * own.inverse_radius) * x;
    (*sums).fluid += dot(along, own.velocity - velocity_after(b));
    (*sums).gradient += along;
    (*sums).squares += dot(along, along);
}

// Walls that have a velocity are belts: their samples stay where they are.
fn add_sample(own: Own, sample: fields::Sample, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, sample.position);
    let along = sample.weight * kernels::slope_over_q(length(x) * own.inverse_radius) * x;
    (*sums).samples += dot(along, own.velocity);
    (*sums).sample_gradient += along;
}
#endif

#ifdef PRESSURE_CHANGE
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
    change: f32,
}

struct Sums {
    // sum_b (P_a + P_b) F x_ab, and sum_k V_k F x_ak
    fluid: vec3<f32>,
    samples: vec3<f32>,
}

fn own_of(a: u32) -> Own {
    return Own(fields::sorted_position(a), fields::parameters.inverse_support_radius, fields::change(a));
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::sorted_position(b));
    (*sums).fluid += ((own.change + fields::change(b)) * kernels::slope_over_q(length(x) * own.inverse_radius)) * x;
}

fn add_sample(own: Own, sample: fields::Sample, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, sample.position);
    (*sums).samples += (sample.weight * kernels::slope_over_q(length(x) * own.inverse_radius)) * x;
}
#endif

#ifdef PROJECT
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
    acceleration: vec3<f32>,
#ifdef BODIES
    bodies_answer: bool,
#endif
}

struct Sums {
    // sum_b F x_ab . (a_a - a_b), and sum_k V_k F x_ak . a_a
    fluid: f32,
    samples: f32,
}

fn own_of(a: u32) -> Own {
    var own: Own;
    own.position = fields::sorted_position(a);
    own.inverse_radius = fields::parameters.inverse_support_radius;
    own.acceleration = fields::motion(a);
#ifdef BODIES
    own.bodies_answer = fields::control.solve_phase == solve::DIVERGENCE;
#endif
    return own;
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::sorted_position(b));
    let parting = dot(x, own.acceleration - fields::motion(b));
    (*sums).fluid += kernels::slope_over_q(length(x) * own.inverse_radius) * parting;
}

fn add_sample(own: Own, sample: fields::Sample, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, sample.position);
    (*sums).samples += sample.weight * kernels::slope_over_q(length(x) * own.inverse_radius) * dot(x, own.acceleration);
}

#ifdef BODIES
fn add_body_sample(own: Own, k: u32, sums: ptr<function, Sums>) {
    let sample = fields::sample(k);
    let x = grid::difference(own.position, sample.position);
    var acceleration = own.acceleration;
    if (own.bodies_answer) {
        let arm = fields::sample_arm(k);
        acceleration -= fields::answer_linear(arm.body) + cross(fields::answer_angular(arm.body), arm.offset);
    }
    (*sums).samples += sample.weight * kernels::slope_over_q(length(x) * own.inverse_radius) * dot(x, acceleration);
}
#endif
#endif

#ifndef DENSITY_BEGIN
fn sums_of(own: Own, a: u32) -> Sums {
    let center = grid::cell_of(own.position);
    let extent = grid::shape();
#ifdef WALLS
    let wall_starts = fields::parameters.wall_starts;
#endif
#ifdef BODIES
    let body_starts = fields::parameters.body_starts;
#endif
    var sums: Sums;
    for (var row = 0u; row < 9u; row++) {
        var found = 0u;
        if (row == hits::OWN_ROW) {
            found = fields::own_row(a);
        } else {
            found = fields::hits_of(a, hits::word_of(row));
        }
        if (hits::is_empty(found)) {
            continue;
        }
        let cells = grid::cells_of(extent, center, row, found & hits::BEGIN, grid::ROW_CELLS);
        let around = grid::open_row_of(0u, cells);
        for (var places = hits::places_of(found); places != 0u; places &= places - 1u) {
            add_particle(own, grid::member(around, hits::first_of(places)), &sums);
        }
        if ((found & hits::MORE) != 0u) {
            let all = grid::row_of(0u, cells);
            for (var t = hits::PLACES; t < all.count; t++) {
                add_particle(own, grid::member(around, t), &sums);
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
            add_sample(own, fields::sample(grid::member(walls, t)), &sums);
        }
#endif
#ifdef BODIES
        let bodies = grid::row_of(body_starts, cells);
        for (var t = 0u; t < bodies.count; t++) {
#ifdef PROJECT
            add_body_sample(own, grid::member(bodies, t), &sums);
#else
            add_sample(own, fields::sample(grid::member(bodies, t)), &sums);
#endif
        }
#endif
    }
    return sums;
}
#endif

#ifndef PROJECT
#ifndef PRESSURE_CHANGE
// What velocities correct of a density too large: DivergenceFree::by_velocity.
fn by_velocity(excess: f32) -> f32 {
    return fields::control.share * clamp(excess, 0.0, fields::parameters.by_velocity_rate * fields::control.substep);
}

#ifdef BODIES
// What velocities correct of it beside a body that swells, beyond that: freshet_core::swelling.
fn pushed_out(a: u32, excess: f32) -> f32 {
    let most = min(max(excess, 0.0), fields::parameters.push_out_rate * fields::control.substep);
    let more = max(most - by_velocity(excess), 0.0);
    return select(0.0, more, (fields::touch(a) & touch::SWELLS) != 0u);
}
#endif
#endif
#endif

#ifdef DIVERGENCE_FIRST
// What a substep may or must change of a density: DivergenceFree::source.
fn source_of(excess: f32) -> f32 {
    let lack = fields::parameters.lack;
    let share = fields::control.share;
    let filling = max(share, fields::parameters.filling);
    return min(excess + lack, 0.0) + filling * clamp(excess, -lack, 0.0) + by_velocity(excess);
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn divergence_first(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let sums = sums_of(own_of(a), a);
        let number_density = fields::parameters.number_density;
        let gradient = sums.gradient + number_density * sums.sample_gradient;
        let diagonal = fields::parameters.diagonal_scale * (dot(gradient, gradient) + sums.squares);
        fields::set_inverse_diagonal(a, 1.0 / max(diagonal, fields::parameters.least_diagonal));
#ifdef BODIES
        // What the bodies' motion adds.
        let of_bodies = fields::source(a);
#else
        let of_bodies = 0.0;
#endif
        let rate = fields::parameters.rate_scale * (sums.fluid + number_density * sums.samples + of_bodies);
        let excess = fields::velocity_and_density(a).w * fields::parameters.inverse_rest_density - 1.0;
        var source = source_of(excess);
#ifdef BODIES
        source += pushed_out(a, excess);
#endif
        let left = source + fields::control.substep * rate;
        fields::set_source(a, left);
        solve::add_left(take_step(a, 0.0, 0.0, left, -fields::solved_pressure(a)));
    }
    workgroupBarrier();
    if (local == 0u) {
        solve::publish_left();
    }
}
#endif

#ifdef PRESSURE_CHANGE
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn pressure_change(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let own = own_of(a);
    let sums = sums_of(own, a);
    let by_samples = (fields::parameters.sample_force_scale * own.change) * sums.samples;
    fields::set_motion(a, -fields::parameters.fluid_force_scale * sums.fluid - by_samples);
}
#endif

#ifdef PROJECT
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn project(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let sums = sums_of(own_of(a), a);
        let rate = fields::parameters.rate_scale * (sums.fluid + fields::parameters.number_density * sums.samples);
        let dt = fields::control.substep;
        let left = fields::source(a) + dt * dt * rate;
        // Pressures are there already in the one solve, in the other there are none.
        let least = select(0.0, -fields::solved_pressure(a), fields::control.solve_phase == solve::DIVERGENCE);
#ifdef BODIES
        if (fields::control.solve_phase == solve::DIVERGENCE) {
            left_of_bodies::add(a, fields::change(a), left, least);
        }
#endif
        solve::add_left(take_step(a, fields::change(a), fields::stepped(a), left, least));
    }
    workgroupBarrier();
    if (local == 0u) {
        solve::publish_left();
    }
}
#endif

#ifdef DENSITY_BEGIN
// Adds what the divergence solve found to pressures and accelerations; what it leaves too dense is the other solve's.
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn density_begin(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let density = fields::velocity_and_density(a).w;
        var pressure = fields::solved_pressure(a);
        let solving = fields::control.solve_phase == solve::BETWEEN;
        // The first iteration is about what is there already.
        if (solving && fields::control.iterations > 1u) {
            pressure += fields::taken(a);
            fields::set_solved_pressure(a, pressure);
            fields::set_acceleration(a, fields::acceleration(a) + fields::motion(a));
        }
        fields::set_density(a, density, pressure);
        if (solving) {
            let excess = max(density * fields::parameters.inverse_rest_density - 1.0, 0.0);
            var too_much = fields::left(a) + excess - by_velocity(excess);
#ifdef BODIES
            too_much -= pushed_out(a, excess);
#endif
            let step = max(step_scale() * too_much * fields::inverse_diagonal(a), 0.0);
            fields::set_source(a, too_much);
            fields::set_change(a, step);
            fields::set_stepped(a, step);
            solve::add_left(max(too_much, 0.0));
        }
    }
    workgroupBarrier();
    if (local == 0u) {
        solve::publish_left();
    }
}
#endif
