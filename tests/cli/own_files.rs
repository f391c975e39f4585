//! No output replaces a file of its own run.

use std::any::TypeId;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;

use super::{Folder, room, save};

const NODE: &str = r#"Kind(
    name: "Glow",
    doc: "Brightens.",
    inputs: { "source": Image(doc: "The image.", accepts: [Encoded]) },
    outputs: { "result": Image(doc: "The image.", state: Same("source")) },
)"#;
const SHADER: &str = "import package::lib::shared::same;\nfn glow(source: vec4f) -> vec4f { return same(source); }\n";
const SHARED: &str = "fn same(color: vec4f) -> vec4f { return color; }\n";

const BASE: &str = r#"Pipeline(
    inputs: { "scene": Encoded },
    nodes: { "look": ColorLut(source: "scene", file: "table.cube"), "glow": Glow(source: "look") },
    outputs: { "display": "glow", "same": "scene" },
)"#;
const TABLE: &str = "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n";
/// A frame that was measured, of another pipeline.
const METER: &str = "{\"afterimage_meter\":1,\"frame\":1,\"exposure\":null,\"passes\":\"\",\"measured\":{}}\n";
const METERED: &str = r#"Pipeline(
    inputs: { "scene": Color, "eye": Camera },
    nodes: {
        "bins": Histogram(source: "scene"),
        "meter": AutoExposure(histogram: "bins"),
        "lit": Exposure(source: "scene", meter: "meter"),
        "display": Encode(source: "mapped", transfer: Srgb),
        "mapped": ToneMap(source: "lit", curve: Reinhard),
    },
    outputs: { "display": "display" },
)"#;
const CAMERA: &str = "{ \"view\": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], \"projection\": [[1.2, 0, 0, \
                      0], [0, 2, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]] }";

/// Files of a pipeline, the last two of a tier that no command chooses.
const PIPELINE: [&str; 8] = [
    "p.ron",
    "base.ron",
    "table.cube",
    "kinds/glow/node.ron",
    "kinds/glow/glow.wgsl",
    "kinds/lib/shared.wgsl",
    "low.ron",
    "low.cube",
];

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    for name in ["kinds/glow", "kinds/lib"] {
        fs::create_dir_all(folder.file(name)).expect("a temporary folder");
    }
    for (name, text) in [
        ("kinds/glow/node.ron", NODE),
        ("kinds/glow/glow.wgsl", SHADER),
        ("kinds/lib/shared.wgsl", SHARED),
        ("base.ron", BASE),
        ("p.ron", "Pipeline(extends: \"base.ron\", tiers: { \"low\": \"low.ron\" })"),
        ("low.ron", "Pipeline(extends: \"base.ron\", set: { \"look.file\": \"low.cube\" })"),
        ("table.cube", TABLE),
        ("low.cube", TABLE),
        ("metered.ron", METERED),
        ("shot.meter", METER),
    ] {
        folder.with(name, text.as_bytes());
    }
    save(&folder.file("room.exr"), &room(12, 8));
    for frame in 1..=2 {
        save(&folder.file(&format!("shot.{frame}.exr")), &room(12, 8));
        folder.with(&format!("eye.{frame}.json"), CAMERA.as_bytes());
    }
    folder
}

/// The bytes of all files, by their names.
fn contents(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.0.clone()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.ends_with(super::CACHE) {
            } else if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(path.to_string_lossy().into_owned(), fs::read(&path).unwrap_or_default());
            }
        }
    }
    found
}

/// That each command is refused with these words, before anything is written.
fn refused(folder: &Folder, table: &[(&str, &str)]) {
    let before = contents(folder);
    for (line, words) in table {
        folder.run(&format!("{line} --nodes kinds")).fails_saying(1, &[words]);
        assert_eq!(contents(folder), before, "{line}");
    }
}

