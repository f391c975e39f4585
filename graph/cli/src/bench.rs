//! `afterimage bench`: what a pipeline costs here, pass by pass, next to what the device could do.

use afterimage_gpu::Gpu;
use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_lab::bench::{self, BenchOptions, KindsOptions};
use afterimage_lab::stress;
use afterimage_media::write_atomic;

use crate::args::BenchArgs;
use crate::cameras::scene;
use crate::device::{keep_calibration, keep_pipeline_data, open, options_on, pipelines};
use crate::failure::Failure;
use crate::files::{Files, folder_kinds, read_document, registry};
use crate::pipeline::{PipelineFile, facts, load_graph, plan_options};
use crate::progress::Bar;
use crate::terminal::say;

pub(crate) fn run(args: &BenchArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.options.kinds)?;
    let gpu = open(&args.device)?;
    if args.calibrate {
        let (calibration, size) = bench::calibrate(&gpu, &registry, args.frames)?;
        let kept = keep_calibration(&gpu, &calibration);
        say(&bench::describe(&calibration, &gpu.name(), size, kept.as_deref()));
    }
    if let Some(folder) = &args.grow {
        say(&bench::growth(&gpu, &registry, args.frames, folder)?);
    }
    if let Some(sizes) = &args.kinds {
        kinds(args, &sizes.0, &gpu, tables)?;
    }
    let Some(path) = &args.pipeline else { return Ok(()) };
    // Prints the warnings; the starts below do not print them again.
    load_graph(path, &registry, &args.options)?;
    args.json.iter().try_for_each(|out| Files::of(path, &args.options.kinds).refuse_output(out))?;
    let load = || -> Result<Graph, Failure> {
        let files = Files::of(path, &args.options.kinds);
        Ok(PipelineFile::new(&read_document(path)?, &registry, &files).check(&args.options)?.0)
    };
    let options = BenchOptions {
        size: Size::new(args.size.0, args.size.1),
        samples: args.frames,
        finite: args.finite,
        facts: facts(&args.options)?,
        options: options_on(&gpu, plan_options(&args.plan), &args.device.arithmetic),
    };
    let report = bench::bench(&gpu, &registry, &path.display().to_string(), &load, &options)?;
    keep_pipeline_data(&gpu, &report.pipelines, &pipelines(&gpu));
    say(&report.to_string());
    write_json(args, &report)
}

/// The file of `--json`, if there is one.
fn write_json(args: &BenchArgs, report: &impl serde::Serialize) -> Result<(), Failure> {
    let Some(file) = &args.json else { return Ok(()) };
    Ok(write_atomic(file, &serde_json::to_vec_pretty(report).expect("names and finite numbers are JSON"))?)
}

/// Every kind on its own.
fn kinds(args: &BenchArgs, sizes: &[(u32, u32)], gpu: &Gpu, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let from_folders = folder_kinds(&args.options.kinds)?;
    let mut tables = tables.to_vec();
    tables.push(&from_folders);
    // It also has kinds that make values and tables visible.
    let registry = stress::registry(&tables).map_err(Failure::user)?;
    let options = KindsOptions {
        sizes: sizes.iter().map(|(width, height)| Size::new(*width, *height)).collect(),
        samples: args.frames,
        options: options_on(gpu, plan_options(&args.plan), &args.device.arithmetic),
        camera: &|graph, size| scene(graph).map(|scene| scene.camera(size)),
    };
    let report = bench::kinds(gpu, &registry, &tables, &options, &Bar::new(0))?;
    say(&report.to_string());
    write_json(args, &report)
}
