//! The choice of quality switches with the smallest error within a time, or the shortest time within an error.

mod search;
mod space;
mod state;

use std::path::Path;

use afterimage_gpu::{ClockSource, Gpu};
use afterimage_graph::check::Graph;
use afterimage_graph::node::Registry;

pub use crate::measure::variants::changes;
pub use search::{Measured, TuneTarget};

use search::search;
use space::Space;
use state::SearchState;

use crate::measure::clips::{self, Clip};
use crate::measure::player::Player;
use crate::measure::reference::{self, Reference};
use crate::measure::variants::most_accurate;
use crate::measure::view::View;
use crate::measure::{MeasureOptions, load};
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
    /// The number of measured choices.
    pub choices: usize,
}

/// Searches the choices of a pipeline's quality switches. `state` is a file of figures: a search that was interrupted
/// continues from it.
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
    let (choice, measured) =
        search(&space, target, &mut |choice, left| measurer.measured(&space, choice, left, &mut state, progress))?;
    if !target.is_met(&measured) {
        return Err(unreachable_target(target, &measured));
    }
    let graph = space.graph(&pipeline.written, &choice);
    Ok(Tuned { graph, measured, conditions: measurer.conditions(), choices: state.len() })
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
        Ok(Self { player, written, view, clips: ready, reference_hashes, adapter: gpu.name(), measured: 0 })
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

    /// The figures of a choice, from the state or measured. `left` is the number of choices that may be left with it.
    fn measured(
        &mut self,
        space: &Space,
        choice: &[usize],
        left: usize,
        state: &mut SearchState,
        progress: &dyn Progress,
    ) -> Result<Measured, LabError> {
        let name = space.key(choice);
        if let Some(known) = state.get(&name) {
            return Ok(known);
        }
        progress.expect(self.measured + left as u64);
        self.measured += 1;
        progress.begin(&name);
        let graph = space.graph(self.written, choice);
        let mut worst: Option<Measured> = None;
        for (clip, reference) in &self.clips {
            let compared = reference::before_quantization(&graph, reference.output());
            self.player.load(&compared, clip, false)?;
            let (p999, max) = reference.errors_in_codes(&mut self.player, clip, self.view)?;
            self.player.load(&graph, clip, false)?;
            let cost = self.player.cost(clip)?;
            let here = Measured { ms: cost.time.ms(), p999, p999_without_worst: None, max, bytes: cost.bytes };
            worst = Some(worst.map_or(here, |worst| worst.worst(here)));
        }
        let measured = worst.expect("there is at least one clip");
        state.insert(name, measured)?;
        progress.end();
        Ok(measured)
    }

    /// Clock, adapter and images of the figures.
    fn conditions(&self) -> String {
        let clock = if self.player.clock_source() == ClockSource::Gpu { "GPU time" } else { "host time" };
        let images: Vec<String> =
            self.clips.iter().map(|(clip, _)| format!("{} at {}", clip.name, clip.size)).collect();
        format!("{clock} on {}; worst of: {}", self.adapter, images.join(", "))
    }
}
