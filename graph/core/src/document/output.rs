//! Outputs: `"node"`, or `Output(source: "node", alpha: Coverage)`.

use super::entries::OutputEntry;
use super::tree::{Field, Item, Tree};
use super::unknown::unknown;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Spanned, quote};

/// The word before the options of an output.
pub(super) const OUTPUT: &str = "Output";

const OPTIONS: [&str; 2] = ["source", "alpha"];

/// The output with these options, each of which occurs once; `None` once its error is in `problems`.
pub(super) fn output(
    name: Spanned<String>,
    word: &Spanned<String>,
    options: Vec<Field>,
    problems: &mut Diagnostics,
) -> Option<OutputEntry> {
    let (mut source, mut has_coverage, mut has_source) = (None, false, false);
    for (option, value) in options {
        match option.value.as_str() {
            "source" => {
                has_source = true;
                match value.value {
                    Tree::Text(text) => source = Some(Spanned::new(text, value.location)),
                    Tree::Broken => {}
                    _ => problems.push(wrong(&option, &value, "the name of a node or an input in quotes")),
                }
            }
            "alpha" => match &value.value {
                Tree::Name(word) if word == "Coverage" => has_coverage = true,
                Tree::Name(word) if word == "Opaque" => has_coverage = false,
                Tree::Broken => {}
                _ => problems.push(wrong(&option, &value, "`Coverage` or `Opaque`")),
            },
            other => {
                let message = format!("an output has no option {}", quote(other));
                problems.push(unknown("unknown-option", message, &option, "options", &OPTIONS));
            }
        }
    }
    if !has_source {
        let message = format!("output {} has no `source`", quote(&name.value));
        let help = "write `Output(source: \"node\", alpha: Coverage)`";
        problems.push(Diagnostic::error("wrong-shape", message).at(&word.location, "").help(help));
    }
    Some(OutputEntry { name, source: source?, has_coverage })
}

fn wrong(option: &Spanned<String>, value: &Item, wanted: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", format!("{} is {wanted}", quote(&option.value)))
        .at(&value.location, format!("this is {}", value.value.describe()))
}
