//! Time against error, for each tier and each quality switch of a pipeline.
//!
//! The variants follow from the node kinds: the reference, the tiers, and each value of each quality switch. Kinds of
//! plug-ins are measured in the same way as built-in ones.

mod chart;
mod charts;
mod digits;
mod error_image;
pub(crate) mod errors;
mod explain;
mod json;
pub(crate) mod node_change;
mod picture_errors;
pub(crate) mod reference;
mod report;
pub(crate) mod sequence_runner;
pub(crate) mod sequences;
mod table;
pub(crate) mod variants;
pub(crate) mod view;
pub(crate) mod wires;

use std::path::PathBuf;
use std::sync::Arc;

use afterimage_gpu::Gpu;
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::node::Registry;
use afterimage_plan::{Options, Plan};

pub use chart::chart;
pub use errors::{Errors, Flicker};
pub use explain::{ErrorShare, Explainer, Explanation};
pub use json::json;
pub use picture_errors::{PictureErrors, ShownOutput};
pub use reference::Figures;
pub use report::{MeasureReport, Row, SequenceInfo};
pub use sequence_runner::Cost;
pub use sequences::{SequenceOptions, files};
pub use table::table;
pub use variants::{Pipeline, VariantKind};

pub(crate) use report::{beats, images};

use reference::Reference;
use sequence_runner::SequenceRunner;
use sequences::{SequenceSource, TestSequence};
use variants::{Variant, variants};
use view::View;

use crate::files::{file_name, make_folder};
use crate::metrics::Display;
use crate::{LabError, Progress};

#[derive(Clone, Debug)]
pub struct MeasureOptions {
    pub sequences: SequenceOptions,
    pub facts: Facts,
    /// The planner's options of all variants.
    pub options: Options,
    /// Samples of each time; `None` for 50 on a GPU and 7 on a processor.
    pub samples: Option<u32>,
    /// The output to compare; `None` for the first encoded one, or the first.
    pub output: Option<String>,
    /// The display on which differences are seen; `None` for that of the output's range.
    pub display: Option<Display>,
    /// Measures only the tiers.
    pub tiers_only: bool,
    /// A folder for images of the errors.
    pub error_images: Option<PathBuf>,
}

/// Measures all variants of a pipeline on all images.
///
/// # Errors
/// Images that cannot be read or do not fit the pipeline, and errors of the device.
pub fn measure(
    gpu: &Gpu,
    registry: &Registry,
    pipeline: &Pipeline,
    options: &MeasureOptions,
    progress: &dyn Progress,
) -> Result<MeasureReport, LabError> {
    if let Some(folder) = &options.error_images {
        make_folder(folder)?;
    }
    let mut measurement = Measurement::new(gpu, pipeline, options, progress)?;
    let sources = sequences::sources(&options.sequences, &pipeline.written)?;
    let mut report = measurement.report(gpu, registry, &sources)?;
    report.mark_pareto();
    Ok(report)
}

/// Rounds in which the time of each variant is measured, with a part of the samples each.
const ROUNDS: u32 = 2;

/// The state of a measurement.
struct Measurement<'a> {
    pipeline: &'a Pipeline,
    options: &'a MeasureOptions,
    output: &'a str,
    view: View,
    display: Display,
    runner: SequenceRunner,
    progress: &'a dyn Progress,
}

impl<'a> Measurement<'a> {
    fn new(
        gpu: &Gpu,
        pipeline: &'a Pipeline,
        options: &'a MeasureOptions,
        progress: &'a dyn Progress,
    ) -> Result<Self, LabError> {
        let written = &pipeline.written;
        let output = reference::output(written, options.output.as_deref())?;
        let view = View::of(written, output)?;
        let runner = SequenceRunner::new(gpu, written, options.facts.clone(), options.options, options.samples)?;
        let display = options.display.unwrap_or(Display::of(view.range()));
        Ok(Self { pipeline, options, output: &output.name, view, display, runner, progress })
    }

    fn report(
        &mut self,
        gpu: &Gpu,
        registry: &Registry,
        sources: &[SequenceSource],
    ) -> Result<MeasureReport, LabError> {
        let mut all = variants(self.pipeline)?;
        all.retain(|variant| !(self.options.tiers_only && variant.kind.is_switch()));
        let (mut rows, mut sequences, mut without_effect) = (Vec::new(), Vec::new(), Vec::new());
        for source in sources {
            let sequence =
                load(source, gpu, registry, &mut self.runner, &self.pipeline.written, &self.options.sequences)?;
            if sequences.is_empty() {
                (all, without_effect) = with_effect(all, &mut self.runner, &sequence)?;
                rows = all.iter().map(|variant| Row::new(&variant.name, variant.kind)).collect();
                self.progress.expect((1 + u64::from(self.rounds())) * (all.len() * sources.len()) as u64);
            }
            self.sequence(&all, &sequence, &mut rows)?;
            sequences.push(info(&sequence));
        }
        Ok(MeasureReport {
            pipeline: self.pipeline.name.clone(),
            output: self.output.to_owned(),
            range: self.view.range(),
            display: self.display,
            adapter: gpu.name(),
            clock: self.runner.clock.source(),
            samples: self.runner.samples(),
            sequences,
            rows,
            without_effect,
        })
    }

