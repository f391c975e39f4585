//! `afterimage tune`: the choice of switches that suits a budget or an error best.

mod search;
mod space;
mod state;
mod write;

use afterimage_gpu::Gpu;
use afterimage_graph::check::Graph;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::Options;
use indicatif::ProgressBar;

use super::args::TuneArgs;
use super::clips::{self, Clip};
use super::judge::{self, Truth};
use super::runner::Runner;
use super::variants::{changes, most_exact};
use super::view::View;
use super::{load, progress};
use crate::args::PipelineOptions;
use crate::failure::Failure;
use crate::pipeline::{check_file, facts, load_graph, registry};
use crate::session::{open, options_on};
use crate::terminal::{note, say};
use afterimage_media::write_atomic;
use search::search;
pub(crate) use search::{Goal, Measured};
use space::Space;
use state::SearchState;

pub(crate) fn run(args: &TuneArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let goal = Goal::of(&args.goal);
    let material = &args.material;
    let registry = registry(tables, &material.options.nodes)?;
    let written = load_graph(&args.pipeline, &registry, &material.options)?;
    let plain = without_changes(args, &registry, &written)?;
    write::check_name(args, &registry)?;
    let gpu = open(&material.device)?;
    let options = options_on(&gpu, Options::default(), &material.device.arithmetic);
    let runner = Runner::new(&gpu, facts(&material.options)?, options, material.repeats);
    let mut bench = Bench::prepare(args, &gpu, &registry, &written, runner)?;
    let space = bench.space(&written)?;
    let mut state = SearchState::open(args.state.as_deref(), bench.problem(args, &space)?)?;
    let bar = progress(0);
    let found = search(&space, goal, &mut |choice| bench.measured(&space, choice, &mut state, &bar));
    bar.finish_and_clear();
    let (choice, measured) = found?;
    if !goal.is_met(&measured) {
        return Err(unreachable_goal(goal, &measured));
    }
    let tuned = space.graph(&written, &choice);
    let tier = write::Tier { entries: changes(&plain, &tuned), measured, bench: bench.words() };
    let text = write::text(args, &registry, &tier)?;
    match &args.out {
        Some(path) => write_atomic(path, text.as_bytes())?,
        None => say(&text),
    }
    note(&format!("{}; {} pipelines were measured", tier.figures(), state.len()));
    Ok(())
}

/// The pipeline as its file is, which the new tier stands on: what `--tier` and `--set` change becomes part of the new tier.
fn without_changes(args: &TuneArgs, registry: &Registry, written: &Graph) -> Result<Graph, Failure> {
    let options = PipelineOptions { tier: None, sets: Vec::new(), ..args.material.options.clone() };
    let (plain, _) = check_file(&args.pipeline, registry, &options)?;
    let frame = |graph: &Graph| -> Vec<_> {
        graph.nodes.iter().map(|node| (node.name.clone(), node.kind.name().to_owned(), node.wires.clone())).collect()
    };
    if frame(&plain) == frame(written) {
        return Ok(plain);
    }
    let tier = args.material.options.tier.as_deref().unwrap_or_default();
    Err(Failure::user(format!("the tier `{tier}` is another pipeline, not a choice of numbers"))
        .hint("tune the file that the tier names"))
}

fn unreachable_goal(goal: Goal, best: &Measured) -> Failure {
    let reached = format!("the closest found takes {:.3} ms and is {:.3} codes off", best.ms, best.p999);
    let failure = Failure::user(format!("no choice of the quality switches stays {goal}: {reached}"));
    failure.hint(match goal {
        Goal::Budget(_) => "allow more time, or change what the pipeline does: fewer levels, a smaller picture",
        Goal::Error(_) => "allow more error; what is left comes from intermediates of half floats",
    })
}

/// What errors are measured against: `--set` asks for another look, but a tier is a compromise, and what it leaves out is missing.
fn ideal(args: &TuneArgs, registry: &Registry) -> Result<Graph, Failure> {
    let options = PipelineOptions { tier: None, ..args.material.options.clone() };
    Ok(check_file(&args.pipeline, registry, &options)?.0)
}

