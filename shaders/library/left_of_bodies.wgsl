// What an iteration of a divergence solve leaves around each body.
#define_import_path freshet::left_of_bodies

#import freshet::bindings as fields
#import freshet::solve
#import freshet::touch

// Adds what is wrong of a particle to the sums of the bodies it touches.
fn add(a: u32, change: f32, left: f32, least: f32) {
    let body = fields::touch(a) & ~touch::SWELLS;
    if (body == touch::NOBODY) {
        return;
    }
    // Where there is no pressure left to take away, a fluid that parts is as it should be.
    let units = solve::left_units(select(abs(left), 0.0, change <= least && left < 0.0));
    if (body != touch::SEVERAL) {
        fields::add_body_left(body - 1u, units);
        return;
    }
    var found = touch::after(a, 0u);
    while (found.body != touch::NOBODY) {
        fields::add_body_left(found.body - 1u, units);
        found = touch::after(a, found.body);
    }
}
