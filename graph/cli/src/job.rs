//! `afterimage job`: a render as a template of Open Job Description, for the farms that read it.
//!
//! Frames that leave nothing for later ones are tasks of one step, in chunks that run side by side. If they leave what
//! meters make, the tasks of a step before measure. Otherwise each task renders a whole shot.

use std::path::Path;

use afterimage_graph::diagnostic::shown;
use afterimage_graph::node::NodeKind;
use afterimage_media::film::is_film;
use afterimage_media::sequence::Pattern;
use clap::ArgMatches;
use clap::parser::ValueSource;
use serde_json::{Value, json};

use crate::args::{JobArgs, MACHINE};
use crate::failure::Failure;
use crate::frame_ranges::ranges;
use crate::render::{Sequence, sequence};
use crate::terminal::{note, say_text};

/// The options that differ by task, by the names of their fields.
const OF_TASKS: [&str; 2] = ["frames", "openjd"];
/// Of Open Job Description 2023-09: characters of the value of a parameter, and of a variable; parameters besides
/// `Program` and `Folder`; values of a parameter of tasks.
const MOST_OF_PARAMETER: usize = 1024;
const MOST_OF_VARIABLE: usize = 2048;
const MOST_PARAMETERS: usize = 48;
const MOST_SHOTS: usize = 1024;

/// Prints the template. `matches` are the arguments that `args` are made of.
pub(crate) fn run(args: &JobArgs, matches: &ArgMatches, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.render.json.is_some() || args.render.meter.is_some() {
        return Err(Failure::user("`--json` and `--meter` name one file for all chunks of the job")
            .hint("leave them out: the job measures by itself"));
    }
    if args.render.captured.is_some() {
        return Err(Failure::user("`--captured` is for one frame of a host").hint("leave it out"));
    }
    if args.render.watch {
        return Err(Failure::user("a job with `--watch` never ends").hint("leave it out"));
    }
    let sequence = sequence(&args.render, tables)?;
    if let Some(film) = sequence.files.iter().find(|file| is_film(file)) {
        return Err(Failure::user(format!("`{film}` is a film, which one task writes"))
            .hint("write numbered images, `out.####.exr`, and make a film of them at the end"));
    }
    if sequence.frames.is_empty() {
        return Err(Failure::user("a job is a sequence, and this is one image")
            .hint("name a sequence: `shot.####.exr`, or frames: `--frames 1-48`"));
    }
    let mut parameters = Parameters::default();
    let mut steps = match sequence.has_state && args.render.preroll == 0 {
        true if sequence.is_metered && sequence.step.is_some() => {
            metered(&sequence, matches, args.chunk, &mut parameters)?
        }
        true => vec![shots(&sequence, matches, &mut parameters)?],
        false => {
            let script = script(&words_of(matches, "render", &OF_TASKS)?, &[], &mut parameters)?;
            vec![parallel("Render", &sequence, script, args.chunk)]
        }
    };
    let folder = std::env::current_dir().map_err(|error| Failure::machine(format!("the current folder: {error}")))?;
    let folder = folder.to_str().filter(|folder| folder.chars().count() <= MOST_OF_PARAMETER).ok_or_else(|| {
        Failure::user(format!("no template has this folder: {}", folder.display()))
            .hint(format!("its name is in UTF-8, with at most {MOST_OF_PARAMETER} characters"))
    })?;
    let program = std::env::current_exe().ok().and_then(|path| path.to_str().map(str::to_owned));
    let program = program.filter(|program| program.chars().count() <= MOST_OF_PARAMETER);
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
                "default": folder,
            },
        ],
    });
    if let Some(all) = template["parameterDefinitions"].as_array_mut() {
        all.extend(parameters.definitions());
    }
    let parameter = |step: &Value| step["parameterSpace"]["taskParameterDefinitions"][0]["chunks"].is_object();
    if steps.iter().any(parameter) {
        template["extensions"] = json!(["TASK_CHUNKING"]);
    }
    let variables = variables()?;
    if !variables.is_empty() {
        template["jobEnvironments"] = json!([{ "name": "Afterimage", "variables": variables }]);
    }
    if args.render.device.require_gpu {
        for step in &mut steps {
            step["hostRequirements"] = json!({ "amounts": [{ "name": "amount.worker.gpu", "min": 1 }] });
        }
    }
    template["steps"] = steps.into();
    say_text(&format!("{template:#}"));
    Ok(())
}

