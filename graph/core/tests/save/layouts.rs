//! Texts of random layout: comments between tokens, commas at ends, all in one line, line ends of Windows.

use proptest::prelude::*;
use proptest::sample::Index;

use afterimage_graph::check::{Change, Checker, Graph};
use afterimage_graph::document::parse;
use afterimage_graph::value::Value;

use super::{Folder, float, is_within, registry, switch, tokens, value, values};

const INNER: &str = r#"Pipeline(inputs: { "scene": Color }, nodes: {
    "lifted": Exposure(source: "scene", stops: 0.25), "kept": Extract(source: "lifted", threshold: 1.0) },
    outputs: { "light": "kept" }, set: { "kept.knee": 0.5 }, tiers: { "low": { "kept.threshold": 2.0 } })"#;

const BASE: &str = r#"Pipeline(inputs: { "scene": Color }, nodes: {
    "exposed": Exposure(source: "scene", stops: 0.5), "tinted": WhiteBalance(source: "exposed") },
    outputs: { "display": "tinted" }, set: { "tinted.target": (1.0, 0.5, 0.25) },
    tiers: { "low": { "exposed.stops": 1.0, "tinted": Off }, "base": { "exposed.stops": 2.0 } })"#;

/// What is laid out: files with and without the sections that a save needs.
pub(super) const OWN: [&str; 3] = [
    r#"Pipeline(inputs: { "scene": Color }, nodes: { "exposed": Exposure(source: "scene", stops: -1),
    "tinted": WhiteBalance(source: "exposed", target: (1, 0.5, 2.5e-1)),
    "inner": Pipeline(file: "inner.ron", scene: "scene", set: { "lifted.stops": 3.0 }),
    "mapped": ToneMap(source: "inner", curve: Reinhard) }, outputs: { "display": "mapped", "light": "tinted" },
    set: { "mapped.white_level": 3.0 },
    tiers: { "low": { "exposed.stops": 0.0, "inner/kept.knee": 0.25 }, "none": {} })"#,
    r#"Pipeline(extends: "base.ron")"#,
    r#"Pipeline(extends: "base.ron", set: {}, tiers: { "low": {}, "own": { "tinted.temperature": 5000.0 } },
    nodes: { "exposed": Exposure(source: "scene") }, outputs: {})"#,
];

pub(super) fn folder() -> Folder {
    Folder::of(&[("inner.ron", INNER), ("base.ron", BASE)])
}

/// The tokens of a text with other gaps between them, and commas before closing brackets.
pub(super) fn laid_out(text: &str, gaps: &[u8], end: &str) -> String {
    const GAPS: [&str; 9] =
        ["", "", " ", "\n", "\n    ", " /* a, \"b\" { ( */ ", "// c: 1, (\n", "\n\t// d\n\t", "\n        "];
    let words: Vec<&str> = tokens(text).into_iter().filter(|token| !token.trim().is_empty()).collect();
    let mut laid_out = String::new();
    for (index, word) in words.iter().enumerate() {
        let choice = gaps[index % gaps.len()];
        let follows_entry = index > 0 && !"({[,".contains(words[index - 1]);
        if choice & 64 != 0 && follows_entry && [")", "}"].contains(word) {
            laid_out.push(',');
        }
        laid_out += GAPS[usize::from(choice & 63) % GAPS.len()];
        laid_out += word;
    }
    laid_out.replace('\n', end) + end
}

fn graph(text: &str, tier: Option<&str>, sets: &[(String, String)]) -> Option<Graph> {
    let document = parse("a.ron", text).unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    Checker::new(&document, registry(), &folder()).check(tier, sets).ok().map(|(graph, _)| graph)
}

fn tiers(text: &str) -> Vec<Option<String>> {
    let document = parse("a.ron", text).expect("the text is right");
    let tiers = Checker::new(&document, registry(), &folder()).tiers();
    std::iter::once(None).chain(tiers.into_iter().map(Some)).collect()
}

/// Another value of a parameter that a number chooses, or a switch; its key and value as an override writes them.
pub(super) fn change(graph: &Graph, choice: usize) -> (Change, (String, String)) {
    let parameters: Vec<_> = graph.parameters().collect();
    let Some(&id) = parameters.get(choice % (parameters.len() + graph.nodes.len())) else {
        let node = &graph.nodes[choice % graph.nodes.len()];
        let word = if node.off { "On" } else { "Off" };
        return (switch(&node.name, node.off), (node.name.clone(), word.into()));
    };
    let new = match graph.value(id) {
        Value::Float(x) => Value::Float(x * 0.5 + 0.125),
        Value::Vector(v, n) => Value::Vector([v[0] * 0.5 + 0.125, v[1], v[2] * 0.75, v[3]], *n),
        Value::Int(whole) => Value::Int(whole + 1),
        Value::Bool(flag) => Value::Bool(!flag),
        other => other.clone(),
    };
    let name = graph.parameter_name(id);
    (value(&name, new.clone()), (name, new.to_string()))
}

fn comments(text: &str) -> Vec<&str> {
    tokens(text).into_iter().filter(|token| token.starts_with("//") || token.starts_with("/*")).collect()
}

