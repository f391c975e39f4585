//! Limits of the process: a system that gives too little is told as such, and no run ends by a signal.

use std::process::{Command, Stdio};

use super::{Folder, Outcome, room, save};

impl Folder {
    /// Runs the program after a command of the shell that sets a limit.
    fn run_limited(&self, limit: &str, line: &str) -> Outcome {
        let program = self.command(line);
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("{limit} && exec \"$0\" \"$@\"")]).arg(program.get_program());
        shell.args(program.get_args()).current_dir(&self.0).stdin(Stdio::null());
        shell.envs(program.get_envs().filter_map(|(name, value)| Some((name, value?))));
        // The driver's cache is that of all tests.
        shell.env("MESA_SHADER_CACHE_DISABLE", "true");
        Outcome::of(&shell.output().expect("a shell is part of the system"))
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_file_that_may_not_become_so_large_is_an_error() {
    let folder = Folder::new("limit-file");
    save(&folder.file("room.exr"), &room(64, 36));
    folder.with("out.png", b"old");
    folder.run_limited("ulimit -f 1", "render {glare} room.exr -o out.png").fails_saying(
        2,
        &["error: out.png: the file may not become so large\n  hint: this process may write no larger files (`ulimit -f`)"],
    );
    assert_eq!(folder.names(), ["out.png", "room.exr"]);
    assert_eq!(std::fs::read(folder.file("out.png")).expect("it is there"), b"old");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn too_little_memory_is_told_as_such() {
    let folder = Folder::new("limit-memory");
    save(&folder.file("room.exr"), &room(64, 36));
    // The part that fails first, and the driver's word for it, change with each of its libraries.
    for kibibytes in (60_000..=1_100_000).step_by(40_000) {
        let outcome = folder.run_limited(&format!("ulimit -v {kibibytes}"), "render {glare} room.exr -o out.png");
        let told = outcome.err.contains("(`ulimit -v`)");
        let is_told = outcome.status == Some(2) && told && !outcome.err.contains("is wrong");
        assert!(outcome.status == Some(0) || is_told, "{kibibytes}: {outcome:?}");
        assert!(!outcome.err.contains("panicked"), "{kibibytes}: {outcome:?}");
    }
}
