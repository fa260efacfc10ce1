// The state that a substep starts from, kept and put back: freshet_core::plan::Parameters::redone. What is kept is in the order of the sort, and so is
// what is put back; of the densities that particles carry it is those that the density pass has found.

#import freshet::bindings as fields
#import freshet::threads

#ifdef KEEP_STATE
fn keep_vector(a: u32, word: u32, value: vec3<f32>) {
    let words = bitcast<vec3<u32>>(value);
    fields::set_before(a, word, words.x);
    fields::set_before(a, word + 1u, words.y);
    fields::set_before(a, word + 2u, words.z);
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn keep_state(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
#ifdef BODIES
    if (a < fields::parameters.bodies) {
        fields::keep_body(a);
    }
#endif
    if (a >= fields::control.live) {
        return;
    }
    let motion = fields::velocity_and_density(a);
    keep_vector(a, 0u, fields::sorted_position(a));
    fields::set_before(a, 3u, fields::sorted_id(a));
    keep_vector(a, 4u, motion.xyz);
    fields::set_before(a, 7u, bitcast<u32>(fields::sorted_remaining_life(a)));
    fields::set_before(a, 8u, bitcast<u32>(motion.w));
#ifdef INCOMPRESSIBLE
    fields::set_before(a, 9u, bitcast<u32>(fields::solved_pressure(a)));
#endif
#ifdef HISTORIES
    for (var word = 0u; word < #{PAST_WORDS}u; word++) {
        fields::set_before(a, 9u + word, bitcast<u32>(fields::sorted_history(a, word)));
    }
#ifdef KEPT_EXCESS
    fields::set_before(a, 9u + #{PAST_WORDS}u, bitcast<u32>(fields::excess(a)));
#endif
#endif
}
#endif

#ifdef RESTORE_STATE
fn kept_vector(a: u32, word: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3<u32>(fields::before(a, word), fields::before(a, word + 1u), fields::before(a, word + 2u)));
}

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn restore_state(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
#ifdef BODIES
    if (a < fields::parameters.bodies) {
        fields::restore_body(a);
    }
#endif
    if (a >= fields::control.live) {
        return;
    }
    let life = bitcast<f32>(fields::before(a, 7u));
    fields::set_particle(a, kept_vector(a, 0u), fields::before(a, 3u), kept_vector(a, 4u), life);
#ifdef INCOMPRESSIBLE
    let pressure = bitcast<f32>(fields::before(a, 9u));
    fields::set_solved_pressure(a, pressure);
    fields::set_density(a, bitcast<f32>(fields::before(a, 8u)), pressure);
#endif
#ifdef HISTORIES
    for (var word = 0u; word < #{HISTORY_WORDS}u; word++) {
        fields::set_history(a, word, bitcast<f32>(fields::before(a, 9u + word)));
    }
#endif
}
#endif
