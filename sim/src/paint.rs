//! A picture onto a surface: whole-number upscaling, centred, black around it.
//!
//! No filter and no colour conversion: what the panel shows are the bytes of the picture.

use crate::gpu::{Gpu, GpuError};

/// A picture of 8-bit RGB, rows from the top, display-referred (sRGB).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 3 bytes a pixel; exactly `3 * width * height`.
    pub rgb: Vec<u8>,
}

impl Frame {
    /// A black picture.
    #[must_use]
    pub fn new(width: u16, height: u16) -> Frame {
        let rgb = vec![0; usize::from(width) * usize::from(height) * 3];
        Frame {
            width: width.into(),
            height: height.into(),
            rgb,
        }
    }

    /// Whether the bytes fit the size, and there are any.
    fn is_whole(&self) -> bool {
        let bytes = u64::from(self.width) * u64::from(self.height) * 3;
        bytes > 0 && bytes == self.rgb.len() as u64
    }
}

/// Where a picture lands on a surface, in surface pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// Its top left corner; negative where the surface crops it.
    pub origin: [i32; 2],
    /// Surface pixels a picture pixel along each axis, 1 or more.
    pub scale: i32,
}

impl Placement {
    /// The largest whole-number scale at which `picture` fits into `surface`, centred; a picture
    /// larger than the surface is cropped equally on both sides. Sizes are width and height, at
    /// most 2^16 each.
    #[must_use]
    pub fn fit(picture: [u32; 2], surface: [u32; 2]) -> Placement {
        let ratio = |i: usize| surface[i] / picture[i].max(1);
        let scale = ratio(0).min(ratio(1)).max(1);
        // Sizes of at most 2^16 keep the products within i32 whenever the scale is above 1.
        let origin = |i: usize| (surface[i] as i32 - (picture[i] * scale) as i32).div_euclid(2);
        Placement {
            origin: [origin(0), origin(1)],
            scale: scale as i32,
        }
    }
}

/// The pipeline that paints pictures onto textures of one format.
#[derive(Debug)]
pub(crate) struct Painter {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    placement: wgpu::Buffer,
    picture: Option<wgpu::Texture>,
    /// Whether the surface encodes to sRGB on writing, so that reading must decode.
    encodes: bool,
    rgba: Vec<u8>,
}

impl Painter {
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Painter, GpuError> {
        gpu.checked("paint.wgsl", || {
            let device = gpu.device();
            let module = device.create_shader_module(wgpu::include_wgsl!("shaders/paint.wgsl"));
            let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty,
                count: None,
            };
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("paint"),
                entries: &[
                    entry(
                        0,
                        wgpu::BindingType::Buffer {
                            ty: wgpu::BufferBindingType::Uniform,
                            has_dynamic_offset: false,
                            min_binding_size: None,
                        },
                    ),
                    entry(
                        1,
                        wgpu::BindingType::Texture {
                            sample_type: wgpu::TextureSampleType::Float { filterable: false },
                            view_dimension: wgpu::TextureViewDimension::D2,
                            multisampled: false,
                        },
                    ),
                ],
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("paint"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("paint"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("cover"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("paint"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            });
            let placement = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("placement"),
                size: 16,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let encodes = format.is_srgb();
            Painter {
                layout,
                pipeline,
                placement,
                picture: None,
                encodes,
                rgba: Vec::new(),
            }
        })
    }

    /// Makes `frame` the picture of the next [`Painter::paint`].
    pub(crate) fn load(&mut self, gpu: &Gpu, frame: &Frame) -> Result<(), GpuError> {
        if !frame.is_whole() {
            let Frame { width, height, rgb } = frame;
            let reason = format!("{} bytes for {width}x{height} pixels of 3 bytes", rgb.len());
            return Err(GpuError::failed("picture", reason));
        }
        self.rgba.clear();
        for pixel in frame.rgb.chunks_exact(3) {
            self.rgba
                .extend_from_slice(&[pixel[0], pixel[1], pixel[2], 255]);
        }
        let extent = wgpu::Extent3d {
            width: frame.width,
            height: frame.height,
            depth_or_array_layers: 1,
        };
        let fits = self
            .picture
            .as_ref()
            .is_some_and(|texture| texture.size() == extent);
        if !fits {
            self.picture = Some(self.new_texture(gpu, extent)?);
        }
        let Some(texture) = &self.picture else {
            return Ok(());
        };
        gpu.checked("picture", || {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(frame.width * 4),
                rows_per_image: None,
            };
            gpu.queue()
                .write_texture(texture.as_image_copy(), &self.rgba, layout, extent);
        })
    }

    fn new_texture(&self, gpu: &Gpu, size: wgpu::Extent3d) -> Result<wgpu::Texture, GpuError> {
        let (plain, srgb) = (
            wgpu::TextureFormat::Rgba8Unorm,
            wgpu::TextureFormat::Rgba8UnormSrgb,
        );
        gpu.checked("picture", || {
            gpu.device().create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: if self.encodes { srgb } else { plain },
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        })
    }

