//! Sequences that are rendered in parts.

use std::fs;

use afterimage_media::{Encoding, Picture, Pixels, write_image};

use super::{Folder, save};

pub(super) const FRAMES: u32 = 6;

/// A shot whose light, lamp, depth and camera change from frame to frame: `shot.1.exr` and so on.
pub(super) fn shot(test: &str) -> Folder {
    let folder = Folder::new(test);
    let (width, height) = (40_u32, 24_u32);
    for frame in 1..=FRAMES {
        let (mut light, mut depth) = (Vec::new(), Vec::new());
        for y in 0..height {
            for x in 0..width {
                let level = 0.3 * 2_f32.powi(frame as i32 - 3) * (0.2 + (x as f32 * 0.7).sin().abs());
                let is_lamp = x == 5 + 4 * frame && y == 8;
                let [r, g, b] = if is_lamp { [900.0, 700.0, 400.0] } else { [level, 0.8 * level, 0.5 * level] };
                light.extend([r, g, b, 1.0]);
                let far = 2.0 + x as f32 * 0.1 + frame as f32 * 0.05;
                depth.extend([far, far, far, 1.0]);
            }
        }
        save(&folder.file(&format!("shot.{frame}.exr")), &Picture::new(width, height, Pixels::Float(light)));
        let exact = Encoding { bits: 32, ..Encoding::EXR };
        let picture = Picture::new(width, height, Pixels::Float(depth));
        write_image(&folder.file(&format!("depth.{frame}.exr")), &picture, &exact).expect("it can be written");
        let (side, jitter) = (0.02 * frame as f32, 0.25 * (frame % 3) as f32 - 0.25);
        let camera = format!(
            "{{ \"view\": [[1, 0, 0, {side}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], \"projection\": [[1.2, 0, 0, \
             0], [0, 2, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]], \"jitter\": [{jitter}, 0.125] }}"
        );
        folder.with(&format!("camera.{frame}.json"), camera.as_bytes());
    }
    folder
}

/// The bytes of the files of all frames.
pub(super) fn bytes(folder: &Folder, pattern: &str) -> Vec<Vec<u8>> {
    let of = |frame: u32| fs::read(folder.file(&pattern.replace('#', &frame.to_string()))).expect("it was written");
    (1..=FRAMES).map(of).collect()
}

