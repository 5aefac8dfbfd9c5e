//! Number formats that a display could have, emulated: [`unframed_recon::rounded`].

use unframed_recon::Arith;
use unframed_recon::rounded::{Bits, Rounded};

/// Something to be done in the numbers of a format.
pub trait In {
    /// What comes of it.
    type Output;

    /// Does it in `A`.
    fn numbers<A: Arith>(self) -> Self::Output;
}

/// One thing narrower than deployed, all else as deployed.
macro_rules! formats {
    ($($sweep:literal: $($name:ident $label:literal $bits:ident = $value:expr),+;)+) => {
        /// A format: all as deployed but for one thing.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Narrow {
            $($(#[doc = concat!($sweep, ": ", $label)] $name,)+)+
        }

        /// All formats, by what is narrower.
        pub const FORMATS: &[(&str, &[Narrow])] = &[
            $(($sweep, &[$(Narrow::$name),+]),)+
        ];

        $($(
            #[derive(Clone, Copy, Debug, Default, PartialEq)]
            struct $name;

            impl Bits for $name {
                const $bits: formats!(@ $bits) = $value;
            }
        )+)+

        impl Narrow {
            /// How narrow it is.
            #[must_use]
            pub fn label(self) -> &'static str {
                match self {
                    $($(Self::$name => $label,)+)+
                }
            }

            /// Does something in its numbers.
            pub fn run<W: In>(self, work: W) -> W::Output {
                match self {
                    $($(Self::$name => work.numbers::<Rounded<$name>>(),)+)+
                }
            }
        }
    };
    (@ CUT) => { f64 };
    (@ $bits:ident) => { u32 };
}

formats! {
    "bits of screen places": Place4 "4 bits" PLACE = 4, Place2 "2 bits" PLACE = 2;
    "bits of weights": Weight8 "8 bits" WEIGHT = 8, Weight6 "6 bits" WEIGHT = 6;
    "bits of light": Light8 "8 bits" LIGHT = 8;
    "bits of depths": Depth4 "4 bits an octave" DEPTH = 4;
    "steps of filter widths": Width3 "1/8 octave" WIDTH = 3, Width0 "an octave" WIDTH = 0;
    "steps of ages": Age4 "1/16 octave" AGE = 4, Age0 "an octave" AGE = 0;
    "cut-off of the filter": Cut20 "2 σ" CUT = 2.0, Cut25 "2.5 σ" CUT = 2.5;
}
