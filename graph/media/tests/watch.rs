//! Changes of files are seen.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::Duration;

use super::Folder;
use afterimage_media::{FileWatch, write_atomic};

fn only(path: &Path) -> BTreeSet<PathBuf> {
    BTreeSet::from([path.to_owned()])
}

#[test]
fn a_file_that_is_written_replaced_removed_or_made_has_changed() {
    let folder = Folder::new("watch-file");
    let (file, beside) = (folder.file("look.ron"), folder.file("beside.txt"));
    let mut watch = FileWatch::new(|| {});
    watch.extend([file.clone()]);
    assert!(watch.look().is_empty());
    std::fs::write(&file, "one").unwrap();
    assert_eq!(watch.wait(), only(&file));
    write_atomic(&file, b"another").unwrap();
    assert_eq!(watch.wait(), only(&file));
    std::fs::write(&beside, "not watched").unwrap();
    std::fs::remove_file(&file).unwrap();
    assert_eq!(watch.wait(), only(&file));
    assert!(watch.look().is_empty());
}

#[test]
fn folders_of_kinds_are_watched_for_their_texts_alone() {
    let folder = Folder::new("watch-kinds");
    std::fs::create_dir_all(folder.file("gray")).unwrap();
    let shader = folder.file("gray/gray.wgsl");
    let mut watch = FileWatch::new(|| {});
    watch.extend([folder.0.clone()]);
    std::fs::write(folder.file("gray/notes.txt"), "no text of a kind").unwrap();
    assert!(watch.look().is_empty());
    std::fs::write(&shader, "fn gray() {}").unwrap();
    assert_eq!(watch.wait(), only(&shader));
}

#[cfg(target_os = "linux")]
#[test]
fn the_system_reports_a_whole_file_once_also_behind_a_link() {
    use std::io::Write as _;

    let (folder, elsewhere) = (Folder::new("watch-link"), Folder::new("watch-target"));
    let (target, link) = (elsewhere.file("target.ron"), folder.file("link.ron"));
    std::fs::write(&target, "one").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let (report, reports) = channel();
    let mut watch = FileWatch::new(move || report.send(()).unwrap_or_default());
    watch.extend([link.clone()]);
    let mut file = std::fs::File::create(&target).unwrap();
    file.write_all(b"half of").unwrap();
    assert!(reports.recv_timeout(Duration::from_millis(200)).is_err(), "the file is not closed");
    file.write_all(b" another").unwrap();
    drop(file);
    reports.recv_timeout(Duration::from_secs(20)).unwrap();
    assert!(watch.changed().contains(&link));
    assert!(watch.changed().is_empty());
}
