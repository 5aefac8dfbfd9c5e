//! The compute passes: 64-bit arithmetic against Rust's, ordering, errors.

use super::*;
use crate::testing::{Random, adapter_or_skip};

const INT64_TEST: &str = include_str!("shaders/int64_test.wgsl");
const IN: usize = 5;
const OUT: usize = 44;
const PAIRS: usize = 100_000;

/// The names of the results, in the order of `expected`.
const NAMES: [&str; OUT / 2] = [
    "from_u32",
    "from_i32",
    "add",
    "sub",
    "neg",
    "abs",
    "mul_u32",
    "mul_u32_u16",
    "mul_i32",
    "mul_i32_i16",
    "mul_w64_u32",
    "mul_w64_i32",
    "mul",
    "shl",
    "shr_u",
    "shr_i",
    "shr_round_i",
    "clz, is_negative",
    "eq, lt_u",
    "lt_i, clamp_i32",
    "div_u",
    "div_i",
];

/// What Rust makes of one pair.
fn expected(a: u64, b: u64, n: u32) -> [u64; OUT / 2] {
    let (ia, ib) = (a as i64, b as i64);
    let (la, lb) = (a as u32, b as u32);
    let (sa, sb) = (la as i32, lb as i32);
    let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
    let rounded = if n == 0 {
        ia
    } else {
        ia.wrapping_add(1i64.wrapping_shl(n - 1)) >> n
    };
    let clamped = ia.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
    [
        u64::from(la),
        i64::from(sa) as u64,
        a.wrapping_add(b),
        a.wrapping_sub(b),
        a.wrapping_neg(),
        ia.unsigned_abs(),
        u64::from(la) * u64::from(lb),
        u64::from(la) * u64::from(lb as u16),
        (i64::from(sa) * i64::from(sb)) as u64,
        (i64::from(sa) * i64::from(sb as i16)) as u64,
        a.wrapping_mul(u64::from(lb)),
        ia.wrapping_mul(i64::from(sb)) as u64,
        a.wrapping_mul(b),
        a << n,
        a >> n,
        (ia >> n) as u64,
        rounded as u64,
        pair(a.leading_zeros(), u32::from(ia < 0)),
        pair(u32::from(a == b), u32::from(a < b)),
        pair(u32::from(ia < ib), clamped as u32),
        a.checked_div(b).unwrap_or(u64::MAX),
        // The sign rule of a division by zero follows from that of the unsigned one.
        if b == 0 {
            if ia < 0 { 1 } else { u64::MAX }
        } else {
            ia.wrapping_div(ib) as u64
        },
    ]
}

/// All pairs of edge cases, then random ones of every magnitude.
fn operands() -> Vec<(u64, u64, u32)> {
    let mut edges = vec![0, 1, 2, 3, 0x5555_5555_5555_5555];
    for bit in [8, 15, 16, 17, 30, 31, 32, 33, 47, 48, 62, 63] {
        edges.extend([(1u64 << bit) - 1, 1 << bit, (1 << bit) + 1]);
    }
    let negative: Vec<u64> = edges.iter().map(|e| e.wrapping_neg()).collect();
    edges.extend(negative);
    let mut list = Vec::new();
    for (i, a) in edges.iter().enumerate() {
        for (j, b) in edges.iter().enumerate() {
            list.push((*a, *b, ((i * 7 + j) % 64) as u32));
        }
    }
    let mut random = Random(0x1234_5678_9abc_def1);
    while list.len() < PAIRS {
        // Shifted by random amounts with sign: uniform words would all be huge.
        let mut number = || ((random.next() as i64) >> (random.next() >> 58)) as u64;
        let (a, b) = (number(), number());
        list.push((a, b, (random.next() >> 58) as u32));
    }
    list
}

