//! Errors and time of one choice after another, on all sequences.

use std::collections::BTreeMap;

use afterimage_gpu::{ClockSource, FrameTime, Gpu};
use afterimage_graph::check::Graph;
use afterimage_graph::node::Registry;
use afterimage_plan::PlanHash;
use serde::{Deserialize, Serialize};

use super::space::Space;
use super::steps::Steps;
use super::target::Measured;
use crate::LabError;
use crate::measure::reference::{self, CodeErrors, Reference};
use crate::measure::sequence_runner::{SequenceRunner, reads_earlier_images};
use crate::measure::sequences::{self, TestSequence};
use crate::measure::variants::most_accurate;
use crate::measure::view::View;
use crate::measure::{Cost, Errors, MeasureOptions, images, load};
use crate::metrics::Display;

#[derive(Clone, Debug)]
pub struct TunePipeline {
    /// The graph whose switches are searched.
    pub written: Graph,
    /// The graph that errors are measured against: without the compromises of a tier.
    pub ideal: Graph,
    /// Names and values of the facts, as the user gave them. They are part of the search's identity.
    pub facts: Vec<String>,
}

/// A sequence with its reference.
struct Picture {
    sequence: TestSequence,
    reference: Reference,
    /// The hash of the reference's plan.
    plan: String,
    /// The search sees it; otherwise it confirms what the search finds.
    is_searched: bool,
    /// The frames that the search sees, from the first. Of a still image that is one, unless earlier images are read:
    /// the others confirm.
    searched_frames: usize,
}

/// A choice on all pictures, also on those that the search does not see.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Confirmed {
    pub(super) measured: Measured,
    /// The name of the picture where the 99.9th percentile is largest.
    pub(super) worst: String,
}

/// All pictures, and what was measured on them.
pub(super) struct ChoiceMeasurer<'a> {
    runner: SequenceRunner,
    written: &'a Graph,
    pub(super) space: Space,
    view: View,
    pub(super) display: Display,
    pictures: Vec<Picture>,
    /// Samples of the time of each choice.
    pub(super) samples: u32,
    adapter: String,
    /// The cost of each plan for the largest image, by its hash: equal choices share it.
    costs: BTreeMap<PlanHash, Cost>,
}

impl<'a> ChoiceMeasurer<'a> {
    /// Loads the sequences and renders their references. The search sees some of them only.
    pub(super) fn prepare(
        gpu: &Gpu,
        registry: &Registry,
        pipeline: &'a TunePipeline,
        options: &MeasureOptions,
        steps: &mut Steps<'_>,
    ) -> Result<Self, LabError> {
        let written = &pipeline.written;
        let output = reference::output(written, options.output.as_deref())?;
        let view = View::of(written, output)?;
        let exact = reference::before_quantization(&most_accurate(&pipeline.ideal)?, &output.name);
        let mut runner = SequenceRunner::new(gpu, written, options.facts.clone(), options.options, options.samples)?;
        let sources = sequences::sources(&options.sequences, written)?;
        let mut sequences = Vec::new();
        for source in &sources {
            sequences.push(load(source, gpu, registry, &mut runner, written, &options.sequences)?);
        }
        let samples = runner.samples();
        let space = Space::new(written, &mut |graph| runner.plan(graph, &sequences[0], false))?;
        steps.add(sequences.len() as u64);
        steps.add_search(&space.sizes());
        let mut pictures = Vec::with_capacity(sequences.len());
        for (sequence, is_searched) in sequences.into_iter().zip(sequences::searched(&sources)) {
            let (plan, reference) = steps.run(&format!("reference of {}", sequence.name), || {
                let plan = runner.load(&exact, &sequence, true)?;
                Ok((plan, Reference::render(&mut runner.session, &sequence, view, &output.name)?))
            })?;
            let searched_frames = if sequence.is_still() && !reads_earlier_images(&plan) { 1 } else { sequence.len() };
            let plan = plan.hash().to_string();
            pictures.push(Picture { sequence, reference, plan, is_searched, searched_frames });
        }
        let (display, adapter) = (options.display.unwrap_or(Display::of(view.range())), gpu.name());
        Ok(Self { runner, written, space, view, display, pictures, samples, adapter, costs: BTreeMap::new() })
    }

    /// The settings on which the figures depend: a search with another identity cannot use them.
    pub(super) fn identity(&mut self, pipeline: &TunePipeline) -> Result<serde_json::Value, LabError> {
        let exact = self.graph(&self.space.most_accurate());
        let mut images = Vec::new();
        for Picture { sequence, reference, plan, is_searched, .. } in &self.pictures {
            let hash = self.runner.plan(&exact, sequence, false)?.hash().to_string();
            images.push(serde_json::json!({
                "image": sequence.name,
                "frames": reference.frames.len(),
                "searched": is_searched,
                "plan": hash,
                "reference": plan,
            }));
        }
        Ok(serde_json::json!({
            "adapter": self.adapter,
            "clock": self.runner.clock.source().name(),
            "switches": self.space.names(),
            "facts": pipeline.facts,
            "images": images,
        }))
    }

