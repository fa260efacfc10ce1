// Particles as shaded spheres. A quad that just covers the sphere is made from the vertex index; the fragment shader
// finds where its ray meets the sphere and writes that depth, so that fluid and meshes cut each other correctly. The last two
// fragment shaders are for surfaces (surface.wgsl).
//
// `FluidUniform`, `ParticleRecord` and the `FIELD_` constants are written in front of this text by Rust (bevy_freshet,
// rendering).

#import bevy_render::view::View
#ifdef TONEMAP_IN_SHADER
#import bevy_core_pipeline::tonemapping
#endif
#ifdef SRGB_OUTPUT
#import bevy_render::color_operations::linear_to_srgb
#endif
#ifdef OKLAB_OUTPUT
#import bevy_render::color_operations::linear_rgb_to_oklab
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var dt_lut_texture: texture_3d<f32>;
@group(0) @binding(2) var dt_lut_sampler: sampler;

@group(1) @binding(0) var<uniform> fluid: FluidUniform;
// In the domain's frame.
@group(1) @binding(1) var<storage, read> particles: array<ParticleRecord>;
// x: density, y: pressure over its square.
@group(1) @binding(2) var<storage, read> densities: array<vec2<f32>>;
@group(1) @binding(3) var<storage, read> accelerations: array<vec4<f32>>;

const PI: f32 = 3.14159265;

struct Vertex {
    @builtin(position) clip_position: vec4<f32>,
    // Where this point of the quad is, in the world.
    @location(0) world_position: vec3<f32>,
    @location(1) @interpolate(flat) center: vec3<f32>,
    @location(2) @interpolate(flat) color: vec3<f32>,
    // How open the particle lies: 1 at the surface, 0 deep inside.
    @location(3) @interpolate(flat) openness: f32,
}

fn is_orthographic() -> bool {
    return view.clip_from_view[3].w == 1.0;
}

// Unit vector from a point towards the eye.
fn towards_eye(point: vec3<f32>) -> vec3<f32> {
    if is_orthographic() {
        return normalize(view.world_from_view[2].xyz);
    }
    return normalize(view.world_position - point);
}

fn hash(id: u32) -> f32 {
    var x = id * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
    return f32((x >> 22u) ^ x) / 4294967295.0;
}

// Value of the field that colours, for particle i at `position` in the world.
fn field_value(i: u32, position: vec3<f32>) -> f32 {
    let density = densities[i];
    switch fluid.field {
        case FIELD_ID: { return hash(particles[i].id); }
        case FIELD_POSITION: { return position.y; }
        case FIELD_DENSITY: { return density.x; }
        case FIELD_PRESSURE: { return density.y * density.x * density.x; }
        case FIELD_ACCELERATION: { return length(accelerations[i].xyz); }
        case FIELD_REMAINING_LIFE: { return particles[i].remaining_life; }
        default: { return length(particles[i].velocity); }
    }
}

