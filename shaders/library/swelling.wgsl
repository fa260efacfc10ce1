// Samples of bodies as far as these have swollen: see freshet_core::swelling.
#define_import_path freshet::swelling

#import freshet::bindings as fields
#import freshet::rotation

// A sample about its body's centre of mass, in world axes, m.
fn arm(k: u32, body: u32) -> vec3<f32> {
    let swollen = fields::body_swollen(body);
    let root = fields::sample_root(k);
    let offset = fields::sample_offset(k);
    let there = select(root + swollen * (offset - root), offset, swollen >= 1.0);
    return rotation::rotate(fields::body_rotation(body), there);
}

// m3
fn weight(k: u32, body: u32) -> f32 {
    let swollen = fields::body_swollen(body);
    return swollen * swollen * fields::sample_volume(k);
}
