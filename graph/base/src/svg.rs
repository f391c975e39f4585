//! Pictures as SVG text: lines, shapes and labels on white.

use std::fmt::Write as _;

/// The fonts of all texts, by preference.
const FONTS: &str = "Ubuntu, Inter, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";

/// Right and down from the top left corner, in SVG units.
pub type Point = (f64, f64);

/// An SVG file under construction.
pub struct Canvas(String);

/// The part of a text that lies at its position.
#[derive(Clone, Copy, PartialEq)]
pub enum Anchor {
    /// The left end.
    Start,
    /// The center.
    Middle,
    /// The right end.
    End,
}

/// Color and weight of a text.
#[derive(Clone, Copy)]
pub struct Paint<'a> {
    color: &'a str,
    is_bold: bool,
}

impl<'a> Paint<'a> {
    /// Bold in a color.
    pub fn bold(color: &'a str) -> Self {
        Self { color, is_bold: true }
    }
}

impl<'a> From<&'a str> for Paint<'a> {
    fn from(color: &'a str) -> Self {
        Self { color, is_bold: false }
    }
}

impl Canvas {
    /// An empty canvas with a white background.
    pub fn new(width: f64, height: f64) -> Self {
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"{FONTS}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        ))
    }

    /// The SVG file.
    pub fn finish(self) -> String {
        self.0 + "</svg>\n"
    }

    /// A line of text.
    pub fn text<'a>(&mut self, at: Point, size: f64, anchor: Anchor, paint: impl Into<Paint<'a>>, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let Paint { color, is_bold } = paint.into();
        let weight = if is_bold { " font-weight=\"600\"" } else { "" };
        self.element(format_args!(
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{color}\"{weight}>\
             {}</text>",
            at.0,
            at.1,
            escaped(text)
        ));
    }

    /// A text that rises to the right.
    pub fn slanted_text(&mut self, at: Point, size: f64, color: &str, text: &str) {
        self.element(format_args!(
            "<text transform=\"translate({:.1} {:.1}) rotate(-52)\" font-size=\"{size}\" fill=\"{color}\">{}</text>",
            at.0,
            at.1,
            escaped(text)
        ));
    }

    /// A straight line.
    pub fn line(&mut self, from: Point, to: Point, color: &str, dashed: bool) {
        let dashes = if dashed { " stroke-dasharray=\"5 4\"" } else { "" };
        self.element(format_args!(
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\"{dashes}/>",
            from.0, from.1, to.0, to.1
        ));
    }

    /// A line through all points.
    pub fn path(&mut self, points: &[Point], color: &str) {
        self.element(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.5\" stroke-linejoin=\"round\"/>",
            list(points)
        ));
    }

    /// A filled polygon.
    pub fn area(&mut self, points: &[Point], fill: &str, edge: &str) {
        self.element(format_args!(
            "<polygon points=\"{}\" fill=\"{fill}\" stroke=\"{edge}\" stroke-linejoin=\"round\"/>",
            list(points)
        ));
    }

    /// A filled box: left, top, width and height. Tooltips are left out where they are empty, here and below.
    pub fn bar(&mut self, area: [f64; 4], fill: &str, edge: Option<&str>, tooltip: &str) {
        let [x, y, width, height] = area;
        let edge = edge.map_or(String::new(), |edge| format!(" stroke=\"{edge}\" stroke-width=\"0.8\""));
        let round = if height > 6.0 { 2.0 } else { 0.0 };
        self.element(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"{round}\" \
             fill=\"{fill}\"{edge}>{}</rect>",
            title(tooltip)
        ));
    }

    /// A circle.
    pub fn dot(&mut self, center: Point, radius: f64, fill: &str, edge: Option<&str>, tooltip: &str) {
        let edge = edge.map_or(String::new(), |edge| format!(" stroke=\"{edge}\" stroke-width=\"2\""));
        self.element(format_args!(
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{fill}\"{edge}>{}</circle>",
            center.0,
            center.1,
            title(tooltip)
        ));
    }

    /// A square that stands on a corner.
    pub fn diamond(&mut self, center: Point, radius: f64, fill: &str, tooltip: &str) {
        let (x, y) = center;
        let ([left, right], [top, bottom]) = ([x - radius, x + radius], [y - radius, y + radius]);
        self.element(format_args!(
            "<path d=\"M{x:.1} {top:.1}L{right:.1} {y:.1}L{x:.1} {bottom:.1}L{left:.1} {y:.1}Z\" fill=\"{fill}\">\
             {}</path>",
            title(tooltip)
        ));
    }

    fn element(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.0, "{element}");
    }
}

fn list(points: &[Point]) -> String {
    points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

fn title(tooltip: &str) -> String {
    if tooltip.is_empty() { String::new() } else { format!("<title>{}</title>", escaped(tooltip)) }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_tooltips_are_escaped() {
        let mut canvas = Canvas::new(10.0, 10.0);
        canvas.text((1.0, 2.0), 9.0, Anchor::Start, "#000", "a < b & \"c\"");
        canvas.dot((1.0, 2.0), 3.0, "#000", None, "<title>");
        let svg = canvas.finish();
        assert!(svg.contains(">a &lt; b &amp; &quot;c&quot;</text>"), "{svg}");
        assert!(svg.contains("<title>&lt;title&gt;</title>"), "{svg}");
    }
}
