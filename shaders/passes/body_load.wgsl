// Force and torque of the fluid on each body. Sample k feels (1/G) m rho0 V_k sum_a (P_a + P_k) F x_ak, P_k being zero but for quasi-fluid: the opposite of what the
// particles felt from it. Fluid that sticks to the body gives it the opposite of its drag too, at the place of the particle: to each
// sample its share of the sum of V_k F that the drag is by, see body_drag.wgsl.
//
// body_load, body_sum: by the pressures, and how many samples the fluid reaches; of an incompressible fluid by those of the last substep.
// friction_sum: adds what body_friction.wgsl left on the samples.
// body_push, body_answer: in an iteration of its divergence solve by the change of pressures, and how bodies answer.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::kernels
#import freshet::pressure_kernels
#import freshet::swelling
#import freshet::viscosity_kernels
#ifdef QUASI_FLUID
#import freshet::quasi_fluid
#endif
#import freshet::threads

#ifndef BODY_SUM
#ifndef BODY_ANSWER
#ifndef FRICTION_SUM
fn pressure_of(a: u32) -> f32 {
#ifdef BODY_PUSH
    return fields::change(a);
#else
#ifdef INCOMPRESSIBLE
    return fields::solved_pressure(a);
#else
    return fields::pressure_term(a);
#endif
#endif
}

fn load_sample(k: u32) {
    let body = fields::body_of_sample(k);
    let arm = swelling::arm(k, body);
    let position = fields::body_position(body) + arm;
    if (!threads::all_finite(position)) {
        fields::set_sample_load(k, vec3<f32>(0.0), vec3<f32>(0.0), 0.0);
        return;
    }
    let place = grid::place_of(position);
    let extent = grid::shape();
    let inverse_radius = fields::parameters.inverse_support_radius;
    var sum = vec3<f32>(0.0);
    var wet = 0.0;
#ifdef QUASI_FLUID
    var shapes = 0.0;
    var slopes = vec3<f32>(0.0);
#endif
#ifdef BODY_LOAD
#ifdef STICKING_BODIES
    var drag = vec3<f32>(0.0);
    var drag_torque = vec3<f32>(0.0);
#endif
#endif
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let around = grid::row_of(0u, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let a = grid::member(around, t);
            let x = grid::difference(fields::sorted_position(a), position);
            let q = length(x) * inverse_radius;
            wet = select(wet, 1.0, q < 1.0);
            let slope = pressure_kernels::slope_over_q(q);
            sum += (pressure_of(a) * slope) * x;
#ifdef QUASI_FLUID
            shapes += kernels::shape(q);
            slopes += slope * x;
#endif
#ifdef BODY_LOAD
#ifdef STICKING_BODIES
            if (fields::contact_body(a) == body + 1u) {
                let share = viscosity_kernels::slope_over_q(q) * fields::contact_force(a);
                drag += share;
                drag_torque += cross(arm + x, share);
            }
#endif
#endif
        }
    }
#ifdef QUASI_FLUID
    sum += quasi_fluid::pressure_term(k, body, shapes) * slopes;
#endif
    let weight = swelling::weight(k, body);
    var force = (fields::parameters.body_force_scale * weight) * sum;
    var torque = cross(arm, force);
#ifdef BODY_LOAD
#ifdef STICKING_BODIES
    force += weight * drag;
    torque += weight * drag_torque;
#endif
#endif
    fields::set_sample_load(k, force, torque, wet);
}
#endif
#endif
#endif

#ifdef BODY_LOAD
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_load(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k < fields::parameters.body_samples) {
        load_sample(k);
    }
}
#endif

#ifdef BODY_PUSH
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_push(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let k = threads::thread_index(group, local);
    if (k < fields::parameters.body_samples) {
        load_sample(k);
    }
}
#endif

#ifndef BODY_LOAD
#ifndef BODY_PUSH
// A fixed tree, whatever the size of a workgroup: LEAVES sums of every LEAVES-th sample, then halves onto halves.
const LEAVES: u32 = 256u;

var<workgroup> force: array<vec3<f32>, LEAVES>;
var<workgroup> torque: array<vec3<f32>, LEAVES>;
#ifdef BODY_SUM
var<workgroup> wet: array<f32, LEAVES>;
#endif

// Sums over the samples of a body, into the first leaf; one workgroup a body.
fn sum_samples(body: u32, local: u32) {
    var first = 0u;
    var end = 0u;
    if (body < fields::parameters.bodies) {
        first = fields::body_first_sample(body);
        end = first + fields::body_sample_count(body);
    }
    for (var leaf = local; leaf < LEAVES; leaf += #{WORKGROUP_SIZE}u) {
        var leaf_force = vec3<f32>(0.0);
        var leaf_torque = vec3<f32>(0.0);
#ifdef BODY_SUM
        var leaf_wet = 0.0;
#endif
        for (var k = first + leaf; k < end; k += LEAVES) {
            leaf_force += fields::sample_force(k);
            leaf_torque += fields::sample_torque(k);
#ifdef BODY_SUM
            leaf_wet += fields::sample_wet(k);
#endif
        }
        force[leaf] = leaf_force;
        torque[leaf] = leaf_torque;
#ifdef BODY_SUM
        wet[leaf] = leaf_wet;
#endif
    }
    workgroupBarrier();
    for (var half = LEAVES / 2u; half > 0u; half /= 2u) {
        for (var leaf = local; leaf < half; leaf += #{WORKGROUP_SIZE}u) {
            force[leaf] += force[leaf + half];
            torque[leaf] += torque[leaf + half];
#ifdef BODY_SUM
            wet[leaf] += wet[leaf + half];
#endif
        }
        workgroupBarrier();
    }
}
#endif
#endif

#ifdef BODY_SUM
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_sum(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let body = threads::group_index(group);
    sum_samples(body, local);
    if (local == 0u && body < fields::parameters.bodies) {
        fields::set_body_load(body, force[0], torque[0]);
        fields::set_body_wetted(body, u32(wet[0]));
#ifdef INCOMPRESSIBLE
        fields::begin_answer(body, fields::body_inverse_mass(body) > 0.0 || fields::body_swollen(body) < 1.0);
#endif
    }
}
#endif

#ifdef BODY_ANSWER
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn body_answer(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let body = threads::group_index(group);
    sum_samples(body, local);
    if (local == 0u && body < fields::parameters.bodies) {
        let linear = force[0] * fields::body_inverse_mass(body);
        let angular = fields::body_inverse_inertia(body) * torque[0];
        fields::set_answer(body, force[0], torque[0], linear, angular);
    }
}
#endif

#ifdef FRICTION_SUM
@compute @workgroup_size(#{WORKGROUP_SIZE})
fn friction_sum(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let body = threads::group_index(group);
    sum_samples(body, local);
    if (local == 0u && body < fields::parameters.bodies) {
        fields::set_body_load(body, fields::body_force(body) + force[0], fields::body_torque(body) + torque[0]);
    }
}
#endif
