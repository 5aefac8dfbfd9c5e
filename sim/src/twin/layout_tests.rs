//! The layout of every struct that crosses to the adapter, against its twin in WGSL, and all
//! shaders through naga's validator: no adapter is needed.

use std::mem::{offset_of, size_of};

use super::light::Lamps;
use super::params::{self, Fresh, Level, Params, Transform};
use super::stages::{
    ALL, AVERAGE, BLOCK, DROP_HIDDEN, GATHER_MEANS, GROUP, LOOK, PROJECT, PULL, SCAN_ADD, SORT,
    Source,
};
use super::tables::{DISTANCES, Tables};
use unframed_recon::deep::{Placing, Stored, slot};
use unframed_recon::light::{
    self,
    toward::{self, Toward},
};
use unframed_recon::motion::{BUCKET_BITS, BUCKETS};
use unframed_recon::rest;
use unframed_recon::tables::TIME_LEN;
use unframed_recon::taps;
use unframed_recon::tiles::{CELL_BITS, LONGEST, RESTS};
use unframed_wire::{LAMPS, Shares};

fn module(source: &Source) -> naga::Module {
    let text = source.whole().join("\n");
    naga::front::wgsl::parse_str(&text)
        .unwrap_or_else(|error| panic!("{}: {}", source.name, error.emit_to_string(&text)))
}

/// Members and offsets of a struct of a shader, and its size.
fn reflected(source: &Source, name: &str) -> (Vec<(String, usize)>, usize) {
    let module = module(source);
    let found = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, ty)) = found else {
        panic!("{}: no struct {name}", source.name);
    };
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{}: {name} is no struct", source.name);
    };
    let name = |m: &naga::StructMember| m.name.clone().unwrap_or_default();
    let list = members.iter().map(|m| (name(m), m.offset as usize));
    (list.collect(), *span as usize)
}

macro_rules! same_layout {
    ($source:expr, $name:ident, [$($field:ident),*]) => {
        let (members, size) = reflected($source, stringify!($name));
        let expected = [$((stringify!($field).to_owned(), offset_of!($name, $field))),*];
        assert_eq!(members, expected, "{}", stringify!($name));
        assert_eq!(size, size_of::<$name>(), "{}", stringify!($name));
    };
}

#[test]
fn structs_lie_as_the_shaders_read_them() {
    same_layout!(
        &PROJECT,
        Params,
        [
            width,
            height,
            extent_bits,
            frac_bits,
            columns,
            rows,
            now,
            capacity,
            lifetime,
            lifetime_log,
            extents,
            width_log,
            hidden,
            encoded,
            averages,
            cutoff
        ]
    );
    same_layout!(
        &SORT,
        Lamps,
        [windows_len, directional, faces, windows, parts, towards]
    );
    assert_eq!(reflected(&SORT, "Window").1, size_of::<[u32; 8]>());
    same_layout!(&SORT, Toward, [matrix, offset]);
    same_layout!(&AVERAGE, Fresh, [first, count, padding]);
    same_layout!(
        &PROJECT,
        Tables,
        [
            log2_q11, exp2_q15, time, light, linear, srgb_from, srgb_guess, taps
        ]
    );
    same_layout!(
        &PROJECT,
        Transform,
        [matrix, exponent, offset, known, padding]
    );
    same_layout!(
        &PULL,
        Level,
        [
            fine_first,
            fine_columns,
            fine_rows,
            coarse_first,
            coarse_columns,
            coarse_rows,
            side,
            top
        ]
    );
}

/// The value of a constant of a shader.
fn constant(source: &Source, name: &str) -> u32 {
    let module = module(source);
    let found = module
        .constants
        .iter()
        .find(|(_, c)| c.name.as_deref() == Some(name));
    let Some((_, constant)) = found else {
        panic!("{}: no constant {name}", source.name);
    };
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => value,
        naga::Expression::Literal(naga::Literal::I32(value)) => value as u32,
        ref other => panic!("{}: {name} is {other:?}", source.name),
    }
}

