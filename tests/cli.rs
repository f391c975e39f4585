//! The program as a user runs it: arguments in; pictures, words and an exit status out.

mod bands;
#[cfg(target_os = "linux")]
mod bombs;
mod broken;
mod built_in;
mod cameras;
mod chunks;
mod environment;
mod errors;
mod explain;
mod films;
mod folders;
mod foreign;
mod gaps;
mod hostile;
mod info;
mod job;
#[cfg(target_os = "linux")]
mod limits;
mod luts;
mod mend;
mod meters;
mod outputs;
mod own_files;
mod pictures;
mod plans;
mod quantize;
mod readings;
mod recipes;
mod scaffold;
mod sequences;
mod spaces;
#[cfg(target_os = "linux")]
mod strangers;
mod stress;
mod tiers;
mod topics;
mod tunes;
mod untrusted;
mod volumes;
mod watch;
mod windows;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use afterimage_media::{Encoding, Picture, Pixels, write_image};

use crate::support::command::program;

/// The cache folder of the program.
const CACHE: &str = ".cache";

/// A folder of one test, removed at its end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("afterimage-cli-{}-{test}", std::process::id()));
        fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn with(&self, name: &str, bytes: &[u8]) -> PathBuf {
        fs::write(self.file(name), bytes).expect("a temporary file");
        self.file(name)
    }

    /// The names of all files but the program's own cache, sorted.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("the folder");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| name != CACHE);
        names.sort();
        names
    }

    /// Runs the program in this folder with the words of `line`; `{name}` stands for a built-in pipeline.
    fn run(&self, line: &str) -> Outcome {
        let output = self.command(line).output().expect("the program starts");
        Outcome::of(&output)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = program(&self.file(CACHE));
        command.current_dir(&self.0).stdin(Stdio::null());
        for word in line.split(' ') {
            match word.strip_prefix('{').and_then(|word| word.strip_suffix('}')) {
                Some(name) => command.arg(built_in(name)),
                None => command.arg(word),
            };
        }
        command
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The output of the program, and its exit status.
#[derive(Debug)]
struct Outcome {
    status: Option<i32>,
    out: String,
    err: String,
}

impl Outcome {
    fn of(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self { status: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }

    /// That it went well; what it wrote to standard output.
    #[track_caller]
    fn good(self) -> String {
        assert_eq!(self.status, Some(0), "{}", self.err);
        self.out
    }

    /// That it went well; what it wrote to standard error.
    #[track_caller]
    fn notes(self) -> String {
        assert_eq!(self.status, Some(0), "{}", self.err);
        self.err
    }

    /// That it stopped with this status and these words, to the letter.
    #[track_caller]
    fn fails(self, status: i32, words: &str) {
        assert_eq!((self.status, self.err.trim_end()), (Some(status), words));
    }

    /// That it stopped with this status and printed all of this.
    #[track_caller]
    fn fails_saying(self, status: i32, parts: &[&str]) {
        assert_eq!(self.status, Some(status), "{}", self.err);
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is not in:\n{}", self.err);
        }
    }
}

fn built_in(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../pipelines").join(format!("{name}.ron"))
}

/// Middle gray, with a white lamp of four pixels in it and light that grows from left to right.
fn room(width: u32, height: u32) -> Picture {
    let mut pixels = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let light = 0.05 + 0.4 * x as f32 / width as f32;
            let lamp = x.abs_diff(width / 2) < 2 && y.abs_diff(height / 2) < 2;
            let [r, g, b] = if lamp { [40.0, 30.0, 20.0] } else { [light, light * 0.8, light * 0.6] };
            pixels.extend([r, g, b, 1.0]);
        }
    }
    Picture::new(width, height, Pixels::Float(pixels))
}

fn save(path: &Path, picture: &Picture) {
    write_image(path, picture, &Encoding::EXR).expect("a picture of a test can be written");
}

/// In 32-bit floats.
fn save_exact(path: &Path, picture: &Picture) {
    let options = Encoding { bits: 32, ..Encoding::EXR };
    write_image(path, picture, &options).expect("a picture of a test can be written");
}

#[test]
fn help_version_and_nonsense() {
    let folder = Folder::new("help");
    let help = folder.run("--help").good();
    for command in ["demo", "render", "lut", "check", "plan", "nodes", "stress"] {
        assert!(help.contains(command), "{help}");
    }
    assert!(folder.run("--version").good().starts_with("afterimage "));
    folder.run("rendr").fails_saying(1, &["rendr", "render"]);
    folder.run("render").fails_saying(1, &["<PIPELINE>"]);
    assert_eq!(folder.names(), Vec::<String>::new());
}
