//! Plans against an interpreter that knows nothing of the planner: whatever is fused, ordered, batched or laid over
//! other images, the terms of the outputs are those of the plan that does nothing of it. And `verify` finds every
//! change of a plan that the interpreter notices.

use std::fmt::Write as _;

use afterimage_generators::{Recipe, Rng, hold_some};
use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::{Pass, WarpPart};
use afterimage_plan::{Alias, Caps, Options, Plan, Refresh, When, verify};

use super::fusion::planned_at;
use super::machine::Machine;
use super::support::{all_formats, built_in, checked, plan_at, plan_images, plan_on};

/// More than any history reaches back.
const FRAMES: usize = 5;

/// As recorded: a dispatch for each pass, and memory for each image.
pub const PLAIN: Options = Options {
    fuse: false,
    row_downsample: When::Never,
    alias: Alias::None,
    repeatable: false,
    serial: true,
    exact: false,
    batches_first: false,
    bounds_checks: false,
    bake: None,
    count_faults: false,
    one_frame: false,
};

/// Every way in which a plan differs from it.
pub fn variants() -> [(&'static str, Options); 8] {
    let default = Options::default();
    [
        ("default", default),
        ("unfused", Options { fuse: false, ..default }),
        ("pool", Options { alias: Alias::Pool, ..default }),
        ("none", Options { alias: Alias::None, ..default }),
        ("serial", Options { serial: true, ..default }),
        ("batches first", Options { batches_first: true, ..default }),
        ("always", Options { row_downsample: When::Always, ..default }),
        ("rows alone", Options { fuse: false, row_downsample: When::Always, ..default }),
    ]
}

#[track_caller]
pub fn assert_computes_the_same(plan: &Plan, plain: &Plan, what: &str) {
    let [shown, wanted] = [plan, plain].map(|plan| Machine::frames(plan, FRAMES));
    let wanted = wanted.unwrap_or_else(|fault| panic!("{what}, as recorded: {fault}"));
    let shown = shown.unwrap_or_else(|fault| panic!("{what}: {fault}\n{}", plan.to_text()));
    assert_eq!(shown, wanted, "{what}:\n{}", plan.to_text());
}

#[test]
fn every_way_to_run_a_random_graph_computes_the_same() {
    for seed in 0..40 {
        let graph = Recipe { seed, nodes: 10 + seed as usize, histories: 3, off: 8 }.graph();
        let size = Size::new(640, 360);
        let plain = plan_at(&graph, size, PLAIN).expect("the graph can be planned");
        for (name, options) in variants() {
            let plan = plan_at(&graph, size, options).expect("the graph can be planned");
            assert_computes_the_same(&plan, &plain, &format!("graph {seed}, {name}"));
        }
        let drawn = Caps { prefer_fragment: true, ..Caps::default() };
        let plan = plan_on(&graph, size, Options::default(), drawn).expect("the graph can be planned");
        assert_computes_the_same(&plan, &plain, &format!("graph {seed}, drawn"));
    }
}

/// Whatever is fused, cached results are computed in the same frames, and from the same.
#[test]
fn cached_results_are_the_same_in_every_way() {
    let (mut cached, mut spared) = (0, 0);
    for seed in 0..40 {
        let mut graph = Recipe { seed, nodes: 10 + seed as usize, histories: 3, off: 8 }.graph();
        hold_some(&mut graph, seed);
        let size = Size::new(640, 360);
        let plain = plan_at(&graph, size, PLAIN).expect("the graph can be planned");
        cached += plain.savings.cached.iter().filter(|cached| !cached.results.is_empty()).count();
        spared += plain.passes.iter().filter(|pass| !pass.refresh.contains(&Refresh::EachFrame)).count();
        let film = |plan: &Plan| Machine::frames(plan, 9).unwrap_or_else(|fault| panic!("{fault}: {}", plan.to_text()));
        let wanted = film(&plain);
        for (name, options) in variants() {
            let plan = plan_at(&graph, size, options).expect("the graph can be planned");
            assert_eq!(verify(&plan), Ok(()), "graph {seed}, {name}: {}", plan.to_text());
            assert!(film(&plan) == wanted, "graph {seed}, {name}: {}", plan.to_text());
        }
    }
    assert!(cached > 100 && spared > cached, "{cached} nodes are cached, and {spared} passes run in some frames only");
}

/// A cached result equals, in each frame, what the pipeline without the cache had in the last frame that was due.
#[test]
fn a_cached_result_is_that_of_the_last_frame_that_was_due() {
    let text = |every: &str| {
        format!(
            r#"Pipeline(inputs: {{ "picture": Color }}, nodes: {{ "mips": Downsample(source: "picture", levels: 3),
               "wide": Upsample(source: "mips"{every}), "out": Composite(base: "wide", bloom: "wide") }},
               outputs: {{ "out": "out" }})"#
        )
    };
    let plan = |every: &str| plan_at(&checked(&text(every)), Size::new(640, 360), Options::default());
    let [each, fourth] = ["", ", every: 4"].map(|every| plan(every).expect("it can be planned"));
    let [each, fourth] = [each, fourth].map(|plan| Machine::frames(&plan, 12).expect("it runs"));
    for frame in 0..12 {
        assert_eq!(fourth[frame], each[frame / 4 * 4], "frame {frame}");
    }
}

