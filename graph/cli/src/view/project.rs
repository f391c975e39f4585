//! A pipeline in a file, with the files that it names.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use afterimage_graph::check::{Change, Loader as _};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::node::NodeKind;
use afterimage_media::write_atomic;
use afterimage_view::{Checked, Project, saved};

use crate::args::KindOptions;
use crate::failure::Failure;
use crate::files::{Files, registry, text};
use crate::watch::{RecordingLoader, Stamp, stamps};

/// Between two looks at the files: not noticeable as a delay or as load.
const INTERVAL: Duration = Duration::from_millis(20);

/// A pipeline in a file.
pub(super) struct FileProject {
    path: PathBuf,
    options: KindOptions,
    kinds: Vec<NodeKind>,
    edited: Option<String>,
    /// The text of the last check.
    known: String,
    /// What was read, and how it looked.
    places: BTreeSet<PathBuf>,
    before: Vec<Stamp>,
    looked: Instant,
}

impl FileProject {
    pub(super) fn new(path: PathBuf, options: KindOptions, kinds: Vec<NodeKind>) -> Self {
        let (places, before) = (BTreeSet::new(), Vec::new());
        Self { path, options, kinds, edited: None, known: String::new(), places, before, looked: Instant::now() }
    }

    fn read(&mut self) -> Result<(), Failure> {
        self.known = match &self.edited {
            Some(text) => text.clone(),
            None => text(&self.path, "pipeline")?,
        };
        Ok(())
    }

    fn checked(&mut self, tier: Option<&str>) -> Result<Checked, Failure> {
        self.read()?;
        let registry = registry(&[&self.kinds], &self.options)?;
        let loader = RecordingLoader::new(Files::of(&self.path, &self.options));
        let checked = Checked::of((&self.path.to_string_lossy(), &self.known), tier, &registry, &loader);
        // While the file has errors, the files that it named before may be the ones to be corrected.
        self.places.extend(loader.named());
        Ok(checked?)
    }
}

impl Project for FileProject {
    fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    fn text(&self) -> String {
        self.known.clone()
    }

    fn check(&mut self, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        self.places.insert(self.path.clone());
        self.places.extend(self.options.nodes.iter().cloned());
        let checked = self.checked(tier).map_err(Failure::into_diagnostics);
        self.before = stamps(&self.places);
        checked
    }

    fn has_changed(&mut self) -> bool {
        if self.looked.elapsed() < INTERVAL {
            return false;
        }
        self.looked = Instant::now();
        let now = stamps(&self.places);
        let has_changed = now != self.before;
        if has_changed {
            // What is on the disk now is newer than what was typed here.
            let own = |stamps: &[Stamp]| stamps.iter().find(|stamp| stamp.0 == self.path).cloned();
            if own(&now) != own(&self.before) {
                self.edited = None;
            }
        }
        has_changed
    }

    fn edit(&mut self, text: Option<String>) {
        self.edited = text;
    }

    fn saved(&self, tier: Option<&str>, new_tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        let registry = registry(&[&self.kinds], &self.options).map_err(Failure::into_diagnostics)?;
        let files = Files::of(&self.path, &self.options);
        saved((&self.path.to_string_lossy(), &self.known), (tier, new_tier), changes, &registry, &files)
    }

    fn file(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        Files::of(&self.path, &self.options).load(&folder.join(path).to_string_lossy())
    }

    fn write(&mut self, text: &str) -> Result<(), String> {
        write_atomic(&self.path, text.as_bytes()).map_err(|error| error.to_string())?;
        self.edited = None;
        Ok(())
    }
}
