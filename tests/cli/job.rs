//! Templates for render farms: their tasks make the files of one run.

use std::fs;

use serde_json::Value;

use super::{Folder, room, save};

pub(super) const METERED: &str = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"bins\": Histogram(source: \"scene\"), \
                       \"meter\": AutoExposure(histogram: \"bins\"), \"lit\": Exposure(source: \"scene\", meter: \
                       \"meter\") }, outputs: { \"light\": \"lit\" })";

/// The same after a trail of light, which is made from all frames before: no frame can be measured alone.
const TRAILING: &str = "Pipeline(extends: \"meter.ron\", nodes: { \"trail\": Composite(base: \"scene\", bloom: \
                        \"trail@previous\", strength: 0.25), \"bins\": Histogram(source: \"trail\"), \"lit\": \
                        Exposure(source: \"trail\", meter: \"meter\") })";

/// A shot that gets brighter, of nine frames.
fn shot(test: &str) -> Folder {
    let folder = Folder::new(test);
    for frame in 1..=9 {
        let mut picture = room(12, 8);
        let brighter = picture.pixels.to_f32().iter().map(|x| x * frame as f32).collect();
        picture.pixels = afterimage_media::Pixels::Float(brighter);
        save(&folder.file(&format!("shot.{frame}.exr")), &picture);
    }
    folder.with("meter.ron", METERED.as_bytes());
    folder.with("trail.ron", TRAILING.as_bytes());
    folder
}

fn job(folder: &Folder, line: &str) -> Value {
    let template: Value = serde_json::from_str(&folder.run(line).good()).expect("it is JSON");
    assert_eq!(template["specificationVersion"], "jobtemplate-2023-09");
    template
}

/// The line of the program that a step of a template runs, from another folder.
fn line_of(template: &Value, step: &Value, frames: &str) -> String {
    let action = &step["script"]["actions"]["onRun"];
    assert_eq!(action["command"], "{{Param.Program}}");
    let words = action["args"].as_array().expect("a list").iter().map(|word| word.as_str().expect("a word"));
    let mut line = words.collect::<Vec<_>>().join(" ").replace("{{Task.Param.Frames}}", frames);
    for parameter in template["parameterDefinitions"].as_array().expect("a list") {
        let [name, value] = ["name", "default"].map(|key| parameter[key].as_str().expect("a word"));
        line = line.replace(&format!("{{{{Param.{name}}}}}"), value);
    }
    line
}

