//! A stream of any content, shown in integers and in `f64`: they may differ by what rounding
//! explains, see `fuzzed::check`.
#![no_main]

#[path = "../../tests/src/accuracy.rs"]
#[expect(dead_code, reason = "what tests report")]
mod accuracy;
#[path = "../../tests/src/fuzzed.rs"]
mod fuzzed;
#[path = "../../tests/src/holes.rs"]
mod holes;
#[path = "../../tests/src/stream.rs"]
#[expect(dead_code, reason = "streams of other tests")]
mod stream;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = fuzzed::check(data);
});
