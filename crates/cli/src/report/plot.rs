//! Plots of one quantity against another, as SVG: lines over time, points, fronts.
//!
//! `plotters` lays out the axes and the lines; the text is SVG text in the reader's own font, so
//! no font is needed here. Colours are Okabe and Ito's, which the colour-blind can tell apart, and
//! each series has its name in its own colour beside the plot.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::ReportError;
use super::axis::{Axis, Scale, number};
use super::html::escape;

/// A plot of series against two axes.
#[derive(Clone, Debug)]
pub struct Plot {
    title: String,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    marks: Vec<(f64, String)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Style {
    Line,
    Points,
    Front,
}

#[derive(Clone, Debug)]
struct Series {
    name: String,
    style: Style,
    points: Vec<(f64, f64)>,
}

impl Plot {
    /// An empty plot.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            series: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// A line through points in their order; one that is not finite leaves a gap.
    #[must_use]
    pub fn line(self, name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        self.with(name.into(), Style::Line, points)
    }

    /// Points alone.
    #[must_use]
    pub fn points(self, name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        self.with(name.into(), Style::Points, points)
    }

    /// A front: points and the staircase under which nothing was reached, for axes on both of
    /// which less is better. Points that another one beats on both axes are left out.
    #[must_use]
    pub fn front(self, name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        let front = front(points);
        self.with(name.into(), Style::Front, front)
    }

    /// A thin vertical line at `x` with a name above it: a cut, a limit.
    #[must_use]
    pub fn mark(mut self, x: f64, name: impl Into<String>) -> Self {
        self.marks.push((x, name.into()));
        self
    }

    fn with(mut self, name: String, style: Style, points: Vec<(f64, f64)>) -> Self {
        self.series.push(Series {
            name,
            style,
            points,
        });
        self
    }

    /// The plot as an SVG file: dark on white.
    ///
    /// # Errors
    ///
    /// [`ReportError::Plot`] if plotters fails.
    pub fn svg(&self) -> Result<String, ReportError> {
        Ok(standalone(&self.inline_svg()?))
    }

    /// The plot as an SVG element for a page, in the page's text colour.
    ///
    /// # Errors
    ///
    /// [`ReportError::Plot`] if plotters fails.
    pub fn inline_svg(&self) -> Result<String, ReportError> {
        let legend_width = match self.series.len() {
            0 => 0.0,
            _ => 30.0 + widest(self.series.iter().map(|s| s.name.as_str())),
        };
        let legend_width = legend_width.min(0.4 * f64::from(WIDTH));
        let height = HEIGHT.max(70 + 20 * self.series.len() as i32);
        canvas(&self.title, height, |root| {
            self.draw(root, height, legend_width as i32)
        })
    }

