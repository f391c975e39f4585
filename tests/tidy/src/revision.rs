//! The files of a revision of git.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The files of a revision in a temporary folder, which is removed on drop.
pub struct Revision(PathBuf);

impl Revision {
    /// Unpacks a revision of the repository at `root`.
    ///
    /// # Panics
    ///
    /// Panics if git does not know the revision.
    pub fn unpack(root: &Path, revision: &str) -> Self {
        let unpacked = Self(std::env::temp_dir().join(format!("afterimage-tidy-{}-{revision}", std::process::id())));
        std::fs::create_dir_all(unpacked.root()).expect("a temporary folder");
        let archive = unpacked.root().join("archive.tar");
        run(Command::new("git").args(["archive", revision, "--output"]).arg(&archive).current_dir(root));
        run(Command::new("tar").arg("xf").arg(&archive).current_dir(unpacked.root()));
        unpacked
    }

    /// The folder of the root manifest.
    pub fn root(&self) -> &Path {
        &self.0
    }
}

impl Drop for Revision {
    fn drop(&mut self) {
        // A folder that stays behind is the operating system's to remove.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn run(command: &mut Command) {
    let status = command.status();
    assert!(status.is_ok_and(|status| status.success()), "{command:?} fails");
}
