//! Output files appear whole or not at all.

use std::fs;
use std::path::Path;

use super::Folder;
use afterimage_media::*;

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

#[cfg(unix)]
#[test]
fn a_link_to_no_file_stays_a_link() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("dangling");
    symlink("file", folder.file("link")).unwrap();
    symlink(folder.file("link"), folder.file("to-link")).unwrap();
    write_atomic(&folder.file("to-link"), b"new").unwrap();
    assert_eq!(fs::read(folder.file("file")).unwrap(), b"new");
    assert!(folder.file("link").is_symlink() && folder.file("to-link").is_symlink());
    symlink("nowhere/file", folder.file("lost")).unwrap();
    let error = write_atomic(&folder.file("lost"), b"new").unwrap_err();
    assert_eq!(error.message, "the folder of this output does not exist");
    symlink("circle", folder.file("circle")).unwrap();
    let error = write_atomic(&folder.file("circle"), b"new").unwrap_err();
    assert_eq!((error.message.as_str(), error.exit()), ("its links lead in a circle", 1));
    assert!(folder.file("lost").is_symlink() && folder.file("circle").is_symlink());
}

#[cfg(unix)]
#[test]
fn a_replaced_file_keeps_its_mode_and_its_owner() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, chown};
    let folder = Folder::new("rights");
    for mode in [0o600, 0o640, 0o444, 0o777] {
        let path = folder.with("file", b"old");
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        // Only root may give files away; others keep their own.
        let _ = chown(&path, Some(4321), Some(1234));
        let rights = |path: &Path| {
            let meta = fs::metadata(path).unwrap();
            (meta.mode() & 0o7777, meta.uid(), meta.gid())
        };
        let before = rights(&path);
        assert_eq!(before.0, mode);
        write_atomic(&path, b"new").unwrap();
        assert_eq!((fs::read(&path).unwrap().as_slice(), rights(&path)), (b"new".as_slice(), before), "{mode:o}");
        fs::remove_file(&path).unwrap();
    }
    // A new file has the mode that the system gives to new files.
    let usual = rights_of_a_new_file(&folder);
    write_atomic(&folder.file("new"), b"new").unwrap();
    assert_eq!(fs::metadata(folder.file("new")).unwrap().mode(), usual);
}

#[cfg(unix)]
fn rights_of_a_new_file(folder: &Folder) -> u32 {
    use std::os::unix::fs::MetadataExt as _;
    fs::metadata(folder.with("usual", b"")).unwrap().mode()
}

#[test]
fn what_killed_runs_have_left_is_removed_and_nothing_else() {
    let folder = Folder::new("leftovers");
    let of_a_killed_run = ".out.png.4242-7.afterimage.part";
    let in_work = ".other.png.4243-0.afterimage.part";
    let kept = [in_work, "mine.afterimage.part", ".out.png.4242-7.part"];
    for name in kept.into_iter().chain([of_a_killed_run]) {
        folder.with(name, b"half");
    }
    let lock = fs::File::open(folder.file(in_work)).unwrap();
    lock.try_lock().unwrap();
    write_atomic(&folder.file("out.png"), b"x").unwrap();
    let mut left: Vec<&str> = kept.into_iter().chain(["out.png"]).collect();
    left.sort();
    assert_eq!(names(&folder), left);
}

#[test]
fn writers_of_one_folder_do_not_remove_each_other_s_files() {
    let folder = Folder::new("writers");
    std::thread::scope(|scope| {
        for writer in 0..8 {
            let path = folder.file(&format!("{writer}.png"));
            scope.spawn(move || (0..50).for_each(|_| write_atomic(&path, &[writer; 1000]).unwrap()));
        }
    });
    assert_eq!(names(&folder), (0..8).map(|writer| format!("{writer}.png")).collect::<Vec<_>>());
}
