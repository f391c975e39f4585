//! Changes of files: the operating system reports them where it can, and polling finds the others.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant, SystemTime};

use notify::event::{AccessKind, AccessMode, ModifyKind};
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher as _};

use super::real_path;

/// The polling interval where the system reports changes: it does not report those that another computer makes in a
/// shared folder.
const INTERVAL: Duration = Duration::from_millis(100);
/// The polling interval where it reports none: not noticeable as a delay or as load.
const SHORT_INTERVAL: Duration = Duration::from_millis(20);
/// One of how many parts of the time polling takes at most, however many files there are.
const PART: u32 = 50;
/// The depth of watched folders: `kinds/posterize/posterize.wgsl`.
const DEPTH: u32 = 2;

/// Watches files, and folders of node kinds: of a folder the `.ron` and `.wgsl` files, and those of folders in it.
///
/// A file that does not exist is watched, too: that it appears is a change.
pub struct FileWatch {
    places: BTreeSet<PathBuf>,
    seen: Vec<Stamp>,
    looked: Instant,
    pause: Duration,
    watcher: Option<RecommendedWatcher>,
    /// The folders in which the system reports changes.
    folders: BTreeSet<PathBuf>,
    reports: Receiver<()>,
}

/// A file, the time of its last change, and its length.
type Stamp = (PathBuf, Option<SystemTime>, u64);

impl FileWatch {
    /// An empty watch. `wake` is called on another thread when the system reports a change of what is watched, or
    /// of a file next to it.
    pub fn new(wake: impl Fn() + Send + 'static) -> Self {
        let (report, reports) = channel();
        let handler = move |event: notify::Result<Event>| {
            // The other end is gone with the watch.
            if event.is_ok_and(|event| is_whole(event.kind)) && report.send(()).is_ok() {
                wake();
            }
        };
        Self {
            places: BTreeSet::new(),
            seen: Vec::new(),
            looked: Instant::now(),
            pause: Duration::ZERO,
            watcher: notify::recommended_watcher(handler).ok(),
            folders: BTreeSet::new(),
            reports,
        }
    }

    /// The files that have changed, appeared or gone since the last call. Call it before reading them: changes during
    /// reading are then found by the next call.
    pub fn look(&mut self) -> BTreeSet<PathBuf> {
        let begin = Instant::now();
        let now = self.stamps();
        let interval = if self.watcher.is_some() { INTERVAL } else { SHORT_INTERVAL };
        (self.looked, self.pause) = (Instant::now(), interval.max(begin.elapsed() * PART));
        let changed = differing(&self.seen, &now);
        self.seen = now;
        changed
    }

    /// Watches these files and folders as well.
    pub fn extend(&mut self, places: impl IntoIterator<Item = PathBuf>) {
        for place in places {
            if self.places.contains(&place) {
                continue;
            }
            look_at(&place, DEPTH, &mut self.seen);
            self.watch_folders(&place);
            self.places.insert(place);
        }
        self.seen.sort();
    }

    /// As [`look`](Self::look), cheap enough for every frame: it polls after a report of the system, and at intervals.
    pub fn changed(&mut self) -> BTreeSet<PathBuf> {
        let is_reported = self.reports.try_iter().count() > 0;
        if is_reported || self.looked.elapsed() >= self.pause { self.look() } else { BTreeSet::new() }
    }

    /// Waits until files have changed, and returns them.
    pub fn wait(&mut self) -> BTreeSet<PathBuf> {
        loop {
            let changed = self.changed();
            if !changed.is_empty() {
                return changed;
            }
            // A report ends the wait, so it must make the next look happen, too.
            if self.reports.recv_timeout(self.pause).is_ok() {
                self.pause = Duration::ZERO;
            }
        }
    }

    fn stamps(&self) -> Vec<Stamp> {
        let mut found = Vec::new();
        self.places.iter().for_each(|place| look_at(place, DEPTH, &mut found));
        found.sort();
        found
    }

    /// Asks the system for reports about the folders of a file, of the target of a link, or of a folder of kinds.
    fn watch_folders(&mut self, place: &Path) {
        let mut folders = vec![folder_of(place).to_owned()];
        folders.extend(real_path(place).ok().and_then(|real| Some(real.parent()?.to_owned())));
        if place.is_dir() {
            let within = std::fs::read_dir(place).into_iter().flatten().flatten().map(|entry| entry.path());
            folders.extend(std::iter::once(place.to_owned()).chain(within.filter(|path| path.is_dir())));
        }
        for folder in folders {
            let Some(watcher) = &mut self.watcher else { return };
            // A folder that cannot be watched is looked at.
            if !self.folders.contains(&folder) && watcher.watch(&folder, RecursiveMode::NonRecursive).is_ok() {
                self.folders.insert(folder);
            }
        }
    }
}

/// The folder of a file. That of a bare name is the current one.
fn folder_of(place: &Path) -> &Path {
    place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// True if a change is complete. Where the system reports that a writer has closed a file, earlier events may be about
/// a partial file.
fn is_whole(kind: EventKind) -> bool {
    match kind {
        EventKind::Access(access) => access == AccessKind::Close(AccessMode::Write),
        EventKind::Modify(ModifyKind::Name(_)) | EventKind::Remove(_) => true,
        _ => cfg!(not(target_os = "linux")),
    }
}

/// A file itself; of a folder only the files of kinds, because the output may be in it.
fn look_at(place: &Path, depth: u32, found: &mut Vec<Stamp>) {
    let Ok(meta) = std::fs::metadata(place) else { return };
    if meta.is_file() {
        let is_of_a_kind = ["ron", "wgsl"].into_iter().any(|ending| place.extension() == Some(ending.as_ref()));
        if is_of_a_kind || depth == DEPTH {
            found.push((place.to_owned(), meta.modified().ok(), meta.len()));
        }
    } else if depth > 0 {
        let entries = std::fs::read_dir(place).into_iter().flatten().flatten();
        entries.for_each(|entry| look_at(&entry.path(), depth - 1, found));
    }
}

/// The files whose stamps are in one list alone.
fn differing(before: &[Stamp], now: &[Stamp]) -> BTreeSet<PathBuf> {
    let (before, now): (BTreeSet<&Stamp>, BTreeSet<&Stamp>) = (before.iter().collect(), now.iter().collect());
    before.symmetric_difference(&now).map(|stamp| stamp.0.clone()).collect()
}
