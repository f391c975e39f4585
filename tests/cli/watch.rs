//! `render --watch`: each picture is that of a run of its own.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use afterimage_media::{Encoding, Picture, write_image};

use super::{Folder, room};

/// A program that waits for changes, ended with this.
struct Watching {
    program: Child,
    lines: Receiver<String>,
}

impl Watching {
    fn start(folder: &Folder, line: &str) -> Self {
        let mut program = folder.command(line).stderr(Stdio::piped()).spawn().expect("the program starts");
        let errors = BufReader::new(program.stderr.take().expect("it is piped"));
        let (to, lines) = channel();
        std::thread::spawn(move || errors.lines().map_while(Result::ok).try_for_each(|line| to.send(line)));
        Self { program, lines }
    }

    /// Waits for a line that has this.
    fn says(&self, words: &str) {
        let mut said = Vec::new();
        while let Ok(line) = self.lines.recv_timeout(Duration::from_secs(120)) {
            if line.contains(words) {
                return;
            }
            said.push(line);
        }
        panic!("`{words}` is not said: {said:?}");
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

const LOOK: &str = "Pipeline(extends: \"tsushima.ron\", set: { \"metered.compensation\": EV })";

fn write_look(folder: &Folder, ev: &str) {
    fs::write(folder.file("look.ron"), LOOK.replace("EV", ev)).expect("it can be written");
}

fn save(folder: &Folder, picture: &Picture) {
    write_image(&folder.file("in.exr"), picture, &Encoding::EXR).expect("it can be written");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pictures_after_changes_are_those_of_runs_of_their_own() {
    let folder = Folder::new("watch");
    folder.run("pipelines tsushima --write tsushima.ron").good();
    write_look(&folder, "0.0");
    save(&folder, &room(64, 48));
    let watching = Watching::start(&folder, "render look.ron in.exr -o out.png --watch");
    let is_alone = |what: &str| {
        watching.says("wrote `out.png`; waiting for changes");
        folder.run("render look.ron in.exr -o alone.png").good();
        let bytes = |name: &str| fs::read(folder.file(name)).expect("it is written");
        assert!(bytes("out.png") == bytes("alone.png"), "{what}");
        bytes("out.png")
    };
    let first = is_alone("at first");
    write_look(&folder, "1.0");
    assert!(is_alone("a parameter") != first);
    save(&folder, &room(90, 30));
    is_alone("an image of another size");
    fs::write(folder.file("look.ron"), "Pipeline(").expect("it can be written");
    watching.says("look.ron");
    write_look(&folder, "0.0");
    is_alone("after a mistake");
    save(&folder, &room(64, 48));
    assert!(is_alone("as at first") == first);
}
