//! The frame of an example: a window, or with `AFTERIMAGE_SHOT=picture.png` none. Then it renders some frames, writes the
//! last one and ends.

use std::time::Duration;

use bevy::app::ScheduleRunnerPlugin;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy_afterimage::AfterimagePlugin;

/// Shaders of the scene and plans have arrived by then.
const FRAME: u32 = 90;

/// Where an example without a window renders to.
#[derive(Resource)]
pub(crate) struct Shot {
    image: Handle<Image>,
    file: String,
}

impl Shot {
    pub(crate) fn target(&self) -> RenderTarget {
        RenderTarget::Image(self.image.clone().into())
    }
}

/// An app whose assets are the pipelines of the repository.
pub(crate) fn app(title: &str, size: UVec2) -> App {
    let assets = AssetPlugin { file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines").into(), ..default() };
    let mut app = App::new();
    let Ok(file) = std::env::var("AFTERIMAGE_SHOT") else {
        let window = Window { title: title.into(), resolution: size.into(), ..default() };
        let window = WindowPlugin { primary_window: Some(window), ..default() };
        app.add_plugins((DefaultPlugins.set(assets).set(window), AfterimagePlugin::default()));
        return app;
    };
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let plugins = DefaultPlugins.set(assets).set(window).disable::<bevy::winit::WinitPlugin>();
    app.add_plugins((plugins, ScheduleRunnerPlugin::run_loop(Duration::ZERO), AfterimagePlugin::default()))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
        .add_systems(Update, shoot);
    let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.insert_resource(Shot { image, file });
    app
}

fn shoot(mut commands: Commands, shot: Res<Shot>, mut frame: Local<u32>, mut exit: MessageWriter<AppExit>) {
    *frame += 1;
    if *frame == FRAME {
        commands.spawn(Screenshot::image(shot.image.clone())).observe(save_to_disk(shot.file.clone()));
    }
    if *frame == FRAME + 30 {
        exit.write(AppExit::Success);
    }
}
