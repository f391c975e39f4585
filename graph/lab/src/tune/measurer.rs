//! One choice after another on all clips: errors, predicted errors, time.

use std::collections::BTreeMap;

use afterimage_gpu::{ClockSource, FrameTime, Gpu};
use afterimage_graph::check::Graph;
use afterimage_graph::node::Registry;
use afterimage_plan::PlanHash;
use serde::{Deserialize, Serialize};

use super::prediction::SignedErrors;
use super::search::Measured;
use super::space::{Space, changed, only, singles};
use super::steps::Steps;
use crate::LabError;
use crate::measure::clips::{self, Clip};
use crate::measure::errors::SHARE;
use crate::measure::player::{Player, reads_earlier_images};
use crate::measure::reference::{self, Reference};
use crate::measure::variants::most_accurate;
use crate::measure::view::View;
use crate::measure::{MeasureOptions, load};
use crate::metrics::percentile;

/// The 99.9th percentile and the largest error on a clip, in codes.
pub(super) type ClipError = (f64, f64);
/// The signed differences of each pixel of a frame from the reference, in codes.
type Frame = Vec<[f32; 3]>;

#[derive(Clone, Debug)]
pub struct TunePipeline {
    /// The graph whose switches are searched.
    pub written: Graph,
    /// The graph that errors are measured against: without the compromises of a tier.
    pub ideal: Graph,
    /// Names and values of the facts, as the user gave them. They are part of the search's identity.
    pub facts: Vec<String>,
}

/// A clip with its reference.
struct Picture {
    clip: Clip,
    reference: Reference,
    /// The hash of the reference's plan.
    plan: String,
    /// Whether the search sees it; otherwise it confirms what the search finds.
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
pub(super) struct ClipMeasurer<'a> {
    player: Player,
    written: &'a Graph,
    pub(super) space: Space,
    view: View,
    pictures: Vec<Picture>,
    /// Samples of the time of each choice.
    pub(super) samples: u32,
    adapter: String,
    /// The time and the bytes of each plan for the largest image, by its hash: equal choices share them.
    costs: BTreeMap<PlanHash, (f64, u64)>,
    /// The errors of the most accurate choice, of choices of one switch, and of pairs that interact.
    errors: BTreeMap<Vec<usize>, SignedErrors>,
}

impl<'a> ClipMeasurer<'a> {
    /// Loads the clips and renders their references. With `is_split`, the search sees some of them only.
    pub(super) fn prepare(
        gpu: &Gpu,
        registry: &Registry,
        pipeline: &'a TunePipeline,
        options: &MeasureOptions,
        is_split: bool,
        steps: &mut Steps<'_>,
    ) -> Result<Self, LabError> {
        let written = &pipeline.written;
        let output = reference::output(written, options.output.as_deref())?;
        let view = View::of(written, output)?;
        let exact = reference::before_quantization(&most_accurate(&pipeline.ideal)?, &output.name);
        let mut player = Player::new(gpu, written, options.facts.clone(), options.options, options.samples)?;
        let sources = clips::sources(&options.clips, written)?;
        let mut clips = Vec::new();
        for source in &sources {
            clips.push(load(source, gpu, registry, &mut player, written, &options.clips)?);
        }
        let samples = player.samples();
        let space = Space::new(written, &mut |graph| player.plan(graph, &clips[0], false))?;
        let (parts, count) = (space.parts(written), clips.len());
        let mut pictures = Vec::with_capacity(count);
        for (at, (clip, is_searched)) in clips.into_iter().zip(clips::searched(&sources)).enumerate() {
            let (plan, reference) =
                steps.run(&format!("reference of {}", clip.name), (count - at) as u64 + parts, || {
                    let plan = player.load(&exact, &clip, true)?;
                    Ok((plan, Reference::render(&mut player, &clip, view, &output.name)?))
                })?;
            let searched_frames = if clip.is_still() && !reads_earlier_images(&plan) { 1 } else { clip.len() };
            let (plan, is_searched) = (plan.hash().to_string(), is_searched || !is_split);
            pictures.push(Picture { clip, reference, plan, is_searched, searched_frames });
        }
        Ok(Self {
            player,
            written,
            space,
            view,
            pictures,
            samples,
            adapter: gpu.name(),
            costs: BTreeMap::new(),
            errors: BTreeMap::new(),
        })
    }

    /// What the figures depend on: a search with another identity cannot use them.
    pub(super) fn identity(&mut self, pipeline: &TunePipeline) -> Result<serde_json::Value, LabError> {
        let exact = self.graph(&self.space.most_accurate());
        let mut images = Vec::new();
        for Picture { clip, reference, plan, is_searched, .. } in &self.pictures {
            let hash = self.player.plan(&exact, clip, false)?.hash().to_string();
            images.push(serde_json::json!({
                "image": clip.name,
                "frames": reference.frames.len(),
                "searched": is_searched,
                "plan": hash,
                "reference": plan,
            }));
        }
        Ok(serde_json::json!({
            "adapter": self.adapter,
            "clock": self.player.clock_source().name(),
            "switches": self.space.names(),
            "facts": pipeline.facts,
            "images": images,
        }))
    }

    /// The pipeline with that choice.
    pub(super) fn graph(&self, choice: &[usize]) -> Graph {
        self.space.graph(self.written, choice)
    }

