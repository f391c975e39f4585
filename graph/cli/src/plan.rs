//! `afterimage plan`: what a pipeline does on the GPU.

use std::path::Path;

use afterimage::offline::LutErrors;
use afterimage_gpu::{Gpu, Opening};
use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_lab::bench::{self, BenchOptions, TableError};
use afterimage_plan::{Caps, Plan, PlanDiff, PlanRequest, Requirement, diff, plan};
use serde_json::{Value, json};

use crate::args::{PipelineOptions, PlanArgs, PlanFormat};
use crate::failure::Failure;
use crate::pipeline::{PipelineSource, facts, request, typical_caps};
use crate::terminal::say_text;

pub(crate) fn run(args: &PlanArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    match text(args, tables) {
        Ok(text) => {
            say_text(&text);
            Ok(())
        }
        // A program that reads JSON gets the errors as JSON, too.
        Err(failure) if args.format == PlanFormat::Json => {
            let status = failure.status();
            say_text(&format!("{:#}", failure.into_diagnostics().to_json()));
            Err(Failure::Printed { status })
        }
        Err(failure) => Err(failure),
    }
}

fn text(args: &PlanArgs, tables: &[&[NodeKind]]) -> Result<String, Failure> {
    let read = |path: &Path| PipelineSource::read(path, tables, &args.options.kinds);
    let source = read(&args.pipeline)?;
    let file = source.file();
    let this = plan_of(&file.graph(&args.options)?, args)?;
    let other = match (&args.diff, &args.diff_tier) {
        (Some(path), _) => read(path)?.file().graph(&args.options)?,
        (None, Some(tier)) => file.graph(&PipelineOptions { tier: Some(tier.clone()), ..args.options.clone() })?,
        (None, None) if args.bake_error => {
            return Ok(shown(&this, args.format) + &table_errors(&source.registry, file.graph(&args.options)?, args)?);
        }
        (None, None) => return Ok(shown(&this, args.format)),
    };
    difference(&diff(&this, &plan_of(&other, args)?), args.format)
}

/// The errors of tables, at a size at which a frame takes little time.
fn table_errors(registry: &Registry, graph: Graph, args: &PlanArgs) -> Result<String, Failure> {
    let gpu = Gpu::open(&Opening::default())?;
    let (facts, options) = (facts(&args.options)?, args.plan.options());
    let options = BenchOptions { size: Size::new(256, 144), samples: 1, finite: true, facts, options };
    let mut text =
        "\ntables against their nodes, in codes of 8 bits: grays; reversals of their ramp; what 99 %, 99.9 % and all \
        of 262144 random colors of each gamut stay below (of the display, if a table begins with its colors)\n"
            .to_owned();
    for error in bench::table_errors(&gpu, registry, graph, &options)? {
        let TableError { nodes, size, codes, gray, reversals } = error;
        text += &format!("  {}  size {size}  grays {gray:.2}  reversals {reversals}\n", nodes.join(" + "));
        for (gamut, [most, nearly_all, all]) in LutErrors::GAMUTS.iter().zip(codes) {
            text += &format!("    {gamut:8}  {most:.2}  {nearly_all:.2}  {all:.2}\n");
        }
    }
    Ok(text)
}

fn shown(plan: &Plan, format: PlanFormat) -> String {
    match format {
        PlanFormat::Text => plan.to_text(),
        PlanFormat::Json => plan.to_json(),
        PlanFormat::Svg => plan.to_svg(),
    }
}

fn difference(diff: &PlanDiff, format: PlanFormat) -> Result<String, Failure> {
    match format {
        PlanFormat::Text => Ok(diff.to_string()),
        PlanFormat::Json => Ok(format!("{:#}", diff_json(diff))),
        PlanFormat::Svg => {
            Err(Failure::user("differences have no timeline").hint("use `--format text` or `--format json`"))
        }
    }
}

/// The differences as JSON. Each pair has the values of this plan and of the other one.
fn diff_json(diff: &PlanDiff) -> Value {
    let changed =
        |(image, before, after): &(String, String, String)| json!({ "image": image, "values": [before, after] });
    json!({
        "added": diff.added,
        "removed": diff.removed,
        "changed": diff.resized.iter().map(changed).collect::<Vec<Value>>(),
        "passes": diff.passes,
        "batches": diff.batches,
        "bytes_moved": diff.bytes_moved,
        "peak_memory": diff.peak_memory,
    })
}

fn plan_of(graph: &Graph, args: &PlanArgs) -> Result<Plan, Failure> {
    let size = Size::new(args.size.0, args.size.1);
    let (facts, options) = (facts(&args.options)?, args.plan.options());
    let dynamic = args.dynamic.iter().map(|name| dynamic(graph, name)).collect::<Result<_, _>>()?;
    if !args.device {
        let caps = Caps { prefer_fragment: args.plan.draws(), ..typical_caps() };
        let request = request(graph, size, facts, options, caps, &Requirement::typical);
        return Ok(plan(graph, &PlanRequest { dynamic, ..request })?);
    }
    let gpu = Gpu::open(&Opening::default())?;
    let executor = gpu.executor();
    let requirement = |desc: &_| executor.requirement(desc);
    let caps = Caps { prefer_fragment: gpu.caps.prefer_fragment || args.plan.draws(), ..gpu.caps.clone() };
    let request = request(graph, size, facts, options, caps, &requirement);
    Ok(plan(graph, &PlanRequest { dynamic, ..request })?)
}

/// A parameter that can change without a new plan.
fn dynamic(graph: &Graph, name: &str) -> Result<ParameterId, Failure> {
    let parameter = graph.parameter(name).map_err(Failure::user)?;
    match graph.declaration(parameter).replan {
        false => Ok(parameter),
        true => Err(Failure::user(format!("each change of `{name}` needs a new plan"))
            .hint("`afterimage nodes KIND` says which parameters do")),
    }
}