/// Whether a frame runs the node depends on no earlier ones but the one before, in whatever steps numbers go.
#[test]
fn a_frame_is_due_once_in_so_many_numbers() {
    for (every, phase) in [(2, 0), (2, 1), (4, 3), (16, 5)] {
        let refresh = Refresh::Every { every, phase };
        for number in (1..100).chain(0xff_ffff..0x100_0040).chain(u32::MAX - 40..=u32::MAX) {
            assert_eq!(refresh.is_due(number, number - 1), number % every == phase, "{refresh:?} {number}");
            assert!(refresh.is_due(number, number.wrapping_sub(every)), "{refresh:?} {number}: a step over all");
            assert!(!refresh.is_due(number, number), "{refresh:?} {number}: the same frame again");
        }
        assert!(refresh.is_due(0, u32::MAX), "{refresh:?}: the count begins again");
    }
}

/// A random pipeline of kinds that become every kind of pass: its nodes and its outputs.
pub fn blurs(seed: u64) -> (String, String) {
    let mut rng = Rng::new(seed);
    // Names of images and how often each was halved.
    let mut images = vec![("in".to_owned(), 0)];
    let (mut nodes, mut outputs) = (String::new(), String::new());
    for at in 0..6 + rng.below(12) {
        let oldest = images.len().saturating_sub(3);
        let (source, level) = images[oldest + rng.below(images.len() - oldest)].clone();
        let other = images[rng.below(images.len())].clone();
        let alike: Vec<&(String, u32)> = images.iter().filter(|(_, of)| *of == level).collect();
        let beside = alike[rng.below(alike.len())].0.clone();
        let levels = 1 + rng.below(3) as u32;
        let sigma = [0.4, 1.0, 3.0][rng.below(3)];
        let (text, name, level) = match rng.below(20) {
            0..3 => (format!("Soft(source: \"{source}\")"), format!("n{at}"), level),
            3 => (format!("Far(source: \"{source}\")"), format!("n{at}"), level),
            4 | 5 => (format!("Dim(source: \"{source}\")"), format!("n{at}"), level),
            6 => (format!("Beside(source: \"{source}\", other: \"{beside}\")"), format!("n{at}"), level),
            7 => (format!("Gaussian(source: \"{source}\", sigma: {sigma:?})"), format!("n{at}"), level),
            8 | 9 if level < 3 => {
                let text = format!("Downsample(source: \"{source}\", levels: {levels})");
                (text, format!("n{at}.coarsest"), level + levels)
            }
            10 if level < 3 => {
                write!(nodes, "\"p{at}\": Downsample(source: \"{source}\", levels: {levels}), ").expect("it grows");
                (format!("Upsample(source: \"p{at}\")"), format!("n{at}"), level + 1)
            }
            11 => {
                let past = if other.0 == "in" { "in".to_owned() } else { format!("{}@previous", other.0) };
                (format!("Composite(base: \"{source}\", bloom: \"{past}\")"), format!("n{at}"), level)
            }
            12 | 18 => {
                let [width, height] = [[16, 8], [32, 16]][rng.below(2)];
                let cells = format!("width: {width}, height: {height}, sigma: 0.0");
                write!(nodes, "\"m{at}\": LogGaussian(source: \"{source}\", {cells}), ").expect("it grows");
                write!(outputs, "\"m{at}\": \"m{at}\", ").expect("it grows");
                (format!("Dim(source: \"{source}\")"), format!("n{at}"), level)
            }
            13 => (format!("Late(source: \"{source}\")"), format!("n{at}"), level),
            14 => (format!("LensDistortion(source: \"{source}\")"), format!("n{at}"), level),
            16 | 17 => {
                let before = ["", ", before: \"n@previous\""][rng.below(2)].replace('n', &format!("n{at}.peaks"));
                (format!("Extract(source: \"{source}\", fireflies: Limit{before})"), format!("n{at}"), level)
            }
            15 => (format!("ChromaticAberration(source: \"{source}\")"), format!("n{at}"), level),
            _ => (format!("Composite(base: \"{source}\", bloom: \"{}\")", other.0), format!("n{at}"), level),
        };
        write!(nodes, "\"n{at}\": {text}, ").expect("it grows");
        images.push((name, level));
    }
    for (name, _) in images.iter().skip(1).step_by(5).chain(images.last()) {
        let output = name.replace('.', "_");
        if !outputs.contains(&format!("\"{output}\"")) {
            write!(outputs, "\"{output}\": \"{name}\", ").expect("it grows");
        }
    }
    (nodes, outputs)
}