/// The ways to name the file of an option.
enum Use {
    /// It reads the file. These words are in one of its lines.
    Reads(&'static str),
    /// It writes the file: these words follow its lines. `FILE` stands for the file, and `LINK` for a link to it whose
    /// name ends as it must.
    Writes(&'static str),
    /// It writes files to a folder, or is the only one that takes the file.
    Else,
}
use Use::{Else, Reads, Writes};

/// Lines of the commands that write files, which read all that the command can read; and the files that they read.
const LINES: [(&str, &str, &[&str]); 8] = [
    ("render", "render p.ron shot.#.exr --nodes kinds --allow .", &["shot.2.exr"]),
    (
        "render",
        "render metered.ron shot.#.exr --input eye=eye.#.json --frames 1-2 --meter shot.meter",
        &["metered.ron", "shot.2.exr", "eye.2.json", "shot.meter"],
    ),
    (
        "meter",
        "meter metered.ron shot.#.exr --input eye=eye.#.json --nodes kinds --allow .",
        &["metered.ron", "shot.2.exr", "eye.2.json", "kinds/glow/node.ron"],
    ),
    ("measure", "measure p.ron room.exr --input scene=shot.2.exr --nodes kinds --allow .", &["room.exr", "shot.2.exr"]),
    (
        "tune",
        "tune p.ron room.exr --input scene=shot.2.exr --error 1 --nodes kinds --allow .",
        &["room.exr", "shot.2.exr"],
    ),
    ("bench", "bench p.ron --size 16x16 --frames 1 --nodes kinds --allow .", &[]),
    ("stress", "stress p.ron --quick --nodes kinds --allow .", &[]),
    ("lut", "lut p.ron --from Srgb --nodes kinds --allow .", &[]),
];

/// All options that name files, by the command and by the names that the program's definition gives them.
const FILES: &[(&str, &str, Use)] = &[
    ("", "folder", Else),
    ("", "ocio", Else),
    ("demo", "out", Else),
    ("view", "pipeline", Else),
    ("view", "input", Else),
    ("view", "inputs", Else),
    ("render", "pipeline", Reads("p.ron")),
    ("render", "input", Reads("shot.#.exr")),
    ("render", "inputs", Reads("--input eye=eye.#.json")),
    ("render", "meter", Reads("--meter shot.meter")),
    ("render", "out", Writes("-o LINK.#.png")),
    ("render", "outputs", Writes("--output display=LINK.#.png")),
    ("render", "json", Writes("-o out.#.png --json FILE")),
    ("meter", "pipeline", Reads("metered.ron")),
    ("meter", "input", Reads("shot.#.exr")),
    ("meter", "inputs", Reads("--input eye=eye.#.json")),
    ("meter", "out", Writes("-o FILE")),
    ("info", "files", Else),
    ("check", "pipelines", Else),
    ("plan", "pipeline", Else),
    ("plan", "diff", Else),
    ("lut", "pipeline", Reads("p.ron")),
    ("lut", "out", Writes("-o LINK.cube")),
    ("new", "file", Else),
    ("nodes", "repository", Else),
    ("pipelines", "write", Else),
    ("measure", "pipeline", Reads("p.ron")),
    ("measure", "images", Reads("room.exr")),
    ("measure", "inputs", Reads("--input scene=shot.2.exr")),
    ("measure", "json", Writes("--json FILE")),
    ("measure", "plot", Writes("--plot LINK.svg")),
    ("measure", "error_image", Else),
    ("tune", "pipeline", Reads("p.ron")),
    ("tune", "images", Reads("room.exr")),
    ("tune", "inputs", Reads("--input scene=shot.2.exr")),
    ("tune", "out", Writes("-o FILE")),
    ("tune", "state", Writes("--state FILE")),
    ("bench", "pipeline", Reads("p.ron")),
    ("bench", "json", Writes("--json FILE")),
    ("stress", "pipelines", Reads("p.ron")),
    ("stress", "json", Writes("--json FILE")),
    ("man", "folder", Else),
];

/// Options of all commands that name a folder of files which are read.
const READ_EVERYWHERE: [&str; 2] = ["nodes", "allow"];

/// Options that take any word and name no file.
const WORDS: [&str; 19] = [
    "adapter",
    "case",
    "code",
    "cut",
    "diff_tier",
    "dynamic",
    "explain",
    "facts",
    "frames",
    "gain_map",
    "kind",
    "name",
    "new",
    "output",
    "sets",
    "shell",
    "tier",
    "input_space",
    "video",
];

/// Arguments of a command that take any word or path.
fn open_arguments(command: &clap::Command) -> Vec<String> {
    let is_open = |argument: &&clap::Arg| {
        let value = argument.get_value_parser().type_id();
        value == TypeId::of::<String>() || value == TypeId::of::<PathBuf>() || value == TypeId::of::<OsString>()
    };
    command.get_arguments().filter(is_open).map(|argument| argument.get_id().to_string()).collect()
}

#[test]
fn each_option_that_may_name_a_file_is_known_here() {
    let program = afterimage_cli::command();
    let mut open: Vec<(String, String)> = Vec::new();
    for command in std::iter::once(&program).chain(program.get_subcommands()) {
        let name = if command.get_name() == program.get_name() { "" } else { command.get_name() };
        open.extend(open_arguments(command).into_iter().map(|argument| (name.to_owned(), argument)));
    }
    for (command, argument) in &open {
        let is_known = WORDS.contains(&argument.as_str())
            || READ_EVERYWHERE.contains(&argument.as_str())
            || FILES.iter().any(|(of, known, _)| of == command && known == argument)
            || command.as_str() == "job" && FILES.iter().any(|(of, known, _)| *of == "render" && known == argument);
        assert!(is_known, "does `{argument}` of `{command}` name a file? Add it to FILES or WORDS");
    }
    for (command, argument, how) in FILES {
        let is_there = open.iter().any(|(of, known)| of == command && known == argument);
        assert!(is_there || *argument == "ocio", "`{command}` has no `{argument}`");
        if let Reads(words) = how {
            let mut lines = LINES.iter().filter(|(of, ..)| of == command);
            assert!(lines.any(|(_, line, _)| line.contains(words)), "no line of `{command}` has `{words}`");
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn no_output_replaces_a_file_that_its_run_reads() {
    let folder = folder("own-files");
    let before = contents(&folder);
    for (command, line, own) in LINES {
        let of_pipeline: &[&str] = if line.contains("p.ron") { &PIPELINE } else { &[] };
        let written = FILES.iter().filter_map(|(of, argument, how)| match how {
            Writes(words) if *of == command => Some((argument, words)),
            _ => None,
        });
        let written: Vec<_> = written.collect();
        for (number, (argument, words)) in written.iter().enumerate() {
            // Each option has the first file, and each file has an option.
            let files = own.iter().chain(of_pipeline).enumerate();
            for (_, file) in files.filter(|(at, _)| *at == 0 || at % written.len() == number) {
                let ending = words.split_once("LINK").map(|(_, ending)| ending.split(' ').next().unwrap_or_default());
                let link = ending.map(|ending| format!("link{}", ending.replace('#', "1")));
                if let Some(link) = &link {
                    folder.link(link, file);
                }
                let words = words.replace("FILE", file).replace("LINK", "link");
                let outcome = folder.run(&format!("{line} {words}"));
                link.iter().for_each(|link| fs::remove_file(folder.file(link)).expect("the link is there"));
                assert!(outcome.err.contains(": this is "), "{argument}: {line} {words}: {}", outcome.err);
                outcome.fails_saying(1, &["hint: choose another name for the output"]);
                assert_eq!(contents(&folder), before, "{line} {words}");
            }
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_refusal_says_what_the_file_is() {
    let folder = folder("own-names");
    for (file, what) in [
        ("p.ron", "the pipeline"),
        ("base.ron", "a file that the pipeline names"),
        ("table.cube", "a file that the pipeline names"),
        ("kinds/glow/node.ron", "a file of a node kind"),
        ("kinds/glow/glow.wgsl", "a file of a node kind"),
        ("kinds/lib/shared.wgsl", "a file of a node kind"),
    ] {
        let said = format!("{file}: this is {what}");
        refused(&folder, &[(&format!("bench p.ron --size 16x16 --frames 1 --allow . --json {file}"), &said)]);
    }
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder("own-outputs");
    let line = |second: &str| format!("render p.ron room.exr --output display=t.png --output same={second}");
    for second in ["t.png", "./t.png", "kinds/../t.png"] {
        refused(&folder, &[(&line(second), "two outputs go to")]);
    }
    #[cfg(target_os = "linux")]
    {
        folder.link("link.png", "t.png");
        refused(&folder, &[(&line("link.png"), "two outputs go to this file, which is also `t.png`")]);
    }
}

#[test]
fn errors_of_images_do_not_replace_what_is_measured() {
    let folder = folder("own-figures");
    folder.with("room-b.png", b"");
    refused(
        &folder,
        &[
            ("measure p.ron room.exr --json f.svg --plot ./f.svg", "two outputs go to this file"),
            ("measure p.ron room.exr room-b.png --error-image .", "an output may replace an image that is measured"),
            ("tune p.ron room.exr --error 1 -o t.ron --state ./t.ron", "two outputs go to this file"),
        ],
    );
}

#[test]
#[cfg(target_os = "linux")]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_link_to_no_file_gets_one_and_hard_links_are_parted() {
    let folder = folder("own-links");
    folder.link("dangling.png", "new.png");
    folder.run("render p.ron room.exr -o dangling.png --nodes kinds").good();
    assert!(folder.file("dangling.png").is_symlink() && folder.file("new.png").is_file());
    let room = fs::read(folder.file("room.exr")).expect("a picture");
    fs::hard_link(folder.file("room.exr"), folder.file("hard.png")).expect("a link");
    folder.run("render p.ron room.exr -o hard.png --nodes kinds").good();
    assert!(fs::read(folder.file("room.exr")).expect("a picture") == room);
    assert!(fs::read(folder.file("hard.png")).expect("a picture") != room);
}
