//! The few shapes that the picture is made of, as SVG.

/// A picture in the making.
#[derive(Default)]
pub(crate) struct Canvas(String);

/// Which point of a text its position is.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// The color and the weight of a text.
#[derive(Clone, Copy)]
pub(crate) struct Paint<'a> {
    color: &'a str,
    bold: bool,
}

impl<'a> Paint<'a> {
    pub(crate) fn plain(color: &'a str) -> Self {
        Self { color, bold: false }
    }

    pub(crate) fn bold(color: &'a str) -> Self {
        Self { color, bold: true }
    }

    fn attributes(self) -> String {
        format!("fill=\"{}\"{}", self.color, if self.bold { " font-weight=\"600\"" } else { "" })
    }
}

impl Canvas {
    pub(crate) fn text(&mut self, x: f64, y: f64, size: f64, anchor: Anchor, paint: Paint<'_>, text: &str) {
        let (anchor, paint, text) = (anchor.name(), paint.attributes(), escaped(text));
        self.0 += &format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" {paint}>{text}</text>\n"
        );
    }

    /// Text that climbs to the right.
    pub(crate) fn slanted(&mut self, x: f64, y: f64, size: f64, color: &str, text: &str) {
        let text = escaped(text);
        self.0 += &format!(
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-52)\" font-size=\"{size}\" \
             fill=\"{color}\">{text}</text>\n"
        );
    }

    /// A filled rectangle that says `hint` under the pointer; no hint if empty.
    pub(crate) fn bar(&mut self, [x, y, width, height]: [f64; 4], fill: &str, edge: Option<&str>, hint: &str) {
        let edge = edge.map_or(String::new(), |edge| format!(" stroke=\"{edge}\" stroke-width=\"0.8\""));
        let round = if height > 6.0 { 2.0 } else { 0.0 };
        let hint = if hint.is_empty() { String::new() } else { format!("<title>{}</title>", escaped(hint)) };
        self.0 += &format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"{round}\" \
             fill=\"{fill}\"{edge}>{hint}</rect>\n"
        );
    }

    pub(crate) fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), color: &str, dashed: bool) {
        let dashes = if dashed { " stroke-dasharray=\"5 4\"" } else { "" };
        self.0 += &format!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"{dashes}/>\n"
        );
    }

    pub(crate) fn disc(&mut self, x: f64, y: f64, radius: f64, fill: &str, hint: &str) {
        let hint = escaped(hint);
        self.0 += &format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{fill}\"><title>{hint}</title></circle>\n"
        );
    }

    pub(crate) fn diamond(&mut self, x: f64, y: f64, radius: f64, fill: &str, hint: &str) {
        let ([left, right], [top, bottom]) = ([x - radius, x + radius], [y - radius, y + radius]);
        self.0 += &format!(
            "<path d=\"M{x:.1} {top:.1}L{right:.1} {y:.1}L{x:.1} {bottom:.1}L{left:.1} {y:.1}Z\" fill=\"{fill}\">\
             <title>{}</title></path>\n",
            escaped(hint)
        );
    }

    /// A closed shape.
    pub(crate) fn area(&mut self, points: &[(f64, f64)], fill: &str, edge: &str) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let points = points.join(" ");
        self.0 +=
            &format!("<polygon points=\"{points}\" fill=\"{fill}\" stroke=\"{edge}\" stroke-linejoin=\"round\"/>\n");
    }

    pub(crate) fn finish(self, width: f64, height: f64) -> String {
        let fonts = "Inter, 'Helvetica Neue', 'Segoe UI', 'DejaVu Sans', sans-serif";
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"{fonts}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.0
        )
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// About how wide so many letters of this size are.
pub(crate) fn width_of(letters: usize, size: f64) -> f64 {
    0.6 * size * letters as f64
}

/// The text, shortened to what fits into a width at this size of letters.
pub(crate) fn fitting(text: &str, width: f64, size: f64) -> String {
    let room = (width / width_of(1, size)).max(0.0) as usize;
    let length = text.chars().count();
    match room {
        _ if length <= room => text.to_owned(),
        0..3 => String::new(),
        _ => text.chars().take(room - 1).chain(['…']).collect(),
    }
}

/// A soft color of that hue in degrees.
pub(crate) fn color(hue: f64) -> String {
    let (saturation, lightness) = (0.56, 0.72);
    let strength = saturation * f64::min(lightness, 1.0 - lightness);
    let channel = |offset: f64| {
        let k = (offset + hue / 30.0) % 12.0;
        let value = lightness - strength * f64::min(k - 3.0, 9.0 - k).clamp(-1.0, 1.0);
        (255.0 * value).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(0.0), channel(8.0), channel(4.0))
}