#[test]
fn downsampling_by_rows_and_fused_warps_compute_what_single_passes_do() {
    let (mut kinds, mut warps) = (std::collections::HashSet::new(), 0);
    for seed in 0..60 {
        let (nodes, outputs) = blurs(seed);
        for size in [Size::new(97, 61), Size::new(640, 384), Size::new(2560, 1440)] {
            let plain = planned_at(size, &nodes, &outputs, PLAIN);
            for (name, options) in variants() {
                let plan = planned_at(size, &nodes, &outputs, options);
                assert_computes_the_same(&plan, &plain, &format!("pipeline {seed} at {size}, {name}: {nodes}"));
                kinds.extend(plan.work().map(|pass| std::mem::discriminant(&pass.kind)));
                let taps = |pass: &Pass| pass.kernels.iter().filter(|k| k.warp == Some(WarpPart::Place)).count();
                warps += plan.work().filter(|pass| taps(pass) > 1 && pass.nodes.len() > 1).count();
            }
        }
    }
    assert_eq!(kinds.len(), 4, "every kind of pass occurs");
    assert!(warps > 20, "{warps} passes are several warps");
}

#[test]
fn the_built_in_pipelines_compute_what_single_passes_do() {
    for name in ["caracal", "exposure", "glare", "grade", "hdr", "lynx", "tsushima", "tsushima-night"] {
        let graph = built_in(&format!("{name}.ron"));
        for fast_workgroup_memory in [false, true] {
            let caps = Caps { fast_workgroup_memory, ..all_formats() };
            let plan = |options| plan_images(&graph, Format::Rgba16Float, Facts::default(), caps.clone(), options);
            for (way, options) in variants() {
                assert_computes_the_same(&plan(options), &plan(PLAIN), &format!("{name}, {way}"));
            }
        }
    }
}

/// Changes one thing of a plan that matters to a device. What was changed; `None` if there is no such thing.
pub fn change(plan: &mut Plan, rng: &mut Rng) -> Option<&'static str> {
    let batches = plan.batches.len();
    let (passes, images) = (plan.passes.len(), plan.images.len());
    let batch = rng.below(batches);
    match rng.below(9) {
        0 => {
            plan.passes.swap(rng.below(passes), rng.below(passes));
            Some("two passes are exchanged")
        }
        1 => {
            let transitions = &mut plan.batches[batch].transitions;
            let at = rng.below(transitions.len());
            (at < transitions.len()).then(|| transitions.remove(at)).map(|_| "a transition is missing")
        }
        2 => {
            let aliasing = &mut plan.batches[batch].aliasing;
            let at = rng.below(aliasing.len());
            (at < aliasing.len()).then(|| aliasing.remove(at)).map(|_| "an aliasing barrier is missing")
        }
        3 => {
            let barrier = rng.below(plan.batches[batch].aliasing.len());
            let owners = &mut plan.batches[batch].aliasing.get_mut(barrier)?.owners;
            owners.remove(rng.below(owners.len()));
            Some("an owner is missing")
        }
        4 | 5 => {
            let [one, other] = [rng.below(images), rng.below(images)];
            let (offset, slot) = (plan.images[other].offset?, plan.images[other].slot?);
            plan.images[one].offset.as_mut().map(|old| *old = offset)?;
            plan.images[one].slot = Some(slot);
            Some("two images share a place")
        }
        6 => {
            let image = rng.below(images);
            let offset = plan.images[image].offset.as_mut()?;
            *offset = offset.saturating_add(1 << 16);
            Some("an image is moved up")
        }
        7 => {
            let next = plan.batches.get(batch + 1)?.passes.start;
            plan.batches[batch].passes.end = next + 1;
            plan.batches[batch + 1].passes.start = next + 1;
            Some("a pass runs a batch earlier")
        }
        _ => {
            plan.exports.remove(rng.below(plan.exports.len()));
            Some("an export is missing")
        }
    }
}

