//! The choice of quality switches with the smallest error within a time, or the shortest time within an error.

mod prediction;
mod random;
mod search;
mod space;
mod state;

use std::collections::BTreeMap;
use std::path::Path;

use afterimage_gpu::{ClockSource, Gpu};
use afterimage_graph::check::Graph;
use afterimage_graph::node::Registry;
use afterimage_plan::PlanHash;

pub use crate::measure::variants::changes;
pub use random::{PredictedError, random_errors};
pub use search::{Measured, TuneTarget};

use prediction::SignedErrors;
use search::search;
use space::Space;
use state::SearchState;

use crate::measure::clips::{self, Clip};
use crate::measure::errors::SHARE;
use crate::measure::player::Player;
use crate::measure::reference::{self, Reference};
use crate::measure::variants::most_accurate;
use crate::measure::view::View;
use crate::measure::{MeasureOptions, load};
use crate::metrics::percentile;
use crate::{LabError, Progress};

#[derive(Clone, Debug)]
pub struct TunePipeline {
    /// The graph whose switches are searched.
    pub written: Graph,
    /// The graph that errors are measured against: without the compromises of a tier.
    pub ideal: Graph,
    /// Names and values of the facts, as the user gave them. They are part of the search's identity.
    pub facts: Vec<String>,
}

/// The result of a search.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The graph with the chosen values.
    pub graph: Graph,
    pub measured: Measured,
    /// Clock, adapter and images of the figures.
    pub conditions: String,
    /// The number of choices with figures.
    pub choices: usize,
    /// The choices whose predicted error was measured in the end.
    pub predictions: Vec<Prediction>,
}

/// An error that the search relied on, beside what it is: 99.9th percentiles, in codes.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The switches that are not at their most accurate.
    pub choice: String,
    pub predicted: f64,
    pub measured: f64,
}

/// Finalists that are measured at most: from then on no error is predicted.
const MAX_FINALISTS: usize = 16;
/// A measured error may exceed the predicted one by this factor and this number of codes.
const MAX_EXCESS: f64 = 1.2;
const MIN_EXCESS_CODES: f64 = 0.05;

/// Searches the choices of a pipeline's quality switches. Times are measured, and the errors of single switches. The
/// error of several is predicted as that of their signed sum, and measured for the choice that is found. If that has a
/// larger error, the search goes on. `state` is a file of figures: a search that was interrupted continues from it.
///
/// # Errors
/// No choice meets the target; and everything that a measurement reports.
pub fn tune(
    gpu: &Gpu,
    registry: &Registry,
    pipeline: &TunePipeline,
    options: &MeasureOptions,
    target: TuneTarget,
    state: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Tuned, LabError> {
    let mut measurer = ClipMeasurer::prepare(gpu, registry, pipeline, options)?;
    let space = measurer.space()?;
    let mut state = SearchState::open(state, measurer.identity(pipeline, &space)?)?;
    let mut predictions = Vec::new();
    let (choice, measured) = loop {
        let (choice, found) =
            search(&space, target, &mut |choice, left| measurer.figures(&space, choice, left, &mut state, progress))?;
        if !found.is_predicted {
            break (choice, found);
        }
        let measured = measurer.verified(&space, &choice, found, &mut state)?;
        predictions.push(Prediction { choice: space.key(&choice), predicted: found.p999, measured: measured.p999 });
        let is_as_predicted = measured.p999 <= MAX_EXCESS * found.p999 + MIN_EXCESS_CODES;
        if is_as_predicted && target.is_met(&measured) {
            break (choice, measured);
        }
        measurer.predicts = predictions.len() < MAX_FINALISTS;
    };
    if !target.is_met(&measured) {
        return Err(unreachable_target(target, &measured));
    }
    let graph = space.graph(&pipeline.written, &choice);
    Ok(Tuned { graph, measured, conditions: measurer.conditions(), choices: state.len(), predictions })
}

fn unreachable_target(target: TuneTarget, best: &Measured) -> LabError {
    let reached = format!("the closest choice takes {:.3} ms and has an error of {:.3} codes", best.ms, best.p999);
    LabError::request(format!("no choice of the quality switches stays {target}: {reached}")).hint(match target {
        TuneTarget::Budget(_) => "allow more time, or change what the pipeline does: fewer levels, a smaller image",
        TuneTarget::Error(_) => "allow more error; what is left comes from half-float intermediates",
    })
}

/// All clips with their references, to measure one choice after another.
struct ClipMeasurer<'a> {
    player: Player,
    written: &'a Graph,
    view: View,
    clips: Vec<(Clip, Reference)>,
    /// The hashes of the reference plans, one for each clip.
    reference_hashes: Vec<String>,
    adapter: String,
    /// Choices that were measured and not known from the state.
    measured: u64,
    /// Whether errors of several switches are predicted.
    predicts: bool,
    /// The time and the bytes of each plan, by its hash: images of one size and equal choices share them.
    costs: BTreeMap<PlanHash, (f64, u64)>,
    /// The errors of the most accurate choice and of choices of one switch.
    errors: BTreeMap<Vec<usize>, SignedErrors>,
}

