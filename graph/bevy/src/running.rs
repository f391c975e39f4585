//! The pipeline of one camera: it follows the settings, and records frames.

use std::sync::Arc;

use afterimage::host::{BlockData, Camera, Executor, Facts, Matrix, Plan, Reading, TierLimits, Watch};
use afterimage::node::CAMERA;
use afterimage::{Error, Frame, FrameKind, Post, wgpu};
use bevy::prelude::*;
use bevy::render::camera::TemporalJitter;
use bevy::render::view::ExtractedView;

use crate::camera::Afterimage;
use crate::request::Settings;
use crate::setting::Target;
use crate::status::{Rendered, Report};

/// The pipeline of a camera.
pub(crate) struct CameraPost {
    pub(crate) post: Post,
    pub(crate) settings: Arc<Settings>,
    /// The camera in the frame before, and the block that is written for it.
    camera: Option<Camera>,
    block: BlockData,
    has_cut: bool,
    /// The values that are read back, by their labels.
    watches: Vec<(String, Watch)>,
    /// The last report, and true unless something is to be added to it.
    reported: Rendered,
    is_reported: bool,
    plan: Option<Arc<Plan>>,
}

/// The reason why the tiers of a pipeline are valid here.
const CHECKED: &str = "all tiers were checked when the pipeline was loaded";

impl CameraPost {
    /// The first camera with these settings.
    pub(crate) fn new(executor: Executor, settings: Arc<Settings>) -> Self {
        let post = Post::of_snapshot(executor, settings.pipeline.snapshot.clone(), None).expect(CHECKED);
        let nothing_set = Afterimage::new(default()).target(settings.look.target);
        let written = Settings { pipeline: settings.pipeline.clone(), look: nothing_set };
        let mut new = Self::with_post(post, written.into());
        new.set_output_linear();
        new.follow(&settings);
        new
    }

    /// The pipeline for one more camera with the same pipeline and target. Both share compiled pipelines and cached
    /// plans.
    pub(crate) fn clone_for_view(&self, settings: &Arc<Settings>) -> Self {
        let mut new = Self::with_post(self.post.clone_for_view(), self.settings.clone());
        new.follow(settings);
        new
    }

    fn with_post(post: Post, settings: Arc<Settings>) -> Self {
        let (block, reported) = (BlockData::new(&CAMERA), Rendered::default());
        let watches = Vec::new();
        Self { post, settings, camera: None, block, has_cut: true, watches, reported, is_reported: true, plan: None }
    }

    /// Bevy encodes the main texture later.
    fn set_output_linear(&mut self) {
        let Self { post, settings, .. } = self;
        if settings.look.target == Target::MainTexture {
            settings.pipeline.written.outputs.iter().for_each(|output| post.set_output_linear(output.name.clone()));
        }
    }

    /// True if it can follow these settings. An output of linear color stays one.
    pub(crate) fn suits(&self, settings: &Settings) -> bool {
        self.settings.look.target == settings.look.target
    }

    /// Takes over what has changed for the camera.
    pub(crate) fn follow(&mut self, settings: &Arc<Settings>) {
        if Arc::ptr_eq(&self.settings, settings) {
            return;
        }
        let before = std::mem::replace(&mut self.settings, settings.clone());
        self.follow_tier(&before).expect(CHECKED);
        let look = &settings.look;
        let mut refused = Vec::new();
        let mut facts = Facts::default();
        for (name, setting) in &look.facts {
            match setting.fact() {
                Some(fact) => facts.set(name.clone(), fact),
                None => refused.push(format!("`{name}` is no fact: facts are flags and numbers")),
            }
        }
        self.post.set_facts(facts);
        self.post.set_fade(look.fade);
        self.has_cut |= before.look.cuts != look.cuts;
        self.set(&before.look, &mut refused);
        self.watches = look.watched.iter().map(|label| (label.clone(), self.post.watch(label))).collect();
        refused.iter().filter(|why| !self.reported.settings.contains(why)).for_each(|why| error!("{why}"));
        if refused != self.reported.settings {
            self.reported.settings = refused;
            self.is_reported = false;
        }
    }

    /// Follows the pipeline, its tier and its budget.
    fn follow_tier(&mut self, before: &Settings) -> Result<(), Error> {
        let (settings, post) = (self.settings.clone(), &mut self.post);
        let (old, new, snapshot) = (&before.look, &settings.look, &settings.pipeline.snapshot);
        let budget = new.budget.as_ref();
        let is_new = !before.pipeline.snapshot.is_same(snapshot);
        let keeps_tiers = match (budget, &old.budget) {
            // What it has learned stays.
            (Some(new), Some(old)) => post.governor().is_some() && new.tiers == old.tiers && new.min_jod == old.min_jod,
            (Some(_), None) => false,
            (None, _) => post.governor().is_none() && post.tier() == new.tier.as_deref(),
        };
        if !keeps_tiers {
            post.replace(snapshot.clone(), new.tier.as_deref().filter(|_| budget.is_none()))?;
        } else if is_new {
            post.reload(snapshot.clone())?;
        }
        if is_new {
            self.set_output_linear();
        }
        let Some(budget) = budget else { return Ok(()) };
        match self.post.governor_mut() {
            Some(governor) => governor.set_budget(budget.ms),
            None => {
                let tiers: Vec<&str> = budget.tiers.iter().map(String::as_str).collect();
                self.post.govern(TierLimits { min_jod: budget.min_jod, ..budget.ms.into() }, &tiers)?;
            }
        }
        Ok(())
    }