    /// The pipeline with that choice.
    pub(super) fn graph(&self, choice: &[usize]) -> Graph {
        self.space.graph(self.written, choice)
    }

    /// The conditions of a claim: adapter, size, clock and images. `worst` is the image of the largest error.
    pub(super) fn conditions(&self, worst: &str) -> String {
        let clock = if self.runner.clock.source() == ClockSource::Gpu { "GPU time" } else { "host time" };
        let on = format!("{} at {}, {clock}", self.adapter, self.pictures[self.largest()].sequence.size);
        if let [_] = self.pictures.as_slice() {
            return format!("{on}; errors a tenth above those of {worst}");
        }
        let new = self.pictures.iter().filter(|picture| !picture.is_searched).count();
        let all = images(self.pictures.iter().map(|picture| picture.sequence.is_still()));
        format!("{on}; errors a tenth above the worst of {all}, {new} of them new to the search: {worst}")
    }

    /// The picture of the most pixels.
    fn largest(&self) -> usize {
        let pixels = |at: &usize| {
            let size = self.pictures[*at].sequence.size;
            u64::from(size.width) * u64::from(size.height)
        };
        (0..self.pictures.len()).max_by_key(pixels).expect("there is at least one picture")
    }

    /// Measures a choice: the worst errors of the pictures that the search sees, and what it costs on the largest.
    pub(super) fn measured(&mut self, choice: &[usize]) -> Result<Measured, LabError> {
        let errors = self.errors(choice, true)?;
        let graph = self.graph(choice);
        let sequence = &self.pictures[self.largest()].sequence;
        let plan = self.runner.load(&graph, sequence, false)?.hash();
        let Cost { time, bytes, bytes_moved, .. } = match self.costs.get(&plan) {
            Some(known) => *known,
            None => {
                let cost = self.runner.cost(sequence, self.samples)?;
                *self.costs.entry(plan).or_insert(cost)
            }
        };
        Ok(Measured { ms: time.ms(), bytes, bytes_moved, ..worst(&errors) })
    }

    /// Measures the errors of a choice on all pictures; `seen` are those that the search saw, and the cost.
    pub(super) fn confirmed(&mut self, choice: &[usize], seen: &Measured) -> Result<Confirmed, LabError> {
        let errors = self.errors(choice, false)?;
        let mut at = 0;
        for (other, error) in errors.iter().enumerate() {
            if error.p999 > errors[at].p999 {
                at = other;
            }
        }
        let Measured { ms, bytes, bytes_moved, .. } = *seen;
        let measured = Measured { ms, bytes, bytes_moved, ..worst(&errors) };
        Ok(Confirmed { measured, worst: self.pictures[at].sequence.name.clone() })
    }

    /// The time of a choice on the largest image, with the share of the samples of one of `parts`.
    pub(super) fn time(&mut self, choice: &[usize], parts: u32) -> Result<FrameTime, LabError> {
        let graph = self.graph(choice);
        let sequence = &self.pictures[self.largest()].sequence;
        self.runner.load(&graph, sequence, false)?;
        Ok(self.runner.cost(sequence, self.runner.samples().div_ceil(parts))?.time)
    }

    /// All errors of a choice, the visible differences among them, on the pictures where each is largest.
    pub(super) fn all_errors(&mut self, choice: &[usize]) -> Result<Errors, LabError> {
        let graph = self.graph(choice);
        let mut worst = Errors::NONE;
        for Picture { sequence, reference, .. } in &self.pictures {
            let compared = reference::before_quantization(&graph, reference.output());
            self.runner.load(&compared, sequence, false)?;
            let session = &mut self.runner.session;
            worst = worst.worst(reference.errors(session, sequence, self.view, &self.display, |_, _| Ok(()))?);
        }
        Ok(worst)
    }

    /// The errors of a choice on each sequence, or on the sequences and frames that the search sees.
    fn errors(&mut self, choice: &[usize], only_searched: bool) -> Result<Vec<CodeErrors>, LabError> {
        let graph = self.graph(choice);
        let (mut errors, mut loaded): (Vec<CodeErrors>, Option<&TestSequence>) = (Vec::new(), None);
        for Picture { sequence, reference, searched_frames, .. } in
            self.pictures.iter().filter(|picture| picture.is_searched || !only_searched)
        {
            if loaded.is_some_and(|loaded| loaded.is_like(sequence)) {
                self.runner.session.restart();
            } else {
                let compared = reference::before_quantization(&graph, reference.output());
                self.runner.load(&compared, sequence, false)?;
                loaded = Some(sequence);
            }
            let frames = if only_searched { *searched_frames } else { sequence.len() };
            errors.push(reference.code_errors(&mut self.runner.session, sequence, self.view, frames)?);
        }
        Ok(errors)
    }
}

/// The worst errors of all sequences, without costs.
fn worst(errors: &[CodeErrors]) -> Measured {
    let one = |errors: &CodeErrors| Measured { p999: errors.p999, max: errors.max, ..Measured::default() };
    errors.iter().map(one).reduce(Measured::worst).expect("there is at least one sequence")
}
