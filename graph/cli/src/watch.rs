//! `render --watch`: the picture again, each time that a file changes which it is made from.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::terminal::note;

/// How often files are looked at: soon enough for an eye, and too seldom for a load.
const LOOK: Duration = Duration::from_millis(100);
/// How deep folders are looked into: `looks/dusk.cube` beside a pipeline, `kind/kind.wgsl` in a folder of kinds.
const DEPTH: u32 = 2;

/// Renders, and renders again after each change; mistakes are told and waited for. Never returns.
pub(crate) fn watch(args: &RenderArgs, mut render: impl FnMut() -> Result<(), Failure>) -> ! {
    let places = places(args);
    loop {
        let before = stamps(&places);
        match render() {
            Ok(()) => note(&format!("wrote `{}`; waiting for changes, Ctrl-C ends it", args.out)),
            Err(failure) => {
                failure.report();
            }
        }
        // A change during the rendering counts: it may have come too late for it.
        while stamps(&places) == before {
            std::thread::sleep(LOOK);
        }
    }
}

/// What a picture is made from: the pipeline's folder with its looks and subgraphs, folders of kinds, and the images.
fn places(args: &RenderArgs) -> Vec<PathBuf> {
    let folder = match args.pipeline.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let named = args.inputs.iter().filter_map(|input| input.split_once('=')).map(|(_, file)| file);
    let images = args.input.as_deref().into_iter().chain(named).map(|file| file.split('#').next().unwrap_or(file));
    let folders = std::iter::once(folder.to_owned()).chain(args.options.nodes.iter().cloned());
    folders.chain(images.map(PathBuf::from)).collect()
}

/// A file, when it was changed, and its bytes.
type Stamp = (PathBuf, Option<SystemTime>, u64);

fn stamps(places: &[PathBuf]) -> Vec<Stamp> {
    let mut found = Vec::new();
    places.iter().for_each(|place| look(place, DEPTH, &mut found));
    found.sort();
    found
}

/// Only files that pictures are made from: the picture itself may lie beside them.
fn look(place: &Path, depth: u32, found: &mut Vec<Stamp>) {
    let Ok(meta) = std::fs::metadata(place) else { return };
    if meta.is_file() {
        let is_of_a_pipeline =
            ["ron", "wgsl", "cube"].into_iter().any(|ending| place.extension() == Some(ending.as_ref()));
        if is_of_a_pipeline || depth == DEPTH {
            found.push((place.to_owned(), meta.modified().ok(), meta.len()));
        }
    } else if depth > 0 {
        let entries = std::fs::read_dir(place).into_iter().flatten().flatten();
        entries.for_each(|entry| look(&entry.path(), depth - 1, found));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn what_a_picture_is_made_from_is_seen_to_change_and_the_picture_is_not() {
        let folder = std::env::temp_dir().join(format!("afterimage-watch-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("looks")).unwrap();
        std::fs::write(folder.join("a.ron"), "one").unwrap();
        let places = vec![folder.clone()];
        let first = stamps(&places);
        assert_eq!(first.len(), 1);
        std::fs::write(folder.join("out.png"), "a picture").unwrap();
        assert_eq!(stamps(&places), first);
        std::fs::write(folder.join("looks/dusk.cube"), "a look").unwrap();
        let second = stamps(&places);
        assert_eq!(second.len(), 2);
        std::fs::write(folder.join("a.ron"), "another").unwrap();
        assert_ne!(stamps(&places), second);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
