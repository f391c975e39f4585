//! The pipeline of one camera: it follows the settings, and records frames.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_gpu::{Frame, Post, wgpu};
use afterimage_graph::node::{BlockData, CAMERA, Camera, Matrix};
use afterimage_plan::Plan;
use bevy::prelude::*;
use bevy::render::camera::TemporalJitter;
use bevy::render::view::ExtractedView;

use crate::request::Settings;
use crate::setting::{Setting, Target};
use crate::status::{Rendered, Report};

/// The pipeline of a camera.
pub(crate) struct CameraPost {
    pub(crate) post: Post,
    pub(crate) settings: Arc<Settings>,
    /// The camera in the frame before, and the block that is written for it.
    camera: Option<Camera>,
    block: BlockData,
    has_cut: bool,
    /// What was said last, and whether something is to be added.
    said: Rendered,
    is_said: bool,
    plan: Option<Arc<Plan>>,
}

impl CameraPost {
    /// The first camera with these settings.
    pub(crate) fn new(post: Post, settings: Arc<Settings>) -> Self {
        let mut new = Self::with_post(post, settings);
        new.set_output_linear();
        new.post.set_facts(new.settings.facts.clone());
        new.post.set_fade(new.settings.fade);
        new.set(&BTreeMap::new());
        new
    }

    /// The pipeline for one more camera with the same graph and target. Both share compiled pipelines and cached plans.
    pub(crate) fn clone_for_view(&self, settings: &Arc<Settings>) -> Self {
        let mut new = Self::with_post(self.post.clone_for_view(), self.settings.clone());
        new.follow(settings);
        new
    }

    fn with_post(post: Post, settings: Arc<Settings>) -> Self {
        let (block, said) = (BlockData::new(&CAMERA), Rendered::default());
        Self { post, settings, camera: None, block, has_cut: true, said, is_said: true, plan: None }
    }

    /// Bevy encodes the main texture later.
    fn set_output_linear(&mut self) {
        let Self { post, settings, .. } = self;
        if settings.target == Target::MainTexture {
            settings.graph.outputs.iter().for_each(|output| post.set_output_linear(output.name.clone()));
        }
    }

    /// Whether it can follow these settings: an output that holds linear light does so for good.
    pub(crate) fn suits(&self, settings: &Settings) -> bool {
        self.settings.target == settings.target
    }

    /// Takes over what has changed for the camera.
    pub(crate) fn follow(&mut self, settings: &Arc<Settings>) {
        if Arc::ptr_eq(&self.settings, settings) {
            return;
        }
        let before = std::mem::replace(&mut self.settings, settings.clone());
        if !Arc::ptr_eq(&before.graph, &settings.graph) {
            self.post.change((*settings.graph).clone());
            self.set_output_linear();
        }
        self.post.set_facts(settings.facts.clone());
        self.post.set_fade(settings.fade);
        self.has_cut |= before.cuts != settings.cuts;
        self.set(&before.parameters);
    }

    /// Sets the parameters, and those that the camera no longer sets to the values of the file.
    fn set(&mut self, before: &BTreeMap<String, Setting>) {
        let settings = self.settings.clone();
        let mut refused = settings.refused.clone();
        let names = before.keys().filter(|name| !settings.parameters.contains_key(*name));
        for name in settings.parameters.keys().chain(names) {
            let result = self.post.control(name).map_err(|error| error.to_string()).and_then(|control| {
                let Some(setting) = settings.parameters.get(name) else {
                    return self.post.unset(control).map_err(|error| error.to_string());
                };
                let place = settings.graph.parameter(name)?;
                let ty = settings.graph.declaration(place).ty;
                let value = setting.value(ty).ok_or_else(|| format!("`{name}` is {}", ty.describe()))?;
                self.post.set_value(control, value).map_err(|error| error.to_string())
            });
            // A parameter that is no longer set may be one that this pipeline never had.
            refused.extend(result.err().filter(|_| settings.parameters.contains_key(name)));
        }
        refused.iter().filter(|why| !self.said.settings.contains(why)).for_each(|why| error!("{why}"));
        if refused != self.said.settings {
            self.said.settings = refused;
            self.is_said = false;
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
        let Self { post, block, camera, has_cut, .. } = self;
        let blocks = &[("camera", &*block)][..usize::from(camera.is_some())];
        let before = post.frame();
        let error = post.encode(encoder, &Frame { blocks, reset: *has_cut, ..*frame }).err();
        let is_recorded = post.frame() > before;
        self.has_cut &= !is_recorded;
        self.say(error.map(|error| error.to_string()), is_recorded, report);
        is_recorded
    }

    /// Tells the main world what has changed; a new error is logged.
    pub(crate) fn say(&mut self, error: Option<String>, is_running: bool, report: &Report) {
        if let Some(error) = error.as_ref().filter(|error| self.said.frame.as_ref() != Some(error)) {
            error!("{error}");
        }
        let is_changing = self.post.is_changing();
        // The reason stays until the next change.
        let has_come_in = self.said.is_changing && !is_changing;
        let fade_skip_reason =
            self.post.fade_skip_reason().filter(|why| has_come_in || self.said.fade_skip_reason.as_ref() != Some(why));
        if let Some(why) = fade_skip_reason {
            warn!("a change did not fade in: {why}");
        }
        let is_same_plan = self.plan.as_ref().map(Arc::as_ptr) == self.post.plan().map(Arc::as_ptr);
        if is_same_plan
            && std::mem::replace(&mut self.is_said, true)
            && self.said.frame == error
            && (self.said.is_running, self.said.is_changing) == (is_running, is_changing)
            && self.said.fade_skip_reason.as_ref() == self.post.fade_skip_reason()
        {
            return;
        }
        self.plan = self.post.plan().cloned();
        let passes = self.plan.as_ref().map_or(Vec::new(), |plan| plan.pass_names());
        let settings = std::mem::take(&mut self.said.settings);
        let fade_skip_reason = self.post.fade_skip_reason().cloned();
        self.said = Rendered { settings, frame: error, is_running, is_changing, fade_skip_reason, passes };
        report.send(self.said.clone());
    }
}
