//! `afterimage job`: a render as a template of Open Job Description, for the farms that read it.
//!
//! Frames that leave nothing for later ones are tasks of one step, in chunks that run side by side. If they leave what
//! meters make, the tasks of a step before measure. Otherwise each task renders a whole shot.

use std::ffi::OsString;
use std::path::Path;

use afterimage_graph::node::NodeKind;
use afterimage_media::sequence::Pattern;
use serde_json::{Value, json};

use crate::args::{JobArgs, NODES, OUTPUT_SPACE};
use crate::failure::Failure;
use crate::frame_ranges::ranges;
use crate::render::{Sequence, sequence};
use crate::terminal::{note, say};

/// Prints the template. `words` are the arguments of the process.
pub(crate) fn run(args: &JobArgs, words: &[OsString], tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.render.json.is_some() || args.render.meter.is_some() {
        return Err(Failure::user("`--json` and `--meter` name one file for all chunks of the job")
            .hint("leave them out: the job measures by itself"));
    }
    if args.render.watch {
        return Err(Failure::user("a job with `--watch` never ends").hint("leave it out"));
    }
    let words = render_words(words)?;
    if let Some(word) = words.iter().find(|word| word.contains("{{")) {
        return Err(
            Failure::user(format!("`{word}`: a template has its own meaning for `{{{{`")).hint("rename the file")
        );
    }
    let sequence = sequence(&args.render, tables)?;
    if sequence.frames.is_empty() {
        return Err(Failure::user("a job is a sequence, and this is one image")
            .hint("name a sequence: `shot.####.exr`, or frames: `--frames 1-48`"));
    }
    let mut steps = match sequence.has_state && args.render.preroll == 0 {
        true if sequence.is_metered && sequence.step.is_some() => metered(&sequence, &words, args.chunk)?,
        true => vec![shots(&sequence, &words)],
        false => vec![parallel("Render", &sequence, script("render", &words, &each()), args.chunk)],
    };
    let folder = std::env::current_dir().map_err(|error| Failure::machine(format!("the current folder: {error}")))?;
    let program = std::env::current_exe().ok().and_then(|path| path.to_str().map(str::to_owned));
    let mut template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": name(&args.render.pipeline, &sequence.files[0]),
        "parameterDefinitions": [
            {
                "name": "Program",
                "type": "STRING",
                "description": "The program on the machines of the farm",
                "default": program.unwrap_or_else(|| "afterimage".to_owned()),
            },
            {
                "name": "Folder",
                "type": "STRING",
                "description": "The folder to which the names of files are relative",
                "default": folder.display().to_string(),
            },
        ],
    });
    let parameter = |step: &Value| step["parameterSpace"]["taskParameterDefinitions"][0]["chunks"].is_object();
    if steps.iter().any(parameter) {
        template["extensions"] = json!(["TASK_CHUNKING"]);
    }
    let variables = variables();
    if !variables.is_empty() {
        template["jobEnvironments"] = json!([{ "name": "Afterimage", "variables": variables }]);
    }
    if args.render.device.require_gpu {
        for step in &mut steps {
            step["hostRequirements"] = json!({ "amounts": [{ "name": "amount.worker.gpu", "min": 1 }] });
        }
    }
    template["steps"] = steps.into();
    say(&format!("{template:#}"));
    Ok(())
}

/// The variables of this environment on which pixels depend. Those about this machine are not of the farm.
fn variables() -> serde_json::Map<String, Value> {
    let names = [OUTPUT_SPACE, NODES].into_iter();
    names.filter_map(|name| Some((name.to_owned(), std::env::var(name).ok()?.into()))).collect()
}

/// The words of `render` that all chunks have: those after `job`, without `--chunk` and `--frames`.
fn render_words(words: &[OsString]) -> Result<Vec<String>, Failure> {
    let mut texts = Vec::new();
    for word in words.iter().skip_while(|word| *word != "job").skip(1) {
        let text = word.to_str().ok_or_else(|| {
            Failure::user(format!("`{}` is not in UTF-8, and a template is", word.display())).hint("rename the file")
        })?;
        texts.push(text.to_owned());
    }
    Ok(without(&texts, &["--chunk", "--frames"], &["--openjd"]))
}

/// The name of the job: at most 128 characters.
fn name(pipeline: &Path, file: &str) -> String {
    let pipeline = pipeline.file_stem().unwrap_or_default().to_string_lossy();
    let file = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
    format!("{pipeline}: {file}").chars().take(128).collect()
}

/// The words that name the frames of a task.
fn each() -> Vec<String> {
    ["--frames", "{{Task.Param.Frames}}"].map(str::to_owned).to_vec()
}

