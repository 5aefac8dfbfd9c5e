//! Integer compute passes: stages made from WGSL, buffers of 32-bit words, and a way to read
//! every one of them back, so that each stage can be compared with its Rust twin word by word.
//!
//! ```no_run
//! use unframed_sim::pass::{Access, Batch, Stage, Words};
//! # fn main() -> Result<(), unframed_sim::GpuError> {
//! let gpu = unframed_sim::Gpu::new()?;
//! let source = "
//!     @group(0) @binding(0) var<storage, read> input: array<u32>;
//!     @group(0) @binding(1) var<storage, read_write> output: array<u32>;
//!     @compute @workgroup_size(64)
//!     fn main(@builtin(global_invocation_id) id: vec3<u32>) {
//!         if id.x < arrayLength(&input) { output[id.x] = 2u * input[id.x]; }
//!     }";
//! let stage = Stage::new(&gpu, "double", &[source], &[Access::Read, Access::Write])?;
//! let input = Words::upload(&gpu, "input", &[1, 2, 3])?;
//! let output = Words::zeroed(&gpu, "output", 3)?;
//! let mut batch = Batch::new(&gpu);
//! batch.run(&stage, &[&input, &output], [1, 1, 1])?;
//! batch.submit()?;
//! assert_eq!(output.read(&gpu)?, [2, 4, 6]);
//! # Ok(()) }
//! ```

use std::time::Duration;

use wgpu::{BufferUsages, ShaderStages};

use crate::gpu::{Gpu, GpuError};

/// 64-bit arithmetic for WGSL; put it before the source of a stage that needs it.
pub const INT64: &str = include_str!("shaders/int64.wgsl");

/// The longest that submitted work may take before it counts as hung. lavapipe on a loaded
/// machine needs a second for the largest stage that we know.
const PATIENCE: Duration = Duration::from_secs(60);

/// Most workgroups along one axis (`max_compute_workgroups_per_dimension`).
const MAX_GROUPS: u32 = 65_535;

/// How a stage uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`, atomics included.
    Write,
    /// `var<uniform>`.
    Uniform,
}

/// A compute pipeline with one bind group: binding i of group 0 is the i-th buffer.
#[derive(Debug)]
pub struct Stage {
    name: String,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    bindings: usize,
}

impl Stage {
    /// Compiles the concatenated `sources`, whose only entry point is a compute shader.
    ///
    /// # Errors
    /// [`GpuError::Failed`] with the stage's name and the compiler's message.
    pub fn new(
        gpu: &Gpu,
        name: &str,
        sources: &[&str],
        bindings: &[Access],
    ) -> Result<Stage, GpuError> {
        gpu.checked(name, || {
            let device = gpu.device();
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(sources.join("\n").into()),
            });
            let entries: Vec<_> = (0..)
                .zip(bindings)
                .map(|(i, a)| layout_entry(i, *a))
                .collect();
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(name),
                entries: &entries,
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            Stage {
                name: name.to_owned(),
                layout,
                pipeline,
                bindings: bindings.len(),
            }
        })
    }
}

