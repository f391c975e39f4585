//! The changes of a variant that make its worst error.
//!
//! Each change is made on its own, and its signed error is projected on that of the variant, in the part of the worst
//! image around the largest error. Small errors add up, so the shares do nearly; what they lack is a remainder.

use std::fmt::Write as _;

use afterimage_gpu::Gpu;
use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::did_you_mean;
use afterimage_graph::node::Registry;
use serde::Serialize;

use super::digits::significant;
use super::errors::SHARE;
use super::node_change::{changes, single_changes};
use super::reference::Reference;
use super::report::{MeasureReport, Row};
use super::sequences::TestSequence;
use super::variants::{Pipeline, Variant, VariantKind, variants};
use super::{MeasureOptions, Measurement, error_image, load, sequences};
use crate::files::file_name;
use crate::metrics::{Shown, difference, percentile};
use crate::{LabError, Progress};

/// The side of the part of an image that is looked at, in pixels.
const SIDE: usize = 128;
/// A pixel of that part in the files.
const ZOOM: usize = 4;
/// The name of the change from 32-bit intermediates to those of the file.
const FORMATS: &str = "intermediates of 16 bits";

/// A variant to explain, and the reference.
pub struct Explainer {
    reference: Variant,
    variant: Variant,
}

/// The worst error of a variant, and what makes it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// The name of the variant.
    pub variant: String,
    /// The name of the image or sequence with the largest error, and its worst frame.
    pub image: String,
    pub frame: usize,
    /// The column and the row of the pixel with the largest error.
    pub at: [usize; 2],
    /// The part around it: the first column and row, width and height.
    pub crop: [usize; 4],
    /// The largest error, in codes.
    pub codes: f64,
    /// The changes from the reference; the largest share comes first. None if there is no error.
    pub changes: Vec<ErrorShare>,
    /// The error that the changes on their own do not add up to.
    pub remainder: ErrorShare,
}

/// The share of a change in an error.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ErrorShare {
    /// As in a tier of a pipeline file.
    pub change: String,
    /// The largest error in the part, in codes.
    pub codes: f64,
    /// Of 1; negative for a change that makes the error smaller.
    pub share: f64,
}

impl Explainer {
    /// A variant by its name in the table, or a tier.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn new(pipeline: &Pipeline, name: &str) -> Result<Self, LabError> {
        let mut all = variants(pipeline)?;
        let tier = format!("tier {name}");
        let Some(at) = all.iter().position(|variant| variant.name == name || variant.name == tier) else {
            let names = || all.iter().skip(1).map(|variant| variant.name.trim_start_matches("tier "));
            let known = || format!("there are `{}`", names().collect::<Vec<_>>().join("`, `"));
            let hint = did_you_mean(name, names()).unwrap_or_else(known);
            return Err(LabError::request(format!("the pipeline has no tier or variant `{name}`")).hint(hint));
        };
        Ok(Self { reference: all[0].clone(), variant: all.swap_remove(at) })
    }

    /// Finds what makes the error of the variant where it is worst in a report of the same pipeline. Pictures of that
    /// part are written to the folder of the images of errors, if there is one.
    ///
    /// # Errors
    /// As for [`measure`](super::measure).
    pub fn explain(
        &self,
        gpu: &Gpu,
        registry: &Registry,
        pipeline: &Pipeline,
        options: &MeasureOptions,
        report: &MeasureReport,
        progress: &dyn Progress,
    ) -> Result<Explanation, LabError> {
        progress.begin(&format!("errors of {}", self.variant.name));
        let mut measurement = Measurement::new(gpu, pipeline, options, progress)?;
        let row = report.rows.iter().find(|row| row.variant == self.variant.name);
        let source = &sequences::sources(&options.sequences, &pipeline.written)?[row.map_or(0, Row::worst_sequence)];
        let (runner, written) = (&mut measurement.runner, &pipeline.written);
        let sequence = load(source, gpu, registry, runner, written, &options.sequences)?;
        measurement.load_compared(&self.reference, &sequence)?;
        let (view, output) = (measurement.view, measurement.output);
        let reference = Reference::render(&mut measurement.runner.session, &sequence, view, output)?;
        measurement.load_compared(&self.variant, &sequence)?;
        let worst = WorstFrame::find(&mut measurement, &reference, &sequence)?;
        let [expected, shown] = [&reference.frames[worst.frame], &worst.shown].map(|shown| worst.crop.of(shown));
        if let Some(folder) = &options.error_images {
            let name = format!("{}-{:04}-{}", file_name(&sequence.name), worst.frame, file_name(&self.variant.name));
            let [expected, shown] = [&expected, &shown].map(enlarged);
            error_image::write_shown(&folder.join(format!("{name}-worst-reference.png")), &expected)?;
            error_image::write_shown(&folder.join(format!("{name}-worst.png")), &shown)?;
            error_image::write(&folder.join(format!("{name}-worst-error.png")), &expected, &shown)?;
        }
        let error = signed(&expected, &shown);
        let mut steps = Vec::new();
        if error.iter().any(|x| *x != 0.0) {
            let mut after = |name: &str, graph: &Graph| {
                let variant = Variant { name: name.to_owned(), kind: VariantKind::Switch, graph: graph.clone() };
                measurement.load_compared(&variant, &sequence)?;
                let session = &mut measurement.runner.session;
                Ok::<_, LabError>(worst.crop.of(&reference.frame(session, &sequence, view, worst.frame)?))
            };
            let base = after(FORMATS, &self.reference.graph)?;
            steps.push((FORMATS.to_owned(), signed(&expected, &base)));
            for graph in single_changes(&self.reference.graph, &self.variant.graph) {
                let change = changes(&self.reference.graph, &graph).join(", ");
                steps.push((change.clone(), signed(&base, &after(&change, &graph)?)));
            }
        }
        let (changes, remainder) = shares(&error, steps);
        Ok(Explanation {
            variant: self.variant.name.clone(),
            image: sequence.name.clone(),
            frame: worst.frame,
            at: worst.at,
            crop: worst.crop.0,
            codes: worst.codes,
            changes,
            remainder,
        })
    }
}