/// All clips with their truths, ready for one candidate after the other.
struct Bench<'a> {
    runner: Runner<'a>,
    written: &'a Graph,
    view: View,
    clips: Vec<(Clip, Truth)>,
    /// What the truths were made by, one for each clip.
    truths: Vec<String>,
    adapter: String,
}

impl<'a> Bench<'a> {
    fn prepare(
        args: &TuneArgs,
        gpu: &'a Gpu,
        registry: &Registry,
        written: &'a Graph,
        mut runner: Runner<'a>,
    ) -> Result<Self, Failure> {
        let output = judge::output(written, args.material.output.as_deref())?;
        let view = View::of(written, output)?;
        let exact = most_exact(&ideal(args, registry)?)?;
        let mut truths = Vec::new();
        let mut ready = Vec::new();
        for source in clips::sources(&args.material, written)? {
            let clip = load(&source, gpu, registry, &runner, written, &args.material)?;
            let plan = runner.plan(&judge::judged(&exact, &output.name), &clip, true)?;
            truths.push(plan.hash().to_string());
            runner.load(plan)?;
            let truth = Truth::render(&mut runner, &clip, view, &output.name)?;
            ready.push((clip, truth));
        }
        Ok(Self { runner, written, view, clips: ready, truths, adapter: gpu.name() })
    }

    fn space(&self, written: &Graph) -> Result<Space, Failure> {
        let clip = &self.clips[0].0;
        Space::new(written, &|graph| self.runner.plan(graph, clip, false))
    }

    /// What figures are good for: they cannot be used for another problem.
    fn problem(&self, args: &TuneArgs, space: &Space) -> Result<serde_json::Value, Failure> {
        let mut clips = Vec::new();
        for (clip, truth) in &self.clips {
            let plan = self.runner.plan(&space.graph(self.written, &space.exact()), clip, false)?;
            clips.push(serde_json::json!({ "image": clip.name, "frames": truth.frames.len(), "plan": plan.hash().to_string() }));
        }
        Ok(serde_json::json!({
            "adapter": self.adapter,
            "clock": self.runner.watch().name(),
            "switches": space.names(),
            "facts": args.material.options.facts,
            "images": clips,
            "truths": self.truths,
        }))
    }

    /// The figures of a choice, measured unless they are known.
    fn measured(
        &mut self,
        space: &Space,
        choice: &[usize],
        state: &mut SearchState,
        bar: &ProgressBar,
    ) -> Result<Measured, Failure> {
        let name = space.key(choice);
        if let Some(known) = state.get(&name) {
            return Ok(known);
        }
        bar.set_message(name.clone());
        let graph = space.graph(self.written, choice);
        let mut worst: Option<Measured> = None;
        for (clip, truth) in &self.clips {
            self.runner.load(self.runner.plan(&judge::judged(&graph, truth.output()), clip, false)?)?;
            let (p999, max) = truth.codes_off(&mut self.runner, clip, self.view)?;
            self.runner.load(self.runner.plan(&graph, clip, false)?)?;
            let cost = self.runner.cost(clip)?;
            let here = Measured { ms: cost.ms, p999, max, bytes: cost.bytes };
            worst = Some(worst.map_or(here, |worst| worst.worst(here)));
        }
        let measured = worst.expect("there is at least one clip");
        state.insert(name, measured)?;
        bar.inc_length(1);
        bar.inc(1);
        Ok(measured)
    }

    /// Where and on what it was measured.
    fn words(&self) -> String {
        let clock = if self.runner.watch() == super::runner::Watch::Gpu { "GPU time" } else { "host time" };
        let images: Vec<String> =
            self.clips.iter().map(|(clip, _)| format!("{} at {}", clip.name, clip.size)).collect();
        format!("{clock} on {}; worst of: {}", self.adapter, images.join(", "))
    }
}
