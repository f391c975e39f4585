//! Temporal anti-aliasing on the GPU: its history, and sequences of the built-in scene.

use afterimage_graph::image::Size;
use afterimage_graph::node::Camera;
use afterimage_nodes::DemoScene;
use glam::{Mat4, vec3};

use super::lens::{apart, lights, on_glass, over};
use super::occlusion::surfaces;
use super::surface::{eye, scene};
use crate::reference::image::Image;
use crate::reference::taa::{Frames, Taa};
use crate::support::gpu::{Picture, Run, graph};
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, checked, differences, image};
use crate::support::sequence::Sequence;

/// A camera that has moved and turned, with jitter.
pub(super) fn moved() -> Camera {
    let before = Mat4::from_rotation_y(0.03) * Mat4::from_translation(vec3(0.56, -1.48, -4.1));
    Camera {
        previous_view: before.to_cols_array_2d(),
        jitter: [0.25, -0.375],
        previous_jitter: [-0.125, 0.25],
        ..eye()
    }
}

const TAA: Taa =
    Taa { blend: 0.125, moving: 0.5, variance: 1.25, depth_threshold: 0.05, white: 1.0, keep_above: 65504.0 };

/// Places of the history are exact to a thousandth of a texel.
const PLACES: Tolerance =
    Tolerance { absolute: 1e-4, relative: 4e-3, of: Scale::Neighborhood, reason: "places in f32, and their splines" };

