//! Cross-fades of changes, and what ends them.

use bevy::camera::Viewport;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_afterimage::{Afterimage, Target};

use crate::program::{differing, half};
use crate::said;
use crate::shown::{Folder, SIZE, Shown};

/// Twice the light with a fact.
const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color },
    facts: { "bright": "Whether the light is on." },
    nodes: {
        "lit": Exposure(source: "scene", stops: 1.0, when: "bright"),
        "out": Vignette(source: "lit", amount: 0.1),
    },
    outputs: { "out": "out" },
)"#;

/// Half floats of a camera in the dark.
fn dark(folder: &Folder, look: &str, fade: u16) -> Shown {
    folder.write("look.ron", look);
    let dark = |look: Afterimage| look.fact("bright", false).fade(fade);
    let mut shown = Shown::with_camera(&folder.0, "look.ron", TextureFormat::Rgba16Float, dark);
    shown.until("a frame", |status| status.is_running);
    shown
}

fn switch_on(look: &mut Afterimage) {
    look.facts.insert("bright".into(), true.into());
}

/// The frames from the last one like `old` on, and as many after it.
fn from_the_change(shown: &mut Shown, old: &Vec<u8>, after: usize) -> Vec<Vec<u8>> {
    let first = |frames: &[Vec<u8>]| frames.iter().position(|frame| frame != old);
    let is_over = |frames: &[Vec<u8>]| first(frames).is_some_and(|first| frames.len() >= first + after);
    let frames = shown.frames("a change", |_| (), is_over);
    let first = first(&frames).expect("it has come");
    assert!(first > 0, "the plan is made in the background");
    frames[first - 1..first + after].to_vec()
}

/// The light of a picture.
fn light(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<2>().0.iter().map(|bits| half(u16::from_le_bytes(*bits))).collect()
}

/// Whatever the target is, and in a viewport, around which nothing changes.
#[test]
fn each_frame_of_a_fade_is_a_mix() {
    let part = Viewport { physical_position: UVec2::new(20, 10), physical_size: UVec2::new(100, 60), ..default() };
    for target in [Target::MainTexture, Target::Output] {
        for viewport in [None, Some(part.clone())] {
            let own = Folder::new("mix");
            let mut shown = dark(&own, LOOK, 7);
            shown.change(|look| look.target = target);
            let world = shown.app.world_mut();
            world.query::<&mut Camera>().single_mut(world).expect("there is one camera").viewport = viewport;
            let old = shown.settled();
            shown.change(switch_on);
            let frames = from_the_change(&mut shown, &old, 10);
            assert_mixed(&frames, &shown.settled());
            assert_eq!(shown.status().fade_skip_reason, None, "{target:?}");
        }
    }
}

/// Seven frames between the first one and those that are like the new picture, which has twice the light.
fn assert_mixed(frames: &[Vec<u8>], new: &[u8]) {
    frames[8..].iter().for_each(|frame| assert_eq!(differing(frame, new), (0, 0)));
    let [before, after] = [&*frames[0], new].map(light);
    let brighter = before.iter().zip(&after).filter(|(before, after)| **after == 2.0 * **before && **before > 0.1);
    assert!(brighter.count() > 1000);
    for (number, frame) in frames[..8].iter().enumerate() {
        let share = number as f32 / 8.0;
        for ((before, after), now) in before.iter().zip(&after).zip(light(frame)) {
            let wanted = before + (after - before) * share;
            // Half floats are rounded once.
            assert!((now - wanted).abs() <= wanted.abs() / 1024.0 + 1e-6, "{number}: {now}, not {wanted}");
        }
    }
}

/// A file that has changed is another pipeline.
#[test]
fn another_pipeline_fades_in() {
    let own = Folder::new("another");
    let always = |stops: &str| LOOK.replace("stops: 1.0, when: \"bright\"", stops);
    let mut shown = dark(&own, &always("stops: 0.0"), 7);
    let old = shown.settled();
    own.write("look.ron", &always("stops: 1.0"));
    let frames = from_the_change(&mut shown, &old, 10);
    assert_mixed(&frames, &shown.settled());
    assert_eq!(shown.status().fade_skip_reason, None);
}

