//! `afterimage nodes`: descriptions of the node kinds, from their tables.

use std::fmt::Write as _;

use afterimage_graph::diagnostic::{did_you_mean, nearest};
use afterimage_graph::image::ColorState;
use afterimage_graph::node::{Fallback, Input, NodeKind, Output, OutputState, Registry};
use afterimage_graph::value::{Param, Type};
use anstyle::{AnsiColor, Style};

use crate::args::NodesArgs;
use crate::failure::Failure;
use crate::files::registry;
use crate::scaffold;
use crate::terminal::{say_styled, say_text, wrapped};

const HEADING: Style = Style::new().bold();
const NAME: Style = AnsiColor::Cyan.on_default().bold();

pub(crate) fn run(args: &NodesArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.kinds, None)?;
    match &args.new {
        Some(name) if args.rust => say_text(&scaffold::rust_crate(name, &registry, args.repository.as_deref())?),
        Some(name) => say_text(&scaffold::folder(name, &registry)?),
        None if args.kind.is_empty() => say_styled(&list(&registry.iter().collect::<Vec<_>>())),
        None => say_styled(&described(&registry, &args.kind.join(" "))?),
    }
    Ok(())
}

/// The page of the kind of that name, or the kinds of that topic.
fn described(registry: &Registry, name: &str) -> Result<String, Failure> {
    let by_letters = |kind: &&NodeKind| kind.name().eq_ignore_ascii_case(name);
    if let Some(kind) = registry.get(name).or_else(|| registry.iter().find(by_letters)) {
        return Ok(page(kind));
    }
    let topic: Vec<&NodeKind> = registry.about(name).into_iter().filter_map(|name| registry.get(name)).collect();
    match topic.as_slice() {
        [] => {
            let words = registry.iter().flat_map(|kind| kind.doc().split(|c: char| !c.is_alphabetic()));
            let topic = nearest(name, words.filter(|word| word.len() > 3));
            let topic = || topic.map(|word| format!("did you mean the topic `{}`?", word.to_lowercase()));
            let near = did_you_mean(name, registry.names()).or_else(topic);
            Err(Failure::user(format!("no node kind is called `{name}`, and none is about that"))
                .hint(near.unwrap_or_else(|| "`afterimage nodes` lists them all".into())))
        }
        [kind] => Ok(page(kind)),
        kinds => Ok(list(kinds)),
    }
}

fn list(kinds: &[&NodeKind]) -> String {
    let width = kinds.iter().map(|kind| kind.name().len()).max().unwrap_or(0);
    let mut text = String::new();
    for kind in kinds {
        let first = kind.doc().trim().lines().next().unwrap_or("");
        let lines = wrapped(first, width + 2);
        let _ = writeln!(text, "{NAME}{:width$}{NAME:#}  {}", kind.name(), lines.trim_start());
    }
    text + "\n`afterimage nodes KIND` explains one, `afterimage nodes WORD` lists those for a topic.\n"
}

fn page(kind: &NodeKind) -> String {
    let mut text = format!("{NAME}{}{NAME:#}\n\n{}", kind.name(), paragraphs(kind.doc()));
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
    let _ = writeln!(text, "\n{HEADING}In a pipeline{HEADING:#}\n  {}", example(kind));
    text
}

/// The paragraphs of a manual, each wrapped; lines that begin with more spaces stay as they are.
fn paragraphs(doc: &str) -> String {
    let mut text = String::new();
    for paragraph in doc.trim().split("\n\n") {
        let is_set = paragraph.lines().any(|line| line.starts_with("   ") || line.starts_with(" *"));
        text += &if is_set { unindented(paragraph) } else { wrapped(paragraph, 0) };
        text += "\n\n";
    }
    text
}

fn unindented(doc: &str) -> String {
    doc.lines().map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

/// A line of a pipeline with such a node: the wires that it needs, and its first parameters.
fn example(kind: &NodeKind) -> String {
    let ports = kind.inputs().iter().filter(|port| !port.optional);
    let ports = ports.map(|port| format!("{}: \"...\"", port.name));
    let params = kind.params().iter().take(3).map(|param| format!("{}: {}", param.name, param.default));
    let fields: Vec<String> = ports.chain(params).collect();
    format!("\"name\": {}({}),", kind.name(), fields.join(", "))
}

fn states(states: &[ColorState]) -> String {
    let names: Vec<&str> = states.iter().map(|state| state.name()).collect();
    if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) }
}

fn input(port: &Input) -> String {
    let optional = if port.optional { ", optional" } else { "" };
    let content = content(port.content.as_deref());
    format!(
        "  {NAME}{}{NAME:#}: {}{}{content}{optional}\n{}\n",
        port.name,
        port.ty.name(),
        states(&port.states),
        wrapped(&port.doc, 6)
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
    format!("  {NAME}{}{NAME:#}: {}{state}{content}\n{}\n", port.name, port.ty.name(), wrapped(&port.doc, 6))
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
    facts.extend(param.when.iter().map(|condition| format!("only while {condition}")));
    if param.quality.is_some() {
        facts.push("trades accuracy for speed".into());
    }
    facts.push(if param.replan { "a change needs a new plan" } else { "can change in every frame" }.into());
    let mut text = format!("  {NAME}{}{NAME:#}: {}\n", param.name, facts.join("; "));
    let _ = writeln!(text, "{}", wrapped(&param.doc, 6));
    if let Type::Choice(choices) = param.ty {
        for choice in choices {
            let name = choice.name;
            let lines = wrapped(&format!("{name} {}", choice.doc), 8);
            let _ = writeln!(text, "        {HEADING}{name}{HEADING:#}{}", &lines[8 + name.len()..]);
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
