//! `unframed run --window`: host and display, live.
//!
//! The host works on a thread of its own in simulated time and hands over each refresh's picture;
//! the window shows the newest at the panel's rate. On a machine too slow for the sampling rate
//! the animation runs slower, never worse.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use anyhow::{Context, Result};
use unframed_sim::window::{self, Frame, Key, Next, Options, Source as WindowSource};
use unframed_wire::TileNode;

use crate::args::RunArgs;
use crate::measure::{REFRESH_HZ, host, open_world};
use crate::method::Method;
use crate::panel::{Order, all_cores, with_panel};

/// What the keys switch.
#[derive(Debug, Default)]
struct Switches {
    frameless: AtomicBool,
    tiling: AtomicBool,
}

/// The window's side.
struct Live {
    frames: Receiver<(Frame, String)>,
    switches: Arc<Switches>,
    status: String,
}

impl WindowSource for Live {
    fn next(&mut self, frame: &mut Frame) -> Next {
        match self.frames.try_recv() {
            Ok((newer, status)) => {
                (*frame, self.status) = (newer, status);
                Next::Picture
            }
            Err(std::sync::mpsc::TryRecvError::Empty) => Next::Unchanged,
            Err(std::sync::mpsc::TryRecvError::Disconnected) => Next::End,
        }
    }

    fn key(&mut self, key: Key) {
        match key {
            Key::Char('m') => _ = self.switches.frameless.fetch_xor(true, Ordering::Relaxed),
            Key::Char('t') => _ = self.switches.tiling.fetch_xor(true, Ordering::Relaxed),
            _ => {}
        }
    }

    fn status(&mut self) -> Option<String> {
        Some(self.status.clone())
    }
}

/// Shows a run in a window until it is closed.
///
/// # Errors
/// No window can be had, or the host stopped.
pub fn show(args: &RunArgs) -> Result<()> {
    // Fail on a bad scene before a window opens.
    open_world(&args.source)?;
    let switches = Arc::new(Switches::default());
    let (sender, frames) = sync_channel(2);
    let mut live = Live {
        frames,
        switches: Arc::clone(&switches),
        status: String::new(),
    };
    let options = Options {
        title: format!("unframed: {}", args.source.scene),
        size: [args.source.size.width, args.source.size.height],
        refresh_hz: REFRESH_HZ,
        frames: args.frames,
    };
    let worker = {
        let args = args.clone();
        std::thread::spawn(move || work(&args, &switches, &sender))
    };
    let shown = window::show(&options, &mut live);
    // The worker stops when nobody takes its pictures.
    drop(live);
    let worked = worker
        .join()
        .ok()
        .context("the host's thread stopped unexpectedly")?;
    let shown = shown?;
    worked?;
    println!(
        "{} refreshes in {:.2} s, {} skipped, presented by {}",
        shown.refreshes, shown.seconds, shown.skipped, shown.adapter
    );
    Ok(())
}

/// Renders until the window is gone; starts anew when the method is switched.
fn work(args: &RunArgs, switches: &Switches, out: &SyncSender<(Frame, String)>) -> Result<()> {
    loop {
        let frameless = switches.frameless.load(Ordering::Relaxed);
        let method = if frameless {
            Method::Frameless
        } else {
            args.source.method
        };
        let (width, height) = (args.source.size.width, args.source.size.height);
        let order = Order {
            kind: args.panel.display,
            config: method.display(),
            width,
            height,
            samples: args.panel.samples,
            threads: all_cores(),
        };
        let gone = with_panel(&order, |panel, display| {
            let mut host = host(&args.source, method, open_world(&args.source)?);
            let mut bytes = Vec::new();
            while switches.frameless.load(Ordering::Relaxed) == frameless {
                bytes.clear();
                let step = host.advance(&mut bytes)?;
                let mut input = &bytes[..];
                while panel.push(&mut input)?.is_some() {}
                let mut frame = Frame::new(width, height);
                frame.rgb.copy_from_slice(panel.picture().as_flattened());
                if switches.tiling.load(Ordering::Relaxed) {
                    draw_tiles(&mut frame, host.tiles());
                }
                let status = format!(
                    "{} on {display}, {} samples/s, {:.2} s",
                    method.name(),
                    args.source.rate,
                    step.time
                );
                if out.send((frame, status)).is_err() {
                    return Ok(true);
                }
            }
            Ok(false)
        })?;
        if gone {
            return Ok(());
        }
    }
}

/// The upper and left edges of each tile.
fn draw_tiles(frame: &mut Frame, nodes: &[TileNode]) {
    let width = frame.width as usize;
    for node in nodes {
        let TileNode::Leaf(tile) = node else { continue };
        let [x, y, w, h] = [tile.rect.x, tile.rect.y, tile.rect.w, tile.rect.h].map(usize::from);
        let across = (x..x + w).map(|x| y * width + x);
        let down = (y..y + h).map(|y| y * width + x);
        for pixel in across.chain(down) {
            if let Some(rgb) = frame.rgb.get_mut(3 * pixel..3 * pixel + 3) {
                rgb.copy_from_slice(&[255, 220, 60]);
            }
        }
    }
}
