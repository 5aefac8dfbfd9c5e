//! The adapter: found, measured against what we need, opened; every failure is a value.
//!
//! wgpu panics on an error that nobody catches. Here nothing can reach that point:
//! [`Gpu::checked`] brackets calls with error scopes, and what slips past them (a lost device,
//! an error of a later frame) is kept and reported by the next call.

use std::fmt;
use std::sync::{Arc, Mutex};

use wgpu::{Backends, DeviceType, ErrorFilter, Limits};

/// What to do when there is no usable driver.
const REMEDY: &str = "install a Vulkan driver (Debian: apt-get install mesa-vulkan-drivers \
     libvulkan1; Mesa's lavapipe needs no graphics card) or choose the CPU display";

/// Why there is no adapter, or what went wrong on it.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver offered an adapter that fits the request.
    #[error("no graphics adapter: {reason}; adapters found: {found}; {REMEDY}")]
    NoAdapter {
        /// What the graphics library said.
        reason: String,
        /// The adapters that exist, or "none".
        found: String,
    },
    /// The adapter exists but cannot run the display.
    #[error("{adapter} cannot run the display: {missing}; {REMEDY}")]
    TooWeak {
        /// The adapter's description.
        adapter: String,
        /// Each limit that falls short: name, what it has, what is needed.
        missing: String,
    },
    /// The driver refused to open the device.
    #[error("{adapter} refused to open: {reason}; update its driver or choose the CPU display")]
    Refused {
        /// The adapter's description.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// A call failed: a shader did not compile, a buffer did not fit, the device was lost.
    #[error("graphics: {place}: {reason}")]
    Failed {
        /// What was being done: a stage's or buffer's name.
        place: String,
        /// What the driver or the validation said.
        reason: String,
    },
}

impl GpuError {
    pub(crate) fn failed(place: &str, reason: impl fmt::Display) -> Self {
        GpuError::Failed {
            place: place.to_owned(),
            reason: reason.to_string(),
        }
    }
}

/// An open adapter.
///
/// Invariant: the device has at least [`needed_limits`] and its uncaptured errors land in
/// `stray`, never in a panic.
pub struct Gpu {
    instance: wgpu::Instance,
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    stray: Arc<Mutex<Option<String>>>,
}

impl fmt::Debug for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Gpu({})", self.describe())
    }
}

impl Gpu {
    /// Opens the best adapter of the machine, without a window: a discrete card before a built-in
    /// one, a software rasteriser only where there is no other.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] without a driver, [`GpuError::TooWeak`] when it lacks compute
    /// shaders or storage buffers of the sizes needed, [`GpuError::Refused`] when it won't open.
    pub fn new() -> Result<Gpu, GpuError> {
        Gpu::open(new_instance(), None)
    }

    /// Opens the best adapter that can present to `surface`, which `instance` made.
    pub(crate) fn open(
        instance: wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Gpu, GpuError> {
        let request = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: surface,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&request)).map_err(|error| {
            GpuError::NoAdapter {
                reason: error.to_string(),
                found: list_adapters(&instance),
            }
        })?;
        let name = describe(&adapter.get_info());
        let missing = shortfalls(&adapter);
        if !missing.is_empty() {
            return Err(GpuError::TooWeak {
                adapter: name,
                missing: missing.join(", "),
            });
        }
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("unframed display"),
            required_limits: granted_limits(&adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| GpuError::Refused {
            adapter: name,
            reason: error.to_string(),
        })?;

        let stray = Arc::new(Mutex::new(None));
        let slot = Arc::clone(&stray);
        device.on_uncaptured_error(Arc::new(move |error| keep_first(&slot, error.to_string())));
        let slot = Arc::clone(&stray);
        device.set_device_lost_callback(move |reason, message| {
            // Dropping the device is also a loss, of which nobody needs to hear.
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep_first(&slot, format!("the device was lost: {message}"));
            }
        });
        Ok(Gpu {
            instance,
            adapter,
            device,
            queue,
            stray,
        })
    }

    /// The adapter in one line: name, kind, API and driver.
    #[must_use]
    pub fn describe(&self) -> String {
        describe(&self.adapter.get_info())
    }

    /// Whether a processor plays the graphics card (lavapipe, WARP).
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == DeviceType::Cpu
    }

    /// The open device, for calls that this crate does not wrap.
    #[must_use]
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue of the device.
    #[must_use]
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    pub(crate) fn instance(&self) -> &wgpu::Instance {
        &self.instance
    }

    pub(crate) fn adapter(&self) -> &wgpu::Adapter {
        &self.adapter
    }

    /// Runs `work`, whose errors would otherwise go to the handler of last resort, and returns
    /// them; `place` names what was being done.
    ///
    /// # Errors
    /// [`GpuError::Failed`] for validation, memory and internal errors of `work`, and for one
    /// left behind by an earlier call.
    pub fn checked<T>(&self, place: &str, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let scopes = [
            ErrorFilter::Internal,
            ErrorFilter::OutOfMemory,
            ErrorFilter::Validation,
        ]
        .map(|filter| self.device.push_error_scope(filter));
        let value = work();
        let mut first = None;
        // Scopes are a stack: the last pushed is the first popped.
        for scope in scopes.into_iter().rev() {
            let error = pollster::block_on(scope.pop());
            first = first.or(error.map(|error| error.to_string()));
        }
        match first.or_else(|| self.take_stray()) {
            Some(reason) => Err(GpuError::Failed {
                place: place.to_owned(),
                reason,
            }),
            None => Ok(value),
        }
    }

    /// An error that no scope caught, once.
    fn take_stray(&self) -> Option<String> {
        // A poisoned lock still holds the message.
        self.stray
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .take()
    }
}