fn run_int64(gpu: &Gpu, arithmetic: &str, list: &[(u64, u64, u32)]) -> Vec<u32> {
    let words: Vec<u32> = list
        .iter()
        .flat_map(|(a, b, n)| [*a as u32, (a >> 32) as u32, *b as u32, (b >> 32) as u32, *n])
        .collect();
    assert_eq!(words.len(), list.len() * IN);
    let bindings = [Access::Read, Access::Write];
    let stage = Stage::new(gpu, "int64_test", &[arithmetic, INT64_TEST], &bindings)
        .expect("the shader compiles");
    let operands = Words::upload(gpu, "operands", &words).expect("it fits");
    let results = Words::zeroed(gpu, "results", list.len() * OUT).expect("it fits");
    let mut batch = Batch::new(gpu);
    let grid = linear_grid(list.len(), 64);
    batch
        .run(&stage, &[&operands, &results], grid)
        .expect("bindings fit");
    batch.submit().expect("valid commands");
    results.read(gpu).expect("the device answers")
}

/// The first result that differs from Rust's, as text.
fn first_difference(list: &[(u64, u64, u32)], results: &[u32]) -> Option<String> {
    assert_eq!(results.len(), list.len() * OUT);
    for ((a, b, n), got) in list.iter().zip(results.chunks_exact(OUT)) {
        let expected = expected(*a, *b, *n);
        for ((name, want), got) in NAMES.iter().zip(expected).zip(got.chunks_exact(2)) {
            let got = u64::from(got[0]) | u64::from(got[1]) << 32;
            if got != want {
                return Some(format!(
                    "{name}: a={a:#x} b={b:#x} n={n}: {got:#x}, not {want:#x}"
                ));
            }
        }
    }
    None
}

#[test]
fn int64_equals_rust_on_edges_and_random_pairs() {
    let Some(gpu) = adapter_or_skip("64-bit integers in WGSL") else {
        return;
    };
    let list = operands();
    assert!(list.len() >= PAIRS);
    let results = run_int64(&gpu, INT64, &list);
    assert_eq!(
        first_difference(&list, &results),
        None,
        "{}",
        gpu.describe()
    );
}

/// The comparison above must be able to fail: a lost carry is found.
#[test]
fn a_wrong_carry_is_found() {
    let Some(gpu) = adapter_or_skip("the check of 64-bit integers in WGSL") else {
        return;
    };
    let list = operands();
    let broken = INT64.replace("select(0u, 1u, low < a.x)", "0u");
    assert_ne!(broken, INT64);
    let found = first_difference(&list, &run_int64(&gpu, &broken, &list));
    assert!(
        found.as_ref().is_some_and(|text| text.starts_with("add: ")),
        "{found:?}"
    );
}

/// Stages see what stages before them wrote; uniforms, atomics, clear, part reads and writes.
#[test]
fn stages_run_in_order_on_each_kind_of_binding() {
    let Some(gpu) = adapter_or_skip("order of compute stages") else {
        return;
    };
    let source = "
        @group(0) @binding(0) var<uniform> step: vec4<u32>;
        @group(0) @binding(1) var<storage, read_write> sums: array<atomic<u32>>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            atomicAdd(&sums[id.x % 3u], step.x);
            if id.x == 0u { atomicMax(&sums[3], step.y); }
        }";
    let stage = Stage::new(&gpu, "sum", &[source], &[Access::Uniform, Access::Write])
        .expect("the shader compiles");
    let step = |x, y| Words::upload(&gpu, "step", &[x, y, 0, 0]).expect("it fits");
    let sums = Words::upload(&gpu, "sums", &[5; 4]).expect("it fits");
    let mut batch = Batch::new(&gpu);
    batch
        .run(&stage, &[&step(1, 9), &sums], [3, 1, 1])
        .expect("bindings fit");
    batch.clear(&sums);
    batch
        .run(&stage, &[&step(2, 4), &sums], [3, 1, 1])
        .expect("bindings fit");
    batch
        .run(&stage, &[&step(3, 2), &sums], [3, 1, 1])
        .expect("bindings fit");
    batch.submit().expect("valid commands");
    // 192 invocations, 64 a sum, 2 + 3 each; the first run was cleared away.
    assert_eq!(
        sums.read(&gpu).expect("the device answers"),
        [320, 320, 320, 4]
    );
    sums.write(&gpu, 1, &[7, 8]).expect("within the buffer");
    assert_eq!(
        sums.read_part(&gpu, 1, 3).expect("the device answers"),
        [7, 8, 4]
    );
}

