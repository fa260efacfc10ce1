// Particles are moved apart where they would be too dense without pressure (freshet_core::position_based, freshet_core::pressure_corrected): `position_begin`, then in each iteration
// `multiply`: P_a = omega max(rho_a/rho0 - 1, 0) / (max(K_a, least) + softness), times dt^2, or c^2 (rho_a - rho0) / rho0^2, `displace`: x_a += a_a(P), and `follow`, which lets the others see
// it; then `position_finish`: v += (x - x*) / dt. Where a Poisson equation says how hard they push
// (freshet_core::pressure_poisson), `poisson_diagonal` comes after the beginning, then so many times `poisson_relax`, solve_control.wgsl, `poisson_exchange`, and at the end `poisson_end` and `displace`.
// The b come from the bits that the density pass left for x*, where the sorted positions stay, see library/hits.wgsl.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::hits
#import freshet::kernels
#import freshet::threads
#ifdef POISSON
#import freshet::solve
#endif

#ifdef POSITION_BEGIN
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn position_begin(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let position = fields::sorted_position(a);
        fields::begin_place(a, position, fields::hits_of_own_row(a));
        fields::set_motion(a, position);
    }
}
#endif

#ifdef FOLLOW
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn follow(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        fields::set_motion(a, fields::place(a));
    }
}
#endif

#ifdef MULTIPLY
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
}

struct Sums {
    // sum_b W_ab and sum_b F x_ab, the same over samples with their volumes, sum_b |F x_ab|^2
    fluid: f32,
    samples: f32,
    gradient: vec3<f32>,
    sample_gradient: vec3<f32>,
    squares: f32,
}

fn own_of(a: u32) -> Own {
    return Own(fields::place(a), fields::parameters.inverse_support_radius);
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::motion(b));
    let q = length(x) * own.inverse_radius;
    let along = kernels::slope_over_q(q) * x;
    (*sums).fluid += kernels::shape(q);
    (*sums).gradient += along;
    (*sums).squares += dot(along, along);
}

fn add_sample(own: Own, sample: fields::Sample, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, sample.position);
    let q = length(x) * own.inverse_radius;
    (*sums).samples += sample.weight * kernels::shape(q);
    (*sums).sample_gradient += sample.weight * kernels::slope_over_q(q) * x;
}
#endif

#ifdef DISPLACE
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
    push: f32,
}

struct Sums {
    // sum_b (P_a + P_b) F x_ab, or of differences P_b - P_a, and sum_k V_k F x_ak
    fluid: vec3<f32>,
    samples: vec3<f32>,
#ifdef DIFFERENCES
    // sum_b P_b W_ab, and sum_b W_ab
    pressures: f32,
    around: f32,
#endif
}

fn own_of(a: u32) -> Own {
    return Own(fields::place(a), fields::parameters.inverse_support_radius, fields::push(a));
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::motion(b));
    let q = length(x) * own.inverse_radius;
#ifdef DIFFERENCES
    (*sums).fluid += ((fields::push(b) - own.push) * kernels::slope_over_q(q)) * x;
    let shape = kernels::shape(q);
    (*sums).pressures += shape * fields::push(b);
    (*sums).around += shape;
#else
    (*sums).fluid += ((own.push + fields::push(b)) * kernels::slope_over_q(q)) * x;
#endif
}

fn add_sample(own: Own, sample: fields::Sample, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, sample.position);
    (*sums).samples += (sample.weight * kernels::slope_over_q(length(x) * own.inverse_radius)) * x;
}
#endif

#ifdef POISSON_DIAGONAL
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
}

struct Sums {
    // sum_b F, sum_b F x_ab, the same of samples with their volumes
    slopes: f32,
    gradient: vec3<f32>,
    sample_gradient: vec3<f32>,
}

fn own_of(a: u32) -> Own {
    return Own(fields::sorted_position(a), fields::parameters.inverse_support_radius);
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::sorted_position(b));
    let slope = kernels::slope_over_q(length(x) * own.inverse_radius);
    (*sums).slopes += slope;
    (*sums).gradient += slope * x;
}

fn add_sample(own: Own, sample: fields::Sample, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, sample.position);
    (*sums).sample_gradient += sample.weight * kernels::slope_over_q(length(x) * own.inverse_radius) * x;
}
#endif

#ifdef POISSON_RELAX
struct Own {
    position: vec3<f32>,
    inverse_radius: f32,
}

struct Sums {
    // sum_b F P_b
    slopes: f32,
}

fn own_of(a: u32) -> Own {
    return Own(fields::sorted_position(a), fields::parameters.inverse_support_radius);
}

fn add_particle(own: Own, b: u32, sums: ptr<function, Sums>) {
    let x = grid::difference(own.position, fields::sorted_position(b));
    (*sums).slopes += kernels::slope_over_q(length(x) * own.inverse_radius) * fields::push(b);
}
#endif

