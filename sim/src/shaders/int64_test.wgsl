// Every function of int64.wgsl on one pair of 64-bit operands and a shift: five words in (a, b,
// n), OUT words out, in the order of `expected` in pass_tests.rs.

const IN: u32 = 5u;
const OUT: u32 = 44u;

@group(0) @binding(0) var<storage, read> operands: array<u32>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let item = (group.y * groups.x + group.x) * 64u + local;
    if item >= arrayLength(&operands) / IN { return; }
    let i = item * IN;
    let a = W64(operands[i], operands[i + 1u]);
    let b = W64(operands[i + 2u], operands[i + 3u]);
    let n = operands[i + 4u];
    let sa = bitcast<i32>(a.x);
    let sb = bitcast<i32>(b.x);
    let short = (sb << 16u) >> 16u;

    var out: array<W64, 22>;
    out[0] = w64_from_u32(a.x);
    out[1] = w64_from_i32(sa);
    out[2] = w64_add(a, b);
    out[3] = w64_sub(a, b);
    out[4] = w64_neg(a);
    out[5] = w64_abs(a);
    out[6] = w64_mul_u32(a.x, b.x);
    out[7] = w64_mul_u32_u16(a.x, b.x & 0xffffu);
    out[8] = w64_mul_i32(sa, sb);
    out[9] = w64_mul_i32_i16(sa, short);
    out[10] = w64_mul_w64_u32(a, b.x);
    out[11] = w64_mul_w64_i32(a, sb);
    out[12] = w64_mul(a, b);
    out[13] = w64_shl(a, n);
    out[14] = w64_shr_u(a, n);
    out[15] = w64_shr_i(a, n);
    out[16] = w64_shr_round_i(a, n);
    out[17] = W64(w64_clz(a), u32(w64_is_negative(a)));
    out[18] = W64(u32(w64_eq(a, b)), u32(w64_lt_u(a, b)));
    out[19] = W64(u32(w64_lt_i(a, b)), bitcast<u32>(w64_clamp_i32(a)));
    out[20] = w64_div_u(a, b);
    out[21] = w64_div_i(a, b);
    for (var k = 0u; k < 22u; k++) {
        results[item * OUT + 2u * k] = out[k].x;
        results[item * OUT + 2u * k + 1u] = out[k].y;
    }
}