    fn draw(&self, root: &Canvas<'_>, height: i32, legend_width: i32) -> Drawn {
        root.draw(&text(&self.title, (0, 0), 15.0, INK, true))?;
        root.draw(&text(&self.y.label, (0, 21), 12.0, QUIET, false))?;
        let values = || self.series.iter().flat_map(|s| &s.points);
        let held = |p: &&(f64, f64)| self.x.holds(p.0) && self.y.holds(p.1);
        let xs = values().filter(held).map(|p| p.0);
        let x = self.x.span(xs.chain(self.marks.iter().map(|m| m.0)));
        let y = self.y.span(values().filter(held).map(|p| p.1));
        let (area, legend) = root.split_horizontally(px(WIDTH - legend_width));
        let mut chart = ChartBuilder::on(&area)
            .margin_top(px(44))
            .margin_right(px(14))
            .x_label_area_size(px(44))
            .y_label_area_size(px(50))
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(stroke(GRID, 1))
            .axis_style(stroke(QUIET, 1))
            .label_style(font(12.0, QUIET))
            .x_labels(8)
            .y_labels(6)
            .x_label_formatter(&|v| number(*v))
            .y_label_formatter(&|v| number(*v))
            .set_all_tick_mark_size(px(4))
            .draw()?;
        let middle = (50 + (WIDTH - legend_width - 14)) / 2;
        let label = font(12.0, QUIET).pos(Pos::new(HPos::Center, VPos::Bottom));
        let place = (px(middle), px(height - 4));
        root.draw(&Text::new(self.x.label.clone(), place, label))?;
        for (at, name) in self.marks.iter().filter(|m| self.x.holds(m.0)) {
            let line = vec![(*at, y.low), (*at, y.high)];
            chart.draw_series([PathElement::new(line, stroke(QUIET, 1))])?;
            let style = font(11.0, QUIET).pos(Pos::new(HPos::Center, VPos::Bottom));
            chart.draw_series([Text::new(name.clone(), (*at, y.high), style)])?;
        }
        let mut empty = true;
        for (i, series) in self.series.iter().enumerate() {
            let colour = colour(i);
            // Few measurements are shown as such; many would hide their line.
            let few = series.points.len() <= 12;
            let runs = series.points.split(|p| !held(&p));
            for run in runs.filter(|r| !r.is_empty()) {
                empty = false;
                let path = match series.style {
                    Style::Line => run.to_vec(),
                    Style::Front => staircase(run),
                    Style::Points => Vec::new(),
                };
                if path.len() > 1 {
                    chart.draw_series([PathElement::new(path, stroke(colour, 2))])?;
                }
                if series.style != Style::Line || few || run.len() == 1 {
                    let dots = run.iter().map(|p| Circle::new(*p, px(4), colour.filled()));
                    chart.draw_series(dots)?;
                }
            }
        }
        if empty {
            let style = font(14.0, QUIET).pos(Pos::new(HPos::Center, VPos::Center));
            let place = (px(middle), px(height / 2));
            root.draw(&Text::new("no data".to_owned(), place, style))?;
        }
        let names = self.series.iter().map(|s| s.name.as_str());
        draw_legend(&legend, names, 48)
    }
}

/// Names in the colours of their series, one below the other from `top`.
pub(super) fn draw_legend<'a>(
    area: &Canvas<'_>,
    names: impl Iterator<Item = &'a str>,
    top: i32,
) -> Drawn {
    for (i, name) in names.enumerate() {
        let y = top + 20 * i as i32;
        let swatch = [(px(4), px(y + 3)), (px(16), px(y + 11))];
        area.draw(&Rectangle::new(swatch, colour(i).filled()))?;
        area.draw(&text(name, (22, y), 12.5, INK, false))?;
    }
    Ok(())
}

/// The points that no other point equals or beats on both axes, from left to right.
fn front(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.retain(|p| p.0.is_finite() && p.1.is_finite());
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut lowest = f64::INFINITY;
    points.retain(|p| {
        let better = p.1 < lowest;
        lowest = lowest.min(p.1);
        better
    });
    points
}

/// Corners between the points of a front: what is reached at x is what was reached left of it.
fn staircase(run: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut path = Vec::with_capacity(2 * run.len());
    for point in run {
        if let Some(&(_, y)) = path.last() {
            path.push((point.0, y));
        }
        path.push(*point);
    }
    path
}

/// Width of every plot, in CSS pixels before scaling to the page.
pub(super) const WIDTH: i32 = 760;
/// Height of a plot with few series.
const HEIGHT: i32 = 330;
/// plotters draws at whole units: so many of them in a pixel keep curves smooth.
const UNITS: i32 = 8;

/// Pixels to the units that are drawn in.
pub(super) const fn px(pixels: i32) -> i32 {
    pixels * UNITS
}

/// A stroke `pixels` wide.
pub(super) fn stroke(colour: RGBColor, pixels: i32) -> ShapeStyle {
    colour.stroke_width(px(pixels).unsigned_abs())
}

pub(super) type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

// Colours that stand for the page's own: replaced by CSS once drawn.
/// Text.
pub(super) const INK: RGBColor = RGBColor(1, 1, 1);
/// Labels and axes.
pub(super) const QUIET: RGBColor = RGBColor(2, 2, 2);
/// Lines behind the data.
pub(super) const GRID: RGBColor = RGBColor(3, 3, 3);

