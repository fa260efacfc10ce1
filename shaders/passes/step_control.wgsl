// Decides on the GPU how long a substep is and whether there is another one. Single threads.

#import freshet::bindings as fields
#import freshet::arguments
#ifdef INCOMPRESSIBLE
#import freshet::solve
#endif

#ifdef BEGIN_TICK
// What the last tick left over is added to what this one asks for. The tick's commands come after this.
@compute @workgroup_size(1)
fn begin_tick() {
    // What the last tick covered, in units of 2^-24 s.
    fields::control.clock += u32((fields::control.asked - fields::control.remaining) * 16777216.0);
    let carry = min(fields::control.remaining, fields::parameters.longest_tick);
    let asked = fields::input.duration + carry;
    fields::control.asked = asked;
    fields::control.remaining = asked;
    fields::control.gravity = fields::input.gravity;
    fields::control.tick_slot = fields::input.tick.x & 3u;
    fields::control.substeps = 0u;
    fields::control.smallest_substep = 0.0;
    fields::control.mean_compression = 0.0;
    fields::control.refused = 0u;
    atomicStore(&fields::control.removed, 0u);
    atomicStore(&fields::control.not_finite, 0u);
    atomicStore(&fields::control.retired, 0u);
    atomicStore(&fields::control.max_ratio, 0u);
    atomicStore(&fields::control.max_speed, 0u);
    atomicStore(&fields::control.max_acceleration, 0u);
#ifdef INCOMPRESSIBLE
    atomicStore(&fields::control.max_pressure, 0u);
    fields::control.divergence_iterations = 0u;
    fields::control.density_iterations = 0u;
    fields::control.most_divergence = 0u;
    fields::control.most_density = 0u;
    fields::control.unsolved = 0u;
    arguments::write_solve_arguments(false, false, false);
#endif
#ifdef POISSON
    fields::control.density_iterations = 0u;
    fields::control.unsolved = 0u;
    fields::control.residual = 0.0;
    arguments::write_iteration_arguments(false);
#endif
#ifdef REDO
    fields::control.judged_next = 0u;
    fields::control.redos = 0u;
    fields::control.redo_substep = 0.0;
    fields::control.redone = 0u;
    atomicStore(&fields::control.state_speed, 0u);
#endif
    // Even a tick of no length evaluates the stages once, so that fields can be read.
    fields::control.going = 1u;
    arguments::write_arguments(true);
    arguments::write_motion_arguments(false);
}
#endif

#ifdef STEP_CONTROL
// The longest substep that the state allows, without what drags bodies: freshet_core::plan::Parameters.
fn limit_of(max_speed: f32, max_acceleration: f32, max_pressure: f32) -> f32 {
#ifdef INCOMPRESSIBLE
    let way = fields::parameters.longest_way;
    let courant = way / max(max_speed, 1e-12);
    let fall = sqrt(way / max(length(fields::control.gravity), 1e-12));
    let pressure = max_pressure * fields::parameters.rest_density;
    let stiff = fields::parameters.pressure_limit / sqrt(max(pressure, 1e-12));
    return min(min(courant, fall), min(stiff, fields::parameters.steady_limit));
#else ifdef MOVED_APART
    let way = fields::parameters.longest_way;
    let courant = way / max(max_speed, 1e-12);
    let fall = sqrt(way / max(length(fields::control.gravity), 1e-12));
    return min(min(courant, fall), fields::parameters.steady_limit);
#else
    let h = fields::parameters.smoothing_length;
    let courant = fields::parameters.courant_factor * h / (fields::parameters.sound_speed + max_speed);
    let force = fields::parameters.force_factor * sqrt(h / max(max_acceleration, 1e-12));
    return min(min(courant, force), fields::parameters.steady_limit);
#endif
}

// The substep that covers what remains in equal parts no longer than the limit.
fn equal_substep(remaining: f32, limit: f32) -> f32 {
    return remaining / max(ceil(remaining / limit - 1e-3), 1.0);
}

