//! Every pipeline and every node kind with extreme images, parameters and sizes.
//!
//! A [`Subject`] is a pipeline or a kind on its own; [`stress`] runs its cases and returns a [`StressReport`]. Images
//! are small and many are rendered in one submission, so that tens of thousands of cases take minutes on a processor.

mod case_runner;
mod filter;
mod images;
mod motion;
mod probes;
mod promises;
mod render;
mod report;
mod run;
mod settings;
mod subject;
mod time;
mod variants;
mod verdicts;
mod wiring;

use afterimage_gpu::Gpu;
use afterimage_graph::check::Loader;
use afterimage_graph::node::{NodeKind, Registry, RegistryError};

pub use case_runner::StressOptions;
pub use report::{Failed, StressReport, Tally};
pub use subject::{Overrides, Subject};

use crate::Progress;
use render::Renderer;
pub use wiring::NODE;

/// The kinds of these tables, and those that make values, pyramids and volumes visible.
///
/// # Errors
/// As [`Registry::new`].
pub fn registry(tables: &[&[NodeKind]]) -> Result<Registry, RegistryError> {
    let mut all = tables.to_vec();
    all.push(probes::ALL);
    Registry::new(&all)
}

/// Each kind of these tables on its own: with its optional inputs, with light that may be negative, and without
/// optional inputs if it has any. In addition, the kinds that cannot run alone, each with the reason and with what
/// makes it reachable.
pub fn kinds(registry: &Registry, tables: &[&[NodeKind]]) -> (Vec<Subject>, Vec<String>) {
    let (mut subjects, mut skipped) = (Vec::new(), Vec::new());
    for kind in tables.iter().copied().flatten() {
        match Subject::kind(registry, kind, false, false) {
            Ok(subject) => subjects.push(subject),
            Err(why) => skipped.push(format!("`{}` does not run with all of its inputs: {why}", kind.name())),
        }
        subjects.extend(Subject::kind(registry, kind, false, true).ok().filter(Subject::takes_images));
        if kind.inputs().iter().any(|port| port.optional) {
            subjects.extend(Subject::kind(registry, kind, true, false).ok());
        }
    }
    (subjects, skipped)
}

/// A pipeline, without its optional inputs, and at each of its tiers; or at the tier that is given. `words` are the
/// arguments that choose it on the command line.
///
/// # Errors
/// The text is not a pipeline.
pub fn pipelines(
    title: &str,
    words: &str,
    file: &str,
    text: &str,
    loader: &'static dyn Loader,
    tier: Option<&str>,
) -> Result<Vec<Subject>, crate::LabError> {
    let whole = Subject::pipeline(title, words, file, text, loader)?;
    if tier.is_some() {
        return Ok(vec![whole.at_tier(tier)]);
    }
    let tiers: Vec<Subject> = whole.tiers().map(|tier| whole.at_tier(Some(tier))).collect();
    let without_optional = whole.has_optional_inputs().then(|| whole.without_optional());
    Ok([whole].into_iter().chain(without_optional).chain(tiers).collect())
}

/// Runs the chosen cases of each subject.
pub fn stress(
    gpu: &Gpu,
    registry: &Registry,
    subjects: &[Subject],
    options: &StressOptions,
    progress: &dyn Progress,
) -> StressReport {
    let mut renderer = Renderer::new(gpu, options.unsanitized, options.options);
    renderer.filters_coarsely = filter::is_coarse(gpu, registry);
    let mut report = StressReport::default();
    for subject in subjects {
        progress.begin(&subject.title);
        report.tallies.push(run::stress(&mut renderer, registry, subject, options, progress));
        progress.end();
    }
    report
}

/// The names of all cases: images, then sequences, then lines that move.
pub fn case_names() -> Vec<&'static str> {
    images::ALL.iter().map(|image| image.name).chain(time::names()).chain([motion::LINES]).collect()
}

/// Whether a case of this name exists.
pub fn is_case(name: &str) -> bool {
    case_names().contains(&name) || name == run::CHECK
}
