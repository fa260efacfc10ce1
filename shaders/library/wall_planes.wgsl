// The faces of walls around a particle, as freshet_core::wall_method::Plane finds them: that of the nearest sample, then of the nearest of
// those whose normal is 60 degrees or more from it, up to three.
#define_import_path freshet::wall_planes

#import freshet::bindings as fields
#import freshet::grid

// As many as meet in the corner of a room.
const MOST_PLANES: u32 = 3u;

// How far beside a sample, in spacings, its face reaches.
const LATERAL_REACH: f32 = 0.01 * f32(#{WALL_LATERAL_PERCENT}u);

// Cosine between the normals of two faces from which on they count as one.
const SAME: f32 = 0.5;

// Normals to the fluid, with the particle's distances, negative behind a face, and the samples they are of.
struct Planes {
    faces: array<vec4<f32>, 3>,
    samples: array<u32, 3>,
    count: u32,
}

fn is_known(planes: ptr<function, Planes>, normal: vec3<f32>) -> bool {
    for (var i = 0u; i < (*planes).count; i++) {
        if (dot((*planes).faces[i].xyz, normal) > SAME) {
            return true;
        }
    }
    return false;
}

// Adds the plane of the nearest sample that is of none of the planes found so far; whether there is one.
fn add_plane(position: vec3<f32>, place: grid::Place, planes: ptr<function, Planes>) -> bool {
    let extent = grid::shape();
    let wall_starts = fields::parameters.wall_starts;
    let spacing = fields::parameters.wall_spacing;
    let lateral = LATERAL_REACH * spacing;
    var nearest = fields::parameters.wall_reach * fields::parameters.wall_reach;
    var face = vec4<f32>(0.0);
    var of_sample = 0u;
    var found = false;
    for (var row = 0u; row < 9u; row++) {
        let reached = grid::reached(place, row);
        let walls = grid::row_of(wall_starts, grid::cells_of(extent, place.cell, row, reached.x, reached.y));
        for (var t = 0u; t < walls.count; t++) {
            let k = grid::member(walls, t);
            let x = grid::difference(position, fields::sample(k).position);
            let squared = dot(x, x);
            if (squared >= nearest) {
                continue;
            }
            let own = fields::wall_face(k);
            let height = dot(x, own.xyz);
            if (squared - height * height < lateral * lateral && !is_known(planes, own.xyz)) {
                nearest = squared;
                face = vec4<f32>(own.xyz, height - own.w);
                of_sample = k;
                found = true;
            }
        }
    }
    if (found) {
        (*planes).faces[(*planes).count] = face;
        (*planes).samples[(*planes).count] = of_sample;
        (*planes).count += 1u;
    }
    return found;
}

fn planes_at(position: vec3<f32>, place: grid::Place) -> Planes {
    var planes: Planes;
    while (planes.count < MOST_PLANES && add_plane(position, place, &planes)) {}
    return planes;
}

// What a spring pushes along the normal, m/s2, of what is at a distance of its face and goes away from it so fast.
fn spring_push(distance: f32, leaving: f32) -> f32 {
    let nearer = 0.5 * fields::parameters.wall_spacing - distance;
    let push = fields::parameters.wall_strength * nearer - fields::parameters.wall_damping * leaving;
    return select(0.0, max(push, 0.0), nearer > 0.0);
}
