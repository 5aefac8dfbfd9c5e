// Exclusive sums of the blocks' totals by one workgroup; the sum of all goes to the end of
// `starts`: the second step of a prefix sum.

@group(0) @binding(2) var<uniform> items: vec4<u32>;
@group(0) @binding(3) var<storage, read_write> starts: array<u32>;
@group(0) @binding(4) var<storage, read_write> blocks: array<u32>;

const THREADS: u32 = 256u;
const BLOCK: u32 = 2048u;

var<workgroup> sums: array<u32, THREADS>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) local: u32) {
    let len = (items.x + BLOCK - 1u) / BLOCK;
    let each = (len + THREADS - 1u) / THREADS;
    let first = local * each;
    var own = 0u;
    for (var k = first; k < min(first + each, len); k++) {
        let block = blocks[k];
        blocks[k] = own;
        own += block;
    }
    sums[local] = own;
    for (var reach = 1u; reach < THREADS; reach *= 2u) {
        workgroupBarrier();
        var more = 0u;
        if local >= reach { more = sums[local - reach]; }
        workgroupBarrier();
        sums[local] += more;
    }
    workgroupBarrier();
    let before = sums[local] - own;
    for (var k = first; k < min(first + each, len); k++) { blocks[k] += before; }
    if local == THREADS - 1u { starts[items.x] = sums[local]; }
}