/// The variables of this environment on which pixels depend. Those about this machine are not of the farm.
fn variables() -> Result<serde_json::Map<String, Value>, Failure> {
    let program = crate::args::command();
    let render = program.find_subcommand("render").expect("it is a command");
    let options = render.get_arguments().filter(|arg| arg.get_help_heading() != Some(MACHINE));
    let named = options.filter_map(|arg| arg.get_env()?.to_str());
    let mut variables = serde_json::Map::new();
    for name in named.chain(cfg!(feature = "ocio").then_some("OCIO")) {
        let Some(value) = std::env::var_os(name).filter(|value| !value.is_empty()) else { continue };
        let text = value.to_str().filter(|text| is_plain(text) && text.chars().count() <= MOST_OF_VARIABLE);
        let text = text.ok_or_else(|| {
            Failure::user(format!("no template has this value of the variable {name}: `{}`", value.display()))
                .hint("state it as an option of the job")
        })?;
        variables.insert(name.to_owned(), text.into());
    }
    Ok(variables)
}

/// The arguments of a command that correspond to those of the job.
struct Words {
    command: &'static str,
    /// `--option=value`, and flags.
    options: Vec<String>,
    /// The pipeline and the image, which may look like options.
    files: Vec<String>,
}

/// The arguments of the job that are options of `command`, without those of `left_out`.
fn words_of(matches: &ArgMatches, command: &'static str, left_out: &[&str]) -> Result<Words, Failure> {
    let mut words = Words { command, options: Vec::new(), files: Vec::new() };
    let program = crate::args::command();
    let definition = program.find_subcommand(command).expect("it is a command");
    let is_stated =
        |id: &str| matches.try_contains_id(id).is_ok() && matches.value_source(id) == Some(ValueSource::CommandLine);
    let of_all_commands = program.get_arguments().filter(|arg| arg.is_global_set());
    for arg in of_all_commands.chain(definition.get_arguments()) {
        let id = arg.get_id().as_str();
        if !is_stated(id) || left_out.contains(&id) {
            continue;
        }
        let Some(option) = arg.get_long() else {
            words.files.extend(values(matches, id)?);
            continue;
        };
        if arg.get_action().takes_values() {
            words.options.extend(values(matches, id)?.into_iter().map(|value| format!("--{option}={value}")));
        } else {
            words.options.push(format!("--{option}"));
        }
    }
    Ok(words)
}

fn values(matches: &ArgMatches, id: &str) -> Result<Vec<String>, Failure> {
    let in_utf8 = |value: &std::ffi::OsStr| {
        value.to_str().map(str::to_owned).ok_or_else(|| {
            Failure::user(format!("`{}` is not in UTF-8, and a template is", value.display())).hint("rename the file")
        })
    };
    matches.get_raw(id).into_iter().flatten().map(in_utf8).collect()
}

/// True if a text stands for itself in a template.
fn is_plain(text: &str) -> bool {
    !text.contains("{{") && !text.contains("}}") && !text.contains(char::is_control)
}

/// Texts that a template would interpret: they become parameters of the job, whose values are literal.
#[derive(Default)]
struct Parameters(Vec<String>);

impl Parameters {
    /// The text for a template.
    fn text(&mut self, text: &str) -> Result<String, Failure> {
        if is_plain(text) {
            return Ok(text.to_owned());
        }
        let known = self.0.iter().position(|known| known == text);
        let index = known.unwrap_or(self.0.len());
        if text.chars().count() > MOST_OF_PARAMETER || index == MOST_PARAMETERS {
            return Err(Failure::user(format!("no template has this word: `{text}`"))
                .hint("put it into the pipeline, or rename the file"));
        }
        if known.is_none() {
            self.0.push(text.to_owned());
        }
        Ok(format!("{{{{Param.Word{index}}}}}"))
    }

    fn definitions(self) -> impl Iterator<Item = Value> {
        let definition = |(index, text)| json!({ "name": format!("Word{index}"), "type": "STRING", "default": text });
        self.0.into_iter().enumerate().map(definition)
    }
}

