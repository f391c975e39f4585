//! One choice after another on all clips: errors, predicted errors, time.

use std::collections::BTreeMap;

use afterimage_gpu::{ClockSource, FrameTime, Gpu};
use afterimage_graph::check::Graph;
use afterimage_graph::node::Registry;
use afterimage_plan::PlanHash;

use super::prediction::SignedErrors;
use super::search::Measured;
use super::space::{Space, changed, only, singles};
use super::steps::Steps;
use crate::LabError;
use crate::measure::clips::{self, Clip};
use crate::measure::errors::SHARE;
use crate::measure::player::Player;
use crate::measure::reference::{self, Reference};
use crate::measure::variants::most_accurate;
use crate::measure::view::View;
use crate::measure::{MeasureOptions, load};
use crate::metrics::percentile;

/// The 99.9th percentile and the largest error on a clip, in codes.
pub(super) type ClipError = (f64, f64);

/// Clips are named in the conditions of figures up to this number.
const MAX_NAMED: usize = 3;

#[derive(Clone, Debug)]
pub struct TunePipeline {
    /// The graph whose switches are searched.
    pub written: Graph,
    /// The graph that errors are measured against: without the compromises of a tier.
    pub ideal: Graph,
    /// Names and values of the facts, as the user gave them. They are part of the search's identity.
    pub facts: Vec<String>,
}

/// All clips with their references.
pub(super) struct ClipMeasurer<'a> {
    player: Player,
    written: &'a Graph,
    pub(super) space: Space,
    view: View,
    clips: Vec<(Clip, Reference)>,
    /// The hashes of the reference plans, one for each clip.
    reference_hashes: Vec<String>,
    adapter: String,
    /// The time and the bytes of each plan for the largest image, by its hash: equal choices share them.
    costs: BTreeMap<PlanHash, (f64, u64)>,
    /// The errors of the most accurate choice, of choices of one switch, and of pairs that interact.
    errors: BTreeMap<Vec<usize>, SignedErrors>,
}

