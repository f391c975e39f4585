//! Emissive spheres through a pipeline: `spheres [PIPELINE [TIER]]`, from the folder `pipelines` of the repository.
//!
//! With `AFTERIMAGE_SHOT=picture.png` it has no window: it renders 90 frames, writes the last one and ends.

use bevy::prelude::*;
use bevy_afterimage::Afterimage;
use shot::Shot;

#[path = "common/shot.rs"]
mod shot;

fn main() {
    shot::app("Spheres", UVec2::new(1280, 720))
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight { brightness: 30.0, ..default() })
        .add_systems(Startup, scene)
        .add_systems(Update, turn)
        .run();
}

#[derive(Component)]
struct Turning;

fn scene(
    mut commands: Commands,
    assets: Res<AssetServer>,
    shot: Option<Res<Shot>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut words = std::env::args().skip(1);
    let pipeline = words.next().unwrap_or_else(|| "lynx.ron".into());
    let mut look = Afterimage::new(assets.load(pipeline));
    look.tier = words.next();
    let place = Transform::from_xyz(0.0, 2.2, 9.0).looking_at(Vec3::new(0.0, 0.7, 0.0), Vec3::Y);
    let mut camera = commands.spawn((Camera3d::default(), place, look));
    if let Some(shot) = shot {
        camera.insert(shot.target());
    }
    let floor = StandardMaterial { base_color: Color::srgb(0.3, 0.3, 0.34), perceptual_roughness: 0.3, ..default() };
    let plane = meshes.add(Plane3d::default().mesh().size(60.0, 60.0));
    commands.spawn((Mesh3d(plane), MeshMaterial3d(materials.add(floor))));
    let sphere = meshes.add(Sphere::new(0.6).mesh().uv(64, 40));
    for index in 0..7 {
        let hue = index as f32 * 360.0 / 7.0;
        // From a dim ember to a lamp 200 times as bright.
        let light = LinearRgba::from(Hsla::hsl(hue, 0.9, 0.55)) * 2.4_f32.powi(index - 1);
        let material = StandardMaterial { base_color: Color::hsl(hue, 0.4, 0.3), emissive: light, ..default() };
        let place = Transform::from_xyz(index as f32 * 1.5 - 4.5, 0.6, 0.0);
        let lamp = PointLight {
            color: Color::hsl(hue, 0.9, 0.6),
            intensity: 9000.0 * 2.0_f32.powi(index),
            range: 30.0,
            radius: 0.6,
            ..default()
        };
        let parts = (Mesh3d(sphere.clone()), MeshMaterial3d(materials.add(material)), place, Turning);
        commands.spawn(parts).with_child((lamp, Transform::from_xyz(0.0, 0.0, 0.9)));
    }
}

fn turn(time: Res<Time>, mut spheres: Query<&mut Transform, With<Turning>>) {
    for mut place in &mut spheres {
        place.translation.y = 0.6 + 0.5 * (1.4 * time.elapsed_secs() + 0.8 * place.translation.x).sin().abs();
    }
}
