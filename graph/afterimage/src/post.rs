//! A pipeline of a file on the host's device.

use std::ops::{Deref, DerefMut};

use afterimage_gpu::{GovernedTier, Gpu, Post as GraphPost, TierGraph};

use crate::error::Error;
use crate::files::Stamps;
use crate::snapshot::{Snapshot, files_of};
use crate::source::Source;

/// A pipeline on the host's device: parameters, facts, tiers, and the commands of a frame.
///
/// Here is what follows from its files. All else is of the [`GraphPost`] in it, whose methods are listed below:
/// [`parameter`](GraphPost::parameter), [`set`](GraphPost::set), [`set_fact`](GraphPost::set_fact),
/// [`encode`](GraphPost::encode) and more. A graph of [`change`](GraphPost::change) holds until the next tier or
/// reload.
///
/// A change of tier, of a file or of a fact needs another plan, which is made and compiled in the background while the
/// old one renders. Handles of parameters and the values that the host has set stay valid.
pub struct Post {
    post: GraphPost,
    source: Source,
    /// What was read last without an error.
    snapshot: Snapshot,
    /// What was read, also last with an error.
    stamps: Stamps,
    /// The tiers of the governor, if that chooses.
    governed: Vec<String>,
}

impl Post {
    /// Opens a pipeline: a file, the name of a built-in pipeline, or another [`Source`]. Reads and checks the files on
    /// this thread, about a millisecond without large tables; the plan is made for the first frame.
    ///
    /// # Errors
    /// There is no such pipeline, or it or what it names is wrong; the text has all errors with their excerpts.
    pub fn open(gpu: &Gpu, source: impl Into<Source>) -> Result<Self, Error> {
        let source = source.into();
        let files = files_of(&source);
        let snapshot = Snapshot::read(&source, files.clone())?;
        let graph = snapshot.graph(source.tier.as_deref())?;
        let post = GraphPost::new(&gpu.adapter, &gpu.device, &gpu.queue, graph);
        Ok(Self { post, source, snapshot, stamps: files.stamps(), governed: Vec::new() })
    }

    /// The same pipeline for another view, as [`GraphPost::clone_for_view`] makes it. It reads files for itself.
    pub fn clone_for_view(&self) -> Self {
        Self {
            post: self.post.clone_for_view(),
            source: self.source.clone(),
            snapshot: self.snapshot.clone(),
            stamps: self.stamps.clone(),
            governed: Vec::new(),
        }
    }

    /// Continues on another device, after the first was lost, with all values, facts and handles. Histories begin anew,
    /// and the next frame waits for its plan.
    pub fn rebuild(&mut self, gpu: &Gpu) {
        self.post.rebuild(&gpu.adapter, &gpu.device, &gpu.queue);
    }

    /// The names of the pipeline's tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        self.snapshot.tiers()
    }

    /// The present tier; `None` for the values that the file has without one. Under a [budget](Self::govern), it is the
    /// one that the governor has chosen.
    pub fn tier(&self) -> Option<&str> {
        match self.post.governor() {
            Some(governor) => self.governed.get(governor.tier()).map(String::as_str),
            None => self.source.tier.as_deref(),
        }
    }

    /// Changes to a tier, in the background: `set_tier("low")`, or `set_tier(None)` for the values that the file has
    /// without one. Checks the pipeline on this thread, less than a millisecond. A [budget](Self::govern) ends.
    ///
    /// # Errors
    /// There is no such tier: the text lists those that there are. The present tier stays.
    pub fn set_tier<'t>(&mut self, tier: impl Into<Option<&'t str>>) -> Result<(), Error> {
        let tier = tier.into();
        let graph = self.snapshot.graph(tier)?;
        self.post.stop_governing();
        self.source.tier = tier.map(str::to_owned);
        self.post.change(graph);
        Ok(())
    }

    /// Holds a budget in milliseconds: from now on, a governor chooses one of these tiers, which are in order from the
    /// worst picture to the best, as [`GraphPost::govern`] describes.
    ///
    /// # Errors
    /// There is no such tier.
    ///
    /// # Panics
    /// There is no tier in the list.
    pub fn govern(&mut self, budget_ms: f64, tiers: &[&str]) -> Result<(), Error> {
        let mut graphs = Vec::with_capacity(tiers.len());
        for tier in tiers {
            let graph = self.snapshot.graph(Some(tier))?;
            graphs.push(TierGraph { tier: GovernedTier { name: (*tier).to_owned(), cost: None }, graph });
        }
        self.post.govern(budget_ms, graphs);
        self.governed = tiers.iter().map(|tier| (*tier).to_owned()).collect();
        Ok(())
    }

    /// Keeps the present tier from now on.
    pub fn stop_governing(&mut self) {
        self.source.tier = self.tier().map(str::to_owned);
        self.post.stop_governing();
    }

    /// Looks whether a file of the pipeline has changed, and takes it: the pipeline itself, the files that it names,
    /// node kinds in folders. Returns whether anything was taken.
    ///
    /// It asks the system for the time of change and the length of each file, about two microseconds each, and starts
    /// no thread: call it as often as edits shall be seen, such as twice in a second. After a change it reads and
    /// checks the pipeline on this thread, as [`open`](Self::open) does; the plan is made in the background. Built-in
    /// pipelines and texts without files do not change.
    ///
    /// # Errors
    /// What has changed is wrong: the old pipeline renders on. The error is returned once, until the next change.
    pub fn reload_if_changed(&mut self) -> Result<bool, Error> {
        let Some(mut stamps) = self.stamps.changed() else { return Ok(false) };
        let files = files_of(&self.source);
        let read = Snapshot::read(&self.source, files.clone());
        let taken = read.and_then(|snapshot| self.take(snapshot));
        // While a file is wrong, those that it named before may be the ones to be corrected.
        if taken.is_err() {
            stamps.extend(files.stamps());
            self.stamps = stamps;
        } else {
            self.stamps = files.stamps();
        }
        taken.map(|()| true)
    }

    fn take(&mut self, snapshot: Snapshot) -> Result<(), Error> {
        if self.post.governor().is_some() {
            let graphs: Result<_, Error> = self.governed.iter().map(|tier| snapshot.graph(Some(tier))).collect();
            self.post.change_governed(graphs?);
        } else {
            self.post.change(snapshot.graph(self.source.tier.as_deref())?);
        }
        self.snapshot = snapshot;
        Ok(())
    }
}

impl Deref for Post {
    type Target = GraphPost;

    fn deref(&self) -> &GraphPost {
        &self.post
    }
}

impl DerefMut for Post {
    fn deref_mut(&mut self) -> &mut GraphPost {
        &mut self.post
    }
}