#[test]
fn constants_are_the_shaders() {
    assert_eq!(constant(&PROJECT, "GROUP"), GROUP);
    assert_eq!(constant(&SCAN_ADD, "BLOCK"), BLOCK);
    assert_eq!(constant(&GATHER_MEANS, "LOOK"), LOOK);
    assert_eq!(constant(&DROP_HIDDEN, "BUCKETS") as usize, BUCKETS);
    assert_eq!(constant(&DROP_HIDDEN, "BUCKET_BITS"), BUCKET_BITS);
    assert_eq!(constant(&PROJECT, "STATIC_SLOT"), u32::from(slot(0)));
    assert_eq!(constant(&SORT, "LAMPS") as usize, LAMPS);
    assert_eq!(constant(&SORT, "FACES") as usize, toward::FACES);
    assert_eq!(constant(&SORT, "FACE_BITS"), toward::FACE_BITS);
    assert_eq!(constant(&SORT, "PLANE") as i32, toward::PLANE);
    assert_eq!(constant(&SORT, "TOWARD_BITS") as i32, toward::BITS);
    assert_eq!(constant(&SORT, "DEPTH_BITS"), toward::DEPTH);
    assert_eq!(constant(&SORT, "BEHIND"), u32::from(light::map::BEHIND));
    assert_eq!(constant(&SORT, "NOTHING"), u32::from(toward::NOTHING));
    assert_eq!(constant(&SORT, "WHOLE"), light::WHOLE);
    assert_eq!(constant(&SORT, "CODES") as usize, light::CODES);
    assert_eq!(constant(&SORT, "WINDOWS") as usize, light::map::WINDOWS);
    assert_eq!(constant(&AVERAGE, "FULL"), rest::FULL);
    assert_eq!(constant(&AVERAGE, "PRIOR"), rest::PRIOR);
    assert_eq!(constant(&AVERAGE, "RESTS"), u32::from(RESTS.0));
    assert_eq!(constant(&AVERAGE, "MAP_BITS"), CELL_BITS);
    let longest = constant(&PROJECT, "LONGEST_CODE");
    assert_eq!(longest, u32::from(LONGEST.0));
    assert_eq!(constant(&PROJECT, "TIME_CHORDS") as usize + 1, TIME_LEN);
    assert_eq!(constant(&GATHER_MEANS, "LEAST") as i32, taps::LEAST);
    assert_eq!(constant(&GATHER_MEANS, "MOST") as i32, taps::MOST);
    assert_eq!(constant(&GATHER_MEANS, "STEP_BITS"), taps::STEP_BITS);
    assert_eq!(constant(&GATHER_MEANS, "FOOT"), taps::FOOT);
    assert_eq!(constant(&GATHER_MEANS, "TAP_STEPS") as usize, DISTANCES);
}

/// The shaders take a sample apart by shifts; here its bytes are where those shifts look.
#[test]
fn a_stored_sample_is_its_own_sixteen_bytes() {
    let sample = Stored {
        time: 0x0403_0201,
        place: [0x0605, 0x0807, 0x0a09],
        rgb: [11, 12, 13],
        slot: 14,
        placing: Placing::Screen,
        shares: Shares(15),
    };
    let words = params::stored(&sample);
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    if cfg!(target_endian = "big") {
        return;
    }
    assert_eq!(bytes[offset_of!(Stored, time)..][..4], [1, 2, 3, 4]);
    assert_eq!(bytes[offset_of!(Stored, place)..][..6], [5, 6, 7, 8, 9, 10]);
    assert_eq!(bytes[offset_of!(Stored, rgb)..][..3], [11, 12, 13]);
    assert_eq!(bytes[offset_of!(Stored, slot)], 14);
    assert_eq!(bytes[offset_of!(Stored, placing)], 2);
    assert_eq!(bytes[offset_of!(Stored, shares)], 15);
    assert_eq!(bytes.len(), size_of::<Stored>());
    assert_eq!(
        [Placing::Empty, Placing::Lattice, Placing::Screen].map(|p| p as u32),
        [0, 1, 2]
    );
}

#[test]
fn every_stage_is_valid_and_binds_what_it_says() {
    for source in ALL {
        let module = module(source);
        let (flags, capabilities) = Default::default();
        naga::valid::Validator::new(flags, capabilities)
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}: {error:?}", source.name));
        let mut bound: Vec<u32> = module
            .global_variables
            .iter()
            .filter_map(|(_, v)| v.binding.map(|b| b.binding))
            .collect();
        bound.sort_unstable();
        let expected: Vec<u32> = (0..source.bindings.len() as u32 + 2).collect();
        assert_eq!(bound, expected, "{}", source.name);
    }
    // All files of the folder are some stage's.
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/twin/shaders");
    for entry in std::fs::read_dir(folder).expect("the folder of shaders") {
        let path = entry.expect("a file").path();
        let text = std::fs::read_to_string(&path).expect("a readable file");
        let used = ALL.iter().any(|s| s.whole().contains(&text.as_str()));
        assert!(used, "{} belongs to no stage", path.display());
    }
}
