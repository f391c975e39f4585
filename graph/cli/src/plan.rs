//! `afterimage plan`.

use afterimage_gpu::{Executor, Gpu, Opening};
use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_plan::{Plan, diff, plan};

use crate::args::{PipelineOptions, PlanArgs, PlanFormat};
use crate::failure::Failure;
use crate::memory::table;
use crate::pipeline::{facts, load_graph, plan_options, plan_without_device, registry, setting};
use crate::terminal::say;

pub(crate) fn run(args: &PlanArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.options.nodes)?;
    if args.memory {
        say(&table(args, &registry)?);
        return Ok(());
    }
    let [pipeline] = args.pipelines.as_slice() else {
        return Err(Failure::user("this shows one pipeline at a time").hint("compare two with `--diff OTHER`"));
    };
    let make = |path: &std::path::Path, options: &PipelineOptions| {
        let graph = load_graph(path, &registry, options)?;
        plan_of(&graph, args)
    };
    let this = make(pipeline, &args.options)?;
    let other = match (&args.diff, &args.diff_tier) {
        (Some(path), _) => Some(make(path, &args.options)?),
        (None, Some(tier)) => {
            Some(make(pipeline, &PipelineOptions { tier: Some(tier.clone()), ..args.options.clone() })?)
        }
        (None, None) => None,
    };
    if let Some(other) = other {
        say(&diff(&this, &other).to_string());
        return Ok(());
    }
    say(&match args.format {
        PlanFormat::Text => this.to_text(),
        PlanFormat::Json => this.to_json(),
        PlanFormat::Dot => this.to_dot(),
        PlanFormat::Svg => this.to_svg(),
    });
    Ok(())
}

fn plan_of(graph: &Graph, args: &PlanArgs) -> Result<Plan, Failure> {
    let size = Size::new(args.size.0, args.size.1);
    let (facts, options) = (facts(&args.options)?, args.arithmetic.over(plan_options(&args.plan)));
    if !args.device {
        return plan_without_device(graph, size, facts, options);
    }
    let gpu = Gpu::open(&Opening::default())?;
    let executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
    let requirement = |desc: &_| executor.requirement(desc);
    Ok(plan(graph, &setting(graph, size, facts, options, gpu.caps.clone(), &requirement))?)
}
