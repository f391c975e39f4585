//! All cases of one pipeline or kind.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::Invariants;

use super::case_runner::{CaseRunner, StressOptions, judge};
use super::images::{ALL, Extreme};
use super::laws::{Tolerance, different, finite, invariants, tested};
use super::render::{Configuration, OutputPixels, RenderRequest, Rendered, Renderer, StressFrame};
use super::report::Results;
use super::settings::{Change, sweep};
use super::target::{Overrides, Target};
use super::wiring::NODE;
use super::{motion, time, variants};
use crate::Progress;

/// The size at which parameters are swept: both sides are odd and not close to a power of two.
const SWEPT: Size = Size { width: 17, height: 13, depth: 1 };
/// Sizes with the other parities of the sides, for kinds that keep the sum of an image.
const PARITIES: [Size; 3] = [
    Size { width: 16, height: 12, depth: 1 },
    Size { width: 17, height: 12, depth: 1 },
    Size { width: 16, height: 13, depth: 1 },
];
/// Images whose bright pixels do not reach the border.
const LIGHTS: [&str; 3] = ["firefly", "diagonal", "board"];
/// One pixel, lines, odd and even sides, primes; large enough for all levels of a pyramid in the last.
const SIZES: [(u32, u32); 8] = [(1, 1), (1, 7), (7, 1), (2, 2), (5, 3), (16, 16), (31, 29), (127, 67)];
/// Sizes of a quick run, and of heavy targets.
const FEW_SIZES: [(u32, u32); 2] = [(1, 1), (5, 3)];
/// Pairs of extremes for each pipeline and kind.
const PAIRS: usize = 160;
/// The texels from which on a target is heavy: fewer of its cases are run.
const HEAVY: u64 = 50_000;
/// Pairs of extremes for a heavy target.
const FEW_PAIRS: usize = 4;
/// The images for the parameters of a heavy target: every bad value, and those with negative ones.
const HEAVY_IMAGES: [&str; 4] = ["mixed", "negative", "minus-inf", "wide"];
/// The texels from which on pairs of extremes are skipped, and single ones get one image.
const TOO_HEAVY: u64 = 400_000;
const TOO_HEAVY_IMAGE: &str = "mixed";
/// The images for pairs of extremes.
const PAIR_IMAGES: [&str; 5] = ["black", "nan", "firefly", "ramp", "primaries"];
/// The images for the longest sides that the device allows.
const LONG_IMAGES: [&str; 2] = ["ramp", "inf"];

impl StressOptions {
    fn images(&self, change: &Change, is_heavy: bool) -> Vec<Extreme> {
        let is_default = change.overrides.is_empty();
        let all = self.case.is_some() || (is_default && !(self.quick && is_heavy)) || (change.is_single && !is_heavy);
        let is_heavy_image = |name: &str| is_heavy && HEAVY_IMAGES.contains(&name);
        let is_pair_image = |name: &str| (is_default || !is_heavy) && PAIR_IMAGES.contains(&name);
        let is_chosen = |image: &&Extreme| {
            (all || is_heavy_image(image.name) || is_pair_image(image.name)) && self.accepts(image.name)
        };
        ALL.iter().filter(is_chosen).copied().collect()
    }

    fn sizes(&self, is_heavy: bool) -> Vec<Size> {
        let list: &[(u32, u32)] = if self.quick || is_heavy { &FEW_SIZES } else { &SIZES };
        list.iter().map(|(width, height)| Size::new(*width, *height)).collect()
    }

    /// The texels from which on a change of parameters is skipped, or gets one image.
    fn too_heavy(&self) -> u64 {
        if self.quick { TOO_HEAVY / 2 } else { TOO_HEAVY }
    }

    fn swept(&self) -> Size {
        self.size.map_or(SWEPT, |(width, height)| Size::new(width, height))
    }
}

/// The verdict on an invariant that holds in an exact plan, but not with the coarse filter of the device.
const KEPT_IF_EXACT: &str = "kept but for the device's filter";

/// An invariant that an output violates.
struct Violation {
    output: String,
    invariant: &'static str,
    what: String,
}

/// The case of a graph that cannot be checked.
pub(crate) const CHECK: &str = "check";

/// Runs all cases of a target.
pub(crate) fn stress(
    renderer: &mut Renderer,
    target: &Target,
    options: &StressOptions,
    progress: &dyn Progress,
) -> Results {
    let target = &target.with_words(if options.unsanitized { " --unsanitized" } else { "" });
    let results = Results::new(target);
    let mut runner = CaseRunner { renderer, target, options, progress, results, is_heavy: false };
    match target.graph(&Overrides::new()) {
        Ok(graph) => runner.all(&graph),
        Err(diagnostics) => {
            let first = diagnostics.iter().next().map_or_else(String::new, |one| one.message.clone());
            runner.count(&Overrides::new(), SWEPT, CHECK, vec![first]);
        }
    }
    runner.results
}

