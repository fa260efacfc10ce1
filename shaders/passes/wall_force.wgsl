// What walls push by forces of their own, see freshet_core::wall_method. Added to the accelerations before the substep is chosen, which has to
// bear it.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::kernels
#import freshet::threads
#import freshet::wall_planes
#ifdef WALL_GHOSTS
#import freshet::equation_of_state
#import freshet::ghosts
#endif

var<workgroup> group_acceleration: atomic<u32>;

// What is nearer to a sample than this many spacings is pushed as at that distance.
const NEAREST: f32 = 0.5;

#ifdef WALL_LENNARD_JONES
// K/r^2 ((d/r)^12 - (d/r)^6) where r < d
fn push_over_r(r: f32) -> f32 {
    let spacing = fields::parameters.wall_spacing;
    let held = max(r, NEAREST * spacing);
    let ratio = spacing / held;
    let third = ratio * ratio * ratio;
    let sixth = third * third;
    return select(0.0, fields::parameters.wall_strength / (held * held) * (sixth * sixth - sixth), r < spacing);
}
#endif

#ifdef WALL_KERNEL_FORCING
// K d^3 W/r
fn push_over_r(r: f32) -> f32 {
    let shape = kernels::shape(r * fields::parameters.inverse_support_radius);
    return fields::parameters.wall_strength * shape / max(r, NEAREST * fields::parameters.wall_spacing);
}
#endif

#ifdef WALL_MONAGHAN
// 0.01 c^2/r^2 times a shape of q = r/h
fn push_over_r(r: f32) -> f32 {
    let q = 2.0 * r * fields::parameters.inverse_support_radius;
    let left = max(2.0 - q, 0.0);
    var shape = 0.5 * left * left;
    shape = select(shape, q * (2.0 - 1.5 * q), q < 1.0);
    shape = select(shape, 2.0 / 3.0, q < 2.0 / 3.0);
    let held = max(r, NEAREST * fields::parameters.wall_spacing);
    return fields::parameters.wall_strength / (held * held) * shape;
}
#endif

#ifdef WALL_GHOSTS
// What the particles around the image of a particle in the planes of a mask do to it: (P_a + P_b + Pi) f'(q)/q x and Morris' term, as acceleration.wgsl has them.
fn from_images(position: vec3<f32>, own: vec4<f32>, planes: ptr<function, wall_planes::Planes>, mask: u32) -> vec3<f32> {
    let sticks = ghosts::sticking(planes) & mask;
    let image = position + ghosts::way(planes, mask);
    let place = grid::place_of(image);
    let extent = grid::shape();
    let own_term = equation_of_state::pressure_term(own.w);
    let softening = fields::parameters.viscosity_softening;
    let inverse_radius = fields::parameters.inverse_support_radius;
    var sum = vec3<f32>(0.0);
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let around = grid::row_of(0u, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < around.count; t++) {
            let b = grid::member(around, t);
            let apart = grid::difference(image, fields::sorted_position(b));
            let squared = dot(apart, apart);
            let q = sqrt(squared) * inverse_radius;
            if (q >= 1.0) {
                continue;
            }
            let x = ghosts::image(planes, mask, 0u, apart);
            let other = fields::velocity_and_density(b);
            let velocity = own.xyz - ghosts::image(planes, mask, sticks, other.xyz);
            let softened = squared + softening;
            let artificial = fields::parameters.viscosity_scale * dot(velocity, x) / (softened * (own.w + other.w));
            let strength = own_term + equation_of_state::pressure_term(other.w) - artificial;
            let exchange = fields::parameters.pair_viscosity * squared / (softened * own.w * other.w);
            sum += kernels::slope_over_q(q) * (strength * x - exchange * velocity);
        }
    }
    return sum;
}

fn push_of_images(position: vec3<f32>, own: vec4<f32>, place: grid::Place) -> vec3<f32> {
    var planes = wall_planes::planes_at(position, place);
    var sum = vec3<f32>(0.0);
    for (var mask = 1u; mask < (1u << planes.count); mask++) {
        if (ghosts::is_image(&planes, mask)) {
            sum += from_images(position, own, &planes, mask);
        }
    }
    return -fields::parameters.fluid_force_scale * sum;
}
#else ifdef WALL_SPRINGS
fn push_on(position: vec3<f32>, velocity: vec3<f32>, place: grid::Place) -> vec3<f32> {
    var planes = wall_planes::planes_at(position, place);
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < planes.count; i++) {
        let face = planes.faces[i];
        sum += wall_planes::spring_push(face.w, dot(velocity, face.xyz)) * face.xyz;
    }
    return sum;
}
#else
fn push_on(position: vec3<f32>, velocity: vec3<f32>, place: grid::Place) -> vec3<f32> {
    let extent = grid::shape();
    let wall_starts = fields::parameters.wall_starts;
    let reach = fields::parameters.squared_support_radius;
    var sum = vec3<f32>(0.0);
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let walls = grid::row_of(wall_starts, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < walls.count; t++) {
            let x = grid::difference(position, fields::sample(grid::member(walls, t)).position);
            let squared = dot(x, x);
            if (squared < reach) {
                sum += push_over_r(sqrt(squared)) * x;
            }
        }
    }
    return sum;
}
#endif

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn wall_force(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a < fields::control.live) {
        let position = fields::sorted_position(a);
        let place = grid::place_of(position);
        if (grid::is_near_walls(place.cell)) {
            let own = fields::velocity_and_density(a);
#ifdef WALL_GHOSTS
            let pushed = fields::acceleration(a) + push_of_images(position, own, place);
#else
            let pushed = fields::acceleration(a) + push_on(position, own.xyz, place);
#endif
            fields::set_acceleration(a, pushed);
            atomicMax(&group_acceleration, threads::ordered_bits(length(pushed)));
        }
    }
    workgroupBarrier();
    if (local == 0u) {
        atomicMax(&fields::control.max_acceleration, atomicLoad(&group_acceleration));
    }
}
