//! Cameras with viewports, and 2-D cameras.

use bevy::camera::visibility::RenderLayers;
use bevy::camera::{CameraOutputMode, CompositingSpace, Viewport};
use bevy::math::URect;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_afterimage::{Afterimage, Target};

use crate::program::{PASS, cut, differing, pass, rendered, texels};
use crate::shown::{BACKGROUND, SIZE, Shown, pipelines};

/// The parts of a split screen; one is not at the border, and neither has the other's size.
const PARTS: [URect; 2] =
    [URect { min: UVec2::ZERO, max: UVec2::new(78, 90) }, URect { min: UVec2::new(82, 6), max: UVec2::new(157, 86) }];

const PLACES: [Vec3; 2] = [Vec3::new(-2.5, 1.0, 6.0), Vec3::new(3.0, 1.5, 5.0)];

/// Two cameras side by side, each with a pipeline.
fn split(folder: &std::path::Path, files: [&str; 2], format: TextureFormat, target: Target) -> Shown {
    let mut shown = Shown::new(folder, format);
    for (order, (part, place)) in PARTS.into_iter().zip(PLACES).enumerate() {
        let viewport = Viewport { physical_position: part.min, physical_size: part.size(), ..default() };
        let camera = Camera { viewport: Some(viewport), order: order as isize, ..default() };
        let look = shown.look(files[order]).target(target);
        shown.spawn(place, (camera, look));
    }
    shown
}

#[test]
fn each_half_of_a_split_screen_is_what_the_program_makes_of_it() {
    let own = pass("split");
    let light = split(&own.0, ["pass.ron"; 2], TextureFormat::Rgba16Float, Target::MainTexture).settled();
    // The second pair has a meter: with a common one, no half would be right. What has been adapted for a while may
    // be another code than in a first frame.
    for (files, most) in [(["lynx.ron", "caracal.ron"], 0), (["lynx.ron"; 2], 0), (["exposure.ron"; 2], 1)] {
        for target in [Target::MainTexture, Target::Output] {
            let shown = split(&pipelines(), files, TextureFormat::Rgba8UnormSrgb, target).settled();
            for (part, file) in PARTS.into_iter().zip(files) {
                let wanted = rendered(file, &texels(&light, part));
                let off = differing(&cut(&shown, 4, part), &wanted);
                assert!(off.1 <= most, "{file}, {part:?}, {target:?}: {off:?}");
            }
            assert_around(&shown, target);
        }
    }
}

/// Cameras with one pipeline share plans, and not what is set.
#[test]
fn cameras_of_one_pipeline_have_their_own_settings() {
    let settings: [fn(Afterimage) -> Afterimage; 2] =
        [|look| look.set("lit.strength", 0.9), |look| look.tier("low").set("lit.strength", 0.05)];
    let shown_with = |ours: &[usize]| {
        let mut shown = Shown::new(&pipelines(), TextureFormat::Rgba8UnormSrgb);
        for camera in ours {
            let viewport =
                Viewport { physical_position: PARTS[*camera].min, physical_size: PARTS[*camera].size(), ..default() };
            let parts = Camera { viewport: Some(viewport), order: *camera as isize, ..default() };
            let look = settings[*camera](shown.look("lynx.ron"));
            shown.spawn(PLACES[*camera], (parts, look));
        }
        shown.settled()
    };
    let both = shown_with(&[0, 1]);
    for (camera, part) in PARTS.into_iter().enumerate() {
        let alone = shown_with(&[camera]);
        assert_eq!(differing(&cut(&both, 4, part), &cut(&alone, 4, part)), (0, 0), "{camera}");
    }
}

/// What does not suit is an error of the frame, which goes with it.
#[test]
fn what_does_not_suit_a_camera_is_said() {
    let mut shown =
        Shown::with_camera(&pipelines(), "lynx.ron", TextureFormat::Rgba8UnormSrgb, |look| look.target(Target::Output));
    let first = shown.settled();
    let world = shown.app.world_mut();
    let camera = world.query_filtered::<Entity, With<Afterimage>>().single(world).expect("there is one camera");
    // Bevy does not draw a camera at all that clears and writes no output.
    let mut parts = world.get_mut::<Camera>(camera).expect("it is one");
    (parts.output_mode, parts.clear_color) = (CameraOutputMode::Skip, ClearColorConfig::None);
    let status = shown.until("an error", |status| status.frame.is_some());
    assert!(status.frame.as_ref().is_some_and(|why| why.contains("Skip")) && !status.is_running, "{status:?}");
    let mut parts = shown.app.world_mut().get_mut::<Camera>(camera).expect("it is one");
    (parts.output_mode, parts.clear_color) = default();
    shown.until("no error", |status| status.frame.is_none() && status.is_running);
    assert_eq!(differing(&shown.settled(), &first), (0, 0));
}

/// Bevy has other spaces than that of linear light for 2-D cameras.
#[test]
fn a_camera_that_does_not_hold_linear_light_is_said() {
    let mut shown = Shown::new(&pipelines(), TextureFormat::Rgba8UnormSrgb);
    let (look, target) = (shown.look("lynx.ron"), shown.target.clone());
    let parts = (Camera2d, Msaa::Off, target, look, CompositingSpace::Oklab);
    let camera = shown.app.world_mut().spawn(parts).id();
    let status = shown.until("an error", |status| status.frame.is_some());
    assert!(status.frame.as_ref().is_some_and(|why| why.contains("CompositingSpace")), "{status:?}");
    shown.app.world_mut().entity_mut(camera).insert(CompositingSpace::Linear);
    shown.until("no error", |status| status.frame.is_none() && status.is_running);
}