#[test]
fn misuse_is_an_error_with_the_name_of_the_place() {
    let Some(gpu) = adapter_or_skip("errors of compute stages") else {
        return;
    };
    let error = Stage::new(&gpu, "splat", &["fn main( {"], &[]).expect_err("no shader");
    assert!(
        error.to_string().starts_with("graphics: splat: "),
        "{error}"
    );

    let four = Words::zeroed(&gpu, "four", 4).expect("it fits");
    let error = four.write(&gpu, 3, &[1, 2]).expect_err("beyond the end");
    assert!(error.to_string().starts_with("graphics: four: "), "{error}");
    assert!(four.read_part(&gpu, 2, 3).is_err());
    assert_eq!(four.read(&gpu).expect("still usable"), [0; 4]);

    let huge = Words::zeroed(&gpu, "huge", usize::MAX / 8).expect_err("no such memory");
    assert!(huge.to_string().starts_with("graphics: huge: "), "{huge}");

    let source = "
        @group(0) @binding(0) var<storage, read_write> words: array<u32>;
        @compute @workgroup_size(1) fn main() { words[0] = 1u; }";
    let stage = Stage::new(&gpu, "one", &[source], &[Access::Write]).expect("it compiles");
    let mut batch = Batch::new(&gpu);
    let error = batch
        .run(&stage, &[], [1, 1, 1])
        .expect_err("a buffer is missing");
    assert!(
        error.to_string().contains("one: 0 buffers for 1 bindings"),
        "{error}"
    );
    let wrong = Stage::new(&gpu, "wrong", &[source], &[Access::Read]);
    assert!(wrong.is_err(), "the layout does not fit the shader");
}

#[test]
fn the_grid_covers_all_items_within_the_bounds() {
    let items = [
        0,
        1,
        63,
        64,
        65,
        65_535 * 64,
        65_535 * 64 + 1,
        1 << 24,
        4096 * 4096 * 15,
    ];
    for (items, group) in items.into_iter().flat_map(|i| [(i, 64), (i, 256), (i, 1)]) {
        let [x, y, z] = linear_grid(items, group);
        assert!((1..=MAX_GROUPS).contains(&x) && (1..=MAX_GROUPS).contains(&y) && z == 1);
        let covered = x as usize * y as usize * group as usize;
        assert!(covered >= items, "{items} {group}");
        assert!(
            covered < items + (y as usize + 1) * group as usize,
            "{items} {group}: wasteful"
        );
    }
}

/// Each shader of the crate compiles without any adapter (naga's front end and validator).
#[test]
fn every_shader_is_valid() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/shaders");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the folder of shaders") {
        let path = entry.expect("a file").path();
        let source = std::fs::read_to_string(&path).expect("a readable file");
        let name = path.display();
        // Those that use 64-bit arithmetic get it in front, as in `Stage::new`.
        let uses_int64 = source.contains("w64_") && !source.contains("alias W64");
        let whole = if uses_int64 {
            format!("{INT64}\n{source}")
        } else {
            source
        };
        if let Err(error) = validate(&whole) {
            panic!("{name}: {error}");
        }
        count += 1;
    }
    assert!(count >= 3, "{count} shaders");
    assert!(validate("fn f() -> u32 { return 1.5; }").is_err());
}

fn validate(source: &str) -> Result<(), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    let (flags, capabilities) = Default::default();
    naga::valid::Validator::new(flags, capabilities)
        .validate(&module)
        .map(drop)
        .map_err(|e| e.emit_to_string(source))
}
