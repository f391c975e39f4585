//! Emissive spheres through a pipeline: `spheres [PIPELINE [TIER]]`, from the folder `pipelines` of the repository.
//!
//! With `AFTERIMAGE_SHOT=picture.png` it has no window: it renders 60 frames, writes the last one and ends.

use bevy::app::ScheduleRunnerPlugin;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::window::ExitCondition;
use bevy_afterimage::{Afterimage, AfterimagePlugin};

fn main() {
    let shot = std::env::var("AFTERIMAGE_SHOT").ok();
    let assets = AssetPlugin { file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines").into(), ..default() };
    let mut app = App::new();
    match shot {
        None => app.add_plugins(DefaultPlugins.set(assets)),
        Some(_) => {
            let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
            let plugins = DefaultPlugins.set(assets).set(window).disable::<bevy::winit::WinitPlugin>();
            app.add_plugins((plugins, ScheduleRunnerPlugin::run_loop(std::time::Duration::ZERO)))
        }
    };
    app.add_plugins(AfterimagePlugin::default())
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, scene)
        .add_systems(Update, (turn, shoot))
        .run();
}

#[derive(Component)]
struct Turning;

#[derive(Resource)]
struct Shot(Handle<Image>, String);

fn scene(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut words = std::env::args().skip(1);
    let pipeline = words.next().unwrap_or_else(|| "lynx.ron".into());
    let mut look = Afterimage::new(assets.load(pipeline));
    look.tier = words.next();
    let place = Transform::from_xyz(0.0, 3.0, 9.0).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y);
    let mut camera = commands.spawn((Camera3d::default(), place, look));
    if let Ok(file) = std::env::var("AFTERIMAGE_SHOT") {
        let mut image = Image::new_target_texture(960, 540, TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.size = Extent3d { width: 960, height: 540, depth_or_array_layers: 1 };
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let image = images.add(image);
        camera.insert(RenderTarget::Image(image.clone().into()));
        commands.insert_resource(Shot(image, file));
    }
    let floor = StandardMaterial { base_color: Color::srgb(0.2, 0.2, 0.25), perceptual_roughness: 0.4, ..default() };
    commands
        .spawn((Mesh3d(meshes.add(Plane3d::default().mesh().size(40.0, 40.0))), MeshMaterial3d(materials.add(floor))));
    commands.spawn((PointLight { intensity: 400_000.0, ..default() }, Transform::from_xyz(3.0, 6.0, 4.0)));
    let sphere = meshes.add(Sphere::new(0.6).mesh().uv(48, 32));
    for index in 0..7 {
        let hue = index as f32 * 360.0 / 7.0;
        let light = LinearRgba::from(Hsla::hsl(hue, 0.8, 0.5)) * 4.0_f32.powi(index - 2);
        let base_color = Color::hsl(hue, 0.4, 0.4);
        let material = StandardMaterial { base_color, emissive: light, ..default() };
        let place = Transform::from_xyz(index as f32 * 1.5 - 4.5, 0.6, 0.0);
        commands.spawn((Mesh3d(sphere.clone()), MeshMaterial3d(materials.add(material)), place, Turning));
    }
}

fn turn(time: Res<Time>, mut spheres: Query<&mut Transform, With<Turning>>) {
    for mut place in &mut spheres {
        place.translation.y = 0.6 + 0.3 * (time.elapsed_secs() + place.translation.x).sin().abs();
    }
}

fn shoot(mut commands: Commands, shot: Option<Res<Shot>>, mut frame: Local<u32>, mut exit: MessageWriter<AppExit>) {
    let Some(shot) = shot else { return };
    *frame += 1;
    if *frame == 60 {
        commands.spawn(Screenshot::image(shot.0.clone())).observe(save_to_disk(shot.1.clone()));
    }
    if *frame == 90 {
        exit.write(AppExit::Success);
    }
}