impl CaseRunner<'_> {
    fn all(&mut self, graph: &Graph) {
        let mut configuration = self.renderer.configure(|_, _| {}, false);
        self.is_heavy = configuration.texels(self.target, graph, SWEPT) > HEAVY;
        let pairs = match (self.options.quick, self.is_heavy) {
            (true, _) => 0,
            (false, true) => FEW_PAIRS,
            (false, false) => PAIRS,
        };
        let mut changes = sweep(self.target, graph, pairs);
        if self.options.defaults || !self.target.sweep {
            changes.truncate(1);
        }
        self.sweep(&mut configuration, &changes);
        self.kernel_faults(&mut configuration, graph, &changes[0]);
        if self.options.size.is_none() {
            self.sizes(&mut configuration, graph);
        }
        variants::compare(self, &changes);
        time::sequences(self, graph);
        time::late(self, graph);
        motion::moving_lines(self, graph);
    }

    /// Counts what functions of kinds in folders do wrong at the defaults.
    fn kernel_faults(&mut self, configuration: &mut Configuration, graph: &Graph, default: &Change) {
        let images = self.options.images(default, self.is_heavy);
        let inputs: Vec<StressFrame> = images.into_iter().map(StressFrame::still).collect();
        let size = self.options.swept();
        let request = RenderRequest { target: self.target, graph, size, inputs: &inputs, together: false };
        let mut faults = Vec::new();
        let searched = self.renderer.kernel_faults(configuration, request, &mut faults);
        self.results.kernel_faults = faults.iter().map(ToString::to_string).collect();
        if let Err(error) = searched {
            self.results.kernel_faults.push(format!("not all images were searched for NaN: {error}"));
        }
    }

    fn sweep(&mut self, configuration: &mut Configuration, changes: &[Change]) {
        let mut forced = self.renderer.configure(|_, _| {}, false);
        let size = self.options.swept();
        for change in changes {
            let Ok(graph) = self.target.graph(&change.overrides) else {
                self.results.refused += 1;
                continue;
            };
            let texels = if self.is_heavy { configuration.texels(self.target, &graph, size) } else { 0 };
            let is_worth_it = change.is_single && !self.options.quick;
            if texels > self.options.too_heavy() && !is_worth_it && self.options.case.is_none() {
                continue;
            }
            let mut images = self.options.images(change, self.is_heavy);
            if texels > self.options.too_heavy() && self.options.case.is_none() {
                images.retain(|image| image.name == TOO_HEAVY_IMAGE);
            }
            let Some(ran) = self.stills(configuration, &graph, &change.overrides, size, &images) else { continue };
            if self.target.is_kind && ran.skipped.iter().any(|node| node == NODE) {
                self.identity(&mut forced, &ran, &change.overrides, size, &images);
            }
            if self.options.size.is_none() && change.is_single && invariants(&graph).keeps_sum {
                images.retain(|image| LIGHTS.contains(&image.name));
                for size in PARITIES {
                    self.stills(configuration, &graph, &change.overrides, size, &images);
                }
            }
        }
    }

    fn sizes(&mut self, configuration: &mut Configuration, graph: &Graph) {
        let images = |names: Option<&[&str]>| -> Vec<Extreme> {
            let is_chosen = |image: &&Extreme| names.is_none_or(|names| names.contains(&image.name));
            ALL.iter().filter(is_chosen).filter(|image| self.options.accepts(image.name)).copied().collect()
        };
        let is_slow = self.options.quick && self.is_heavy;
        let (all, long) = (images(is_slow.then_some(&HEAVY_IMAGES)), images(Some(&LONG_IMAGES)));
        // How many times as wide as the image the widest output is.
        let mut ratios = Vec::new();
        for size in self.options.sizes(self.is_heavy) {
            let ran = self.stills(configuration, graph, &Overrides::new(), size, &all);
            let outputs = ran.iter().flat_map(|ran| &ran.frames[0]);
            let widest = outputs.map(|output| output.size.width).max();
            ratios.extend(widest.map(|widest| widest.div_ceil(size.width)));
        }
        if self.options.includes(self.target, "half floats") {
            let mut half = self.renderer.configure(|_, _| {}, true);
            self.stills(&mut half, graph, &Overrides::new(), SWEPT, &all);
        }
        if !self.options.quick {
            // Outputs of a kind that enlarges have the longest side; those of a fixed size do not grow.
            let longest = configuration.longest_side() / ratios.into_iter().min().unwrap_or(1);
            for size in [Size::new(longest, 1), Size::new(1, longest)] {
                self.stills(configuration, graph, &Overrides::new(), size, &long);
            }
        }
    }

    /// Renders first frames and counts a case for each; `None` without images or if they cannot be rendered.
    fn stills(
        &mut self,
        configuration: &mut Configuration,
        graph: &Graph,
        overrides: &Overrides,
        size: Size,
        images: &[Extreme],
    ) -> Option<Rendered> {
        if images.is_empty() {
            return None;
        }
        // The images, then sanitized versions of those that are not clean: both must give equal outputs.
        let sanitized: Vec<usize> = (0..images.len()).filter(|index| images[*index].is_sanitized(size)).collect();
        let clean = sanitized.iter().map(|index| StressFrame { sanitized: true, ..StressFrame::still(images[*index]) });
        let inputs: Vec<StressFrame> = images.iter().map(|image| StressFrame::still(*image)).chain(clean).collect();
        let request = RenderRequest { target: self.target, graph, size, inputs: &inputs, together: true };
        let ran = match self.renderer.run(configuration, request) {
            Ok(ran) => ran,
            Err(why) => {
                self.count(overrides, size, images[0].name, vec![why]);
                return None;
            }
        };
        let invariants = invariants(graph);
        let mut exact = None;
        for (index, image) in images.iter().enumerate() {
            let mut wrong: Vec<String> =
                ran.frames[index].iter().flat_map(|shown| judge(shown, invariants.non_negative)).collect();
            let mut broken = self.broken(&ran.frames[index], *image, size, &invariants);
            if !broken.is_empty() && self.renderer.filters_coarsely {
                let ran = exact.get_or_insert_with(|| self.renderer.run(&mut configuration.exact(), request));
                let frame = ran.as_ref().map_or(&[][..], |ran| &ran.frames[index]);
                self.forgive(&mut broken, frame, *image, size, &invariants);
            }
            wrong.extend(broken.into_iter().map(|broken| broken.what));
            if let Some(clean) = sanitized.iter().position(|sanitized| *sanitized == index) {
                self.results.judged("no spread in space");
                wrong.extend(spread(&ran.frames[index], &ran.frames[images.len() + clean]));
            }
            self.count(overrides, size, image.name, wrong);
        }
        Some(ran)
    }

    /// The invariants that the outputs of a still violate.
    fn broken(
        &mut self,
        frame: &[OutputPixels],
        image: Extreme,
        size: Size,
        invariants: &Invariants,
    ) -> Vec<Violation> {
        let mut all = Vec::new();
        for shown in frame {
            for (invariant, what) in tested(shown, image, size, invariants) {
                self.results.judged(invariant);
                all.extend(what.map(|what| Violation { output: shown.name.clone(), invariant, what }));
            }
        }
        all
    }

    /// Removes the violations that an exact plan does not have: the filter of the device causes them.
    fn forgive(
        &mut self,
        broken: &mut Vec<Violation>,
        exact: &[OutputPixels],
        image: Extreme,
        size: Size,
        invariants: &Invariants,
    ) {
        let is_kept = |broken: &Violation| {
            let Some(shown) = named(exact, &broken.output) else { return false };
            tested(shown, image, size, invariants).contains(&(broken.invariant, None))
        };
        let before = broken.len();
        broken.retain(|broken| !is_kept(broken));
        (broken.len()..before).for_each(|_| self.results.judged(KEPT_IF_EXACT));
    }

    /// A node that is skipped as an identity must change nothing when it runs. A kind without negative results
    /// removes negative values when it runs, but not when it is skipped.
    fn identity(
        &mut self,
        configuration: &mut Configuration,
        skipped: &Rendered,
        overrides: &Overrides,
        size: Size,
        images: &[Extreme],
    ) {
        let Some(graph) = self.target.forced(overrides) else { return };
        let inputs: Vec<StressFrame> = images.iter().map(|image| StressFrame::still(*image)).collect();
        let request = RenderRequest { target: self.target, graph: &graph, size, inputs: &inputs, together: true };
        let ran = match self.renderer.run(configuration, request) {
            Ok(ran) if !ran.skipped.iter().any(|node| node == NODE) => ran,
            _ => return,
        };
        let cuts = invariants(&graph).non_negative;
        for (index, image) in images.iter().enumerate() {
            let mut wrong = Vec::new();
            for skipped in &skipped.frames[index] {
                let Some(ran) = named(&ran.frames[index], &skipped.name) else { continue };
                let difference = match cuts {
                    true => different(&without_negatives(ran), &without_negatives(skipped), Tolerance::HALF),
                    false => different(ran, skipped, Tolerance::HALF),
                };
                wrong.extend(difference.map(|what| format!("skipped as an identity, but it gives {what}")));
            }
            self.results.judged("neutral");
            self.count(overrides, size, image.name, wrong);
        }
    }
}

fn without_negatives(shown: &OutputPixels) -> OutputPixels {
    let mut shown = shown.clone();
    shown.pixels.iter_mut().flat_map(|pixel| &mut pixel[..3]).for_each(|x| *x = x.max(0.0));
    shown
}

/// The first pixel in which values that are not sanitized have spread.
fn spread(frame: &[OutputPixels], clean: &[OutputPixels]) -> Option<String> {
    let pairs = frame.iter().zip(clean).filter(|(shown, _)| finite(shown).is_none());
    let mut spread = pairs.filter_map(|(shown, clean)| different(shown, clean, Tolerance::NONE));
    spread.next().map(|what| format!("bad values spread: {what} after sanitizing"))
}

fn named<'s>(frame: &'s [OutputPixels], name: &str) -> Option<&'s OutputPixels> {
    frame.iter().find(|shown| shown.name == name)
}