    /// Paints the picture, or black before the first, onto `target`.
    pub(crate) fn paint(&self, gpu: &Gpu, target: &wgpu::Texture) -> Result<(), GpuError> {
        gpu.checked("paint", || {
            let view = target.create_view(&wgpu::TextureViewDescriptor::default());
            let group = self.picture.as_ref().map(|picture| {
                let sizes = [picture, target].map(|t| [t.width(), t.height()]);
                let Placement { origin, scale } = Placement::fit(sizes[0], sizes[1]);
                let words = [origin[0], origin[1], scale, 0];
                gpu.queue()
                    .write_buffer(&self.placement, 0, bytemuck::bytes_of(&words));
                self.bind(gpu, picture)
            });
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("paint"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            if let Some(group) = &group {
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, group, &[]);
                pass.draw(0..3, 0..1);
            }
            drop(pass);
            gpu.queue().submit([encoder.finish()]);
        })
    }

    fn bind(&self, gpu: &Gpu, picture: &wgpu::Texture) -> wgpu::BindGroup {
        let view = picture.create_view(&wgpu::TextureViewDescriptor::default());
        gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("paint"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: self.placement.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pass::read_staging;
    use crate::testing::{Random, adapter_or_skip};

    #[test]
    fn the_scale_is_the_largest_that_fits_and_the_picture_is_centred() {
        let fit = |p, s| Placement::fit(p, s);
        assert_eq!(
            fit([100, 50], [250, 250]),
            Placement {
                origin: [25, 75],
                scale: 2
            }
        );
        assert_eq!(
            fit([100, 50], [200, 100]),
            Placement {
                origin: [0, 0],
                scale: 2
            }
        );
        assert_eq!(
            fit([100, 50], [199, 500]),
            Placement {
                origin: [49, 225],
                scale: 1
            }
        );
        assert_eq!(
            fit([100, 50], [50, 51]),
            Placement {
                origin: [-25, 0],
                scale: 1
            }
        );
        assert_eq!(fit([1, 1], [0, 0]).scale, 1);
        assert_eq!(fit([0, 0], [9, 9]).scale, 9);
    }

    /// What the adapter painted, as rows of RGBA.
    fn painted(gpu: &Gpu, frame: &Frame, size: [u32; 2], format: wgpu::TextureFormat) -> Vec<u8> {
        let mut painter = Painter::new(gpu, format).expect("the shader compiles");
        painter.load(gpu, frame).expect("a whole frame");
        let extent = wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        };
        let target = gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        painter.paint(gpu, &target).expect("valid commands");
        let row = size[0] * 4;
        assert_eq!(row % wgpu::COPY_BYTES_PER_ROW_ALIGNMENT, 0);
        let staging = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * size[1]),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo {
            buffer: &staging,
            layout,
        };
        encoder.copy_texture_to_buffer(target.as_image_copy(), to, extent);
        gpu.queue().submit([encoder.finish()]);
        read_staging(gpu, "painted", &staging, |bytes| bytes).expect("the device answers")
    }

    /// The same in Rust.
    fn expected(frame: &Frame, size: [u32; 2]) -> Vec<u8> {
        let Placement { origin, scale } = Placement::fit([frame.width, frame.height], size);
        let mut out = Vec::new();
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let u = (x as i32 - origin[0]).div_euclid(scale);
            let v = (y as i32 - origin[1]).div_euclid(scale);
            let inside =
                (0..frame.width as i32).contains(&u) && (0..frame.height as i32).contains(&v);
            let at = if inside {
                (v as usize * frame.width as usize + u as usize) * 3
            } else {
                0
            };
            let pixel = if inside {
                &frame.rgb[at..at + 3]
            } else {
                &[0; 3]
            };
            out.extend_from_slice(pixel);
            out.push(255);
        }
        out
    }

    #[test]
    fn every_byte_arrives_on_plain_and_on_srgb_surfaces() {
        let Some(gpu) = adapter_or_skip("painting pictures") else {
            return;
        };
        let mut frame = Frame::new(24, 32);
        let mut random = Random(7);
        // Each of the 256 values in each channel, shuffled.
        for (i, byte) in frame.rgb.iter_mut().enumerate() {
            *byte = (i / 3) as u8 ^ (random.next() >> 56) as u8;
        }
        for size in [[64, 64], [128, 70], [64, 20]] {
            for format in [
                wgpu::TextureFormat::Rgba8Unorm,
                wgpu::TextureFormat::Rgba8UnormSrgb,
            ] {
                let (got, want) = (painted(&gpu, &frame, size, format), expected(&frame, size));
                let differing = got.iter().zip(&want).filter(|(a, b)| a != b).count();
                assert_eq!(
                    (got.len(), differing),
                    (want.len(), 0),
                    "{size:?} {format:?}"
                );
            }
        }
    }

    #[test]
    fn a_frame_whose_bytes_do_not_fit_its_size_is_refused() {
        let Some(gpu) = adapter_or_skip("refusing pictures") else {
            return;
        };
        let mut painter = Painter::new(&gpu, wgpu::TextureFormat::Rgba8Unorm).expect("compiles");
        let short = Frame {
            width: 2,
            height: 2,
            rgb: vec![0; 11],
        };
        let error = painter
            .load(&gpu, &short)
            .expect_err("11 is not 12")
            .to_string();
        assert!(error.contains("11 bytes for 2x2"), "{error}");
        assert!(painter.load(&gpu, &Frame::default()).is_err());
        let long = Frame {
            width: 20_000,
            height: 1,
            rgb: vec![0; 60_000],
        };
        assert!(painter.load(&gpu, &long).is_err(), "wider than any texture");
    }
}
