//! The law that all variants of a plan give the same output: dispatched and drawn, fused and not.

use afterimage_graph::image::{ColorState, Size};
use afterimage_plan::{Alias, Caps, Options};

use super::case_runner::{CaseRunner, judge};
use super::images::Extreme;
use super::laws::{Tolerance, different, invariants};
use super::render::{Configuration, RenderRequest, Rendered, StressFrame};
use super::settings::Change;
use super::target::Overrides;

/// A variant of plans, by what it changes.
struct PlanVariant {
    name: &'static str,
    change: fn(&mut Caps, &mut Options),
}

const VARIANTS: [PlanVariant; 4] = [
    PlanVariant { name: "when drawn", change: |caps, _| caps.prefer_fragment = true },
    PlanVariant { name: "with fast workgroup memory", change: |caps, _| caps.fast_workgroup_memory = true },
    PlanVariant { name: "when not fused", change: |_, options| options.fuse = false },
    PlanVariant { name: "with memory of its own for each image", change: |_, options| options.alias = Alias::None },
];

/// Images with all magnitudes and edges.
const IMAGES: [&str; 4] = ["nan", "edge", "ramp", "primaries"];
/// Odd sides, whose halves do not cover them exactly, and one pixel, where every tap is at the edge.
const SIZES: [(u32, u32); 2] = [(37, 23), (1, 1)];

/// Intermediates are in 32 bits, so differences come from 32-bit rounding; an encoded output may differ by one code.
fn tolerance(state: ColorState) -> Tolerance {
    let code = 1.01 / 255.0;
    Tolerance { relative: 2e-3, absolute: if state == ColorState::Encoded { code } else { 1e-3 } }
}

/// Compares all variants at the defaults and at every choice and integer: these change the shaders.
pub(crate) fn compare(runner: &mut CaseRunner<'_>, changes: &[Change]) {
    let images: Vec<Extreme> =
        IMAGES.iter().filter(|name| runner.options.accepts(name)).filter_map(|n| Extreme::named(n)).collect();
    if images.is_empty() {
        return;
    }
    let exactly = |change: fn(&mut Caps, &mut Options)| {
        move |caps: &mut Caps, options: &mut Options| {
            *options = Options { exact: true, ..*options };
            change(caps, options);
        }
    };
    let mut plain = runner.renderer.configure(exactly(|_, _| {}), false);
    let mut others: Vec<(&'static str, Configuration)> = VARIANTS
        .iter()
        .filter(|variant| runner.options.includes(runner.target, variant.name))
        .map(|variant| (variant.name, runner.renderer.configure(exactly(variant.change), false)))
        .collect();
    if others.is_empty() {
        return;
    }
    let sizes = match (runner.options.size, runner.options.quick) {
        (Some((width, height)), _) => vec![Size::new(width, height)],
        (None, quick) => SIZES.iter().take(if quick { 1 } else { 2 }).map(|(w, h)| Size::new(*w, *h)).collect(),
    };
    let only_defaults = runner.options.quick || runner.is_heavy;
    let is_chosen = |change: &&Change| is_compiled(change) && (change.overrides.is_empty() || !only_defaults);
    for change in changes.iter().filter(is_chosen) {
        for size in &sizes {
            one(runner, &mut plain, &mut others, &change.overrides, *size, &images);
        }
    }
}

/// True if a change can change shaders: names, integers and flags can, fractions only change uniforms.
fn is_compiled(change: &Change) -> bool {
    change.is_single && change.overrides.iter().all(|(_, value)| !value.contains('.'))
}

fn one(
    runner: &mut CaseRunner<'_>,
    plain: &mut Configuration,
    others: &mut [(&'static str, Configuration)],
    overrides: &Overrides,
    size: Size,
    images: &[Extreme],
) {
    let Ok(graph) = runner.target.graph(overrides) else { return };
    let inputs: Vec<StressFrame> = images.iter().map(|image| StressFrame::still(*image)).collect();
    let request = RenderRequest { target: runner.target, graph: &graph, size, inputs: &inputs, together: true };
    // The still images have already reported a failure of the first variant.
    let Ok(expected) = runner.renderer.run(plain, request) else { return };
    // 32-bit outputs show values that a half float cannot hold; some devices round those to the largest half float.
    let non_negative = invariants(&graph).non_negative;
    let mut wrong: Vec<Vec<String>> = expected
        .frames
        .iter()
        .map(|frame| frame.iter().flat_map(|shown| judge(shown, non_negative)).collect())
        .collect();
    for (name, configuration) in others.iter_mut() {
        match runner.renderer.run(configuration, request) {
            Ok(ran) => {
                images.iter().for_each(|_| runner.results.judged(name));
                differences(&ran, &expected).for_each(|(index, what)| wrong[index].push(format!("{name}: {what}")))
            }
            Err(why) => wrong[0].push(format!("{name}: {why}")),
        }
    }
    for (image, wrong) in images.iter().zip(wrong) {
        runner.count(overrides, size, image.name, wrong);
    }
}

/// The first difference of each output of each frame.
fn differences<'r>(ran: &'r Rendered, expected: &'r Rendered) -> impl Iterator<Item = (usize, String)> + 'r {
    ran.frames.iter().zip(&expected.frames).enumerate().flat_map(|(index, (frame, expected))| {
        let pairs = frame.iter().zip(expected);
        pairs.filter_map(move |(a, b)| Some((index, different(a, b, tolerance(a.state).leaking(a))?)))
    })
}
