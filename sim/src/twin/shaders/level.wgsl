// Two neighbouring levels of a pyramid, all levels behind each other in one buffer; twin of Level
// in params.rs.
struct Level {
    fine_first: u32,
    fine_columns: u32,
    fine_rows: u32,
    coarse_first: u32,
    coarse_columns: u32,
    coarse_rows: u32,
    // Fine cells along a coarse one.
    side: u32,
    // The coarsest of all.
    top: u32,
}

@group(0) @binding(2) var<uniform> level: Level;
