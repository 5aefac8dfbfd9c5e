//! The page: one HTML file that needs nothing else, no script, no font, no network.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;

use super::{BarChart, Picture, Plot, ReportError, write_file};

const STYLE: &str = include_str!("report.css");

/// A page in the making: a title, key facts, then sections in order.
#[derive(Debug)]
pub struct Report {
    title: String,
    lead: String,
    facts: Vec<(String, String)>,
    sections: Vec<Section>,
    footer: String,
}

impl Report {
    /// A page with a title and a sentence under it that says what the reader sees.
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            lead: lead.into(),
            facts: Vec::new(),
            sections: Vec::new(),
            footer: String::new(),
        }
    }

    /// Adds a key fact: a short name and a number with its unit.
    pub fn fact(&mut self, name: impl Into<String>, value: impl Into<String>) -> &mut Self {
        self.facts.push((name.into(), value.into()));
        self
    }

    /// Adds a section.
    pub fn section(&mut self, section: Section) -> &mut Self {
        self.sections.push(section);
        self
    }

    /// Sets the small print: the command that makes this page again.
    pub fn footer(&mut self, footer: impl Into<String>) -> &mut Self {
        self.footer = footer.into();
        self
    }

    /// The page as text.
    pub fn html(&self) -> String {
        let mut out = String::new();
        let title = escape(&self.title);
        out += "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n";
        out += "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n";
        out += &format!("<title>{title}</title>\n<style>\n{STYLE}</style>\n<main>\n");
        out += &format!("<h1>{title}</h1>\n");
        if !self.lead.is_empty() {
            out += &format!("<p class=\"lead\">{}</p>\n", escape(&self.lead));
        }
        if !self.facts.is_empty() {
            out += "<dl class=\"facts\">\n";
            for (name, value) in &self.facts {
                let (name, value) = (escape(name), escape(value));
                out += &format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n");
            }
            out += "</dl>\n";
        }
        for section in &self.sections {
            let title = escape(&section.title);
            out += &format!("<section>\n<h2>{title}</h2>\n{}</section>\n", section.body);
        }
        if !self.footer.is_empty() {
            out += &format!("<footer>{}</footer>\n", escape(&self.footer));
        }
        out += "</main>\n</html>\n";
        out
    }

    /// Writes the page; the directory must exist.
    ///
    /// # Errors
    ///
    /// [`ReportError::Write`] with the path.
    pub fn write(&self, path: &Path) -> Result<(), ReportError> {
        write_file(path, self.html().as_bytes())
    }
}

/// A part of the page. Everything given to it is plain text and is escaped.
#[derive(Clone, Debug)]
pub struct Section {
    title: String,
    body: String,
}

impl Section {
    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            body: String::new(),
        }
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<p>{}</p>\n", escape(text)))
    }

    /// Commands or other text, its lines as they are.
    pub fn code(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<pre>{}</pre>\n", escape(text)))
    }

    /// A table.
    pub fn table(&mut self, table: &Table) -> &mut Self {
        self.push(format_args!("{}", table.html()))
    }

    /// A plot, with a sentence under it that says what to see in it.
    ///
    /// # Errors
    ///
    /// [`ReportError::Plot`] if it cannot be drawn.
    pub fn plot(&mut self, plot: &Plot, caption: &str) -> Result<&mut Self, ReportError> {
        Ok(self.svg(&plot.inline_svg()?, caption))
    }

    /// A bar chart, with a sentence under it that says what to see in it.
    ///
    /// # Errors
    ///
    /// [`ReportError::Plot`] if it cannot be drawn.
    pub fn bars(&mut self, chart: &BarChart, caption: &str) -> Result<&mut Self, ReportError> {
        Ok(self.svg(&chart.inline_svg()?, caption))
    }

    /// Pictures side by side, as many to a row as the page has room for.
    ///
    /// # Errors
    ///
    /// [`ReportError::Png`] if one cannot be encoded.
    pub fn pictures(&mut self, figures: &[Figure]) -> Result<&mut Self, ReportError> {
        let mut grid = String::new();
        for figure in figures {
            grid += &figure.html()?;
        }
        Ok(self.push(format_args!("<div class=\"grid\">\n{grid}</div>\n")))
    }

    fn svg(&mut self, svg: &str, caption: &str) -> &mut Self {
        let caption = caption_html("", caption);
        self.push(format_args!(
            "<figure class=\"plot\">\n{svg}{caption}</figure>\n"
        ))
    }

    fn push(&mut self, html: std::fmt::Arguments<'_>) -> &mut Self {
        // Writing to a String does not fail.
        let _ = self.body.write_fmt(html);
        self
    }
}

/// A picture with a name, a caption and perhaps another one beneath it.
#[derive(Clone, Debug)]
pub struct Figure {
    picture: Picture,
    name: String,
    caption: String,
    beneath: Option<Picture>,
    full_width: bool,
}