#[test]
fn verify_finds_what_the_interpreter_notices() {
    let (mut noticed, mut rng) = (std::collections::BTreeMap::<&str, usize>::new(), Rng::new(1));
    for seed in 0..50 {
        let graph = Recipe { seed, nodes: 16, histories: 2, off: 0 }.graph();
        for (name, options) in variants() {
            let plan = plan_at(&graph, Size::new(640, 360), options).expect("the graph can be planned");
            let wanted = Machine::frames(&plan, 3);
            for _ in 0..12 {
                let mut changed = plan.clone();
                let Some(what) = change(&mut changed, &mut rng) else { continue };
                if Machine::frames(&changed, 3) == wanted {
                    continue;
                }
                *noticed.entry(what).or_default() += 1;
                assert!(verify(&changed).is_err(), "graph {seed}, {name}: {what}:\n{}", changed.to_text());
            }
        }
    }
    assert!(noticed.len() == 8 && noticed.values().all(|count| *count >= 20), "{noticed:?}");
}

/// Where the module of a pass has the members of its uniform.
fn members(module: &naga::Module) -> Vec<(String, usize)> {
    let of_pass = |ty: &naga::Type| match &ty.inner {
        naga::TypeInner::Struct { members, .. } if ty.name.as_deref() == Some("PassUniform") => Some(members.clone()),
        _ => None,
    };
    let members = module.types.iter().find_map(|(_, ty)| of_pass(ty)).unwrap_or_default();
    members.into_iter().map(|member| (member.name.unwrap_or_default(), member.offset as usize)).collect()
}

/// The bytes of the one uniform buffer are where the modules look for them, and the size of the result beside them.
#[test]
fn the_numbers_of_each_kernel_are_where_its_module_reads_them() {
    let mut kernels = 0;
    for name in ["lynx.ron", "glare.ron", "tsushima.ron"] {
        let caps = Caps { fast_workgroup_memory: true, ..all_formats() };
        let options = Options { row_downsample: When::Always, ..Options::default() };
        let plan = plan_images(&built_in(name), Format::Rgba16Float, Facts::default(), caps, options);
        let buffer = plan.uniform_buffer();
        for (index, planned) in plan.passes.iter().enumerate() {
            let (uniform, pass) = (&planned.uniform, &planned.pass);
            let module = plan.compose(index, Default::default()).expect("a module").validate().expect("a valid module");
            for (member, offset) in members(&module) {
                let at = &buffer[uniform.offset as usize + offset..];
                let number = member.strip_prefix("kernel").and_then(|number| number.parse::<usize>().ok());
                let kernel = &pass.kernels[number.unwrap_or_else(|| panic!("a member is called {member}"))];
                assert_eq!(at[..kernel.uniform.len()], kernel.uniform, "{name}: {}: {member}", pass.label);
                kernels += 1;
            }
            let extent = &buffer[uniform.extent_offset as usize..][..8];
            let size = pass.written_image().map(|image| plan.image(image).desc.size);
            let wanted = size.map_or([1.0; 2], |size| [size.width as f32, size.height as f32]);
            assert_eq!(extent, wanted.map(f32::to_le_bytes).as_flattened(), "{name}: {}", pass.label);
            assert!(uniform.offset.is_multiple_of(256) && uniform.extent_offset.is_multiple_of(256));
        }
    }
    assert!(kernels > 20, "{kernels} uniforms");
}
