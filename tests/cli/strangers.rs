//! Files from strangers: what a pipeline or a folder of kinds may name, and what is read at all.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use afterimage_graph::diagnostic::is_control;

use super::{Folder, Outcome, room, save};

/// A run that ends on its own.
const MAX_LENGTH: Duration = Duration::from_secs(60);

impl Folder {
    /// Runs the program; a run that does not end is a failure.
    #[track_caller]
    fn run_soon(&self, line: &str) -> Outcome {
        self.run_measured(line).0
    }

    /// Runs the program; also returns the most memory that it was seen to have, in MiB.
    #[track_caller]
    pub(super) fn run_measured(&self, line: &str) -> (Outcome, u64) {
        let mut command = self.command(line);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
        let (start, mut most) = (Instant::now(), 0);
        while child.try_wait().expect("it can be waited for").is_none() {
            if start.elapsed() > MAX_LENGTH {
                child.kill().expect("it runs");
                panic!("`{line}` does not end");
            }
            most = most.max(peak(child.id()).unwrap_or(0));
            std::thread::sleep(Duration::from_millis(5));
        }
        (Outcome::of(&child.wait_with_output().expect("it has ended")), most)
    }

    fn pipe(&self, name: &str) {
        let made = Command::new("mkfifo").arg(self.file(name)).status().expect("`mkfifo` is part of the system");
        assert!(made.success());
    }

    pub(super) fn link(&self, name: &str, to: impl AsRef<Path>) {
        symlink(to, self.file(name)).expect("a link");
    }
}

/// The most memory that a process has had, in MiB.
fn peak(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()? >> 10)
}

/// A pipeline of one node, with further sections.
fn pipeline(node: &str, more: &str) -> Vec<u8> {
    format!(
        r#"Pipeline(inputs: {{ "scene": Encoded }}, nodes: {{ "a": {node} }}, outputs: {{ "display": "a" }}, {more})"#
    )
    .into_bytes()
}