/// What lies in no viewport has the color of the background.
fn assert_around(shown: &[u8], target: Target) {
    let background = Srgba::from(BACKGROUND).to_u8_array();
    for (at, texel) in shown.as_chunks::<4>().0.iter().enumerate() {
        let place = UVec2::new(at as u32 % SIZE.x, at as u32 / SIZE.x);
        let is_inside = |part: &URect| place.cmpge(part.min).all() && place.cmplt(part.max).all();
        if !PARTS.iter().any(is_inside) {
            assert_eq!(*texel, background, "{place}, {target:?}");
        }
    }
}

/// Cameras without a clear draw onto what those before have left in the main texture.
#[test]
fn a_viewport_keeps_what_other_cameras_have_drawn_around_it() {
    let own = pass("around");
    own.write("bright.ron", &PASS.replace("stops: 0.0", "stops: 1.0"));
    let bright = Shown::with_camera(&own.0, "bright.ron", TextureFormat::Rgba16Float, |look| look).settled();
    let mut shown = Shown::with_camera(&own.0, "bright.ron", TextureFormat::Rgba16Float, |look| look);
    let camera = |order, viewport| Camera { order, viewport, clear_color: ClearColorConfig::None, ..default() };
    let part = PARTS[1];
    let viewport = Viewport { physical_position: part.min, physical_size: part.size(), ..default() };
    let looks = ["bright.ron", "pass.ron"].map(|file| shown.look(file));
    for (look, camera) in looks.into_iter().zip([camera(1, Some(viewport)), camera(2, None)]) {
        // They draw nothing of their own.
        shown.spawn(PLACES[0], (camera, RenderLayers::none(), look));
    }
    let twice = shown.settled();
    let outside = |bytes: &[u8], texel: usize| {
        let mut bytes = bytes.to_vec();
        for row in part.min.y..part.max.y {
            let first = (row * SIZE.x + part.min.x) as usize * texel;
            bytes[first..first + part.width() as usize * texel].fill(0);
        }
        bytes
    };
    assert_eq!(differing(&outside(&twice, 8), &outside(&bright, 8)), (0, 0));
    // Within it, light is brighter by a stop: the next exponent of half floats, in the high byte.
    let brighter =
        cut(&bright, 8, part).iter().zip(cut(&twice, 8, part)).filter(|(once, twice)| **once + 4 == *twice).count();
    assert!(brighter > (part.width() * part.height()) as usize * 2, "{brighter}");
}

#[test]
fn a_camera_of_sprites_shows_what_the_program_makes_of_its_image() {
    let flat = |folder: &std::path::Path, file: &str, format| {
        let mut shown = Shown::new(folder, format);
        let (look, target) = (shown.look(file), shown.target.clone());
        let world = shown.app.world_mut();
        for index in 0..6 {
            let color = Color::from(LinearRgba::rgb(0.2, 0.7, 1.5) * 2.0_f32.powi(index - 1));
            let sprite = Sprite::from_color(color, Vec2::new(12.0, 30.0 + 4.0 * index as f32));
            world.spawn((sprite, Transform::from_xyz(22.0 * index as f32 - 55.0, 3.0 * index as f32 - 8.0, 0.0)));
        }
        world.spawn((Camera2d, Msaa::Off, target, look));
        shown.settled()
    };
    let own = pass("flat");
    let light = flat(&own.0, "pass.ron", TextureFormat::Rgba16Float);
    let scene = texels(&light, URect { min: UVec2::ZERO, max: SIZE });
    for file in ["lynx.ron", "caracal.ron"] {
        let shown = flat(&pipelines(), file, TextureFormat::Rgba8UnormSrgb);
        assert_eq!(differing(&shown, &rendered(file, &scene)), (0, 0), "{file}");
    }
}

/// Bevy draws its UI after the pipeline, as it is. On the output itself nothing comes on top.
#[test]
fn the_user_interface_is_drawn_on_the_result() {
    let color = Srgba::rgb_u8(40, 90, 220);
    let part = URect::new(20, 10, 60, 40);
    for target in [Target::MainTexture, Target::Output] {
        let to_target = |look: Afterimage| look.target(target);
        let mut shown = Shown::with_camera(&pipelines(), "lynx.ron", TextureFormat::Rgba8UnormSrgb, to_target);
        let without = shown.settled();
        let world = shown.app.world_mut();
        let camera = world.query_filtered::<Entity, With<Camera3d>>().single(world).expect("there is one camera");
        let node = Node {
            position_type: PositionType::Absolute,
            left: px(part.min.x as f32),
            top: px(part.min.y as f32),
            width: px(part.width() as f32),
            height: px(part.height() as f32),
            ..default()
        };
        world.spawn((node, BackgroundColor(color.into()), UiTargetCamera(camera)));
        let mut wanted = without.clone();
        if target == Target::MainTexture {
            for row in part.min.y..part.max.y {
                let first = (row * SIZE.x + part.min.x) as usize * 4;
                let texels = &mut wanted[first..first + part.width() as usize * 4];
                texels.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| *texel = color.to_u8_array());
            }
        }
        shown.run(20);
        // The main texture holds the color in half floats, which may be another code.
        assert!(differing(&shown.settled(), &wanted).1 <= 1, "{target:?}");
    }
}