/// What those become: attribute as drawn, in a page, in a file of its own.
const THEME: [(&str, &str, &str); 3] = [
    ("\"#010101\"", "\"var(--ink,#1b1f24)\"", "\"#1b1f24\""),
    ("\"#020202\"", "\"var(--quiet,#59626e)\"", "\"#59626e\""),
    ("\"#030303\"", "\"var(--line,#dfe3e8)\"", "\"#dfe3e8\""),
];

/// Okabe and Ito, *Color Universal Design*, 2008, without black and yellow (unreadable on one
/// paper or the other), and two greys at the end.
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
    RGBColor(170, 150, 120),
];

/// The colour of series `i`; after eight they repeat.
pub(super) fn colour(i: usize) -> RGBColor {
    PALETTE[i % PALETTE.len()]
}

pub(super) fn font(size: f64, colour: RGBColor) -> TextStyle<'static> {
    // plotters writes the size divided by 1.24.
    let size = size * 1.24 * f64::from(UNITS);
    ("sans-serif", size).into_font().color(&colour)
}

/// A line of text whose upper left corner is at `place`, in pixels.
pub(super) fn text(
    text: &str,
    place: (i32, i32),
    size: f64,
    colour: RGBColor,
    bold: bool,
) -> Text<'static, (i32, i32), String> {
    let mut style = font(size, colour);
    if bold {
        style.font = style.font.style(FontStyle::Bold);
    }
    Text::new(text.to_owned(), (px(place.0), px(place.1)), style)
}

/// Width of the longest of some lines of 12.5 px text, pixels: a guess, there is no font to ask.
pub(super) fn widest<'a>(lines: impl Iterator<Item = &'a str>) -> f64 {
    lines.map(|l| l.chars().count()).max().unwrap_or(0) as f64 * 7.2
}

