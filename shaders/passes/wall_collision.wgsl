// Puts particles back that got into walls, see freshet_core::wall_method::Penalty.

#import freshet::bindings as fields
#import freshet::grid
#import freshet::threads
#import freshet::wall_planes

@compute @workgroup_size(#{WORKGROUP_SIZE})
fn wall_collision(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let a = threads::thread_index(group, local);
    if (a >= fields::control.live) {
        return;
    }
    let start = fields::position(a);
    let place = grid::place_of(start);
    if (!grid::is_near_walls(place.cell) || fields::control.substep <= 0.0) {
        return;
    }
    var planes = wall_planes::planes_at(start, place);
    var position = start;
    var velocity = fields::velocity(a);
    let dt = fields::control.substep;
    let contact = 0.01 * f32(#{WALL_CONTACT_PERCENT}u) * fields::parameters.wall_spacing;
    let bounce = fields::parameters.wall_bounce;
    for (var i = 0u; i < planes.count; i++) {
        let normal = planes.faces[i].xyz;
        let depth = contact - planes.faces[i].w - dot(position - start, normal);
#ifdef WALL_ONE_WAY
        // A face that could only stop what moves against the way is not there.
        if (dot(normal, fields::parameters.wall_way) > 1.0) {
            continue;
        }
#endif
        if (depth <= 0.0) {
            continue;
        }
        let across = dot(velocity, normal);
        var back = depth;
        if (across < 0.0) {
            let along = velocity - across * normal;
            var leaving = -bounce * across;
#ifdef WALL_SHARE
            leaving *= depth / max(-across * dt, depth);
#endif
#ifdef WALL_MIRRORED
            back *= 1.0 + bounce;
#endif
            velocity = fields::parameters.wall_slip * along + leaving * normal;
        }
        position += back * normal;
    }
#ifdef PERIODIC
    position = grid::wrapped(position);
#endif
    fields::set_particle(a, position, fields::id(a), velocity, fields::remaining_life(a));
}
