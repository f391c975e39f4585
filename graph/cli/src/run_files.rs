//! The files of a run: what is read and what is written, so that no output replaces an input or another output.
//!
//! A command notes all files that it reads, then claims each file that it writes, and only then writes.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use afterimage_media::{real_output_path, real_path};

use crate::failure::Failure;

/// The files of a run. Clones share them.
///
/// Two names are one file if they lead to it: `t.png` and `./t.png`, or a link and its target. Hard links are two
/// files, because writing one of them replaces that name only.
#[derive(Clone, Default)]
pub(crate) struct RunFiles(Rc<RefCell<Files>>);

#[derive(Default)]
struct Files {
    /// What each input is, by its path without links.
    inputs: BTreeMap<PathBuf, String>,
    /// The name of each output on the command line, by its path without links.
    outputs: BTreeMap<PathBuf, PathBuf>,
}

impl RunFiles {
    /// Notes a file that the run reads; `what` names it in errors: "the pipeline". One that does not exist is reported
    /// where it is read.
    pub(crate) fn reads(&self, path: &Path, what: &str) {
        if let Ok(real) = real_path(path) {
            self.0.borrow_mut().inputs.entry(real).or_insert_with(|| what.to_owned());
        }
    }

    /// Claims a file that the run writes.
    ///
    /// # Errors
    /// The run reads it, or writes it under another name, or it cannot be written: its folder does not exist.
    pub(crate) fn writes(&self, path: &Path) -> Result<(), Failure> {
        let Files { inputs, outputs } = &mut *self.0.borrow_mut();
        let real = real_output_path(path)?;
        if let Some(what) = inputs.get(&real) {
            return Err(
                Failure::user(format!("{}: this is {what}", path.display())).hint("choose another name for the output")
            );
        }
        let Some(other) = outputs.insert(real, path.to_owned()) else { return Ok(()) };
        let (path, other) = (path.display(), other.display());
        Err(if other.to_string() == path.to_string() {
            Failure::user(format!("two outputs go to the file `{path}`"))
        } else {
            Failure::user(format!("two outputs go to one file: `{other}` and `{path}`"))
        }
        .hint("name a file for each"))
    }

    /// Refuses a folder for outputs whose names follow from the run, if the run reads a file in it whose name
    /// `is_output` takes for one of them.
    pub(crate) fn writes_into(&self, folder: &Path, is_output: impl Fn(&str) -> bool) -> Result<(), Failure> {
        // A folder that does not exist yet has no inputs.
        let Ok(folder) = real_path(folder) else { return Ok(()) };
        for (path, what) in &self.0.borrow().inputs {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.parent() == Some(&folder) && is_output(&name) {
                return Err(Failure::user(format!("{}: an output may replace {what}", path.display()))
                    .hint("choose another folder for the outputs"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use std::fs;

    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("afterimage-run-files-{}-{test}", std::process::id()));
            fs::create_dir_all(path.join("below")).unwrap();
            Self(path)
        }

        fn with(&self, name: &str) -> PathBuf {
            fs::write(self.0.join(name), name).unwrap();
            self.0.join(name)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn refusal(result: Result<(), Failure>) -> String {
        match result.unwrap_err() {
            Failure::Error { message, .. } => message,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_output_is_no_input_however_it_is_called() {
        let folder = Folder::new("inputs");
        let run = RunFiles::default();
        run.reads(&folder.with("a.exr"), "the image");
        run.reads(&folder.0.join("missing.exr"), "nothing");
        for name in ["a.exr", "./a.exr", "below/../a.exr"] {
            assert!(refusal(run.writes(&folder.0.join(name))).ends_with("this is the image"), "{name}");
        }
        run.writes(&folder.0.join("b.exr")).unwrap();
        run.writes(&folder.0.join("missing.exr")).unwrap();
    }

    #[test]
    fn two_outputs_are_not_one_file_even_before_it_exists() {
        let folder = Folder::new("outputs");
        let run = RunFiles::default();
        run.writes(&folder.0.join("t.png")).unwrap();
        for name in ["t.png", "./t.png", "below/../t.png"] {
            assert!(refusal(run.writes(&folder.0.join(name))).starts_with("two outputs go to"), "{name}");
        }
        run.writes(&folder.0.join("below/t.png")).unwrap();
        let words = refusal(run.writes(&folder.0.join("no/t.png")));
        assert!(words.ends_with("the folder of this output does not exist"), "{words}");
    }

    #[test]
    #[cfg(unix)]
    fn links_lead_to_their_files_also_if_there_is_none() {
        use std::os::unix::fs::symlink;
        let folder = Folder::new("links");
        let run = RunFiles::default();
        run.reads(&folder.with("a.exr"), "the image");
        symlink("a.exr", folder.0.join("to-a")).unwrap();
        symlink("../to-a", folder.0.join("below/to-a")).unwrap();
        assert!(refusal(run.writes(&folder.0.join("below/to-a"))).ends_with("this is the image"));
        symlink("new.png", folder.0.join("to-new")).unwrap();
        run.writes(&folder.0.join("to-new")).unwrap();
        assert!(refusal(run.writes(&folder.0.join("new.png"))).starts_with("two outputs go to one file"));
        symlink("circle", folder.0.join("circle")).unwrap();
        assert!(refusal(run.writes(&folder.0.join("circle"))).ends_with("its links lead in a circle"));
    }

    #[test]
    fn a_folder_of_outputs_has_no_inputs_of_such_names() {
        let folder = Folder::new("folders");
        let run = RunFiles::default();
        run.reads(&folder.with("a.png"), "the image");
        assert!(refusal(run.writes_into(&folder.0, |name| name.ends_with(".png"))).ends_with("replace the image"));
        run.writes_into(&folder.0, |name| name.ends_with(".svg")).unwrap();
        run.writes_into(&folder.0.join("below"), |_| true).unwrap();
    }
}
