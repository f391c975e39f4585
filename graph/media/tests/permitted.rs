//! Files that may be read by where they are.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Folder;
use afterimage_media::*;

/// Reads a name while `swap` changes, thousands of times, what it leads to. What is read is never a file outside.
fn swapped(folder: &Path, name: &Path, swap: impl Fn() + Sync) {
    const SWAPS: usize = 2000;
    let inside = fs::canonicalize(folder.join("inside")).unwrap();
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            (0..SWAPS).for_each(|_| swap());
            is_over.store(true, Ordering::Relaxed);
        });
        while !is_over.load(Ordering::Relaxed) {
            let read = read_permitted(name, 1 << 10, &|real| match real.starts_with(&inside) {
                true => Ok(()),
                false => Err("outside".to_owned()),
            });
            if let Ok(bytes) = read {
                assert_eq!(bytes, b"inside");
            }
        }
    });
    assert_eq!(read_permitted(name, 1 << 10, &|_| Ok(())).unwrap(), b"inside");
}

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    fs::create_dir_all(folder.file("inside/real")).unwrap();
    fs::create_dir_all(folder.file("outside")).unwrap();
    fs::write(folder.file("inside/real/file"), "inside").unwrap();
    fs::write(folder.file("outside/file"), "outside").unwrap();
    folder
}

#[test]
fn a_link_that_changes_while_it_is_read_leads_to_no_file_outside() {
    let folder = folder("swapped-link");
    let link = folder.file("inside/link");
    symlink("real/file", &link).unwrap();
    swapped(&folder.0, &link, || {
        for target in ["../outside/file", "real/file"] {
            symlink(target, folder.file("inside/next")).unwrap();
            fs::rename(folder.file("inside/next"), &link).unwrap();
        }
    });
}

#[test]
fn a_folder_that_becomes_a_link_while_it_is_read_leads_to_no_file_outside() {
    let folder = folder("swapped-folder");
    let [real, aside, link] = ["inside/real", "inside/aside", "inside/link"].map(|name| folder.file(name));
    symlink("../outside", &link).unwrap();
    swapped(&folder.0, &real.join("file"), || {
        fs::rename(&real, &aside).unwrap();
        fs::rename(&link, &real).unwrap();
        fs::rename(&real, &link).unwrap();
        fs::rename(&aside, &real).unwrap();
    });
}