fn table(file: &str) -> Vec<u8> {
    pipeline(&format!(r#"ColorLut(source: "scene", file: "{file}")"#), "")
}

const CUBE: &[u8] = b"LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n";

/// Names of things that are no files to be read, and what is said about each.
fn no_files(folder: &Folder) -> [(&'static str, &'static str); 5] {
    folder.pipe("pipe");
    folder.link("endless", "/dev/zero");
    folder.link("circle", "circle");
    fs::create_dir(folder.file("folder")).expect("a folder");
    let huge = fs::File::create(folder.file("huge")).expect("a file");
    huge.set_len(20 << 30).expect("a file with a hole");
    [
        ("pipe", "this is a pipe or a device, not a file"),
        ("endless", "only files in the folder of the pipeline and below are read; `--allow /dev` permits this one"),
        ("circle", "its links lead in a circle"),
        ("folder", "it is a folder"),
        ("huge", "the file has 20.0 GiB, and at most 1.0 GiB are read"),
    ]
}

#[test]
fn a_pipeline_reads_regular_files_of_a_bounded_size() {
    let folder = Folder::new("no-files");
    let plain = r#"ColorLut(source: "scene")"#;
    for (name, words) in no_files(&folder) {
        folder.with("extends.ron", format!("Pipeline(extends: \"{name}\")").as_bytes());
        folder.with("inner.ron", &pipeline(&format!("Pipeline(file: \"{name}\", source: \"scene\")"), ""));
        folder.with("tier.ron", &pipeline(plain, &format!("tiers: {{ \"low\": \"{name}\" }}")));
        folder.with("table.ron", &table(name));
        for pipeline in ["extends", "inner", "tier", "table"] {
            let outcome = folder.run_soon(&format!("check {pipeline}.ron"));
            outcome.fails_saying(1, &[&format!("error[unreadable-file]: cannot read `{name}`: {words}"), pipeline]);
        }
    }
}

#[test]
fn the_files_of_the_command_line_are_regular_too() {
    let folder = Folder::new("no-pipelines");
    for (name, words) in no_files(&folder) {
        // The user may name any file, but not any kind of file.
        let words = match name {
            "endless" => "this is a pipe or a device, not a file",
            "huge" => "the file has 20.0 GiB, and at most 16 MiB are read",
            _ => words,
        };
        folder.run_soon(&format!("check {name}")).fails_saying(1, &[&format!("the pipeline `{name}`: {words}")]);
    }
    folder.with("table.ron", &table(""));
    let mut command = folder.command("check table.ron --set");
    let output = command.arg("a.file=\"pipe\"").output().expect("the program starts");
    Outcome::of(&output).fails_saying(1, &["cannot read `pipe`: this is a pipe or a device, not a file"]);
}

#[test]
fn a_long_text_is_not_parsed() {
    let folder = Folder::new("long");
    folder.with("long.ron", &vec![b' '; (16 << 20) + 1]);
    folder.with("extends.ron", b"Pipeline(extends: \"long.ron\")");
    folder.run_soon("check long.ron").fails_saying(1, &["the file has 16 MiB, and at most 16 MiB are read"]);
    folder
        .run_soon("check extends.ron")
        .fails_saying(1, &["error[too-much-text]: the files that the pipeline uses have more than"]);
}

#[test]
fn the_files_of_a_kind_are_regular_and_in_its_folder() {
    let folder = Folder::new("no-shaders");
    fs::create_dir_all(folder.file("kinds/tint")).expect("a folder");
    let declaration = "Kind(name: \"Tint\", doc: \"Tints.\", inputs: { \"source\": Image(doc: \"The image.\") }, \
                       outputs: { \"result\": Image(doc: \"The image.\", state: Same(\"source\")) })";
    folder.with("kinds/tint/node.ron", declaration.as_bytes());
    folder.with("shader.wgsl", b"fn tint(source: vec4f) -> vec4f { return source; }");
    folder.with("p.ron", &pipeline("Tint(source: \"scene\")", ""));
    let shader = "kinds/tint/tint.wgsl";
    folder.pipe(shader);
    let words = "cannot read the shader `kinds/tint/tint.wgsl`: this is a pipe or a device, not a file";
    folder.run_soon("check p.ron --nodes kinds").fails_saying(1, &[words]);
    fs::remove_file(folder.file(shader)).expect("the pipe");
    folder.link(shader, "../../shader.wgsl");
    let words = ["cannot read the shader", "only files in the folder of `--nodes` and below are read; `--allow /"];
    folder.run_soon("check p.ron --nodes kinds").fails_saying(1, &words);
    folder.run_soon("nodes Tint --nodes kinds").fails_saying(1, &words);
    folder.run_soon("check p.ron --nodes kinds --allow .").good();
    folder.run_soon("nodes Tint --nodes kinds --allow .").good();
}

#[test]
fn a_pipeline_names_files_of_its_folder_and_of_allowed_ones() {
    let folder = Folder::new("allow");
    for inner in ["mine/below", "other"] {
        fs::create_dir_all(folder.file(inner)).expect("a folder");
    }
    folder.with("mine/below/good.cube", CUBE);
    folder.with("other/secret.cube", CUBE);
    folder.link("mine/link.cube", "../other/secret.cube");
    folder.link("mine/inside.cube", "below/good.cube");
    let absolute = folder.file("other/secret.cube").to_str().expect("a name in UTF-8").to_owned();
    for (named, is_inside) in [
        ("below/good.cube", true),
        ("below/../below/good.cube", true),
        ("inside.cube", true),
        ("../other/secret.cube", false),
        ("below/../../other/secret.cube", false),
        ("link.cube", false),
        (&absolute, false),
    ] {
        folder.with("mine/p.ron", &table(named));
        folder.run_soon("check mine/p.ron --allow other").good();
        let outcome = folder.run_soon("check mine/p.ron");
        match is_inside {
            true => drop(outcome.good()),
            false => outcome.fails_saying(
                1,
                &[
                    "only files in the folder of the pipeline and below are read; `--allow /",
                    "other` permits",
                    "p.ron:1",
                ],
            ),
        }
    }
    folder.run_soon("check mine/p.ron --allow nowhere").fails_saying(1, &["there is no such folder"]);
}

/// What the user names needs no permission, and nothing can pass itself off as named by the user.
#[test]
fn a_file_of_the_command_line_needs_no_permission() {
    let folder = Folder::new("named");
    for inner in ["mine", "other"] {
        fs::create_dir_all(folder.file(inner)).expect("a folder");
    }
    folder.with("other/secret.cube", CUBE);
    folder.with("mine/p.ron", &table("../other/secret.cube"));
    let mut command = folder.command("check mine/p.ron --set");
    Outcome::of(&command.arg("a.file=\"other/secret.cube\"").output().expect("the program starts"))
        .fails_saying(1, &["only files in the folder of the pipeline"]);
    folder.with("mine/p.ron", &table(""));
    let mut command = folder.command("check mine/p.ron --set");
    Outcome::of(&command.arg("a.file=\"other/secret.cube\"").output().expect("the program starts")).good();
    folder.with("mine/--set", &table("../other/secret.cube"));
    folder.with("mine/p.ron", b"Pipeline(extends: \"--set\")");
    let mut command = folder.command("check p.ron");
    let output = command.current_dir(folder.file("mine")).output().expect("the program starts");
    Outcome::of(&output).fails_saying(1, &["only files in the folder of the pipeline"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipe_in_the_cache_stops_nothing() {
    let folder = Folder::new("pipe-cache");
    save(&folder.file("room.exr"), &room(16, 9));
    folder.run_soon("render {glare} room.exr -o out.png").good();
    let cache = folder.file(".cache/afterimage");
    let names: Vec<_> = fs::read_dir(&cache).expect("the cache").map(|entry| entry.expect("an entry").path()).collect();
    assert!(names.iter().any(|path| path.extension().is_some_and(|ending| ending == "pipelines")), "{names:?}");
    for path in &names {
        fs::remove_file(path).expect("a file of the cache");
        folder.pipe(path.to_str().expect("a name in UTF-8"));
    }
    folder.run_soon("render {glare} room.exr -o out.png").good();
}

/// A terminal shows no control character of a file, of its name or of an argument, and no line that one of them begins:
/// a farm would obey it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn control_characters_do_not_reach_the_terminal() {
    const EVIL: &str = "\u{1b}[8m\u{1b}]0;x\u{7}\u{9b}2J\u{85}\r\u{7f}\u{202e}\u{2028}\nopenjd_fail: x";
    let folder = Folder::new("controls");
    save(&folder.file("room.exr"), &room(16, 9));
    let (image, file) = (format!("a{EVIL}.exr"), format!("b{EVIL}.ron"));
    let label = r#"label: "l\u{1b}[8m\u{9b}2J\u{202e}\nopenjd_fail: x""#;
    folder.with("label.ron", &pipeline(&format!("ColorLut(source: \"scene\", {label})"), ""));
    folder
        .with("comment.ron", format!("/* {EVIL} */ Pipeline(nodes: {{ \"a\": Nothing() }}, outputs: {{}})").as_bytes());
    folder.with(&file, &pipeline("Nothing()", ""));
    fs::copy(folder.file("room.exr"), folder.file(&image)).expect("a copy");
    fs::write(folder.file(&format!("c{EVIL}.exr")), "no image").expect("a file");
    let broken = format!("c{EVIL}.exr");
    let option = format!("--{EVIL}");
    let (sequence, measured) = (format!("openjd_fail: {EVIL}.#.exr"), format!("openjd_fail: {EVIL}.#.meter"));
    fs::copy(folder.file("room.exr"), folder.file(&sequence.replace('#', "1"))).expect("a copy");
    folder.with("meter.ron", super::job::METERED.as_bytes());
    // Channels are called `\n`, and not `A`.
    let mut channels = fs::read(folder.file("room.exr")).expect("it is there");
    let at = channels.windows(3).position(|bytes| bytes == *b"A\0\x01").expect("it has alpha");
    channels[at] = b'\n';
    folder.with("channels.exr", &channels);
    for words in [
        vec!["check", &file],
        vec!["check", "--json", &file],
        vec!["check", "comment.ron"],
        vec!["plan", "label.ron"],
        vec!["plan", "label.ron", "--format", "json"],
        vec!["plan", &file],
        vec!["plan", "label.ron", "--format", &option],
        vec![&option],
        vec!["render", "label.ron", &broken, "-o", "out.png"],
        vec!["render", "label.ron", &image, "-o", &option],
        vec!["check", "label.ron", "--set", &option],
        vec!["nodes", EVIL],
        vec!["nodes", "--new", &option],
        vec!["explain", EVIL],
        vec!["pipelines", EVIL],
        vec!["info", &image, &broken, "channels.exr"],
        vec!["info", "--json", &image],
        vec!["render", "--openjd", "meter.ron", &sequence, "-o", &sequence.replace("exr", "out.exr")],
        vec!["render", "meter.ron", "channels.exr#A", "-o", "out.exr"],
        vec!["render", "meter.ron", &sequence, "-o", &sequence],
        vec!["meter", "meter.ron", &sequence, "-o", &measured],
        vec!["job", "meter.ron", &sequence, "-o", &sequence.replace("exr", "part.exr")],
        vec!["render", "meter.ron", "room.exr", "-o", "out.exr", "--adapter", EVIL],
        vec!["render", "meter.ron", "room.exr", "-o", "out.exr", "--input", EVIL],
        vec!["render", "meter.ron", "room.exr", "-o", "out.exr", "--frames", EVIL],
        vec!["render", "meter.ron", "room.exr", "-o", "out.exr", "--crop", EVIL],
        vec!["bench", &file, "--size", "16x16"],
        vec!["measure", &file, &image],
        vec!["tune", &file, &image, "--error", "1", "--name", EVIL],
        vec!["stress", &file, "--kind", EVIL],
    ] {
        let mut command = folder.command(words[0]);
        let output = command.args(&words[1..]).env("CLICOLOR_FORCE", "1").output().expect("the program starts");
        let Outcome { out, err, .. } = Outcome::of(&output);
        assert!(!(out.is_empty() && err.is_empty()), "{words:?} says nothing");
        for text in [out, err] {
            assert!(!text.contains("\u{1b}[8m"), "{words:?}: {text:?}");
            let plain = without_styles(&text);
            let is_safe = |c: char| c == '\n' || c == '\t' || !is_control(c);
            assert!(plain.chars().all(is_safe), "{words:?}: {plain:?}");
            assert!(plain.lines().all(|line| !line.starts_with("openjd_fail")), "{words:?}: {plain}");
        }
    }
}

fn without_styles(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';');
        all + rest.strip_prefix('m').unwrap_or("\u{1b}")
    })
}

#[test]
fn the_pipeline_and_its_files_are_no_outputs() {
    let folder = Folder::new("no-outputs");
    save(&folder.file("room.exr"), &room(16, 9));
    folder.with("look.cube", CUBE);
    folder.with("p.ron", &table("look.cube"));
    folder.with("p.png", &table("look.cube"));
    folder.link("to-p.png", "p.ron");
    folder.link("to-look.png", "look.cube");
    let before = folder.names();
    for (line, what) in [
        ("render p.png room.exr -o p.png", "the pipeline"),
        ("render p.ron room.exr -o to-p.png", "the pipeline"),
        ("render p.ron room.exr -o to-look.png", "a file that the pipeline names"),
        ("render p.ron room.exr --output display=./to-p.png", "the pipeline"),
        ("render p.ron room.exr -o out.png --json p.ron", "the pipeline"),
        ("stress p.ron --quick --json ./p.ron", "the pipeline"),
    ] {
        let words = format!("this is {what}\n  hint: choose another name for the output");
        folder.run_soon(line).fails_saying(1, &[&words]);
    }
    assert_eq!(folder.names(), before);
    assert_eq!(fs::read(folder.file("p.ron")).expect("it is there"), table("look.cube"));
    assert_eq!(fs::read(folder.file("look.cube")).expect("it is there"), CUBE);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn measurements_do_not_replace_the_pipeline() {
    let folder = Folder::new("no-figures");
    save(&folder.file("room.exr"), &room(16, 9));
    folder.with("p.ron", &table(""));
    for line in [
        "measure p.ron room.exr --json p.ron",
        "tune p.ron room.exr --error 1 -o p.ron",
        "tune p.ron room.exr --error 1 --state p.ron",
        "bench p.ron --size 16x16 --frames 1 --json p.ron",
    ] {
        folder.run_soon(line).fails_saying(1, &["p.ron: this is the pipeline"]);
    }
    assert_eq!(fs::read(folder.file("p.ron")).expect("it is there"), table(""));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_run_writes_what_the_command_line_names_and_nothing_else() {
    let folder = Folder::new("only-outputs");
    save(&folder.file("room.exr"), &room(16, 9));
    folder.with("look.cube", CUBE);
    folder.with("p.ron", &table("look.cube"));
    let mut names = folder.names();
    for (line, written) in [
        ("check p.ron --plan", &[][..]),
        ("plan p.ron --format svg", &[]),
        ("info room.exr look.cube", &[]),
        ("render p.ron room.exr -o out.png --json out.json", &["out.json", "out.png"]),
        ("render p.ron room.exr -o no/out.png", &[]),
        ("measure p.ron room.exr --json measured.json", &["measured.json"]),
    ] {
        folder.run_soon(line);
        names.extend(written.iter().map(|name| (*name).to_owned()));
        names.sort();
        assert_eq!(folder.names(), names, "{line}");
    }
}
