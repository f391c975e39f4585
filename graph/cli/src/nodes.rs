//! `afterimage nodes`: descriptions of the node kinds, from their tables.

use std::fmt::Write as _;

use afterimage_graph::check::kinds_about;
use afterimage_graph::diagnostic::did_you_mean;
use afterimage_graph::image::ColorState;
use afterimage_graph::node::{Fallback, Input, NodeKind, Output, OutputState, Registry};
use afterimage_graph::value::{Param, Type};
use anstyle::{AnsiColor, Style};

use crate::args::NodesArgs;
use crate::failure::Failure;
use crate::files::registry;
use crate::run_files::RunFiles;
use crate::scaffold;
use crate::terminal::{say, say_styled};

const HEADING: Style = Style::new().bold();
const NAME: Style = AnsiColor::Cyan.on_default().bold();

pub(crate) fn run(args: &NodesArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.kinds, &RunFiles::default())?;
    match (&args.new, &args.kind) {
        (Some(name), _) if args.rust => say(&scaffold::rust_crate(name, &registry, args.repository.as_deref())?),
        (Some(name), _) => say(&scaffold::folder(name, &registry)?),
        (None, None) => say_styled(&list(&registry)),
        (None, Some(name)) => say_styled(&page(find(&registry, name)?)),
    }
    Ok(())
}

fn find<'r>(registry: &'r Registry, name: &str) -> Result<&'r NodeKind, Failure> {
    let by_letters = |kind: &&NodeKind| kind.name().eq_ignore_ascii_case(name);
    registry.get(name).or_else(|| registry.iter().find(by_letters)).ok_or_else(|| {
        let failure = Failure::user(format!("no node kind is called `{name}`"));
        let near = did_you_mean(name, registry.names()).or_else(|| kinds_about(registry, name));
        failure.hint(near.unwrap_or_else(|| "`afterimage nodes` lists them all".into()))
    })
}

fn list(registry: &Registry) -> String {
    let width = registry.names().map(str::len).max().unwrap_or(0);
    let mut text = String::new();
    for kind in registry.iter() {
        let first = kind.doc().trim().lines().next().unwrap_or("").trim();
        let _ = writeln!(text, "{NAME}{:width$}{NAME:#}  {first}", kind.name());
    }
    text + "\n`afterimage nodes KIND` explains one.\n"
}

fn page(kind: &NodeKind) -> String {
    let mut text = format!("{NAME}{}{NAME:#}\n\n{}\n", kind.name(), paragraph(kind.doc()));
    let _ = writeln!(text, "{HEADING}Inputs{HEADING:#}");
    if kind.inputs().is_empty() {
        text += "  none: it makes its picture from nothing\n";
    }
    kind.inputs().iter().for_each(|port| text += &input(port));
    let _ = writeln!(text, "\n{HEADING}Outputs{HEADING:#}");
    kind.outputs().iter().for_each(|port| text += &output(port));
    let _ = writeln!(text, "\n{HEADING}Parameters{HEADING:#}");
    if kind.params().is_empty() {
        text += "  none\n";
    }
    kind.params().iter().for_each(|param| text += &parameter(param));
    let _ = writeln!(text, "\n{HEADING}When it is off{HEADING:#}");
    kind.outputs().iter().for_each(|port| text += &fallback(port));
    text
}

fn paragraph(doc: &str) -> String {
    doc.lines().map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

fn states(states: &[ColorState]) -> String {
    let names: Vec<&str> = states.iter().map(|state| state.name()).collect();
    if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) }
}

fn input(port: &Input) -> String {
    let optional = if port.optional { ", optional" } else { "" };
    let content = content(port.content.as_deref());
    format!(
        "  {NAME}{}{NAME:#}: {}{}{content}{optional}\n      {}\n",
        port.name,
        port.ty.name(),
        states(&port.states),
        port.doc
    )
}

fn content(content: Option<&str>) -> String {
    content.map_or_else(String::new, |content| format!(" ({content})"))
}

fn output(port: &Output) -> String {
    let state = match &port.state {
        OutputState::Always(state) => format!(" ({})", state.name()),
        OutputState::Same(input) => format!(" (in the state of `{input}`)"),
        OutputState::Chosen(param) => format!(" (in the state that `{param}` names)"),
        OutputState::Nothing => String::new(),
    };
    let content = content(port.content.as_deref());
    format!("  {NAME}{}{NAME:#}: {}{state}{content}\n      {}\n", port.name, port.ty.name(), port.doc)
}

fn parameter(param: &Param) -> String {
    let mut facts = vec![format!("default {}", param.default)];
    if let Some((low, high)) = param.domain {
        facts.push(format!(
            "from {low} to {high}{}",
            if param.unit.is_empty() { String::new() } else { format!(" {}", param.unit) }
        ));
    } else if !param.unit.is_empty() {
        facts.push(format!("in {}", param.unit));
    }
    facts.extend(param.neutral.as_ref().map(|value| format!("neutral at {value}")));
    if param.quality.is_some() {
        facts.push("trades accuracy for speed".into());
    }
    facts.push(if param.replan { "a change needs a new plan" } else { "can change in every frame" }.into());
    let mut text = format!("  {NAME}{}{NAME:#}: {}\n", param.name, facts.join("; "));
    for line in param.doc.lines() {
        let _ = writeln!(text, "      {}", line.trim());
    }
    if let Type::Choice(choices) = param.ty {
        for choice in choices {
            let _ = writeln!(text, "        {HEADING}{}{HEADING:#} {}", choice.name, choice.doc.trim());
        }
    }
    text
}

fn fallback(port: &Output) -> String {
    let what = match &port.fallback {
        Fallback::Input(input) => format!("the input `{input}`"),
        Fallback::Zero => "black".into(),
        Fallback::Absent => "absent, and what needs it is off too".into(),
    };
    format!("  {NAME}{}{NAME:#} is {what}\n", port.name)
}
