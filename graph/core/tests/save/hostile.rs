//! Texts with random changes: whatever is accepted can be saved, or errors say why not.

use proptest::prelude::*;
use proptest::sample::Index;

use afterimage_graph::check::{Change, Checker, Edit, Graph, Reader, Saver};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::value::Value;

use super::layouts::{OWN, change, folder};
use super::{registry, tokens};

/// Saves a change in a text in two ways, at its tier and as a new one; how many of them are possible. The result is
/// right and has the value, or there are errors with words.
fn save(text: &str, choice: usize) -> usize {
    let folder = folder();
    let Ok(document) = parse("a.ron", text) else { return 0 };
    let checker = Checker::new(&document, registry(), &folder);
    let tiers = checker.tiers();
    let tier = tiers.get(choice % (tiers.len() + 1)).map(String::as_str);
    let Ok((graph, _)) = checker.check(tier, &[]) else { return 0 };
    if graph.nodes.is_empty() {
        return 0;
    }
    let (wanted, _) = change(&graph, choice);
    let saver = Saver::new("a.ron", text, registry(), &folder).expect("the text has no errors");
    let name = "a \"new\" tier\\\n";
    let changes = std::slice::from_ref(&wanted);
    let results = [(tier, saver.save(tier, changes)), (Some(name), saver.save_as_tier(name, tier, changes))];
    let edited = saver.edit(tier, &edit(&graph, choice));
    match edited {
        Ok(text) => drop(folder.graph(&text, tier)),
        Err(errors) => assert_told(&errors, text),
    }
    let mut saved = 0;
    for (tier, result) in results {
        match result {
            Ok(text) => {
                assert_holds(&text, tier, &wanted);
                saved += 1;
            }
            Err(errors) => assert_told(&errors, text),
        }
    }
    saved
}

/// An edit of a node that a number chooses.
fn edit(graph: &Graph, choice: usize) -> Edit {
    let node = graph.nodes[choice % graph.nodes.len()].clone();
    let name = "a \"new\" \\name".to_owned();
    let port = node.kind().inputs().first().map_or("source", |input| &*input.name);
    let reader = Reader::input(&node.name, port);
    match choice / graph.nodes.len() % 5 {
        0 => Edit::Remove { node: node.name },
        1 => Edit::Rename { node: node.name, name },
        2 => Edit::Insert { kind: "Vignette".into(), name, reader },
        3 => Edit::Connect { reader, wire: Some(format!("{}@previous", graph.nodes[0].name)) },
        _ => Edit::SwitchAtTier { node: node.name, on: Some(node.off) },
    }
}

fn assert_told(errors: &Diagnostics, text: &str) {
    let is_told = |code: &str, labels: usize| code != "not-saved" && labels > 0;
    assert!(errors.iter().all(|error| is_told(error.code, error.labels.len())), "{errors}\n{text}");
}

fn assert_holds(saved: &str, tier: Option<&str>, wanted: &Change) {
    let graph = folder().graph(saved, tier);
    match wanted {
        Change::Value { parameter, value } => {
            let id = graph.parameter(parameter).expect("it has the same nodes");
            assert!(graph.value(id) == value || matches!(value, Value::File(_)), "{wanted:?}\n{saved}");
        }
        Change::Enabled { node, on } => {
            assert_eq!(graph.node(node).expect("it has the same nodes").1.off, !on, "{saved}");
        }
    }
}

proptest! {
    #[test]
    fn characters_changed_moved_and_removed(
        (own, choice) in (0..OWN.len(), any::<usize>()),
        changes in proptest::collection::vec((any::<Index>(), any::<Index>(), 0..4_u8), 0..3),
    ) {
        const SIGNS: &str = "(){}[]\"',:.@/#\\*r b0-9eE+_A\u{df}\u{7}\n\r!&|<>=$%\u{e9}\u{1F600}\0\u{feff}\u{2028}";
        let signs: Vec<char> = SIGNS.chars().collect();
        let mut text: Vec<char> = OWN[own].chars().collect();
        for (at, other, what) in changes {
            let at = at.index(text.len());
            match what {
                0 => text[at] = signs[other.index(signs.len())],
                1 => text.insert(at, signs[other.index(signs.len())]),
                2 => drop(text.remove(at)),
                _ => text.swap(at, other.index(at + 1)),
            }
        }
        save(&text.into_iter().collect::<String>(), choice);
    }

    #[test]
    fn words_exchanged_doubled_and_removed(
        (own, choice) in (0..OWN.len(), any::<usize>()),
        changes in proptest::collection::vec((any::<Index>(), any::<Index>(), 0..4_u8), 0..3),
    ) {
        let mut words = tokens(OWN[own]);
        for (at, other, what) in changes {
            let (at, other) = (at.index(words.len()), other.index(words.len()));
            match what {
                0 => words[at] = words[other],
                1 => words.insert(at, words[other]),
                2 => drop(words.remove(at)),
                _ => words.swap(at, other),
            }
        }
        save(&words.concat(), choice);
    }
}

#[test]
fn a_right_text_is_saved_for_nearly_every_choice() {
    for text in OWN {
        let saved: usize = (0..100).map(|choice| save(text, choice)).sum();
        assert!((170..=200).contains(&saved), "only {saved} of 200 saves are possible");
    }
}
