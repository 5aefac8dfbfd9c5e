//! Lamps and shapes on their way out.

use std::collections::HashMap;

use unframed_wire::{EncodeError, Lamp, LampKind, Shape, Writer};

use super::Quantiser;
use crate::trace::World;
use crate::trace::light::Source;

/// Parts that displays take of a shape.
const PARTS: usize = 32;

/// A part of a shape as it is sent.
#[derive(Debug)]
struct Part {
    object: u8,
    index: u8,
    of: u16,
    vertices: Vec<[i16; 3]>,
    triangles: Vec<[u8; 3]>,
}

/// What tells a display where lamps are and what throws shadows.
#[derive(Debug, Default)]
pub(super) struct LightSender {
    parts: Vec<Part>,
    next: usize,
}

impl LightSender {
    /// Cuts the shapes of a world up.
    pub(super) fn new(world: &World, quantiser: &Quantiser) -> Self {
        let mut parts = Vec::new();
        for (object, triangles) in world.shapes() {
            let corners = triangles.iter().map(|corners| {
                let place = |corner| quantiser.place(object, glam::Vec3::from(corner));
                corners.map(place)
            });
            let mut own = cut(object, corners);
            own.truncate(PARTS);
            let of = own.len() as u16;
            own.iter_mut().for_each(|part| part.of = of);
            parts.extend(own);
        }
        Self { parts, next: 0 }
    }

    /// Sends all shapes.
    pub(super) fn all(
        &mut self,
        writer: &mut Writer,
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        for part in &self.parts {
            part.send(writer, sink)?;
        }
        Ok(())
    }

    /// Sends one more part again, for displays that came later.
    pub(super) fn again(
        &mut self,
        writer: &mut Writer,
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let Some(part) = self.parts.get(self.next) else {
            return Ok(());
        };
        self.next = (self.next + 1) % self.parts.len();
        part.send(writer, sink)
    }
}

impl Part {
    fn send(&self, writer: &mut Writer, sink: &mut impl FnMut(&[u8])) -> Result<(), EncodeError> {
        let (vertices, triangles) = (&self.vertices, &self.triangles);
        writer.shape(self.object, self.index, self.of, vertices, triangles, sink)
    }
}

/// Triangles in parts that fit into packets; corners that triangles of a part share are sent once. Triangles
/// that the lattice makes a line or a point are left out.
fn cut(object: u8, triangles: impl Iterator<Item = [[i16; 3]; 3]>) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut known: HashMap<[i16; 3], u8> = HashMap::new();
    for corners in triangles {
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            continue;
        }
        let new = corners.iter().filter(|v| !known.contains_key(*v)).count();
        let fits = parts
            .last()
            .is_some_and(|part| Shape::fits(part.vertices.len() + new, part.triangles.len() + 1));
        if !fits {
            known.clear();
            parts.push(Part {
                object,
                index: parts.len() as u8,
                of: 0,
                vertices: Vec::new(),
                triangles: Vec::new(),
            });
        }
        if let Some(part) = parts.last_mut() {
            let triangle = corners.map(|corner| {
                *known.entry(corner).or_insert_with(|| {
                    part.vertices.push(corner);
                    (part.vertices.len() - 1) as u8
                })
            });
            part.triangles.push(triangle);
        }
    }
    parts
}

/// The lamps of an instant, seconds, whose shadows the display draws.
pub(super) fn lamps(world: &World, quantiser: &Quantiser, time: f64) -> Vec<Lamp> {
    let lamps = (0..usize::from(world.lamps_left())).filter_map(|lamp| world.lamp_left(lamp, time));
    lamps
        .map(|(source, against)| {
            let (kind, place) = match source {
                Source::At(at) => (LampKind::Point, quantiser.point(at)),
                Source::Towards(way) => {
                    let part = |v: f32| (f64::from(v) * f64::from(Lamp::UNIT)).round() as i32;
                    (LampKind::Directional, way.to_array().map(part))
                }
            };
            let tint = |channel: f32| {
                let by = channel / against.y.max(1e-6);
                (by * 256.0).round().clamp(1.0, f32::from(u16::MAX)) as u16
            };
            Lamp {
                kind,
                place,
                tint: [tint(against.x), tint(against.z)],
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_every_triangle_and_fit_into_packets() {
        // A grid of 40 × 40 squares, whose triangles share corners.
        let at = |i: i16, k: i16| [i * 700, k * 600, (i * k) % 97];
        let squares = (0..40).flat_map(|i| (0..40).map(move |k| (i, k)));
        let triangles: Vec<[[i16; 3]; 3]> = squares
            .flat_map(|(i, k)| {
                let (a, b) = (at(i, k), at(i + 1, k));
                let (c, d) = (at(i + 1, k + 1), at(i, k + 1));
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let nothing = [[[5; 3], [5; 3], [6; 3]]];
        let parts = cut(7, triangles.iter().chain(&nothing).copied());
        let mut found = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            assert_eq!((part.object, usize::from(part.index)), (7, index));
            assert!(Shape::fits(part.vertices.len(), part.triangles.len()));
            let corners = part.triangles.iter();
            found.extend(corners.map(|t| t.map(|v| part.vertices[usize::from(v)])));
        }
        assert_eq!(found, triangles);
        assert!(
            parts.len() < 20,
            "corners are shared: {} parts",
            parts.len()
        );
    }
}