    /// Measures all variants on one sequence; the first is the reference. Equal plans are measured once. Times come
    /// last, so that the GPU stays warm between them, in two rounds of opposite order, so that a drift is not taken for
    /// a difference.
    fn sequence(&mut self, variants: &[Variant], sequence: &TestSequence, rows: &mut [Row]) -> Result<(), LabError> {
        let measured_as = self.equal_plans(variants, sequence)?;
        let mut reference: Option<Reference> = None;
        let mut errors: Vec<Errors> = Vec::new();
        for (at, variant) in variants.iter().enumerate() {
            self.progress.begin(&format!("{}: errors of {}", sequence.name, variant.name));
            errors.push(match &reference {
                Some(_) if measured_as[at] < at => errors[measured_as[at]],
                Some(reference) => {
                    self.load_compared(variant, sequence)?;
                    self.errors(reference, variant, sequence)?
                }
                None => {
                    self.load_compared(variant, sequence)?;
                    reference = Some(Reference::render(&mut self.runner.session, sequence, self.view, self.output)?);
                    Errors::none(sequence.len())
                }
            });
            self.progress.end();
        }
        let mut costs: Vec<Option<Cost>> = vec![None; variants.len()];
        for round in 0..self.rounds() {
            for step in 0..variants.len() {
                let at = if round % 2 == 0 { step } else { variants.len() - 1 - step };
                self.progress.begin(&format!("{}: time of {}", sequence.name, variants[at].name));
                if measured_as[at] == at {
                    self.runner.load(&variants[at].graph, sequence, variants[at].is_exact())?;
                    // Together they are all samples.
                    let samples = (self.runner.samples() + round) / self.rounds();
                    let cost = self.runner.cost(sequence, samples)?;
                    costs[at] = Some(costs[at].map_or(cost, |before| before.joined(cost)));
                }
                self.progress.end();
            }
        }
        for (at, row) in rows.iter_mut().enumerate() {
            let cost = costs[measured_as[at]].expect("the first of equal plans is measured");
            row.sequences.push(Figures { cost, errors: errors[at] });
            row.measured_as.push(measured_as[at]);
        }
        Ok(())
    }

    fn rounds(&self) -> u32 {
        ROUNDS.min(self.runner.samples())
    }

    /// For each variant the first one with the same plan. The reference is compared with none.
    fn equal_plans(&mut self, variants: &[Variant], sequence: &TestSequence) -> Result<Vec<usize>, LabError> {
        let (mut plans, mut first): (Vec<Arc<Plan>>, Vec<usize>) = (Vec::new(), Vec::new());
        for (at, variant) in variants.iter().enumerate() {
            let plan = self.runner.plan(&variant.graph, sequence, variant.is_exact())?;
            let known = (1..at).find(|known| sequence_runner::run_alike(&plans[*known], &plan));
            first.push(known.unwrap_or(at));
            plans.push(plan);
        }
        Ok(first)
    }

    /// Loads a variant whose output is compared before it is quantized.
    fn load_compared(&mut self, variant: &Variant, sequence: &TestSequence) -> Result<(), LabError> {
        let graph = reference::before_quantization(&variant.graph, self.output);
        self.runner.load(&graph, sequence, variant.is_exact()).map(drop)
    }

    fn errors(
        &mut self,
        reference: &Reference,
        variant: &Variant,
        sequence: &TestSequence,
    ) -> Result<Errors, LabError> {
        let folder = self.options.error_images.as_deref();
        reference.errors(&mut self.runner.session, sequence, self.view, &self.display, |frame, shown| match folder {
            Some(folder) => {
                let number = if sequence.len() > 1 { format!("-{frame:04}") } else { String::new() };
                let name = format!("{}{number}-{}.png", file_name(&sequence.name), file_name(&variant.name));
                error_image::write(&folder.join(name), &reference.frames[frame], shown)
            }
            None => Ok(()),
        })
    }
}

/// Loads a sequence; a still image is repeated if the pipeline has histories.
pub(crate) fn load(
    source: &SequenceSource,
    gpu: &Gpu,
    registry: &Registry,
    runner: &mut SequenceRunner,
    graph: &Graph,
    options: &SequenceOptions,
) -> Result<TestSequence, LabError> {
    let sequence = source.load(gpu, registry, graph, options)?;
    if sequence.len() > 1 {
        return Ok(sequence);
    }
    let frames = sequence_runner::frames_of_still(&*runner.plan(graph, &sequence, false)?, options.walk);
    Ok(sequence.repeated(frames, options.fps))
}

fn info(sequence: &TestSequence) -> SequenceInfo {
    SequenceInfo {
        name: sequence.name.clone(),
        width: sequence.size.width,
        height: sequence.size.height,
        frames: sequence.len(),
        still: sequence.is_still(),
    }
}

/// The variants whose plan differs from that of the file as it is, and the names of the others.
fn with_effect(
    all: Vec<Variant>,
    runner: &mut SequenceRunner,
    sequence: &TestSequence,
) -> Result<(Vec<Variant>, Vec<String>), LabError> {
    let mut written: Option<Arc<Plan>> = None;
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for variant in all {
        let plan = runner.plan(&variant.graph, sequence, variant.is_exact())?;
        let is_same = written.as_ref().is_some_and(|written| sequence_runner::run_alike(written, &plan));
        if variant.kind.is_switch() && is_same {
            without.push(variant.name);
            continue;
        }
        if variant.kind == VariantKind::Written {
            written = Some(plan);
        }
        with.push(variant);
    }
    Ok((with, without))
}