fn gradient(t: f32) -> vec3<f32> {
    let place = clamp(t, 0.0, 1.0) * f32(GRADIENT_COLORS - 1u);
    let index = min(u32(place), GRADIENT_COLORS - 2u);
    return mix(fluid.gradient[index].rgb, fluid.gradient[index + 1u].rgb, place - f32(index));
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) i: u32) -> Vertex {
    if i >= arrayLength(&particles) {
        // The count may be newer than the buffers, when the solver has just made room.
        return Vertex(vec4(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    }
    // The state is that of the last tick; what is drawn lies up to a tick before, as Bevy interpolates bodies.
    let local = particles[i].position - particles[i].velocity * fluid.lag;
    let center = (fluid.world_from_domain * vec4(local, 1.0)).xyz;

    // Three axes: towards the eye, and two across.
    let forward = towards_eye(center);
    let right = normalize(cross(view.world_from_view[1].xyz, forward));
    let up = cross(forward, right);
    var half_size = fluid.radius;
    if !is_orthographic() {
        // From close by a sphere's outline is wider than its radius.
        let distance = length(view.world_position - center);
        let beyond = max(distance * distance - half_size * half_size, 0.01 * half_size * half_size);
        half_size *= distance * inverseSqrt(beyond);
    }
    let across = vec2(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;

    var out: Vertex;
    out.center = center;
    out.world_position = center + (right * across.x + up * across.y) * half_size;
    out.clip_position = view.clip_from_world * vec4(out.world_position, 1.0);
    out.color = gradient((field_value(i, center) - fluid.range.x) * fluid.range.y);
    // A particle with few neighbours has a low density sum: it lies at the surface, or flies alone.
    out.openness = 1.0 - smoothstep(0.72, 1.0, densities[i].x * fluid.inverse_rest_density);
    return out;
}

struct Fragment {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
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

fn shade(n: vec3<f32>, v: vec3<f32>, color: vec3<f32>, openness: f32) -> vec3<f32> {
    let l = fluid.towards_light.xyz;
    let n_l = dot(n, l);
    // Light passes through a drop and comes out on its dark side: the terminator is soft.
    let wrap = 0.45;
    let diffuse = pow(saturate((n_l + wrap) / (1.0 + wrap)), 1.4);
    // Fluid around takes light from what lies deep.
    let occlusion = mix(0.5, 1.0, openness);
    let sky = mix(0.55, 1.0, n.y * 0.5 + 0.5);
    var light = color / PI * fluid.light.rgb * diffuse * mix(0.75, 1.0, openness);
    light += color * fluid.ambient.rgb * sky * occlusion;
    light += fluid.light.rgb * saturate(n_l) * 0.6 * specular(n, v, l, 0.36);
    // The sky's reflection makes the rim bright.
    let fresnel = 0.02 + 0.98 * pow(1.0 - saturate(dot(n, v)), 4.0);
    let horizon = fluid.ambient.rgb * 1.6 + fluid.light.rgb * 0.025;
    light += horizon * fresnel * sky * occlusion * 0.55;
    return light * view.exposure;
}

// From a ray's start backwards: half its way through the sphere, and how far the middle of that way is. The start is the quad's
// point: near the sphere, so that f32 does.
fn meet(in: Vertex, v: vec3<f32>) -> vec2<f32> {
    let offset = in.world_position - in.center;
    let b = dot(offset, v);
    let discriminant = b * b - dot(offset, offset) + fluid.radius * fluid.radius;
    if discriminant < 0.0 {
        discard;
    }
    return vec2(sqrt(discriminant), b);
}

@fragment
fn fragment(in: Vertex) -> Fragment {
    let v = towards_eye(in.world_position);
    let way = meet(in, v);
    let hit = in.world_position + v * (way.x - way.y);
    let n = (hit - in.center) / fluid.radius;
    let clip = view.clip_from_world * vec4(hit, 1.0);

    var color = vec4(shade(n, v, in.color, in.openness), 1.0);
#ifdef TONEMAP_IN_SHADER
    color = tonemapping::tone_mapping(color, view.color_grading);
#endif
#ifdef SRGB_OUTPUT
    color = vec4(linear_to_srgb(color.rgb), color.a);
#endif
#ifdef OKLAB_OUTPUT
    color = vec4(linear_rgb_to_oklab(color.rgb), color.a);
#endif
    return Fragment(color, clip.z / clip.w);
}

// For surfaces: how deep the nearest sphere lies, m.
struct Nearest {
    @location(0) depth: f32,
    @builtin(frag_depth) occlusion: f32,
}

@fragment
fn nearest(in: Vertex) -> Nearest {
    let v = towards_eye(in.world_position);
    let way = meet(in, v);
    let hit = vec4(in.world_position + v * (way.x - way.y), 1.0);
    let clip = view.clip_from_world * hit;
    return Nearest(-(view.view_from_world * hit).z, clip.z / clip.w);
}

// For surfaces: how much of this particle lies on the ray, m, and its colour times that.
@fragment
fn thickness(in: Vertex) -> @location(0) vec4<f32> {
    let way = 2.0 * meet(in, towards_eye(in.world_position)).x * fluid.fullness;
    return vec4(in.color, 1.0) * way;
}