/// The first of several errors is the cause, the rest are its consequences.
fn keep_first(slot: &Mutex<Option<String>>, message: String) {
    slot.lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
        .get_or_insert(message);
}

/// A new instance of the system's own API, independent of any window.
pub(crate) fn new_instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

/// What the shaders need: WebGPU's guaranteed limits, which every driver we know exceeds. They
/// cover 8 storage buffers a stage of 128 MiB each, workgroups of 256 invocations with 16 KiB,
/// and pictures of 8192 pixels a side.
#[must_use]
pub fn needed_limits() -> Limits {
    Limits::defaults()
}

/// The needed limits, with those of size raised to what the adapter has: a deep buffer for a
/// large panel is more than the guaranteed 128 MiB.
fn granted_limits(adapter: &Limits) -> Limits {
    Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        max_storage_buffers_per_shader_stage: adapter.max_storage_buffers_per_shader_stage.min(16),
        ..needed_limits()
    }
}

/// Each need that the adapter misses, in words.
fn shortfalls(adapter: &wgpu::Adapter) -> Vec<String> {
    let mut missing = Vec::new();
    let capabilities = adapter.get_downlevel_capabilities();
    if !capabilities
        .flags
        .contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
    {
        missing.push("no compute shaders".to_owned());
    }
    let limits = adapter.limits();
    needed_limits().check_limits_with_fail_fn(&limits, false, |name, needed, has| {
        missing.push(format!("{name} is {has}, needed {needed}"));
    });
    missing
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => "discrete",
        DeviceType::IntegratedGpu => "integrated",
        DeviceType::VirtualGpu => "virtual",
        DeviceType::Cpu => "software",
        DeviceType::Other => "unknown kind",
    };
    let driver = [info.driver.as_str(), info.driver_info.as_str()].join(" ");
    format!(
        "{} ({kind}, {}, driver {})",
        info.name,
        info.backend,
        driver.trim()
    )
}

fn list_adapters(instance: &wgpu::Instance) -> String {
    let adapters = pollster::block_on(instance.enumerate_adapters(Backends::all()));
    if adapters.is_empty() {
        return "none".to_owned();
    }
    let names: Vec<String> = adapters.iter().map(|a| describe(&a.get_info())).collect();
    names.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, adapter_or_skip};

    #[test]
    fn the_adapter_describes_itself_and_has_what_we_need() {
        let Some(gpu) = adapter_or_skip("opening an adapter") else {
            return;
        };
        let text = gpu.describe();
        assert!(text.contains(&gpu.adapter().get_info().name), "{text}");
        assert_eq!(gpu.is_software(), text.contains("software"), "{text}");
        assert!(gpu.device().limits().max_storage_buffers_per_shader_stage >= 8);
        assert!(needed_limits().check_limits(&gpu.device().limits()));
    }

    #[test]
    fn errors_become_values_and_do_not_linger() {
        let Some(gpu) = adapter_or_skip("error scopes") else {
            return;
        };
        let broken = wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl("fn f() -> u32 { return 1.5; }".into()),
        };
        let error = gpu.checked("broken.wgsl", || {
            gpu.device().create_shader_module(broken.clone())
        });
        let text = error.expect_err("1.5 is no u32").to_string();
        assert!(text.starts_with("graphics: broken.wgsl: "), "{text}");
        assert!(gpu.checked("nothing", || ()).is_ok());

        // Outside any scope: no panic, and the next checked call tells.
        let _ = gpu.device().create_shader_module(broken);
        assert!(gpu.checked("later", || ()).is_err());
        assert!(gpu.checked("later still", || ()).is_ok());
    }

    #[test]
    fn a_shortfall_is_named() {
        let weak = Limits {
            max_storage_buffers_per_shader_stage: 4,
            ..needed_limits()
        };
        let mut names = Vec::new();
        needed_limits()
            .check_limits_with_fail_fn(&weak, false, |name, n, h| names.push((name, n, h)));
        assert_eq!(names, [("max_storage_buffers_per_shader_stage", 8, 4)]);
    }

    /// The loader looks for drivers where the environment says; the variable must be set before
    /// the process starts, so this test runs itself again.
    #[test]
    fn without_a_driver_the_error_says_what_to_install() {
        let output = testing::run_ignored(
            "gpu::tests::child_without_driver",
            &[
                ("VK_ICD_FILENAMES", "/nonexistent.json"),
                ("VK_DRIVER_FILES", "/nonexistent.json"),
            ],
            &[],
        );
        if cfg!(not(target_os = "linux")) {
            return; // The variables steer the Vulkan loader alone.
        }
        assert!(output.contains("no graphics adapter"), "{output}");
        assert!(output.contains("adapters found: none"), "{output}");
        assert!(
            output.contains("apt-get install mesa-vulkan-drivers libvulkan1"),
            "{output}"
        );
    }

    #[test]
    #[ignore = "run by without_a_driver_the_error_says_what_to_install"]
    fn child_without_driver() {
        match Gpu::new() {
            Ok(gpu) => println!("opened {}", gpu.describe()),
            Err(error) => println!("{error}"),
        }
    }
}
