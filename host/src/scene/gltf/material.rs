//! Materials and textures (glTF 2.0 §3.9, §3.8, and the KHR extensions named in
//! [`super`]).

use super::error::{Fault, Warnings, place};
use super::source::Source;
use crate::scene::{MIRROR_ROUGHNESS, Material, Texture, TextureRef};
use glam::{Mat2, Vec2, Vec3, Vec4};
use gltf::material::AlphaMode;
use gltf::texture::{Info, WrappingMode};

/// The materials of a file, and what primitives need to know to use them.
pub(super) struct Materials {
    /// In the order of the file; then, if asked for, the default material.
    pub(super) materials: Vec<Material>,
    /// Decoded images, each once for each pair of wrapping modes.
    pub(super) textures: Vec<Texture>,
    /// For each material, where its primitives take their texture coordinates from.
    pub(super) coordinates: Vec<Coordinates>,
    /// Image and wrapping of each of `textures`.
    keys: Vec<(usize, bool, bool)>,
}

/// Which attribute a material's texture coordinates come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    /// The set: TEXCOORD_`set`.
    pub(super) set: u32,
    /// Applied to the coordinates once, at loading: the rotation and all of a
    /// KHR_texture_transform that has one, which [`TextureRef`] cannot say.
    pub(super) baked: Option<(Mat2, Vec2)>,
}

impl Materials {
    /// Converts all materials of a file.
    pub(super) fn load(source: &Source, warnings: &mut Warnings) -> Result<Self, Fault> {
        let mut all = Self {
            materials: Vec::new(),
            textures: Vec::new(),
            coordinates: Vec::new(),
            keys: Vec::new(),
        };
        for (index, material) in source.document.materials().enumerate() {
            let at = place("material", index, material.name());
            let (material, coordinates) = all.convert(source, &material, &at, warnings)?;
            all.materials.push(material);
            all.coordinates.push(coordinates);
        }
        Ok(all)
    }

    /// Index of the material that primitives without one get.
    ///
    /// glTF's default (§3.7.2.1) is a white rough metal, which shows little more than the
    /// environment it reflects; ours is white and matt, so that light and shadow show.
    pub(super) fn default_material(&mut self) -> usize {
        let material = Material {
            name: "default".into(),
            ..Material::default()
        };
        let count = self.coordinates.len();
        if let Some(found) = self.materials[..count].iter().position(|m| *m == material) {
            return found;
        }
        self.materials.push(material);
        self.coordinates.push(Coordinates {
            set: 0,
            baked: None,
        });
        count
    }

    fn convert(
        &mut self,
        source: &Source,
        material: &gltf::Material,
        at: &str,
        warnings: &mut Warnings,
    ) -> Result<(Material, Coordinates), Fault> {
        let pbr = material.pbr_metallic_roughness();
        let emissive = material.emissive_texture();
        let mut coordinates = Coordinates {
            set: 0,
            baked: None,
        };
        let mut base_texture = None;
        if let Some(info) = pbr.base_color_texture() {
            let (texture, from) = self.texture_ref(source, &info, at, warnings)?;
            base_texture = Some(texture);
            coordinates = from;
        }
        let mut emissive_texture = None;
        if let Some(info) = emissive {
            let (texture, from) = self.texture_ref(source, &info, at, warnings)?;
            emissive_texture = Some(texture);
            if base_texture.is_none() {
                coordinates = from;
            } else if from != coordinates {
                warnings.add(
                    at,
                    "its emissive texture uses the base texture's coordinates",
                );
            }
        }
        let (mut metallic, mut roughness) = (pbr.metallic_factor(), pbr.roughness_factor());
        if let Some(info) = pbr.metallic_roughness_texture() {
            let [_, g, b] = mean(&source.image(info.texture().source().index())?.2);
            roughness *= g;
            metallic *= b;
            warnings.add(at, "its metallic-roughness texture is replaced by its mean");
        }
        for (texture, name) in [
            (material.normal_texture().is_some(), "normal"),
            (material.occlusion_texture().is_some(), "occlusion"),
        ] {
            if texture {
                warnings.add(at, format!("its {name} texture is not used"));
            }
        }
        let strength = material.emissive_strength().unwrap_or(1.0);
        let transmission = material.transmission();
        if transmission
            .as_ref()
            .is_some_and(|t| t.transmission_texture().is_some())
        {
            warnings.add(at, "its transmission texture is not used");
        }
        let mut converted = Material {
            name: material.name().unwrap_or(at).to_owned(),
            base_colour: Vec4::from(pbr.base_color_factor()),
            base_texture,
            procedural: None,
            emissive: Vec3::from(material.emissive_factor()) * strength,
            emissive_texture,
            metallic,
            roughness,
            transmission: transmission.map_or(0.0, |t| t.transmission_factor()),
            ior: material.ior().unwrap_or(1.5),
            double_sided: material.double_sided(),
            alpha_cutoff: None,
            unlit: material.unlit(),
        };
        check_ranges(&mut converted, at, warnings)?;
        match material.alpha_mode() {
            AlphaMode::Opaque => {}
            AlphaMode::Mask => {
                let cutoff = material.alpha_cutoff().unwrap_or(0.5);
                converted.alpha_cutoff = Some(if cutoff.is_nan() { 0.5 } else { cutoff });
            }
            AlphaMode::Blend => {
                blend(&mut converted, material.ior().is_some(), at, warnings);
            }
        }
        Ok((converted, coordinates))
    }