/// The name of the job: at most 128 characters.
fn name(pipeline: &Path, file: &str) -> String {
    let pipeline = pipeline.file_stem().unwrap_or_default().to_string_lossy();
    let file = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
    let name = shown(&format!("{pipeline}: {file}")).replace('{', "(").replace('}', ")");
    name.chars().take(128).collect()
}

/// A step whose tasks measure, and one whose tasks render.
fn metered(
    sequence: &Sequence,
    matches: &ArgMatches,
    chunk: u32,
    parameters: &mut Parameters,
) -> Result<Vec<Value>, Failure> {
    let numbered = Path::new(&sequence.files[0]).with_extension("meter");
    let numbered = numbered.to_str().expect("it is made of a text");
    if Pattern::parse(numbered)?.is_none() {
        return Ok(vec![shots(sequence, matches, parameters)?]);
    }
    let mut cuts = sequence.cuts.clone();
    if sequence.begins_within {
        // The frames before this one are no part of the job, so none of them is missing.
        cuts.insert(0, sequence.frames[0]);
    }
    let cuts = (!cuts.is_empty()).then(|| format!("--cut={}", ranges(&cuts)));
    let left_out = [&OF_TASKS[..], &["cut", "out"]].concat();
    let measuring = words_of(matches, "meter", &left_out)?;
    let own: Vec<String> = cuts.iter().cloned().chain([format!("--out={numbered}")]).collect();
    let measuring = script(&measuring, &own, parameters)?;
    let rendering = words_of(matches, "render", &[&OF_TASKS[..], &["cut"]].concat())?;
    let own: Vec<String> = cuts.into_iter().chain([format!("--meter={numbered}")]).collect();
    let mut rendering = parallel("Render", sequence, script(&rendering, &own, parameters)?, chunk);
    rendering["dependencies"] = json!([{ "dependsOn": "Meter" }]);
    Ok(vec![parallel("Meter", sequence, measuring, chunk), rendering])
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
fn shots(sequence: &Sequence, matches: &ArgMatches, parameters: &mut Parameters) -> Result<Value, Failure> {
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
    if shots.len() > MOST_SHOTS || shots.iter().any(|shot| shot.chars().count() > MOST_OF_PARAMETER) {
        return Err(Failure::user("no template has the frames of so many shots, each of which is a task")
            .hint("make several jobs, with `--frames`"));
    }
    let frames = json!({ "name": "Frames", "type": "STRING", "range": shots });
    let script = script(&words_of(matches, "render", &OF_TASKS)?, &[], parameters)?;
    Ok(json!({ "name": "Render", "parameterSpace": { "taskParameterDefinitions": [frames] }, "script": script }))
}

/// The command line of a task: a command of the program with these words, and those of its own.
fn script(words: &Words, own: &[String], parameters: &mut Parameters) -> Result<Value, Failure> {
    let first = ["-C", "{{Param.Folder}}", words.command, "--openjd", "--frames={{Task.Param.Frames}}"];
    let mut args: Vec<String> = first.map(str::to_owned).to_vec();
    for word in own.iter().chain(&words.options).map(String::as_str).chain(["--"]).chain(files(words)) {
        args.push(parameters.text(word)?);
    }
    Ok(json!({ "actions": { "onRun": { "command": "{{Param.Program}}", "args": args } } }))
}

fn files(words: &Words) -> impl Iterator<Item = &str> {
    words.files.iter().map(String::as_str)
}

#[cfg(test)]
mod tests {
    use clap::FromArgMatches as _;

    use super::*;
    use crate::args::{Arguments, Command, command};

    /// Options that no job has, because they name one file for all tasks, are of one frame, or never end.
    const REFUSED: [&str; 4] = ["captured", "json", "meter", "watch"];
    /// A value for each option of `render` that takes one.
    const VALUES: &[(&str, &[&str])] = &[
        ("adapter", &["a b#2"]),
        ("allow", &["/"]),
        ("alpha", &["keep"]),
        ("compression", &["piz"]),
        ("crop", &["1,2,3x4"]),
        ("cut", &["3,5"]),
        ("depth", &["16"]),
        ("facts", &["-x=1", "y={{2}}"]),
        ("fps", &["23.976"]),
        ("gpu_memory", &["2G"]),
        ("input_space", &["ACEScg"]),
        ("inputs", &["a=-b.exr", "c=d e.exr"]),
        ("memory", &["1G"]),
        ("missing", &["hold"]),
        ("nodes", &["kinds", "more \u{202e}kinds"]),
        ("out", &["-o\n.#.exr"]),
        ("output_space", &["ACEScg"]),
        ("outputs", &["hdr=}}.#.exr"]),
        ("plan", &["fuse=off,bake=33"]),
        ("preroll", &["4"]),
        ("quality", &["80"]),
        ("resize", &["fit"]),
        ("scale", &["25%"]),
        ("sets", &["a.b=\"-o\"", "a.c=[1, 2]"]),
        ("size", &["12x8"]),
        ("slices", &["4"]),
        ("tier", &["--low"]),
        ("video", &["hevc -crf 18"]),
        ("window", &["data"]),
    ];

    /// The matches of a job with all options of `render`, and its files.
    fn all_options() -> ArgMatches {
        let program = command();
        let render = program.find_subcommand("render").expect("it is a command");
        let mut words = ["afterimage", "job"].map(str::to_owned).to_vec();
        for arg in render.get_arguments() {
            let (id, Some(option)) = (arg.get_id().as_str(), arg.get_long()) else { continue };
            // A gain map is of whole pictures: it cannot stand beside `--crop`.
            if [&REFUSED[..], &OF_TASKS, &["help", "ocio", "gain_map"]].concat().contains(&id) {
                continue;
            }
            if !arg.get_action().takes_values() {
                words.push(format!("--{option}"));
                continue;
            }
            let (_, values) = VALUES.iter().find(|(known, _)| *known == id).unwrap_or_else(|| panic!("add `{id}`"));
            words.extend(values.iter().map(|value| format!("--{option}={value}")));
        }
        words.extend(["--chunk=3", "--frames=1-9", "--", "--a.ron", "-s.#.exr"].map(str::to_owned));
        command().try_get_matches_from(words).expect("they are options of a job")
    }

    fn of_job(matches: &ArgMatches) -> &ArgMatches {
        matches.subcommand_matches("job").expect("it is the command")
    }

    #[test]
    fn every_option_of_a_render_is_one_of_its_tasks() {
        let matches = all_options();
        let words = words_of(of_job(&matches), "render", &OF_TASKS).expect("they are in UTF-8");
        let line = ["afterimage", "render", "--frames=1-9"].into_iter().map(str::to_owned);
        let line = line.chain(words.options).chain(["--".to_owned()]).chain(words.files);
        let again = Arguments::from_arg_matches(&command().try_get_matches_from(line).expect("they are of render"));
        let job = Arguments::from_arg_matches(&matches).expect("they are arguments");
        let (Command::Job(job), Command::Render(render)) = (job.command, again.expect("they are arguments").command)
        else {
            panic!("these are the commands")
        };
        assert_eq!(format!("{:?}", job.render), format!("{render:?}"));
    }

    #[test]
    fn tasks_that_measure_have_the_options_that_a_measurement_has() {
        let matches = all_options();
        let words =
            words_of(of_job(&matches), "meter", &[&OF_TASKS[..], &["out"]].concat()).expect("they are in UTF-8");
        let line = ["afterimage", "meter", "--out=m.#.meter"].into_iter().map(str::to_owned);
        let line = line.chain(words.options.clone()).chain(["--".to_owned()]).chain(words.files);
        command().try_get_matches_from(line).expect("they are of meter");
        let has = |word: &str| words.options.iter().any(|option| option.starts_with(word));
        assert!(has("--set=a.b") && has("--fps=23.976") && !has("--crop") && !has("--depth"), "{:?}", words.options);
    }

    #[test]
    fn a_word_that_a_template_would_read_is_a_parameter() {
        let mut parameters = Parameters::default();
        let mut text = |text: &str| parameters.text(text).expect("it is short");
        assert_eq!(
            ["a", "a{{b", "}}", "a{{b", "c\td", "{}"].map(&mut text).join(" "),
            "a {{Param.Word0}} {{Param.Word1}} {{Param.Word0}} {{Param.Word2}} {}"
        );
        assert!(parameters.text(&"}}".repeat(600)).is_err());
        let texts: Vec<Value> = parameters.definitions().map(|definition| definition["default"].clone()).collect();
        assert_eq!(texts, ["a{{b", "}}", "c\td"]);
        assert_eq!(name(Path::new("a{{b.ron"), "s\n.#.png"), "a((b: s\\n.#.png");
    }
}
