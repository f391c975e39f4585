//! The files of a run: what it reads and what it writes, so that no output replaces an input or another output.
//!
//! The list is that of the process. A program [begins](begin) one for each run; from then on it has every file that
//! is opened for reading, and [`AtomicFile`](super::AtomicFile) asks it before a file is replaced. A program adds
//! the files that it will open later ([`reads`]), and asks for its outputs before it works ([`writes`]). A process that
//! begins no list, such as a host, may replace what it has read.

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::codec::ErrorKind;
use crate::files::FileError;
use crate::files::paths::{check_replaceable, real_output_path, real_path};

static LIST: Mutex<Option<RunFiles>> = Mutex::new(None);

/// The description of an input that was opened before it was described.
const OPENED: &str = "a file that this run reads";

/// Begins the list of a run, and drops that of the previous one.
pub fn begin() {
    *list() = Some(RunFiles::default());
}

/// Adds a file that the run reads; `what` names it in errors: "the pipeline". One that does not exist is reported where
/// it is opened.
pub fn reads(path: &Path, what: &str) {
    if let Some(list) = &mut *list() {
        list.read(path, what);
    }
}

/// Claims a file that the run writes, before it works.
///
/// # Errors
/// As [`claims`]; and a file that is read-only.
pub fn writes(path: &Path) -> Result<(), FileError> {
    check_replaceable(path)?;
    claims(path)
}

/// Claims a file that the run writes unless it is there already.
///
/// Two names are one file if they lead to it: `t.png` and `./t.png`, or a symbolic link and its target. Hard links are
/// two files, because a writer replaces one name and leaves the other with the old file.
///
/// # Errors
/// The run reads it, or writes it under another name, or its folder does not exist.
pub fn claims(path: &Path) -> Result<(), FileError> {
    let Some(list) = &mut *list() else { return Ok(()) };
    list.write(path)
}

/// Refuses a folder for outputs whose names follow from the run, if the run reads a file in it whose name `is_output`
/// takes for one of them.
///
/// # Errors
/// There is such a file.
pub fn writes_into(folder: &Path, is_output: impl Fn(&str) -> bool) -> Result<(), FileError> {
    let Some(list) = &*list() else { return Ok(()) };
    list.write_into(folder, is_output)
}

/// Adds a file that was opened.
pub(super) fn opened(path: &Path) {
    reads(path, OPENED);
}

/// Refuses to replace a file that the run reads.
pub(super) fn check_output(path: &Path) -> Result<(), FileError> {
    let Some(list) = &*list() else { return Ok(()) };
    list.check_input(path, &real_output_path(path)?)
}

fn list() -> MutexGuard<'static, Option<RunFiles>> {
    LIST.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Default)]
struct RunFiles {
    /// The description of each input, by its path without links.
    inputs: BTreeMap<PathBuf, Input>,
    /// The name of each output on the command line, by its path without links.
    outputs: BTreeMap<PathBuf, PathBuf>,
}

struct Input {
    what: String,
    id: Option<FileId>,
}

/// The device and the number of a file that has one name; `None` for others, whose names cannot be told apart.
type FileId = (u64, u64);

#[cfg(unix)]
fn id(meta: &Metadata) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt;
    (meta.nlink() == 1).then(|| (meta.dev(), meta.ino()))
}

#[cfg(not(unix))]
fn id(_: &Metadata) -> Option<FileId> {
    None
}

impl RunFiles {
    fn read(&mut self, path: &Path, what: &str) {
        let Ok(real) = real_path(path) else { return };
        match self.inputs.get_mut(&real) {
            Some(known) if known.what == OPENED => what.clone_into(&mut known.what),
            Some(_) => {}
            None => {
                let id = real.metadata().ok().and_then(|meta| id(&meta));
                self.inputs.insert(real, Input { what: what.to_owned(), id });
            }
        }
    }

    fn write(&mut self, path: &Path) -> Result<(), FileError> {
        let real = real_output_path(path)?;
        self.check_input(path, &real)?;
        let Some(other) = self.outputs.insert(real, path.to_owned()) else { return Ok(()) };
        let message = match other == path {
            true => "two outputs go to this file".to_owned(),
            false => format!("two outputs go to this file, which is also `{}`", other.display()),
        };
        Err(FileError::new(path, ErrorKind::Naming, message).hint("name a file for each"))
    }

    /// Refuses an output, whose path without links is `real`, if it is an input.
    fn check_input(&self, path: &Path, real: &Path) -> Result<(), FileError> {
        let of_name = self.inputs.get(real);
        // A file of one name has two paths where a folder is mounted twice, or capitals do not count. A file system
        // gives the number of a file that is gone to the next one, so the input must still be that file.
        let same = || {
            let own = real.metadata().ok().and_then(|meta| id(&meta))?;
            let is_same = |path: &Path| path.metadata().ok().and_then(|meta| id(&meta)) == Some(own);
            self.inputs.iter().find(|(path, input)| input.id == Some(own) && is_same(path)).map(|(_, input)| input)
        };
        match of_name.or_else(same) {
            None => Ok(()),
            Some(Input { what, .. }) => Err(FileError::new(path, ErrorKind::Naming, format!("this is {what}"))
                .hint("choose another name for the output")),
        }
    }