    fn texture_ref(
        &mut self,
        source: &Source,
        info: &Info,
        at: &str,
        warnings: &mut Warnings,
    ) -> Result<(TextureRef, Coordinates), Fault> {
        let texture = info.texture();
        let sampler = texture.sampler();
        for mode in [sampler.wrap_s(), sampler.wrap_t()] {
            if mode == WrappingMode::MirroredRepeat {
                warnings.add(
                    at,
                    "mirrored repetition of a texture is shown as plain repetition",
                );
            }
        }
        let repeat = |mode| mode != WrappingMode::ClampToEdge;
        let key = (
            texture.source().index(),
            repeat(sampler.wrap_s()),
            repeat(sampler.wrap_t()),
        );
        let index = match self.keys.iter().position(|k| *k == key) {
            Some(index) => index,
            None => {
                // The same image with another wrapping is copied, not decoded again.
                let (width, height, rgba) = match self.keys.iter().position(|k| k.0 == key.0) {
                    Some(i) => {
                        let t = &self.textures[i];
                        (t.width, t.height, t.rgba.clone())
                    }
                    None => source.image(key.0)?,
                };
                let image = texture.source();
                let name = image.name().or(texture.name());
                self.textures.push(Texture {
                    name: name.map_or_else(|| place("image", key.0, None), str::to_owned),
                    width,
                    height,
                    rgba,
                    repeat_u: key.1,
                    repeat_v: key.2,
                });
                self.keys.push(key);
                self.keys.len() - 1
            }
        };
        let mut reference = TextureRef {
            texture: index,
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
        };
        let mut coordinates = Coordinates {
            set: info.tex_coord(),
            baked: None,
        };
        if let Some(transform) = info.texture_transform() {
            let (scale, offset) = (
                Vec2::from(transform.scale()),
                Vec2::from(transform.offset()),
            );
            let rotation = transform.rotation();
            if !(scale.is_finite() && offset.is_finite() && rotation.is_finite()) {
                return Err(Fault::new(at, "its KHR_texture_transform is not finite"));
            }
            coordinates.set = transform.tex_coord().unwrap_or(coordinates.set);
            if rotation == 0.0 {
                (reference.scale, reference.offset) = (scale, offset);
            } else {
                // uv' = T R S uv, the rotation being clockwise as the extension's matrix has it.
                let matrix = Mat2::from_angle(-rotation) * Mat2::from_diagonal(scale);
                coordinates.baked = Some((matrix, offset));
            }
        }
        Ok((reference, coordinates))
    }
}

/// glTF's BLEND is coverage in screen space, which rays do not have. A uniform opacity becomes
/// transmission (glossy: glass; matt: a film that does not bend rays), any other a mask.
fn blend(material: &mut Material, has_ior: bool, at: &str, warnings: &mut Warnings) {
    if material.transmission > 0.0 {
        return;
    }
    let opacity = material.base_colour.w;
    if material.base_texture.is_none() && opacity < 1.0 {
        let glossy = material.roughness <= MIRROR_ROUGHNESS;
        material.transmission = 1.0 - opacity;
        material.metallic = 0.0;
        if !has_ior && !glossy {
            material.ior = 1.0;
        }
        warnings.add(
            at,
            "alpha blending is shown as transmission of the same strength",
        );
    } else if material.base_texture.is_some() {
        material.alpha_cutoff = Some(0.5);
        warnings.add(at, "alpha blending is shown as a mask with a cutoff of 0.5");
    }
}

/// Factors that are not numbers are faults; factors outside their range are clamped.
fn check_ranges(material: &mut Material, at: &str, warnings: &mut Warnings) -> Result<(), Fault> {
    let m = &material;
    let finite = m.base_colour.is_finite()
        && m.emissive.is_finite()
        && [m.metallic, m.roughness, m.transmission, m.ior]
            .iter()
            .all(|x| x.is_finite());
    if !finite {
        return Err(Fault::new(at, "has a factor that is not a finite number"));
    }
    let before = material.clone();
    material.base_colour = material.base_colour.clamp(Vec4::ZERO, Vec4::ONE);
    material.emissive = material.emissive.max(Vec3::ZERO);
    for factor in [
        &mut material.metallic,
        &mut material.roughness,
        &mut material.transmission,
    ] {
        *factor = factor.clamp(0.0, 1.0);
    }
    // KHR_materials_ior: 0 asks for Fresnel reflectance 1 everywhere; nothing else is below 1.
    material.ior = material.ior.max(1.0);
    if *material != before {
        warnings.add(at, "factors outside their range are clamped");
    }
    Ok(())
}

/// Mean of R, G, B as 0..1, without sRGB decoding (the texture holds linear data).
fn mean(rgba: &[[u8; 4]]) -> [f32; 3] {
    let mut sums = [0_u64; 3];
    for texel in rgba {
        for (sum, &value) in sums.iter_mut().zip(texel) {
            *sum += u64::from(value);
        }
    }
    sums.map(|sum| (sum as f64 / (255.0 * rgba.len().max(1) as f64)) as f32)
}
