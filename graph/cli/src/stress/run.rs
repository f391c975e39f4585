//! One pipeline or kind through all its cases.

use afterimage_graph::check::Graph;
use afterimage_graph::image::{ColorState, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::Options;

use super::images::{ALL, Extreme};
use super::lab::{Bench, Lab, Ran, Shot, Shown};
use super::promises::Promises;
use super::report::Tally;
use super::settings::{Change, sweep};
use super::subject::{Sets, Subject};
use super::verdicts::{Tolerance, different, finite, in_range, promised};
use super::wiring::NODE;
use super::{time, variants};

/// Which cases are run.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Only the image or sequence of this name.
    pub case: Option<String>,
    /// Only this size.
    pub size: Option<(u32, u32)>,
    /// Whether parameters stay as they are.
    pub defaults: bool,
    /// Fewer sizes, and no pairs of extremes.
    pub quick: bool,
    /// Whether nothing guards what kinds read from bad numbers in the images. Then `stress` must fail.
    pub unguarded: bool,
    /// What plans are made with.
    pub options: Options,
}

/// The size at which parameters are swept: both sides odd, and no power of two near.
const SWEPT: Size = Size { width: 17, height: 13, depth: 1 };
/// One pixel, lines, odd and even sides, primes; large enough for all levels of a pyramid in the last.
const SIZES: [(u32, u32); 8] = [(1, 1), (1, 7), (7, 1), (2, 2), (5, 3), (16, 16), (31, 29), (127, 67)];
/// Sizes of a quick run, and of heavy subjects.
const FEW_SIZES: [(u32, u32); 2] = [(1, 1), (5, 3)];
/// Pairs of extremes for each pipeline and kind.
const PAIRS: usize = 160;
/// Texels of all images of a subject that makes many from few pixels; fewer of its cases are run.
const HEAVY: u64 = 50_000;
/// Pairs of extremes for such a subject.
const FEW_PAIRS: usize = 4;
/// The images that its parameters see.
const MOST_TELLING: [&str; 1] = ["mixed"];
/// Texels beyond which a pair of extremes is not tried and a single one is seen with one image.
const TOO_HEAVY: u64 = 400_000;
/// The images that pairs of extremes see.
const TELLING: [&str; 5] = ["black", "nan", "firefly", "ramp", "primaries"];
/// The images with negative numbers.
const NEGATIVE: [&str; 2] = ["negative", "minus-inf"];
/// The images that lines as long as the device allows see.
const LONG: [&str; 2] = ["ramp", "inf"];

impl Choice {
    /// Whether a case of this name is run.
    pub(crate) fn accepts(&self, case: &str) -> bool {
        self.case.as_ref().is_none_or(|wanted| wanted == case)
    }

    fn images(&self, change: &Change, is_heavy: bool, is_signed: bool) -> Vec<Extreme> {
        let is_default = change.sets.is_empty();
        let all = self.case.is_some() || (is_default && !(self.quick && is_heavy)) || (change.is_single && !is_heavy);
        let some: &[&str] = if is_heavy && !is_default { &MOST_TELLING } else { &TELLING };
        let is_wanted = |image: &&Extreme| all || is_signed || some.contains(&image.name);
        let fits = |image: &&Extreme| self.accepts(image.name) && (!is_signed || NEGATIVE.contains(&image.name));
        ALL.iter().filter(is_wanted).filter(fits).copied().collect()
    }

    fn sizes(&self, is_heavy: bool) -> Vec<Size> {
        let list: &[(u32, u32)] = if self.quick || is_heavy { &FEW_SIZES } else { &SIZES };
        list.iter().map(|(width, height)| Size::new(*width, *height)).collect()
    }

    /// Texels beyond which a change of parameters is left out, or seen with one image.
    fn too_heavy(&self) -> u64 {
        if self.quick { TOO_HEAVY / 2 } else { TOO_HEAVY }
    }

    fn swept(&self) -> Size {
        self.size.map_or(SWEPT, |(width, height)| Size::new(width, height))
    }
}

/// All that one subject's cases share.
pub(crate) struct Stand<'a, 'g> {
    pub(crate) lab: &'a mut Lab<'g>,
    pub(crate) registry: &'a Registry,
    pub(crate) subject: &'a Subject,
    pub(crate) choice: &'a Choice,
    pub(crate) tally: Tally,
    /// Whether it makes many texels from few pixels.
    pub(crate) is_heavy: bool,
}