    fn write_into(&self, folder: &Path, is_output: impl Fn(&str) -> bool) -> Result<(), FileError> {
        // A folder that does not exist yet has no inputs.
        let Ok(folder) = real_path(folder) else { return Ok(()) };
        for (path, Input { what, .. }) in &self.inputs {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.parent() == Some(&folder) && is_output(&name) {
                return Err(FileError::new(path, ErrorKind::Naming, format!("an output may replace {what}"))
                    .hint("choose another folder for the outputs"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("afterimage-run-files-{}-{test}", std::process::id()));
            fs::create_dir_all(path.join("below")).expect("a temporary folder");
            Self(path)
        }

        fn with(&self, name: &str) -> PathBuf {
            fs::write(self.0.join(name), name).expect("a temporary file");
            self.0.join(name)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn refusal(result: Result<(), FileError>) -> String {
        result.expect_err("it is refused").message
    }

    #[test]
    fn an_output_is_no_input_however_it_is_called() {
        let folder = Folder::new("inputs");
        let mut run = RunFiles::default();
        run.read(&folder.with("a.exr"), OPENED);
        run.read(&folder.0.join("a.exr"), "the image");
        run.read(&folder.0.join("a.exr"), OPENED);
        run.read(&folder.0.join("missing.exr"), "nothing");
        for name in ["a.exr", "./a.exr", "below/../a.exr"] {
            assert_eq!(refusal(run.write(&folder.0.join(name))), "this is the image", "{name}");
        }
        run.write(&folder.0.join("b.exr")).expect("it is another file");
        run.write(&folder.0.join("missing.exr")).expect("there is none");
    }

    #[test]
    fn two_outputs_are_not_one_file_even_before_it_exists() {
        let folder = Folder::new("outputs");
        let mut run = RunFiles::default();
        run.write(&folder.0.join("t.png")).expect("it is new");
        for name in ["t.png", "./t.png", "below/../t.png"] {
            assert!(refusal(run.write(&folder.0.join(name))).starts_with("two outputs go to this file"), "{name}");
        }
        run.write(&folder.0.join("below/t.png")).expect("it is another file");
        assert_eq!(refusal(run.write(&folder.0.join("no/t.png"))), "the folder of this output does not exist");
    }

    #[test]
    #[cfg(unix)]
    fn links_lead_to_their_files_also_if_there_is_none() {
        use std::os::unix::fs::symlink;
        let folder = Folder::new("links");
        let mut run = RunFiles::default();
        run.read(&folder.with("a.exr"), "the image");
        symlink("a.exr", folder.0.join("to-a")).expect("a link");
        symlink("../to-a", folder.0.join("below/to-a")).expect("a link");
        assert_eq!(refusal(run.write(&folder.0.join("below/to-a"))), "this is the image");
        symlink("new.png", folder.0.join("to-new")).expect("a link");
        run.write(&folder.0.join("to-new")).expect("it is new");
        assert!(refusal(run.write(&folder.0.join("new.png"))).starts_with("two outputs go to this file"));
        symlink("circle", folder.0.join("circle")).expect("a link");
        assert_eq!(refusal(run.write(&folder.0.join("circle"))), "its links lead in a circle");
        // Another name of the same file is another file to a writer that replaces names.
        fs::hard_link(folder.0.join("a.exr"), folder.0.join("hard.exr")).expect("a link");
        run.write(&folder.0.join("hard.exr")).expect("it is parted");
    }

    #[test]
    fn the_number_of_a_file_that_is_gone_does_not_refuse_the_next_one() {
        let folder = Folder::new("numbers");
        let mut run = RunFiles::default();
        run.read(&folder.with("a.exr"), "the image");
        // A file system would give the number again at some time: here it goes to the other name at once.
        fs::rename(folder.0.join("a.exr"), folder.0.join("b.exr")).expect("a new name");
        run.write(&folder.0.join("b.exr")).expect("the input is gone");
        folder.with("a.exr");
        assert_eq!(refusal(run.write(&folder.0.join("a.exr"))), "this is the image");
    }

    #[test]
    fn a_folder_of_outputs_has_no_inputs_of_such_names() {
        let folder = Folder::new("folders");
        let mut run = RunFiles::default();
        run.read(&folder.with("a.png"), "the image");
        let refused = run.write_into(&folder.0, |name| name.ends_with(".png"));
        assert_eq!(refusal(refused), "an output may replace the image");
        run.write_into(&folder.0, |name| name.ends_with(".svg")).expect("it is of another name");
        run.write_into(&folder.0.join("below"), |_| true).expect("it is empty");
    }
}