/// The frame of the loaded variant with the largest error, by its 99.9th percentile.
struct WorstFrame {
    frame: usize,
    shown: Shown,
    at: [usize; 2],
    crop: Crop,
    codes: f64,
}

impl WorstFrame {
    fn find(
        measurement: &mut Measurement<'_>,
        reference: &Reference,
        sequence: &TestSequence,
    ) -> Result<Self, LabError> {
        let mut worst: Option<(f64, Self)> = None;
        for frame in 0..sequence.len() {
            let shown = reference.shown(&mut measurement.runner.session, sequence, measurement.view, frame)?;
            let errors = difference(&reference.frames[frame].codes(), &shown.codes());
            let (p999, codes) = (percentile(&errors, SHARE), percentile(&errors, 1.0));
            if worst.as_ref().is_none_or(|(least, worst)| (*least, worst.codes) < (p999, codes)) {
                let largest = errors.iter().position(|error| f64::from(*error) == codes).unwrap_or(0);
                let at = [largest % shown.width, largest / shown.width];
                let crop = Crop::around(at, [shown.width, shown.height]);
                worst = Some((p999, Self { frame, shown, at, crop, codes }));
            }
        }
        Ok(worst.expect("a sequence has a frame").1)
    }
}

/// A part of an image: its first column and row, width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crop([usize; 4]);

impl Crop {
    /// The part with a pixel in its middle, or as near to it as the border allows.
    fn around(at: [usize; 2], size: [usize; 2]) -> Self {
        let [width, height] = size.map(|side| side.min(SIDE));
        let first = |at: usize, side: usize, all: usize| at.saturating_sub(side / 2).min(all - side);
        Self([first(at[0], width, size[0]), first(at[1], height, size[1]), width, height])
    }

    fn of(self, shown: &Shown) -> Shown {
        let Self([left, top, width, height]) = self;
        let rows = shown.pixels.chunks(shown.width).skip(top).take(height);
        let pixels = rows.flat_map(|row| &row[left..left + width]).copied().collect();
        Shown { width, height, range: shown.range, pixels }
    }
}

/// The picture with larger pixels.
fn enlarged(shown: &Shown) -> Shown {
    let (width, height) = (ZOOM * shown.width, ZOOM * shown.height);
    let at = |place: usize| shown.pixels[place / width / ZOOM * shown.width + place % width / ZOOM];
    Shown { width, height, range: shown.range, pixels: (0..width * height).map(at).collect() }
}

/// The error of each channel in codes.
fn signed(reference: &Shown, shown: &Shown) -> Vec<f64> {
    let pairs = reference.codes().into_iter().flatten().zip(shown.codes().into_iter().flatten());
    pairs.map(|(reference, shown)| f64::from(shown) - f64::from(reference)).collect()
}

/// The share of each step in an error: its projection on the error. The shares and the remainder's are 1 together, if
/// there is an error.
fn shares(error: &[f64], steps: Vec<(String, Vec<f64>)>) -> (Vec<ErrorShare>, ErrorShare) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let whole = dot(error, error);
    let share = |change: String, part: &[f64]| {
        let codes = part.iter().fold(0.0, |most, x| f64::max(most, x.abs()));
        ErrorShare { change, codes, share: if whole > 0.0 { dot(part, error) / whole } else { 0.0 } }
    };
    let mut rest = error.to_vec();
    for (_, part) in &steps {
        rest.iter_mut().zip(part).for_each(|(rest, part)| *rest -= part);
    }
    let mut all: Vec<ErrorShare> = steps.into_iter().map(|(change, part)| share(change, &part)).collect();
    all.sort_by(|a, b| b.share.abs().total_cmp(&a.share.abs()));
    (all, share("remainder".to_owned(), &rest))
}

