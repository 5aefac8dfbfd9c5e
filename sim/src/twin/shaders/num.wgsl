// Twin of unframed_recon::num: reciprocal, logarithm, narrow products.

// The high 32 bits of a 32 × 32-bit product.
fn mul_hi(a: u32, b: u32) -> u32 { return w64_mul_u32(a, b).y; }

// 2^63/d for d in 2^31..2^32, within 8 units.
fn reciprocal(d: u32) -> u32 {
    let top = d >> 16u;
    var seed = 0xffffffffu;
    if top != 0u { seed = (0xffffffffu / top) << 15u; }
    let error = 0u - mul_hi(d, seed);
    let product = w64_mul_u32(seed, error);
    if (product.y >> 31u) != 0u { return 0xffffffffu; }
    return (product.y << 1u) | (product.x >> 31u);
}

// floor(log2(v)) for a positive v.
fn exponent(v: W64) -> i32 { return 63i - i32(w64_clz(v)); }

// Left for positive `by`, arithmetically right for negative.
fn shift(v: W64, by: i32) -> W64 {
    if by >= 64i { return W64(0u, 0u); }
    if by >= 0i { return w64_shl(v, u32(by)); }
    return w64_shr_i(v, u32(min(-by, 63i)));
}

// The top 32 bits of a positive value, its leading one moved to bit 31.
fn normalise(v: W64) -> u32 { return w64_shl(v, w64_clz(v) & 63u).y; }

// log2 with 11 fractional bits; that of 0 is 0.
fn log2_q11(v: W64) -> i32 {
    if v.x == 0u && v.y == 0u { return 0i; }
    let mantissa = normalise(v) << 1u;
    let chord = mantissa >> 26u;
    let along = (mantissa >> 16u) & 0x3ffu;
    let ends = tables.log2_q11[chord];
    let a = ends & 0xffffu;
    let b = ends >> 16u;
    return exponent(v) * 2048i + i32(a + (((b - a) * along + 512u) >> 10u));
}

// 2^(−v) with 15 fractional bits, v with 12.
fn exp2_negative(v: u32) -> u32 {
    let whole = v >> 12u;
    if whole > 15u { return 0u; }
    let chord = (v >> 4u) & 0xffu;
    let ends = tables.exp2_q15[chord];
    let a = ends & 0xffffu;
    let b = ends >> 16u;
    let mantissa = (a << 4u) - (a - b) * (v & 15u);
    return (mantissa + (8u << whole)) >> (4u + whole);
}

// 2^v with `bits` fractional bits, v with 11.
fn exp2_q(v: i32, bits: i32) -> u32 {
    let up = (v + 2047i) >> 11u;
    let rest = u32((up << 11u) - v);
    let by = up + bits - 15i;
    let mantissa = exp2_negative(rest << 1u);
    if by >= 0i { return mantissa << u32(min(by, 15i)); }
    if by > -31i { return mantissa >> u32(-by); }
    return 0u;
}

// Division by one positive value, several times.
struct Divider {
    inverse: u32,
    power: i32,
}

// A divisor of 0 acts as 1.
fn divider(divisor: W64) -> Divider {
    var d = divisor;
    if d.x == 0u && d.y == 0u { d.x = 1u; }
    return Divider(reciprocal(normalise(d)), exponent(d));
}

// v / divisor with 31 − bits fractional bits, given |v| ≤ divisor·2^bits.
fn ratio(by_this: Divider, v: W64, bits: i32) -> i32 {
    let magnitude = w64_abs(v);
    let by = by_this.power + 1i + bits - 32i;
    var wide = W64(0u, 0u);
    if by < 64i {
        if by >= 0i {
            wide = w64_shr_u(magnitude, u32(by));
        } else {
            wide = w64_shl(magnitude, u32(min(-by, 63i)));
        }
    }
    let narrow = select(wide.x, 0xffffffffu, wide.y != 0u);
    let quotient = i32(min(mul_hi(narrow, by_this.inverse), 0x7fffffffu));
    return select(quotient, -quotient, w64_is_negative(v));
}
