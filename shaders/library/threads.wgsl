// Which element a thread works on, and totals of a workgroup.
#define_import_path freshet::threads

// Indirect dispatches wrap into rows of MAX_WORKGROUPS groups, the most WebGPU allows along one axis. The builtin
// num_workgroups is not used for this: Direct3D 12 needs an extra validation pass to fill it for indirect dispatches.
fn thread_index(group: vec3<u32>, local: u32) -> u32 {
    return group_index(group) * #{WORKGROUP_SIZE}u + local;
}

fn group_index(group: vec3<u32>) -> u32 {
    return group.y * #{MAX_WORKGROUPS}u + group.x;
}

// Groups of an indirect dispatch for `count` threads.
fn groups_for(count: u32) -> vec3<u32> {
    return group_grid((count + #{WORKGROUP_SIZE}u - 1u) / #{WORKGROUP_SIZE}u);
}

fn group_grid(groups: u32) -> vec3<u32> {
    let rows = (groups + #{MAX_WORKGROUPS}u - 1u) / #{MAX_WORKGROUPS}u;
    return vec3<u32>(min(groups, #{MAX_WORKGROUPS}u), rows, min(groups, 1u));
}

// Whether a number is neither infinite nor not-a-number. Compilers may assume that floats are finite, so it is the bits
// that are looked at.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn all_finite(v: vec3<f32>) -> bool {
    return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}

// The bits of a non-negative number, which compare as it does; zero for what is not finite.
fn ordered_bits(x: f32) -> u32 {
    return select(0u, bitcast<u32>(x), is_finite(x));
}
