//! Afterimage beside Bevy's own effects: GPU and CPU milliseconds of both, from Bevy's diagnostics.
//!
//! `beside [WIDTH HEIGHT [FRAMES]]` runs the spheres without a window: Bevy's bloom, exposure and tone mapping, then the
//! pipelines `lynx.ron` and `tsushima.ron`, dispatched and drawn.

use std::collections::BTreeMap;
use std::time::Duration;

use bevy::camera::{CameraMainTextureUsages, Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::diagnostic::DiagnosticsStore;
use bevy::post_process::auto_exposure::{AutoExposure, AutoExposurePlugin};
use bevy::post_process::bloom::Bloom;
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy_afterimage::{Afterimage, AfterimagePlugin};

fn main() {
    let numbers: Vec<u32> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let (width, height) = (*numbers.first().unwrap_or(&1920), *numbers.get(1).unwrap_or(&1080));
    let frames = numbers.get(2).map_or(300, |frames| *frames as usize);
    println!("{width}x{height}, medians of {frames} frames, milliseconds");
    println!("{:<34} {:>9} {:>9}", "", "GPU", "recording");
    for (name, own, is_drawn) in [
        ("Bevy: bloom, tone mapping", None, false),
        ("Bevy: auto exposure, bloom, tone mapping", Some(""), false),
        ("Afterimage: lynx.ron", Some("lynx.ron"), false),
        ("Afterimage: lynx.ron, drawn", Some("lynx.ron"), true),
        ("Afterimage: tsushima.ron", Some("tsushima.ron"), false),
    ] {
        let times = measured(UVec2::new(width, height), frames, own, is_drawn);
        let sum =
            |field: &str| -> f64 { times.iter().filter(|(path, _)| path.ends_with(field)).map(|(_, ms)| ms).sum() };
        println!("{name:<34} {:>9.4} {:>9.4}", sum("elapsed_gpu"), sum("elapsed_cpu"));
    }
}

/// The median of each span of post-processing.
fn measured(size: UVec2, frames: usize, own: Option<&str>, is_drawn: bool) -> BTreeMap<String, f64> {
    let pipelines = std::env::var("AFTERIMAGE_PIPELINES");
    let file_path = pipelines.unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines").into());
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let plugins = DefaultPlugins.set(AssetPlugin { file_path, ..default() }).set(window);
    let plugins = plugins.disable::<bevy::winit::WinitPlugin>().disable::<bevy::log::LogPlugin>();
    let mut app = App::new();
    app.add_plugins((plugins.disable::<PipelinedRenderingPlugin>(), AfterimagePlugin::default()))
        .add_plugins((RenderDiagnosticsPlugin, AutoExposurePlugin))
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(16)));
    app.finish();
    app.cleanup();
    let world = app.world_mut();
    let image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
    let target = RenderTarget::Image(world.resource_mut::<Assets<Image>>().add(image).into());
    let place = Transform::from_xyz(0.0, 1.0, 7.0).looking_at(Vec3::ZERO, Vec3::Y);
    let look = own.filter(|file| !file.is_empty()).map(|file| world.resource::<AssetServer>().load(file.to_owned()));
    let camera = world.spawn((Camera3d::default(), Msaa::Off, Hdr, place, target)).id();
    match look {
        Some(pipeline) => world.entity_mut(camera).insert(Afterimage::new(pipeline)),
        None => world.entity_mut(camera).insert((Bloom::NATURAL, Tonemapping::AcesFitted)),
    };
    if own == Some("") {
        world.entity_mut(camera).insert(AutoExposure::default());
    }
    let sphere = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.8).mesh().uv(32, 16));
    for index in 0..5 {
        let emissive = LinearRgba::rgb(0.3 + index as f32, 0.9, 2.0 - 0.4 * index as f32) * 3.0_f32.powi(index - 1);
        let material = StandardMaterial { emissive, ..default() };
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
        let place = Transform::from_xyz(1.9 * index as f32 - 3.8, 0.0, 0.0);
        world.spawn((Mesh3d(sphere.clone()), MeshMaterial3d(material), place));
    }
    for frame in 0..60 {
        app.update();
        std::thread::sleep(Duration::from_millis(if frame < 30 { 30 } else { 1 }));
        if is_drawn {
            // The plug-in adds the usage for dispatches.
            let usages = CameraMainTextureUsages::default();
            app.world_mut().entity_mut(camera).insert(usages);
        }
    }
    let mut samples: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for _ in 0..frames {
        app.update();
        for diagnostic in app.world().resource::<DiagnosticsStore>().iter() {
            let path = diagnostic.path().as_str();
            let is_post =
                ["bloom", "tonemapping", "auto_exposure", "afterimage"].iter().any(|name| path.contains(name));
            // Spans inside of others would count twice.
            if let Some(value) = diagnostic.value().filter(|_| is_post && path.split('/').count() <= 4) {
                samples.entry(path.to_owned()).or_default().push(value);
            }
        }
    }
    if std::env::var("SPANS").is_ok() {
        samples.iter().for_each(|(path, values)| println!("    {path} {}", values.len()));
    }
    samples
        .into_iter()
        .map(|(path, mut values)| {
            values.sort_by(f64::total_cmp);
            (path, values[values.len() / 2])
        })
        .collect()
}
