// Coulomb friction, see freshet_core::scene::Friction.
#define_import_path freshet::coulomb

// What friction takes of an acceleration, with a velocity relative to the wall and `most` what it can hold, along the wall's normal.
fn taken(velocity: vec3<f32>, most: vec3<f32>, sliding: f32, dt: f32) -> vec3<f32> {
    let limit = length(most);
    if (limit <= 1e-30) {
        return vec3<f32>(0.0);
    }
    let normal = most / limit;
    let along = velocity - normal * dot(velocity, normal);
    let speed = length(along);
    if (speed > limit * dt) {
        return (sliding / speed) * along;
    }
    return select(vec3<f32>(0.0), along / dt, dt > 0.0);
}
