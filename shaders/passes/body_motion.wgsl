// Bodies move by the fluid's force within the tick, so that a light one answers at once.

#import freshet::bindings as fields
#import freshet::rotation
#import freshet::threads

fn turned_by_inertia(body: u32, v: vec3<f32>) -> vec3<f32> {
    let columns = fields::body_inverse_inertia(body);
    return columns * v;
}

#ifdef BEGIN_BODIES
// Whether 64-bit a is less than b; x holds the lower half.
fn less(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

fn at_most(v: vec3<f32>, limit: f32) -> vec3<f32> {
    return v * min(1.0, limit / max(length(v), 1e-30));
}

// Bodies at the start of a tick: as their engine knows them, plus what the engine has not heard of yet.
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn begin_bodies(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let body = threads::thread_index(group, local);
    if (body >= fields::parameters.bodies) {
        return;
    }
    let given = fields::body_input(fields::input.first_body + body);
    let was_placed = fields::body_is_placed(body);
    fields::start_body(body, given);
    let tick = fields::input.tick;
    var position = given.position;
    var turning = given.rotation;
    var linear_velocity = given.linear_velocity;
    var angular_velocity = given.angular_velocity;
    for (var slot = 0u; slot < 4u; slot++) {
        let exchange = fields::body_exchange(body, slot);
        let none = exchange.tick_plus_one.x == 0u && exchange.tick_plus_one.y == 0u;
        let borrow = select(0u, 1u, exchange.tick_plus_one.x == 0u);
        let past = vec2<u32>(exchange.tick_plus_one.x - 1u, exchange.tick_plus_one.y - borrow);
        if (!none && !less(past, given.corrected_before) && less(past, tick)) {
            let velocity = exchange.linear * given.inverse_mass;
            let turn = turned_by_inertia(body, exchange.angular);
            linear_velocity += velocity;
            angular_velocity += turn;
            if (given.is_free != 0u) {
                let late = (f32(tick.x - past.x) - 0.5) * fields::input.duration;
                position += velocity * late;
                turning = rotation::turned(turning, turn * late);
            }
        }
    }
    // It starts from where the last tick left it and drifts to its place: what contacts and joints do to a body the solver
    // learns a tick later, and where it jumped to there would be fluid. One that has been put elsewhere jumps.
    var drift = vec3<f32>(0.0);
    var turn = vec3<f32>(0.0);
    let away = position - fields::body_position(body);
    let turned = rotation::between(fields::body_rotation(body), turning);
    let duration = fields::control.asked;
    // What is new or elsewhere swells from nothing, see freshet_core::swelling.
    let jumps = given.is_put != 0u || length(away) > fields::parameters.body_reach;
    let is_elsewhere = length(away) + length(turned) * fields::body_reach(body) > fields::parameters.elsewhere;
    if (given.is_whole != 0u) {
        fields::set_body_swollen(body, 1.0);
    } else if (!was_placed || (jumps && is_elsewhere)) {
        fields::set_body_swollen(body, 0.0);
    }
    if (was_placed && given.is_put == 0u && duration > 0.0 && length(away) <= fields::parameters.body_reach) {
        let limit = fields::parameters.expected_speed;
        drift = at_most(away / duration, limit);
        turn = at_most(turned / duration, limit / fields::parameters.body_reach);
        position = fields::body_position(body);
        turning = fields::body_rotation(body);
    }
    fields::set_body_drift(body, drift, turn);
    fields::set_body_pose(body, position, turning);
    fields::set_body_velocity(body, linear_velocity, angular_velocity);
    // Remembered from here on as what is given minus what was forecast; the forecast is taken off at once.
    fields::set_body_exchange(body, tick.x & 3u, fields::input.tick_plus_one, -given.forecast_linear, -given.forecast_angular);
}
#endif

#ifdef BODY_MOTION
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_motion(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let body = threads::thread_index(group, local);
    if (body >= fields::parameters.bodies) {
        return;
    }
    let dt = fields::control.substep;
#ifdef INCOMPRESSIBLE
    // What the divergence solve changed.
    let force = fields::body_force(body) + fields::answer_force(body);
    let torque = fields::body_torque(body) + fields::answer_torque(body);
#else
    let force = fields::body_force(body);
    let torque = fields::body_torque(body);
#endif
    fields::add_body_impulse(body, fields::control.tick_slot, force * dt, torque * dt);
    let push = force * fields::body_inverse_mass(body) + fields::body_acceleration(body);
    let linear_velocity = fields::body_linear_velocity(body) + dt * push;
    let angular_velocity = fields::body_angular_velocity(body) + dt * turned_by_inertia(body, torque);
    fields::set_body_velocity(body, linear_velocity, angular_velocity);
    let position = fields::body_position(body) + dt * (linear_velocity + fields::body_drift(body));
    let turn = dt * (angular_velocity + fields::body_turn(body));
    fields::set_body_pose(body, position, rotation::turned(fields::body_rotation(body), turn));
    let swollen = fields::body_swollen(body);
    if (swollen < 1.0) {
        let is_wet = fields::body_wetted(body) > 0u;
        let way = select(fields::parameters.swelling_way, fields::parameters.push_out_speed * dt, is_wet);
        fields::set_body_swollen(body, min(1.0, swollen + way / fields::body_swelling_reach(body)));
    }
}
#endif
