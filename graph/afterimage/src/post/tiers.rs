//! The files of a pipeline: tiers by name, and reloads.

use afterimage_gpu::{Executor, Gpu};
use afterimage_graph::document::Claim;

use super::Post;
use super::opened::Opened;
use crate::error::Error;
use crate::files::Stamps;
use crate::snapshot::{Snapshot, files_of};
use crate::source::Source;

impl Post {
    /// Opens a pipeline: a file, the name of a built-in pipeline, or another [`Source`]. Reads and checks the files on
    /// this thread, about a millisecond without large tables. The plan is made by [`prepare`](Self::prepare), or for
    /// the first frame.
    ///
    /// # Errors
    /// There is no such pipeline, or it or what it names is wrong; the text has all errors with their excerpts.
    pub fn open(gpu: &Gpu, source: impl Into<Source>) -> Result<Self, Error> {
        let source = source.into();
        let files = files_of(&source);
        let snapshot = Snapshot::read(&source, files.clone())?;
        let executor = gpu.host_executor();
        let executor = match &source.pipeline_cache {
            Some(data) => executor.with_pipeline_cache(data),
            None => executor,
        };
        let mut post = Self::of_snapshot(executor, snapshot, source.tier.as_deref())?;
        if let Some(opened) = &mut post.opened {
            (opened.stamps, opened.source) = (files.stamps(), Some(source));
        }
        Ok(post)
    }

    /// A pipeline whose files the host has loaded, at a tier: it never reads them by itself. The executor may be a
    /// [view](Executor::clone_for_view) of another pipeline's, which then share what is compiled.
    ///
    /// # Errors
    /// The pipeline or what it names is wrong, or has no such tier.
    pub fn of_snapshot(executor: Executor, snapshot: Snapshot, tier: Option<&str>) -> Result<Self, Error> {
        let mut post = Self::with_executor(executor, snapshot.graph(tier)?);
        let tier = tier.map(str::to_owned);
        post.opened = Some(Opened { source: None, tier, snapshot, stamps: Stamps::default() });
        Ok(post)
    }

    /// The files for another view, which reads them for itself.
    pub(super) fn opened_for_view(&self) -> Option<Opened> {
        let Opened { source, snapshot, stamps, .. } = self.opened.as_ref()?;
        let tier = self.tier().map(str::to_owned);
        Some(Opened { source: source.clone(), tier, snapshot: snapshot.clone(), stamps: stamps.clone() })
    }

    pub(super) fn files(&self) -> Result<&Opened, Error> {
        let none = || Error::Name("the pipeline was made of a graph, which has no tiers".to_owned());
        self.opened.as_ref().ok_or_else(none)
    }

    /// The pipeline with its files, as read last without an error; `None` if the host has given a graph.
    pub fn snapshot(&self) -> Option<&Snapshot> {
        self.opened.as_ref().map(|opened| &opened.snapshot)
    }

    /// The names of the pipeline's tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        self.snapshot().map(Snapshot::tiers).unwrap_or_default()
    }

    /// The pipeline's claim of a tier: [`Snapshot::claim`].
    pub fn claim(&self, tier: &str) -> Option<&Claim> {
        self.snapshot()?.claim(tier)
    }

    /// The present tier; `None` for the values that the file has without one. Under a [budget](Self::govern), it is the
    /// one that the governor has chosen.
    pub fn tier(&self) -> Option<&str> {
        match &self.governed {
            Some(governed) => Some(governed.governor.name()),
            None => self.opened.as_ref()?.tier.as_deref(),
        }
    }

    /// Changes to a tier, in the background: `set_tier("low")`, or `set_tier(None)` for the values that the file has
    /// without one. Checks the pipeline on this thread, less than a millisecond. A [budget](Self::govern) ends.
    ///
    /// # Errors
    /// There is no such tier: the text lists those that there are. The present tier stays.
    pub fn set_tier<'t>(&mut self, tier: impl Into<Option<&'t str>>) -> Result<(), Error> {
        self.replace(self.files()?.snapshot.clone(), tier.into())
    }

    /// Changes to another pipeline that the host has loaded, at a tier, as by [`set_tier`](Self::set_tier). Values of
    /// parameters that both have stay.
    ///
    /// # Errors
    /// As for [`of_snapshot`](Self::of_snapshot). The present pipeline stays.
    pub fn replace(&mut self, snapshot: Snapshot, tier: Option<&str>) -> Result<(), Error> {
        let graph = snapshot.graph(tier)?;
        self.governed = None;
        let (source, stamps) = self.opened.take().map_or_else(Default::default, |old| (old.source, old.stamps));
        self.opened = Some(Opened { source, tier: tier.map(str::to_owned), snapshot, stamps });
        self.change(graph);
        Ok(())
    }

    /// Reads the pipeline again if one of its files has changed: the pipeline itself, the files that it names, node
    /// kinds in folders. Returns whether anything was taken.
    ///
    /// It asks the system for the time of change and the length of each file, about two microseconds each, and starts
    /// no thread: call it as often as edits shall be seen, such as twice in a second. After a change it reads and
    /// checks the pipeline on this thread, as [`open`](Self::open) does; the plan is made in the background. Built-in
    /// pipelines and texts without files do not change.
    ///
    /// # Errors
    /// A changed file is wrong: the old pipeline renders on. The error is returned once, until the next change.
    pub fn reload_if_changed(&mut self) -> Result<bool, Error> {
        let Some(opened) = &self.opened else { return Ok(false) };
        let (Some(mut stamps), Some(source)) = (opened.stamps.changed(), &opened.source) else { return Ok(false) };
        let files = files_of(source);
        let read = Snapshot::read(source, files.clone());
        let taken = read.and_then(|snapshot| self.reload(snapshot));
        // While a file is wrong, those that it named before may be the ones to be corrected.
        if taken.is_err() {
            stamps.extend(files.stamps());
        } else {
            stamps = files.stamps();
        }
        if let Some(opened) = &mut self.opened {
            opened.stamps = stamps;
        }
        taken.map(|()| true)
    }

    /// Takes files that the host has loaded again: the tier or the budget stays.
    ///
    /// # Errors
    /// The pipeline is wrong, or has no such tier. The present pipeline stays.
    pub fn reload(&mut self, snapshot: Snapshot) -> Result<(), Error> {
        let graph = match &mut self.governed {
            Some(governed) => {
                governed.reload(&snapshot, self.frame)?;
                governed.present_graph()
            }
            None => snapshot.graph(self.tier())?,
        };
        self.change(graph);
        if let Some(opened) = &mut self.opened {
            opened.snapshot = snapshot;
        }
        Ok(())
    }
}
