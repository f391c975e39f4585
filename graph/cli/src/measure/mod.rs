//! `afterimage measure`: what each quality switch of a pipeline costs and what it saves. `afterimage tune`: the best choice of them.
//!
//! Everything is derived from the table of node kinds: the truth, the switches, the variants. Plug-ins are measured like all others.

pub(crate) mod args;
mod book;
mod clips;
mod csv;
mod errors;
mod heat;
mod json;
mod judge;
pub(crate) mod plot;
mod report;
mod runner;
mod table;
pub(crate) mod tune;
mod variants;
mod view;

use std::path::Path;

use afterimage_gpu::Gpu;
use afterimage_graph::check::Graph;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::{Options, Plan};
use indicatif::{ProgressBar, ProgressStyle};

use crate::failure::Failure;
use crate::pipeline::{facts, load_graph, registry};
use crate::session::{open, options_on};
use crate::terminal::say;
use afterimage_media::write_atomic;
use args::{Material, MeasureArgs};
use clips::{Clip, ClipSource};
use errors::Errors;
use judge::{Figures, Truth};
use report::{ClipInfo, Report, Row};
use runner::Runner;
use variants::{Variant, VariantKind, variants};
use view::View;

pub(crate) fn run(args: &MeasureArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    args.plot.iter().try_for_each(|path| plot::check_name(path))?;
    if let Some(folder) = &args.error_image {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::machine(format!("cannot make the folder `{}`: {error}", folder.display())))?;
    }
    let registry = registry(tables, &args.material.options.nodes)?;
    let gpu = open(&args.material.device)?;
    if let Some(folder) = &args.docs {
        return book::write(folder, args, &gpu, &registry);
    }
    let report = report(args, &args.pipeline, &gpu, &registry)?;
    say(&table::table(&report));
    write(args, &report)
}

/// All variants of a pipeline on all images.
fn report(args: &MeasureArgs, pipeline: &Path, gpu: &Gpu, registry: &Registry) -> Result<Report, Failure> {
    let material = &args.material;
    let written = load_graph(pipeline, registry, &material.options)?;
    let mut all = variants(pipeline, registry, &material.options, &written)?;
    if args.tiers {
        all.retain(|variant| !matches!(variant.kind, VariantKind::Switch | VariantKind::Format));
    }
    let sources = clips::sources(material, &written)?;
    let options = options_on(gpu, Options::default(), &material.device.arithmetic);
    let runner = Runner::new(gpu, facts(&material.options)?, options, material.repeats);
    Work { gpu, registry, args, pipeline, written: &written, runner }.measure(all, &sources)
}

fn write(args: &MeasureArgs, report: &Report) -> Result<(), Failure> {
    if let Some(path) = &args.json {
        write_atomic(path, format!("{:#}\n", json::json(report)).as_bytes())?;
    }
    if let Some(path) = &args.csv {
        write_atomic(path, csv::csv(report).as_bytes())?;
    }
    args.plot.iter().try_for_each(|path| plot::write(path, report))
}

/// What a measurement needs throughout.
struct Work<'a> {
    gpu: &'a Gpu,
    registry: &'a Registry,
    args: &'a MeasureArgs,
    pipeline: &'a Path,
    written: &'a Graph,
    runner: Runner<'a>,
}

