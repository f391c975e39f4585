//! The state that all cases of a pipeline or a kind share: options, renderer and results.

use afterimage_graph::image::Size;
use afterimage_plan::Options;

use super::laws::{finite, in_range};
use super::render::{OutputPixels, Renderer};
use super::report::Results;
use super::target::{Overrides, Target};
use crate::Progress;

#[derive(Clone, Debug)]
pub struct StressOptions {
    /// Only the image or sequence of this name.
    pub case: Option<String>,
    /// Only this size.
    pub size: Option<(u32, u32)>,
    /// Parameters keep their values.
    pub defaults: bool,
    /// Fewer sizes, and no pairs of extremes.
    pub quick: bool,
    /// Images are not sanitized. Then stress must fail.
    pub unsanitized: bool,
    /// The seed of a sampled tenth of the cases that need further shaders: variants of plans, images of half floats,
    /// targets without optional inputs. `None` for all of it.
    pub tenth: Option<u64>,
    pub options: Options,
}

impl StressOptions {
    /// True if cases of this name run.
    pub(crate) fn accepts(&self, case: &str) -> bool {
        self.case.as_ref().is_none_or(|chosen| chosen == case)
    }

    /// True if this part of a target's cases runs.
    pub(crate) fn includes(&self, target: &Target, part: &str) -> bool {
        let Some(seed) = self.tenth else { return true };
        // FNV-1a, whose low bits are the worst.
        let bytes = seed.to_le_bytes().into_iter().chain(target.title.bytes()).chain(part.bytes());
        let hash =
            bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        (hash >> 32).is_multiple_of(10)
    }
}

/// The state that all cases of one target share.
pub(crate) struct CaseRunner<'a> {
    pub(crate) renderer: &'a mut Renderer,
    pub(crate) target: &'a Target,
    pub(crate) options: &'a StressOptions,
    pub(crate) progress: &'a dyn Progress,
    pub(crate) results: Results,
    /// Frames need many texels.
    pub(crate) is_heavy: bool,
}

impl CaseRunner<'_> {
    /// Adds a case with what is wrong with it.
    pub(crate) fn count(&mut self, overrides: &Overrides, size: Size, case: &str, wrong: Vec<String>) {
        self.results.count(self.target, overrides, size, case, wrong);
        self.progress.reach(&format!("{}, {} cases", self.results.title, self.results.cases));
    }
}

/// Faults of an output on its own.
pub(crate) fn judge(shown: &OutputPixels, non_negative: bool) -> Vec<String> {
    finite(shown).into_iter().chain(in_range(shown, non_negative)).collect()
}

#[cfg(test)]
mod tests {
    use afterimage_graph::check::NoFiles;

    use super::*;

    fn options(tenth: Option<u64>) -> StressOptions {
        let (case, size, options) = (None, None, Options::default());
        StressOptions { case, size, defaults: true, quick: true, unsanitized: false, tenth, options }
    }

    #[test]
    fn a_tenth_is_another_tenth_for_each_seed() {
        let text = "Pipeline(inputs: { \"in\": Color }, nodes: {}, outputs: { \"out\": \"in\" })";
        let registry = super::super::registry(&[]).expect("no two kinds share a name");
        let target = |number: u32| Target::pipeline(&format!("kind {number}"), "", "", text, &registry, &NoFiles);
        let targets: Vec<Target> = (0..300).map(|number| target(number).expect("a pipeline")).collect();
        let parts = ["half floats", "when drawn"];
        let chosen = |seed: Option<u64>| -> Vec<bool> {
            let options = options(seed);
            targets.iter().flat_map(|target| parts.map(|part| options.includes(target, part))).collect()
        };
        assert!(chosen(None).iter().all(|chosen| *chosen));
        let mut ever = vec![false; 600];
        for seed in 0..80 {
            let chosen = chosen(Some(seed));
            let count = chosen.iter().filter(|chosen| **chosen).count();
            assert!((30..100).contains(&count), "{count} of 600 for the seed {seed}");
            ever.iter_mut().zip(chosen).for_each(|(ever, chosen)| *ever |= chosen);
        }
        let never = ever.iter().filter(|ever| !**ever).count();
        assert!(never < 6, "{never} of 600 parts are in none of 80 tenths");
    }
}
