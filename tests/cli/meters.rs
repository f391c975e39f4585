//! Sequences that are measured and rendered in parts, in any order: as one run, bit for bit.

use std::fs;

use afterimage_media::{Picture, Pixels};
use serde_json::Value;

use super::chunks::{FRAMES, METERED, bytes, shot};
use super::{Folder, save_exact};

/// Renders all frames at once and in three parts, the last part first, from two files that are joined in the wrong
/// order; `line` has `OUT` where names of outputs begin. `meter` is the line that measures.
fn parts_are_the_whole(test: &str, meter: &str, line: &str, outputs: &[&str]) {
    let folder = shot(test);
    let named = |out: &str| line.replace("OUT", out);
    folder.run(&named("whole")).good();
    folder.run(&format!("{meter} --frames 4-6 -o a.meter")).good();
    folder.run(&format!("{meter} --frames 1-3 -o b.meter")).good();
    let read = |name: &str| fs::read(folder.file(name)).expect("it was written");
    folder.with("all.meter", &[read("a.meter"), read("b.meter")].concat());
    for frames in ["5-6", "3-4", "1-2"] {
        let words = folder.run(&format!("{} --frames {frames} --meter all.meter", named("part"))).notes();
        assert!(!words.contains("warning") && !words.contains("before the range"), "{words}");
    }
    folder.run(&format!("{} --frames 3-4 --preroll 1", named("anew"))).good();
    for output in outputs {
        let of = |out: &str, frame: u32| {
            fs::read(folder.file(&output.replace("OUT", out).replace('#', &frame.to_string()))).expect("it was written")
        };
        for frame in 1..=FRAMES {
            assert!(of("whole", frame) == of("part", frame), "{output}: frame {frame} differs in parts");
        }
        assert!(of("whole", 4) != of("anew", 4), "{output}: nothing is learned from frames without state");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn measured_parts_are_the_whole() {
    let line = "render {exposure} shot.#.exr -o OUT.#.png";
    parts_are_the_whole("meters-exposure", "meter {exposure} shot.#.exr", line, &["OUT.#.png"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn measured_parts_with_grain_and_limited_fireflies_are_the_whole() {
    let line = "render {tsushima} shot.#.exr --set grain.amount=0.5 -o OUT.#.png --depth 16";
    parts_are_the_whole("meters-tsushima", "meter {tsushima} shot.#.exr", line, &["OUT.#.png"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn measured_parts_of_two_outputs_are_the_whole() {
    let line = "render {hdr} shot.#.exr --output sdr=OUT-s.#.png --output hdr=OUT-h.#.png";
    parts_are_the_whole("meters-hdr", "meter {hdr} shot.#.exr", line, &["OUT-s.#.png", "OUT-h.#.png"]);
}

/// The meter is that of the mean, and comes after a blur by the motion of the camera: the camera of the frame before a
/// part is that of its first frame.
const AFTER_MOTION: &str = "Pipeline(inputs: { \"scene\": Color, \"depth\": Depth, \"camera\": Camera }, nodes: { \
                            \"far\": LinearDepth(depth: \"depth\", camera: \"camera\", encoding: Distance), \"moved\": \
                            MotionBlur(source: \"scene\", depth: \"far\", camera: \"camera\"), \"mean\": \
                            MeanLuminance(source: \"moved\"), \"meter\": Adapt(mean: \"mean\", adaptation: Linear), \
                            \"lit\": Exposure(source: \"moved\", meter: \"meter\") }, outputs: { \"light\": \"lit\" })";

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_camera_moves_as_in_the_whole() {
    let folder = shot("meters-camera");
    folder.with("moved.ron", AFTER_MOTION.as_bytes());
    let inputs = "moved.ron shot.#.exr --input depth=depth.#.exr --input camera=camera.#.json";
    folder.run(&format!("render {inputs} --depth 32 -o whole.#.exr")).good();
    for frames in ["3-5", "6", "1-2"] {
        folder.run(&format!("meter {inputs} --frames {frames} -o shot.#.meter")).good();
    }
    for frames in ["4-6", "1-3"] {
        let line = format!("render {inputs} --depth 32 -o part.#.exr --frames {frames} --meter shot.#.meter");
        folder.run(&line).good();
    }
    assert!(bytes(&folder, "whole.#.exr") == bytes(&folder, "part.#.exr"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_shot_that_begins_and_steps_over_frames_are_as_in_the_whole() {
    let folder = shot("meters-steps");
    folder.with("meter.ron", METERED.as_bytes());
    let frame = |name: &str| fs::read(folder.file(name)).expect("it was written");
    folder.run("meter meter.ron shot.#.exr -o all.meter").good();
    folder.run("render meter.ron shot.#.exr --cut 3 --fps 30 --depth 32 -o cut.#.exr").good();
    let line = "render meter.ron shot.#.exr --cut 3 --fps 30 --depth 32 --meter all.meter --frames 5 -o own.#.exr";
    folder.run(line).good();
    assert!(frame("cut.5.exr") == frame("own.5.exr"));
    folder.run("render meter.ron shot.#.exr --frames 1-5:2 --depth 32 -o step.#.exr").good();
    folder.run("meter meter.ron shot.#.exr --frames 1-5:2 -o step.meter").good();
    folder.run("render meter.ron shot.#.exr --meter step.meter --frames 5 --depth 32 -o own.#.exr").good();
    assert!(frame("step.5.exr") == frame("own.5.exr") && frame("step.5.exr") != frame("cut.5.exr"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_of_one_gray_is_measured_as_that_gray() {
    let folder = Folder::new("meters-gray");
    let (width, height) = (30_u32, 20_u32);
    for (frame, light) in [(1, 0.18_f32), (2, 0.72)] {
        let pixels = [light, light, light, 1.0].repeat((width * height) as usize);
        save_exact(&folder.file(&format!("gray.{frame}.exr")), &Picture::new(width, height, Pixels::Float(pixels)));
    }
    folder.run("meter {exposure} gray.#.exr -o gray.meter --set meter.compensation=0.0").good();
    let text = fs::read_to_string(folder.file("gray.meter")).expect("it was written");
    let frames: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("it is JSON")).collect();
    for (frame, stops) in frames.iter().zip([0.0, -2.0]) {
        let found = frame["exposure"][0]["stops"].as_f64().expect("a number");
        assert!((found - stops).abs() < 0.06, "{frame}");
        // Four words of floats, and the counts of all pixels in one bin: 255 of each.
        let bins = frame["measured"]["bins.result"].as_array().expect("a list");
        let counts: Vec<u64> = bins[4..].iter().filter_map(Value::as_u64).filter(|count| *count > 0).collect();
        assert_eq!(counts, [255 * u64::from(width * height)], "{frame}");
    }
    assert_eq!(frames.len(), 2);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_without_images_is_measured_at_the_size_that_is_asked_for() {
    let folder = Folder::new("meters-size");
    let scene = METERED.replace("\"scene\": Color", "").replace("nodes: {", "nodes: { \"scene\": DemoScene(),");
    folder.with("scene.ron", scene.as_bytes());
    for (size, pixels) in [("32x18", 32 * 18), ("20x10", 200)] {
        folder.run(&format!("meter scene.ron --size {size} --frames 1-2 -o scene.meter")).good();
        let text = fs::read_to_string(folder.file("scene.meter")).expect("it was written");
        for line in text.lines() {
            let frame: Value = serde_json::from_str(line).expect("it is JSON");
            let bins = frame["measured"]["bins.result"].as_array().expect("a list");
            let all: u64 = bins[4..].iter().filter_map(Value::as_u64).sum();
            // Weights are 255 of each pixel, shared by two bins.
            assert!(all.abs_diff(255 * pixels) <= pixels, "{size}: {all}");
        }
        assert_eq!(text.lines().count(), 2);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn measurements_that_do_not_fit_are_refused() {
    let folder = shot("meters-refused");
    folder.with("meter.ron", METERED.as_bytes());
    folder.with("other.ron", METERED.replace("source: \"scene\")", "source: \"scene\", lo: -9.0)").as_bytes());
    folder.run("meter meter.ron shot.#.exr --frames 1-2 -o a.meter").good();
    folder.run("meter meter.ron shot.#.exr --frames 4 -o b.meter").good();
    folder.run("meter other.ron shot.#.exr --frames 4 -o c.meter").good();
    let text = |name: &str| fs::read_to_string(folder.file(name)).expect("it was written");
    folder.with("holes.meter", format!("{}{}", text("a.meter"), text("b.meter")).as_bytes());
    folder.with("twice.meter", format!("{}{}", text("c.meter"), text("b.meter")).as_bytes());
    folder.with("words.meter", b"a text\n");
    let run = |line: &str| folder.run(&format!("render {line} -o refused.#.exr"));
    let of = |name: &str, frames: &str| run(&format!("meter.ron shot.#.exr --meter {name} --frames {frames}"));
    of("holes.meter", "6").fails_saying(1, &["frame 5 follows from frame 3, which is not measured", "--frames 3"]);
    of("b.meter", "6").fails_saying(1, &["frame 5 follows from frames 1-3, which are not measured"]);
    of("twice.meter", "6").fails_saying(1, &["frame 4 was measured twice, differently"]);
    of("words.meter", "6").fails_saying(1, &["words.meter:1: this is no measured frame"]);
    run("other.ron shot.#.exr --meter a.meter --frames 3").fails_saying(1, &["frame 1 was measured by other passes"]);
    let glare = folder.run("render glare shot.#.exr --meter a.meter --frames 3 -o refused.#.png");
    glare.fails_saying(1, &["has no meter"]);
    folder.run("meter glare shot.#.exr -o no.meter").fails_saying(1, &["each of its frames is rendered alone"]);
    let line = "meter cinematic shot.#.exr --input depth=depth.#.exr --input camera=camera.#.json -o no.meter";
    folder.run(line).fails_saying(1, &["no meter that measures a frame alone", "`steady.result`", "--preroll"]);
    folder.run("meter meter.ron shot.1.exr -o no.meter").fails_saying(1, &["this is one image"]);
    folder.run("meter meter.ron shot.#.exr -o shot.1.exr").fails_saying(1, &["this is the image of input `scene`"]);
    let names = folder.names();
    assert!(!names.iter().any(|name| name.starts_with("refused") || name == "no.meter"), "{names:?}");
}
