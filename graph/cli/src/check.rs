//! `afterimage check`.

use afterimage_graph::diagnostic::{Diagnostics, Style};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_graph::plan::check_plan;

use crate::args::CheckArgs;
use crate::failure::Failure;
use crate::pipeline::{Files, check_file, facts, plan_without_device, registry, split};
use crate::terminal::{note, say};

pub(crate) fn run(args: &CheckArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.options.nodes)?;
    if args.json {
        return json(args, &registry);
    }
    let mut failed = 0;
    for path in &args.pipelines {
        match check_file(path, &registry, &args.options) {
            Ok((graph, warnings)) => {
                if !warnings.is_empty() {
                    note(&warnings.render(Style::Coloured));
                }
                let verdict = if args.plan { prove(&graph, args)? } else { String::new() };
                say(&format!("{}: good{verdict}", path.display()));
            }
            Err(failure) => {
                note(&failure.text);
                failed += 1;
            }
        }
    }
    match failed {
        0 => Ok(()),
        _ => Err(Failure::user(format!("{failed} of {} pipelines cannot be used", args.pipelines.len()))),
    }
}

/// Plans the pipeline at three sizes and lets the checker replay each plan.
fn prove(graph: &afterimage_graph::check::Graph, args: &CheckArgs) -> Result<String, Failure> {
    for size in [Size::new(1, 1), Size::new(641, 359), Size::new(3840, 2160)] {
        let plan = plan_without_device(graph, size, facts(&args.options)?, Default::default())?;
        check_plan(&plan).map_err(|faults| {
            let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
            Failure::machine(format!("the plan at {size} is wrong: {}", lines.join("; ")))
        })?;
    }
    Ok(", and its plans are proved".into())
}

fn json(args: &CheckArgs, registry: &afterimage_graph::node::Registry) -> Result<(), Failure> {
    let mut all = Diagnostics::default();
    for path in &args.pipelines {
        let name = path.to_string_lossy();
        let text = std::fs::read_to_string(path)
            .map_err(|error| Failure::user(format!("cannot read the pipeline `{name}`: {error}")))?;
        let sets = args.options.sets.iter().map(|set| split(set, "--set")).collect::<Result<_, _>>()?;
        let options = afterimage_graph::check::CheckOptions { tier: args.options.tier.clone(), sets, loader: &Files };
        let checked = parse(&name, &text).and_then(|document| {
            afterimage_graph::check::check(&document, registry, &options).map(|(_, warnings)| warnings)
        });
        all.absorb(checked.unwrap_or_else(|errors| errors));
    }
    say(&format!("{:#}", all.to_json()));
    if all.has_errors() { Err(Failure { text: String::new(), status: 1 }) } else { Ok(()) }
}