    /// Sets the parameters, and those that the camera no longer sets to the values of the file.
    fn set(&mut self, before: &Afterimage, refused: &mut Vec<String>) {
        let settings = self.settings.clone();
        let parameters = &settings.look.parameters;
        let names = before.parameters.keys().filter(|name| !parameters.contains_key(*name));
        for name in parameters.keys().chain(names) {
            let result = self.post.control(name).map_err(|error| error.to_string()).and_then(|control| {
                let Some(setting) = parameters.get(name) else {
                    return self.post.unset(control).map_err(|error| error.to_string());
                };
                let graph = self.post.graph();
                let ty = graph.declaration(graph.parameter(name)?).ty;
                let value = setting.value(ty).ok_or_else(|| format!("`{name}` is {}", ty.describe()))?;
                self.post.set_value(control, value).map_err(|error| error.to_string())
            });
            // A parameter that is no longer set may be one that this pipeline never had.
            refused.extend(result.err().filter(|_| parameters.contains_key(name)));
        }
    }

    /// The block of the camera in this frame; none if its matrices have no inverse.
    pub(crate) fn look(&mut self, view: &ExtractedView, jitter: Option<&TemporalJitter>) {
        let columns = |matrix: Mat4| -> Matrix { matrix.to_cols_array_2d() };
        let still = Camera::still(columns(view.world_from_view.to_matrix().inverse()), columns(view.clip_from_view));
        let jitter = jitter.map_or([0.0; 2], |jitter| jitter.offset.to_array());
        let camera = match self.camera.filter(|_| !self.has_cut) {
            None => Camera { jitter, previous_jitter: jitter, ..still },
            Some(before) => Camera {
                previous_view: before.view,
                previous_projection: before.projection,
                previous_jitter: before.jitter,
                jitter,
                ..still
            },
        };
        self.camera = camera.write(&mut self.block).is_ok().then_some(camera);
    }

    /// Records a frame. An error is logged once; whether the frame is recorded anyway.
    pub(crate) fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>, report: &Report) -> bool {
        let Self { post, settings, block, camera, has_cut, .. } = self;
        let mut blocks = settings.pipeline.written.inputs.iter().filter(|input| input.block.is_some());
        let has_camera = camera.is_some() && blocks.any(|input| input.name == "camera");
        let blocks = &[("camera", &*block)][..usize::from(has_camera)];
        let before = post.frame();
        let error = post.encode(encoder, &Frame { blocks, kind: FrameKind::cut_if(*has_cut), ..*frame }).err();
        let is_recorded = post.frame() > before;
        self.has_cut &= !is_recorded;
        self.read_back(report);
        self.say(error.map(|error| error.to_string()), is_recorded, report);
        is_recorded
    }

    /// Passes on the newest values that have arrived.
    fn read_back(&self, report: &Report) {
        let mut sent = report.lock();
        sent.readings.retain(|label, _| self.watches.iter().any(|(known, _)| known == label));
        for (label, watch) in &self.watches {
            let reading = self.post.reading(*watch).expect("the watch is of this pipeline");
            let Some(value) = reading.and_then(Reading::value).map(Vec4::from) else { continue };
            match sent.readings.get_mut(label) {
                Some(known) => *known = value,
                None => _ = sent.readings.insert(label.clone(), value),
            }
        }
    }

    /// Tells the main world what has changed; a new error is logged.
    pub(crate) fn say(&mut self, error: Option<String>, is_running: bool, report: &Report) {
        if let Some(error) = error.as_ref().filter(|error| self.reported.frame.as_ref() != Some(error)) {
            error!("{error}");
        }
        let is_changing = self.post.is_changing();
        // The reason stays until the next change.
        let has_come_in = self.reported.is_changing && !is_changing;
        let known = self.reported.fade_skip_reason.as_deref();
        if let Some(why) = self.post.fade_skip_reason().filter(|why| has_come_in || known != Some(*why)) {
            warn!("a change did not fade in: {why}");
        }
        let is_same_plan = self.plan.as_ref().map(Arc::as_ptr) == self.post.plan().map(Arc::as_ptr);
        if is_same_plan
            && std::mem::replace(&mut self.is_reported, true)
            && self.reported.frame == error
            && (self.reported.is_running, self.reported.is_changing) == (is_running, is_changing)
            && self.reported.tier.as_deref() == self.post.tier()
            && self.reported.unknown == self.post.warnings()
            && self.reported.fade_skip_reason.as_deref() == self.post.fade_skip_reason()
        {
            return;
        }
        self.plan = self.post.plan().cloned();
        let passes = self.plan.as_ref().map_or(Vec::new(), |plan| plan.pass_names());
        let settings = std::mem::take(&mut self.reported.settings);
        let fade_skip_reason = self.post.fade_skip_reason().map(str::to_owned);
        let (unknown, tier) = (self.post.warnings().to_vec(), self.post.tier().map(str::to_owned));
        self.reported =
            Rendered { settings, unknown, tier, frame: error, is_running, is_changing, fade_skip_reason, passes };
        report.lock().rendered = Some(self.reported.clone());
    }
}