/// A step whose tasks measure, and one whose tasks render.
fn metered(sequence: &Sequence, words: &[String], chunk: u32) -> Result<Vec<Value>, Failure> {
    let file = &sequence.files[0];
    let numbered = Path::new(file).with_extension("meter").display().to_string();
    if Pattern::parse(&numbered)?.is_none() {
        return Ok(vec![shots(sequence, words)]);
    }
    let (mut words, mut cuts) = (without(words, &["--cut"], &[]), sequence.cuts.clone());
    if sequence.begins_within {
        // The frames before this one are no part of the job, so none of them is missing.
        cuts.insert(0, sequence.frames[0]);
    }
    if !cuts.is_empty() {
        words.extend(["--cut".to_owned(), ranges(&cuts)]);
    }
    let named = |option: &str| each().into_iter().chain([option.to_owned(), numbered.clone()]).collect::<Vec<_>>();
    let measuring = script("meter", &without(&words, &RENDER_OPTIONS, &RENDER_FLAGS), &named("-o"));
    let mut rendering = parallel("Render", sequence, script("render", &words, &named("--meter")), chunk);
    rendering["dependencies"] = json!([{ "dependsOn": "Meter" }]);
    Ok(vec![parallel("Meter", sequence, measuring, chunk), rendering])
}

/// The options of `render` with a value that `meter` does not have.
const RENDER_OPTIONS: [&str; 10] = [
    "-o",
    "--out",
    "--output",
    "--depth",
    "--alpha",
    "--quality",
    "--preroll",
    "--output-space",
    "--compression",
    "--channel-type",
];
/// Those without a value.
const RENDER_FLAGS: [&str; 5] = ["--no-dither", "--keep-going", "--skip-existing", "--timings", "--drop-layers"];

/// The words without these options, which have a value, and without these flags.
fn without(words: &[String], options: &[&str], flags: &[&str]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let name = word.split_once('=').map_or(word.as_str(), |(name, _)| name);
        // `-oFILE` is `-o FILE`.
        let is_joined = options.iter().any(|option| option.len() == 2 && word.starts_with(option) && word != option);
        if options.contains(&word.as_str()) {
            words.next();
        } else if !is_joined && !options.contains(&name) && !flags.contains(&name) {
            kept.push(word.clone());
        }
    }
    kept
}

/// A step with a task for each chunk.
fn parallel(name: &str, sequence: &Sequence, script: Value, chunk: u32) -> Value {
    let is_contiguous = sequence.frames.windows(2).all(|pair| pair[1] == pair[0].wrapping_add(1));
    let frames = json!({
        "name": "Frames",
        "type": "CHUNK[INT]",
        "range": ranges(&sequence.frames),
        "chunks": {
            "defaultTaskCount": chunk,
            "rangeConstraint": if is_contiguous { "CONTIGUOUS" } else { "NONCONTIGUOUS" },
        },
    });
    json!({ "name": name, "parameterSpace": { "taskParameterDefinitions": [frames] }, "script": script })
}

/// A step with a task for each shot, whose frames depend on those before.
fn shots(sequence: &Sequence, words: &[String]) -> Value {
    let mut shots: Vec<Vec<u32>> = Vec::new();
    for frame in &sequence.frames {
        match shots.last_mut().filter(|_| !sequence.cuts.contains(frame)) {
            Some(shot) => shot.push(*frame),
            None => shots.push(vec![*frame]),
        }
    }
    if shots.len() < sequence.frames.len() {
        note("note: frames depend on those before, so a task renders a whole shot; `--preroll COUNT` allows chunks");
    }
    let shots: Vec<String> = shots.iter().map(|shot| ranges(shot)).collect();
    let frames = json!({ "name": "Frames", "type": "STRING", "range": shots });
    let script = script("render", words, &each());
    json!({ "name": "Render", "parameterSpace": { "taskParameterDefinitions": [frames] }, "script": script })
}

/// What a task runs: a command of the program with these words, and those of its own.
fn script(command: &str, words: &[String], own: &[String]) -> Value {
    let first = ["-C", "{{Param.Folder}}", command, "--openjd"].map(str::to_owned);
    let args: Vec<&String> = first.iter().chain(words).chain(own).collect();
    json!({ "actions": { "onRun": { "command": "{{Param.Program}}", "args": args } } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_have_frames_of_their_own() {
        let words =
            ["afterimage", "-C", "x", "job", "a.ron", "--frames", "1-9", "--chunk=4", "s.#.exr", "-o", "o.#.png"];
        let words = render_words(&words.map(OsString::from)).expect("it is UTF-8");
        assert_eq!(words, ["a.ron", "s.#.exr", "-o", "o.#.png"]);
        let words = ["a.ron", "-os.#.png", "--output=hdr=h.#.png", "--depth", "16", "--keep-going", "--set", "a.b=-o"];
        let words = without(&words.map(str::to_owned), &RENDER_OPTIONS, &RENDER_FLAGS);
        assert_eq!(words, ["a.ron", "--set", "a.b=-o"]);
    }
}
