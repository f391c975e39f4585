//! The render world: a pipeline for each camera, recorded into Bevy's own commands.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use afterimage_gpu::{Executor, Frame, Post, caps, wgpu};
use afterimage_graph::check::Graph;
use afterimage_graph::node::{BlockData, Camera, Matrix};
use bevy::core_pipeline::prepass::{PreviousViewData, ViewPrepassTextures};
use bevy::core_pipeline::schedule::{Core3d, Core3dSystems};
use bevy::core_pipeline::tonemapping::tonemapping;
use bevy::core_pipeline::upscaling::ViewUpscalingPipeline;
use bevy::prelude::*;
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::renderer::{RenderAdapter, RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::{ExtractedView, ViewTarget};
use bevy::render::{Render, RenderSystems};

use crate::camera::{Settings, Target, Wanted};

pub(crate) fn build(render: &mut SubApp) {
    render
        .init_resource::<Running>()
        .add_systems(Render, (output_without_copy, forget_cameras).in_set(RenderSystems::PrepareResources))
        .add_systems(Core3d, afterimage.before(tonemapping).in_set(Core3dSystems::PostProcess));
}

/// The pipelines of all cameras.
#[derive(Resource, Default)]
struct Running(Mutex<HashMap<Entity, CameraPost>>);

/// The pipeline of a camera.
struct CameraPost {
    post: Post,
    /// What it follows.
    settings: Arc<Settings>,
    is_first: bool,
    /// The last error, which is logged once.
    error: Option<String>,
}

/// Images and histories of cameras that are gone are freed.
fn forget_cameras(running: Res<Running>, views: Query<&MainEntity, With<Wanted>>) {
    let mut running = running.0.lock().unwrap_or_else(PoisonError::into_inner);
    running.retain(|camera, _| views.iter().any(|view| view.id() == *camera));
}

/// Bevy copies the main texture to the output, unless the pipeline writes there itself.
fn output_without_copy(mut commands: Commands, views: Query<(Entity, &Wanted), With<ViewUpscalingPipeline>>) {
    for (view, wanted) in &views {
        if wanted.0.as_ref().is_some_and(|settings| settings.target == Target::Output) {
            commands.entity(view).remove::<ViewUpscalingPipeline>();
        }
    }
}

type View = (
    &'static MainEntity,
    &'static ExtractedCamera,
    &'static ExtractedView,
    &'static ViewTarget,
    &'static Wanted,
    Option<&'static ViewPrepassTextures>,
    Option<&'static PreviousViewData>,
    Option<&'static TemporalJitter>,
);

fn afterimage(
    view: ViewQuery<View>,
    running: Res<Running>,
    (device, queue, adapter): (Res<RenderDevice>, Res<RenderQueue>, Res<RenderAdapter>),
    time: Res<Time>,
    mut context: RenderContext,
) {
    let (camera, extracted, view, target, wanted, prepass, previous, jitter) = view.into_inner();
    let Some(settings) = &wanted.0 else { return };
    let mut running = running.0.lock().unwrap_or_else(PoisonError::into_inner);
    let running = running.entry(camera.id()).or_insert_with(|| {
        let caps = caps(&adapter, device.wgpu_device());
        let executor = Executor::with_caps(device.wgpu_device(), &queue, caps);
        CameraPost::new(Post::with_executor(executor, (*settings.graph).clone()), settings.clone())
    });
    if extracted.viewport.is_some() {
        return running.report(Some("a viewport is not supported: the pipeline would run on the whole image".into()));
    }
    running.follow(settings);
    let images = Images::new(&settings.graph, target, prepass);
    let block = camera_block(view, previous, jitter);
    let blocks: Vec<(&str, &BlockData)> = block.iter().map(|data| ("camera", data)).collect();
    let Some((output, format)) = destination(settings, target) else { return };
    let name = settings.graph.outputs[0].name.as_str();
    let (inputs, outputs, formats) = (&*images.0, &[(name, output)], &[(name, format)]);
    let (time, dt, reset) = (time.elapsed_secs_wrapped(), time.delta_secs(), running.is_first);
    let frame = Frame { inputs, blocks: &blocks, outputs, formats, time, dt, reset, ..Frame::default() };
    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(context.command_encoder(), "afterimage");
    let is_recorded = running.encode(context.command_encoder(), &frame);
    span.end(context.command_encoder());
    if is_recorded {
        match settings.target {
            // The other texture is the main one from now on.
            Target::MainTexture => drop(target.post_process_write()),
            // Otherwise Bevy would clear the output, or not present it.
            Target::Output => drop(target.out_texture_color_attachment(None)),
        }
    }
}

/// The image that the pipeline writes, and its format.
fn destination<'a>(
    settings: &Settings,
    target: &'a ViewTarget,
) -> Option<(&'a wgpu::TextureView, wgpu::TextureFormat)> {
    match settings.target {
        Target::MainTexture => Some((target.main_texture_other_view(), target.main_texture_format())),
        Target::Output => Some((target.out_texture()?, target.out_texture_view_format()?)),
    }
}