#ifdef STICKING_BODIES
// The substep that the drag on a body allows: freshet_core::plan::Parameters::drag_limit.
fn drag_limit_of(body: u32) -> f32 {
    let inertia = fields::body_inverse_inertia(body);
    let reach = fields::body_reach(body);
    let longest = max(dot(inertia[0], inertia[0]), max(dot(inertia[1], inertia[1]), dot(inertia[2], inertia[2])));
    let answer = max(fields::body_inverse_mass(body), reach * reach * sqrt(longest));
    return 1.0 / max(fields::parameters.sample_drag * f32(fields::body_sample_count(body)) * answer, 1e-30);
}
#endif

#ifdef INCOMPRESSIBLE
// Begins the solves of a substep, if it is long enough for anything to move. The next substep waits for their end.
fn begin_solves(substep: f32, speed: f32, going: bool) {
    fields::control.correction = 0.0;
    fields::control.lead = 0.0;
    let solving = substep >= fields::parameters.shortest_substep;
    if (solving) {
        let way = min(speed * substep / fields::parameters.longest_way, 1.0);
        fields::control.share = way * way;
        fields::control.lead = 0.5 * (1.0 - way * way) * min(fields::control.last_substep, substep);
        fields::control.divergence = max(fields::parameters.divergence * way, fields::parameters.least_divergence);
        fields::control.solve_phase = solve::DIVERGENCE;
        solve::start_pace();
        solve::set_momentum();
    }
    arguments::write_solve_arguments(solving, false, !solving);
    arguments::write_arguments(going && !solving);
    arguments::write_motion_arguments(!solving);
}
#endif

#ifdef REDO
// Nothing moves until what was encoded for the next substep. `going`: whether anything is found out about the state again.
fn stand_still(going: bool) {
    fields::control.judged_next = 0u;
    fields::control.count = fields::control.live;
    fields::control.going = select(0u, 1u, going);
#ifdef INCOMPRESSIBLE
    arguments::write_solve_arguments(false, false, false);
#endif
#ifdef LAST_SUBSTEP
    // What follows from the way of particles has been found.
    fields::control.last_substep = 0.0;
#endif
    atomicStore(&fields::control.max_ratio, fields::control.ratio_before);
    arguments::write_arguments(going);
    arguments::write_motion_arguments(false);
}

// The substep was too long for the state that it left: back to where it started from.
fn take_back(limit: f32) {
    let substep = fields::control.substep;
    fields::control.redone += 1u;
    fields::control.redos += 1u;
    fields::control.redo_substep = min(max(limit, 0.125 * substep), 0.5 * substep);
    fields::control.remaining = fields::control.remaining_before;
    fields::control.smallest_substep = fields::control.smallest_before;
    fields::control.substeps -= 1u;
    fields::control.live = fields::control.live_before;
    fields::control.last_substep = fields::control.last_before;
    atomicStore(&fields::control.removed, fields::control.removed_before);
    atomicStore(&fields::control.retired, fields::control.retired_before);
    atomicStore(&fields::control.not_finite, fields::control.not_finite_before);
    stand_still(true);
    arguments::write_redo_arguments(false, true);
}

