//! From a path to a validated document with its buffers and images in memory.
//!
//! The `gltf` crate parses the container and the JSON and validates indices and enumerations
//! (its `Validate`); what it leaves open and would later panic on is checked here.

use super::error::{Fault, LoadError, place};
use gltf::{buffer, json};
use std::path::{Path, PathBuf};

/// Largest image side that is accepted, pixels: a bound on what a small file can make us allocate.
const MAX_IMAGE_SIDE: u32 = 16_384;

/// A parsed file.
pub(super) struct Source {
    /// Validated by the `gltf` crate.
    pub(super) document: gltf::Document,
    /// Contents of each buffer, at least as long as declared.
    pub(super) buffers: Vec<Vec<u8>>,
    /// Folder that relative URIs start from.
    base: PathBuf,
}

impl Source {
    /// Reads and validates a `.glb` or `.gltf` file and its buffers.
    pub(super) fn open(file: &Path) -> Result<Self, LoadError> {
        let bytes = std::fs::read(file).map_err(|source| LoadError::Read {
            file: file.to_owned(),
            source,
        })?;
        let base = file.parent().map(Path::to_owned).unwrap_or_default();
        Self::from_bytes(&bytes, file, base)
    }

    /// The same from memory; `file` is for messages.
    pub(super) fn from_bytes(bytes: &[u8], file: &Path, base: PathBuf) -> Result<Self, LoadError> {
        let container = |reason: String| LoadError::Container {
            file: file.to_owned(),
            reason,
        };
        let content = |fault: Fault| LoadError::Content {
            file: file.to_owned(),
            fault,
        };
        if bytes.starts_with(b"glTF") {
            check_glb_length(bytes).map_err(container)?;
        } else if bytes.is_empty() {
            return Err(container("it is empty".into()));
        }
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes)
            .map_err(|error| container(error.to_string()))?;
        refuse_extensions(document.as_json(), file)?;
        let document = gltf::Document::from_json(document.into_json()).map_err(|error| {
            let gltf::Error::Validation(faults) = error else {
                return container(error.to_string());
            };
            let (path, first) = match faults.first() {
                Some((path, error)) => (path.as_str().to_owned(), error.to_string()),
                None => (String::from("the document"), String::from("invalid")),
            };
            let more = match faults.len() {
                0 | 1 => String::new(),
                n => format!(" (and {} more faults)", n - 1),
            };
            content(Fault::new(path, format!("{}{more}", first.to_lowercase())))
        })?;
        let buffers = load_buffers(&document, blob, &base).map_err(content)?;
        Ok(Self {
            document,
            buffers,
            base,
        })
    }

    /// The bytes of a view.
    pub(super) fn view(&self, view: &buffer::View, place: &str) -> Result<&[u8], Fault> {
        let data = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| data.get(view.offset()..end))
            .ok_or_else(|| {
                Fault::new(
                    place,
                    format!(
                        "buffer view {} covers bytes {}+{} of buffer {}, which has {}",
                        view.index(),
                        view.offset(),
                        view.length(),
                        view.buffer().index(),
                        data.len()
                    ),
                )
            })
    }

    /// Decodes an image (PNG or JPEG, told by its first bytes) to 8-bit RGBA.
    pub(super) fn image(&self, index: usize) -> Result<(u32, u32, Vec<[u8; 4]>), Fault> {
        let Some(image) = self.document.as_json().images.get(index) else {
            return Err(Fault::new(place("image", index, None), "does not exist"));
        };
        let at = place("image", index, image.name.as_deref());
        let owned;
        let bytes = if let Some(view) = image.buffer_view {
            // Validated: the index of the view is in range.
            match self.document.views().nth(view.value()) {
                Some(view) => self.view(&view, &at)?,
                None => return Err(Fault::new(at, "its buffer view does not exist")),
            }
        } else if let Some(uri) = &image.uri {
            owned = read_uri(uri, &self.base, &at)?;
            &owned
        } else {
            return Err(Fault::new(at, "has neither a bufferView nor a uri"));
        };
        let undecodable = |error: String| {
            Fault::new(
                &at,
                format!("cannot be decoded ({error}); glTF allows PNG and JPEG"),
            )
        };
        let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|error| undecodable(error.to_string()))?;
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_IMAGE_SIDE);
        limits.max_image_height = Some(MAX_IMAGE_SIDE);
        reader.limits(limits);
        let pixels = reader
            .decode()
            .map_err(|error| undecodable(error.to_string()))?
            .into_rgba8();
        let (width, height) = pixels.dimensions();
        if width == 0 || height == 0 {
            return Err(undecodable(format!("{width}×{height} pixels")));
        }
        Ok((width, height, pixels.pixels().map(|p| p.0).collect()))
    }
}

