//! The window: its clock, its channel, its errors, and a real one under a virtual server.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use super::*;
use crate::testing::{adapter_or_skip, run_ignored};

#[test]
fn the_clock_keeps_its_phase_and_counts_what_it_missed() {
    let start = Instant::now();
    let ms = Duration::from_millis;
    let period = ms(10);
    assert_eq!(next_due(start, start, period), (start + ms(10), 0));
    assert_eq!(next_due(start, start + ms(9), period), (start + ms(10), 0));
    assert_eq!(next_due(start, start + ms(10), period), (start + ms(20), 1));
    assert_eq!(next_due(start, start + ms(34), period), (start + ms(40), 3));
    assert_eq!(next_due(start + ms(5), start, period), (start + ms(15), 0));
}

#[test]
fn a_channel_shows_the_newest_frame_and_ends_after_the_last() {
    let (sender, mut receiver) = std::sync::mpsc::channel();
    let mut frame = Frame::default();
    assert_eq!(receiver.next(&mut frame), Next::Unchanged);
    for width in 1..4 {
        sender
            .send(Frame::new(width, 1))
            .expect("the receiver lives");
    }
    assert_eq!(receiver.next(&mut frame), Next::Picture);
    assert_eq!(frame, Frame::new(3, 1));
    sender.send(Frame::new(9, 1)).expect("the receiver lives");
    drop(sender);
    assert_eq!(receiver.next(&mut frame), Next::Picture);
    assert_eq!(frame.width, 9);
    assert_eq!(receiver.next(&mut frame), Next::End);
}

/// Notes what it is told.
#[derive(Default)]
struct Listener {
    keys: Vec<Key>,
    pauses: Vec<bool>,
}

impl Source for Listener {
    fn next(&mut self, _frame: &mut Frame) -> Next {
        Next::Unchanged
    }

    fn key(&mut self, key: Key) {
        self.keys.push(key);
    }

    fn pause(&mut self, paused: bool) {
        self.pauses.push(paused);
    }
}

#[test]
fn keys_quit_and_pause_and_the_others_go_to_the_source() {
    let options = Options {
        title: String::new(),
        size: [1, 1],
        refresh_hz: 60,
        frames: None,
    };
    let mut source = Listener::default();
    let mut app = App::new(&options, &mut source);
    let character = |text: &str| WinitKey::Character(text.into());
    assert!(!app.press(&WinitKey::Named(NamedKey::Escape), false));
    assert!(!app.press(&character("q"), false));
    assert!(app.press(&WinitKey::Named(NamedKey::Space), false));
    assert!(app.paused);
    assert!(
        app.press(&WinitKey::Named(NamedKey::Space), true),
        "a held key"
    );
    assert!(app.paused);
    assert!(app.press(&WinitKey::Named(NamedKey::Space), false));
    assert!(!app.paused);
    assert!(app.press(&WinitKey::Named(NamedKey::ArrowLeft), true));
    assert!(app.press(&character("G"), false));
    assert!(app.press(&WinitKey::Named(NamedKey::Shift), false));
    assert_eq!(source.keys, [Key::Left, Key::Char('G')]);
    assert_eq!(source.pauses, [true, false]);
}

/// A source of `left` grey frames.
struct Grey {
    left: u32,
}

impl Source for Grey {
    fn next(&mut self, frame: &mut Frame) -> Next {
        let Some(left) = self.left.checked_sub(1) else {
            return Next::End;
        };
        self.left = left;
        *frame = Frame::new(64, 48);
        frame.rgb.fill(128);
        Next::Picture
    }

    fn status(&mut self) -> Option<String> {
        Some(format!("{} left", self.left))
    }
}

/// Shows 20 frames, or as many refreshes as `WINDOW_FRAMES` says; prints what happened.
#[test]
#[ignore = "run by the tests below in an environment of their own"]
fn child_window() {
    let frames = std::env::var("WINDOW_FRAMES")
        .ok()
        .and_then(|text| text.parse().ok());
    let options = Options {
        title: "test".into(),
        size: [64, 48],
        refresh_hz: 120,
        frames,
    };
    let mut source = Grey { left: 20 };
    match show(&options, &mut source) {
        Ok(shown) => println!("refreshes={} left={}", shown.refreshes, source.left),
        Err(error) => println!("error: {error}"),
    }
}

const CHILD: &str = "window::tests::child_window";
const NO_SERVER: [&str; 3] = ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"];

#[test]
fn without_a_display_server_the_error_says_what_to_do() {
    if cfg!(not(target_os = "linux")) {
        return; // Elsewhere there always is one.
    }
    let output = run_ignored(CHILD, &[], &NO_SERVER);
    assert!(output.contains("error: no window: "), "{output}");
    assert!(output.contains("or run headless"), "{output}");
    let output = run_ignored(CHILD, &[("DISPLAY", ":4095")], &NO_SERVER[1..]);
    assert!(output.contains("error: no window: "), "{output}");
}

/// A virtual X server, stopped when dropped.
struct Server {
    child: Child,
    display: String,
}

impl Server {
    /// `None` where Xvfb is not installed.
    fn start() -> Option<Server> {
        // Without -noreset the server restarts when a client leaves, and may lose the next one.
        let mut child = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "640x480x24",
                "-noreset",
                "-nolisten",
                "tcp",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut line = String::new();
        let stdout = child.stdout.take().expect("it is piped");
        BufReader::new(stdout)
            .read_line(&mut line)
            .expect("the number of the display");
        Some(Server {
            child,
            display: format!(":{}", line.trim()),
        })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_window_shows_its_frames_and_closes_by_itself() {
    if cfg!(not(target_os = "linux")) || adapter_or_skip("a window").is_none() {
        return;
    }
    let Some(server) = Server::start() else {
        assert!(
            std::env::var_os("CI").is_none(),
            "Xvfb is missing: apt-get install xvfb"
        );
        eprintln!("SKIPPED, not tested: a window: Xvfb is not installed");
        return;
    };
    let display = ("DISPLAY", server.display.as_str());
    let output = run_ignored(CHILD, &[display, ("WINDOW_FRAMES", "5")], &NO_SERVER[1..]);
    assert!(output.contains("refreshes=5 left="), "{output}");
    // Without a limit it ends with its source.
    let output = run_ignored(CHILD, &[display, ("WINDOW_FRAMES", "")], &NO_SERVER[1..]);
    assert!(output.contains(" left=0"), "{output}");
    // A window without a driver is an error with a remedy.
    let no_driver = [
        ("VK_ICD_FILENAMES", "/nonexistent.json"),
        ("VK_DRIVER_FILES", "/nonexistent.json"),
    ];
    let output = run_ignored(
        CHILD,
        &[display, no_driver[0], no_driver[1]],
        &NO_SERVER[1..],
    );
    assert!(
        output.contains("error: the window cannot be drawn to"),
        "{output}"
    );
    assert!(output.contains("mesa-vulkan-drivers"), "{output}");
}
