// Images of the fluid in the planes of walls around a particle, see freshet_core::wall_method::ghosts. A mask says in which of the planes.
#define_import_path freshet::ghosts

#import freshet::bindings as fields
#import freshet::wall_planes

// Cosine between two normals up to which faces are at right angles.
const RIGHT: f32 = 0.01;

// Whether there is an image in several planes at once, near enough to the fluid: they are at right angles to each other.
fn is_image(planes: ptr<function, wall_planes::Planes>, mask: u32) -> bool {
    var squared = 0.0;
    for (var i = 0u; i < (*planes).count; i++) {
        let distance = (*planes).faces[i].w;
        squared += select(0.0, distance * distance, (mask & (1u << i)) != 0u);
        for (var j = 0u; j < i; j++) {
            let both = (1u << i) | (1u << j);
            if ((mask & both) == both && abs(dot((*planes).faces[i].xyz, (*planes).faces[j].xyz)) > RIGHT) {
                return false;
            }
        }
    }
    return squared < fields::parameters.squared_support_radius;
}

// From the particle to its image, m.
fn way(planes: ptr<function, wall_planes::Planes>, mask: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < (*planes).count; i++) {
        if ((mask & (1u << i)) != 0u) {
            sum -= 2.0 * (*planes).faces[i].w * (*planes).faces[i].xyz;
        }
    }
    return sum;
}

// A vector, mirrored in the planes of a mask, and turned round for each that is among those that stick: for these it is not mirrored.
fn image(planes: ptr<function, wall_planes::Planes>, mask: u32, sticks: u32, vector: vec3<f32>) -> vec3<f32> {
    var result = vector;
    for (var i = 0u; i < (*planes).count; i++) {
        let bit = 1u << i;
        if ((sticks & bit) != 0u) {
            result = -result;
        } else if ((mask & bit) != 0u) {
            let normal = (*planes).faces[i].xyz;
            result -= 2.0 * dot(result, normal) * normal;
        }
    }
    return result;
}

// Which of the planes are of viscous faces.
fn sticking(planes: ptr<function, wall_planes::Planes>) -> u32 {
    var mask = 0u;
    for (var i = 0u; i < (*planes).count; i++) {
        mask |= select(0u, 1u << i, fields::sample((*planes).samples[i]).viscous_weight > 0.0);
    }
    return mask;
}
