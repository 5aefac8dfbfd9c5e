//! `unframed record`: the host alone.

use std::fs::File;
use std::io::BufWriter;

use anyhow::{Context, Result};
use serde_json::json;
use unframed_wire::recording::Recorder;

use super::bar;
use crate::args::RecordArgs;
use crate::measure::{host, open_world, refreshes};

/// Writes a stream with its index.
///
/// # Errors
/// The scene cannot be opened or the file not be written.
pub fn record(args: &RecordArgs) -> Result<()> {
    let world = open_world(&args.source)?;
    let path = args.output.display();
    let failed = || format!("cannot write the stream {path}");
    let file = File::create(&args.output).with_context(failed)?;
    let mut recorder = Recorder::new(BufWriter::new(file));
    let mut host = host(&args.source, args.source.method, world);
    let count = refreshes(&args.source);
    let progress = bar(count.into(), &args.source.scene);
    let mut bytes = Vec::new();
    for _ in 0..count {
        bytes.clear();
        host.advance(&mut bytes)?;
        recorder.write(&bytes).with_context(failed)?;
        progress.inc(1);
    }
    bytes.clear();
    let end = host.end(&mut bytes)?;
    recorder.write(&bytes).with_context(failed)?;
    recorder.finish().with_context(failed)?;
    progress.finish_and_clear();
    let total = host.ledger().total_bytes();
    let per_sample = total as f64 / end.samples.max(1) as f64;
    if args.json {
        let report = json!({
            "scene": args.source.scene,
            "method": args.source.method.name(),
            "seed": args.source.seed,
            "rate": args.source.rate,
            "size": [args.source.size.width, args.source.size.height],
            "refreshes": count,
            "samples": end.samples,
            "packets": end.packets + 1,
            "stream_bytes": total,
            "bytes_per_sample": per_sample,
        });
        println!("{report}");
    } else {
        println!(
            "{path}: {count} refreshes, {} samples, {total} bytes, {per_sample:.2} bytes a sample",
            end.samples
        );
    }
    Ok(())
}