/// Renders all frames at once, and the last three after those before them and without; `line` has `OUT` where names of
/// outputs begin. After the frames before they are those of the whole, and without they are not.
fn parts_are_the_whole(test: &str, line: &str) {
    let folder = shot(test);
    let named = |out: &str| line.replace("OUT", out);
    folder.run(&named("whole")).good();
    folder.run(&format!("{} --frames 4-6 --preroll 9", named("part"))).good();
    let anew = folder.run(&format!("{} --frames 4-6", named("anew"))).notes();
    assert!(anew.contains("warning: the sequence has frame 3 before the first one here"), "{anew}");
    let frame = |out: &str, frame: u32| fs::read(folder.file(&format!("{out}.{frame}.png"))).expect("it was written");
    for number in 4..=6 {
        assert!(frame("whole", number) == frame("part", number), "frame {number} differs in parts");
    }
    assert!(frame("whole", 4) != frame("anew", 4), "nothing is learned from frames before");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn parts_with_cached_results_are_the_whole() {
    let sets = "--set mips.every=5 --set counted.every=3";
    parts_are_the_whole("chunks-every", &format!("render {{tsushima}} shot.#.exr {sets} -o OUT.#.png --depth 16"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn parts_with_histories_and_cameras_are_the_whole() {
    let line = "render {cinematic} shot.#.exr --input depth=depth.#.exr --input camera=camera.#.json \
                --set linear.encoding=Distance -o OUT.#.png";
    parts_are_the_whole("chunks-cinematic", line);
}

/// A meter and an output of its light, and nothing else.
pub(super) const METERED: &str = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"bins\": Histogram(source: \"scene\"), \
                       \"meter\": AutoExposure(histogram: \"bins\"), \"bright\": Extract(source: \"scene\", before: \
                       \"bright.peaks@previous\", fireflies: Limit), \"all\": Composite(base: \"scene\", bloom: \
                       \"bright\"), \"lit\": Exposure(source: \"all\", meter: \"meter\") }, outputs: { \"light\": \
                       \"lit\" })";

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn parts_in_exr_are_the_whole_and_a_shot_begins_within_them() {
    let folder = shot("chunks-exr");
    folder.with("meter.ron", METERED.as_bytes());
    let line = "render meter.ron shot.#.exr --cut 5 --depth 32 -o";
    folder.run(&format!("{line} whole.#.exr")).good();
    // From the cut on, no state is needed, and nothing is warned of.
    let words = folder.run(&format!("{line} anew.#.exr --frames 5-6")).notes();
    assert!(!words.contains("warning"), "{words}");
    let frame = |name: &str| fs::read(folder.file(name)).expect("it was written");
    assert!(frame("anew.6.exr") == frame("whole.6.exr"));
    // Frames before the range bring the exposure nearer; all of them are the whole sequence.
    let words = folder.run(&format!("{line} rolled.#.exr --frames 4 --preroll 2")).notes();
    assert!(
        words.contains("note: 2 frames before the range are rendered") && words.contains("`meter.result`"),
        "{words}"
    );
    assert!(!folder.names().contains(&"rolled.3.exr".to_owned()), "{:?}", folder.names());
    folder.run(&format!("{line} rolled.#.exr --frames 4 --preroll 9")).good();
    assert!(frame("rolled.4.exr") == frame("whole.4.exr"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_bad_frame_does_not_end_a_run_that_keeps_going() {
    let folder = shot("chunks-bad");
    folder.with("meter.ron", METERED.as_bytes());
    folder.with("shot.3.exr", b"");
    let line = "render meter.ron shot.#.exr -o out.#.exr --json report.json";
    let report = || -> serde_json::Value {
        let text = fs::read_to_string(folder.file("report.json")).expect("the program wrote it");
        serde_json::from_str(&text).expect("it is JSON")
    };
    folder
        .run(line)
        .fails_saying(1, &["shot.3.exr: the file is empty", "frames: 2 good, 0 skipped, 1 failed; 0 repaired"]);
    let failed = report();
    assert!(failed["failure"].as_str().is_some_and(|why| why.contains("shot.3.exr")), "{failed}");
    let made_by = ["adapter", "driver", "plan", "version"].map(|key| failed[key].as_str().map(str::len));
    assert!(made_by.iter().all(|length| length.is_some_and(|length| length > 0)), "{failed}");
    folder
        .run(&format!("{line} --keep-going"))
        .fails_saying(1, &["frames: 5 good, 0 skipped, 1 failed; 0 repaired", "error: 1 of 6 frames failed"]);
    let outcomes = |report: &serde_json::Value| -> Vec<String> {
        let frames = report["frames"].as_array().expect("a list of frames");
        frames.iter().map(|frame| frame["outcome"].as_str().expect("a word").to_owned()).collect()
    };
    assert_eq!(outcomes(&report()), ["good", "good", "failed", "good", "good", "good"]);
    // Only what is missing is written, as it would have been.
    let whole = shot("chunks-good");
    fs::copy(whole.file("shot.3.exr"), folder.file("shot.3.exr")).expect("it can be copied");
    folder.with("four.ron", b"Pipeline(extends: \"meter.ron\")");
    folder.run("render four.ron shot.#.exr -o out.#.exr").good();
    let before = bytes(&folder, "out.#.exr");
    let half = before[4][..before[4].len() / 2].to_vec();
    folder.with("out.5.exr", &half);
    fs::remove_file(folder.file("out.3.exr")).expect("it is there");
    let words = folder.run(&format!("{line} --skip-existing")).notes();
    assert!(words.contains("frames: 2 good, 4 skipped, 0 failed; 0 repaired"), "{words}");
    assert!(bytes(&folder, "out.#.exr") == before);
    assert_eq!(outcomes(&report()), ["skipped", "skipped", "good", "skipped", "good", "skipped"]);
}
