//! Texts that are expensive to check: sections, pipelines in pipelines, and errors.

use super::bomb::{Bomb, before, last, lines, pipeline};
use super::graphs::points;

/// Outputs that each show a node of their own.
pub(super) fn outputs(count: usize) -> Bomb {
    let nodes = lines(count, |at| format!("\"n{at}\": Gaussian(source: \"scene\")"));
    let outputs = lines(count, |at| format!("\"o{at}\": \"n{at}\""));
    Bomb::of(format!("Pipeline(inputs: {{\"scene\": Color}}, nodes: {{\n{nodes}}}, outputs: {{\n{outputs}}})"))
}

/// Outputs that all show one node.
pub(super) fn outputs_of_one(count: usize) -> Bomb {
    let outputs = lines(count, |at| format!("\"o{at}\": \"n\""));
    let nodes = "\"n\": Gaussian(source: \"scene\")";
    Bomb::of(format!("Pipeline(inputs: {{\"scene\": Color}}, nodes: {{{nodes}}}, outputs: {{\n{outputs}}})"))
}

/// Images of the host, joined one after the other.
pub(super) fn inputs(count: usize) -> Bomb {
    let inputs = lines(count, |at| format!("\"i{at}\": Color"));
    let base = |at: usize| if at == 0 { "i0".to_owned() } else { before(at) };
    let nodes = lines(count, |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"i{at}\")", base(at)));
    Bomb::of(format!(
        "Pipeline(inputs: {{\n{inputs}}}, nodes: {{\n{nodes}}}, outputs: {{\"out\": \"{}\"}})",
        last(count)
    ))
}

/// A pipeline as a node with many inputs.
pub(super) fn inner_inputs(count: usize) -> Bomb {
    let inner = inputs(count).text;
    let fields = lines(count, |at| format!("i{}: \"scene\"", count - 1 - at));
    let text = pipeline(&format!("\"inner\": Pipeline(file: \"inner.ron\",\n{fields}),\n"), "inner");
    Bomb { text, files: [("inner.ron".to_owned(), inner)].into() }
}

/// A pipeline as a node with many outputs, each of which is read.
pub(super) fn inner_outputs(count: usize) -> Bomb {
    let inner = outputs(count).text;
    let node = |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"inner.o{at}\")", before(at));
    let nodes = format!("\"inner\": Pipeline(file: \"inner.ron\", scene: \"scene\"),\n{}", lines(count, node));
    Bomb { text: pipeline(&nodes, &last(count)), files: [("inner.ron".to_owned(), inner)].into() }
}

/// A node, and tiers of one setting each.
pub(super) fn tiers(count: usize) -> Bomb {
    let tiers = lines(count, |at| format!("\"t{at}\": {{\"n0.amount\": 0.25}}"));
    let text = points(1).text;
    Bomb::of(format!("{}, tiers: {{\n{tiers}}})", text.trim_end_matches(')')))
}

/// Settings of many nodes in a few tiers.
pub(super) fn settings(count: usize) -> Bomb {
    let settings = lines(count, |at| format!("\"n{at}.amount\": 0.25"));
    let tiers = lines(4, |at| format!("\"t{at}\": {{\n{settings}}}"));
    let text = points(count).text;
    Bomb::of(format!("{}, set: {{\n{settings}}}, tiers: {{\n{tiers}}})", text.trim_end_matches(')')))
}

/// Facts that conditions use.
pub(super) fn facts(count: usize) -> Bomb {
    let node =
        |at| format!("\"n{at}\": Saturation(source: \"{}\", amount: 0.5, when: \"f{at} > 1 or g < 2\")", before(at));
    let facts = lines(count, |at| format!("\"f{}\": \"a fact\"", count - 1 - at));
    let text = pipeline(&lines(count, node), &last(count));
    Bomb::of(format!("{}, facts: {{\n{facts}\"g\": \"\"}})", text.trim_end_matches(')')))
}

