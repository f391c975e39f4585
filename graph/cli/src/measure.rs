//! `afterimage measure`: time against error.

use std::path::{Path, PathBuf};

use afterimage_gpu::Gpu;
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_lab::measure::{self, ClipOptions, FigurePage, MeasureOptions, MeasureReport, Pipeline, write_chart};
use afterimage_lab::plot::is_chart;
use afterimage_media::write_atomic;
use afterimage_plan::Options;

use crate::args::PipelineOptions;
use crate::args::measure::{ClipArgs, MeasureArgs};
use crate::device::{open, options_on};
use crate::failure::Failure;
use crate::files::{Files, read_document, registry};
use crate::pipeline::{PipelineFile, assignments, facts};
use crate::progress::Bar;
use crate::terminal::{note, say_styled, visible};

pub(crate) fn run(args: &MeasureArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if let Some(path) = args.plot.iter().find(|path| !is_chart(path)) {
        return Err(Failure::user(format!("`--plot {}` ends neither in `.svg` nor in `.png`", path.display())));
    }
    let registry = registry(tables, &args.clips.options.kinds)?;
    let gpu = open(&args.clips.device)?;
    let mut options = measure_options(&args.clips, &gpu)?;
    options.tiers_only = args.tiers;
    options.error_images.clone_from(&args.error_image);
    if let Some(folder) = &args.docs {
        return page(folder, args, &gpu, &registry, &options);
    }
    let report = report(args, &args.pipeline, &gpu, &registry, &options)?;
    say_styled(&measure::table(&report));
    write(args, &report)
}

/// How a pipeline is measured, as the arguments of `measure` and `tune` say it.
pub(crate) fn measure_options(args: &ClipArgs, gpu: &Gpu) -> Result<MeasureOptions, Failure> {
    let inputs = assignments(&args.inputs, "--input")?;
    let clips = ClipOptions {
        images: args.images.clone(),
        inputs,
        scene: args.scene,
        size: Size::new(args.size.0, args.size.1),
        walk: args.walk,
        frames: args.frames.clone(),
        fps: args.fps,
        budget: args.decoding.budget(),
    };
    Ok(MeasureOptions {
        clips,
        facts: facts(&args.options)?,
        options: options_on(gpu, Options::default(), &args.device.arithmetic),
        samples: args.repeats,
        output: args.output.clone(),
        tiers_only: false,
        error_images: None,
    })
}

fn report(
    args: &MeasureArgs,
    path: &Path,
    gpu: &Gpu,
    registry: &Registry,
    options: &MeasureOptions,
) -> Result<MeasureReport, Failure> {
    let document = read_document(path)?;
    let files = Files::of(path, &args.clips.options.kinds);
    let file = PipelineFile::new(&document, registry, &files);
    let pipeline = &args.clips.options;
    args.json.iter().chain(&args.csv).chain(&args.plot).try_for_each(|out| files.refuse_output(out))?;
    let tiers = file.tiers().into_iter().map(|tier| {
        let graph = file.check(&PipelineOptions { tier: Some(tier.clone()), ..pipeline.clone() })?.0;
        Ok((visible(&tier), graph))
    });
    let pipeline = Pipeline {
        name: visible(&path.to_string_lossy()),
        written: file.graph(pipeline)?,
        tier: pipeline.tier.clone(),
        tiers: tiers.collect::<Result<_, Failure>>()?,
    };
    Ok(measure::measure(gpu, registry, &pipeline, options, &Bar::new(0))?)
}

fn write(args: &MeasureArgs, report: &MeasureReport) -> Result<(), Failure> {
    if let Some(path) = &args.json {
        write_atomic(path, format!("{:#}\n", measure::json(report)).as_bytes())?;
    }
    if let Some(path) = &args.csv {
        write_atomic(path, measure::csv(report).as_bytes())?;
    }
    Ok(args.plot.iter().try_for_each(|path| write_chart(path, report))?)
}

/// Measures every pipeline of a file or a folder, and writes the figures of this adapter and the page.
fn page(
    folder: &Path,
    args: &MeasureArgs,
    gpu: &Gpu,
    registry: &Registry,
    options: &MeasureOptions,
) -> Result<(), Failure> {
    let mut page = FigurePage::open(folder, &gpu.name())?;
    for path in pipelines(&args.pipeline)? {
        note(&path.to_string_lossy());
        let report = report(args, &path, gpu, registry, options)?;
        page.add(&path.file_stem().unwrap_or_default().to_string_lossy(), &report)?;
    }
    Ok(page.write()?)
}

/// The pipelines of a folder, in the order of their names; or the file itself.
fn pipelines(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = std::fs::read_dir(path)
        .map_err(|error| Failure::unreadable(format!("cannot read the folder `{}`: {error}", path.display())))?;
    let mut all: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    all.retain(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron")));
    all.sort();
    match all.is_empty() {
        true => Err(Failure::user(format!("no file in `{}` ends in `.ron`", path.display()))),
        false => Ok(all),
    }
}