/// The length in the header of a GLB; the `gltf` crate subtracts from it unchecked.
fn check_glb_length(bytes: &[u8]) -> Result<(), String> {
    let Some(&[a, b, c, d]) = bytes.get(8..12) else {
        return Err(format!(
            "{} bytes are too few for a GLB header",
            bytes.len()
        ));
    };
    let declared = u64::from(u32::from_le_bytes([a, b, c, d]));
    if declared < 20 || declared > bytes.len() as u64 {
        return Err(format!(
            "its header declares {declared} bytes and it has {}",
            bytes.len()
        ));
    }
    Ok(())
}

/// Refuses required extensions that neither the `gltf` crate nor we know.
fn refuse_extensions(root: &json::Root, file: &Path) -> Result<(), LoadError> {
    let known = json::extensions::ENABLED_EXTENSIONS;
    let names: Vec<String> = root
        .extensions_required
        .iter()
        .filter(|name| !known.contains(&name.as_str()))
        .cloned()
        .collect();
    if names.is_empty() {
        return Ok(());
    }
    Err(LoadError::Extensions {
        file: file.to_owned(),
        names,
    })
}

/// Loads all buffers: the binary chunk, data URIs and files.
fn load_buffers(
    document: &gltf::Document,
    mut blob: Option<Vec<u8>>,
    base: &Path,
) -> Result<Vec<Vec<u8>>, Fault> {
    let mut buffers = Vec::new();
    for (index, buffer) in document.as_json().buffers.iter().enumerate() {
        let at = place("buffer", index, buffer.name.as_deref());
        let data = match &buffer.uri {
            Some(uri) => read_uri(uri, base, &at)?,
            None => blob
                .take()
                .ok_or_else(|| Fault::new(&at, "has no uri and the file has no binary chunk"))?,
        };
        if (data.len() as u64) < buffer.byte_length.0 {
            let declared = buffer.byte_length.0;
            return Err(Fault::new(
                at,
                format!(
                    "declares {declared} bytes and has {}; it was cut short",
                    data.len()
                ),
            ));
        }
        buffers.push(data);
    }
    Ok(buffers)
}

/// Fetches a `data:` URI or a file named relative to the glTF file.
fn read_uri(uri: &str, base: &Path, at: &str) -> Result<Vec<u8>, Fault> {
    // The `gltf` crate decodes percent escapes and panics when the result is not UTF-8.
    if !uri.starts_with("data:") && !percent_decodes(uri) {
        return Err(Fault::new(
            at,
            format!("uri {uri:?} has escapes that are not UTF-8"),
        ));
    }
    let source = buffer::Source::Uri(uri);
    match buffer::Data::from_source(source, Some(base)) {
        Ok(data) => Ok(data.0),
        Err(_) if uri.starts_with("data:") => {
            Err(Fault::new(at, "its data: uri is not valid base64"))
        }
        Err(gltf::Error::UnsupportedScheme) => Err(Fault::new(
            at,
            format!("uri {uri:?} is neither relative nor data:; put the file beside this one"),
        )),
        Err(error) => Err(Fault::new(
            at,
            format!(
                "{uri:?} in {:?} cannot be read: {error}; put the file there",
                if base.as_os_str().is_empty() {
                    Path::new(".")
                } else {
                    base
                }
            ),
        )),
    }
}

/// Whether the percent escapes of a URI decode to UTF-8.
fn percent_decodes(uri: &str) -> bool {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let digits = uri
            .get(i + 1..i + 3)
            .and_then(|d| u8::from_str_radix(d, 16).ok());
        match digits.filter(|_| bytes[i] == b'%') {
            Some(value) => {
                decoded.push(value);
                i += 3;
            }
            None => {
                decoded.push(bytes[i]);
                i += 1;
            }
        }
    }
    std::str::from_utf8(&decoded).is_ok()
}
