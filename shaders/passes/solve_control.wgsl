// Decides on the GPU how many iterations the solves of a substep take: freshet_core::pressure_solver::DivergenceFree, at the end freshet_core::pressure_poisson. Single threads.
//
// Of each solve of the former a substep has as many iterations encoded as the last ticks needed. A solve that needs more stays open: nothing
// that comes after it is dispatched, and the iterations of what was encoded for the next substep continue it. So results do not
// depend on how many were encoded. At the end of a tick that nobody waits for, `close_solve` ends it as it is,
// and `close_density_solve` the one that comes after it.

#import freshet::bindings as fields
#import freshet::arguments
#import freshet::solve

#ifdef INCOMPRESSIBLE
// Hears what an iteration left; the pace starts again when that made things worse (O'Donoghue & Candes 2015).
fn hear(left: f32) {
    if (left > fields::control.last_left) {
        fields::control.pace = 1.0;
    }
    fields::control.last_left = left;
    fields::control.iterations += 1u;
}

fn end_divergence_solve(converged: bool) {
    let iterations = fields::control.iterations;
    fields::control.divergence_iterations += iterations;
    fields::control.most_divergence = max(fields::control.most_divergence, iterations);
    fields::control.unsolved += select(1u, 0u, converged);
    fields::control.solve_phase = solve::BETWEEN;
    arguments::write_solve_arguments(false, false, true);
}

fn end_density_solve(converged: bool) {
    let iterations = fields::control.iterations;
    let dt = fields::control.substep;
    fields::control.density_iterations += iterations;
    fields::control.most_density = max(fields::control.most_density, iterations);
    fields::control.unsolved += select(1u, 0u, converged);
    fields::control.correction = select(0.0, dt * dt, iterations > 0u);
    fields::control.last_substep = dt;
    fields::control.solve_phase = solve::NONE;
    arguments::write_solve_arguments(false, false, false);
    arguments::write_arguments(fields::control.going != 0u);
    arguments::write_motion_arguments(true);
}

// Goes on with the solve or ends it.
fn decide(left: f32) {
    let divergence = fields::control.solve_phase == solve::DIVERGENCE;
    let wanted = select(fields::parameters.compression, fields::control.divergence, divergence);
    if (left > wanted && fields::control.iterations < fields::parameters.max_iterations) {
        solve::set_momentum();
        arguments::write_solve_arguments(false, true, false);
    } else if (divergence) {
        end_divergence_solve(left <= wanted);
    } else {
        end_density_solve(left <= wanted);
    }
}
#endif

#ifdef INCOMPRESSIBLE
// What an iteration left: in the mean, or in that of those who touch a body which answers, if that is more. Around it it has to be as
// exact as everywhere, however few they are.
fn take_left() -> f32 {
    var left = solve::take_mean_left();
#ifdef BODIES
    if (fields::control.solve_phase == solve::DIVERGENCE) {
        for (var body = 0u; body < fields::parameters.bodies; body++) {
            left = max(left, solve::in_ones(fields::take_body_left(body)) / f32(max(fields::touching(body), 1u)));
        }
    }
#endif
    return left;
}
#endif

#ifdef FIRST_CONTROL
@compute @workgroup_size(1)
fn first_control() {
    if (fields::control.solve_phase == solve::DIVERGENCE && fields::control.iterations == 0u) {
        let left = take_left();
        hear(left);
        decide(left);
    }
}
#endif

#ifdef SOLVE_CONTROL
@compute @workgroup_size(1)
fn solve_control() {
    if (fields::control.solve_phase == solve::DIVERGENCE || fields::control.solve_phase == solve::DENSITY) {
        let left = take_left();
        hear(left);
        decide(left);
    }
}
#endif

#ifdef DENSITY_CONTROL
@compute @workgroup_size(1)
fn density_control() {
    if (fields::control.solve_phase == solve::BETWEEN) {
        fields::control.solve_phase = solve::DENSITY;
        solve::start_pace();
        decide(solve::take_mean_left());
    } else if (fields::control.solve_phase == solve::NONE) {
        // A substep too short to be solved has shown its pressures.
        arguments::write_solve_arguments(false, false, false);
    }
}
#endif

#ifdef CLOSE_SOLVE
@compute @workgroup_size(1)
fn close_solve() {
    if (fields::control.solve_phase == solve::DIVERGENCE) {
        end_divergence_solve(false);
    } else if (fields::control.solve_phase == solve::DENSITY) {
        end_density_solve(false);
    } else {
        // What moved at the end of the last substep must not move again.
        arguments::write_motion_arguments(false);
    }
}
#endif

#ifdef CLOSE_DENSITY_SOLVE
@compute @workgroup_size(1)
fn close_density_solve() {
    if (fields::control.solve_phase == solve::DENSITY) {
        end_density_solve(false);
    }
}
#endif

#ifdef POISSON_FIRST
// A Poisson equation begins from no pressure, if there was a substep whose way it could correct.
@compute @workgroup_size(1)
fn poisson_first() {
    let begins = fields::control.going != 0u && fields::control.last_substep > 0.0;
    fields::control.solve_phase = select(solve::NONE, solve::POISSON, begins);
    solve::start_pace();
    solve::set_momentum();
    arguments::write_iteration_arguments(begins);
}
#endif

#ifdef POISSON_CONTROL
@compute @workgroup_size(1)
fn poisson_control() {
    if (fields::control.solve_phase != solve::POISSON) {
        return;
    }
    let left = solve::take_mean_left();
    if (left > fields::control.last_left) {
        fields::control.pace = 1.0;
    }
    fields::control.last_left = left;
    if (fields::control.iterations == 0u) {
        fields::control.divergence = left;
    }
    fields::control.iterations += 1u;
    let begun = fields::control.divergence;
    let converged = left <= fields::parameters.divergence * begun;
    if (converged || fields::control.iterations >= fields::parameters.max_iterations) {
        fields::control.density_iterations += fields::control.iterations;
        fields::control.unsolved += select(1u, 0u, converged);
        fields::control.residual = max(fields::control.residual, select(0.0, left / max(begun, 1e-30), begun > 0.0));
        fields::control.solve_phase = solve::NONE;
        arguments::write_iteration_arguments(false);
    } else {
        solve::set_momentum();
    }
}
#endif
