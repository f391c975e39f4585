//! A camera walks from the dim room to the bright window: the exposure follows, and how often frames come makes no
//! difference.

use afterimage::offline::Session;
use afterimage_gpu::{FrameKind, FrameStep, InputImage};
use afterimage_graph::image::Size;
use afterimage_plan::Options;

use super::{bits, camera, scene, up_to};
use crate::support::gpu::{Picture, Run, Shared, built_in, gpu, graph};
use crate::support::sequence::Sequence;

const SIZE: Size = Size { width: 48, height: 27, depth: 1 };
/// The frames of the walk: 96 at 24 in a second.
const SECONDS: f64 = 4.0;

/// A camera in the built-in scene, and two meters on its image: one that adapts, one that starts again in each frame.
struct Walk {
    camera: Session,
    adapts: Session,
    starts: Session,
    seen: Picture,
    image: InputImage,
    _gpu: Shared,
}

impl Walk {
    fn new() -> Self {
        let (view, exposed) = (graph(&camera(0.0)), up_to("exposed"));
        let gpu = gpu();
        let exposure = Run::new(&exposed).exact();
        let (adapts, starts) = (exposure.session(&gpu), exposure.session(&gpu));
        let mut camera = Run::new(&view).session(&gpu);
        let (seen, image) = look(&mut camera);
        Self { camera, adapts, starts, seen, image, _gpu: gpu }
    }

    fn go_to(&mut self, walk: f64) {
        let view = graph(&camera(walk.clamp(0.0, 1.0)));
        self.camera.change(view, Options::default());
        (self.seen, self.image) = look(&mut self.camera);
    }

    /// The stops of the exposure after `dt` more seconds.
    fn follow(&mut self, dt: f64) -> f64 {
        gain(&self.seen, &expose(&mut self.adapts, &self.image, dt, false))
    }

    /// The same after a declared cut.
    fn cut(&mut self) -> f64 {
        gain(&self.seen, &expose(&mut self.adapts, &self.image, 0.0, true))
    }

    /// The stops that the present view asks for.
    fn wanted(&mut self) -> f64 {
        gain(&self.seen, &expose(&mut self.starts, &self.image, 0.0, true))
    }
}

/// What the camera sees, on the host and on the device.
fn look(camera: &mut Session) -> (Picture, InputImage) {
    camera.render(SIZE, &[], FrameStep::default()).expect("the scene renders");
    let texels = camera.output("scene").expect("the scene is read back");
    (Picture::of(&texels), camera.output_image("scene", "scene"))
}

fn expose(exposure: &mut Session, scene: &InputImage, dt: f64, reset: bool) -> Picture {
    let step = FrameStep { time: 0.0, dt: dt as f32, kind: FrameKind::cut_if(reset) };
    exposure.render(SIZE, std::slice::from_ref(scene), step).expect("the scene is exposed");
    Picture::of(&exposure.output("exposed").expect("the picture is read back"))
}

