//! What the main world makes of cameras with pipelines for the render world.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::Graph;
use bevy::asset::{AssetLoadError, AssetLoadFailedEvent};
use bevy::camera::CameraMainTextureUsages;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::post_process::auto_exposure::AutoExposure;
use bevy::post_process::bloom::Bloom;
use bevy::prelude::*;
use bevy::render::render_resource::TextureUsages;

use crate::asset::Pipeline;
use crate::camera::Afterimage;
use crate::files::PipelineError;
use crate::request::{CameraRequest, Settings};
use crate::status::{AfterimageStatus, Rendered};

/// What a camera had before a pipeline replaced it.
#[derive(Component)]
pub(crate) struct Replaced {
    tonemapping: Option<Tonemapping>,
    dither: Option<DebandDither>,
    usages: Option<CameraMainTextureUsages>,
}

/// The graphs that have been made, by pipeline and tier.
type Graphs = BTreeMap<(AssetId<Pipeline>, Option<String>), Arc<Graph>>;

type Replaceable =
    (Entity, Option<&'static Tonemapping>, Option<&'static DebandDither>, Option<&'static CameraMainTextureUsages>);

type New = (Added<Afterimage>, Without<Replaced>);

/// Switches off what the pipeline replaces.
pub(crate) fn replace_others(mut commands: Commands, cameras: Query<Replaceable, New>) {
    for (camera, tonemapping, dither, usages) in &cameras {
        let (tonemapping, dither) = (tonemapping.copied(), dither.copied());
        let replaced = Replaced { tonemapping, dither, usages: usages.copied() };
        // With the first usage the last pass can be a dispatch, which is faster than a draw on most devices. The second
        // is for viewports, whose result is copied back.
        let added = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let usages = usages.copied().unwrap_or_default().with(added);
        commands.entity(camera).insert((Tonemapping::None, DebandDither::Disabled, usages, replaced));
    }
}

type ReplacedOn = (&'static Replaced, Option<&'static Tonemapping>, Option<&'static DebandDither>);

/// Gives back what a pipeline has replaced when it is removed, unless the game has set it meanwhile.
pub(crate) fn restore_others(
    mut commands: Commands,
    mut removed: RemovedComponents<Afterimage>,
    cameras: Query<ReplacedOn, Without<Afterimage>>,
) {
    for camera in removed.read() {
        let Ok((replaced, tonemapping, dither)) = cameras.get(camera) else { continue };
        let mut camera = commands.entity(camera);
        if let Some(before) = replaced.tonemapping.filter(|_| tonemapping == Some(&Tonemapping::None)) {
            camera.insert(before);
        }
        if let Some(before) = replaced.dither.filter(|_| dither == Some(&DebandDither::Disabled)) {
            camera.insert(before);
        }
        if let Some(before) = replaced.usages {
            camera.insert(before);
        }
        camera.remove::<(Replaced, CameraRequest, AfterimageStatus)>();
    }
}

type Effects = (
    Entity,
    Option<&'static Tonemapping>,
    Option<&'static DebandDither>,
    Option<&'static Bloom>,
    Option<&'static AutoExposure>,
    &'static mut AfterimageStatus,
);

/// Warns of effects of Bevy that are on beside the pipeline.
pub(crate) fn warn_of_others(mut cameras: Query<Effects, (With<Afterimage>, With<Replaced>)>) {
    for (camera, tonemapping, dither, bloom, exposure, mut status) in &mut cameras {
        let on = [
            (tonemapping.is_some_and(|curve| *curve != Tonemapping::None), "`Tonemapping`: light is compressed twice"),
            (dither.is_some_and(|dither| *dither != DebandDither::Disabled), "`DebandDither`: noise is added twice"),
            (bloom.is_some(), "`Bloom`: light is spread by both"),
            (exposure.is_some(), "`AutoExposure`: the pipeline has a meter, or needs none"),
        ];
        let is_same = on.iter().filter(|(is_on, _)| *is_on).map(|(_, what)| what).eq(&status.others);
        if !is_same {
            status.others = on.iter().filter(|(is_on, _)| *is_on).map(|(_, what)| (*what).to_owned()).collect();
            status.others.iter().for_each(|what| warn!("camera {camera} has a pipeline and Bevy's {what}"));
        }
    }
}

/// A pipeline that has been loaded again is checked again; why one is not loaded is passed on.
pub(crate) fn follow_assets(
    mut events: MessageReader<AssetEvent<Pipeline>>,
    mut failures: MessageReader<AssetLoadFailedEvent<Pipeline>>,
    mut cameras: Query<(&mut Afterimage, &mut AfterimageStatus)>,
) {
    for event in events.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id }) = event else { continue };
        for (mut camera, mut status) in cameras.iter_mut().filter(|(camera, _)| camera.pipeline.id() == *id) {
            camera.set_changed();
            clear(&mut status);
        }
    }
    for failure in failures.read() {
        for (_, mut status) in cameras.iter_mut().filter(|(camera, _)| camera.pipeline.id() == failure.id) {
            // Bevy has logged it, with a call stack that says nothing of the files.
            let ours = match &failure.error {
                AssetLoadError::AssetLoaderError(error) => error.error().downcast_ref::<PipelineError>(),
                _ => None,
            };
            status.files = Some(ours.map_or_else(|| failure.error.to_string(), PipelineError::to_string));
        }
    }
}

