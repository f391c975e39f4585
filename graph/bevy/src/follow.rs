//! Requests of the main world to the render world, for cameras with pipelines.

use std::sync::Arc;

use afterimage::Error;
use bevy::asset::{AssetLoadError, AssetLoadFailedEvent};
use bevy::camera::CameraMainTextureUsages;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::post_process::auto_exposure::AutoExposure;
use bevy::post_process::bloom::Bloom;
use bevy::prelude::*;
use bevy::render::render_resource::TextureUsages;

use crate::asset::Pipeline;
use crate::camera::Afterimage;
use crate::request::{CameraRequest, Settings};
use crate::status::{AfterimageReadings, AfterimageStatus, Rendered};

/// Settings of a camera that a pipeline has replaced.
#[derive(Component)]
pub(crate) struct Replaced {
    tonemapping: Option<Tonemapping>,
    dither: Option<DebandDither>,
    usages: Option<CameraMainTextureUsages>,
}

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
        camera.remove::<(Replaced, CameraRequest, AfterimageStatus, AfterimageReadings)>();
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
                AssetLoadError::AssetLoaderError(error) => error.error().downcast_ref::<Error>(),
                _ => None,
            };
            status.files = Some(ours.map_or_else(|| failure.error.to_string(), Error::to_string));
        }
    }
}

fn clear(status: &mut Mut<AfterimageStatus>) {
    if status.files.is_some() {
        status.files = None;
    }
}

/// Requests what is set for changed cameras. What was requested before stays where there is no such tier.
pub(crate) fn request(
    pipelines: Res<Assets<Pipeline>>,
    mut cameras: Query<(Entity, &Afterimage, &mut CameraRequest, &mut AfterimageStatus), Changed<Afterimage>>,
) {
    for (camera, look, mut request, mut status) in &mut cameras {
        let Some(pipeline) = pipelines.get(&look.pipeline) else { continue };
        if let Some(error) = wrong_tier(pipeline, look) {
            error!("camera {camera}:\n{error}");
            status.files = Some(error);
            continue;
        }
        clear(&mut status);
        request.settings = Some(Arc::new(Settings { pipeline: pipeline.clone(), look: look.clone() }));
    }
}

/// The error of tiers of a camera that its pipeline does not have.
fn wrong_tier(pipeline: &Pipeline, look: &Afterimage) -> Option<String> {
    let governed = look.budget.as_ref().map(|budget| &*budget.tiers);
    if governed.is_some_and(<[String]>::is_empty) {
        return Some("a budget needs tiers to choose from".into());
    }
    let mut tiers = governed.unwrap_or(look.tier.as_slice()).iter();
    let unknown = tiers.find(|tier| !pipeline.tiers().contains(tier))?;
    // All that there are were checked when the pipeline was loaded.
    pipeline.graph(Some(unknown)).err().map(|error| error.to_string())
}

/// Copies the reports of the render world into the cameras' components.
pub(crate) fn take_reports(
    mut cameras: Query<(&CameraRequest, &mut AfterimageStatus, Option<&mut AfterimageReadings>)>,
) {
    for (request, mut status, readings) in &mut cameras {
        let mut sent = request.report.lock();
        if let Some(mut readings) = readings.filter(|readings| readings.0 != sent.readings) {
            readings.0.clone_from(&sent.readings);
        }
        if let Some(rendered) = sent.rendered.take() {
            let Rendered { settings, unknown, tier, frame, is_running, is_changing, fade_skip_reason, passes } =
                rendered;
            let (files, others) = (status.files.clone(), status.others.clone());
            let new = AfterimageStatus {
                files,
                settings,
                unknown,
                tier,
                frame,
                others,
                is_running,
                is_changing,
                fade_skip_reason,
                passes,
            };
            status.set_if_neq(new);
        }
    }
}
