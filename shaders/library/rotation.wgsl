// Unit quaternions, (x, y, z, w).
#define_import_path freshet::rotation

fn rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

fn multiply(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

// `q`, then turned about the axis `turn` by its length in radians.
fn turned(q: vec4<f32>, turn: vec3<f32>) -> vec4<f32> {
    let angle = length(turn);
    // sin(angle / 2) / angle, which is 1/2 where the angle vanishes.
    let share = select(sin(0.5 * angle) / angle, 0.5, angle < 1e-6);
    return normalize(multiply(vec4<f32>(turn * share, cos(0.5 * angle)), q));
}

// The turn that takes `a` to `b` the shorter way round: its axis times its angle in radians.
fn between(a: vec4<f32>, b: vec4<f32>) -> vec3<f32> {
    var q = multiply(b, vec4<f32>(-a.xyz, a.w));
    q = select(q, -q, q.w < 0.0);
    let sine = length(q.xyz);
    // Angle over the sine of its half, which is 2 where the angle vanishes.
    let share = select(2.0 * atan2(sine, q.w) / sine, 2.0, sine < 1e-6);
    return share * q.xyz;
}