impl Figure {
    /// A picture; its pixels stay sharp when the page enlarges it.
    pub fn new(picture: Picture, name: impl Into<String>, caption: impl Into<String>) -> Self {
        Self {
            picture,
            name: name.into(),
            caption: caption.into(),
            beneath: None,
            full_width: false,
        }
    }

    /// Shows `picture` in the same place while the pointer is over this one: the eye finds a
    /// difference best where the two alternate.
    #[must_use]
    pub fn on_hover(mut self, picture: Picture) -> Self {
        self.beneath = Some(picture);
        self
    }

    /// Takes the whole width of the page.
    #[must_use]
    pub fn full_width(mut self) -> Self {
        self.full_width = true;
        self
    }

    fn html(&self) -> Result<String, ReportError> {
        let class = if self.full_width {
            " class=\"big\""
        } else {
            ""
        };
        let mut images = image(&self.picture, &self.name, "")?;
        if let Some(beneath) = &self.beneath {
            images += &image(beneath, "", "under")?;
        }
        let focus = if self.beneath.is_some() {
            " tabindex=\"0\""
        } else {
            ""
        };
        let caption = caption_html(&self.name, &self.caption);
        Ok(format!(
            "<figure{class}><span class=\"frame\"{focus}>{images}</span>{caption}</figure>\n"
        ))
    }
}

/// Wider pictures than this are shown smaller than they are: there, leaving out pixels would
/// leave out the lines of a net.
const SHARP_UP_TO: usize = 384;

fn image(picture: &Picture, alt: &str, class: &str) -> Result<String, ReportError> {
    let fine = picture.width() > SHARP_UP_TO;
    let class = match (class, fine) {
        ("", true) => " class=\"fine\"".to_owned(),
        ("", false) => String::new(),
        (class, true) => format!(" class=\"{class} fine\""),
        (class, false) => format!(" class=\"{class}\""),
    };
    let data = base64::engine::general_purpose::STANDARD.encode(picture.png()?);
    Ok(format!(
        "<img{class} width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{data}\">",
        picture.width(),
        picture.height(),
        escape(alt)
    ))
}

fn caption_html(name: &str, caption: &str) -> String {
    let (name, caption) = (escape(name), escape(caption));
    match (name.is_empty(), caption.is_empty()) {
        (true, true) => String::new(),
        (true, false) => format!("<figcaption>{caption}</figcaption>\n"),
        (false, true) => format!("<figcaption><b>{name}</b></figcaption>\n"),
        (false, false) => format!("<figcaption><b>{name}</b><br>{caption}</figcaption>\n"),
    }
}

/// A table: a row of heads, then rows of cells. Columns of numbers are set flush right; cells
/// that begin with ✓ or ✗ stand out.
#[derive(Clone, Debug, Default)]
pub struct Table {
    caption: String,
    heads: Vec<String>,
    rows: Vec<(Vec<String>, bool)>,
}

impl Table {
    /// A table with these heads.
    pub fn new<S: Into<String>>(heads: impl IntoIterator<Item = S>) -> Self {
        Self {
            heads: heads.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Sets a line above the table.
    #[must_use]
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Adds a row; missing cells stay empty, surplus ones are shown.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) -> &mut Self {
        self.rows
            .push((cells.into_iter().map(Into::into).collect(), false));
        self
    }

    /// Adds a row that stands out: the method that the table is about.
    pub fn strong_row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) -> &mut Self {
        self.rows
            .push((cells.into_iter().map(Into::into).collect(), true));
        self
    }

    fn html(&self) -> String {
        let rows = self.rows.iter().map(|r| r.0.len());
        let columns = rows.chain([self.heads.len()]).max().unwrap_or(0);
        let numeric: Vec<bool> = (0..columns)
            .map(|c| {
                let mut cells = self.rows.iter().filter_map(|r| r.0.get(c)).peekable();
                cells.peek().is_some() && cells.all(|cell| is_number(cell))
            })
            .collect();
        let line = |cells: &[String], tag: &str, class: &str| {
            let mut out = format!("<tr{class}>");
            for (c, numeric) in numeric.iter().enumerate() {
                let cell = cells.get(c).map(|s| escape(s)).unwrap_or_default();
                let align = match cell.chars().next() {
                    Some('✓') => " class=\"ok\"",
                    Some('✗') => " class=\"bad\"",
                    _ if *numeric => " class=\"n\"",
                    _ => "",
                };
                out += &format!("<{tag}{align}>{cell}</{tag}>");
            }
            out + "</tr>\n"
        };
        let mut out = String::from("<div class=\"wide\"><table>\n");
        if !self.caption.is_empty() {
            out += &format!("<caption>{}</caption>\n", escape(&self.caption));
        }
        if !self.heads.is_empty() {
            out += &format!("<thead>{}</thead>\n", line(&self.heads, "th", ""));
        }
        out += "<tbody>\n";
        for (cells, strong) in &self.rows {
            out += &line(cells, "td", if *strong { " class=\"best\"" } else { "" });
        }
        out + "</tbody></table></div>\n"
    }
}

