// A surface around particles, in screen space: smooths the depth of their spheres, takes normals from it, and lights it.
//
// `FluidUniform` is written in front of this text by Rust (bevy_freshet, rendering).

#import bevy_render::view::View
#ifdef TONEMAP_IN_SHADER
#import bevy_core_pipeline::tonemapping
#endif
#ifdef SRGB_OUTPUT
#import bevy_render::color_operations::{linear_to_srgb, srgb_to_linear}
#endif
#ifdef OKLAB_OUTPUT
#import bevy_render::color_operations::{linear_rgb_to_oklab, oklab_to_linear_rgb}
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var dt_lut_texture: texture_3d<f32>;
@group(0) @binding(2) var dt_lut_sampler: sampler;

@group(1) @binding(0) var<uniform> fluid: FluidUniform;
// m below the eye's plane; zero where there is no fluid.
@group(1) @binding(1) var depths: texture_2d<f32>;
// Colour times thickness, and thickness, m.
@group(1) @binding(2) var thicknesses: texture_2d<f32>;
// What is seen through the fluid.
@group(1) @binding(3) var scene: texture_2d<f32>;
@group(1) @binding(4) var scene_sampler: sampler;

const PI: f32 = 3.14159265;
// Most pixels to either side that are smoothed over.
const MOST_PIXELS: i32 = 32;
// How far in front or behind a point still belongs to the same surface, in radii of a sphere.
const SAME_SURFACE: f32 = 3.0;