impl<'a> ClipMeasurer<'a> {
    fn prepare(
        gpu: &Gpu,
        registry: &Registry,
        pipeline: &'a TunePipeline,
        options: &MeasureOptions,
    ) -> Result<Self, LabError> {
        let written = &pipeline.written;
        let output = reference::output(written, options.output.as_deref())?;
        let view = View::of(written, output)?;
        let exact = reference::before_quantization(&most_accurate(&pipeline.ideal)?, &output.name);
        let mut player = Player::new(gpu, written, options.facts.clone(), options.options, options.samples)?;
        let (mut reference_hashes, mut ready) = (Vec::new(), Vec::new());
        for source in clips::sources(&options.clips, written)? {
            let clip = load(&source, gpu, registry, &mut player, written, &options.clips)?;
            reference_hashes.push(player.load(&exact, &clip, true)?.hash().to_string());
            let reference = Reference::render(&mut player, &clip, view, &output.name)?;
            ready.push((clip, reference));
        }
        Ok(Self {
            player,
            written,
            view,
            clips: ready,
            reference_hashes,
            adapter: gpu.name(),
            measured: 0,
            predicts: true,
            costs: BTreeMap::new(),
            errors: BTreeMap::new(),
        })
    }

    fn space(&mut self) -> Result<Space, LabError> {
        let Self { player, written, clips, .. } = self;
        Space::new(written, &mut |graph| player.plan(graph, &clips[0].0, false))
    }

    /// What the figures depend on: a search with another identity cannot use them.
    fn identity(&mut self, pipeline: &TunePipeline, space: &Space) -> Result<serde_json::Value, LabError> {
        let exact = space.graph(self.written, &space.most_accurate());
        let mut images = Vec::new();
        for (clip, reference) in &self.clips {
            let hash = self.player.plan(&exact, clip, false)?.hash().to_string();
            let frames = reference.frames.len();
            images.push(serde_json::json!({ "image": clip.name, "frames": frames, "plan": hash }));
        }
        Ok(serde_json::json!({
            "adapter": self.adapter,
            "clock": self.player.clock_source().name(),
            "switches": space.names(),
            "facts": pipeline.facts,
            "images": images,
            "references": self.reference_hashes,
        }))
    }

    /// The figures of a choice, from the state or new. `left` is the number of choices that may be left with it.
    fn figures(
        &mut self,
        space: &Space,
        choice: &[usize],
        left: usize,
        state: &mut SearchState,
        progress: &dyn Progress,
    ) -> Result<Measured, LabError> {
        let name = space.key(choice);
        if let Some(known) = state.get(&name).filter(|known| self.predicts || !known.is_predicted) {
            return Ok(known);
        }
        progress.expect(self.measured + left as u64);
        self.measured += 1;
        progress.begin(&name);
        let is_predicted = self.predicts && singles(choice).len() > 1;
        let errors =
            if is_predicted { self.predicted_errors(space, choice)? } else { self.measured_errors(space, choice)? };
        let graph = space.graph(self.written, choice);
        let mut worst: Option<Measured> = None;
        for ((clip, _), (p999, max)) in self.clips.iter().zip(errors) {
            let plan = self.player.load(&graph, clip, false)?.hash();
            let (ms, bytes) = match self.costs.get(&plan) {
                Some(known) => *known,
                None => {
                    let cost = self.player.cost(clip, self.player.samples())?;
                    *self.costs.entry(plan).or_insert((cost.time.ms(), cost.bytes))
                }
            };
            let here = Measured { ms, p999, p999_without_worst: None, max, bytes, is_predicted };
            worst = Some(worst.map_or(here, |worst| worst.worst(here)));
        }
        let figures = worst.expect("there is at least one clip");
        state.insert(name, figures)?;
        progress.end();
        Ok(figures)
    }