/// The images for the inputs of a pipeline.
struct Images<'a>(Vec<(&'a str, &'a wgpu::TextureView)>);

impl<'a> Images<'a> {
    /// Those of the prepasses by their names, and the camera's image for the first other input.
    fn new(graph: &'a Graph, target: &'a ViewTarget, prepass: Option<&'a ViewPrepassTextures>) -> Self {
        let of_prepass = |name: &str| match name {
            "depth" => Some(prepass.and_then(|prepass| prepass.depth_only_view())),
            "normals" => Some(prepass.and_then(|prepass| prepass.normal_view())),
            "motion" => Some(prepass.and_then(|prepass| prepass.motion_vectors_view())),
            _ => None,
        };
        let mut scene = Some(&**target.main_texture_view());
        let images = graph.inputs.iter().filter(|input| input.block.is_none()).filter_map(|input| {
            let view = match of_prepass(&input.name) {
                Some(view) => view.map(|view| &**view),
                None => scene.take(),
            };
            Some((input.name.as_str(), view?))
        });
        Self(images.collect())
    }
}

/// The camera; `None` if its matrices have no inverse.
fn camera_block(
    view: &ExtractedView,
    previous: Option<&PreviousViewData>,
    jitter: Option<&TemporalJitter>,
) -> Option<BlockData> {
    let columns = |matrix: Mat4| -> Matrix { matrix.to_cols_array_2d() };
    let still = Camera::still(columns(view.world_from_view.to_matrix().inverse()), columns(view.clip_from_view));
    let jitter = jitter.map_or([0.0; 2], |jitter| jitter.offset.to_array());
    let camera = match previous {
        None => Camera { jitter, ..still },
        Some(previous) => Camera {
            previous_view: columns(previous.view_from_world),
            previous_projection: columns(previous.clip_from_view),
            jitter,
            ..still
        },
    };
    camera.data().ok()
}

impl CameraPost {
    fn new(mut post: Post, settings: Arc<Settings>) -> Self {
        hold_linear(&mut post, &settings);
        post.set_facts(settings.facts.clone());
        let mut new = Self { post, settings, is_first: true, error: None };
        new.set(&BTreeMap::new());
        new
    }

    /// Takes over what has changed for the camera.
    fn follow(&mut self, settings: &Arc<Settings>) {
        if Arc::ptr_eq(&self.settings, settings) {
            return;
        }
        let before = std::mem::replace(&mut self.settings, settings.clone());
        if !Arc::ptr_eq(&before.graph, &settings.graph) {
            self.post.change((*settings.graph).clone());
            hold_linear(&mut self.post, settings);
        }
        if before.facts != settings.facts {
            self.post.set_facts(settings.facts.clone());
        }
        self.set(&before.parameters);
    }

    /// Sets the parameters, and those that the camera no longer sets to the values of the file.
    fn set(&mut self, before: &BTreeMap<String, crate::Setting>) {
        let settings = self.settings.clone();
        let names = before.keys().filter(|name| !settings.parameters.contains_key(*name));
        for name in settings.parameters.keys().chain(names) {
            let result = self.post.control(name).map_err(|error| error.to_string()).and_then(|control| {
                let Some(setting) = settings.parameters.get(name) else {
                    return self.post.unset(control).map_err(|error| error.to_string());
                };
                let place = settings.graph.parameter(name)?;
                let value = setting.value(settings.graph.declaration(place).ty);
                let value = value.ok_or_else(|| format!("`{name}` has no such choice"))?;
                self.post.set_value(control, value).map_err(|error| error.to_string())
            });
            if let Err(why) = result {
                error!("{why}");
            }
        }
    }

    /// Records a frame. An error is logged once; whether the frame is recorded anyway.
    fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) -> bool {
        let before = self.post.frame();
        let error = self.post.encode(encoder, frame).err().map(|error| error.to_string());
        self.report(error);
        let is_recorded = self.post.frame() > before;
        self.is_first &= !is_recorded;
        is_recorded
    }

    fn report(&mut self, error: Option<String>) {
        if error.is_some() && error != self.error {
            error!("{}", error.as_deref().unwrap_or_default());
        }
        self.error = error;
    }
}

/// Bevy encodes the main texture later.
fn hold_linear(post: &mut Post, settings: &Settings) {
    if settings.target == Target::MainTexture {
        settings.graph.outputs.iter().for_each(|output| post.hold_linear(output.name.clone()));
    }
}
