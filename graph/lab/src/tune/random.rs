//! How far predicted errors are from measured ones: random choices of the switches, each on each image.

use afterimage_gpu::Gpu;
use afterimage_graph::check::Graph;
use afterimage_graph::node::Registry;

use super::measurer::{ClipMeasurer, TunePipeline};
use super::space::{Space, singles};
use super::steps::Steps;
use crate::measure::MeasureOptions;
use crate::measure::variants::verify;
use crate::{LabError, Progress};

/// The error of a choice on an image: 99.9th percentiles, in codes.
#[derive(Clone, Debug)]
pub struct PredictedError {
    /// The switches that are not at their most accurate.
    pub choice: String,
    pub image: String,
    pub predicted: f64,
    pub measured: f64,
}

/// Random choices are tried so many times for each that is wanted: some are not valid, or known already.
const TRIES: u32 = 20;

/// Errors of `count` random choices of at least two switches. Equal pipelines give equal choices; there may be fewer
/// than that in all.
///
/// # Errors
/// Everything that a measurement reports.
pub fn random_errors(
    gpu: &Gpu,
    registry: &Registry,
    pipeline: &TunePipeline,
    options: &MeasureOptions,
    count: u32,
    progress: &dyn Progress,
) -> Result<Vec<PredictedError>, LabError> {
    let mut steps = Steps::new(progress, 0, u64::from(count));
    let mut measurer = ClipMeasurer::prepare(gpu, registry, pipeline, options, false, &mut steps)?;
    let choices = choices(&measurer.space, &pipeline.written, count);
    steps.expect_last(choices.len() as u64);
    let mut errors = Vec::new();
    for choice in choices {
        for part in measurer.missing_parts(&choice) {
            let name = measurer.space.key(&part);
            steps.run(&name, measurer.parts_left(), || measurer.measured_errors(&part))?;
        }
        let (name, predicted) = (measurer.space.key(&choice), measurer.predicted_errors(&choice));
        let measured = steps.run_last(&name, measurer.parts_left(), || measurer.measured_errors(&choice))?;
        for (image, (predicted, measured)) in measurer.clip_names().zip(predicted.into_iter().zip(measured)) {
            let (choice, image) = (name.clone(), image.to_owned());
            errors.push(PredictedError { choice, image, predicted: predicted.0, measured: measured.0 });
        }
    }
    steps.finish();
    Ok(errors)
}

/// Different choices, from a few switches to nearly all.
fn choices(space: &Space, written: &Graph, count: u32) -> Vec<Vec<usize>> {
    let (sizes, mut random) = (space.sizes(), Random(1));
    let mut all: Vec<Vec<usize>> = Vec::new();
    for _ in 0..TRIES * count {
        if all.len() == count as usize {
            break;
        }
        let share = random.below(1000);
        let mut choice = Vec::with_capacity(sizes.len());
        for size in &sizes {
            let is_changed = random.below(1000) < share;
            choice.push(if is_changed { 1 + random.below(*size as u64 - 1) as usize } else { 0 });
        }
        if singles(&choice).len() > 1 && !all.contains(&choice) && verify(&space.graph(written, &choice)).is_ok() {
            all.push(choice);
        }
    }
    all
}

/// Numbers that are the same in every run: a linear congruential generator (Knuth, MMIX), of which the upper bits
/// count.
struct Random(u64);

impl Random {
    /// A number below `end`.
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % end
    }
}
