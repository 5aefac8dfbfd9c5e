// The code of a light of 16 bits, twin of unframed_recon::tables::linear_to_srgb.

fn linear_to_srgb(light: u32) -> u32 {
    let code = tables.srgb_guess[light >> 4u];
    if code < 255u && tables.srgb_from[code + 1u] <= light { return code + 1u; }
    return code;
}