/// What tiers give in the files above, with those of the files that they extend and nest.
const OF_TIERS: [&[(&str, &str)]; 3] = [
    &[("low", "exposed.stops"), ("low", "inner/kept.knee"), ("low", "inner/kept.threshold")],
    &[("low", "exposed.stops"), ("low", "tinted"), ("base", "exposed.stops")],
    &[("own", "tinted.temperature"), ("base", "exposed.stops")],
];

/// Compares what a saved text says at the other tiers: a tier that gives the value keeps it, and all tiers do if the
/// value was that of a tier.
fn compare_tiers(own: usize, text: &str, (tier, set): (Option<&str>, &(String, String)), saved: &str) {
    let gives = |tier: Option<&str>| tier.is_some_and(|tier| OF_TIERS[own].contains(&(tier, set.0.as_str())));
    for other in tiers(text).iter().map(Option::as_deref).filter(|other| *other != tier) {
        let sets = if gives(tier) || gives(other) { Vec::new() } else { vec![set.clone()] };
        let found = graph(saved, other, &[]).map(|graph| values(&graph));
        assert_eq!(found, graph(text, other, &sets).map(|graph| values(&graph)), "at {other:?}: {set:?}\n{saved}");
    }
}

/// Saves a change and compares: all else of the text stays, and the graph is that of an override.
fn compare(own: usize, text: &str, tier: Option<&str>, choice: usize) {
    let Some(before) = graph(text, tier, &[]) else { panic!("a layout is wrong\n{text}") };
    let (change, set) = change(&before, choice);
    let Some(wanted) = graph(text, tier, std::slice::from_ref(&set)) else { return };
    let saved = match folder().save(text, tier, std::slice::from_ref(&change)) {
        Ok(saved) => saved,
        // Another tier may refuse the value.
        Err(errors) => {
            let refuses = |tier: &Option<String>| graph(text, tier.as_deref(), std::slice::from_ref(&set)).is_none();
            assert!(tiers(text).iter().any(refuses), "{errors}\n{change:?}\n{text}");
            return;
        }
    };
    let what = format!("{tier:?} {set:?}\n{text}\n---\n{saved}");
    let found = graph(&saved, tier, &[]).unwrap_or_else(|| panic!("{what}"));
    assert_eq!(values(&found), values(&wanted), "{what}");
    compare_tiers(own, text, (tier, &set), &saved);
    assert_eq!(comments(&saved), comments(text), "{what}");
    let (old_tokens, new_tokens) = (tokens(text), tokens(&saved));
    if old_tokens.len() == new_tokens.len() {
        let differ = old_tokens.iter().zip(&new_tokens).filter(|(old, new)| old != new).count();
        assert!(differ <= set.1.matches(',').count() + 1, "{what}");
    } else {
        assert!(is_within(text, &saved), "{what}");
    }
    if text.contains("\r\n") {
        assert_eq!(saved.matches('\n').count(), saved.matches("\r\n").count(), "{what}");
    }
    assert_eq!(folder().save(&saved, tier, &[change]).expect("it is right"), saved, "{what}");
}

proptest! {
    #[test]
    fn a_change_keeps_the_rest_of_any_layout(
        (own, gaps, windows) in (0..OWN.len(), proptest::collection::vec(any::<u8>(), 1..90), any::<bool>()),
        (tier, choice) in (any::<Index>(), any::<usize>()),
    ) {
        let text = laid_out(OWN[own], &gaps, if windows { "\r\n" } else { "\n" });
        let tiers = tiers(&text);
        compare(own, &text, tiers[tier.index(tiers.len())].as_deref(), choice);
    }

    #[test]
    fn saves_one_after_the_other_make_the_text_of_one_save(
        (own, gaps) in (0..OWN.len(), proptest::collection::vec(any::<u8>(), 1..90)),
        (tier, choices) in (any::<Index>(), proptest::collection::btree_set(0..60_usize, 2..6)),
    ) {
        let text = laid_out(OWN[own], &gaps, "\n");
        let tiers = tiers(&text);
        let tier = tiers[tier.index(tiers.len())].as_deref();
        let before = graph(&text, tier, &[]).expect("a layout is right");
        let mut changes: Vec<Change> = Vec::new();
        for choice in choices {
            let (change, _) = change(&before, choice);
            let is_new = !changes.contains(&change);
            if is_new && folder().save(&text, tier, std::slice::from_ref(&change)).is_ok() {
                changes.push(change);
            }
        }
        let mut one_by_one = text.clone();
        for change in &changes {
            one_by_one = folder().save(&one_by_one, tier, std::slice::from_ref(change)).expect("the change is right");
        }
        let at_once = folder().save(&text, tier, &changes).expect("the changes are right");
        prop_assert_eq!(one_by_one, at_once);
    }
}

#[test]
fn the_layouts_have_what_they_are_for() {
    OWN.iter().for_each(|text| assert!(folder().graph(text, None).nodes.len() > 1));
    let text = laid_out(OWN[0], &[5, 70, 4, 66, 8, 3], "\r\n");
    assert!(text.contains("/* a") && text.contains(",\r\n") && !text.replace("\r\n", "").contains('\n'), "{text}");
    assert!(graph(&text, Some("low"), &[]).is_some());
    assert!(folder().save(&text, None, &[float("exposed.stops", 9.0)]).expect("it is right").contains("9.0"));
}
