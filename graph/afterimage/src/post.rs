//! A pipeline of a file on the host's device.

use std::ops::{Deref, DerefMut};

use afterimage_gpu::{Executor, GovernedTier, Gpu, Post as GraphPost, TierGraph, caps};
use afterimage_graph::document::Claim;

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
    /// Where its files are, if it reads them by itself.
    source: Option<Source>,
    /// The tier that the host has chosen.
    tier: Option<String>,
    /// What was read last without an error.
    snapshot: Snapshot,
    /// What was read, also last with an error.
    stamps: Stamps,
    /// The tiers of the governor, if that chooses.
    governed: Vec<String>,
}

impl Post {
    /// Opens a pipeline: a file, the name of a built-in pipeline, or another [`Source`]. Reads and checks the files on
    /// this thread, about a millisecond without large tables. The plan is made by [`prepare`](GraphPost::prepare), or
    /// for the first frame.
    ///
    /// # Errors
    /// There is no such pipeline, or it or what it names is wrong; the text has all errors with their excerpts.
    pub fn open(gpu: &Gpu, source: impl Into<Source>) -> Result<Self, Error> {
        let source = source.into();
        let files = files_of(&source);
        let snapshot = Snapshot::read(&source, files.clone())?;
        let executor = Executor::with_caps(&gpu.device, &gpu.queue, caps(&gpu.adapter, &gpu.device));
        let executor = match &source.pipeline_cache {
            Some(data) => executor.with_pipeline_cache(data),
            None => executor,
        };
        let post = Self::of_snapshot(executor, snapshot, source.tier.as_deref())?;
        Ok(Self { source: Some(source), stamps: files.stamps(), ..post })
    }

    /// A pipeline whose files the host has loaded, at a tier: it never reads them by itself. The executor may be a
    /// [view](Executor::clone_for_view) of another pipeline's, which then share what is compiled.
    ///
    /// # Errors
    /// The pipeline or what it names is wrong, or has no such tier.
    pub fn of_snapshot(executor: Executor, snapshot: Snapshot, tier: Option<&str>) -> Result<Self, Error> {
        let post = GraphPost::with_executor(executor, snapshot.graph(tier)?);
        let tier = tier.map(str::to_owned);
        Ok(Self { post, source: None, tier, snapshot, stamps: Stamps::default(), governed: Vec::new() })
    }

    /// The same pipeline for another view, as [`GraphPost::clone_for_view`] makes it. It reads files for itself.
    pub fn clone_for_view(&self) -> Self {
        Self {
            post: self.post.clone_for_view(),
            source: self.source.clone(),
            tier: self.tier().map(str::to_owned),
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

    /// The pipeline with its files, as read last without an error.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// The names of the pipeline's tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        self.snapshot.tiers()
    }

    /// What the pipeline claims of a tier: [`Snapshot::claim`].
    pub fn claim(&self, tier: &str) -> Option<&Claim> {
        self.snapshot.claim(tier)
    }

    /// The present tier; `None` for the values that the file has without one. Under a [budget](Self::govern), it is the
    /// one that the governor has chosen.
    pub fn tier(&self) -> Option<&str> {
        match self.post.governor() {
            Some(governor) => self.governed.get(governor.tier()).map(String::as_str),
            None => self.tier.as_deref(),
        }
    }

    /// Changes to a tier, in the background: `set_tier("low")`, or `set_tier(None)` for the values that the file has
    /// without one. Checks the pipeline on this thread, less than a millisecond. A [budget](Self::govern) ends.
    ///
    /// # Errors
    /// There is no such tier: the text lists those that there are. The present tier stays.
    pub fn set_tier<'t>(&mut self, tier: impl Into<Option<&'t str>>) -> Result<(), Error> {
        self.replace(self.snapshot.clone(), tier.into())
    }

    /// Changes to another pipeline that the host has loaded, at a tier, as by [`set_tier`](Self::set_tier). Values of
    /// parameters that both have stay.
    ///
    /// # Errors
    /// As for [`of_snapshot`](Self::of_snapshot). The present pipeline stays.
    pub fn replace(&mut self, snapshot: Snapshot, tier: Option<&str>) -> Result<(), Error> {
        let graph = snapshot.graph(tier)?;
        self.post.stop_governing();
        (self.tier, self.snapshot) = (tier.map(str::to_owned), snapshot);
        self.post.change(graph);
        Ok(())
    }

    /// Holds a budget in milliseconds: from now on, a governor chooses one of these tiers, which are in order from the
    /// worst picture to the best, as [`GraphPost::govern`] describes. It begins with the costs that the pipeline
    /// [claims](Self::claim).
    ///
    /// # Errors
    /// There is no such tier, or none in the list. Nothing changes.
    pub fn govern(&mut self, budget_ms: f64, tiers: &[&str]) -> Result<(), Error> {
        let mut graphs = Vec::with_capacity(tiers.len());
        for tier in tiers {
            let graph = self.snapshot.graph(Some(tier))?;
            let cost = self.claim(tier).and_then(|claim| claim.ms);
            graphs.push(TierGraph { tier: GovernedTier { name: (*tier).to_owned(), cost }, graph });
        }
        self.post.govern(budget_ms, graphs)?;
        self.governed = tiers.iter().map(|tier| (*tier).to_owned()).collect();
        Ok(())
    }

    /// Keeps the present tier from now on.
    pub fn stop_governing(&mut self) {
        self.tier = self.tier().map(str::to_owned);
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
        let Some(source) = &self.source else { return Ok(false) };
        let files = files_of(source);
        let read = Snapshot::read(source, files.clone());
        let taken = read.and_then(|snapshot| self.reload(snapshot));
        // While a file is wrong, those that it named before may be the ones to be corrected.
        if taken.is_err() {
            stamps.extend(files.stamps());
            self.stamps = stamps;
        } else {
            self.stamps = files.stamps();
        }
        taken.map(|()| true)
    }

    /// Takes what the host has loaded anew: the tier or the budget stays.
    ///
    /// # Errors
    /// It is wrong, or has no such tier. The present pipeline stays.
    pub fn reload(&mut self, snapshot: Snapshot) -> Result<(), Error> {
        if self.post.governor().is_some() {
            let graphs: Result<_, Error> = self.governed.iter().map(|tier| snapshot.graph(Some(tier))).collect();
            self.post.change_governed(graphs?)?;
        } else {
            self.post.change(snapshot.graph(self.tier.as_deref())?);
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
