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
fn a_device_is_written_to_and_may_refuse() {
    let error = write_atomic(Path::new("/dev/full"), b"x").unwrap_err();
    assert!(error.message.starts_with("this device or pipe takes no more: No space left"), "{error}");
    assert_eq!(error.exit(), 2);
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
    for mode in [0o600, 0o640, 0o644, 0o777] {
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
#[test]
fn a_read_only_file_is_not_replaced_also_by_root_and_by_its_owner() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = Folder::new("read-only");
    let path = folder.with("file", b"old");
    std::os::unix::fs::symlink("file", folder.file("link")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
    for name in ["file", "link"] {
        for written in [write_atomic(&folder.file(name), b"new"), rewrite(&folder.file(name), b"new")] {
            let error = written.unwrap_err();
            assert_eq!((error.message.as_str(), error.exit()), ("this file is read-only, and it is not replaced", 1));
        }
    }
    assert_eq!((fs::read(&path).unwrap().as_slice(), names(&folder).len()), (b"old".as_slice(), 2));
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_of_the_kernel_takes_no_files() {
    for name in ["/proc/x.png", "/proc/self/x.png", "/proc/version"] {
        let error = write_atomic(Path::new(name), b"x").unwrap_err();
        let words = ["no file can be made in this folder", "this file is read-only, and it is not replaced"];
        assert!(words.contains(&error.message.as_str()), "{error}");
    }
}

#[test]
fn new_files_are_made_all_or_none_and_replace_nothing() {
    let folder = Folder::new("new-files");
    let files = |names: &[&str]| -> Vec<(std::path::PathBuf, Vec<u8>)> {
        names.iter().map(|name| ((*name).into(), name.as_bytes().to_vec())).collect()
    };
    assert_eq!(write_new(&folder.0, &files(&["a", "b/c/d"])).unwrap(), [true, true]);
    // What is there is as good as written.
    assert_eq!(write_new(&folder.0, &files(&["a", "e"])).unwrap(), [false, true]);
    folder.with("edited", b"mine");
    for taken in ["edited", "b"] {
        let error = write_new(&folder.0, &files(&["f", "g/h", taken])).unwrap_err();
        assert_eq!(error.message, "this file exists, and is not replaced by a new one", "{taken}");
    }
    // A file stands where a folder has to be: that is seen when the first file is made already.
    assert!(write_new(&folder.0, &files(&["g/h", "a/i"])).is_err());
    assert_eq!(names(&folder), ["a", "b", "e", "edited"]);
    assert_eq!(fs::read(folder.file("edited")).unwrap(), b"mine");
}

#[cfg(unix)]
#[test]
fn new_files_are_not_written_through_links() {
    let folder = Folder::new("new-links");
    fs::create_dir(folder.file("elsewhere")).unwrap();
    std::os::unix::fs::symlink("elsewhere", folder.file("looks")).unwrap();
    std::os::unix::fs::symlink("nothing", folder.file("dangling")).unwrap();
    for name in ["looks/a.png", "dangling"] {
        write_new(&folder.0, &[("first".into(), Vec::new()), (name.into(), Vec::new())]).unwrap_err();
    }
    assert_eq!(names(&folder), ["dangling", "elsewhere", "looks"]);
    assert_eq!(fs::read_dir(folder.file("elsewhere")).unwrap().count(), 0);
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