impl Explanation {
    /// A table of the changes.
    pub fn to_text(&self) -> String {
        let Self { variant, image, frame, at: [x, y], crop: [left, top, width, height], .. } = self;
        let codes = significant(self.codes);
        let mut text = format!("\n{variant} is worst in frame {frame} of {image}: off by {codes} codes at {x}, {y}\n");
        if self.changes.is_empty() {
            text += "there is no difference from the reference\n";
            return text;
        }
        let _ = writeln!(text, "share   codes  change, in {width}x{height} pixels from {left}, {top}");
        for ErrorShare { change, codes, share } in self.changes.iter().chain([&self.remainder]) {
            let _ = writeln!(text, "{:>4.0} %{:>8}  {change}", 100.0 * share, significant(*codes));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Range;

    fn parts(error: &[f64], steps: &[(&str, &[f64])]) -> (Vec<ErrorShare>, ErrorShare) {
        shares(error, steps.iter().map(|(name, part)| ((*name).to_owned(), part.to_vec())).collect())
    }

    #[test]
    fn shares_and_the_remainder_are_one() {
        // One makes 90 % of each pixel, one 10 % of it, one is at right angles, and one makes it smaller.
        let error = [10.0, -20.0, 5.0, 0.0];
        let tenths = |share: f64| error.map(|x| share * x);
        let (all, remainder) = parts(&error, &[("a", &tenths(0.1)), ("b", &tenths(0.9)), ("c", &[2.0, 1.0, 0.0, 7.0])]);
        let found: Vec<(&str, f64, f64)> = all.iter().map(|one| (one.change.as_str(), one.share, one.codes)).collect();
        assert_eq!(found.iter().map(|one| one.0).collect::<Vec<_>>(), ["b", "a", "c"]);
        for ((_, share, codes), expected) in found.iter().zip([(0.9, 18.0), (0.1, 2.0), (0.0, 7.0)]) {
            assert!((share - expected.0).abs() < 1e-12 && (codes - expected.1).abs() < 1e-12, "{found:?}");
        }
        assert!(remainder.share.abs() < 1e-12 && (remainder.codes - 7.0).abs() < 1e-12, "{remainder:?}");
        let (all, remainder) = parts(&error, &[("a", &tenths(1.5)), ("b", &tenths(-0.7))]);
        assert_eq!(all.iter().map(|one| one.share).collect::<Vec<_>>(), [1.5, -0.7]);
        assert!((remainder.share - 0.2).abs() < 1e-12);
    }

    #[test]
    fn no_error_has_no_shares() {
        let (all, remainder) = parts(&[0.0; 3], &[("a", &[0.0, 1.0, -2.0])]);
        assert_eq!((all[0].share, all[0].codes), (0.0, 2.0));
        assert_eq!(remainder.share, 0.0);
        assert_eq!(parts(&[], &[]), (Vec::new(), ErrorShare { change: "remainder".to_owned(), ..Default::default() }));
    }

    #[test]
    fn a_part_lies_within_the_image() {
        for (at, size, crop) in [
            ([0, 0], [1, 1], [0, 0, 1, 1]),
            ([500, 2], [1000, 5], [500 - SIDE / 2, 0, SIDE, 5]),
            ([999, 699], [1000, 700], [1000 - SIDE, 700 - SIDE, SIDE, SIDE]),
            ([3, 300], [SIDE, 700], [0, 300 - SIDE / 2, SIDE, SIDE]),
        ] {
            assert_eq!(Crop::around(at, size), Crop(crop));
        }
        let pixels = (0..12).map(|place| [place as f32, 0.0, 0.0]).collect();
        let shown = Shown { width: 4, height: 3, range: Range::Sdr, pixels };
        let part = Crop([1, 1, 2, 2]).of(&shown);
        let reds = |shown: &Shown| shown.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>();
        assert_eq!(reds(&part), [5.0, 6.0, 9.0, 10.0]);
        let large = enlarged(&part);
        assert_eq!((large.width, large.height), (2 * ZOOM, 2 * ZOOM));
        assert_eq!(reds(&large)[..ZOOM + 1], [[5.0; ZOOM].as_slice(), &[6.0]].concat());
        assert_eq!(reds(&large)[2 * ZOOM * ZOOM], 9.0);
    }
}