#[test]
fn a_change_without_a_fade_is_a_cut() {
    let own = Folder::new("cut");
    let mut shown = dark(&own, LOOK, 0);
    let old = shown.settled();
    shown.change(switch_on);
    let frames = from_the_change(&mut shown, &old, 3);
    let new = shown.settled();
    frames[1..].iter().for_each(|frame| assert_eq!(differing(frame, &new), (0, 0)));
    assert_eq!(shown.status().fade_skip_reason, None);
    // The number holds for the change that comes with it.
    shown.change(|look| (look.facts, look.fade) = ([("bright".to_owned(), false.into())].into(), 1));
    let frames = from_the_change(&mut shown, &new, 2);
    assert!(frames[1] != old && frames[2] == old);
}

/// A pipeline with two outputs is not faded: its status and the log say why, once for each change.
#[test]
fn a_refused_fade_is_said_once() {
    said::listen();
    let own = Folder::new("refused");
    let two = LOOK.replace(r#""out": "out" }"#, r#""out": "out", "lit": "lit" }"#);
    let mut shown = dark(&own, &two, 20);
    let old = shown.settled();
    let times = || said::times("did not fade in: the plans do not have one output each");
    assert_eq!((shown.status().fade_skip_reason, times()), (None, 0));
    shown.change(switch_on);
    let frames = from_the_change(&mut shown, &old, 5);
    frames[2..].iter().for_each(|frame| assert_eq!(differing(frame, &frames[1]), (0, 0)));
    shown.run(20);
    let status = shown.status();
    assert!(status.fade_skip_reason.is_some_and(|why| why.contains("one output each")) && status.frame.is_none());
    assert_eq!(times(), 1);
    shown.change(|look| _ = look.facts.insert("bright".into(), false.into()));
    from_the_change(&mut shown, &frames[1], 20);
    assert_eq!(times(), 2);
}

/// The camera that comes after it begins anew.
#[test]
fn a_camera_may_go_while_a_fade_goes_on() {
    let own = Folder::new("gone");
    let mut shown = dark(&own, LOOK, 500);
    let old = shown.settled();
    shown.change(switch_on);
    from_the_change(&mut shown, &old, 5);
    let world = shown.app.world_mut();
    let camera = world.query_filtered::<Entity, With<Afterimage>>().single(world).expect("there is one camera");
    let look = world.get::<Afterimage>(camera).expect("it has one").clone();
    world.despawn(camera);
    shown.run(10);
    let other = shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
    let new = shown.settled();
    let twice = light(&old).into_iter().zip(light(&new)).filter(|(old, new)| *new == 2.0 * old && *old > 0.1);
    assert!(twice.count() > 1000);
    let status = shown.app.world().get::<bevy_afterimage::AfterimageStatus>(other).expect("it has a pipeline");
    assert!(status.is_running && status.frame.is_none() && status.fade_skip_reason.is_none(), "{status:?}");
}

/// Another size of what the camera renders to, as of a window.
#[test]
fn another_size_ends_a_fade() {
    const OTHER: UVec2 = UVec2::new(120, 70);
    let own = Folder::new("size");
    let mut shown = dark(&own, LOOK, 0);
    shown.change(switch_on);
    shown.resize(OTHER);
    let wanted = shown.settled();
    assert_eq!(wanted.len() as u32, OTHER.element_product() * 8);
    let mut shown = dark(&own, LOOK, 500);
    let old = shown.settled();
    assert_eq!(old.len() as u32, SIZE.element_product() * 8);
    shown.change(switch_on);
    from_the_change(&mut shown, &old, 5);
    shown.resize(OTHER);
    shown.once("the new size", |now| now.len() == wanted.len());
    assert_eq!(differing(&shown.settled(), &wanted), (0, 0));
    let status = shown.status();
    let why = status.fade_skip_reason.as_deref().unwrap_or_default();
    assert!(why.contains("images of the host have changed") && status.frame.is_none(), "{status:?}");
}
