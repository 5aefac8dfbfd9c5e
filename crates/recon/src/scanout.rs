//! Scan-out: the picture onto any embedded-graphics [`DrawTarget`].

use crate::arith::Arith;
use crate::display::Display;
use embedded_graphics_core::Pixel;
use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::geometry::{Point, Size};
use embedded_graphics_core::pixelcolor::Rgb888;
use embedded_graphics_core::primitives::Rectangle;

/// Draws the whole picture at the target's origin. Colours convert from [`Rgb888`], so panels of
/// 16 or 18 bits work too.
///
/// # Errors
/// Those of the target.
pub fn draw<A: Arith, D>(display: &Display<'_, A>, target: &mut D) -> Result<(), D::Error>
where
    D: DrawTarget,
    D::Color: From<Rgb888>,
{
    let (width, height) = display.size();
    let area = Rectangle::new(Point::zero(), Size::new(width.into(), height.into()));
    let colours = display
        .picture()
        .iter()
        .map(|[r, g, b]| Rgb888::new(*r, *g, *b).into());
    target.fill_contiguous(&area, colours)
}

/// Draws only what differs from `shown`, the picture that the target shows, and brings `shown` up
/// to date. Returns the number of pixels drawn.
///
/// # Errors
/// Those of the target; `shown` is then true up to the pixel that failed.
pub fn draw_changes<A: Arith, D>(
    display: &Display<'_, A>,
    shown: &mut [[u8; 3]],
    target: &mut D,
) -> Result<usize, D::Error>
where
    D: DrawTarget,
    D::Color: From<Rgb888>,
{
    let width = usize::from(display.size().0);
    let mut drawn = 0;
    for (i, (new, old)) in display.picture().iter().zip(shown).enumerate() {
        if new != old {
            let at = Point::new((i % width) as i32, (i / width) as i32);
            let colour = Rgb888::new(new[0], new[1], new[2]);
            target.draw_iter(core::iter::once(Pixel(at, colour.into())))?;
            *old = *new;
            drawn += 1;
        }
    }
    Ok(drawn)
}
