//! The binary chunk of a GLB: views and accessors (glTF 2.0 §3.6), and the container (§4).

use super::ExportError;
use serde_json::{Value, json};

/// Component types, by their number in the format.
#[derive(Clone, Copy)]
pub(super) enum Component {
    /// `UNSIGNED_SHORT`
    U16 = 5123,
    /// `UNSIGNED_INT`
    U32 = 5125,
    /// `FLOAT`
    F32 = 5126,
}

/// What vertex indices are for.
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;

/// Collects binary data, with the views and accessors that describe it.
#[derive(Default)]
pub(super) struct Buffer {
    data: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds a view of these bytes, aligned to 4; its index.
    pub(super) fn bytes(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.data.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor over a view of its own; its index as JSON.
    pub(super) fn accessor(
        &mut self,
        bytes: &[u8],
        component: Component,
        kind: &str,
        count: usize,
    ) -> Value {
        let view = self.bytes(bytes, None);
        self.push_accessor(view, component, kind, count)
    }

    fn push_accessor(
        &mut self,
        view: usize,
        component: Component,
        kind: &str,
        count: usize,
    ) -> Value {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component as u32, "type": kind, "count": count,
        }));
        json!(self.accessors.len() - 1)
    }

    /// Adds floats as elements of a kind (`VEC3`, …), with the extremes where the format wants
    /// them (positions and key times).
    pub(super) fn floats(&mut self, values: &[f32], kind: &str, extremes: bool) -> Value {
        let width = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let index = self.accessor(&bytes, Component::F32, kind, values.len() / width);
        if extremes {
            let of = |pick: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
                let component = |c: usize| values.iter().skip(c).step_by(width).copied();
                (0..width).map(|c| component(c).fold(start, pick)).collect()
            };
            if let Some(accessor) = self.accessors.last_mut() {
                accessor["min"] = json!(of(f32::min, f32::INFINITY));
                accessor["max"] = json!(of(f32::max, f32::NEG_INFINITY));
            }
        }
        index
    }

    /// Adds vertex indices, 16 bits wide where that is enough (65,535 is a restart mark).
    pub(super) fn indices(&mut self, indices: &[u32], vertices: usize) -> Value {
        let (component, bytes): (_, Vec<u8>) = if vertices < usize::from(u16::MAX) {
            (
                Component::U16,
                indices
                    .iter()
                    .flat_map(|&i| (i as u16).to_le_bytes())
                    .collect(),
            )
        } else {
            (
                Component::U32,
                indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
            )
        };
        let view = self.bytes(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.push_accessor(view, component, "SCALAR", indices.len())
    }

    /// Packs the document and the data into the container.
    pub(super) fn into_glb(mut self, mut root: Value) -> Result<Vec<u8>, ExportError> {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        if !self.data.is_empty() {
            root["buffers"] = json!([{ "byteLength": self.data.len() }]);
            root["bufferViews"] = Value::Array(self.views);
        }
        if !self.accessors.is_empty() {
            root["accessors"] = Value::Array(self.accessors);
        }
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunks = [(*b"JSON", text), (*b"BIN\0", self.data)];
        let chunks: Vec<_> = chunks
            .into_iter()
            .filter(|(_, data)| !data.is_empty())
            .collect();
        let total = 12 + chunks.iter().map(|(_, data)| 8 + data.len()).sum::<usize>();
        let length = u32::try_from(total).map_err(|_| ExportError::TooLarge(total))?;
        let mut glb = Vec::with_capacity(total);
        glb.extend_from_slice(b"glTF");
        glb.extend_from_slice(&2_u32.to_le_bytes());
        glb.extend_from_slice(&length.to_le_bytes());
        for (kind, data) in chunks {
            // Below `length`, which fits.
            glb.extend_from_slice(&(data.len() as u32).to_le_bytes());
            glb.extend_from_slice(&kind);
            glb.extend_from_slice(&data);
        }
        Ok(glb)
    }
}
