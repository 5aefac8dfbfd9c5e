//! A live window: shows what a [`Source`] gives, at the panel's refresh rate.
//!
//! The clock is ours, not the presentation's: a Fifo surface blocks at the monitor's rate, or not
//! at all under a virtual server, and the panel that we simulate has its own. A source that is too
//! slow loses refreshes, which are counted, instead of falling behind.
//!
//! Keys: Esc and q quit, space pauses; all others go to the source.

use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key as WinitKey, NamedKey};
use winit::window::{Window, WindowId};

use crate::gpu::{Gpu, GpuError, new_instance};
use crate::paint::Painter;
pub use crate::paint::{Frame, Placement};
pub use crate::source::{Key, Next, Source};

/// How the window behaves.
#[derive(Clone, Debug)]
pub struct Options {
    /// Title, before the source's status.
    pub title: String,
    /// The picture's size in pixels, for the window's first size.
    pub size: [u16; 2],
    /// Refreshes a second, 1..=1000.
    pub refresh_hz: u32,
    /// Close after this many refreshes shown.
    pub frames: Option<u64>,
}

/// What a window did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Refreshes presented.
    pub refreshes: u64,
    /// Refreshes that passed without one, as the source or the machine was late.
    pub skipped: u64,
    /// Seconds from the first refresh to the close.
    pub seconds: f64,
    /// The adapter that presented.
    pub adapter: String,
}

/// Why there is no window, or why it closed.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No display server.
    #[error(
        "no window: {0}; start it in a graphical session (or under `xvfb-run`), or run headless"
    )]
    NoDisplay(String),
    /// The server refused the window.
    #[error("no window: the display server refused it: {0}; run headless")]
    Refused(String),
    /// The window exists but the driver cannot present to it.
    #[error("the window cannot be drawn to: {0}; run headless, or {remedy}", remedy = PRESENT_REMEDY)]
    Surface(String),
    /// The adapter.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

const PRESENT_REMEDY: &str = "install a Vulkan driver that presents to it (Debian: apt-get \
     install mesa-vulkan-drivers libvulkan1)";

/// Shows `source` in a window until it ends or the user closes it. Call it from the main thread,
/// once a process (window systems demand both).
///
/// # Errors
/// [`WindowError`]; each names a remedy.
pub fn show(options: &Options, source: &mut dyn Source) -> Result<Shown, WindowError> {
    let event_loop =
        build_event_loop().map_err(|error| WindowError::NoDisplay(error.to_string()))?;
    let mut app = App::new(options, source);
    event_loop
        .run_app(&mut app)
        .map_err(|error| WindowError::Refused(error.to_string()))?;
    app.outcome?;
    app.shown.seconds = app
        .started
        .map_or(0.0, |start| start.elapsed().as_secs_f64());
    Ok(app.shown)
}

/// X11 and Wayland accept any thread, so there we do too, instead of winit's panic.
fn build_event_loop() -> Result<EventLoop<()>, winit::error::EventLoopError> {
    let mut builder = EventLoop::builder();
    #[cfg(target_os = "linux")]
    {
        use winit::platform::{wayland, x11};
        x11::EventLoopBuilderExtX11::with_any_thread(&mut builder, true);
        wayland::EventLoopBuilderExtWayland::with_any_thread(&mut builder, true);
    }
    builder.build()
}

/// A window that can be drawn to. The surface comes first: it must go before its window.
struct Screen {
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    painter: Painter,
    gpu: Gpu,
    window: Arc<Window>,
}

impl Screen {
    fn open(event_loop: &ActiveEventLoop, options: &Options) -> Result<Screen, WindowError> {
        let [width, height] = options.size.map(|side| u32::from(side).max(1));
        // At least 480 rows where the picture is small: a 128-pixel panel is a stamp otherwise.
        let scale = (480 / height).max(1);
        let attributes = Window::default_attributes()
            .with_title(&options.title)
            .with_inner_size(PhysicalSize::new(width * scale, height * scale));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| WindowError::Refused(error.to_string()))?;
        let window = Arc::new(window);