impl<'a> ClipMeasurer<'a> {
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
        let mut player = Player::new(gpu, written, options.facts.clone(), options.options, options.samples)?;
        let mut clips = Vec::new();
        for source in clips::sources(&options.clips, written)? {
            clips.push(load(&source, gpu, registry, &mut player, written, &options.clips)?);
        }
        let space = Space::new(written, &mut |graph| player.plan(graph, &clips[0], false))?;
        let (parts, count) = (space.parts(written), clips.len());
        let (mut reference_hashes, mut ready) = (Vec::new(), Vec::new());
        for (at, clip) in clips.into_iter().enumerate() {
            let reference = steps.run(&format!("reference of {}", clip.name), (count - at) as u64 + parts, || {
                reference_hashes.push(player.load(&exact, &clip, true)?.hash().to_string());
                Reference::render(&mut player, &clip, view, &output.name)
            })?;
            ready.push((clip, reference));
        }
        Ok(Self {
            player,
            written,
            space,
            view,
            clips: ready,
            reference_hashes,
            adapter: gpu.name(),
            costs: BTreeMap::new(),
            errors: BTreeMap::new(),
        })
    }

    /// What the figures depend on: a search with another identity cannot use them.
    pub(super) fn identity(&mut self, pipeline: &TunePipeline) -> Result<serde_json::Value, LabError> {
        let exact = self.graph(&self.space.most_accurate());
        let mut images = Vec::new();
        for (clip, reference) in &self.clips {
            let hash = self.player.plan(&exact, clip, false)?.hash().to_string();
            let frames = reference.frames.len();
            images.push(serde_json::json!({ "image": clip.name, "frames": frames, "plan": hash }));
        }
        Ok(serde_json::json!({
            "adapter": self.adapter,
            "clock": self.player.clock_source().name(),
            "switches": self.space.names(),
            "facts": pipeline.facts,
            "images": images,
            "references": self.reference_hashes,
        }))
    }

    /// The pipeline with that choice.
    pub(super) fn graph(&self, choice: &[usize]) -> Graph {
        self.space.graph(self.written, choice)
    }

    pub(super) fn clip_names(&self) -> impl Iterator<Item = &str> {
        self.clips.iter().map(|(clip, _)| clip.name.as_str())
    }

    /// Clock, adapter and images of the figures.
    pub(super) fn conditions(&self) -> String {
        let clock = if self.player.clock_source() == ClockSource::Gpu { "GPU time" } else { "host time" };
        let images = if self.clips.len() > MAX_NAMED {
            format!("{} images of at most {}", self.clips.len(), self.clips[self.largest()].0.size)
        } else {
            let names = self.clips.iter().map(|(clip, _)| format!("{} at {}", clip.name, clip.size));
            names.collect::<Vec<_>>().join(", ")
        };
        format!("{clock} on {}; worst of {images}", self.adapter)
    }

    /// The clip of the most pixels.
    fn largest(&self) -> usize {
        let pixels = |at: &usize| u64::from(self.clips[*at].0.size.width) * u64::from(self.clips[*at].0.size.height);
        (0..self.clips.len()).max_by_key(pixels).expect("there is at least one clip")
    }

    /// Measures a choice: the worst errors of all clips, and what it costs on the largest image.
    pub(super) fn measured(&mut self, choice: &[usize]) -> Result<Measured, LabError> {
        let errors = self.measured_errors(choice)?;
        let graph = self.graph(choice);
        let clip = &self.clips[self.largest()].0;
        let plan = self.player.load(&graph, clip, false)?.hash();
        let (ms, bytes) = match self.costs.get(&plan) {
            Some(known) => *known,
            None => {
                let cost = self.player.cost(clip, self.player.samples())?;
                *self.costs.entry(plan).or_insert((cost.time.ms(), cost.bytes))
            }
        };
        Ok(Measured { ms, bytes, ..worst(&errors) })
    }

    /// The time of a choice on the largest image, with the share of the samples of one of `parts`.
    pub(super) fn time(&mut self, choice: &[usize], parts: u32) -> Result<FrameTime, LabError> {
        let graph = self.graph(choice);
        let clip = &self.clips[self.largest()].0;
        self.player.load(&graph, clip, false)?;
        Ok(self.player.cost(clip, self.player.samples().div_ceil(parts))?.time)
    }

    /// The visible difference of a choice, FLIP, on the clip where it is largest.
    pub(super) fn flip(&mut self, choice: &[usize]) -> Result<f64, LabError> {
        let graph = self.graph(choice);
        let mut worst = 0.0_f64;
        for (clip, reference) in &self.clips {
            let compared = reference::before_quantization(&graph, reference.output());
            self.player.load(&compared, clip, false)?;
            worst = worst.max(reference.flip(&mut self.player, clip, self.view)?);
        }
        Ok(worst)
    }

    /// The errors of each clip. The images that predictions add are kept.
    pub(super) fn measured_errors(&mut self, choice: &[usize]) -> Result<Vec<ClipError>, LabError> {
        let graph = self.graph(choice);
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
        if singles(choice).len() < 2 || self.is_pair(choice) {
            self.errors.insert(choice.to_vec(), SignedErrors::new(&images));
        }
        Ok(figures)
    }

    /// The choices whose errors a prediction adds, and that are not measured.
    pub(super) fn missing_parts(&self, choice: &[usize]) -> Vec<Vec<usize>> {
        let mut parts: Vec<Vec<usize>> = self.parts(choice).into_keys().collect();
        parts.push(self.space.most_accurate());
        parts.retain(|part| !self.errors.contains_key(part));
        parts
    }

    /// The most parts that any predictions may still lack.
    pub(super) fn parts_left(&self) -> u64 {
        self.space.parts(self.written) - self.errors.len() as u64
    }

    /// The errors of each clip of a choice of several switches, from the sum of their signed errors.
    ///
    /// # Panics
    /// Parts are missing.
    pub(super) fn predicted_errors(&self, choice: &[usize]) -> Vec<ClipError> {
        let parts = self.parts(choice);
        let parts: Vec<(&SignedErrors, f32)> =
            parts.iter().map(|(part, factor)| (&self.errors[part], *factor)).collect();
        SignedErrors::of_sum(&self.errors[&self.space.most_accurate()], &parts)
    }

    /// The choices whose errors are added for one, and the factor of each. The error of a pair that interacts takes the
    /// place of the sum of both.
    fn parts(&self, choice: &[usize]) -> BTreeMap<Vec<usize>, f32> {
        let changed = changed(choice);
        let mut parts: BTreeMap<Vec<usize>, f32> = BTreeMap::new();
        for (at, a) in changed.iter().enumerate() {
            *parts.entry(only(choice, &[*a])).or_default() += 1.0;
            for b in changed[at + 1..].iter().filter(|b| self.space.interact(self.written, *a, **b)) {
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
    fn is_pair(&self, choice: &[usize]) -> bool {
        matches!(changed(choice)[..], [a, b] if self.space.interact(self.written, a, b))
    }
}

/// The worst errors of all clips, without costs.
pub(super) fn worst(errors: &[ClipError]) -> Measured {
    let one = |(p999, max): &ClipError| Measured {
        ms: 0.0,
        p999: *p999,
        p999_without_worst: None,
        max: *max,
        bytes: 0,
        is_predicted: false,
    };
    errors.iter().map(one).reduce(Measured::worst).expect("there is at least one clip")
}
