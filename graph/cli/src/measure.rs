//! `afterimage measure`: time against error.

use afterimage_graph::diagnostic::{shown, shown_path};
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_lab::measure::{self, Explainer, Explanation, MeasureOptions, MeasureReport, Pipeline, SequenceOptions};
use afterimage_media::sequence::{Input, is_numbered};
use afterimage_media::{run_files, write_atomic};
use afterimage_plan::Options;

use crate::args::PipelineOptions;
use crate::args::measure::{MeasureArgs, SequenceArgs};
use crate::device::open;
use crate::failure::Failure;
use crate::pipeline::{PipelineSource, assignments, facts};
use crate::progress::Bar;
use crate::render::tell_other_numbers;
use crate::terminal::{say_styled, say_text};

pub(crate) fn run(args: &MeasureArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if let Some(path) = args.plot.as_ref().filter(|path| path.extension().is_none_or(|ending| ending != "svg")) {
        return Err(Failure::user(format!("`--plot {}` does not end in `.svg`", path.display())));
    }
    let mut options = measure_options(&args.sequences)?;
    options.tiers_only = args.tiers;
    options.error_images.clone_from(&args.error_image);
    let (report, explanation) = report(args, tables, &options)?;
    say_styled(&measure::table(&report));
    explanation.iter().for_each(|explanation| say_text(&explanation.to_text()));
    write(args, &report, explanation.as_ref())
}

/// Options of a measurement from the arguments of `measure` and `tune`.
pub(crate) fn measure_options(args: &SequenceArgs) -> Result<MeasureOptions, Failure> {
    let inputs = assignments(&args.inputs, "--input")?;
    let sequences = SequenceOptions {
        images: args.images.clone(),
        inputs,
        scene: args.scene,
        charts: args.charts,
        sizes: args.sizes.iter().map(|(width, height)| Size::new(*width, *height)).collect(),
        walk: args.walk,
        frames: args.frames.clone(),
        fps: args.fps,
        budget: args.decoding.budget(),
    };
    Ok(MeasureOptions {
        sequences,
        facts: facts(&args.options)?,
        options: Options::default(),
        samples: args.repeats,
        output: args.output.clone(),
        display: args.display,
        tiers_only: false,
        error_images: None,
    })
}

/// Notes the images that a pipeline is measured on. Names without files are reported when they are read.
pub(crate) fn note_images(args: &SequenceArgs) {
    let named = args.inputs.iter().filter_map(|input| input.split_once('=')).map(|(_, file)| file);
    // A folder that cannot be listed is reported when it is read.
    let images = args.images.iter().flat_map(|image| measure::files(image).unwrap_or_default());
    for file in images.chain(named.map(str::to_owned)) {
        let file = file.as_str();
        let frames = args.frames.as_deref().filter(|_| is_numbered(file));
        let found = Input::find(file, frames);
        if args.frames.is_none() {
            tell_other_numbers(file);
        }
        for (_, source) in found.iter().flat_map(Input::sources) {
            run_files::reads(&source.path, "an image that is measured");
        }
    }
}

fn report(
    args: &MeasureArgs,
    tables: &[&[NodeKind]],
    options: &MeasureOptions,
) -> Result<(MeasureReport, Option<Explanation>), Failure> {
    let path = &args.pipeline;
    let source = PipelineSource::read(path, tables, &args.sequences.options.kinds)?;
    let (file, registry) = (source.file(), &source.registry);
    let pipeline = &args.sequences.options;
    let tiers = file.tiers().into_iter().map(|tier| {
        let graph = file.check(&PipelineOptions { tier: Some(tier.clone()), ..pipeline.clone() })?.0;
        Ok((shown(&tier).into_owned(), graph))
    });
    let pipeline = Pipeline {
        name: shown_path(path),
        written: file.graph(pipeline)?,
        tier: pipeline.tier.clone(),
        tiers: tiers.collect::<Result<_, Failure>>()?,
    };
    let explainer = args.explain.as_deref().map(|name| Explainer::new(&pipeline, name)).transpose()?;
    note_images(&args.sequences);
    args.json.iter().chain(&args.plot).try_for_each(|out| run_files::writes(out))?;
    if let Some(folder) = &args.error_image {
        run_files::writes_into(folder, |name| options.sequences.may_name_error_image(name))?;
    }
    let gpu = open(&args.sequences.device)?;
    let bar = Bar::new(0);
    let report = measure::measure(&gpu, registry, &pipeline, options, &bar)?;
    let explain = |explainer: Explainer| explainer.explain(&gpu, registry, &pipeline, options, &report, &bar);
    let explanation = explainer.map(explain).transpose()?;
    Ok((report, explanation))
}

fn write(args: &MeasureArgs, report: &MeasureReport, explanation: Option<&Explanation>) -> Result<(), Failure> {
    if let Some(path) = &args.json {
        let mut json = measure::json(report);
        json["explained"] = serde_json::json!(explanation);
        write_atomic(path, format!("{json:#}\n").as_bytes())?;
    }
    if let Some(path) = &args.plot {
        write_atomic(path, measure::chart(report).as_bytes())?;
    }
    Ok(())
}
