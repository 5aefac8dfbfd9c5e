//! What a refresh decided about each stored sample: so that arithmetics can be compared decision
//! by decision (feature `float`).

use crate::arith::{Arith, Projected};
use crate::display::Display;
use crate::hidden;
use crate::project::{Instant, locate};
use crate::splat::Widths;
use crate::workers::Workers;
use unframed_wire::Tick;

/// What was decided about one sample, and from what.
#[derive(Clone, Copy, Debug)]
pub struct Decision<A: Arith> {
    /// Where it was seen and what it weighed before it was looked at as hidden.
    pub seen: Projected<A>,
    /// What placed it; the default for a sample on the screen.
    pub transform: A::Transform,
    /// Index of the pixel it counted for: its own, or the nearest of the panel.
    pub pixel: usize,
    /// The depth beyond which samples of that pixel are hidden; where `near_mover`, for one at rest
    /// [`Arith::nearer`] than that.
    pub limit: A::Depth,
    /// Whether a sample of a moving object lies nearby.
    pub near_mover: bool,
    /// How deep an occluder may lie that could have hidden it since it was taken, away from and
    /// near moving objects.
    pub reach: [A::Depth; 2],
    /// Whether it was hidden.
    pub hidden: bool,
    /// Its filter widths in x and y; `None` where it counts for its pixel alone.
    pub widths: Option<[A::Log; 2]>,
}

impl<A: Arith, W: Workers> Display<'_, A, W> {
    /// What the last refresh, at `now`, decided about each stored sample, in the order of the deep
    /// buffer; `None` of a sample that was out of sight or weighed nothing.
    ///
    /// Meaningful until the next packet is received. Of a refresh at another time it says what
    /// would be seen then, with the limits and widths of the last.
    pub fn decisions(&self, now: Tick) -> impl Iterator<Item = Option<Decision<A>>> + '_ {
        let reach = self.reach();
        self.deep.samples().iter().map(move |sample| {
            let instant = Instant {
                config: self.config,
                panel: self.panel,
                tiles: &self.tiles,
                slots: self.slots,
                lifetimes: &[],
                lights: &self.lights,
                now,
            };
            let age = instant.age(sample.time)?;
            let place = locate(&self.panel, self.slots, sample)?;
            let pixel = A::nearest(&self.panel, place.0, place.1);
            let seen = instant.weigh(sample, &age, place, pixel);
            if !A::counts(seen.weight) {
                return None;
            }
            let pixel = pixel.index(self.panel.width);
            let tests = self.config.hidden;
            let slot = self.slots.get(usize::from(sample.slot));
            Some(Decision {
                seen,
                transform: slot.and_then(|slot| slot.transform).unwrap_or_default(),
                pixel,
                limit: self.limits.get(pixel).copied().unwrap_or_default(),
                near_mover: self.movers.get(pixel).is_some_and(|mover| *mover != 0),
                hidden: tests && hidden::hides(&reach, self.limits, self.movers, pixel, &seen),
                reach: [false, true].map(|near_mover| reach.of(seen.past, near_mover)),
                widths: Widths::new(self.config.extents, self.logs, &self.tiles)
                    .of(&self.panel, &seen),
            })
        })
    }
}
