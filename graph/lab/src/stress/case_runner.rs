//! What all cases of a pipeline or a kind share: options, the renderer and the results.

use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::Options;

use super::render::{OutputPixels, Renderer};
use super::report::Tally;
use super::subject::{Overrides, Subject};
use super::verdicts::{finite, in_range};
use crate::Progress;

/// Which cases are run, and how.
#[derive(Clone, Debug)]
pub struct StressOptions {
    /// Only the image or sequence of this name.
    pub case: Option<String>,
    /// Only this size.
    pub size: Option<(u32, u32)>,
    /// Whether parameters keep their values.
    pub defaults: bool,
    /// Fewer sizes, and no pairs of extremes.
    pub quick: bool,
    /// Whether images are not sanitized. Then stress must fail.
    pub unsanitized: bool,
    pub options: Options,
}

impl StressOptions {
    /// Whether a case of this name is run.
    pub(crate) fn accepts(&self, case: &str) -> bool {
        self.case.as_ref().is_none_or(|chosen| chosen == case)
    }
}

/// What all cases of one subject share.
pub(crate) struct CaseRunner<'a> {
    pub(crate) renderer: &'a mut Renderer,
    pub(crate) registry: &'a Registry,
    pub(crate) subject: &'a Subject,
    pub(crate) options: &'a StressOptions,
    pub(crate) progress: &'a dyn Progress,
    pub(crate) tally: Tally,
    /// Whether frames need many texels.
    pub(crate) is_heavy: bool,
}

impl CaseRunner<'_> {
    /// Adds a case with what is wrong with it.
    pub(crate) fn count(&mut self, overrides: &Overrides, size: Size, case: &str, wrong: Vec<String>) {
        self.tally.count(self.subject, overrides, size, case, wrong);
        self.progress.reach(&format!("{}, {} cases", self.tally.title, self.tally.cases));
    }
}

/// What is wrong with an output on its own.
pub(crate) fn judge(shown: &OutputPixels, non_negative: bool) -> Vec<String> {
    finite(shown).into_iter().chain(in_range(shown, non_negative)).collect()
}