/// Draws on a canvas of [`WIDTH`] × `height` pixels and gives an SVG element for a page.
pub(super) fn canvas(
    title: &str,
    height: i32,
    draw: impl FnOnce(&Canvas<'_>) -> Drawn,
) -> Result<String, ReportError> {
    let mut drawn = String::new();
    let failed = |e: &dyn std::fmt::Display| ReportError::Plot {
        plot: title.to_owned(),
        reason: e.to_string(),
    };
    {
        let size = (px(WIDTH).unsigned_abs(), px(height).unsigned_abs());
        let root = SVGBackend::with_string(&mut drawn, size).into_drawing_area();
        draw(&root).map_err(|e| failed(&e))?;
        root.present().map_err(|e| failed(&e))?;
    }
    // Our own opening tag: scaled by the page, and named for those who cannot see it.
    let body = drawn.split_once(">\n").map_or("", |(_, body)| body);
    let mut svg = format!(
        "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" \
         role=\"img\" aria-label=\"{}\">\n{body}",
        px(WIDTH),
        px(height),
        escape(title)
    );
    for (drawn, page, _) in THEME {
        svg = svg.replace(drawn, page);
    }
    Ok(svg)
}

/// An SVG element of a page as a file of its own: its size stated, its colours fixed, on white.
pub(super) fn standalone(inline: &str) -> String {
    let mut svg = inline.replacen(
        "<svg class=\"plot\"",
        &format!("<svg width=\"{WIDTH}\" style=\"background:#fff\""),
        1,
    );
    for (_, page, file) in THEME {
        svg = svg.replace(page, file);
    }
    svg
}

/// The y axis of RMSE plots: used by every command, so that they look alike.
pub fn rmse_axis() -> Axis {
    Axis::new("RMSE of displayed sRGB values, 0 to 255", Scale::FromZero)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        let axis = |l: &str| Axis::new(l, Scale::Linear);
        Plot::new("Error <over> time", axis("time, s"), axis("RMSE"))
    }

    #[test]
    fn every_name_is_in_the_plot_and_escaped() {
        let svg = plot()
            .line("adaptive", vec![(0.0, 1.0), (1.0, 2.0)])
            .points("a < b & \"c\"", vec![(0.5, 1.5)])
            .mark(0.5, "cut")
            .inline_svg()
            .unwrap();
        for text in [
            "adaptive",
            "a &lt; b &amp; &quot;c&quot;",
            "time, s",
            "RMSE",
            "cut",
        ] {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert!(!svg.contains("<over>"));
        assert!(!svg.contains("#010101") && svg.contains("var(--ink"));
        let file = plot().svg().unwrap();
        assert!(!file.contains("var(--") && file.contains("width=\"760\""));
        for end in [svg, file] {
            assert!(end.starts_with("<svg ") && end.trim_end().ends_with("</svg>"));
        }
    }

    fn polylines(svg: &str) -> Vec<usize> {
        let colour = "stroke=\"#0072B2\"";
        let lines = svg
            .lines()
            .filter(|l| l.starts_with("<polyline") && l.contains(colour));
        lines
            .map(|l| {
                l.split("points=\"")
                    .nth(1)
                    .unwrap()
                    .split(' ')
                    .filter(|p| p.contains(','))
                    .count()
            })
            .collect()
    }

    #[test]
    fn a_number_that_is_not_finite_is_a_gap() {
        let points = [1.0, 2.0, f64::NAN, 3.0, 2.0, 1.0, f64::INFINITY, 4.0];
        let points = points
            .iter()
            .enumerate()
            .map(|(i, y)| (i as f64, *y))
            .collect();
        let svg = plot().line("a", points).inline_svg().unwrap();
        assert_eq!(polylines(&svg), [2, 3]);
        assert_eq!(
            svg.matches("<circle").count(),
            6,
            "few points show as dots, a lone one too"
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn no_data_is_said_and_nothing_panics() {
        let sets = [
            vec![],
            vec![(f64::NAN, 1.0)],
            vec![(1.0, f64::NEG_INFINITY)],
            vec![(f64::MAX, f64::MIN), (f64::MIN, f64::MAX)],
        ];
        for scale in [Scale::FromZero, Scale::Linear, Scale::Log] {
            for set in &sets {
                let axis = || Axis::new("", scale);
                let plot = Plot::new("", axis(), axis()).line("x", set.clone());
                let plot = plot.points("y", set.clone()).front("z", set.clone());
                assert!(plot.inline_svg().unwrap().contains("no data"));
            }
            let axis = || Axis::new("", scale);
            let flat = Plot::new("", axis(), axis()).line("x", vec![(2.0, 3.0); 4]);
            assert!(!flat.inline_svg().unwrap().contains("no data"));
        }
    }

    #[test]
    fn logarithms_leave_out_what_they_cannot_show() {
        let axis = || Axis::new("", Scale::Log);
        let points = vec![(1.0, 1.0), (10.0, 0.0), (100.0, 5.0), (1000.0, 7.0)];
        let svg = Plot::new("", axis(), axis()).line("x", points);
        assert_eq!(polylines(&svg.inline_svg().unwrap()), [2]);
    }

    #[test]
    fn a_front_keeps_what_nothing_beats() {
        let points = vec![
            (3.0, 1.0),
            (1.0, 5.0),
            (2.0, 6.0),
            (2.0, 2.0),
            (f64::NAN, 0.0),
            (3.0, 1.0),
        ];
        let expected = vec![(1.0, 5.0), (2.0, 2.0), (3.0, 1.0)];
        assert_eq!(front(points), expected);
        let corners = [(1.0, 5.0), (2.0, 5.0), (2.0, 2.0), (3.0, 2.0), (3.0, 1.0)];
        assert_eq!(staircase(&expected), corners);
    }

    #[test]
    fn many_series_make_a_taller_plot_and_long_names_leave_room() {
        let mut many = plot();
        for i in 0..20 {
            many = many.line(
                format!("{i}{}", "long ".repeat(30)),
                vec![(0.0, 1.0), (1.0, 2.0)],
            );
        }
        let svg = many.inline_svg().unwrap();
        assert!(svg.contains(&format!("viewBox=\"0 0 {} {}\"", px(WIDTH), px(470))));
    }
}
