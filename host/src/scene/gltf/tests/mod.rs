//! The loader and the exporter, on files made here and on the real ones in `shared/assets`.

mod assets;
mod faults;
mod loading;
mod motion;
mod round_trip;

use super::{LoadError, Loaded, load_bytes};
use serde_json::{Value, json};
use std::path::Path;

/// Packs a document and its binary chunk; declares buffer 0 to match.
fn glb(mut root: Value, data: &[u8]) -> Vec<u8> {
    if !data.is_empty() {
        root["buffers"] = json!([{ "byteLength": data.len() }]);
    }
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = data.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + text.len() as u32 + 8 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", data)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn load_json(root: Value, data: &[u8]) -> Result<Loaded, LoadError> {
    load_bytes(&glb(root, data), Path::new("made.glb"), None)
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A square of four vertices in the plane z = 0 with side 2 around the origin, two triangles of
/// u16 indices; accessor 0 its positions, 1 its indices. `more` follows in the buffer, from
/// byte 60 on, as buffer view 2.
fn square(more: &[u8]) -> (Value, Vec<u8>) {
    let mut data = floats(&[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.]);
    data.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    data.extend(more);
    let root = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "plate", "mesh": 0 }],
        "meshes": [{ "name": "square", "primitives": [{
            "attributes": { "POSITION": 0 }, "indices": 1,
        }] }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
            { "buffer": 0, "byteOffset": 60, "byteLength": more.len().max(1) },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4,
              "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 6 },
        ],
    });
    if more.is_empty() {
        data.push(0);
    }
    (root, data)
}

/// Appends an accessor; its index.
fn accessor(root: &mut Value, value: Value) -> usize {
    let list = root["accessors"]
        .as_array_mut()
        .expect("the square has accessors");
    list.push(value);
    list.len() - 1
}