#ifndef POSITION_BEGIN
#ifndef FOLLOW
#ifndef POSITION_FINISH
#ifndef POISSON_EXCHANGE
#ifndef POISSON_END
fn sums_of(own: Own, a: u32) -> Sums {
    // Of where it was sorted.
    let start = fields::sorted_position(a);
    let center = grid::cell_of(start);
    let extent = grid::shape();
    let squared_radius = fields::parameters.squared_support_radius;
#ifdef WALLS
#ifndef POISSON_RELAX
    let wall_starts = fields::parameters.wall_starts;
#endif
#endif
    var sums: Sums;
    for (var row = 0u; row < 9u; row++) {
        var found = 0u;
        if (row == hits::OWN_ROW) {
            found = fields::place_own_row(a);
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
                let b = grid::member(around, t);
                let apart = grid::difference(start, fields::sorted_position(b));
                if (b != a && dot(apart, apart) < squared_radius) {
                    add_particle(own, b, &sums);
                }
            }
        }
#ifdef WALLS
#ifndef POISSON_RELAX
        if ((found & hits::SAMPLES) != 0u) {
            let walls = grid::row_of(wall_starts, cells);
            for (var t = 0u; t < walls.count; t++) {
                let sample = fields::sample(grid::member(walls, t));
                let apart = grid::difference(start, sample.position);
                if (dot(apart, apart) < squared_radius) {
                    add_sample(own, sample, &sums);
                }
            }
        }
#endif
#endif
    }
    return sums;
}
#endif
#endif
#endif
#endif
#endif

#ifdef MULTIPLY
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn multiply(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let sums = sums_of(own_of(a), a);
    // The bits leave out the particle itself.
    var density = fields::parameters.fluid_density_scale * (sums.fluid + kernels::shape(0.0));
    var gradient = sums.gradient;
#ifdef WALLS
    density += fields::parameters.sample_density_scale * sums.samples;
    gradient += fields::parameters.number_density * sums.sample_gradient;
#endif
    let excess = density * fields::parameters.inverse_rest_density - 1.0;
#ifdef PRESSURE_CORRECTED
    let way = min(fields::parameters.sound_speed * fields::control.last_substep, fields::parameters.longest_sound);
    let stiffness = way * way * fields::parameters.inverse_rest_density;
    // Less again where it is too thin, but none below zero in all.
    let push = max(stiffness * excess, -fields::sum_of_pushes(a));
#else
    let diagonal = fields::parameters.diagonal_scale * (dot(gradient, gradient) + sums.squares);
    let stiffness = max(diagonal, fields::parameters.least_diagonal) + fields::parameters.softness;
    let push = fields::parameters.relaxation * max(excess, 0.0) / stiffness;
#endif
    // Before there was a substep nothing has come from anywhere.
    fields::set_push(a, select(0.0, push, fields::control.last_substep > 0.0));
}
#endif

#ifdef DISPLACE
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn displace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let own = own_of(a);
    let sums = sums_of(own, a);
    var way = fields::parameters.fluid_force_scale * sums.fluid;
#ifdef WALLS
#ifdef DIFFERENCES
    let whole = fields::parameters.fluid_density_scale * fields::parameters.inverse_rest_density;
    // The fluid's pressure continued into the wall: PressureGradient::in_walls.
    let mean = whole * sums.pressures / max(whole * sums.around, fields::parameters.fewest_around);
    way += fields::parameters.sample_force_scale * max(own.push - mean, 0.0) * sums.samples;
#else
    way += fields::parameters.sample_force_scale * own.push * sums.samples;
#endif
#endif
    fields::set_place(a, own.position - way);
}
#endif

#ifdef POSITION_FINISH
var<workgroup> group_speed: atomic<u32>;

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn position_finish(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let dt = fields::control.last_substep;
        let rate = select(0.0, 1.0 / max(dt, 1e-30), dt > 0.0);
        let velocity = fields::velocity_before(a) + (fields::place(a) - fields::sorted_position(a)) * rate;
        let density = fields::density(a);
        fields::set_density(a, density, fields::sum_of_pushes(a) * rate * rate);
        fields::set_velocity_and_density(a, velocity, density);
        atomicMax(&group_speed, threads::ordered_bits(length(velocity)));
    }
    workgroupBarrier();
    if (local == 0u) {
        atomicMax(&fields::control.max_speed, atomicLoad(&group_speed));
    }
}
#endif

#ifdef POISSON_DIAGONAL
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn poisson_diagonal(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let sums = sums_of(own_of(a), a);
    let gradient = sums.gradient + fields::parameters.number_density * sums.sample_gradient;
    let own = fields::parameters.diagonal_scale * dot(gradient, gradient);
    let all = max(own - fields::parameters.poisson_scale * sums.slopes, fields::parameters.least_diagonal);
    // Zero at a free surface.
    fields::set_push_diagonal(a, select(all, 0.0, fields::density(a) < fields::parameters.surface_density));
}
#endif

#ifdef POISSON_RELAX
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn poisson_relax(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let diagonal = fields::push_diagonal(a);
        if (diagonal > 0.0) {
            let excess = fields::density(a) * fields::parameters.inverse_rest_density - 1.0;
            let push = fields::push(a);
            let left = excess - diagonal * push - fields::parameters.poisson_scale * sums_of(own_of(a), a).slopes;
            let free = push + fields::parameters.relaxation * left / diagonal;
            let stepped = max(free, 0.0);
            let before = fields::stepped_push(a);
            fields::set_next_push(a, stepped, max(stepped + fields::control.momentum * (stepped - before), 0.0));
            // Where there is no pressure left to take away, a fluid that parts is as it should be.
            solve::add_left(select(abs(left), 0.0, free < 0.0));
        }
    }
    workgroupBarrier();
    if (local == 0u) {
        solve::publish_left();
    }
}
#endif

#ifdef POISSON_EXCHANGE
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn poisson_exchange(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        fields::take_next_push(a);
    }
}
#endif

#ifdef POISSON_END
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn poisson_end(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        fields::take_stepped_push(a);
    }
}
#endif