@vertex
fn vertex(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    // A triangle twice as large as the screen.
    return vec4(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn is_orthographic() -> bool {
    return view.clip_from_view[3].w == 1.0;
}

// Pixels to a metre at a depth.
fn pixels_per_metre(depth: f32) -> f32 {
    let focal = 0.5 * view.clip_from_view[1].y * view.viewport.w;
    return select(focal / depth, focal, is_orthographic());
}

fn depth_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(depths, clamp(pixel, vec2(0), vec2<i32>(textureDimensions(depths)) - 1), 0).x;
}

// The point at a depth in a pixel, in view space.
fn point_at(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    let share = (vec2<f32>(pixel) + 0.5 - view.viewport.xy) / view.viewport.zw;
    let near = view.view_from_clip * vec4(share.x * 2.0 - 1.0, 1.0 - share.y * 2.0, 1.0, 1.0);
    let point = near.xyz / near.w;
    if is_orthographic() {
        return vec3(point.xy, -depth);
    }
    return point * (depth / -point.z);
}

@fragment
fn smooth_depth(@builtin(position) position: vec4<f32>) -> @location(0) f32 {
    let pixel = vec2<i32>(position.xy);
    let depth = depth_at(pixel);
    if depth == 0.0 {
        return 0.0;
    }
#ifdef ALONG_ROWS
    let along = vec2(1, 0);
#else
    let along = vec2(0, 1);
#endif
    let reach = clamp(i32(fluid.smoothing * pixels_per_metre(depth)), 0, MOST_PIXELS);
    let range = SAME_SURFACE * fluid.radius;
    let falloff = 2.0 / f32(max(reach * reach, 1));
    var sum = depth;
    var weights = 1.0;
    for (var i = 1; i <= reach; i += 1) {
        let one = depth_at(pixel + i * along);
        let other = depth_at(pixel - i * along);
        // In pairs, so that a slope stays one beside an edge.
        if abs(one - depth) < range && abs(other - depth) < range {
            let weight = exp(-falloff * f32(i * i));
            sum += weight * (one + other);
            weights += 2.0 * weight;
        }
    }
    return sum / weights;
}

// From this pixel's point to the next one along an axis; of both sides, the one that is less of a step.
fn slope(pixel: vec2<i32>, along: vec2<i32>, here: vec3<f32>) -> vec3<f32> {
    let next = depth_at(pixel + along);
    let last = depth_at(pixel - along);
    let ahead = point_at(pixel + along, next) - here;
    let behind = here - point_at(pixel - along, last);
    if next == 0.0 && last == 0.0 {
        return point_at(pixel + along, -here.z) - here;
    }
    if last == 0.0 || (next != 0.0 && abs(ahead.z) < abs(behind.z)) {
        return ahead;
    }
    return behind;
}

// Mean colour of the fluid behind a pixel, and its thickness, over what a sphere covers: single ones are not to be seen.
fn fluid_behind(pixel: vec2<i32>, depth: f32) -> vec4<f32> {
    let last = vec2<i32>(textureDimensions(thicknesses)) - 1;
    let stride = clamp(0.8 * fluid.radius * pixels_per_metre(depth), 1.0, 24.0);
    var sum = vec4(0.0);
    var weights = 0.0;
    for (var y = -2; y <= 2; y += 1) {
        for (var x = -2; x <= 2; x += 1) {
            let place = pixel + vec2<i32>(vec2(f32(x), f32(y)) * 0.5 * stride);
            if depth_at(place) == 0.0 {
                continue;
            }
            let weight = exp(-0.35 * f32(x * x + y * y));
            sum += weight * textureLoad(thicknesses, clamp(place, vec2(0), last), 0);
            weights += weight;
        }
    }
    let mean = sum / max(weights, 1e-6);
    return vec4(mean.rgb / max(mean.a, 1e-6), mean.a);
}

// GGX with Smith's visibility, both in Filament's form.
fn specular(n: vec3<f32>, v: vec3<f32>, l: vec3<f32>, roughness: f32) -> f32 {
    let h = normalize(v + l);
    let n_h = saturate(dot(n, h));
    let n_v = max(dot(n, v), 1e-3);
    let n_l = saturate(dot(n, l));
    let a = roughness * roughness;
    let k = n_h * n_h * (a * a - 1.0) + 1.0;
    let d = a * a / (PI * k * k);
    let g = 0.5 / mix(2.0 * n_l * n_v, n_l + n_v, a);
    let f = 0.02 + 0.98 * pow(1.0 - saturate(dot(v, h)), 5.0);
    return d * g * f;
}

// The sky in a direction.
fn sky(direction: vec3<f32>) -> vec3<f32> {
    let horizon = fluid.ambient.rgb * 1.3 + fluid.light.rgb * 0.02;
    let zenith = fluid.ambient.rgb * vec3(0.45, 0.65, 0.95);
    let ground = fluid.ambient.rgb * 0.35;
    return select(mix(horizon, ground, saturate(-4.0 * direction.y)), mix(horizon, zenith, sqrt(saturate(direction.y))), direction.y > 0.0);
}

struct Lit {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn light_surface(@builtin(position) position: vec4<f32>) -> Lit {
    let pixel = vec2<i32>(position.xy);
    let depth = depth_at(pixel);
    if depth == 0.0 {
        discard;
    }
    let point = point_at(pixel, depth);
    // Rows go down on the screen.
    let bent = normalize(cross(slope(pixel, vec2(0, 1), point), slope(pixel, vec2(1, 0), point)));
    let normal = select(bent, -bent, bent.z < 0.0);
    let toward = select(normalize(-point), vec3(0.0, 0.0, 1.0), is_orthographic());
    let n = normalize((view.world_from_view * vec4(normal, 0.0)).xyz);
    let v = normalize((view.world_from_view * vec4(toward, 0.0)).xyz);
    let l = fluid.towards_light.xyz;

    let behind = fluid_behind(pixel, depth);
    let color = behind.rgb;
    // What is nearly white is foam: air takes the light that water would let through.
    let foam = smoothstep(0.35, 0.85, min(color.r, min(color.g, color.b)));
    let tint = color / max(max(color.r, max(color.g, color.b)), 1e-4);
    let taken = (1.05 - 0.85 * tint + 8.0 * foam) * behind.a * fluid.inverse_clarity;
    let through = exp(-taken);
    let fresnel = 0.02 + 0.98 * pow(1.0 - saturate(dot(n, v)), 5.0);

    // What is behind is seen bent by the surface, the more the thicker the fluid is.
    let size = vec2<f32>(textureDimensions(scene));
    let shift = -normal.xy * vec2(1.0, -1.0) * 0.25 * min(behind.a, 4.0 * fluid.radius) * pixels_per_metre(depth);
    var seen = textureSampleLevel(scene, scene_sampler, (position.xy + shift) / size, 0.0).rgb;
#ifdef SRGB_OUTPUT
    seen = srgb_to_linear(seen);
#endif
#ifdef OKLAB_OUTPUT
    seen = oklab_to_linear_rgb(seen);
#endif

    // Light that the fluid scatters back, and that of sky and sun in its mirror.
    let n_l = dot(n, l);
    let diffuse = pow(saturate((n_l + 0.4) / 1.4), 1.2);
    let scattered = color * (fluid.light.rgb / PI * diffuse + fluid.ambient.rgb * mix(0.6, 1.0, n.y * 0.5 + 0.5));
    var lit = scattered * (1.0 - through) * (1.0 - fresnel);
    lit += sky(reflect(-v, n)) * fresnel * mix(1.0, 0.4, foam);
    lit += fluid.light.rgb * saturate(n_l) * specular(n, v, l, 0.18);
    var out = vec4(lit * view.exposure, 1.0);
#ifdef TONEMAP_IN_SHADER
    out = tonemapping::tone_mapping(out, view.color_grading);
#endif
    // What is seen has been mapped to the display already, where shaders do that.
    out = vec4(out.rgb + seen * through * (1.0 - fresnel), 1.0);
#ifdef SRGB_OUTPUT
    out = vec4(linear_to_srgb(out.rgb), out.a);
#endif
#ifdef OKLAB_OUTPUT
    out = vec4(linear_rgb_to_oklab(out.rgb), out.a);
#endif
    let clip = view.clip_from_view * vec4(point, 1.0);
    return Lit(out, clip.z / clip.w);
}