/// Pixels of a second frame that differ from the CPU reference, which has all of the images.
fn second_frame(wires: &str, frames: impl Fn(&Frames<'_>) -> Image) {
    let [width, height] = [61, 37];
    let source = lights([width, height]);
    let old = Picture::new(width, height, |x, y| source.at((x + 3) % width, y).map(|light| 0.7 * light + 0.05));
    let depth = surfaces([width, height]);
    let previous = Picture::new(width, height, |x, y| {
        let depth = depth.at(x, y)[0];
        [if x < 20 { depth } else { depth + 2.0 }, 0.0, 0.0, 1.0]
    });
    let motion = Picture::new(width, height, |x, y| [0.02 + 0.0007 * y as f32, 0.031 - 0.001 * x as f32, 0.0, 1.0]);
    let text = format!(
        "\"result\": Taa(source: \"in\", history: \"old\", depth: \"depth\", camera: \"camera\", blend: 0.125, {wires})"
    );
    let inputs = [("in", "Color"), ("old", "Color"), ("depth", "Depth"), ("motion", "Motion"), ("previous", "Depth")];
    let camera = moved();
    let nodes = Nodes::new(&text, &inputs).camera(Some(&camera));
    let graph = nodes.graph();
    let run = Run::new(&graph).camera(Some(&camera)).exact();
    let given = nodes.named(&[&source, &old, &depth, &motion, &previous]);
    let found = run.frames(&given, &[(0.0, true), (0.04, false)]).remove(1).remove(0);
    let [source, old, depth, motion, previous] = [&source, &old, &depth, &motion, &previous].map(image);
    let all = Frames {
        source: &source,
        history: Some(&old),
        depth: &depth,
        previous_depth: Some(&previous),
        motion: Some(&motion),
        camera: &camera,
        ratio: 1.0,
    };
    // The history has steps of 60, so a place that is off by a thousandth of a texel counts, and at a threshold a depth is
    // that of the same surface or not. Without a limit or a rejection, most pixels would differ.
    let off = differences(&found, &frames(&all), &PLACES);
    assert!(off.len() <= found.pixels.len() / 50, "{wires}: {off:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_second_frame_is_that_of_the_cpu_reference() {
    second_frame("motion: \"motion\", previous_depth: \"previous\"", |all| TAA.apply(all));
    second_frame("", |all| TAA.apply(&Frames { motion: None, previous_depth: None, ..*all }));
    second_frame("previous_depth: \"previous\", variance: 0.5, white: 4.0, depth_threshold: 0.2", |all| {
        let taa = Taa { variance: 0.5, white: 4.0, depth_threshold: f64::from(0.2_f32), ..TAA };
        taa.apply(&Frames { motion: None, ..*all })
    });
    second_frame("motion: \"motion\", keep_above: 3.0", |all| {
        let taa = Taa { keep_above: 3.0, ..TAA };
        taa.apply(&Frames { previous_depth: None, ..*all })
    });
}

/// The numbers of Halton's sequence in a base, from -0.5 to 0.5.
pub(super) fn halton(mut index: u32, base: u32) -> f32 {
    let (mut part, mut sum) = (1.0, 0.0);
    while index > 0 {
        part /= base as f32;
        sum += part * (index % base) as f32;
        index /= base;
    }
    sum - 0.5
}

const SIZE: Size = Size { width: 160, height: 90, depth: 1 };
const NODE: &str = "\"result\": Taa(source: \"in\", history: \"result@previous\", depth: \"depth\", camera: \"camera\", \
                    motion: \"motion\", previous_depth: \"before\", white: 1.0)";

/// A frame of the scene as a renderer draws it: one sample in each pixel.
pub(super) struct Drawn {
    room: DemoScene,
    pub(super) light: Picture,
    depth: Picture,
    motion: Picture,
}

/// The parameters of a room, as a pipeline has them.
fn text(room: &DemoScene) -> String {
    let DemoScene { time, walk, step, dt, objects, samples, jitter: [x, y], .. } = room;
    format!(
        "time: {time:?}, walk: {walk:?}, step: {step:?}, dt: {dt:?}, objects: {objects}, samples: {samples}, \
         jitter: ({x:?}, {y:?})"
    )
}

impl Drawn {
    /// The same moment with many samples.
    fn reference(&self) -> Picture {
        self.drawn(64, SIZE)
    }

    /// The same moment with this many samples in the middle of pixels, in any size.
    fn drawn(&self, samples: u32, size: Size) -> Picture {
        let room = DemoScene { samples, jitter: [0.0, 0.0], ..self.room.clone() };
        scene("result", &text(&room), size)
    }
}

/// The frames of a shot from a place of the walk on: it and the time grow by these steps.
pub(super) fn shot(frames: u32, (from, step): (f32, f32), dt: f32, size: Size) -> Vec<Drawn> {
    let room = |index: u32| {
        let jitter = [halton(index % 16 + 1, 2), halton(index % 16 + 1, 3)];
        let at = index as f32;
        let (walk, time) = (from + step * at, 1.0 + dt * at);
        DemoScene { walk, time, step, dt, objects: 2, samples: 1, jitter, ..DemoScene::default() }
    };
    let rooms: Vec<DemoScene> = (0..frames).map(room).collect();
    // All frames in one graph: each kernel of the scene is compiled once.
    let node = |(i, room): (usize, &DemoScene)| format!("\"f{i}\": DemoScene({}), ", text(room));
    let nodes: String = rooms.iter().enumerate().map(node).collect();
    let wires = |i| format!("\"l{i}\": \"f{i}\", \"d{i}\": \"f{i}.depth\", \"m{i}\": \"f{i}.motion\", ");
    let outputs: String = (0..frames).map(wires).collect();
    let graph = graph(&format!("Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})"));
    let mut run = Run::new(&graph).exact();
    run.size = size;
    let mut found = run.frame(&[]).into_iter();
    let mut next = || found.next().expect("three outputs for each frame");
    rooms.into_iter().map(|room| Drawn { room, light: next(), depth: next(), motion: next() }).collect()
}

/// The last image of a shot through these nodes.
pub(super) fn smoothed(node: &str, shot: &[Drawn]) -> Picture {
    let inputs = [("in", "Color"), ("depth", "Depth"), ("motion", "Motion"), ("before", "Depth")];
    let size = Size::new(shot[0].light.width, shot[0].light.height);
    let camera = shot[0].room.camera(size);
    let graph = Nodes::new(node, &inputs).camera(Some(&camera)).graph();
    let run = Run::new(&graph).camera(Some(&camera));
    let mut sequence = Sequence::new(&run);
    for (index, drawn) in shot.iter().enumerate() {
        let before = &shot[index.saturating_sub(1)];
        let camera = Camera { previous_jitter: before.room.jitter, ..drawn.room.camera(size) };
        sequence.camera(&camera);
        let images = [("in", &drawn.light), ("depth", &drawn.depth), ("motion", &drawn.motion)];
        let images: Vec<_> = images.into_iter().chain([("before", &before.depth)]).collect();
        sequence.frame(&images, drawn.room.dt, index == 0);
    }
    sequence.output("out")
}

/// Root mean square of the difference of two images as they are seen, at the pixels that count.
fn error(a: &Picture, b: &Picture, counts: impl Fn(usize) -> bool) -> f64 {
    let seen = |light: f32| f64::from(light / (1.0 + light)).max(0.0).powf(1.0 / 2.2);
    let (mut sum, mut count) = (0.0, 0.0);
    for (_, (a, b)) in a.pixels.iter().zip(&b.pixels).enumerate().filter(|(index, _)| counts(*index)) {
        sum += (0..3).map(|c| (seen(a[c]) - seen(b[c])).powi(2)).sum::<f64>() / 3.0;
        count += 1.0;
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn a_still_image_converges_to_the_supersampled_one() {
    let shot = shot(32, (0.1, 0.0), 0.0, SIZE);
    let wanted = shot[31].reference();
    let [first, fourth, last] = [1, 4, 32].map(|count| error(&smoothed(NODE, &shot[..count]), &wanted, |_| true));
    let aliased = error(&shot[31].light, &wanted, |_| true);
    println!("one sample {aliased:.4}, after 1 frame {first:.4}, 4 {fourth:.4}, 32 {last:.4}");
    assert!(fourth < first && last < fourth && last < 0.55 * aliased, "{aliased}, {first}, {fourth}, {last}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn a_walk_past_moving_objects_is_smooth_and_has_no_ghosts() {
    let shot = shot(20, (0.1, 0.004), 1.0 / 24.0, SIZE);
    let last = &shot[19];
    let wanted = last.reference();
    // Where an object has been in the five frames before, and is not now.
    let masks = [14, 15, 16, 17, 18, 19].map(|at: usize| mask(&shot[at]));
    let uncovered = |index: usize| masks[..5].iter().any(|mask| mask[index]) && !masks[5][index];
    let found = smoothed(NODE, &shot);
    let [all, smooth] = [&last.light, &found].map(|picture| error(picture, &wanted, |_| true));
    let [one, trail] = [&last.light, &found].map(|picture| error(picture, &wanted, uncovered));
    let count = (0..masks[0].len()).filter(|index| uncovered(*index)).count();
    println!("whole: one sample {all:.4}, smoothed {smooth:.4}; {count} pixels of trails: {one:.4}, {trail:.4}");
    assert!(smooth < 0.7 * all && count > 40 && trail < one, "{all}, {smooth}, {count}, {one}, {trail}");
}

/// A picture in twice the size, by the mean of the nearest four pixels.
fn doubled(picture: &Picture) -> Picture {
    let source = image(picture);
    let [width, height] = [picture.width, picture.height].map(|side| 2 * side);
    let wide = Image::from_uv(width as usize, height as usize, |uv| source.tap(uv));
    Picture::new(width, height, |x, y| wide.texel(i64::from(x), i64::from(y)).map(|light| light as f32))
}

/// Errors against many samples in twice the size: of the last frame enlarged, of `Taa` enlarged, of `Taa` that doubles,
/// and of one sample in each pixel of the double size.
fn errors_of_doubling(shot: &[Drawn]) -> [f64; 4] {
    let last = shot.last().expect("there are frames");
    let large = Size::new(2 * SIZE.width, 2 * SIZE.height);
    let wanted = last.drawn(64, large);
    let double = NODE.replace("white: 1.0", "white: 1.0, double: true");
    let found = [doubled(&last.light), doubled(&smoothed(NODE, shot)), smoothed(&double, shot), last.drawn(1, large)];
    found.map(|picture| error(&picture, &wanted, |_| true))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn frames_of_half_the_size_come_to_the_supersampled_whole() {
    let still = errors_of_doubling(&shot(16, (0.1, 0.0), 0.0, SIZE));
    let walk = errors_of_doubling(&shot(16, (0.1, 0.002), 1.0 / 24.0, SIZE));
    println!("enlarged frame, enlarged Taa, doubling Taa, one sample of the double size: {still:.4?}, {walk:.4?}");
    let [enlarged, smooth, double, aliased] = still;
    assert!(double < 0.8 * smooth && double < 0.7 * enlarged && double < aliased, "{still:.4?}");
    let [enlarged, smooth, double, _] = walk;
    assert!(double < smooth && double < 0.9 * enlarged, "{walk:.4?}");
}

/// One frame after another history, with the depths of both frames.
fn after(history: [f32; 4], [before, now]: [f32; 2], source: &Picture) -> Picture {
    let inputs = [("in", "Color"), ("old", "Color"), ("depth", "Depth"), ("before", "Depth")];
    let text = "\"result\": Taa(source: \"in\", history: \"old\", depth: \"depth\", camera: \"camera\", \
                previous_depth: \"before\", blend: 0.1)";
    let flat = |pixel: [f32; 4]| Picture::new(source.width, source.height, |_, _| pixel);
    let (old, before, now) = (flat(history), flat([before, 0.0, 0.0, 1.0]), flat([now, 0.0, 0.0, 1.0]));
    let camera = eye();
    let nodes = Nodes::new(text, &inputs).camera(Some(&camera));
    let graph = nodes.graph();
    let run = Run::new(&graph).camera(Some(&camera)).exact();
    let given = nodes.named(&[source, &old, &now, &before]);
    run.frames(&given, &[(0.0, true), (0.04, false)]).remove(1).remove(0)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_not_there_any_more_leaves_no_trace() {
    // A white history over a gray wall is gone at once.
    let wall = Picture::new(24, 16, |_, _| [0.2, 0.2, 0.2, 1.0]);
    let gray = after([50.0, 0.0, 9.0, 1.0], [3.0, 3.0], &wall);
    assert!(gray.pixels.iter().all(|pixel| (pixel[0] - 0.2).abs() < 1e-4), "{:?}", gray.at(9, 9));
    // Over noise, where it could be a part of it, the depth says that it was another surface.
    let noisy = Picture::new(24, 16, |x, y| [noise(x, y), noise(x, y), noise(x, y), 1.0]);
    let [kept, gone] = [[3.0, 3.0], [2.0, 3.0]].map(|depths| after([0.4, 0.4, 0.4, 1.0], depths, &noisy));
    let alone = after([0.1, 0.1, 0.1, 1.0], [2.0, 3.0], &noisy);
    assert_eq!(gone.pixels, alone.pixels);
    assert!(kept.pixels != gone.pixels);
}

/// A disc of two pixels before the sky, in frames of one sample in each pixel, and then a frame without it: the light
/// above the sky's in each frame, as a share of the disc's.
fn light_of_a_sun(parameters: &str) -> Vec<f64> {
    const SKY: f32 = 6.0;
    let sun = |jitter: [f32; 2], radius: f32| {
        Picture::new(32, 24, move |x, y| {
            let away = [x as f32 + 0.5 + jitter[0] - 16.3, y as f32 + 0.5 + jitter[1] - 11.8];
            let light = if away[0].hypot(away[1]) < radius { 15000.0 } else { SKY };
            [light, light, light, 1.0]
        })
    };
    let text = format!(
        "\"result\": Taa(source: \"in\", history: \"result@previous\", depth: \"depth\", camera: \"camera\", \
         white: 8.0, {parameters})"
    );
    let camera = eye();
    let graph = Nodes::new(&text, &[("in", "Color"), ("depth", "Depth")]).camera(Some(&camera)).graph();
    let run = Run::new(&graph).camera(Some(&camera));
    let mut sequence = Sequence::new(&run);
    let depth = Picture::new(32, 24, |_, _| [3.0, 0.0, 0.0, 1.0]);
    let frame = |index: u32| {
        let jitter = [halton(index % 8 + 1, 2), halton(index % 8 + 1, 3)];
        sequence.camera(&Camera { jitter, ..eye() });
        let light = sun(jitter, if index == 32 { 0.0 } else { 1.0 });
        sequence.frame(&[("in", &light), ("depth", &depth)], 0.04, index == 0);
        let above = |pixel: &[f32; 4]| f64::from(pixel[1] - 1.01 * SKY).max(0.0);
        sequence.output("out").pixels.iter().map(above).sum::<f64>() / (15000.0 * std::f64::consts::PI)
    };
    (0..=32).map(frame).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_small_sun_keeps_its_light_and_leaves_at_once() {
    let [lost, kept] = ["", "keep_above: 64.0"].map(light_of_a_sun);
    assert!(lost[..32].iter().all(|share| *share < 0.5), "{lost:.2?}");
    assert!(kept[16..32].iter().all(|share| (0.85..1.15).contains(share)), "{kept:.2?}");
    assert!(kept[32] == 0.0, "{}", kept[32]);
}

/// The pixels that show an object.
fn mask(drawn: &Drawn) -> Vec<bool> {
    let still = DemoScene { objects: 0, ..drawn.room.clone() };
    let empty = scene("depth", &text(&still), SIZE);
    empty.pixels.iter().zip(&drawn.depth.pixels).map(|(a, b)| (a[0] - b[0]).abs() > 1e-3).collect()
}

/// On exposed light, the history is as bright as the new frame before the two are mixed.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_history_follows_the_exposure() {
    let text = r#"Pipeline(
        inputs: { "in": Color, "light": Color, "depth": Depth, "camera": Camera },
        nodes: {
            "mean": MeanLuminance(source: "light"),
            "metered": Adapt(mean: "mean", rate_dark: 1000.0, rate_bright: 1000.0),
            "exposed": Exposure(source: "in", meter: "metered"),
            "taa": Taa(
                source: "exposed", history: "taa@previous", depth: "depth", camera: "camera", blend: 0.125, variance: 4.0,
                meter: "metered", previous_exposure: "taa.exposure@previous",
            ),
        },
        outputs: { "taa": "taa", "exposed": "exposed" },
    )"#;
    let graph = checked(text, &afterimage_graph::check::NoFiles);
    let (camera, depth) = (moved(), surfaces([61, 37]));
    let run = Run::new(&graph).camera(Some(&camera)).exact();
    let mut sequence = Sequence::new(&run);
    let flat = |light: f32| Picture::new(61, 37, |_, _| [light, light, light, 1.0]);
    let mut frame = |seed: u32, light: f32, reset: bool| {
        let scene = Picture::new(61, 37, |x, y| [noise(x + seed, y), noise(x, y + 40 + seed), noise(x + 90, y), 1.0]);
        sequence.frame(&[("in", &scene), ("light", &flat(light)), ("depth", &depth)], 0.1, reset);
        let [taa, exposed]: [Picture; 2] = sequence.outputs().try_into().expect("two outputs");
        let gain = f64::from(exposed.at(5, 5)[0] / scene.at(5, 5)[0]);
        (taa, exposed, gain)
    };
    let (first, _, before) = frame(0, 0.2, true);
    let (second, exposed, after) = frame(3, 1.6, false);
    assert!(after / before < 0.2, "the exposure follows: {before}, {after}");
    let (source, history, depth) = (image(&exposed), image(&first), image(&depth));
    let frames = Frames {
        source: &source,
        history: Some(&history),
        depth: &depth,
        previous_depth: None,
        motion: None,
        camera: &camera,
        ratio: after / before,
    };
    let taa = Taa { variance: 4.0, ..TAA };
    assert_close("with the exposure", &second, &taa.apply(&frames), &PLACES);
    let without = taa.apply(&Frames { ratio: 1.0, ..frames });
    let off = second.pixels.iter().zip(&without.pixels).filter(|(a, b)| (f64::from(a[0]) - b[0]).abs() > 0.01 * b[0]);
    assert!(off.count() > 1000, "the exposure makes a difference");
}

/// Light that differs from pixel to pixel.
fn noise(x: u32, y: u32) -> f32 {
    0.3 + super::camera::shift(x as usize, y as usize) as f32 * 0.4
}

/// The judge is the same node on the picture over a background: what it makes of a striped disc that moves before
/// nothing, over that background.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kind is")]
fn a_transparent_picture_over_a_background_is_smoothed_as_one() {
    let size = [72, 60];
    let depth = Picture::new(size[0], size[1], |_, _| [3.0, 0.0, 0.0, 1.0]);
    let motion = Picture::new(size[0], size[1], |_, _| [2.3, 1.4, 0.0, 1.0]);
    let camera = eye();
    let text = "\"result\": Taa(source: \"in\", history: \"result@previous\", depth: \"depth\", camera: \"camera\", \
                motion: \"motion\", unit: Pixels)";
    let nodes = Nodes::new(text, &[("in", "Color"), ("depth", "Depth"), ("motion", "Motion")]).camera(Some(&camera));
    let graph = nodes.graph();
    let run = Run::new(&graph).camera(Some(&camera)).exact();
    let smooth = |change: &dyn Fn(Picture) -> Picture| {
        let mut sequence = Sequence::new(&run);
        for frame in 0..8_u8 {
            let place = [2.3, 1.4].map(|step| 20.0 + step * f32::from(frame));
            let picture = change(on_glass(size, place));
            sequence.frame(&[("in", &picture), ("depth", &depth), ("motion", &motion)], 0.04, frame == 0);
        }
        sequence.output("out")
    };
    let glass = smooth(&|picture| picture);
    // With the alpha of the last frame alone.
    let last = on_glass(size, [2.3, 1.4].map(|step| 20.0 + step * 7.0));
    let unmixed = Picture::new(size[0], size[1], |x, y| {
        let ([r, g, b, _], [.., alpha]) = (glass.at(x, y), last.at(x, y));
        [r, g, b, alpha]
    });
    for background in [0.0, 1.0] {
        let wanted = smooth(&|picture| over(&picture, background));
        let [[most, mean], [_, without]] = [&glass, &unmixed].map(|picture| {
            let found = over(picture, background);
            let sum: f32 = found.pixels.iter().zip(&wanted.pixels).map(|(a, b)| (a[0] - b[0]).abs()).sum();
            [apart(&found, &wanted), sum / found.pixels.len() as f32]
        });
        println!(
            "over {background}: {most:.4} at most, {mean:.5} on average, {without:.5} with the alpha of one frame"
        );
        // Limits and weights of light differ over another background.
        assert!(most < 0.15 && mean < 0.002, "over {background}: {most}, {mean}");
        assert!(background == 0.0 || mean < 0.25 * without, "over {background}: {mean}, and {without} without");
    }
}