/// The gain of an exposure, from the largest number below 100, which sanitizing has not changed.
fn gain(scene: &Picture, exposed: &Picture) -> f64 {
    let pairs = scene.pixels.as_flattened().iter().zip(exposed.pixels.as_flattened());
    let colors = pairs.enumerate().filter(|(i, (from, _))| i % 4 != 3 && **from < 100.0).map(|(_, pair)| pair);
    let (from, to) = colors.max_by(|a, b| a.0.total_cmp(b.0)).expect("the picture has pixels");
    (f64::from(*to) / f64::from(*from)).log2()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exposure_follows_a_walk_never_passes_its_aim_and_arrives() {
    let mut walk = Walk::new();
    let mut before = walk.cut();
    let start = before;
    for frame in 1..96 {
        walk.go_to(f64::from(frame) / 95.0);
        let wanted = walk.wanted();
        let after = walk.follow(1.0 / 24.0);
        let (step, way) = (after - before, wanted - before);
        assert!(step * way >= -1e-9, "frame {frame} goes from {before} to {after}, away from {wanted}");
        assert!(step.abs() <= way.abs() + 1e-4, "frame {frame} goes from {before} to {after}, past {wanted}");
        before = after;
    }
    let wanted = walk.wanted();
    assert!(start - wanted > 3.0, "the window is brighter than the room: {start} and {wanted} stops");
    // The eye rests: from here on the way left gets shorter with every frame, until there is none.
    for frame in 0..72 {
        let after = walk.follow(1.0 / 24.0);
        assert!(
            (after - wanted).abs() <= (before - wanted).abs() + 1e-6,
            "held frame {frame}: {before} {after} {wanted}"
        );
        assert!((after - wanted) * (before - wanted) >= -1e-6, "held frame {frame}: {before} {after} {wanted}");
        before = after;
    }
    assert!((before - wanted).abs() < 1e-5, "{before} has not arrived at {wanted}");
}

/// The exposure every twelfth of a second of the walk and of a second of rest behind it.
fn at_rate(walk: &mut Walk, rate: u32) -> Vec<f64> {
    walk.go_to(0.0);
    let mut stops = vec![walk.cut()];
    for frame in 1..=rate * (SECONDS as u32 + 1) {
        walk.go_to(f64::from(frame) / f64::from(rate) / SECONDS);
        let followed = walk.follow(1.0 / f64::from(rate));
        if frame % (rate / 12) == 0 {
            stops.push(followed);
        }
    }
    stops
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exposure_is_the_same_at_24_60_and_144_frames_in_a_second() {
    let mut walk = Walk::new();
    let [film, screen, fast] = [24, 60, 144].map(|rate| at_rate(&mut walk, rate));
    assert!((film[0] - film[60]).abs() > 3.0, "the exposure moves: {film:?}");
    for (name, other, most) in [("24", film, 0.01), ("60", screen, 0.01)] {
        let off = other.iter().zip(&fast).map(|(a, b)| ((a - b).exp2() - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < most, "{name} frames in a second are off by {off}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_declared_cut_is_right_at_once() {
    let mut walk = Walk::new();
    walk.cut();
    walk.go_to(1.0);
    let wanted = walk.wanted();
    let undeclared = walk.follow(1.0 / 24.0);
    assert!((undeclared - wanted).abs() > 2.0, "without a cut the eye takes its time: {undeclared} {wanted}");
    assert_eq!(walk.cut(), wanted);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn two_runs_of_a_sequence_have_the_same_bits() {
    let graph = built_in(super::PIPELINE, None);
    let scenes = [0.0, 0.5, 1.0].map(|walk| scene(96, 54, walk));
    let run = Run::new(&graph);
    let render = || {
        let mut sequence = Sequence::new(&run);
        let frames = scenes.iter().enumerate().map(|(index, scene)| {
            sequence.frame(&[("scene", scene)], 1.0 / 24.0, index == 0);
            sequence.output("display")
        });
        frames.collect::<Vec<Picture>>()
    };
    let first = render();
    assert_ne!(bits(&first[..1]), bits(&first[2..]), "the frames differ");
    assert_eq!(bits(&first), bits(&render()));
}

/// Memory that an earlier frame has written does not change the frame: it has the bits of a first frame.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_after_a_cut_remembers_nothing() {
    let graph = built_in(super::PIPELINE, None);
    let [dim, bright] = [0.0, 1.0].map(|walk| scene(96, 54, walk));
    let run = Run::new(&graph);
    let last = |frames: &[(&Picture, f32)]| {
        let mut sequence = Sequence::new(&run);
        frames.iter().for_each(|(scene, dt)| sequence.frame(&[("scene", scene)], *dt, true));
        sequence.output("display")
    };
    assert_eq!(bits(&[last(&[(&bright, 0.0), (&dim, 0.5)])]), bits(&[last(&[(&dim, 0.0)])]));
}
