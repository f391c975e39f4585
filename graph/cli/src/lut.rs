//! `afterimage lut`: the color nodes of a pipeline as a table for other programs.

use afterimage_color::lut::WrittenFormat;
use afterimage_color::process::LutSpace;
use afterimage_graph::check::Graph;
use afterimage_graph::color::Transfer;
use afterimage_graph::diagnostic::shown_path;
use afterimage_graph::image::{ColorState, Size};
use afterimage_graph::node::NodeKind;
use afterimage_lab::lut::{ColorRun, LutExport, LutOptions};
use afterimage_media::{run_files, write_atomic};
use afterimage_plan::Options;

use crate::args::lut::LutArgs;
use crate::device::open;
use crate::failure::Failure;
use crate::pipeline::{PipelineSource, facts, plan_without_device};
use crate::terminal::{note, say};

/// A size at which kinds do what they do in films.
const TYPICAL: Size = Size { width: 1920, height: 1080, depth: 1 };

pub(crate) fn run(args: &LutArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let source = PipelineSource::read(&args.pipeline, tables, &args.options.kinds)?;
    let graph = source.file().graph(&args.options)?;
    let format = WrittenFormat::of_name(&args.out).ok_or_else(|| {
        Failure::user(format!("`{}`: a table is a `.cube` or a `.clf` file", shown_path(&args.out)))
            .hint("`ociobakelut` makes other formats of it")
    })?;
    check_spacing(args)?;
    run_files::writes(&args.out)?;
    let run = ColorRun::before(&graph, args.output.as_deref())?;
    let options = LutOptions {
        from: args.from,
        size: args.size as usize,
        shaper: args.shaper,
        format,
        title: args.pipeline.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        facts: facts(&args.options)?,
    };
    let made = run.export(&open(&args.device)?, &options)?;
    write_atomic(&args.out, made.text.as_bytes())?;
    report(args, &run, &made);
    note_left_out(args, &run, graph)
}

/// Tables in equal steps of light have few entries where eyes see most.
fn check_spacing(args: &LutArgs) -> Result<(), Failure> {
    let is_linear = args.from.colorimetry(1.0).is_some_and(|color| color.transfer == Transfer::Linear);
    let name = args.from.name();
    match args.shaper {
        Some(_) if !is_linear => {
            Err(Failure::user(format!("`--shaper` is for linear colors, and {name} has a curve")).hint("leave it out"))
        }
        None if is_linear => {
            note(&format!("note: the table has equal steps of light, and none above 1; `--shaper` is for {name}"));
            Ok(())
        }
        _ => Ok(()),
    }
}

fn report(args: &LutArgs, run: &ColorRun, made: &LutExport) {
    let (file, nodes) = (shown_path(&args.out), run.nodes.join("`, `"));
    say(&format!(
        "{file}: {size} entries a side, from {from} to {to}, of `{nodes}`",
        size = args.size,
        from = args.from.name(),
        to = made.to.map_or(made.state.name(), LutSpace::name)
    ));
    let errors = made.errors;
    // Rounded up: no color is further off than what is printed.
    let [grays, p99, p999, max] = [errors.grays, errors.p99, errors.p999, errors.max].map(|error| match made.state {
        ColorState::Encoded => format!("{:.3}", error * 255.0 + 0.0005),
        _ => format!("{:.2e}", error * 1.005),
    });
    let unit = if made.state == ColorState::Encoded { "codes of 8 bits" } else { "units of its results" };
    say(&format!(
        "error in {unit}: grays at most {grays}; 99 % of colors at most {p99}, 99.9 % at most {p999}; the largest that \
         a search finds is {max}"
    ));
    if let Some(to) = made.to {
        let state = match made.state {
            ColorState::Encoded | ColorState::DisplayLinear => format!(", state: {}", made.state.name()),
            _ => String::new(),
        };
        let (name, from) = (args.out.file_name().unwrap_or_default().to_string_lossy(), args.from.name());
        let to = if args.from == to { String::new() } else { format!(", to: {}", to.name()) };
        // `ColorLut` takes light after an `Exposure`.
        let source = if run.state() == ColorState::Scene { "exposed" } else { &run.input };
        note(&format!("in a pipeline: ColorLut(source: {source:?}, file: {name:?}, from: {from}{to}{state})"));
    }
}

/// Names the nodes that have an effect and are not in the table.
fn note_left_out(args: &LutArgs, run: &ColorRun, mut graph: Graph) -> Result<(), Failure> {
    graph.outputs.retain(|output| output.name == run.output);
    let plan = plan_without_device(&graph, TYPICAL, facts(&args.options)?, Options::default())?;
    let left_out = run.left_out(&plan).into_iter().map(|(name, kind)| format!("`{name}` ({kind})"));
    let left_out: Vec<String> = left_out.collect();
    if !left_out.is_empty() {
        let names = left_out.join(", ");
        note(&format!("note: not in the table, which sees one color at a time: {names}"));
    }
    Ok(())
}
