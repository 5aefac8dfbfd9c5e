//! Materials, textures, images.

use super::{ExportError, Writer, bake};
use crate::scene::{Material, Scene, TextureRef};
use glam::Vec2;
use serde_json::{Value, json};

impl Writer {
    pub(super) fn material(
        &mut self,
        scene: &Scene,
        material: &Material,
    ) -> Result<(), ExportError> {
        let mut pbr = json!({
            "baseColorFactor": material.base_colour.to_array(),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        });
        match (&material.base_texture, &material.procedural) {
            (Some(_), Some(_)) => return Err(ExportError::TwoTextures(material.name.clone())),
            (Some(texture), None) => {
                pbr["baseColorTexture"] = self.texture_ref(scene, texture)?;
            }
            (None, Some(pattern)) => {
                let baked = bake::bake(pattern, material.base_colour.truncate());
                let texture = self.image(&material.name, baked.size, &baked.rgba, true, true)?;
                pbr["baseColorTexture"] = self.transformed(texture, baked.scale, Vec2::ZERO);
                pbr["baseColorFactor"] = json!([1.0, 1.0, 1.0, material.base_colour.w]);
            }
            (None, None) => {}
        }
        let mut extensions = serde_json::Map::new();
        let strength = material.emissive.max_element().max(1.0);
        if strength > 1.0 {
            let value = json!({ "emissiveStrength": strength });
            extensions.insert("KHR_materials_emissive_strength".into(), value);
            self.extensions.push("KHR_materials_emissive_strength");
        }
        if material.transmission > 0.0 {
            let value = json!({ "transmissionFactor": material.transmission });
            extensions.insert("KHR_materials_transmission".into(), value);
            self.extensions.push("KHR_materials_transmission");
        }
        if material.ior != 1.5 {
            extensions.insert("KHR_materials_ior".into(), json!({ "ior": material.ior }));
            self.extensions.push("KHR_materials_ior");
        }
        if material.unlit {
            extensions.insert("KHR_materials_unlit".into(), json!({}));
            self.extensions.push("KHR_materials_unlit");
        }
        let mut written = json!({
            "name": material.name,
            "pbrMetallicRoughness": pbr,
            "emissiveFactor": (material.emissive / strength).to_array(),
            "doubleSided": material.double_sided,
        });
        if let Some(texture) = &material.emissive_texture {
            written["emissiveTexture"] = self.texture_ref(scene, texture)?;
        }
        if let Some(cutoff) = material.alpha_cutoff {
            written["alphaMode"] = json!("MASK");
            written["alphaCutoff"] = json!(cutoff);
        }
        if !extensions.is_empty() {
            written["extensions"] = Value::Object(extensions);
        }
        self.materials.push(written);
        Ok(())
    }

    fn texture_ref(&mut self, scene: &Scene, used: &TextureRef) -> Result<Value, ExportError> {
        let index = match self.written.iter().find(|(ours, _)| *ours == used.texture) {
            Some(&(_, index)) => index,
            None => {
                let t = &scene.textures[used.texture];
                let size = (t.width, t.height);
                let index = self.image(&t.name, size, &t.rgba, t.repeat_u, t.repeat_v)?;
                self.written.push((used.texture, index));
                index
            }
        };
        Ok(self.transformed(index, used.scale, used.offset))
    }

    fn transformed(&mut self, index: usize, scale: Vec2, offset: Vec2) -> Value {
        if scale == Vec2::ONE && offset == Vec2::ZERO {
            return json!({ "index": index });
        }
        self.extensions.push("KHR_texture_transform");
        let transform = json!({ "scale": scale.to_array(), "offset": offset.to_array() });
        json!({ "index": index, "extensions": { "KHR_texture_transform": transform } })
    }

    /// Adds an image with its sampler and texture; the index of the texture.
    fn image(
        &mut self,
        name: &str,
        size: (u32, u32),
        rgba: &[[u8; 4]],
        repeat_u: bool,
        repeat_v: bool,
    ) -> Result<usize, ExportError> {
        let png = bake::png(size, rgba).map_err(|reason| ExportError::Texture {
            name: name.to_owned(),
            reason,
        })?;
        let view = self.buffer.bytes(&png, None);
        let wrap = |repeat| if repeat { 10_497 } else { 33_071 };
        // LINEAR, LINEAR_MIPMAP_LINEAR.
        let sampler = json!({
            "magFilter": 9729, "minFilter": 9987, "wrapS": wrap(repeat_u), "wrapT": wrap(repeat_v),
        });
        let index = self.textures.len();
        self.images
            .push(json!({ "name": name, "bufferView": view, "mimeType": "image/png" }));
        self.samplers.push(sampler);
        self.textures
            .push(json!({ "source": index, "sampler": index }));
        Ok(index)
    }
}