    /// The figures of a choice with errors that are measured in the place of predicted ones.
    fn verified(
        &mut self,
        space: &Space,
        choice: &[usize],
        found: Measured,
        state: &mut SearchState,
    ) -> Result<Measured, LabError> {
        let mut worst: Option<Measured> = None;
        for (p999, max) in self.measured_errors(space, choice)? {
            let here = Measured { p999, p999_without_worst: None, max, is_predicted: false, ..found };
            worst = Some(worst.map_or(here, |worst| worst.worst(here)));
        }
        let measured = worst.expect("there is at least one clip");
        state.insert(space.key(choice), measured)?;
        Ok(measured)
    }

    /// The 99.9th percentile and the largest error of each clip. The images that predictions
    /// add are kept.
    fn measured_errors(&mut self, space: &Space, choice: &[usize]) -> Result<Vec<(f64, f64)>, LabError> {
        let graph = space.graph(self.written, choice);
        let (mut figures, mut images) = (Vec::new(), Vec::new());
        for (clip, reference) in &self.clips {
            let compared = reference::before_quantization(&graph, reference.output());
            self.player.load(&compared, clip, false)?;
            let frames = reference.differences(&mut self.player, clip, self.view)?;
            let mut worst = (0.0_f64, 0.0_f64);
            for frame in &frames {
                let largest: Vec<f32> =
                    frame.iter().map(|pixel| pixel.map(f32::abs).into_iter().fold(0.0, f32::max)).collect();
                worst = (worst.0.max(percentile(&largest, SHARE)), worst.1.max(percentile(&largest, 1.0)));
            }
            figures.push(worst);
            images.push(frames);
        }
        if singles(choice).len() < 2 || is_pair(space, self.written, choice) {
            self.errors.insert(choice.to_vec(), SignedErrors::new(&images));
        }
        Ok(figures)
    }

    /// The same for a choice of several switches, from the sum of their signed errors.
    fn predicted_errors(&mut self, space: &Space, choice: &[usize]) -> Result<Vec<(f64, f64)>, LabError> {
        let (exact, parts) = (space.most_accurate(), parts(space, self.written, choice));
        for part in parts.keys().chain([&exact]) {
            // A search that goes on has the figures of its state, and no images.
            if !self.errors.contains_key(part) {
                self.measured_errors(space, part)?;
            }
        }
        let parts: Vec<(&SignedErrors, f32)> =
            parts.iter().map(|(part, factor)| (&self.errors[part], *factor)).collect();
        Ok(SignedErrors::of_sum(&self.errors[&exact], &parts))
    }

    /// Clock, adapter and images of the figures.
    fn conditions(&self) -> String {
        let clock = if self.player.clock_source() == ClockSource::Gpu { "GPU time" } else { "host time" };
        let images: Vec<String> =
            self.clips.iter().map(|(clip, _)| format!("{} at {}", clip.name, clip.size)).collect();
        format!("{clock} on {}; worst of: {}", self.adapter, images.join(", "))
    }
}

/// The choices of one switch that make up a choice.
fn singles(choice: &[usize]) -> Vec<Vec<usize>> {
    changed(choice).into_iter().map(|switch| only(choice, &[switch])).collect()
}

/// The choices whose errors are added for one, and the factor of each. The error of a pair that interacts takes the
/// place of the sum of both.
fn parts(space: &Space, graph: &Graph, choice: &[usize]) -> BTreeMap<Vec<usize>, f32> {
    let changed = changed(choice);
    let mut parts: BTreeMap<Vec<usize>, f32> = BTreeMap::new();
    for (at, a) in changed.iter().enumerate() {
        *parts.entry(only(choice, &[*a])).or_default() += 1.0;
        for b in changed[at + 1..].iter().filter(|b| space.interact(graph, *a, **b)) {
            *parts.entry(only(choice, &[*a, *b])).or_default() += 1.0;
            for switch in [a, b] {
                *parts.entry(only(choice, &[*switch])).or_default() -= 1.0;
            }
        }
    }
    parts.retain(|_, factor| *factor != 0.0);
    parts
}

/// Whether a choice changes two switches that interact.
fn is_pair(space: &Space, graph: &Graph, choice: &[usize]) -> bool {
    matches!(changed(choice)[..], [a, b] if space.interact(graph, a, b))
}

/// The switches that are not at their most accurate.
fn changed(choice: &[usize]) -> Vec<usize> {
    (0..choice.len()).filter(|switch| choice[*switch] > 0).collect()
}

/// The choice with all other switches at their most accurate.
fn only(choice: &[usize], switches: &[usize]) -> Vec<usize> {
    (0..choice.len()).map(|switch| if switches.contains(&switch) { choice[switch] } else { 0 }).collect()
}
