//! A walk through a hall, with a menu of the pipeline's tiers and facts, which fade in, and of its parameters: `walk
//! [PIPELINE [TIER]]`, from the folder `pipelines` of the repository.
//!
//! W, A, S, D walk, and the left and right arrow turn. The menu takes the mouse, or Tab and the arrows up and down to
//! choose a line, minus and equals to change it, and the digits for tiers. With `AFTERIMAGE_SHOT=picture.png` it has no
//! window: it renders 90 frames, writes the last one and ends.

use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass};
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy_afterimage::Afterimage;
use shot::Shot;

mod hall;
mod panel;
#[path = "../common/shot.rs"]
mod shot;

fn main() {
    shot::app("Walk", UVec2::new(1280, 720))
        .add_plugins(RenderDiagnosticsPlugin)
        .insert_resource(ClearColor(Color::srgb(0.01, 0.012, 0.02)))
        .insert_resource(GlobalAmbientLight { color: Color::srgb(0.6, 0.7, 1.0), brightness: 22.0, ..default() })
        .add_systems(Startup, (hall::build, camera))
        .add_systems(Update, (walk, flicker))
        .add_systems(Update, (panel::build, panel::keys, panel::mouse, panel::apply, panel::show).chain())
        .run();
}

fn camera(mut commands: Commands, assets: Res<AssetServer>, shot: Option<Res<Shot>>) {
    let mut words = std::env::args().skip(1);
    let pipeline = words.next().unwrap_or_else(|| "tsushima.ron".into());
    let mut look = Afterimage::new(assets.load(pipeline)).fade(20);
    look.tier = words.next();
    let place = Transform::from_xyz(-0.6, 1.65, 9.0).looking_at(Vec3::new(0.5, 1.7, -6.0), Vec3::Y);
    // What prepasses draw is for pipelines that take it, such as `cinematic.ron`.
    let prepasses = (DepthPrepass, MotionVectorPrepass);
    let mut camera = commands.spawn((Camera3d::default(), Msaa::Off, prepasses, place, look, IsDefaultUiCamera));
    if let Some(shot) = shot {
        camera.insert(shot.target());
    }
}

fn walk(time: Res<Time>, keys: Res<ButtonInput<KeyCode>>, mut camera: Single<&mut Transform, With<Afterimage>>) {
    let axis = |back, forth| f32::from(keys.pressed(forth)) - f32::from(keys.pressed(back));
    camera.rotate_y(axis(KeyCode::ArrowRight, KeyCode::ArrowLeft) * 1.2 * time.delta_secs());
    let [ahead, aside] = [camera.forward(), camera.right()].map(|to| Vec3::new(to.x, 0.0, to.z).normalize_or_zero());
    let step = ahead * axis(KeyCode::KeyS, KeyCode::KeyW) + aside * axis(KeyCode::KeyA, KeyCode::KeyD);
    let place = camera.translation + step.normalize_or_zero() * 3.0 * time.delta_secs();
    camera.translation = place.clamp(Vec3::new(-2.2, 1.65, -16.0), Vec3::new(2.2, 1.65, 12.0));
}

/// Lanterns burn unevenly.
fn flicker(time: Res<Time>, mut lamps: Query<(&mut PointLight, &hall::Lantern)>) {
    for (mut light, lantern) in &mut lamps {
        let at = time.elapsed_secs() * 3.0 + lantern.phase;
        light.intensity = lantern.lumens * (1.0 + 0.06 * at.sin() + 0.04 * (2.7 * at).sin());
    }
}