/// Runs all cases of a subject.
pub(crate) fn stress(lab: &mut Lab<'_>, registry: &Registry, subject: &Subject, choice: &Choice) -> Tally {
    let flags = [
        (choice.unguarded, " --unguarded"),
        (choice.options.half, " --half"),
        (choice.options.subgroups, " --subgroups"),
    ];
    let words: String = flags.iter().filter_map(|(given, flag)| given.then_some(*flag)).collect();
    let subject = &subject.with_words(&words);
    let mut stand = Stand { lab, registry, subject, choice, tally: Tally::new(subject), is_heavy: false };
    match subject.graph(registry, &Sets::new()) {
        Ok(graph) => stand.all(&graph),
        Err(told) => {
            let first = told.iter().next().map_or_else(String::new, |one| one.message.clone());
            stand.count(&Sets::new(), SWEPT, "check", vec![first]);
        }
    }
    stand.tally
}

impl Stand<'_, '_> {
    pub(crate) fn count(&mut self, sets: &Sets, size: Size, case: &str, wrong: Vec<String>) {
        self.tally.count(self.subject, sets, size, case, wrong);
    }

    fn all(&mut self, graph: &Graph) {
        let mut bench = self.lab.bench(|_, _| {}, self.choice.options.half);
        self.is_heavy = bench.texels(self.subject, graph, SWEPT) > HEAVY;
        let pairs = match (self.choice.quick, self.is_heavy) {
            (true, _) => 0,
            (false, true) => FEW_PAIRS,
            (false, false) => PAIRS,
        };
        let pairs = if self.subject.signed { 0 } else { pairs };
        let mut changes = sweep(self.subject, graph, pairs);
        if self.choice.defaults || !self.subject.sweep {
            changes.truncate(1);
        }
        self.sweep(&mut bench, &changes);
        if self.subject.signed {
            return;
        }
        if self.choice.size.is_none() {
            self.sizes(&mut bench, graph);
        }
        variants::compare(self, &changes);
        time::sequences(self, graph);
    }

    fn sweep(&mut self, bench: &mut Bench, changes: &[Change]) {
        let mut forced = self.lab.bench(|_, _| {}, self.choice.options.half);
        let size = self.choice.swept();
        for change in changes {
            let Ok(graph) = self.subject.graph(self.registry, &change.sets) else {
                self.tally.refused += 1;
                continue;
            };
            let texels = if self.is_heavy { bench.texels(self.subject, &graph, size) } else { 0 };
            let is_worth_it = change.is_single && !self.choice.quick;
            if texels > self.choice.too_heavy() && !is_worth_it && self.choice.case.is_none() {
                continue;
            }
            let mut images = self.choice.images(change, self.is_heavy, self.subject.signed);
            if texels > self.choice.too_heavy() {
                images.truncate(1);
            }
            let Some(ran) = self.stills(bench, &graph, &change.sets, size, &images) else { continue };
            if self.subject.is_kind && ran.skipped.iter().any(|node| node == NODE) {
                self.identity(&mut forced, &ran, &change.sets, size, &images);
            }
        }
    }

    fn sizes(&mut self, bench: &mut Bench, graph: &Graph) {
        let images = |names: Option<&[&str]>| -> Vec<Extreme> {
            let is_wanted = |image: &&Extreme| names.is_none_or(|names| names.contains(&image.name));
            ALL.iter().filter(is_wanted).filter(|image| self.choice.accepts(image.name)).copied().collect()
        };
        let is_slow = self.choice.quick && self.is_heavy;
        let (all, long) = (images(is_slow.then_some(&MOST_TELLING)), images(Some(&LONG)));
        for size in self.choice.sizes(self.is_heavy) {
            self.stills(bench, graph, &Sets::new(), size, &all);
        }
        let mut half = self.lab.bench(|_, _| {}, true);
        self.stills(&mut half, graph, &Sets::new(), SWEPT, &all);
        if !self.choice.quick {
            let longest = bench.longest_side();
            for size in [Size::new(longest, 1), Size::new(1, longest)] {
                self.stills(bench, graph, &Sets::new(), size, &long);
            }
        }
    }

