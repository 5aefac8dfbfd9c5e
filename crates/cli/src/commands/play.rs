//! `unframed play`: the display alone.

use anyhow::{Context, Result, bail};
use serde_json::json;
use unframed_recon::frame_hash;
use unframed_wire::{Layout, Packet, Receiver};

use super::{make_out, read_stream};
use crate::args::PlayArgs;
use crate::method::Method;
use crate::panel::{Order, all_cores, with_panel};
use crate::report::Picture;

/// Plays a stream on a display.
///
/// Lost and damaged packets are counted on stderr; the picture goes on.
///
/// # Errors
/// The file cannot be read, is no stream, or its panel is beyond this display.
pub fn play(args: &PlayArgs) -> Result<()> {
    let bytes = read_stream(&args.file)?;
    let file = args.file.display();
    let mut receiver = Receiver::new();
    let mut input = &bytes[..];
    let hello = loop {
        match receiver.push(&mut input) {
            Some(Packet::Hello(hello)) => break hello,
            Some(_) => {}
            None => bail!(
                "{file} is no unframed stream: it has no Hello ({} of its frames are damaged)",
                receiver.counters().damaged
            ),
        }
    };
    if let Some(dir) = &args.out {
        make_out(dir)?;
    }
    // A stream without world data can only be shown as it falls.
    let method = if hello.layout == Layout::Screen {
        Method::Frameless
    } else {
        args.method
    };
    let order = Order {
        kind: args.panel.display,
        config: method.display(),
        width: hello.width,
        height: hello.height,
        samples: args.panel.samples,
        threads: all_cores(),
    };
    with_panel(&order, |panel, display| {
        let mut refreshes = 0u64;
        let mut last = 0;
        let mut input = &bytes[..];
        while let Some(refresh) = panel.push(&mut input)? {
            last = frame_hash(panel.picture());
            if args.hashes {
                println!("{} {last:016x}", refresh.index);
            }
            if let Some(dir) = &args.out {
                let pixels = panel.picture().to_vec();
                let picture = Picture::new(hello.width.into(), hello.height.into(), pixels)?;
                picture.write_png(&dir.join(format!("refresh-{:05}.png", refresh.index)))?;
            }
            refreshes += 1;
        }
        let link = panel.link();
        if link.lost + link.damaged > 0 {
            eprintln!(
                "{file}: {} packets lost, {} frames damaged",
                link.lost, link.damaged
            );
        }
        if args.json {
            let report = json!({
                "file": args.file.to_str().context("the file name is not Unicode")?,
                "size": [hello.width, hello.height],
                "method": method.name(),
                "display": display,
                "refreshes": refreshes,
                "last_hash": format!("{last:016x}"),
                "lost": link.lost,
                "damaged": link.damaged,
            });
            println!("{report}");
        } else if !args.hashes {
            println!(
                "{file}: {refreshes} refreshes on {}x{} pixels ({display}), the last is {last:016x}",
                hello.width, hello.height
            );
        }
        Ok(())
    })
}
