//! `unframed inspect`: what is in a stream.

use anyhow::{Context, Result};
use serde_json::json;
use unframed_wire::Kind;
use unframed_wire::recording::Summary;

use super::read_stream;
use crate::args::InspectArgs;

/// Reads a stream and tells packets, rates, losses.
///
/// # Errors
/// The file cannot be read or is no stream.
pub fn inspect(args: &InspectArgs) -> Result<()> {
    let bytes = read_stream(&args.file)?;
    let file = args.file.display();
    let summary = Summary::of(&bytes).with_context(|| format!("cannot inspect {file}"))?;
    if args.json {
        println!("{}", as_json(&summary));
        return Ok(());
    }
    let hello = &summary.hello;
    println!(
        "{file}: format {}, {}x{} pixels, {:?} layout, nominal {} samples/s, {:.2} Hz",
        summary.version,
        hello.width,
        hello.height,
        hello.layout,
        hello.rate,
        f64::from(hello.refresh_millihertz) / 1000.0,
    );
    println!(
        "{} samples in {} bytes over {:.3} s: {:.2} bytes a sample, {:.0} bytes/s",
        summary.samples,
        summary.bytes,
        summary.seconds,
        summary.bytes_per_sample().unwrap_or(f64::NAN),
        summary.bytes as f64 / summary.seconds.max(1e-6),
    );
    println!(
        "{} packets lost, {} frames damaged, {}, {}",
        summary.lost,
        summary.damaged,
        if summary.end.is_some() {
            "ends properly"
        } else {
            "cut off before its end"
        },
        if summary.indexed {
            "indexed"
        } else {
            "no index"
        },
    );
    for kind in Kind::ALL {
        let packets = summary.packets_of(kind);
        if packets > 0 {
            let bytes = summary.packet_bytes[kind.index()];
            println!(
                "{:>10}  {packets:>8} packets  {bytes:>10} bytes",
                kind.name()
            );
        }
    }
    Ok(())
}

fn as_json(summary: &Summary) -> serde_json::Value {
    let hello = &summary.hello;
    let timeline: Vec<_> = summary
        .timeline
        .iter()
        .map(|line| {
            json!({
                "index": line.index,
                "seconds": line.micros as f64 * 1e-6,
                "samples": line.samples,
                "bytes": line.bytes,
                "lost": line.lost,
                "damaged": line.damaged,
            })
        })
        .collect();
    json!({
        "version": summary.version,
        "size": [hello.width, hello.height],
        "layout": format!("{:?}", hello.layout).to_lowercase(),
        "lamps": hello.lamps,
        "rate": hello.rate,
        "refresh_hz": f64::from(hello.refresh_millihertz) / 1000.0,
        "packets": {
            "hello": summary.packets_of(Kind::Hello),
            "view": summary.packets_of(Kind::View),
            "poses": summary.packets_of(Kind::Poses),
            "tiles": summary.packets_of(Kind::Tiles),
            "samples": summary.sample_packets(),
            "refresh": summary.packets_of(Kind::Refresh),
            "cut": summary.packets_of(Kind::Cut),
            "end": summary.packets_of(Kind::End),
            "lamps": summary.packets_of(Kind::Lamps),
            "shape": summary.packets_of(Kind::Shape),
        },
        "samples": summary.samples,
        "bytes": summary.bytes,
        "bytes_per_sample": summary.bytes_per_sample(),
        "lost": summary.lost,
        "damaged": summary.damaged,
        "seconds": summary.seconds,
        "ended": summary.end.is_some(),
        "indexed": summary.indexed,
        "timeline": timeline,
    })
}
