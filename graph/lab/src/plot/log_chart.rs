//! Charts with logarithmic axes, as SVG for light and for dark pages.

use std::fmt::Write as _;

/// Pixels of one chart, with its margins.
const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 250.0;
/// Margins for the numbers at the left, the caption at the bottom, and the title at the top.
const LEFT: f64 = 52.0;
const BOTTOM: f64 = 42.0;
const TOP: f64 = 34.0;
const RIGHT: f64 = 14.0;
const COLUMNS: usize = 2;
/// The colors also differ in brightness.
const COLORS: [&str; 2] = ["#d9822b", "#3b8ec2"];

/// Points in one color.
pub(crate) struct Line {
    pub(crate) name: &'static str,
    pub(crate) points: Vec<(f64, f64)>,
}

/// A chart: the title names the vertical axis, `x` the horizontal one.
pub(crate) struct Chart {
    pub(crate) title: &'static str,
    pub(crate) x: &'static str,
    pub(crate) lines: Vec<Line>,
}

/// A logarithmic axis between two powers of ten.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LogRange {
    low: i32,
    high: i32,
}

impl LogRange {
    /// The powers of ten around all values above zero.
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let logs: Vec<f64> = values.filter(|v| *v > 0.0).map(f64::log10).collect();
        let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if logs.is_empty() {
            return Self { low: 0, high: 1 };
        }
        let low = low.floor() as i32;
        Self { low, high: (high.ceil() as i32).max(low + 1) }
    }

    /// 0 at the low end, 1 at the high end.
    fn place(self, value: f64) -> f64 {
        let log = if value > 0.0 { value.log10() } else { f64::from(self.low) };
        (log - f64::from(self.low)) / f64::from(self.high - self.low)
    }

    fn powers(self) -> impl Iterator<Item = f64> {
        (self.low..=self.high).map(|power| 10_f64.powi(power))
    }
}

/// All charts, two in a row, under one title.
pub(crate) fn page(title: &str, charts: &[Chart]) -> String {
    let (width, height) = (WIDTH * COLUMNS as f64, HEIGHT * charts.len().div_ceil(COLUMNS) as f64 + 30.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"11\" fill=\"#808080\">\n<text x=\"{LEFT}\" y=\"20\" font-size=\"13\">{}</text>\n",
        escaped(title)
    );
    for (index, chart) in charts.iter().enumerate() {
        let (x, y) = ((index % COLUMNS) as f64 * WIDTH, (index / COLUMNS) as f64 * HEIGHT + 30.0);
        let _ = writeln!(svg, "<g transform=\"translate({x} {y})\">");
        draw(chart, &mut svg);
        svg += "</g>\n";
    }
    svg + "</svg>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn draw(chart: &Chart, svg: &mut String) {
    let points = || chart.lines.iter().flat_map(|line| &line.points);
    let (across, up) = (LogRange::around(points().map(|p| p.0)), LogRange::around(points().map(|p| p.1)));
    let x = |value: f64| LEFT + across.place(value) * (WIDTH - LEFT - RIGHT);
    let y = |value: f64| HEIGHT - BOTTOM - up.place(value) * (HEIGHT - BOTTOM - TOP);
    let _ = writeln!(svg, "<text x=\"{LEFT}\" y=\"14\" font-weight=\"bold\">{}</text>", escaped(chart.title));
    for power in up.powers() {
        let (at, right) = (y(power), WIDTH - RIGHT);
        let _ = writeln!(svg, "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#80808055\"/>");
        let _ = writeln!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{power}</text>", LEFT - 5.0, at + 4.0);
    }
    for power in across.powers() {
        let (at, foot) = (x(power), HEIGHT - BOTTOM);
        let _ = writeln!(svg, "<path d=\"M{at:.1} {TOP}V{foot}\" stroke=\"#80808055\"/>");
        let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{power}</text>", foot + 14.0);
    }
    let middle = LEFT + 0.5 * (WIDTH - LEFT - RIGHT);
    let _ = writeln!(
        svg,
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
        HEIGHT - 12.0,
        escaped(chart.x)
    );
    for (index, (line, color)) in chart.lines.iter().zip(COLORS).enumerate() {
        let path: Vec<String> = line.points.iter().map(|p| format!("{:.1} {:.1}", x(p.0), y(p.1))).collect();
        let _ = writeln!(svg, "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>", path.join("L"));
        for (px, py) in &line.points {
            let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{color}\"/>", x(*px), y(*py));
        }
        let at = LEFT + 8.0 + 100.0 * index as f64;
        let _ = writeln!(svg, "<text x=\"{at}\" y=\"{}\" fill=\"{color}\">{}</text>", TOP - 6.0, escaped(line.name));
    }
}

#[cfg(test)]
mod tests {
    use super::LogRange;

    #[test]
    fn axes_reach_around_their_values() {
        let axis = LogRange::around([0.02, 0.0, 30.0].into_iter());
        assert_eq!(axis, LogRange { low: -2, high: 2 });
        assert_eq!((axis.place(0.01), axis.place(1.0), axis.place(100.0)), (0.0, 0.5, 1.0));
        assert_eq!(LogRange::around([10.0].into_iter()), LogRange { low: 1, high: 2 });
    }
}
