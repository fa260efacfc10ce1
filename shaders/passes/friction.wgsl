// Coulomb friction of walls, see freshet_core::scene::Friction. The walls push particle a with
// n_a = -(1/G) rho0 sum_k V_k P_a F x_ak; each sample counts with its coefficient, in n_s with that of what sticks, in n_k with
// that of what slides. With v = v_a + a_a dt - u and t its part across n_s: a_a -= t/dt if |t| <= |n_s| dt, else a_a -= |n_k| t/|t|.
// u is the velocity of the walls, their mean by what they add to n_s.
// Walls that are springs push with these instead.

#import freshet::bindings as fields
#ifdef WALL_SPRINGS
#import freshet::wall_planes
#else
#ifndef INCOMPRESSIBLE
#import freshet::equation_of_state
#endif
#endif
#import freshet::coulomb
#import freshet::grid
#import freshet::pressure_kernels
#import freshet::threads

// The push of walls, m/s2, or sum_k V_k f'(q)/q x_ak, times either coefficient.
struct Push {
    at_rest: vec3<f32>,
    sliding: vec3<f32>,
#ifdef MOVING_WALLS
    // Sums of V_k F times the coefficient of what sticks, and of that times velocities of walls.
    size: f32,
    surface: vec3<f32>,
#endif
}

#ifdef WALL_SPRINGS
fn push_of_springs(position: vec3<f32>, velocity: vec3<f32>, place: grid::Place) -> Push {
    var planes = wall_planes::planes_at(position, place);
    var push: Push;
    for (var i = 0u; i < planes.count; i++) {
        let face = planes.faces[i];
        let part = wall_planes::spring_push(face.w, dot(velocity, face.xyz)) * face.xyz;
        let coefficients = fields::wall_friction(planes.samples[i]);
        push.at_rest += coefficients.x * part;
        push.sliding += coefficients.y * part;
    }
    return push;
}
#else
fn push_on(position: vec3<f32>, place: grid::Place) -> Push {
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    let wall_starts = fields::parameters.wall_starts;
    var push: Push;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let walls = grid::row_of(wall_starts, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < walls.count; t++) {
            let k = grid::member(walls, t);
            let sample = fields::sample(k);
            let x = grid::difference(position, sample.position);
            let weight = sample.weight * pressure_kernels::slope_over_q(length(x) * inverse_radius);
            let part = weight * x;
            let coefficients = fields::wall_friction(k);
#ifdef MOVING_WALLS
            let size = coefficients.x * weight;
            push.size += size;
            push.surface += size * fields::wall_velocity(k);
#endif
            push.at_rest += coefficients.x * part;
            push.sliding += coefficients.y * part;
        }
    }
    return push;
}
#endif

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn friction(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let position = fields::sorted_position(a);
    let place = grid::place_of(position);
    if (!grid::is_near_walls(place.cell)) {
        return;
    }
    let motion = fields::velocity_and_density(a);
#ifdef WALL_SPRINGS
    let push = push_of_springs(position, motion.xyz, place);
    let scale = 1.0;
#else
#ifdef INCOMPRESSIBLE
    let pressure = fields::solved_pressure(a);
#else
    let pressure = equation_of_state::pressure_term(motion.w);
#endif
    // What does not press is not held.
    if (pressure <= 0.0) {
        return;
    }
    let push = push_on(position, place);
    let scale = -fields::parameters.sample_force_scale * pressure;
#endif
    let dt = fields::control.substep;
    let before = fields::acceleration(a);
    let sliding = length(scale * push.sliding);
    var velocity = motion.xyz + dt * before;
#ifdef MOVING_WALLS
    if (push.size < 0.0) {
        velocity -= push.surface / push.size;
    }
#endif
    fields::set_acceleration(a, before - coulomb::taken(velocity, scale * push.at_rest, sliding, dt));
}