        let instance = new_instance();
        let surface = instance
            .create_surface(Arc::clone(&window))
            .map_err(|error| WindowError::Surface(error.to_string()))?;
        let gpu = Gpu::open(instance, Some(&surface))?;
        let size = window.inner_size();
        let configuration = configure(&gpu, &surface, size)?;
        let painter = Painter::new(&gpu, configuration.format)?;
        Ok(Screen {
            surface,
            configuration,
            painter,
            gpu,
            window,
        })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) -> Result<(), GpuError> {
        let most = self.gpu.device().limits().max_texture_dimension_2d;
        self.configuration.width = size.width.clamp(1, most);
        self.configuration.height = size.height.clamp(1, most);
        self.reconfigure()
    }

    fn reconfigure(&self) -> Result<(), GpuError> {
        self.gpu.checked("surface", || {
            self.surface
                .configure(self.gpu.device(), &self.configuration);
        })
    }

    /// Presents the picture loaded last; false when the surface had no room for it now.
    fn present(&mut self) -> Result<bool, WindowError> {
        use wgpu::CurrentSurfaceTexture as Current;
        let current = self
            .gpu
            .checked("surface", || self.surface.get_current_texture())?;
        let (target, again) = match current {
            Current::Success(target) => (target, false),
            Current::Suboptimal(target) => (target, true),
            Current::Timeout | Current::Occluded => return Ok(false),
            Current::Outdated | Current::Validation => {
                self.reconfigure()?;
                return Ok(false);
            }
            Current::Lost => {
                self.surface = self
                    .gpu
                    .instance()
                    .create_surface(Arc::clone(&self.window))
                    .map_err(|error| WindowError::Surface(error.to_string()))?;
                self.reconfigure()?;
                return Ok(false);
            }
        };
        self.painter.paint(&self.gpu, &target.texture)?;
        self.window.pre_present_notify();
        self.gpu
            .checked("present", || self.gpu.queue().present(target))?;
        if again {
            self.reconfigure()?;
        }
        Ok(true)
    }
}

/// Configures the surface for bytes that pass unchanged, in the order of their making.
fn configure(
    gpu: &Gpu,
    surface: &wgpu::Surface<'_>,
    size: PhysicalSize<u32>,
) -> Result<wgpu::SurfaceConfiguration, WindowError> {
    let most = gpu.device().limits().max_texture_dimension_2d;
    let (width, height) = (size.width.clamp(1, most), size.height.clamp(1, most));
    let mut configuration = surface
        .get_default_config(gpu.adapter(), width, height)
        .ok_or_else(|| WindowError::Surface(format!("{} cannot present to it", gpu.describe())))?;
    // Our bytes are encoded already: a format that doesn't encode again saves the round trip.
    let formats = surface.get_capabilities(gpu.adapter()).formats;
    let plain = [
        wgpu::TextureFormat::Bgra8Unorm,
        wgpu::TextureFormat::Rgba8Unorm,
    ];
    if let Some(format) = plain.into_iter().find(|format| formats.contains(format)) {
        configuration.format = format;
    }
    // The default may be Immediate, which tears.
    configuration.present_mode = wgpu::PresentMode::Fifo;
    configuration.desired_maximum_frame_latency = 1;
    gpu.checked("surface", || {
        surface.configure(gpu.device(), &configuration)
    })?;
    Ok(configuration)
}

struct App<'a> {
    options: &'a Options,
    source: &'a mut dyn Source,
    period: Duration,
    screen: Option<Screen>,
    frame: Frame,
    /// When the next refresh is due.
    due: Instant,
    started: Option<Instant>,
    titled: Option<Instant>,
    paused: bool,
    shown: Shown,
    outcome: Result<(), WindowError>,
}

