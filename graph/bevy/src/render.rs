//! The render world: a pipeline for each camera, recorded into Bevy's own commands.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use afterimage::host::{Executor, Rectangle, caps};
use afterimage::{Frame, wgpu};
use bevy::camera::{CameraOutputMode, ClearColor, ClearColorConfig};
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::core_pipeline::schedule::{Core2d, Core2dSystems, Core3d, Core3dSystems};
use bevy::core_pipeline::tonemapping::tonemapping;
use bevy::core_pipeline::upscaling::ViewUpscalingPipeline;
use bevy::post_process::bloom::bloom;
use bevy::prelude::*;
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::renderer::{RenderAdapter, RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::{ExtractedView, ResolvedCompositingSpace, ViewTarget};
use bevy::render::{GpuResourceAppExt, Render, RenderSystems};

use crate::images::{Images, part_of};
use crate::request::{CameraRequest, Settings};
use crate::running::CameraPost;
use crate::setting::Target;
use crate::systems::AfterimageSystems;

pub(crate) fn build(render: &mut SubApp) {
    render
        // After a loss, Bevy makes these again on the new device.
        .init_gpu_resource::<Running>()
        .add_systems(Render, (output_without_copy, forget_cameras).in_set(RenderSystems::PrepareResources))
        .configure_sets(
            Core3d,
            AfterimageSystems::Record.after(bloom).before(tonemapping).in_set(Core3dSystems::PostProcess),
        )
        .configure_sets(
            Core2d,
            AfterimageSystems::Record.after(bloom).before(tonemapping).in_set(Core2dSystems::PostProcess),
        )
        .add_systems(Core3d, afterimage.in_set(AfterimageSystems::Record))
        .add_systems(Core2d, afterimage.in_set(AfterimageSystems::Record));
}

/// The pipelines of all cameras.
#[derive(Resource, Default)]
struct Running(Mutex<HashMap<Entity, CameraPost>>);

/// Images and histories of cameras that are gone are freed.
fn forget_cameras(running: Res<Running>, views: Query<&MainEntity, With<CameraRequest>>) {
    let mut running = running.0.lock().unwrap_or_else(PoisonError::into_inner);
    running.retain(|camera, _| views.iter().any(|view| view.id() == *camera));
}

/// Bevy copies the main texture to the output, unless the pipeline writes there itself.
fn output_without_copy(mut commands: Commands, views: Query<(Entity, &CameraRequest), With<ViewUpscalingPipeline>>) {
    for (view, wanted) in &views {
        if wanted.settings.as_ref().is_some_and(|settings| settings.look.target == Target::Output) {
            commands.entity(view).remove::<ViewUpscalingPipeline>();
        }
    }
}

type View = (
    &'static MainEntity,
    &'static ExtractedCamera,
    &'static ExtractedView,
    &'static ViewTarget,
    &'static CameraRequest,
    Option<&'static ViewPrepassTextures>,
    Option<&'static TemporalJitter>,
    Option<&'static ResolvedCompositingSpace>,
);

fn afterimage(
    view: ViewQuery<View>,
    running: Res<Running>,
    (device, queue, adapter): (Res<RenderDevice>, Res<RenderQueue>, Res<RenderAdapter>),
    (time, background): (Res<Time>, Res<ClearColor>),
    mut context: RenderContext,
) {
    let (camera, extracted, view, target, wanted, prepass, jitter, space) = view.into_inner();
    let Some(settings) = &wanted.settings else { return };
    let mut running = running.0.lock().unwrap_or_else(PoisonError::into_inner);
    if running.get(&camera.id()).is_none_or(|known| !known.suits(settings)) {
        running.remove(&camera.id());
        let alike = running.values().find(|other| {
            other.settings.pipeline.snapshot.is_same(&settings.pipeline.snapshot) && other.suits(settings)
        });
        let new = alike.map(|other| other.clone_for_view(settings)).unwrap_or_else(|| {
            // What one camera has compiled serves all.
            let executor = running.values_mut().next().map(|other| other.post.executor().clone_for_view());
            let executor = executor.unwrap_or_else(|| {
                let caps = caps(&adapter, device.wgpu_device());
                Executor::with_caps(device.wgpu_device(), &queue, caps)
            });
            CameraPost::new(executor, settings.clone())
        });
        running.insert(camera.id(), new);
    }
    let Some(running) = running.get_mut(&camera.id()) else { return };
    running.follow(settings);
    let part = part_of(view, target);
    let (output, format) = match destination(settings, part, target, extracted, space) {
        Ok(destination) => destination,
        Err(why) => return running.say(Some(why.to_owned()), false, &wanted.report),
    };
    let images = Images::new(&settings.pipeline.written, target, prepass, part);
    running.look(view, jitter);
    let name = settings.pipeline.written.outputs[0].name.as_str();
    let frame = Frame {
        inputs: images.inputs(),
        rectangles: images.rectangles(),
        outputs: &[(name, output)],
        formats: &[(name, format)],
        time: time.elapsed_secs_f64(),
        dt: time.delta_secs(),
        ..Frame::default()
    };
    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(context.command_encoder(), "afterimage");
    if settings.look.target == Target::Output && part.is_some() {
        clear_around(context.command_encoder(), target, extracted, background.0);
    }
    let is_recorded = running.encode(context.command_encoder(), &frame, &wanted.report);
    if is_recorded {
        match (settings.look.target, part) {
            // The other texture is the main one from now on.
            (Target::MainTexture, None) => drop(target.post_process_write()),
            // What is around the viewport stays as it is.
            (Target::MainTexture, Some(part)) => copy_back(context.command_encoder(), target, part),
            // Otherwise Bevy would clear the output, or not present it.
            (Target::Output, _) => drop(target.out_texture_color_attachment(None)),
        }
    }
    span.end(context.command_encoder());
}

/// The image that the pipeline writes, and its format; a sentence where the camera has none.
fn destination<'a>(
    settings: &Settings,
    part: Option<Rectangle>,
    target: &'a ViewTarget,
    camera: &ExtractedCamera,
    space: Option<&ResolvedCompositingSpace>,
) -> Result<(&'a wgpu::TextureView, wgpu::TextureFormat), &'static str> {
    if ResolvedCompositingSpace::space(space).is_some() {
        return Err("the camera's `CompositingSpace` is not linear, and pipelines need linear light");
    }
    let copies = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
    match settings.look.target {
        Target::MainTexture if part.is_some() && !target.main_texture().usage().contains(copies) => {
            Err("a viewport needs `COPY_SRC` and `COPY_DST` in the camera's `CameraMainTextureUsages`")
        }
        Target::MainTexture => Ok((target.main_texture_other_view(), target.main_texture_format())),
        Target::Output if matches!(camera.output_mode, CameraOutputMode::Skip) => {
            Err("the camera's output mode is `Skip`, and the pipeline's target is its output")
        }
        Target::Output => {
            let output = target.out_texture().zip(target.out_texture_view_format());
            output.map(|(view, format)| (&**view, format)).ok_or("the camera has no output to write to")
        }
    }
}

/// The first camera of an output clears it, as Bevy's copy would.
fn clear_around(encoder: &mut wgpu::CommandEncoder, target: &ViewTarget, camera: &ExtractedCamera, background: Color) {
    let color = match camera.output_mode {
        CameraOutputMode::Write { clear_color: ClearColorConfig::Custom(color), .. } => Some(color),
        CameraOutputMode::Write { clear_color: ClearColorConfig::None, .. } | CameraOutputMode::Skip => None,
        CameraOutputMode::Write { clear_color: ClearColorConfig::Default, .. } => Some(background),
    };
    let attachment = target.out_texture_color_attachment(color.map(Into::into));
    if let Some(attachment) = attachment.filter(|attachment| matches!(attachment.ops.load, wgpu::LoadOp::Clear(_))) {
        drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("afterimage: around the viewport"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        }));
    }
}

/// Copies the result in a viewport to the main texture, which other cameras may share.
fn copy_back(encoder: &mut wgpu::CommandEncoder, target: &ViewTarget, part: Rectangle) {
    let Rectangle { x, y, width, height } = part;
    let origin = wgpu::Origin3d { x, y, z: 0 };
    let [from, to] = [target.main_texture_other(), target.main_texture()].map(|texture| wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin,
        aspect: wgpu::TextureAspect::All,
    });
    encoder.copy_texture_to_texture(from, to, wgpu::Extent3d { width, height, depth_or_array_layers: 1 });
}
