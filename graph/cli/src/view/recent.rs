//! The pipelines that were opened last, listed in a file of the cache.

use std::path::{Path, PathBuf};

use afterimage_media::{read_text, rewrite};
use afterimage_view::RecentFiles;

use crate::device::cache_folder;

/// The number of pipelines that are listed.
const COUNT: usize = 5;
/// The most bytes that a list may have.
const MAX_BYTES: u64 = 1 << 16;

/// The list of the user.
pub(super) fn recent_files() -> RecentFiles {
    match cache_folder() {
        Some(folder) => listed_in(folder.join("recent")),
        None => Box::new(|_| Vec::new()),
    }
}

/// A list in a file, with a path on each line. Several windows share it, so it is read each time.
fn listed_in(list: PathBuf) -> RecentFiles {
    Box::new(move |opened: Option<&Path>| {
        let text = read_text(&list, MAX_BYTES).unwrap_or_default();
        let listed = text.lines().map(PathBuf::from);
        let opened = opened.and_then(|path| std::path::absolute(path).ok());
        // A path that is no line of text is not listed.
        let opened = opened.filter(|path| path.to_str().is_some_and(|path| !path.contains(['\n', '\r'])));
        let is_new = opened.is_some();
        let mut recent: Vec<PathBuf> = opened.clone().into_iter().collect();
        recent.extend(listed.filter(|path| opened.as_ref() != Some(path)));
        recent.truncate(COUNT);
        if is_new {
            let lines: String = recent.iter().map(|path| format!("{}\n", path.display())).collect();
            // A list that cannot be stored is missed by nobody else.
            let _ = list.parent().map(std::fs::create_dir_all);
            let _ = rewrite(&list, lines.as_bytes());
        }
        recent.retain(|path| path.is_file());
        recent
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn the_newest_pipeline_is_first_and_files_that_are_gone_are_not_shown() {
        let folder = std::env::temp_dir().join(format!("afterimage-recent-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let paths: Vec<PathBuf> = (0..12).map(|number| folder.join(format!("{number}.ron"))).collect();
        paths.iter().for_each(|path| std::fs::write(path, "a pipeline").unwrap());
        let mut one = listed_in(folder.join("cache/recent"));
        assert_eq!(one(None), Vec::<PathBuf>::new());
        for path in &paths {
            assert_eq!(one(Some(path))[0], *path);
        }
        // Another window.
        let mut other = listed_in(folder.join("cache/recent"));
        let newest: Vec<PathBuf> = paths.iter().rev().take(COUNT).cloned().collect();
        assert_eq!(other(None), newest);
        other(Some(&paths[5]));
        assert_eq!((one(None)[0].clone(), one(None).len()), (paths[5].clone(), COUNT));
        std::fs::remove_file(&paths[5]).unwrap();
        assert_eq!((one(None)[0].clone(), one(None).len()), (paths[11].clone(), COUNT - 1));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
