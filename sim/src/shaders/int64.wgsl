// 64-bit integers for WGSL, which has none: a word pair, x the low and y the high half, signed
// ones in two's complement. Every function is what Rust does with i64 or u64 of the same name,
// wrapping; the test beside pass.rs compares them all.

alias W64 = vec2<u32>;

fn w64_from_u32(a: u32) -> W64 { return W64(a, 0u); }

fn w64_from_i32(a: i32) -> W64 { return W64(bitcast<u32>(a), bitcast<u32>(a >> 31u)); }

fn w64_add(a: W64, b: W64) -> W64 {
    let low = a.x + b.x;
    return W64(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn w64_sub(a: W64, b: W64) -> W64 {
    return W64(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn w64_neg(a: W64) -> W64 { return w64_sub(W64(0u, 0u), a); }

fn w64_is_negative(a: W64) -> bool { return (a.y >> 31u) != 0u; }

// |a| as an unsigned number; i64::MIN gives 2^63.
fn w64_abs(a: W64) -> W64 { return select(a, w64_neg(a), w64_is_negative(a)); }

// u32 × u32 → u64, by 16-bit limbs.
fn w64_mul_u32(a: u32, b: u32) -> W64 {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let p00 = a0 * b0;
    // (2^16-1)^2 + 2·(2^16-1) = 2^32-1: neither middle sum overflows.
    let middle = a1 * b0 + (p00 >> 16u);
    let cross = a0 * b1 + (middle & 0xffffu);
    return W64((cross << 16u) | (p00 & 0xffffu), a1 * b1 + (middle >> 16u) + (cross >> 16u));
}

// u32 × u16 → u64, b < 2^16: two products instead of four.
fn w64_mul_u32_u16(a: u32, b: u32) -> W64 {
    let p0 = (a & 0xffffu) * b;
    let p1 = (a >> 16u) * b + (p0 >> 16u);
    return W64((p1 << 16u) | (p0 & 0xffffu), p1 >> 16u);
}

// i32 × i32 → i64. The signed product is the unsigned one less the operands' high corrections.
fn w64_mul_i32(a: i32, b: i32) -> W64 {
    let ua = bitcast<u32>(a);
    let ub = bitcast<u32>(b);
    let p = w64_mul_u32(ua, ub);
    return W64(p.x, p.y - select(0u, ub, a < 0i) - select(0u, ua, b < 0i));
}

// i32 × i16 → i64; b within −2^15..2^15 − 1.
fn w64_mul_i32_i16(a: i32, b: i32) -> W64 {
    let ua = bitcast<u32>(a);
    // b = b₁₆ − 2^16·[b < 0] with b₁₆ its low 16 bits, and a = ua − 2^32·[a < 0].
    let p = w64_mul_u32_u16(ua, bitcast<u32>(b) & 0xffffu);
    let high = p.y - select(0u, bitcast<u32>(b) & 0xffffu, a < 0i);
    let less = W64(ua << 16u, bitcast<u32>(a >> 16u));
    return w64_sub(W64(p.x, high), select(W64(0u, 0u), less, b < 0i));
}

// The low 64 bits of a 64 × 32-bit product, b unsigned.
fn w64_mul_w64_u32(a: W64, b: u32) -> W64 {
    let p = w64_mul_u32(a.x, b);
    return W64(p.x, p.y + a.y * b);
}

// The low 64 bits of i64 × i32.
fn w64_mul_w64_i32(a: W64, b: i32) -> W64 {
    let p = w64_mul_w64_u32(a, bitcast<u32>(b));
    return W64(p.x, p.y - select(0u, a.x, b < 0i));
}

// The low 64 bits of a 64 × 64-bit product, signed or not.
fn w64_mul(a: W64, b: W64) -> W64 {
    let p = w64_mul_u32(a.x, b.x);
    return W64(p.x, p.y + a.x * b.y + a.y * b.x);
}

// Shifts by 0..=63. WGSL leaves shifts of 32 and more undefined, so they are taken apart.
fn w64_shl(a: W64, n: u32) -> W64 {
    if n == 0u { return a; }
    if n >= 32u { return W64(0u, a.x << (n - 32u)); }
    return W64(a.x << n, (a.y << n) | (a.x >> (32u - n)));
}

fn w64_shr_u(a: W64, n: u32) -> W64 {
    if n == 0u { return a; }
    if n >= 32u { return W64(a.y >> (n - 32u), 0u); }
    return W64((a.x >> n) | (a.y << (32u - n)), a.y >> n);
}

// Arithmetic: rounds towards minus infinity.
fn w64_shr_i(a: W64, n: u32) -> W64 {
    let high = bitcast<i32>(a.y);
    if n == 0u { return a; }
    if n >= 32u { return W64(bitcast<u32>(high >> (n - 32u)), bitcast<u32>(high >> 31u)); }
    return W64((a.x >> n) | (a.y << (32u - n)), bitcast<u32>(high >> n));
}

// (a + 2^(n−1)) >> n, wrapping: rounds to nearest, halves towards plus infinity; n = 0 is a.
fn w64_shr_round_i(a: W64, n: u32) -> W64 {
    if n == 0u { return a; }
    return w64_shr_i(w64_add(a, w64_shl(W64(1u, 0u), n - 1u)), n);
}

// Leading zeros, 64 for zero.
fn w64_clz(a: W64) -> u32 {
    return select(countLeadingZeros(a.y), 32u + countLeadingZeros(a.x), a.y == 0u);
}

fn w64_eq(a: W64, b: W64) -> bool { return a.x == b.x && a.y == b.y; }

fn w64_lt_u(a: W64, b: W64) -> bool { return a.y < b.y || (a.y == b.y && a.x < b.x); }

fn w64_lt_i(a: W64, b: W64) -> bool {
    let ha = bitcast<i32>(a.y);
    let hb = bitcast<i32>(b.y);
    return ha < hb || (ha == hb && a.x < b.x);
}

// a as an i32, the nearest one when it does not fit.
fn w64_clamp_i32(a: W64) -> i32 {
    let low = bitcast<i32>(a.x);
    if bitcast<i32>(a.y) == (low >> 31u) { return low; }
    return select(0x7fffffffi, bitcast<i32>(0x80000000u), w64_is_negative(a));
}

// Unsigned division, shift and subtract, as many steps as the quotient has bits; b = 0 gives
// 2^64 − 1 (Rust panics: the twin must test first, and so no driver's choice is seen).
fn w64_div_u(a: W64, b: W64) -> W64 {
    if b.x == 0u && b.y == 0u { return W64(0xffffffffu, 0xffffffffu); }
    if w64_lt_u(a, b) { return W64(0u, 0u); }
    if a.y == 0u { return W64(a.x / b.x, 0u); }
    let steps = w64_clz(b) - w64_clz(a);
    var rest = a;
    var divisor = w64_shl(b, steps);
    var quotient = W64(0u, 0u);
    for (var i = 0u; i <= steps; i++) {
        quotient = w64_shl(quotient, 1u);
        if !w64_lt_u(rest, divisor) {
            rest = w64_sub(rest, divisor);
            quotient.x |= 1u;
        }
        divisor = w64_shr_u(divisor, 1u);
    }
    return quotient;
}

// Signed division, truncated towards zero; i64::MIN / −1 wraps.
fn w64_div_i(a: W64, b: W64) -> W64 {
    let q = w64_div_u(w64_abs(a), w64_abs(b));
    return select(q, w64_neg(q), w64_is_negative(a) != w64_is_negative(b));
}