/// Long conditions.
pub(super) fn conditions(count: usize) -> Bomb {
    let condition = vec!["(a > 1 or not b)"; 30].join(" and ");
    let node = |at| format!("\"n{at}\": Saturation(source: \"{}\", amount: 0.5, when: \"{condition}\")", before(at));
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Pipelines in pipelines, each used under a long condition, with a chain of nodes in the innermost.
pub(super) fn nested_conditions(count: usize) -> Bomb {
    let depth = count.min(15);
    let condition = vec!["(a > 1 or not b)"; 30].join(" and ");
    let inner = |at: usize| match at {
        at if at == depth => points(count).text,
        _ => pipeline(
            &format!("\"inner\": Pipeline(file: \"f{}.ron\", scene: \"scene\", when: \"{condition}\"),\n", at + 1),
            "inner",
        ),
    };
    let files = (1..=depth).map(|at| (format!("f{at}.ron"), inner(at))).collect();
    Bomb { text: inner(0), files }
}

/// Files that each extend another one and write all nodes anew.
pub(super) fn extends(count: usize) -> Bomb {
    let text = |at: usize| match at {
        15 => points(count).text,
        _ => format!("{}, extends: \"f{}.ron\")", points(count).text.trim_end_matches(')'), at + 1),
    };
    Bomb { text: text(0), files: (1..16).map(|at| (format!("f{at}.ron"), text(at))).collect() }
}

/// Pipelines that each use the next one twice: about so many nodes in all.
pub(super) fn nested(count: usize) -> Bomb {
    let depth = count.ilog2().min(15) as usize - 1;
    let text = |at: usize| match at {
        at if at == depth => pipeline("\"n\": Saturation(source: \"scene\", amount: 0.5),\n", "n"),
        at => {
            let node = |n| format!("\"n{n}\": Pipeline(file: \"f{}.ron\", scene: \"{}\")", at + 1, before(n));
            pipeline(&lines(2, node), "n1")
        }
    };
    Bomb { text: text(0), files: (1..=depth).map(|at| (format!("f{at}.ron"), text(at))).collect() }
}

/// A pipeline with one node and many facts, used as often.
pub(super) fn nested_facts(count: usize) -> Bomb {
    let facts = lines(count, |at| format!("\"f{at}\": \"a fact\""));
    let inner = pipeline("\"n\": Saturation(source: \"scene\", amount: 0.5),\n", "n");
    many_uses(count, format!("{}, facts: {{\n{facts}}})", inner.trim_end_matches(')')))
}

/// A pipeline with one node and many tiers, used as often.
pub(super) fn nested_tiers(count: usize) -> Bomb {
    let tiers = lines(count, |at| format!("\"t{at}\": {{\"n.amount\": 0.25}}"));
    let inner = pipeline("\"n\": Saturation(source: \"scene\", amount: 0.5),\n", "n");
    many_uses(count, format!("{}, tiers: {{\n{tiers}}})", inner.trim_end_matches(')')))
}

/// A pipeline used many times in a chain.
fn many_uses(count: usize, inner: String) -> Bomb {
    let node = |at| format!("\"n{at}\": Pipeline(file: \"inner.ron\", scene: \"{}\")", before(at));
    let text = pipeline(&lines(count, node), &last(count));
    Bomb { text, files: [("inner.ron".to_owned(), inner)].into() }
}

/// A pipeline with one node and a long comment, used as often as its comment is long.
pub(super) fn nested_comments(count: usize) -> Bomb {
    let inner = pipeline("\"n\": Saturation(source: \"scene\", amount: 0.5),\n", "n");
    many_uses(count, format!("// {}\n{inner}", "a comment ".repeat(count)))
}

/// A node with a long label.
pub(super) fn nested_labels(count: usize) -> Bomb {
    let label = "x".repeat(count * 30);
    Bomb::of(pipeline(&format!("\"n\": Saturation(source: \"scene\", amount: 0.5, label: \"{label}\"),\n"), "n"))
}

/// A pipeline under a long name, with many nodes.
pub(super) fn nested_names(count: usize) -> Bomb {
    let long = "x".repeat(count * 30);
    let text = pipeline(&format!("\"{long}\": Pipeline(file: \"inner.ron\", scene: \"scene\"),\n"), &long);
    Bomb { text, files: [("inner.ron".to_owned(), points(count).text)].into() }
}

/// A node with one field written many times.
pub(super) fn fields(count: usize) -> Bomb {
    let fields = lines(count, |at| format!("f{at}: 1"));
    Bomb::of(pipeline(&format!("\"n\": Saturation(source: \"scene\",\n{fields}),\n"), "n"))
}

/// Wires to names that are nearly those of other nodes.
pub(super) fn unknown_names(count: usize) -> Bomb {
    let node = |at| format!("\"node{at}\": Saturation(source: \"mode{at}\", amount: 0.5)");
    Bomb::of(pipeline(&lines(count, node), "node0"))
}

/// Settings of nodes that are not there.
pub(super) fn unknown_fields(count: usize) -> Bomb {
    let settings = lines(count, |at| format!("\"m{at}.amount\": 0.25"));
    let text = points(count).text;
    Bomb::of(format!("{}, set: {{\n{settings}}})", text.trim_end_matches(')')))
}

/// Wires to outputs of a pipeline that it nearly has.
pub(super) fn unknown_outputs(count: usize) -> Bomb {
    let inner = outputs(count.min(256)).text;
    let node = |at| format!("\"n{at}\": Composite(base: \"scene\", bloom: \"inner.o{at}x\")");
    let nodes = format!("\"inner\": Pipeline(file: \"inner.ron\", scene: \"scene\"),\n{}", lines(count, node));
    Bomb { text: pipeline(&nodes, &last(count)), files: [("inner.ron".to_owned(), inner)].into() }
}

/// Conditions with facts that are nearly those of the list.
pub(super) fn unknown_facts(count: usize) -> Bomb {
    let node = |at| format!("\"n{at}\": Saturation(source: \"{}\", amount: 0.5, when: \"fact{at}x > 1\")", before(at));
    let facts = lines(count.min(256), |at| format!("\"fact{at}\": \"a fact\""));
    let text = pipeline(&lines(count, node), &last(count));
    Bomb::of(format!("{}, facts: {{\n{facts}}})", text.trim_end_matches(')')))
}

/// Kinds and parameters that are nearly those that there are.
pub(super) fn unknown_kinds(count: usize) -> Bomb {
    let kind = |at: usize| if at.is_multiple_of(2) { "Saturations" } else { "AutoExposure" };
    let node = |at| format!("\"n{at}\": {}(source: \"{}\", amounts: 0.5)", kind(at), before(at));
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// A cycle through all nodes, with shorter ones inside.
pub(super) fn cycle(count: usize) -> Bomb {
    let node = |at: usize| {
        let next = (at + 1) % count;
        format!("\"n{at}\": Composite(base: \"n{next}\", bloom: \"n{}\")", (at * 7 + 1) % count)
    };
    Bomb::of(pipeline(&lines(count, node), "n0"))
}