    /// Renders first frames and counts a case for each; `None` if there is nothing to look at.
    fn stills(&mut self, bench: &mut Bench, graph: &Graph, sets: &Sets, size: Size, images: &[Extreme]) -> Option<Ran> {
        if images.is_empty() {
            return None;
        }
        // Behind the images what the guard must make of some of them: both must come out alike.
        let guarded: Vec<usize> = (0..images.len()).filter(|index| images[*index].needs_guard(size)).collect();
        let clean = guarded.iter().map(|index| Shot { guarded: true, ..Shot::still(images[*index]) });
        let shots: Vec<Shot> = images.iter().map(|image| Shot::still(*image)).chain(clean).collect();
        let ran = match self.lab.run(bench, (self.subject, graph), size, &shots, true) {
            Ok(ran) => ran,
            Err(why) => {
                self.count(sets, size, images[0].name, vec![why]);
                return None;
            }
        };
        let promises = Promises::of(graph);
        let signed =
            promises.negative || graph.inputs.iter().any(|input| input.signed && input.state != ColorState::Data);
        for (index, image) in images.iter().enumerate() {
            let mut wrong = Vec::new();
            for shown in &ran.frames[index] {
                wrong.extend(judge(shown, signed));
                for (promise, broken) in promised(shown, *image, size, &promises) {
                    self.tally.judged(promise);
                    wrong.extend(broken);
                }
            }
            if let Some(clean) = guarded.iter().position(|guarded| *guarded == index) {
                self.tally.judged("no poison in space");
                wrong.extend(poison(&ran.frames[index], &ran.frames[images.len() + clean]));
            }
            self.count(sets, size, image.name, wrong);
        }
        Some(ran)
    }

    /// A node that is left out because it changes nothing must change nothing when it does run. What gives no negative light takes it
    /// away where it runs; left out it does not.
    fn identity(&mut self, bench: &mut Bench, skipped: &Ran, sets: &Sets, size: Size, images: &[Extreme]) {
        let Some(graph) = self.subject.forced(self.registry, sets) else { return };
        let shots: Vec<Shot> = images.iter().map(|image| Shot::still(*image)).collect();
        let ran = match self.lab.run(bench, (self.subject, &graph), size, &shots, true) {
            Ok(ran) if !ran.skipped.iter().any(|node| node == NODE) => ran,
            _ => return,
        };
        let cuts = self.subject.signed && !Promises::of(&graph).negative;
        let wanted = |out: &Shown| if cuts { without_negatives(out) } else { out.clone() };
        for (index, image) in images.iter().enumerate() {
            let pairs = skipped.frames[index]
                .iter()
                .filter_map(|out| Some((named(&ran.frames[index], &out.name)?, wanted(out))));
            let wrong = pairs.filter_map(|(ran, out)| {
                let ran = if cuts { without_negatives(ran) } else { ran.clone() };
                different(&ran, &out, Tolerance::HALF)
            });
            let wrong = wrong.map(|what| format!("left out as an identity, yet it gives {what}")).collect();
            self.tally.judged("neutral");
            self.count(sets, size, image.name, wrong);
        }
    }
}

fn without_negatives(shown: &Shown) -> Shown {
    let mut shown = shown.clone();
    shown.pixels.iter_mut().flat_map(|pixel| &mut pixel[..3]).for_each(|x| *x = x.max(0.0));
    shown
}

/// Where outside numbers show that the guard should have taken out.
fn poison(frame: &[Shown], clean: &[Shown]) -> Option<String> {
    let pairs = frame.iter().zip(clean).filter(|(shown, _)| finite(shown).is_none());
    let mut spread = pairs.filter_map(|(shown, clean)| different(shown, clean, Tolerance::NONE));
    spread.next().map(|what| format!("poison spreads: {what} without it"))
}

fn named<'s>(frame: &'s [Shown], name: &str) -> Option<&'s Shown> {
    frame.iter().find(|shown| shown.name == name)
}

/// What is wrong with any picture by itself.
pub(crate) fn judge(shown: &Shown, may_be_negative: bool) -> Vec<String> {
    finite(shown).into_iter().chain(in_range(shown, may_be_negative)).collect()
}