/// Whether a cell reads as a number, perhaps with a unit, or as the dash that stands for none.
fn is_number(cell: &str) -> bool {
    let start = cell.trim_start_matches(['-', '−', '+', '±', '×', '≤', '≥', '<', '>', '(', ' ']);
    cell == "–" || cell.is_empty() || start.starts_with(|c: char| c.is_ascii_digit())
}

/// Text as it may stand in HTML, inside or outside a quoted attribute.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Axis, Scale};

    const EVIL: &str = "<script>alert(\"1\")</script> & 'x'";

    fn picture(level: u8) -> Picture {
        Picture::new(3, 2, vec![[level; 3]; 6]).unwrap()
    }

    /// Every place that takes text, given text that would be markup.
    fn evil_report() -> String {
        let mut report = Report::new(EVIL, EVIL);
        report.fact(EVIL, EVIL).footer(EVIL);
        let mut section = Section::new(EVIL);
        let mut table = Table::new([EVIL]).caption(EVIL);
        table.row([EVIL]).strong_row([EVIL]);
        section.paragraph(EVIL).code(EVIL).table(&table);
        let axis = || Axis::new(EVIL, Scale::Linear);
        let plot = Plot::new(EVIL, axis(), axis()).line(EVIL, vec![(0.0, 1.0)]);
        section.plot(&plot.mark(0.0, EVIL), EVIL).unwrap();
        let bars = BarChart::stacked(EVIL, EVIL, vec![EVIL.into()]).bar(EVIL, 1.0);
        section.bars(&bars, EVIL).unwrap();
        let figure = Figure::new(picture(1), EVIL, EVIL).on_hover(picture(2));
        section.pictures(&[figure.full_width()]).unwrap();
        report.section(section);
        report.html()
    }

    #[test]
    fn text_never_becomes_markup() {
        let html = evil_report();
        assert!(!html.contains("<script"));
        assert!(!html.contains("alert(\"1\")"));
        // 20 places with text of their own, some written twice (title, alternative text).
        assert!(html.matches("&lt;script&gt;").count() >= 20);
        assert_eq!(escape("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
    }

    #[test]
    fn the_page_needs_nothing_from_outside() {
        let html = evil_report();
        let namespace = "xmlns=\"http://www.w3.org/2000/svg\"";
        let rest = html.replace(namespace, "");
        for outside in ["http:", "https:", "url(", "@import", "<link", "<script"] {
            assert!(!rest.contains(outside), "{outside}");
        }
        let sources = html.matches(" src=\"").count();
        assert_eq!(
            sources,
            html.matches(" src=\"data:image/png;base64,").count()
        );
        assert_eq!(sources, 2);
    }

    #[test]
    fn tags_that_are_opened_are_closed() {
        let html = evil_report();
        for tag in [
            "main", "section", "figure", "table", "tr", "td", "th", "dl", "p", "svg", "h2", "div",
            "span",
        ] {
            let opened = html.matches(&format!("<{tag}>")).count()
                + html.matches(&format!("<{tag} ")).count();
            assert!(opened > 0, "{tag}");
            assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }

    #[test]
    fn an_embedded_picture_is_the_picture() {
        let mut section = Section::new("");
        section
            .pictures(&[Figure::new(picture(77), "a", "")])
            .unwrap();
        let data = section.body.split("base64,").nth(1).unwrap();
        let data = data.split('"').next().unwrap();
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(data)
            .unwrap();
        assert_eq!(bytes, picture(77).png().unwrap());
    }

    #[test]
    fn small_pictures_stay_sharp_and_large_ones_keep_their_lines() {
        let wide = Picture::new(768, 1, vec![[0; 3]; 768]).unwrap();
        let figure = Figure::new(picture(1), "", "")
            .on_hover(wide)
            .html()
            .unwrap();
        assert_eq!(figure.matches("<img width=\"3\"").count(), 1);
        assert_eq!(
            figure
                .matches("<img class=\"under fine\" width=\"768\"")
                .count(),
            1
        );
    }

    #[test]
    fn columns_of_numbers_are_set_right() {
        let mut table = Table::new(["method", "RMSE", "note"]);
        table.row(["adaptive", "5.10", "best"]).row(["none", "–"]);
        let html = table.html();
        assert!(
            html.contains("<td class=\"n\">5.10</td><td>best</td>"),
            "{html}"
        );
        assert!(
            html.contains("<td>none</td><td class=\"n\">–</td><td></td>"),
            "{html}"
        );
        let surplus = Table::default().row(["a", "b"]).html();
        assert!(surplus.contains("<td>b</td>"));
    }

    #[test]
    fn what_cannot_be_written_is_an_error_with_its_path() {
        let error = Report::new("t", "").write(Path::new("/nowhere/at/all.html"));
        assert!(
            error
                .unwrap_err()
                .to_string()
                .contains("/nowhere/at/all.html")
        );
    }
}
