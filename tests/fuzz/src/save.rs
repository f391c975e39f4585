//! Saving: whatever text is accepted, changes are written into it and hold when it is read again; nothing else of its
//! graph changes, and what cannot be saved is refused with words.

use std::collections::BTreeMap;

use afterimage_generators::Rng;
use afterimage_graph::check::{Change, Checker, Graph, Saver};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::value::{Type, Value};

use crate::document::{Few, has_words, registry};

const NUMBERS: [f64; 10] = [0.0, -0.0, 0.1, 1e-45, 5e-324, -3.25e-7, 65504.0, 1e300, f64::INFINITY, f64::NAN];
const TEXTS: [&str; 5] = ["", "\"\\", "\n\u{1b}[8m\u{85}", "e\u{301}\u{202e}", "*/ // r#\""];
const NEW_TIER: &str = "new \"tier\"\\\n";

/// True if something could be saved. What is changed follows from the text.
pub(crate) fn survives(text: &str) -> bool {
    let loader = Few::new(text);
    let Ok(document) = parse("self.ron", text) else { return false };
    let checker = Checker::new(&document, registry(), &loader);
    let (tiers, mut rng) = (checker.tiers(), Rng::new(hash(text)));
    let tier = tiers.get(rng.below(tiers.len() + 1)).map(String::as_str);
    let Ok((graph, _)) = checker.check(tier, &[]) else { return false };
    if graph.nodes.is_empty() {
        return false;
    }
    let changes: Vec<Change> = (0..=rng.below(3)).map(|_| change(&graph, &mut rng)).collect();
    let saver = Saver::new("self.ron", text, registry(), &loader).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(saver.save(tier, &[]).expect("nothing changes"), text);
    let expected = expected(&graph, &changes);
    let in_place = holds(saver.save(tier, &changes), tier, &expected, true);
    let as_tier = holds(saver.save_as_tier(NEW_TIER, tier, &changes), Some(NEW_TIER), &expected, false);
    in_place || as_tier
}

/// FNV-1a.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// A parameter with another value, or a node that is switched.
fn change(graph: &Graph, rng: &mut Rng) -> Change {
    let parameters: Vec<_> = graph.parameters().collect();
    let node = &graph.nodes[rng.below(graph.nodes.len())];
    let Some(parameter) = rng.one_of(&parameters).filter(|_| rng.below(4) > 0) else {
        return Change::Enabled { node: node.name.clone(), on: node.off };
    };
    let value = match (graph.value(*parameter), graph.declaration(*parameter).ty) {
        (Value::Float(x), _) => Value::Float(number(*x, rng)),
        (Value::Vector(v, n), _) => Value::Vector(other_vector(*v, *n, rng), *n),
        (Value::Int(whole), _) => Value::Int([*whole + 1, *whole - 1, i64::MAX, i64::MIN][rng.below(4)]),
        (Value::Bool(flag), _) => Value::Bool(!flag),
        (Value::Text(_), _) => Value::Text(TEXTS[rng.below(TEXTS.len())].into()),
        (Value::Choice(_), Type::Choice(all)) => Value::Choice(all[rng.below(all.len())].name),
        (other, _) => other.clone(),
    };
    Change::Value { parameter: graph.parameter_name(*parameter), value }
}

fn other_vector(mut vector: [f64; 4], count: usize, rng: &mut Rng) -> [f64; 4] {
    let at = rng.below(count);
    vector[at] = number(vector[at], rng);
    vector
}

/// A number near the other one, or any.
fn number(near: f64, rng: &mut Rng) -> f64 {
    if rng.below(3) > 0 { near * 0.75 + 0.0625 } else { NUMBERS[rng.below(NUMBERS.len())] }
}

/// All values of a graph by name, and whether its nodes are off.
fn values(graph: &Graph) -> BTreeMap<String, String> {
    let values = graph.parameters().map(|id| (graph.parameter_name(id), shown(graph.value(id))));
    let switches = graph.nodes.iter().map(|node| (node.name.clone(), format!("off: {}", node.off)));
    values.chain(switches).collect()
}

/// A value as a text. Zero has no sign there: a change from 0.0 to -0.0 changes nothing that is saved.
fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) => Value::Float(number + 0.0).to_string(),
        Value::Vector(numbers, count) => Value::Vector(numbers.map(|number| number + 0.0), *count).to_string(),
        other => other.to_string(),
    }
}

/// The values after the changes, of which the last one of a name holds.
fn expected(graph: &Graph, changes: &[Change]) -> BTreeMap<String, String> {
    let changed = changes.iter().map(|change| match change {
        Change::Value { parameter, value } => (parameter.clone(), shown(value)),
        Change::Enabled { node, on } => (node.clone(), format!("off: {}", !on)),
    });
    values(graph).into_iter().chain(changed).collect()
}

/// True if a text was saved; it has the values then, and can be saved again.
fn holds(
    saved: Result<String, Diagnostics>,
    tier: Option<&str>,
    expected: &BTreeMap<String, String>,
    is_stable: bool,
) -> bool {
    let text = match saved {
        Ok(text) => text,
        Err(errors) => {
            assert!(errors.has_errors() && errors.iter().all(|error| error.code != "not-saved"), "{errors}");
            has_words(&errors);
            return false;
        }
    };
    let loader = Few::new(&text);
    let document = parse("self.ron", &text).unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    let checked = Checker::new(&document, registry(), &loader).check(tier, &[]);
    let (graph, _) = checked.unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    assert_eq!(values(&graph), *expected, "{text}");
    if is_stable {
        let saver = Saver::new("self.ron", &text, registry(), &loader).expect("it was read");
        let same = graph.nodes.iter().map(|node| Change::Enabled { node: node.name.clone(), on: !node.off });
        assert_eq!(saver.save(tier, &same.collect::<Vec<_>>()).expect("nothing changes"), text);
    }
    true
}