fn clear(status: &mut Mut<AfterimageStatus>) {
    if status.files.is_some() {
        status.files = None;
    }
}

/// Makes the graphs of changed cameras. The graph before stays in use where the new one has errors.
pub(crate) fn check_graphs(
    pipelines: Res<Assets<Pipeline>>,
    mut cameras: Query<(Entity, &Afterimage, &mut CameraRequest, &mut AfterimageStatus), Changed<Afterimage>>,
    mut known: Local<Graphs>,
    mut reloaded: MessageReader<AssetEvent<Pipeline>>,
) {
    for event in reloaded.read() {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = event {
            known.retain(|(pipeline, _), _| pipeline != id);
        }
    }
    for (camera, afterimage, mut request, mut status) in &mut cameras {
        let Some(pipeline) = pipelines.get(&afterimage.pipeline) else { continue };
        let key = (afterimage.pipeline.id(), afterimage.tier.clone());
        let graph = match known.get(&key) {
            Some(graph) => graph.clone(),
            None => match pipeline.graph(afterimage.tier.as_deref()) {
                Ok(graph) => known.entry(key).or_insert(Arc::new(graph)).clone(),
                Err(errors) => {
                    error!("camera {camera}:\n{errors}");
                    status.files = Some(errors.to_string());
                    continue;
                }
            },
        };
        clear(&mut status);
        let facts = afterimage.facts.iter().filter_map(|(name, fact)| Some((name.clone(), fact.fact()?))).collect();
        let refused = afterimage.facts.iter().filter(|(_, fact)| fact.fact().is_none());
        let refused = refused.map(|(name, _)| format!("`{name}` is no fact: facts are flags and numbers")).collect();
        let (parameters, target, cuts, fade) =
            (afterimage.parameters.clone(), afterimage.target, afterimage.cuts, afterimage.fade);
        request.settings = Some(Arc::new(Settings { graph, facts, refused, parameters, target, cuts, fade }));
    }
}

/// Copies the reports of the render world into the cameras' status.
pub(crate) fn take_reports(mut cameras: Query<(&CameraRequest, &mut AfterimageStatus)>) {
    for (request, mut status) in &mut cameras {
        if let Some(rendered) = request.report.take() {
            let Rendered { settings, frame, is_running, is_changing, fade_skip_reason, passes } = rendered;
            let (files, others) = (status.files.clone(), status.others.clone());
            let fade_skip_reason = fade_skip_reason.map(|why| why.to_string());
            let new =
                AfterimageStatus { files, settings, frame, others, is_running, is_changing, fade_skip_reason, passes };
            status.set_if_neq(new);
        }
    }
}
