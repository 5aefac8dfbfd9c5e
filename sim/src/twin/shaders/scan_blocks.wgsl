// Exclusive sums of each block of 2048 counts, and the block's total: the first of three steps
// of a prefix sum.

@group(0) @binding(2) var<uniform> items: vec4<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> starts: array<u32>;
@group(0) @binding(5) var<storage, read_write> blocks: array<u32>;

const THREADS: u32 = 256u;
const EACH: u32 = 8u;

var<workgroup> sums: array<u32, THREADS>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = group.y * groups.x + group.x;
    let first = (block * THREADS + local) * EACH;
    var own = 0u;
    for (var k = first; k < min(first + EACH, items.x); k++) {
        starts[k] = own;
        own += counts[k];
    }
    sums[local] = own;
    // Hillis and Steele 1986: after each round the sum of twice as many.
    for (var reach = 1u; reach < THREADS; reach *= 2u) {
        workgroupBarrier();
        var more = 0u;
        if local >= reach { more = sums[local - reach]; }
        workgroupBarrier();
        sums[local] += more;
    }
    workgroupBarrier();
    let before = sums[local] - own;
    for (var k = first; k < min(first + EACH, items.x); k++) { starts[k] += before; }
    if local == THREADS - 1u && block * THREADS * EACH < items.x { blocks[block] = sums[local]; }
}
