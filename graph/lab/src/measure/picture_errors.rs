//! The figures of a claim for a single picture.

use std::fmt;

use afterimage_gpu::Texels;
use afterimage_graph::check::Graph;

use super::errors::SHARE;
use super::view::View;
use crate::LabError;
use crate::metrics::{Display, PIXELS_PER_DEGREE, Shown, difference, flip, jod, mean, percentile};

/// The errors of a picture, as a claim states them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureErrors {
    /// The largest difference of the channels in codes that 99.9 % of the pixels do not exceed.
    pub p999: f64,
    /// The mean of FLIP.
    pub flip: f64,
    /// The quality in JOD on [`Self::display`].
    pub jod: f64,
    pub display: Display,
}

/// A picture as an output of a graph shows it.
#[derive(Clone, Copy, Debug)]
pub struct ShownOutput<'a> {
    pub graph: &'a Graph,
    /// The name of the output.
    pub output: &'a str,
    pub texels: &'a Texels,
}

impl PictureErrors {
    /// Compares two pictures.
    ///
    /// # Errors
    /// They cannot be displayed, are of different sizes or displays, or have pixels that are not finite.
    pub fn between(reference: ShownOutput<'_>, shown: ShownOutput<'_>) -> Result<Self, LabError> {
        let (reference, shown) = (displayed(reference)?, displayed(shown)?);
        if (reference.width, reference.height) != (shown.width, shown.height) {
            return Err(LabError::request("the pictures are of different sizes"));
        }
        if reference.range != shown.range {
            return Err(LabError::request("one picture is for an SDR display, the other for an HDR display"));
        }
        let display = Display::of(shown.range);
        let codes = difference(&reference.codes(), &shown.codes());
        Ok(Self {
            p999: percentile(&codes, SHARE),
            flip: mean(&flip(&reference, &shown, PIXELS_PER_DEGREE)),
            jod: jod(&[reference], &[shown], 1.0, &display)?,
            display,
        })
    }
}

impl fmt::Display for PictureErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { p999, flip, jod, display } = self;
        write!(f, "p99.9 {p999:.2} codes, FLIP {flip:.3}, JOD {jod:.3} on `{}`", display.name)
    }
}

fn displayed(shown: ShownOutput<'_>) -> Result<Shown, LabError> {
    let ShownOutput { graph, output, texels } = shown;
    let found = graph.outputs.iter().find(|known| known.name == output);
    let found = found.ok_or_else(|| LabError::request(format!("there is no output `{output}`")))?;
    let shown = View::of(graph, found)?.shown(texels);
    shown.ok_or_else(|| LabError::request("a pixel is not finite"))
}

#[cfg(test)]
mod tests {
    use afterimage_graph::check::{CheckOptions, NoFiles, check};
    use afterimage_graph::document::parse;
    use afterimage_graph::image::{Format, ImageDesc, Size};
    use afterimage_graph::node::Registry;

    use super::*;

    fn graph() -> Graph {
        let text = r#"Pipeline(inputs: { "in": DisplayLinear }, nodes: { "sdr": Encode(source: "in", transfer: Srgb) },
            outputs: { "sdr": "sdr" })"#;
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
        let document = parse("errors.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
        let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
        check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
    }

    /// A gray picture, of which the first pixels have another red.
    fn picture(height: u32, brighter: usize, red: u8) -> Texels {
        let desc = ImageDesc::new(Size::new(100, height)).format(Format::Rgba8Unorm);
        let pixel = |index: usize| if index < brighter { [red, 128, 128, 255] } else { [128, 128, 128, 255] };
        Texels { desc, bytes: (0..100 * height as usize).flat_map(pixel).collect() }
    }

    fn output<'a>(graph: &'a Graph, texels: &'a Texels) -> ShownOutput<'a> {
        ShownOutput { graph, output: "sdr", texels }
    }

    #[test]
    fn a_thousandth_of_the_pixels_may_differ_by_more() {
        let graph = graph();
        let between = |shown: &Texels| {
            let reference = picture(50, 0, 128);
            PictureErrors::between(output(&graph, &reference), output(&graph, shown))
        };
        let same = between(&picture(50, 0, 128)).expect("it is displayed");
        assert_eq!((same.p999, same.flip, same.jod), (0.0, 0.0, 10.0));
        let few = between(&picture(50, 5, 130)).expect("it is displayed");
        let more = between(&picture(50, 6, 130)).expect("it is displayed");
        assert!(few.p999.abs() < 1e-4 && (more.p999 - 2.0).abs() < 1e-4, "{few} {more}");
        let seen = between(&picture(50, 2500, 190)).expect("it is displayed");
        assert!(seen.flip > 0.05 && seen.jod < 9.5, "{seen}");
        assert!(between(&picture(40, 0, 128)).is_err_and(|error| error.to_string().contains("different sizes")));
        let unknown = displayed(ShownOutput { output: "hdr", ..output(&graph, &picture(50, 0, 128)) });
        assert!(unknown.is_err_and(|error| error.to_string().contains("`hdr`")));
    }
}