/// That a task of so many frames tells a farm of each, up to 100 %.
#[track_caller]
fn progress(said: &str, count: usize) {
    let told: Vec<&str> = said.lines().collect();
    assert_eq!(told.len(), 2 * count, "{said}");
    for (number, lines) in told.chunks(2).enumerate().map(|(at, lines)| (at + 1, lines)) {
        assert_eq!(lines[0], format!("openjd_progress: {:.1}", 100.0 * number as f64 / count as f64));
        let (status, ending) = ("openjd_status: frame ", format!(", {number} of {count} frames"));
        assert!(lines[1].starts_with(status) && lines[1].ends_with(&ending), "{}", lines[1]);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn chunks_of_frames_without_state_are_tasks_in_any_order() {
    let (folder, elsewhere) = (shot("job-parallel"), Folder::new("job-elsewhere"));
    folder.run("render grade shot.#.exr -o whole.#.png").good();
    let template = job(&folder, "job grade shot.#.exr -o part.#.png --chunk 4 --frames 1-9");
    let steps = template["steps"].as_array().expect("a list");
    assert_eq!(steps[0]["hostRequirements"], Value::Null);
    let guarded = job(&folder, "job grade shot.#.exr -o part.#.png --require-gpu");
    assert_eq!(guarded["steps"][0]["hostRequirements"]["amounts"][0]["name"], "amount.worker.gpu");
    let space = &steps[0]["parameterSpace"]["taskParameterDefinitions"][0];
    assert_eq!((steps.len(), &space["type"], &space["range"]), (1, &"CHUNK[INT]".into(), &"1-9".into()));
    assert_eq!(
        (&space["chunks"]["defaultTaskCount"], &template["extensions"][0]),
        (&4.into(), &"TASK_CHUNKING".into())
    );
    for (frames, count) in [("9", 1), ("5-8", 4), ("1-4", 4)] {
        progress(&elsewhere.run(&line_of(&template, &steps[0], frames)).good(), count);
    }
    for frame in 1..=9 {
        let bytes = |out: &str| fs::read(folder.file(&format!("{out}.{frame}.png"))).expect("it was written");
        assert!(bytes("whole") == bytes("part"), "frame {frame}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn frames_that_depend_on_those_before_are_a_task_for_each_shot() {
    let (folder, elsewhere) = (shot("job-shots"), Folder::new("job-shots-elsewhere"));
    folder.run("render trail.ron shot.#.exr -o whole.#.exr --cut 6").good();
    let template = job(&folder, "job trail.ron shot.#.exr -o part.#.exr --cut 6 --chunk 3");
    let [step] = &template["steps"].as_array().expect("a list")[..] else { panic!("{template}") };
    let space = &step["parameterSpace"]["taskParameterDefinitions"][0];
    assert_eq!((&space["type"], &space["range"]), (&"STRING".into(), &serde_json::json!(["1-5", "6-9"])));
    assert_eq!(template["extensions"], Value::Null);
    // The second shot before the first.
    for frames in ["6-9", "1-5"] {
        elsewhere.run(&line_of(&template, step, frames)).good();
    }
    for frame in 1..=9 {
        let bytes = |out: &str| fs::read(folder.file(&format!("{out}.{frame}.exr"))).expect("it was written");
        assert!(bytes("whole") == bytes("part"), "frame {frame}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn chunks_of_metered_frames_are_measured_before_in_any_order() {
    let (folder, elsewhere) = (shot("job-metered"), Folder::new("job-metered-elsewhere"));
    // The sequence has a frame before the first, which is no part of the job.
    // Options that `meter` does not have, a name that looks like an option, and one that a template would read.
    fs::rename(folder.file("meter.ron"), folder.file("-{{m}}.ron")).expect("it is there");
    let words = "--frames 2-9 --crop=1,1,8x6 --depth 16 --keep-going --timings -o";
    folder.run(&format!("render {words} whole.#.exr -- -{{{{m}}}}.ron shot.#.exr")).good();
    let template = job(&folder, &format!("job --chunk 3 {words}part.#.exr -- -{{{{m}}}}.ron shot.#.exr"));
    let [measuring, rendering] = &template["steps"].as_array().expect("a list")[..] else { panic!("{template}") };
    assert_eq!((&measuring["name"], &rendering["name"]), (&"Meter".into(), &"Render".into()));
    assert_eq!(rendering["dependencies"][0]["dependsOn"], "Meter");
    for step in [measuring, rendering] {
        for (frames, count) in [("8-9", 2), ("2-4", 3), ("5-7", 3)] {
            progress(&elsewhere.run(&line_of(&template, step, frames)).good(), count);
        }
    }
    for frame in 2..=9 {
        let bytes = |out: &str| fs::read(folder.file(&format!("{out}.{frame}.exr"))).expect("it was written");
        assert!(bytes("whole") == bytes("part"), "frame {frame}");
    }
}

#[test]
fn a_template_has_the_ranges_and_the_names_that_were_asked_for() {
    let folder = shot("job-ranges");
    for (options, chunk, range, constraint) in [
        ("", 20, "1-9", "CONTIGUOUS"),
        (" --frames 3", 20, "3", "CONTIGUOUS"),
        (" --frames 1-9:2 --chunk 2", 2, "1-9:2", "NONCONTIGUOUS"),
        (" --frames 1-3,7-9", 20, "1-3,7-9", "NONCONTIGUOUS"),
    ] {
        let template = job(&folder, &format!("job grade shot.#.exr -o part.#.png{options}"));
        assert_eq!(template["name"], "grade: part.#.png");
        let defaults = template["parameterDefinitions"].as_array().expect("a list").iter();
        let defaults: Vec<&str> = defaults.filter_map(|parameter| parameter["default"].as_str()).collect();
        let place = fs::canonicalize(&folder.0).expect("a folder");
        assert!(defaults.len() == 2 && defaults[0].ends_with("under-test") && *defaults[1] == *place, "{defaults:?}");
        let frames = &template["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0];
        assert_eq!((&frames["name"], &frames["range"]), (&"Frames".into(), &range.into()), "{options}");
        let chunks = serde_json::json!({ "defaultTaskCount": chunk, "rangeConstraint": constraint });
        assert_eq!(frames["chunks"], chunks, "{options}");
    }
    // A few frames before a chunk stand for the state of the whole.
    let template = job(&folder, "job trail.ron shot.#.exr -o part.#.exr --preroll 2");
    assert_eq!(template["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["type"], "CHUNK[INT]");
}

#[test]
fn what_is_no_job_is_refused() {
    let folder = shot("job-refused");
    folder.run("job grade shot.#.exr -o out.#.png --watch").fails_saying(1, &["a job with `--watch` never ends"]);
    folder.run("job meter.ron shot.#.exr -o out.#.exr --chunk 0").fails_saying(1, &["--chunk <COUNT>"]);
    folder.run("job meter.ron shot.1.exr -o out.exr").fails_saying(1, &["a job is a sequence"]);
    folder.run("job meter.ron shot.#.exr -o out.#.exr --json a.json").fails_saying(1, &["one file for all chunks"]);
    folder.run("-C nowhere render meter.ron shot.1.exr -o out.exr").fails_saying(1, &["-C nowhere: "]);
}