fn layout_entry(binding: u32, access: Access) -> wgpu::BindGroupLayoutEntry {
    let ty = match access {
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Access::Write => wgpu::BufferBindingType::Storage { read_only: false },
        Access::Uniform => wgpu::BufferBindingType::Uniform,
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

/// A buffer of 32-bit words on the adapter.
#[derive(Debug)]
pub struct Words {
    name: String,
    buffer: wgpu::Buffer,
}

impl Words {
    /// A buffer of `len` zeros; WebGPU has no empty bindings, so 0 makes one word.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when it is too large for the adapter or its memory.
    pub fn zeroed(gpu: &Gpu, name: &str, len: usize) -> Result<Words, GpuError> {
        // New buffers read as zero (WebGPU §buffer creation).
        let buffer = gpu.checked(name, || {
            gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(name),
                size: bytes(len.max(1)),
                usage: BufferUsages::STORAGE
                    | BufferUsages::UNIFORM
                    | BufferUsages::COPY_SRC
                    | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        Ok(Words {
            name: name.to_owned(),
            buffer,
        })
    }

    /// A buffer that holds `words`.
    ///
    /// # Errors
    /// As for [`Words::zeroed`].
    pub fn upload(gpu: &Gpu, name: &str, words: &[u32]) -> Result<Words, GpuError> {
        let buffer = Words::zeroed(gpu, name, words.len())?;
        buffer.write(gpu, 0, words)?;
        Ok(buffer)
    }

    /// Replaces the words from index `first` on, before anything submitted later runs.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when they reach beyond the end.
    pub fn write(&self, gpu: &Gpu, first: usize, words: &[u32]) -> Result<(), GpuError> {
        gpu.checked(&self.name, || {
            gpu.queue()
                .write_buffer(&self.buffer, bytes(first), bytemuck::cast_slice(words));
        })
    }

    /// Number of words.
    #[must_use]
    pub fn len(&self) -> usize {
        // It came from a usize.
        (self.buffer.size() / 4) as usize
    }

    /// Whether there are no words: never.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Waits for everything submitted and copies the words back.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when the device is lost, hangs for a minute or has no memory left.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        self.read_part(gpu, 0, self.len())
    }

    /// As [`Words::read`], `len` words from index `first` on.
    ///
    /// # Errors
    /// As for [`Words::read`], and when they reach beyond the end.
    pub fn read_part(&self, gpu: &Gpu, first: usize, len: usize) -> Result<Vec<u32>, GpuError> {
        if len == 0 {
            return Ok(Vec::new());
        }
        let staging = gpu.checked(&self.name, || {
            let device = gpu.device();
            let staging = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&self.name),
                size: bytes(len),
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder = device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.buffer, bytes(first), &staging, 0, bytes(len));
            gpu.queue().submit([encoder.finish()]);
            staging
        })?;
        read_staging(gpu, &self.name, &staging, bytemuck::cast_slice::<u8, u32>)
    }
}

/// Maps a staging buffer, waits for it and hands its bytes to `convert`.
pub(crate) fn read_staging<T: Clone>(
    gpu: &Gpu,
    place: &str,
    staging: &wgpu::Buffer,
    convert: impl FnOnce(&[u8]) -> &[T],
) -> Result<Vec<T>, GpuError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    gpu.checked(place, || {
        staging.map_async(wgpu::MapMode::Read, .., move |outcome| {
            // The receiver lives until the end of this function; afterwards nobody asks.
            let _ = sender.send(outcome);
        });
    })?;
    let wait = wgpu::PollType::Wait {
        submission_index: None,
        timeout: Some(PATIENCE),
    };
    gpu.device()
        .poll(wait)
        .map_err(|error| GpuError::failed(place, error))?;
    let mapped = receiver
        .try_recv()
        .map_err(|_| GpuError::failed(place, "mapping hung"))?;
    mapped.map_err(|error| GpuError::failed(place, error))?;
    let view = staging
        .get_mapped_range(..)
        .map_err(|error| GpuError::failed(place, error))?;
    Ok(convert(&view).to_vec())
}

fn bytes(words: usize) -> u64 {
    words as u64 * 4
}

/// Workgroups of `group` invocations for `items` linear items, spread over x and y as the axes
/// are bounded. The stage finds its item as
/// `(workgroup_id.y * num_workgroups.x + workgroup_id.x) * group + local_invocation_index`
/// and ignores those past the end.
#[must_use]
pub fn linear_grid(items: usize, group: u32) -> [u32; 3] {
    let groups = items.div_ceil(group.max(1) as usize).max(1);
    let rows = groups.div_ceil(MAX_GROUPS as usize);
    // At most MAX_GROUPS columns by construction, and rows below that for any buffer.
    [groups.div_ceil(rows) as u32, rows as u32, 1]
}

/// Recorded stages that run in order, each seeing what the one before it wrote.
pub struct Batch<'g> {
    gpu: &'g Gpu,
    encoder: wgpu::CommandEncoder,
}

impl std::fmt::Debug for Batch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Batch").finish_non_exhaustive()
    }
}

impl<'g> Batch<'g> {
    /// An empty batch.
    #[must_use]
    pub fn new(gpu: &'g Gpu) -> Batch<'g> {
        let encoder = gpu.device().create_command_encoder(&Default::default());
        Batch { gpu, encoder }
    }

    /// Appends one dispatch of `stage` over `groups` workgroups with its buffers in the order of
    /// its bindings.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when buffers and bindings don't fit each other.
    pub fn run(
        &mut self,
        stage: &Stage,
        buffers: &[&Words],
        groups: [u32; 3],
    ) -> Result<(), GpuError> {
        if buffers.len() != stage.bindings {
            let reason = format!("{} buffers for {} bindings", buffers.len(), stage.bindings);
            return Err(GpuError::failed(&stage.name, reason));
        }
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, words)| wgpu::BindGroupEntry {
                binding,
                resource: words.buffer.as_entire_binding(),
            })
            .collect();
        self.gpu.checked(&stage.name, || {
            let group = self
                .gpu
                .device()
                .create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(&stage.name),
                    layout: &stage.layout,
                    entries: &entries,
                });
            let mut pass = self
                .encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(&stage.name),
                    timestamp_writes: None,
                });
            pass.set_pipeline(&stage.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups[0], groups[1], groups[2]);
        })
    }

    /// Appends: set every word of `words` to zero.
    pub fn clear(&mut self, words: &Words) {
        self.encoder.clear_buffer(&words.buffer, 0, None);
    }

    /// Starts the work; [`Words::read`] waits for it.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when validation rejects a recorded command.
    pub fn submit(self) -> Result<(), GpuError> {
        self.gpu.checked("submit", || {
            self.gpu.queue().submit([self.encoder.finish()]);
        })
    }
}

#[cfg(test)]
#[path = "pass_tests.rs"]
mod tests;
