//! A test pattern in a window: colour bars above, grey steps and a moving line below.
//!
//! `cargo run -p unframed-sim --example window [FRAMES]`; keys: Esc or q quits, space pauses,
//! g shows a grid, the arrows change the speed. With a number it closes by itself.

use std::process::ExitCode;
use std::time::Instant;

use unframed_sim::window::{self, Frame, Key, Next, Options, Source};

const WIDTH: u16 = 160;
const HEIGHT: u16 = 120;

struct Pattern {
    tick: i64,
    speed: i64,
    grid: bool,
    since: Instant,
    frames: u32,
}

impl Pattern {
    fn pixel(&self, x: i64, y: i64) -> [u8; 3] {
        let (width, height) = (i64::from(WIDTH), i64::from(HEIGHT));
        if self.grid && (x % 10 == 0 || y % 10 == 0) {
            return [90; 3];
        }
        if y < height / 2 {
            // White, yellow, cyan, green, magenta, red, blue, black.
            let bar = 7 - x * 8 / width;
            return [(bar >> 1) & 1, (bar >> 2) & 1, bar & 1].map(|on| (on * 235) as u8);
        }
        if x == self.tick.rem_euclid(width) {
            return [255, 64, 64];
        }
        [(x * 16 / width * 17) as u8; 3]
    }
}

impl Source for Pattern {
    fn next(&mut self, frame: &mut Frame) -> Next {
        if frame.rgb.is_empty() {
            *frame = Frame::new(WIDTH, HEIGHT);
        }
        let places = (0..i64::from(HEIGHT)).flat_map(|y| (0..WIDTH.into()).map(move |x| (x, y)));
        for (pixel, (x, y)) in frame.rgb.chunks_exact_mut(3).zip(places) {
            pixel.copy_from_slice(&self.pixel(x, y));
        }
        self.tick += self.speed;
        self.frames += 1;
        Next::Picture
    }

    fn key(&mut self, key: Key) {
        match key {
            Key::Char('g') => self.grid = !self.grid,
            Key::Left => self.speed -= 1,
            Key::Right => self.speed += 1,
            _ => {}
        }
    }

    fn status(&mut self) -> Option<String> {
        let rate = f64::from(self.frames) / self.since.elapsed().as_secs_f64();
        (self.since, self.frames) = (Instant::now(), 0);
        Some(format!("{rate:.0} refreshes/s"))
    }
}

fn main() -> ExitCode {
    let frames = match std::env::args().nth(1).map(|text| text.parse()) {
        None => None,
        Some(Ok(frames)) => Some(frames),
        Some(Err(_)) => {
            eprintln!("usage: window [FRAMES]");
            return ExitCode::FAILURE;
        }
    };
    let options = Options {
        title: "Unframed test pattern".into(),
        size: [WIDTH, HEIGHT],
        refresh_hz: 60,
        frames,
    };
    let since = Instant::now();
    let mut source = Pattern {
        tick: 0,
        speed: 1,
        grid: false,
        since,
        frames: 0,
    };
    match window::show(&options, &mut source) {
        Ok(shown) => {
            println!(
                "{} refreshes in {:.2} s, {} skipped, on {}",
                shown.refreshes, shown.seconds, shown.skipped, shown.adapter
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
