//! Scan-out: the picture onto any embedded-graphics [`DrawTarget`].

use crate::arith::Arith;
use crate::display::Display;
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

/// Side of the blocks that changes are looked for in, pixels.
pub const BLOCK: usize = 8;

/// What was sent to a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Rectangles.
    pub windows: usize,
    /// Pixels in them.
    pub pixels: usize,
}

/// Draws only the windows that differ from `shown`, the picture that the target shows, and brings
/// `shown` up to date: runs of changed blocks of [`BLOCK`] × [`BLOCK`] pixels, because a window
/// costs a display bus some ten bytes.
///
/// # Errors
/// Those of the target; `shown` is then true but for the window that failed.
pub fn draw_changes<A: Arith, D>(
    display: &Display<'_, A>,
    shown: &mut [[u8; 3]],
    target: &mut D,
) -> Result<Drawn, D::Error>
where
    D: DrawTarget,
    D::Color: From<Rgb888>,
{
    let picture = display.picture();
    let (width, height) = display.size();
    let (width, height) = (usize::from(width), usize::from(height));
    let mut drawn = Drawn::default();
    for top in (0..height).step_by(BLOCK) {
        let rows = top..(top + BLOCK).min(height);
        let changed = |shown: &[[u8; 3]], left: usize| {
            rows.clone().any(|row| {
                let line = row * width;
                let span = line + left..line + (left + BLOCK).min(width);
                picture.get(span.clone()) != shown.get(span)
            })
        };
        let mut left = 0;
        while left < width {
            let mut right = left;
            while right < width && changed(shown, right) {
                right += BLOCK;
            }
            if right == left {
                left += BLOCK;
                continue;
            }
            let end = right.min(width);
            let spans = rows
                .clone()
                .map(|row| row * width + left..row * width + end);
            let pixels = spans.clone().filter_map(|span| picture.get(span)).flatten();
            let colours = pixels.map(|[r, g, b]| Rgb888::new(*r, *g, *b).into());
            let size = Size::new((end - left) as u32, rows.len() as u32);
            let area = Rectangle::new(Point::new(left as i32, top as i32), size);
            target.fill_contiguous(&area, colours)?;
            for span in spans {
                if let (Some(old), Some(new)) = (shown.get_mut(span.clone()), picture.get(span)) {
                    old.copy_from_slice(new);
                }
            }
            drawn.windows += 1;
            drawn.pixels += (end - left) * rows.len();
            left = right;
        }
    }
    Ok(drawn)
}
