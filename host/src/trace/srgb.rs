//! sRGB encoding and decoding (IEC 61966-2-1), exact at the 8-bit codes.

use glam::Vec3;

/// Linear light 0..=1 of an encoded value 0..=1.
#[must_use]
pub fn decode(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Encoded value 0..=1 of linear light; clamps its argument to 0..=1.
#[must_use]
pub fn encode(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The 8-bit code nearest to linear light, each channel clamped to 0..=1 (NaN gives 0).
#[must_use]
pub fn encode8(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| (encode(c) * 255.0 + 0.5) as u8)
}

/// Linear light of an 8-bit code.
#[must_use]
pub fn decode8(code: [u8; 3]) -> Vec3 {
    Vec3::from_array(code.map(|c| decode(f32::from(c) / 255.0)))
}

/// Linear light of each 8-bit code.
#[must_use]
pub fn decode_table() -> [f32; 256] {
    std::array::from_fn(|code| decode(code as f32 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_survive_a_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(encode8(decode8([code; 3])), [code; 3]);
        }
    }

    #[test]
    fn known_values_and_nonsense() {
        // IEC 61966-2-1: mid grey 0.2140 is code 127.5; the linear toe ends near code 10.
        assert!((decode(0.5) - 0.214_041).abs() < 1e-5);
        assert!((encode(0.18) - 0.461_356).abs() < 1e-5);
        assert_eq!(encode8(Vec3::new(-1.0, f32::NAN, 9.0)), [0, 0, 255]);
    }
}
