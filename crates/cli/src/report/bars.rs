//! Bar charts, as SVG: horizontal, so that names can be read, in one part or several.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::ReportError;
use super::axis::{Axis, Scale, number};
use super::plot::{
    Canvas, Drawn, GRID, INK, QUIET, WIDTH, canvas, colour, draw_legend, font, px, standalone,
    stroke, text, widest,
};

/// A chart of horizontal bars, from 0, in the order given.
#[derive(Clone, Debug)]
pub struct BarChart {
    title: String,
    label: String,
    parts: Vec<String>,
    bars: Vec<(String, Vec<f64>)>,
}

/// Height of a bar and its gap, pixels.
const PITCH: i32 = 26;
/// Above the first bar, pixels.
const TOP: i32 = 48;

impl BarChart {
    /// Bars of one part; `label` says what their length is ("RMSE, of 255").
    pub fn new(title: impl Into<String>, label: impl Into<String>) -> Self {
        Self::stacked(title, label, Vec::new())
    }

    /// Bars made of parts end to end, named in order.
    pub fn stacked(title: impl Into<String>, label: impl Into<String>, parts: Vec<String>) -> Self {
        Self {
            title: title.into(),
            label: label.into(),
            parts,
            bars: Vec::new(),
        }
    }

    /// Adds a bar of one part. What is negative or not finite has no length, and a dash for value.
    #[must_use]
    pub fn bar(self, name: impl Into<String>, value: f64) -> Self {
        self.parts_bar(name, vec![value])
    }

    /// Adds a bar of the parts' values, in the order of their names.
    #[must_use]
    pub fn parts_bar(mut self, name: impl Into<String>, values: Vec<f64>) -> Self {
        self.bars.push((name.into(), values));
        self
    }

    /// The chart as an SVG file: dark on white.
    ///
    /// # Errors
    ///
    /// [`ReportError::Plot`] if plotters fails.
    pub fn svg(&self) -> Result<String, ReportError> {
        Ok(standalone(&self.inline_svg()?))
    }

    /// The chart as an SVG element for a page, in the page's text colour.
    ///
    /// # Errors
    ///
    /// [`ReportError::Plot`] if plotters fails.
    pub fn inline_svg(&self) -> Result<String, ReportError> {
        let rows = self.bars.len().max(self.parts.len()).max(1) as i32;
        let height = TOP + PITCH * rows + 34;
        canvas(&self.title, height, |root| self.draw(root))
    }

    fn draw(&self, root: &Canvas<'_>) -> Drawn {
        root.draw(&text(&self.title, (0, 0), 15.0, INK, true))?;
        root.draw(&text(&self.label, (0, 21), 12.0, QUIET, false))?;
        if self.bars.is_empty() {
            root.draw(&text("no data", (0, TOP), 14.0, QUIET, false))?;
            return Ok(());
        }
        let room = |width: f64| width.min(0.45 * f64::from(WIDTH)) as i32;
        let left = room(20.0 + widest(self.bars.iter().map(|b| b.0.as_str())));
        let legend = match self.parts.len() {
            0 => 0,
            _ => room(30.0 + widest(self.parts.iter().map(String::as_str))),
        };
        // The value is written to the right of its bar.
        let right = WIDTH - legend - 56;
        let totals = self
            .bars
            .iter()
            .map(|b| b.1.iter().filter_map(|v| length(*v)).sum());
        let span = Axis::new("", Scale::FromZero).span(totals);
        let place = |v: f64| {
            let units = f64::from(px(left)) + span.place(v) * f64::from(px(right - left));
            units.round() as i32
        };
        let bottom = TOP + PITCH * self.bars.len() as i32;
        for tick in span.ticks(6) {
            let (x, end) = (place(tick), px(bottom));
            let line = vec![(x, px(TOP - 2)), (x, end + px(4))];
            root.draw(&PathElement::new(line, stroke(GRID, 1)))?;
            let style = font(12.0, QUIET).pos(Pos::new(HPos::Center, VPos::Top));
            root.draw(&Text::new(number(tick), (x, end + px(8)), style))?;
        }
        for (i, (name, values)) in self.bars.iter().enumerate() {
            let top = TOP + PITCH * i as i32 + 3;
            let middle = px(top + 10);
            let style = font(12.5, INK).pos(Pos::new(HPos::Right, VPos::Center));
            root.draw(&Text::new(name.clone(), (px(left - 8), middle), style))?;
            let mut sum = 0.0;
            for (part, value) in values.iter().enumerate() {
                let Some(length) = length(*value) else {
                    continue;
                };
                let (from, to) = (place(sum), place(sum + length));
                let corners = [(from, px(top)), (to, px(top + 20))];
                root.draw(&Rectangle::new(corners, colour(part).filled()))?;
                sum += length;
            }
            let shown = if values.iter().any(|v| length(*v).is_some()) {
                number(sum)
            } else {
                "–".to_owned()
            };
            let style = font(12.0, QUIET).pos(Pos::new(HPos::Left, VPos::Center));
            root.draw(&Text::new(shown, (place(sum) + px(6), middle), style))?;
        }
        let (_, legend_area) = root.split_horizontally(px(WIDTH - legend));
        draw_legend(&legend_area, self.parts.iter().map(String::as_str), TOP)
    }
}

/// What a value adds to a bar: nothing if it cannot be drawn as a length.
fn length(value: f64) -> Option<f64> {
    (0.0..=1e300).contains(&value).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Widths of the filled rectangles of a part's colour, in units.
    fn widths(svg: &str, fill: &str) -> Vec<i32> {
        let wanted = format!("fill=\"{fill}\"");
        let bars = svg
            .lines()
            .filter(|l| l.starts_with("<rect") && l.contains(&wanted));
        bars.map(|l| {
            l.split("width=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap()
        })
        .collect()
    }

    #[test]
    fn lengths_are_in_proportion_and_names_are_there() {
        let svg = BarChart::new("Methods", "RMSE")
            .bar("adaptive & co", 5.0)
            .bar("frameless", 20.0)
            .inline_svg()
            .unwrap();
        assert!(svg.contains("adaptive &amp; co") && svg.contains("frameless"));
        let widths = widths(&svg, "#0072B2");
        assert_eq!(widths.len(), 2);
        assert!((widths[1] - 4 * widths[0]).abs() <= 4, "{widths:?}");
    }

    #[test]
    fn parts_stand_end_to_end() {
        let parts = vec!["edge".to_owned(), "texture".to_owned()];
        let svg = BarChart::stacked("Error", "share", parts)
            .parts_bar("toycar", vec![0.25, 0.75])
            .parts_bar("walk", vec![f64::NAN, 0.5])
            .inline_svg()
            .unwrap();
        assert!(svg.contains("edge") && svg.contains("texture"));
        // The legend's swatch comes last.
        let (first, second) = (widths(&svg, "#0072B2"), widths(&svg, "#D55E00"));
        assert_eq!((first.len(), second.len()), (2, 3));
        assert!((second[0] - 3 * first[0]).abs() <= 4);
    }

    #[test]
    fn nothing_to_draw_is_said_and_nothing_panics() {
        let svg = BarChart::new("", "").inline_svg().unwrap();
        assert!(svg.contains("no data"));
        let svg = BarChart::new("", "")
            .bar("a", f64::NAN)
            .bar("b", -1.0)
            .bar("c", f64::INFINITY)
            .bar("d", 0.0)
            .parts_bar("e", vec![])
            .inline_svg()
            .unwrap();
        assert_eq!(svg.matches('–').count(), 4, "d alone has a value");
        assert!(!svg.contains("NaN"));
    }
}