// Judges the last substep by the state that it left, which has been found out about; returns whether another one begins.
fn goes_on(limit: f32) -> bool {
    if (fields::control.judged_next != 0u) {
        let fits = fields::control.substep <= f32(#{REDO_SLACK_PERCENT}u) / 100.0 * limit;
        if (!fits && fields::control.redos < #{MOST_REDOS}u) {
            take_back(limit);
            return false;
        }
        fields::control.redos = 0u;
        if (fields::control.remaining <= 0.0 || fields::control.substeps >= fields::parameters.max_substeps) {
            // The state is where the sort has put it, and goes back to where it belongs.
            stand_still(false);
            arguments::write_redo_arguments(true, true);
            return false;
        }
    }
    return true;
}

// What is to be as it was if the substep that begins is taken back.
fn begin_redo() {
    fields::control.judged_next = 1u;
    fields::control.redo_substep = 0.0;
    fields::control.remaining_before = fields::control.remaining;
    fields::control.smallest_before = fields::control.smallest_substep;
    fields::control.last_before = fields::control.last_substep;
    fields::control.live_before = fields::control.live;
    fields::control.removed_before = atomicLoad(&fields::control.removed);
    fields::control.retired_before = atomicLoad(&fields::control.retired);
    fields::control.not_finite_before = atomicLoad(&fields::control.not_finite);
    fields::control.ratio_before = atomicLoad(&fields::control.max_ratio);
    arguments::write_redo_arguments(true, false);
}
#endif

@compute @workgroup_size(1)
fn step_control() {
#ifdef INCOMPRESSIBLE
    // What was encoded for this substep continues the one before.
    if (fields::control.solve_phase != solve::NONE) {
#ifdef REDO
        arguments::write_redo_arguments(false, false);
#endif
        return;
    }
#endif
    // Dispatched in every substep that was encoded: those beyond the tick's end switch the motion off.
    if (fields::control.going == 0u) {
        arguments::write_motion_arguments(false);
#ifdef REDO
        arguments::write_redo_arguments(false, false);
#endif
        return;
    }
    var max_speed = bitcast<f32>(atomicExchange(&fields::control.max_speed, 0u));
    let max_acceleration = bitcast<f32>(atomicExchange(&fields::control.max_acceleration, 0u));
    let fastest = max_speed;
    var max_pressure = 0.0;
#ifdef INCOMPRESSIBLE
    max_pressure = bitcast<f32>(atomicExchange(&fields::control.max_pressure, 0u));
    // With those bodies that touch the fluid.
    var flow_speed = max_speed;
#endif
#ifdef REDO
#ifdef INCOMPRESSIBLE
    var state_speed = bitcast<f32>(atomicExchange(&fields::control.state_speed, 0u));
#else
    var state_speed = max_speed;
#endif
#endif
    var drag_limit = 3.4e38;
#ifdef BODIES
    for (var body = 0u; body < fields::parameters.bodies; body++) {
        // What no sample is faster than.
        let speed = length(fields::body_linear_velocity(body) + fields::body_drift(body))
            + length(fields::body_angular_velocity(body) + fields::body_turn(body)) * fields::body_reach(body);
        max_speed = max(max_speed, speed);
#ifdef REDO
        state_speed = max(state_speed, speed);
#endif
#ifdef STICKING_BODIES
        drag_limit = min(drag_limit, drag_limit_of(body));
#endif
#ifdef INCOMPRESSIBLE
        flow_speed = max(flow_speed, select(0.0, speed, fields::touching(body) > 0u));
#endif
    }
#endif
    let live = fields::control.live;
    let low = atomicExchange(&fields::control.compression_low, 0u);
    let high = atomicExchange(&fields::control.compression_high, 0u);
#ifdef REDO
    if (!goes_on(min(limit_of(state_speed, max_acceleration, max_pressure), drag_limit))) {
        return;
    }
#endif
    let limit = min(limit_of(max_speed, max_acceleration, max_pressure), drag_limit);
    var substep = equal_substep(fields::control.remaining, limit);
#ifdef REDO
    substep = select(substep, fields::control.redo_substep, fields::control.redo_substep > 0.0);
    begin_redo();
#endif
    fields::control.fastest = fastest;
    // 2^-20 and 2^12: units of the sum, see density.wgsl.
    let compression = (f32(high) * 4096.0 + f32(low) / 1048576.0) / f32(max(live, 1u));
    fields::control.mean_compression = max(fields::control.mean_compression, compression);

    let first = fields::control.substeps == 0u;
    fields::control.smallest_substep = select(min(fields::control.smallest_substep, substep), substep, first);
    fields::control.substep = substep;
#ifdef LAST_SUBSTEP
    // What follows from the way of particles is found at the start of the next.
    fields::control.last_substep = substep;
#endif
    fields::control.substeps += 1u;
    fields::control.remaining -= substep;
    fields::control.count = live;

#ifdef REDO
    // Also the last is judged by the state that it leaves.
    let going = true;
#else
    let going = fields::control.remaining > 0.0 && fields::control.substeps < fields::parameters.max_substeps;
#endif
    fields::control.going = select(0u, 1u, going);
#ifdef INCOMPRESSIBLE
    begin_solves(substep, flow_speed, going);
#else
    arguments::write_arguments(going);
    arguments::write_motion_arguments(true);
#endif
}
#endif
