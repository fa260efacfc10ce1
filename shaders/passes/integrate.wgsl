// Semi-implicit Euler: v += a dt, x += v dt; other integrators are in library/integrator.wgsl. Reads the sorted copy, writes
// the state at the same index, so that whoever draws always reads the same buffers. With XSPH particles also move with what
// that pass found, x += (v + e) dt; those of an incompressible fluid move by the trapezoidal rule, x += (v + lead a) dt.
// Those that were moved apart go from there.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::integrator
#import freshet::threads

#ifdef PASTS
// Keeps the substep; `motion` is what the particle moved with.
fn keep(i: u32, past: integrator::Past, a: vec3<f32>, motion: vec3<f32>, h: f32) {
    fields::set_history(i, 0u, h);
#if PAST_WORDS >= 4
#ifdef INTEGRATOR_VERLET
    let first = motion;
#else
    let first = a;
#endif
    fields::set_history(i, 1u, first.x);
    fields::set_history(i, 2u, first.y);
    fields::set_history(i, 3u, first.z);
#endif
#if PAST_WORDS >= 8
    fields::set_history(i, 4u, past.step);
    fields::set_history(i, 5u, past.first.x);
    fields::set_history(i, 6u, past.first.y);
    fields::set_history(i, 7u, past.first.z);
#endif
}
#endif

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn integrate(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let dt = fields::control.substep;
    let acceleration = fields::acceleration(a);
#ifdef INTEGRATOR
    let past = integrator::past_of(a);
    let velocity = integrator::velocity_after(past, fields::velocity_and_density(a).xyz, acceleration, dt);
    var motion = integrator::motion_in(past, velocity, acceleration, dt);
#ifdef PASTS
    keep(a, past, acceleration, motion, dt);
#endif
#else
    let velocity = fields::velocity_and_density(a).xyz + acceleration * dt;
    var motion = velocity;
#endif
#ifdef XSPH_DRIFT
    motion += fields::drift(a);
#endif
#ifdef INCOMPRESSIBLE
    motion += acceleration * fields::control.lead;
#endif
#ifdef MOVED_APART
    var position = fields::motion(a) + motion * dt;
#else
    var position = fields::sorted_position(a) + motion * dt;
#endif
#ifdef INCOMPRESSIBLE
    // What the density solve found changes positions only.
    if (fields::control.correction > 0.0) {
        let way = fields::motion(a) * fields::control.correction;
        position += way * min(1.0, fields::parameters.longest_correction / max(length(way), 1e-30));
    }
#endif
#ifdef PERIODIC
    position = grid::wrapped(position);
#endif
    fields::set_particle(a, position, fields::sorted_id(a), velocity, fields::sorted_remaining_life(a) - dt);
}