    /// What a claim is measured on: adapter, size, clock and images. `worst` is the image of the largest error.
    pub(super) fn conditions(&self, worst: &str) -> String {
        let clock = if self.player.clock_source() == ClockSource::Gpu { "GPU time" } else { "host time" };
        let on = format!("{} at {}, {clock}", self.adapter, self.pictures[self.largest()].clip.size);
        let count = self.pictures.len();
        if count == 1 {
            return format!("{on}; errors a tenth above those of {worst}");
        }
        let new = self.pictures.iter().filter(|picture| !picture.is_searched).count();
        format!("{on}; errors a tenth above the worst of {count} images, {new} of them new to the search: {worst}")
    }

    /// The picture of the most pixels.
    fn largest(&self) -> usize {
        let pixels = |at: &usize| {
            let size = self.pictures[*at].clip.size;
            u64::from(size.width) * u64::from(size.height)
        };
        (0..self.pictures.len()).max_by_key(pixels).expect("there is at least one picture")
    }

    /// Measures a choice: the worst errors of the pictures that the search sees, and what it costs on the largest.
    pub(super) fn measured(&mut self, choice: &[usize]) -> Result<Measured, LabError> {
        let errors = self.measured_errors(choice)?;
        let graph = self.graph(choice);
        let clip = &self.pictures[self.largest()].clip;
        let plan = self.player.load(&graph, clip, false)?.hash();
        let (ms, bytes) = match self.costs.get(&plan) {
            Some(known) => *known,
            None => {
                let cost = self.player.cost(clip, self.samples)?;
                *self.costs.entry(plan).or_insert((cost.time.ms(), cost.bytes))
            }
        };
        Ok(Measured { ms, bytes, ..worst(&errors) })
    }

    /// Measures the errors of a choice on all pictures; `seen` are those that the search saw, and the cost.
    pub(super) fn confirmed(&mut self, choice: &[usize], seen: &Measured) -> Result<Confirmed, LabError> {
        let errors: Vec<ClipError> = self.differences(choice, false)?.iter().map(|frames| clip_error(frames)).collect();
        let mut at = 0;
        for (other, (p999, _)) in errors.iter().enumerate() {
            if *p999 > errors[at].0 {
                at = other;
            }
        }
        let measured = Measured { ms: seen.ms, bytes: seen.bytes, ..worst(&errors) };
        Ok(Confirmed { measured, worst: self.pictures[at].clip.name.clone() })
    }

    /// The time of a choice on the largest image, with the share of the samples of one of `parts`.
    pub(super) fn time(&mut self, choice: &[usize], parts: u32) -> Result<FrameTime, LabError> {
        let graph = self.graph(choice);
        let clip = &self.pictures[self.largest()].clip;
        self.player.load(&graph, clip, false)?;
        Ok(self.player.cost(clip, self.player.samples().div_ceil(parts))?.time)
    }

    /// The visible difference of a choice, FLIP, on the picture where it is largest.
    pub(super) fn flip(&mut self, choice: &[usize]) -> Result<f64, LabError> {
        let graph = self.graph(choice);
        let mut worst = 0.0_f64;
        for Picture { clip, reference, .. } in &self.pictures {
            let compared = reference::before_quantization(&graph, reference.output());
            self.player.load(&compared, clip, false)?;
            worst = worst.max(reference.flip(&mut self.player, clip, self.view)?);
        }
        Ok(worst)
    }

    /// The errors of each clip that the search sees. The images that predictions add are kept.
    pub(super) fn measured_errors(&mut self, choice: &[usize]) -> Result<Vec<ClipError>, LabError> {
        let images = self.differences(choice, true)?;
        let errors = images.iter().map(|frames| clip_error(frames)).collect();
        if singles(choice).len() < 2 || self.is_pair(choice) {
            self.errors.insert(choice.to_vec(), SignedErrors::new(&images));
        }
        Ok(errors)
    }

    /// The signed differences of each frame of each clip, or of the frames and clips that the search sees.
    fn differences(&mut self, choice: &[usize], only_searched: bool) -> Result<Vec<Vec<Frame>>, LabError> {
        let graph = self.graph(choice);
        let (mut images, mut loaded): (Vec<Vec<Frame>>, Option<&Clip>) = (Vec::new(), None);
        for Picture { clip, reference, searched_frames, .. } in
            self.pictures.iter().filter(|picture| picture.is_searched || !only_searched)
        {
            if loaded.is_some_and(|loaded| loaded.is_like(clip)) {
                self.player.restart();
            } else {
                let compared = reference::before_quantization(&graph, reference.output());
                self.player.load(&compared, clip, false)?;
                loaded = Some(clip);
            }
            let frames = if only_searched { *searched_frames } else { clip.len() };
            images.push(reference.differences(&mut self.player, clip, self.view, frames)?);
        }
        Ok(images)
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

/// The worst frame of a clip.
fn clip_error(frames: &[Frame]) -> ClipError {
    let mut worst = (0.0_f64, 0.0_f64);
    for frame in frames {
        let largest: Vec<f32> = frame.iter().map(|pixel| pixel.map(f32::abs).into_iter().fold(0.0, f32::max)).collect();
        worst = (worst.0.max(percentile(&largest, SHARE)), worst.1.max(percentile(&largest, 1.0)));
    }
    worst
}

/// The worst errors of all clips, without costs.
pub(super) fn worst(errors: &[ClipError]) -> Measured {
    let one = |(p999, max): &ClipError| Measured { p999: *p999, max: *max, ..Measured::default() };
    errors.iter().map(one).reduce(Measured::worst).expect("there is at least one clip")
}
