//! Changed values are written into the text of a file, and nothing else of it changes.

mod cases;
mod gestures;
mod hostile;
mod layouts;
mod shipped;
mod structure;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use afterimage_graph::check::{Change, Checker, Graph, Loader, Saver};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_graph::value::Value;

/// Files by their joined paths.
#[derive(Clone, Default)]
struct Folder(BTreeMap<String, Arc<[u8]>>);

impl Folder {
    fn of(files: &[(&str, &str)]) -> Self {
        Self(files.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().into())).collect())
    }

    /// Saves changes of the file `a.ron`.
    fn save(&self, text: &str, tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        Saver::new("a.ron", text, registry(), self)?.save(tier, changes)
    }

    /// What the file `a.ron` says at a tier.
    fn graph(&self, text: &str, tier: Option<&str>) -> Graph {
        let document = parse("a.ron", text).unwrap_or_else(|errors| panic!("{errors}\n{text}"));
        let checked = Checker::new(&document, registry(), self).check(tier, &[]);
        checked.unwrap_or_else(|errors| panic!("{errors}\n{text}")).0
    }
}

impl Loader for Folder {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.0.get(path).cloned().ok_or_else(|| "there is no such file".into())
    }
}

/// The built-in kinds.
fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| Registry::new(&[afterimage_nodes::ALL]).expect("the kinds have different names"))
}

fn value(parameter: &str, value: Value) -> Change {
    Change::Value { parameter: parameter.to_owned(), value }
}

fn float(parameter: &str, number: f64) -> Change {
    value(parameter, Value::Float(number))
}

fn switch(node: &str, on: bool) -> Change {
    Change::Enabled { node: node.to_owned(), on }
}

/// All values of a graph by name, and whether its nodes are off.
fn values(graph: &Graph) -> BTreeMap<String, String> {
    let values = graph.parameters().map(|id| (graph.parameter_name(id), graph.value(id).to_string()));
    let switches = graph.nodes.iter().map(|node| (node.name.clone(), format!("off: {}", node.off)));
    values.chain(switches).collect()
}

/// What is inserted into `old` to make `new`, if nothing is removed.
fn inserted<'n>(old: &str, new: &'n str) -> Option<&'n str> {
    let same = |(a, b): &(u8, u8)| a == b;
    let start = old.bytes().zip(new.bytes()).take_while(same).count();
    let end = old.bytes().rev().zip(new.bytes().rev()).take_while(same).count().min(old.len() - start);
    (start + end == old.len()).then(|| new.get(start..new.len() - end)).flatten()
}

/// Whether `old` is what is left of `new` without some of its characters.
fn is_within(old: &str, new: &str) -> bool {
    let mut rest = new.chars();
    old.chars().all(|c| rest.any(|other| other == c))
}

/// Words, numbers, texts in quotes, comments, runs of space and single signs.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || "_.-+".contains(c);
        let end = match first {
            '"' => quoted_end(rest),
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").expect("a comment ends") + 2,
            c if c.is_whitespace() => rest.find(|c: char| !c.is_whitespace()).unwrap_or(rest.len()),
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let (token, after) = rest.split_at(end);
        tokens.push(token);
        rest = after;
    }
    tokens
}

fn quoted_end(text: &str) -> usize {
    let mut is_escaped = false;
    let end = text[1..].find(|c| {
        let is_end = c == '"' && !is_escaped;
        is_escaped = c == '\\' && !is_escaped;
        is_end
    });
    end.expect("a text ends") + 2
}
