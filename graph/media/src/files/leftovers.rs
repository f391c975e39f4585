//! Unfinished files of runs that were killed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::files::regular::open_unlisted;

/// The end of the names of unfinished files.
pub(super) const ENDING: &str = ".afterimage.part";

/// Removes unfinished files from the folder of an output, once a run. A run that still writes one holds its lock.
pub(super) fn remove_leftovers(output: &Path) {
    static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_new = SEEN.lock().is_ok_and(|mut seen| seen.insert(folder.to_owned()));
    if is_new {
        // A folder that cannot be listed can still be written to.
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.filter(|entry| is_unfinished(&entry.file_name().to_string_lossy())).for_each(|entry| {
            remove_unlocked(&entry.path());
        });
    }
}

fn is_unfinished(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(ENDING)
}

fn remove_unlocked(path: &Path) {
    let Ok((file, _)) = open_unlisted(path) else { return };
    if file.try_lock().is_ok() {
        // One that cannot be removed takes space, and is tried again by the next run.
        let _ = fs::remove_file(path);
    }
}
