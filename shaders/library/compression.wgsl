// How far the fluid is compressed, for the report: the largest and the mean of all.
#define_import_path freshet::compression

#import freshet::bindings as fields
#import freshet::threads

// Compression is summed in integers, so that its mean has the same bits whatever the order.
const COMPRESSION_UNIT: f32 = 1048576.0;

var<workgroup> group_ratio: atomic<u32>;
var<workgroup> group_compression: atomic<u32>;

// Adds that of a particle.
fn add(density: f32) {
    let ratio = density * fields::parameters.inverse_rest_density;
    atomicMax(&group_ratio, threads::ordered_bits(ratio));
    let compression = clamp(ratio - 1.0, 0.0, 1.0);
    atomicAdd(&group_compression, u32(compression * COMPRESSION_UNIT));
}

// Adds that of the workgroup; for all of its threads.
fn finish(local: u32) {
    workgroupBarrier();
    if (local == 0u) {
        atomicMax(&fields::control.max_ratio, atomicLoad(&group_ratio));
        let added = atomicLoad(&group_compression);
        let before = atomicAdd(&fields::control.compression_low, added);
        if (before + added < before) {
            atomicAdd(&fields::control.compression_high, 1u);
        }
    }
}
