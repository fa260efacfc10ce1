// Exclusive prefix sum over the cells of one section of the cell tables, in two dispatches: totals of blocks of
// SCAN_BLOCK cells, then every block adds up the totals before it and scans itself. Integers: any order, same bits.
#define_import_path freshet::scan

#import freshet::bindings as fields

// Cells one thread handles.
const SHARE: u32 = #{SCAN_BLOCK}u / #{WORKGROUP_SIZE}u;

var<workgroup> total: atomic<u32>;
var<workgroup> partial: array<u32, #{WORKGROUP_SIZE}>;

// First dispatch: writes the block's total. `base` is where the section's counts begin, `cells` how many there are.
fn sum_block(block: u32, local: u32, base: u32, cells: u32) {
    var sum = 0u;
    for (var k = 0u; k < SHARE; k++) {
        let cell = block * #{SCAN_BLOCK}u + k * #{WORKGROUP_SIZE}u + local;
        if (cell < cells) {
            sum += fields::cell_count(base + cell);
        }
    }
    atomicAdd(&total, sum);
    workgroupBarrier();
    if (local == 0u) {
        fields::set_cell_start(fields::parameters.block_sums + block, atomicLoad(&total));
    }
}

// Second dispatch: the sum of all cells before the thread's own, which are SHARE consecutive ones.
fn sum_before(block: u32, local: u32, base: u32, cells: u32) -> u32 {
    var before = 0u;
    for (var k = local; k < block; k += #{WORKGROUP_SIZE}u) {
        before += fields::cell_start(fields::parameters.block_sums + k);
    }
    atomicAdd(&total, before);

    let first = block * #{SCAN_BLOCK}u + local * SHARE;
    var own = 0u;
    for (var cell = first; cell < min(first + SHARE, cells); cell++) {
        own += fields::cell_count(base + cell);
    }
    partial[local] = own;
    workgroupBarrier();
    var running = own;
    for (var reach = 1u; reach < #{WORKGROUP_SIZE}u; reach *= 2u) {
        if (local >= reach) {
            running += partial[local - reach];
        }
        workgroupBarrier();
        partial[local] = running;
        workgroupBarrier();
    }
    return atomicLoad(&total) + running - own;
}

// Writes the starts of the thread's cells.
fn write_starts(block: u32, local: u32, counts: u32, starts: u32, cells: u32, before: u32) {
    let first = block * #{SCAN_BLOCK}u + local * SHARE;
    var sum = before;
    for (var cell = first; cell < min(first + SHARE, cells); cell++) {
        fields::set_cell_start(starts + cell, sum);
        sum += fields::cell_count(counts + cell);
    }
}
