//! The output of a plan that goes to a file.

use afterimage_graph::image::ColorState;
use afterimage_plan::{Plan, PlanOutput};

use crate::failure::Failure;

/// The named output, or the first whose color state fits the file: encoded for PNG, linear for EXR.
pub(crate) fn choose_output(plan: &Plan, wanted: Option<&str>, png: bool) -> Result<PlanOutput, Failure> {
    let fits = |output: &&PlanOutput| (output.state == ColorState::Encoded) == png;
    match wanted {
        None => plan.outputs.iter().find(fits).cloned().ok_or_else(|| no_output(plan, png)),
        Some(name) => {
            let unknown = || {
                Failure::user(format!("the pipeline has no output `{name}`")).hint(format!("it has {}", names(plan)))
            };
            let output = plan.output(Some(name)).ok_or_else(unknown)?;
            if fits(&output) { Ok(output.clone()) } else { Err(wrong_file(output, png)) }
        }
    }
}

fn names(plan: &Plan) -> String {
    let names: Vec<String> = plan.outputs.iter().map(|o| format!("`{}` ({})", o.name, o.state.name())).collect();
    names.join(", ")
}

fn wrong_file(output: &PlanOutput, png: bool) -> Failure {
    let name = &output.name;
    match png {
        true => Failure::user(format!("output `{name}` is {}, and a PNG holds encoded pictures", output.state.name()))
            .hint("write it to an `.exr` file, or add an `Encode` node"),
        false => Failure::user(format!("output `{name}` is Encoded, and an EXR holds linear light"))
            .hint("write it to a `.png` file"),
    }
}

fn no_output(plan: &Plan, png: bool) -> Failure {
    let (kind, hint) = match png {
        true => ("encoded", "write to an `.exr` file, or add an `Encode` node and an output for it"),
        false => ("linear", "write to a `.png` file, or add an output before the `Encode` node"),
    };
    Failure::user(format!("the pipeline has no {kind} output for this file; it has {}", names(plan))).hint(hint)
}
