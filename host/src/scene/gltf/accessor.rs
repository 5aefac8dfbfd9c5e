//! Typed reading of accessors (glTF 2.0 §3.6.2): strides, sparse substitution, normalised
//! integers. Nothing here panics, whatever the offsets and counts say; faults name the place.

use super::error::Fault;
use super::source::Source;
use gltf::Accessor;
use gltf::accessor::{DataType, sparse::IndexType};

/// Most elements that a sparse accessor without a base may declare: nothing else bounds what a
/// few bytes of JSON can make us allocate.
const MAX_SPARSE_COUNT: usize = 1 << 24;

impl Source {
    /// Reads vectors of `N` floats; integers are converted, to 0..1 or −1..1 when normalised.
    ///
    /// # Errors
    /// The element type is another one, the data are out of range or a value is not finite.
    pub(super) fn floats<const N: usize>(
        &self,
        accessor: &Accessor,
        place: &str,
    ) -> Result<Vec<[f32; N]>, Fault> {
        self.expect_components(accessor, N, place)?;
        let kind = accessor.data_type();
        let size = component_size(kind);
        let largest = match kind {
            DataType::I8 => 127.0,
            DataType::U8 => 255.0,
            DataType::I16 => 32_767.0,
            DataType::U16 => 65_535.0,
            DataType::U32 => u32::MAX as f32,
            DataType::F32 => 1.0,
        };
        let normalised = accessor.normalized() && kind != DataType::F32;
        // The lowest signed integer is below −1 (§3.6.2.2).
        let normalise = |x: f32| {
            if normalised {
                (x / largest).max(-1.0)
            } else {
                x
            }
        };
        let component = |b: &[u8]| match kind {
            DataType::I8 => f32::from(b[0] as i8),
            DataType::U8 => f32::from(b[0]),
            DataType::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])),
            DataType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])),
            DataType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        let values = self.elements(accessor, size * N, place, [0.0; N], |bytes| {
            std::array::from_fn(|i| normalise(component(&bytes[i * size..])))
        })?;
        match values
            .iter()
            .position(|v: &[f32; N]| v.iter().any(|x| !x.is_finite()))
        {
            Some(i) => Err(Fault::new(
                place,
                format!("element {i} is not a finite number"),
            )),
            None => Ok(values),
        }
    }

    /// Reads vectors of `N` unsigned integers.
    ///
    /// # Errors
    /// The element type is another one or the data are out of range.
    pub(super) fn integers<const N: usize>(
        &self,
        accessor: &Accessor,
        place: &str,
    ) -> Result<Vec<[u32; N]>, Fault> {
        self.expect_components(accessor, N, place)?;
        let kind = accessor.data_type();
        if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(Fault::new(
                place,
                format!("unsigned integers expected, {kind:?} found"),
            ));
        }
        let size = component_size(kind);
        self.elements(accessor, size * N, place, [0; N], |bytes| {
            std::array::from_fn(|i| {
                let b = &bytes[i * size..];
                match size {
                    1 => u32::from(b[0]),
                    2 => u32::from(u16::from_le_bytes([b[0], b[1]])),
                    _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
                }
            })
        })
    }

    fn expect_components(&self, accessor: &Accessor, n: usize, place: &str) -> Result<(), Fault> {
        let found = accessor.dimensions();
        if found.multiplicity() == n {
            return Ok(());
        }
        Err(Fault::new(
            place,
            format!(
                "accessor {} is {found:?}, {n} components expected",
                accessor.index()
            ),
        ))
    }

    /// Elements of `size` bytes; `decode` gets exactly that many.
    fn elements<T: Copy>(
        &self,
        accessor: &Accessor,
        size: usize,
        place: &str,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Fault> {
        let place = format!("{place}, accessor {}", accessor.index());
        let count = accessor.count();
        let mut values = match accessor.view() {
            Some(view) => self
                .rows(&view, accessor.offset(), count, size, &place)?
                .map(&decode)
                .collect(),
            None if count > MAX_SPARSE_COUNT => {
                return Err(Fault::new(
                    place,
                    format!("declares {count} elements without data; at most {MAX_SPARSE_COUNT}"),
                ));
            }
            None => vec![zero; count],
        };
        let Some(sparse) = accessor.sparse() else {
            return Ok(values);
        };
        let (indices, substitutes) = (sparse.indices(), sparse.values());
        let width = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let at = self.rows(
            &indices.view(),
            indices.offset(),
            sparse.count(),
            width,
            &place,
        )?;
        let from = self.rows(
            &substitutes.view(),
            substitutes.offset(),
            sparse.count(),
            size,
            &place,
        )?;
        for (index, bytes) in at.zip(from) {
            let index = index
                .iter()
                .rev()
                .fold(0, |sum, &b| sum << 8 | usize::from(b));
            let Some(slot) = values.get_mut(index) else {
                let reason = format!("sparse index {index} of {count} elements");
                return Err(Fault::new(place, reason));
            };
            *slot = decode(bytes);
        }
        Ok(values)
    }

    /// `count` slices of `size` bytes at the stride of a view.
    fn rows<'a>(
        &'a self,
        view: &gltf::buffer::View,
        offset: usize,
        count: usize,
        size: usize,
        place: &str,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, Fault> {
        let data = self.view(view, place)?;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            let reason = format!("a stride of {stride} bytes for elements of {size}");
            return Err(Fault::new(place, reason));
        }
        let length = match count.checked_sub(1) {
            Some(steps) => steps.checked_mul(stride).and_then(|n| n.checked_add(size)),
            None => Some(0),
        };
        let rows = length
            .and_then(|length| offset.checked_add(length))
            .and_then(|end| data.get(offset..end))
            .ok_or_else(|| {
                Fault::new(
                    place,
                    format!(
                        "{count} elements of {size} bytes at offset {offset}, stride {stride}, \
                         exceed buffer view {} of {} bytes",
                        view.index(),
                        data.len()
                    ),
                )
            })?;
        Ok(rows.chunks(stride).map(move |row| &row[..size]))
    }
}

fn component_size(kind: DataType) -> usize {
    match kind {
        DataType::I8 | DataType::U8 => 1,
        DataType::I16 | DataType::U16 => 2,
        DataType::U32 | DataType::F32 => 4,
    }
}
