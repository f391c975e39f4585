//! Every pipeline and every node kind with extreme images, parameters and sizes.
//!
//! A [`Target`] is a pipeline or a kind on its own; [`stress`] runs its cases and returns a [`StressReport`]. Images
//! are small and many are rendered in one submission, so that tens of thousands of cases take minutes on a processor.

mod case_runner;
mod filter;
mod images;
mod motion;
mod visible;

mod laws;
mod render;
mod report;
mod run;
mod settings;
mod target;
mod time;
mod variants;
mod wiring;

use std::sync::Arc;

use afterimage_gpu::Gpu;
use afterimage_graph::check::Loader;
use afterimage_graph::node::{NodeKind, Registry, RegistryError};

pub use case_runner::StressOptions;
pub use report::{Failed, Results, StressReport};
pub use target::{Overrides, Target};
pub use visible::ShowValue;

use crate::Progress;
use render::Renderer;
pub use wiring::NODE;

/// The kinds of these tables, and those that make values, pyramids and volumes visible.
///
/// # Errors
/// As [`Registry::new`].
pub fn registry(tables: &[&[NodeKind]]) -> Result<Arc<Registry>, RegistryError> {
    let mut all = tables.to_vec();
    all.push(visible::ALL);
    Registry::new(&all).map(Arc::new)
}

/// Each kind of these tables on its own: with its optional inputs, and without them if it has any. In addition, the
/// kinds that cannot run alone, each with the reason and with what makes it reachable.
pub fn kinds(registry: &Arc<Registry>, tables: &[&[NodeKind]]) -> (Vec<Target>, Vec<String>) {
    let (mut targets, mut skipped) = (Vec::new(), Vec::new());
    for kind in tables.iter().copied().flatten() {
        match Target::kind(registry, kind, false) {
            Ok(target) => targets.push(target),
            Err(why) => skipped.push(format!("`{}` does not run with all of its inputs: {why}", kind.name())),
        }
        if kind.inputs().iter().any(|port| port.optional) {
            targets.extend(Target::kind(registry, kind, true).ok());
        }
    }
    (targets, skipped)
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
    registry: &Arc<Registry>,
    loader: &'static dyn Loader,
    tier: Option<&str>,
) -> Result<Vec<Target>, crate::LabError> {
    let whole = Target::pipeline(title, words, file, text, registry, loader)?;
    if tier.is_some() {
        return Ok(vec![whole.at_tier(tier)]);
    }
    let tiers: Vec<Target> = whole.tiers().map(|tier| whole.at_tier(Some(tier))).collect();
    let without_optional = whole.has_optional_inputs().then(|| whole.without_optional());
    Ok([whole].into_iter().chain(without_optional).chain(tiers).collect())
}

/// Runs the chosen cases of each target.
pub fn stress(gpu: &Gpu, targets: &[Target], options: &StressOptions, progress: &dyn Progress) -> StressReport {
    let mut renderer = Renderer::new(gpu, options.unsanitized, options.options);
    renderer.filters_coarsely = targets.first().is_some_and(|target| filter::is_coarse(gpu, &target.registry));
    let mut report = StressReport::default();
    for target in targets.iter().filter(|target| !target.bare || options.includes(target, "bare")) {
        progress.begin(&target.title);
        report.results.push(run::stress(&mut renderer, target, options, progress));
        progress.end();
    }
    report
}

/// The names of all cases: images, then sequences, then lines that move.
pub fn case_names() -> Vec<&'static str> {
    images::ALL.iter().map(|image| image.name).chain(time::names()).chain([motion::LINES]).collect()
}

/// True if a case of this name exists.
pub fn is_case(name: &str) -> bool {
    case_names().contains(&name) || name == run::CHECK
}

#[cfg(test)]
mod tests {
    use super::{is_case, motion, run};

    #[test]
    fn images_sequences_and_lines_are_cases() {
        assert!(["nan", "cut", motion::LINES, run::CHECK].into_iter().all(is_case));
        assert!(!is_case("cuts"));
    }
}
