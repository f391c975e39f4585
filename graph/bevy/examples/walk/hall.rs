//! A hall of columns at night: lanterns between them, and a door into the light at its end.

use bevy::prelude::*;

/// A light that burns unevenly around a mean.
#[derive(Component)]
pub(crate) struct Lantern {
    pub(crate) lumens: f32,
    pub(crate) phase: f32,
}

/// Distance of the columns along the hall.
const BAY: f32 = 4.0;
const BAYS: i32 = 7;
/// Where the hall ends.
const END: f32 = -19.0;

pub(crate) fn build(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut stone = |base_color: Color, perceptual_roughness| {
        materials.add(StandardMaterial { base_color, perceptual_roughness, reflectance: 0.6, ..default() })
    };
    let (floor, wall) = (stone(Color::srgb(0.2, 0.19, 0.19), 0.22), stone(Color::srgb(0.33, 0.3, 0.28), 0.85));
    let (column, wood) = (stone(Color::srgb(0.46, 0.41, 0.36), 0.6), stone(Color::srgb(0.2, 0.1, 0.06), 0.7));
    let mut glow =
        |light: LinearRgba| materials.add(StandardMaterial { base_color: Color::BLACK, emissive: light, ..default() });
    let (flame, door) = (glow(LinearRgba::rgb(26.0, 12.0, 3.6)), glow(LinearRgba::rgb(15.0, 19.0, 26.0)));
    let inlay = glow(LinearRgba::rgb(0.05, 1.5, 1.7));
    let mut block = |size: Vec3, place: Vec3, material: &Handle<StandardMaterial>| {
        let mesh = meshes.add(Cuboid::from_size(size));
        commands.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone()), Transform::from_translation(place)));
    };
    block(Vec3::new(14.0, 0.2, 40.0), Vec3::new(0.0, -0.1, -4.0), &floor);
    for side in [-1.0, 1.0] {
        block(Vec3::new(0.4, 6.0, 40.0), Vec3::new(side * 5.4, 3.0, -4.0), &wall);
        // The end has an opening.
        block(Vec3::new(4.2, 6.0, 0.4), Vec3::new(side * 3.4, 3.0, END), &wall);
        block(Vec3::new(0.07, 0.05, 30.0), Vec3::new(side * 2.45, 0.01, -4.0), &inlay);
    }
    block(Vec3::new(2.6, 2.4, 0.4), Vec3::new(0.0, 4.8, END), &wall);
    block(Vec3::new(2.6, 3.6, 0.1), Vec3::new(0.0, 1.8, END - 0.4), &door);
    block(Vec3::new(11.0, 0.3, 40.0), Vec3::new(0.0, 5.2, -4.0), &wood);
    for bay in 0..BAYS {
        let z = 7.0 - BAY * bay as f32;
        block(Vec3::new(11.0, 0.4, 0.45), Vec3::new(0.0, 4.85, z), &wood);
        for side in [-1.0, 1.0] {
            block(Vec3::new(1.05, 0.28, 1.05), Vec3::new(side * 3.2, 0.14, z), &column);
            block(Vec3::new(1.0, 0.3, 1.0), Vec3::new(side * 3.2, 4.5, z), &column);
        }
    }
    let (shaft, globe) = (meshes.add(Cylinder::new(0.36, 4.2)), meshes.add(Sphere::new(0.13).mesh().uv(32, 20)));
    for index in 0..2 * BAYS {
        let (bay, side) = ((index / 2) as f32, if index % 2 == 0 { -1.0 } else { 1.0 });
        let z = 7.0 - BAY * bay;
        let place = Transform::from_xyz(side * 3.2, 2.3, z);
        commands.spawn((Mesh3d(shaft.clone()), MeshMaterial3d(column.clone()), place));
        // Lanterns hang to one side in each bay, in turn.
        if (index / 2 + index) % 2 == 0 {
            let lantern = Lantern { lumens: 95_000.0, phase: 1.7 * index as f32 };
            let color = Color::srgb(1.0, 0.62, 0.3);
            let light = PointLight { color, intensity: lantern.lumens, range: 14.0, radius: 0.13, ..default() };
            let place = Transform::from_xyz(side * 2.1, 2.55, z - 0.5 * BAY);
            let parts = (Mesh3d(globe.clone()), MeshMaterial3d(flame.clone()), place);
            commands.spawn(parts).with_child((light, lantern));
        }
    }
    let light = PointLight { color: Color::srgb(0.75, 0.86, 1.0), intensity: 900_000.0, range: 30.0, ..default() };
    commands.spawn((PointLight { shadow_maps_enabled: true, ..light }, Transform::from_xyz(0.0, 2.4, END + 1.2)));
    let brass = StandardMaterial {
        base_color: Color::srgb(0.9, 0.65, 0.3),
        metallic: 1.0,
        perceptual_roughness: 0.25,
        ..default()
    };
    let (ball, brass) = (meshes.add(Sphere::new(0.45).mesh().uv(48, 32)), materials.add(brass));
    for (x, z) in [(1.25, 2.6), (-1.5, -3.4), (1.5, -9.0)] {
        commands.spawn((Mesh3d(ball.clone()), MeshMaterial3d(brass.clone()), Transform::from_xyz(x, 0.45, z)));
    }
}
