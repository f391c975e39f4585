//! Output files appear whole or not at all.

use std::fs;
use std::path::Path;

use super::Folder;
use crate::*;

fn names(folder: &Folder) -> Vec<String> {
    let entries = fs::read_dir(&folder.0).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_and_nothing_else_is_left() {
    let folder = Folder::new("whole");
    let path = folder.with("out.png", b"old and longer");
    write_atomic(&path, b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names(&folder), ["out.png"]);
}

#[test]
fn a_long_name_leaves_room_for_the_temporary_one() {
    let folder = Folder::new("long");
    let name = "n".repeat(250) + ".png";
    write_atomic(&folder.file(&name), b"x").unwrap();
    assert_eq!(names(&folder), [name]);
}

#[test]
fn places_that_cannot_be_written_are_the_users_or_the_machines() {
    let folder = Folder::new("unwritable");
    let missing = write_atomic(&folder.file("no/such/out.png"), b"x").unwrap_err();
    assert_eq!((missing.kind, missing.exit()), (ErrorKind::Missing, 1));
    assert_eq!(missing.message, "the folder of this output does not exist");
    let into_folder = write_atomic(&folder.0, b"x").unwrap_err();
    assert_eq!(into_folder.message, "the output is a folder");
    let under_file = folder.with("file", b"").join("out.png");
    assert_eq!(write_atomic(&under_file, b"x").unwrap_err().exit(), 1);
    assert_eq!(names(&folder), ["file"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_the_machines_fault() {
    let error = write_atomic(Path::new("/dev/full"), b"x").unwrap_err();
    assert_eq!((error.message.as_str(), error.exit()), ("the disk is full", 2));
    write_atomic(Path::new("/dev/null"), b"x").unwrap();
    let is_device = !fs::metadata("/dev/null").unwrap().is_file();
    assert!(is_device, "a device is written to, not replaced");
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let folder = Folder::new("link");
    let file = folder.with("file", b"old");
    std::os::unix::fs::symlink(&file, folder.file("link")).unwrap();
    write_atomic(&folder.file("link"), b"new").unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert!(folder.file("link").is_symlink());
}
