// How a particle of an incompressible fluid touches bodies, for each body: g = sum_k V_k grad W_ak and
// t = sum_k V_k r_k x grad W_ak over its samples (freshet_core::pressure_solver::DivergenceFree), in units of rho0/m A/H^5.
#define_import_path freshet::touch

#import freshet::bindings as fields
#import freshet::grid
#import freshet::hits
#import freshet::pressure_kernels

// Bodies are counted from one here. What is kept of a particle: the body that it touches, or one of these; and whether one of those that
// it touches swells.
const NOBODY: u32 = 0u;
const SEVERAL: u32 = 0x7fffffffu;
const SWELLS: u32 = 0x80000000u;

struct Touch {
    // The body, or NOBODY.
    body: u32,
    // Whether it touches another one with a higher number.
    more: bool,
    // g, m.
    push: vec3<f32>,
    // t, m2.
    turn: vec3<f32>,
}

// The first body after `last` that a particle touches. One time round for each body of a particle, of which there is seldom more than one.
fn after(a: u32, last: u32) -> Touch {
    let position = fields::sorted_position(a);
    let center = grid::cell_of(position);
    let extent = grid::shape();
    let body_starts = fields::parameters.body_starts;
    let squared_radius = fields::parameters.squared_support_radius;
    var found: Touch;
    for (var row = 0u; row < 9u; row++) {
        var word = 0u;
        if (row == hits::OWN_ROW) {
            word = fields::own_row(a);
        } else {
            word = fields::hits_of(a, hits::word_of(row));
        }
        if ((word & hits::SAMPLES) == 0u) {
            continue;
        }
        let samples = grid::row_of(body_starts, grid::cells_of(extent, center, row, word & hits::BEGIN, grid::ROW_CELLS));
        for (var t = 0u; t < samples.count; t++) {
            let k = grid::member(samples, t);
            let sample = fields::sample(k);
            let x = grid::difference(position, sample.position);
            let arm = fields::sample_arm(k);
            let body = arm.body + 1u;
            if (dot(x, x) >= squared_radius || body <= last) {
                continue;
            }
            if (found.body != NOBODY && body != found.body) {
                found.more = true;
                if (body > found.body) {
                    continue;
                }
                found.push = vec3<f32>(0.0);
                found.turn = vec3<f32>(0.0);
            }
            found.body = body;
            let slope = pressure_kernels::slope_over_q(length(x) * fields::parameters.inverse_support_radius);
            let push = (sample.weight * slope) * x;
            found.push += push;
            found.turn += cross(arm.offset, push);
        }
    }
    found.push *= fields::parameters.number_density;
    found.turn *= fields::parameters.number_density;
    return found;
}

// What a body adds to the diagonal is a product of `size`s: c_aB of freshet_core::pressure_solver::DivergenceFree.
fn size(touch: Touch) -> f32 {
    let body = touch.body - 1u;
    let turned = dot(touch.turn, fields::body_inverse_inertia(body) * touch.turn);
    return sqrt(max(fields::body_inverse_mass(body) * dot(touch.push, touch.push) + turned, 0.0));
}

// Their sum is one of integers, so that it has the same bits whatever the order: so many to what a push of H would make.
const UNIT: f32 = 1048576.0;

// Zero for what nothing moves.
fn unit_of(body: u32) -> f32 {
    let inertia = fields::body_inverse_inertia(body);
    let reach = fields::body_reach(body) + 1.0 / fields::parameters.inverse_support_radius;
    let turning = sqrt(dot(inertia[0], inertia[0]) + dot(inertia[1], inertia[1]) + dot(inertia[2], inertia[2]));
    let of_push = sqrt(fields::body_inverse_mass(body) + reach * reach * turning);
    return of_push / (fields::parameters.inverse_support_radius * UNIT);
}
