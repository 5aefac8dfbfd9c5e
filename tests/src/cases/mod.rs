//! The hard cases: named streams, each with what must come of it.
//!
//! | module | where it is hard |
//! |---|---|
//! | `space` | places, views, gradients, tiles |
//! | `time` | clocks, order, rates |
//! | `rest` | when nothing moves |
//! | `amount` | none, one, millions; panels; damage |

mod amount;
mod rest;
mod space;
mod time;

use std::fmt;

use crate::backends::{Outcome, Show};
use crate::stream::Rng;
use unframed_wire::WorldSample;

/// What must come of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expected {
    /// Every picture stays black.
    Black,
    /// The last picture is this colour everywhere, up to so many levels of 255.
    Colour([u8; 3], u8),
    /// No pixel of the last picture leaves this range, and not all are black: a mean does not
    /// invent colours.
    Between([u8; 3], [u8; 3]),
    /// The pictures are those of another stream, and not all black.
    SameAs(&'static str, Vec<u8>),
    /// The last picture is the one before it, and not black.
    Kept,
    /// Something is shown at the last refresh.
    Lit,
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Black => f.write_str("black"),
            Self::Colour(rgb, 0) => write!(f, "{rgb:?} everywhere"),
            Self::Colour(rgb, by) => write!(f, "{rgb:?} ± {by} everywhere"),
            Self::Between(low, high) => write!(f, "within {low:?} to {high:?}"),
            Self::SameAs(other, _) => write!(f, "the pictures of {other}"),
            Self::Kept => f.write_str("the picture before stays"),
            Self::Lit => f.write_str("a picture"),
        }
    }
}

/// Where a case can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// Everywhere.
    Boards,
    /// Not on the boards: it needs more memory than they have.
    Desktop,
}

/// A hard case.
#[derive(Clone, Debug)]
pub struct Case {
    /// What is hard about it.
    pub name: &'static str,
    /// The stream.
    pub bytes: Vec<u8>,
    /// What must come of it.
    pub expected: Expected,
    /// The panel, pixels.
    pub size: (u16, u16),
    /// A name of [`unframed_recon::config::NAMED`].
    pub method: &'static str,
    /// Samples remembered.
    pub samples: usize,
    /// Where it can be shown.
    pub room: Room,
}

impl Case {
    fn new(name: &'static str, size: (u16, u16), bytes: Vec<u8>, expected: Expected) -> Self {
        Self {
            name,
            bytes,
            expected,
            size,
            method: "adaptive",
            samples: 4096,
            room: Room::Boards,
        }
    }

    fn method(mut self, method: &'static str) -> Self {
        self.method = method;
        self
    }

    fn samples(mut self, samples: usize) -> Self {
        self.samples = samples;
        self
    }

    fn room(mut self, room: Room) -> Self {
        self.room = room;
        self
    }

    /// How to show it.
    #[must_use]
    pub fn show(&self) -> Show<'_> {
        Show {
            bytes: &self.bytes,
            size: self.size,
            method: self.method,
            samples: self.samples,
        }
    }

    /// Instructions that a refresh of this case may take on any board, receiving included: a
    /// proportion of samples and pixels, so no stream can make the display late without end.
    #[must_use]
    pub fn bound(&self, arrived: u64) -> u64 {
        let pixels = u64::from(self.size.0) * u64::from(self.size.1);
        200_000 + 6_000 * (pixels + self.samples as u64) + 3_000 * arrived
    }

    /// Whether the pictures are what they must be.
    ///
    /// # Errors
    /// Says what is wrong.
    pub fn judge(&self, outcome: &Outcome) -> Result<(), String> {
        let pictures = &outcome.pictures;
        let last = pictures.last().ok_or("no refresh")?;
        let lit = |picture: &[[u8; 3]]| picture.iter().any(|p| *p != [0; 3]);
        let demand = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
        let outside = |low: &dyn Fn(usize) -> u8, high: &dyn Fn(usize) -> u8| {
            let wrong = last
                .iter()
                .position(|p| (0..3).any(|c| p[c] < low(c) || p[c] > high(c)));
            wrong.map_or(Ok(()), |at| Err(format!("pixel {at} is {:?}", last[at])))
        };
        match &self.expected {
            Expected::Black => demand(!pictures.iter().any(|p| lit(p)), "not black"),
            Expected::Colour(rgb, by) => outside(&|c| rgb[c].saturating_sub(*by), &|c| {
                rgb[c].saturating_add(*by)
            }),
            Expected::Between(low, high) => {
                outside(&|c| low[c], &|c| high[c])?;
                demand(lit(last), "black")
            }
            Expected::SameAs(_, other) => {
                let show = Show {
                    bytes: other,
                    ..self.show()
                };
                demand(show.fixed().pictures == *pictures, "other pictures")?;
                demand(lit(last), "black")
            }
            Expected::Kept => {
                let before = pictures.len().checked_sub(2).map(|k| &pictures[k]);
                demand(before == Some(last), "the picture changed")?;
                demand(lit(last), "black")
            }
            Expected::Lit => demand(lit(last), "black"),
        }
    }
}

/// All cases.
#[must_use]
pub fn all() -> Vec<Case> {
    [
        space::cases(),
        time::cases(),
        rest::cases(),
        amount::cases(),
    ]
    .concat()
}

/// Samples on the plane of [`crate::stream::flat`], spread over the panel, a checker of two colours.
fn checker(rng: &mut Rng, (width, height): (u16, u16), count: usize) -> Vec<WorldSample> {
    let half = [width, height].map(|v| i64::from(v) * i64::from(crate::stream::PIXEL) / 2);
    (0..count)
        .map(|_| {
            let [x, y] = half.map(|half| rng.range(-half, half.max(1)));
            let bright = (x.div_euclid(48) + y.div_euclid(48)) % 2 == 0;
            crate::stream::sample([x as i16, y as i16, 0], if bright { BRIGHT } else { DARK })
        })
        .collect()
}

/// The colours of [`checker`].
const BRIGHT: [u8; 3] = [240, 200, 90];
const DARK: [u8; 3] = [20, 40, 60];
/// What lies between them.
const BETWEEN: Expected = Expected::Between(DARK, BRIGHT);