impl<'a> App<'a> {
    fn new(options: &'a Options, source: &'a mut dyn Source) -> App<'a> {
        App {
            options,
            source,
            period: Duration::from_secs(1) / options.refresh_hz.clamp(1, 1000),
            screen: None,
            frame: Frame::default(),
            due: Instant::now(),
            started: None,
            titled: None,
            paused: false,
            shown: Shown::default(),
            outcome: Ok(()),
        }
    }

    /// Ends the loop, with the first error if there is one.
    fn finish(&mut self, event_loop: &ActiveEventLoop, outcome: Result<(), WindowError>) {
        if self.outcome.is_ok() {
            self.outcome = outcome;
        }
        event_loop.exit();
    }

    /// One refresh: asks the source, presents, keeps the clock. Returns whether to go on.
    fn refresh(&mut self, now: Instant) -> Result<bool, WindowError> {
        let Some(screen) = &mut self.screen else {
            return Ok(true);
        };
        self.started.get_or_insert(now);
        if !self.paused {
            match self.source.next(&mut self.frame) {
                Next::Picture => screen.painter.load(&screen.gpu, &self.frame)?,
                Next::Unchanged => {}
                Next::End => return Ok(false),
            }
        }
        let presented = screen.present()?;
        if presented {
            self.shown.refreshes += 1;
        }
        if self
            .titled
            .is_none_or(|last| now - last >= Duration::from_millis(500))
        {
            self.titled = Some(now);
            self.set_title();
        }
        let (due, missed) = next_due(self.due, Instant::now(), self.period);
        self.due = due;
        self.shown.skipped += missed + u64::from(!presented);
        Ok(self
            .options
            .frames
            .is_none_or(|frames| self.shown.refreshes < frames))
    }

    fn set_title(&mut self) {
        let Some(screen) = &self.screen else { return };
        let mut title = self.options.title.clone();
        if let Some(status) = self.source.status() {
            title.push_str(" | ");
            title.push_str(&status);
        }
        if self.paused {
            title.push_str(" | paused");
        }
        screen.window.set_title(&title);
    }

    /// A key press; returns whether to go on.
    fn press(&mut self, key: &WinitKey, repeat: bool) -> bool {
        let key = match key {
            WinitKey::Named(NamedKey::Escape) => return false,
            WinitKey::Named(NamedKey::Space) => {
                if !repeat {
                    self.paused = !self.paused;
                    self.source.pause(self.paused);
                    self.set_title();
                }
                return true;
            }
            WinitKey::Named(NamedKey::ArrowLeft) => Key::Left,
            WinitKey::Named(NamedKey::ArrowRight) => Key::Right,
            WinitKey::Named(NamedKey::ArrowUp) => Key::Up,
            WinitKey::Named(NamedKey::ArrowDown) => Key::Down,
            WinitKey::Character(text) => match text.chars().next() {
                Some('q') => return false,
                Some(letter) => Key::Char(letter),
                None => return true,
            },
            _ => return true,
        };
        self.source.key(key);
        true
    }
}

/// When the refresh after the one due at `due` is due, and how many are past by `now`: the clock
/// keeps its phase and never catches up in a burst.
fn next_due(due: Instant, now: Instant, period: Duration) -> (Instant, u64) {
    let late = now.saturating_duration_since(due).as_nanos() / period.as_nanos().max(1);
    let missed = u32::try_from(late).unwrap_or(u32::MAX);
    match period
        .checked_mul(missed)
        .and_then(|skip| (due + period).checked_add(skip))
    {
        Some(next) => (next, missed.into()),
        None => (now, missed.into()),
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        match Screen::open(event_loop, self.options) {
            Ok(screen) => {
                self.shown.adapter = screen.gpu.describe();
                self.screen = Some(screen);
                self.due = Instant::now();
                event_loop.set_control_flow(ControlFlow::WaitUntil(self.due));
            }
            Err(error) => self.finish(event_loop, Err(error)),
        }
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, _cause: StartCause) {
        let now = Instant::now();
        if self.screen.is_none() || event_loop.exiting() || now < self.due {
            return;
        }
        match self.refresh(now) {
            Ok(true) => event_loop.set_control_flow(ControlFlow::WaitUntil(self.due)),
            Ok(false) => self.finish(event_loop, Ok(())),
            Err(error) => self.finish(event_loop, Err(error)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _id: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => self.finish(event_loop, Ok(())),
            WindowEvent::Resized(size) => {
                let resized = self.screen.as_mut().map(|screen| screen.resize(size));
                if let Some(Err(error)) = resized {
                    self.finish(event_loop, Err(error.into()));
                }
            }
            WindowEvent::KeyboardInput {
                event:
                    KeyEvent {
                        logical_key,
                        state: ElementState::Pressed,
                        repeat,
                        ..
                    },
                ..
            } => {
                let go_on = self.press(&logical_key, repeat);
                if !go_on {
                    self.finish(event_loop, Ok(()));
                }
            }
            _ => {}
        }
    }

    fn exiting(&mut self, _event_loop: &ActiveEventLoop) {
        // The surface must not outlive the connection to the display server.
        self.screen = None;
    }
}

#[cfg(test)]
#[path = "window_tests.rs"]
mod tests;
