//! A camera walks from the dim room to the bright window: the exposure follows, and how often frames come makes no
//! difference.

use std::sync::Arc;

use afterimage_gpu::{Executor, Frame};
use afterimage_graph::image::Size;
use afterimage_plan::Plan;

use super::{bits, camera, scene, up_to};
use crate::support::gpu::{Picture, Run, graph, shipped};
use crate::support::player::Player;

const SIZE: [u32; 2] = [48, 27];
/// How long the walk takes: 96 frames at 24 in a second.
const SECONDS: f64 = 4.0;

/// A camera in the built-in scene, and two meters on what it sees: one that follows, one that is right at once.
struct Walk {
    player: Player,
    follows: Executor,
    snaps: Executor,
    seen: Picture,
    view: wgpu::TextureView,
}

impl Walk {
    fn new() -> Self {
        let graph = up_to("exposed");
        let mut run = Run::new(&graph).exact();
        run.half_inputs = true;
        let mut player = Player::new();
        let shape = Picture::new(SIZE[0], SIZE[1], |_, _| [0.0; 4]);
        let plan = Arc::new(run.plan(&player.gpu, &[("scene", &shape)]));
        let follows = player.spare(plan.clone());
        let snaps = player.spare(plan);
        let (seen, view) = look(&mut player, 0.0);
        Self { player, follows, snaps, seen, view }
    }

    fn go_to(&mut self, walk: f64) {
        (self.seen, self.view) = look(&mut self.player, walk.clamp(0.0, 1.0));
    }

    /// The stops of the exposure after `dt` more seconds.
    fn follow(&mut self, dt: f64) -> f64 {
        self.stops(dt, false)
    }

    /// The same after a declared cut.
    fn cut(&mut self) -> f64 {
        self.stops(0.0, true)
    }

    fn stops(&mut self, dt: f64, reset: bool) -> f64 {
        std::mem::swap(&mut self.player.executor, &mut self.follows);
        let exposed = expose(&mut self.player, &self.view, dt, reset);
        std::mem::swap(&mut self.player.executor, &mut self.follows);
        gain(&self.seen, &exposed)
    }

    /// The stops that the present view asks for.
    fn wanted(&mut self) -> f64 {
        std::mem::swap(&mut self.player.executor, &mut self.snaps);
        let exposed = expose(&mut self.player, &self.view, 0.0, true);
        std::mem::swap(&mut self.player.executor, &mut self.snaps);
        gain(&self.seen, &exposed)
    }
}

fn look(player: &mut Player, walk: f64) -> (Picture, wgpu::TextureView) {
    let graph = graph(&camera(walk));
    let mut run = Run::new(&graph);
    run.size = Size::new(SIZE[0], SIZE[1]);
    player.load(&run, &[]);
    player.run(&Frame::default()).expect("the scene renders");
    let texture = player.executor.output("scene").expect("it is an output");
    (player.read(texture), texture.create_view(&Default::default()))
}

fn expose(player: &mut Player, scene: &wgpu::TextureView, dt: f64, reset: bool) -> Picture {
    let frame = Frame { inputs: &[("scene", scene)], dt: dt as f32, reset, ..Frame::default() };
    player.run(&frame).expect("the scene is exposed");
    player.output("exposed")
}

/// The gain of an exposure, from the largest number below 100, which sanitizing has not changed.
fn gain(scene: &Picture, exposed: &Picture) -> f64 {
    let pairs = scene.pixels.as_flattened().iter().zip(exposed.pixels.as_flattened());
    let colours = pairs.enumerate().filter(|(i, (from, _))| i % 4 != 3 && **from < 100.0).map(|(_, pair)| pair);
    let (from, to) = colours.max_by(|a, b| a.0.total_cmp(b.0)).expect("the picture has pixels");
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
    let graph = shipped(super::PIPELINE, None);
    let scenes = [0.0, 0.5, 1.0].map(|walk| scene(96, 54, walk));
    let run = || {
        let mut player = Player::new();
        player.load(&Run::new(&graph), &[("scene", &scenes[0])]);
        let frames = scenes.iter().enumerate().map(|(index, scene)| {
            player.frame(&[("scene", scene)], 1.0 / 24.0, index == 0);
            player.output("display")
        });
        frames.collect::<Vec<Picture>>()
    };
    let first = run();
    assert_ne!(bits(&first[..1]), bits(&first[2..]), "the frames differ");
    assert_eq!(bits(&first), bits(&run()));
}

/// What of a plan's memory an earlier frame has left must not be seen: the same frame in another executor has the same
/// bits.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_after_a_cut_remembers_nothing() {
    let graph = shipped(super::PIPELINE, None);
    let [dim, bright] = [0.0, 1.0].map(|walk| scene(96, 54, walk));
    let mut player = Player::new();
    let _: Arc<Plan> = player.load(&Run::new(&graph), &[("scene", &bright)]);
    player.frame(&[("scene", &bright)], 0.0, true);
    player.frame(&[("scene", &dim)], 0.5, true);
    let after = player.output("display");
    player.renew();
    player.load(&Run::new(&graph), &[("scene", &dim)]);
    player.frame(&[("scene", &dim)], 0.0, true);
    assert_eq!(bits(&[after]), bits(&[player.output("display")]));
}