impl Work<'_> {
    fn measure(&mut self, all: Vec<Variant>, sources: &[ClipSource]) -> Result<Report, Failure> {
        let material = &self.args.material;
        let output = judge::output(self.written, material.output.as_deref())?;
        let view = View::of(self.written, output)?;
        let mut chosen: Option<(Vec<Variant>, Vec<String>)> = None;
        let mut rows: Vec<Row> = Vec::new();
        let mut infos = Vec::new();
        let bar = progress(2 * (all.len() * sources.len()) as u64);
        for source in sources {
            let clip = load(source, self.gpu, self.registry, &self.runner, self.written, material)?;
            infos.push(info(&clip));
            if chosen.is_none() {
                let (with_effect, without) = with_effect(&all, &self.runner, &clip)?;
                rows = with_effect.iter().map(|variant| Row::new(&variant.name, variant.kind)).collect();
                bar.set_length(2 * (with_effect.len() * sources.len()) as u64);
                chosen = Some((with_effect, without));
            }
            let (variants, _) = chosen.as_ref().expect("chosen above");
            self.clip(variants, &clip, view, &output.name, &mut rows, &bar)?;
        }
        bar.finish_and_clear();
        let mut report = Report {
            pipeline: self.pipeline.to_string_lossy().into_owned(),
            output: output.name.clone(),
            range: view.range(),
            adapter: self.gpu.name(),
            watch: self.runner.watch(),
            repeats: self.runner.repeats(),
            clips: infos,
            rows,
            without_effect: chosen.map(|(_, without)| without).unwrap_or_default(),
        };
        report.mark_pareto();
        Ok(report)
    }

    /// All variants on one clip; the first is the truth. Times come last, one after the other, so that the GPU stays awake between them.
    fn clip(
        &mut self,
        variants: &[Variant],
        clip: &Clip,
        view: View,
        output: &str,
        rows: &mut [Row],
        bar: &ProgressBar,
    ) -> Result<(), Failure> {
        let mut truth: Option<Truth> = None;
        let mut errors = Vec::new();
        for variant in variants {
            bar.set_message(format!("{}: errors of {}", clip.name, variant.name));
            self.runner.load(self.runner.plan(&judge::judged(&variant.graph, output), clip, variant.is_exact())?)?;
            errors.push(match &truth {
                Some(truth) => self.errors(truth, variant, clip, view)?,
                None => {
                    truth = Some(Truth::render(&mut self.runner, clip, view, output)?);
                    Errors::none(clip.len())
                }
            });
            bar.inc(1);
        }
        for ((variant, row), errors) in variants.iter().zip(rows).zip(errors) {
            bar.set_message(format!("{}: time of {}", clip.name, variant.name));
            self.runner.load(self.runner.plan(&variant.graph, clip, variant.is_exact())?)?;
            row.clips.push(Figures { cost: self.runner.cost(clip)?, errors });
            bar.inc(1);
        }
        Ok(())
    }

    fn errors(&mut self, truth: &Truth, variant: &Variant, clip: &Clip, view: View) -> Result<Errors, Failure> {
        let folder = self.args.error_image.as_deref();
        truth.errors(&mut self.runner, clip, view, |frame, shown| match folder {
            Some(folder) => {
                let number = if clip.len() > 1 { format!("-{frame:04}") } else { String::new() };
                let name = format!("{}{number}-{}.png", file_name(&clip.name), file_name(&variant.name));
                heat::write_heat(&folder.join(name), &truth.frames[frame], shown)
            }
            None => Ok(()),
        })
    }
}

/// Loads a clip; a still gets several frames if the pipeline remembers.
fn load(
    source: &ClipSource,
    gpu: &Gpu,
    registry: &Registry,
    runner: &Runner<'_>,
    graph: &Graph,
    material: &Material,
) -> Result<Clip, Failure> {
    let clip = source.load(gpu, registry, graph, material)?;
    let remembers = runner::remembers(&runner.plan(graph, &clip, false)?);
    if remembers && clip.len() == 1 { Ok(clip.standing(material)) } else { Ok(clip) }
}

fn info(clip: &Clip) -> ClipInfo {
    ClipInfo { name: clip.name.clone(), width: clip.size.width, height: clip.size.height, frames: clip.len() }
}

/// The variants that differ from the file as it is, and the names of the others.
fn with_effect(all: &[Variant], runner: &Runner<'_>, clip: &Clip) -> Result<(Vec<Variant>, Vec<String>), Failure> {
    let mut written: Option<Plan> = None;
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for variant in all {
        let is_switch = matches!(variant.kind, VariantKind::Switch | VariantKind::Format);
        let plan = runner.plan(&variant.graph, clip, variant.is_exact())?;
        if is_switch && written.as_ref().is_some_and(|written| runner::run_alike(written, &plan)) {
            without.push(variant.name.clone());
            continue;
        }
        with.push(variant.clone());
        if variant.kind == VariantKind::Written {
            written = Some(plan);
        }
    }
    Ok((with, without))
}

/// A name without what file systems mind.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || matches!(c, '.' | '-' | '=') { c } else { '-' }).collect()
}

fn progress(steps: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len}, {eta} left; {msg}");
    ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Whether a path ends so.
fn ends_with(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}
