//! Many wrong files, compared with what is known of them: each case of this folder, a good pipeline and a folder kind,
//! with words and signs removed, doubled, exchanged and replaced. `mutated.tsv` has a line for each file: how many of
//! its texts are accepted, how many errors and warnings the others have, and a hash of all that is reported and of the
//! graphs.
//!
//! `AFTERIMAGE_BLESS=1 cargo test -p afterimage-graph errors` writes it anew. A change of a message changes many lines;
//! what each text is reported is asserted nowhere, only that nothing changes by accident.

use std::fmt::Write as _;

use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::node::{NodeKind, folder_kind};

use super::accepted::LYNX;
use super::folder::{DECLARATION, SHADER};
use super::{checked, folder};

/// Texts that are made of each file.
const TEXTS: u64 = 40;

/// Words, numbers and texts in quotes as wholes, and every other character by itself.
fn tokens(text: &str) -> Vec<&str> {
    let kind = |c: char| {
        if c.is_alphanumeric() || c == '_' {
            'w'
        } else if c == ' ' {
            ' '
        } else {
            's'
        }
    };
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let same = rest.find(|c| kind(c) != kind(first)).unwrap_or(rest.len());
        let (token, after) = rest.split_at(if kind(first) == 's' { first.len_utf8() } else { same });
        tokens.push(token);
        rest = after;
    }
    tokens
}

/// The finalizer of splitmix64.
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The text with one to three changes behind the lines of options.
fn mutated(text: &str, seed: u64) -> String {
    const OTHERS: [&str; 22] = [
        "(", ")", "[", "]", "{", "}", ",", ":", "\"", ".", "-", "0", "1e9", "4.5", "true", "None", "//", "/*", "@",
        "previous", "not", "<",
    ];
    let begin = text.split_inclusive('\n').take_while(|line| line.starts_with("//!")).map(str::len).sum();
    let (head, body) = text.split_at(begin);
    let mut tokens = tokens(body);
    for change in 0..1 + seed % 3 {
        let at = |salt: u64, count: usize| (mixed(seed * 97 + change * 7 + salt) % count.max(1) as u64) as usize;
        let (first, second) = (at(1, tokens.len()), at(2, tokens.len()));
        match at(3, 5) {
            _ if tokens.is_empty() => tokens.push(OTHERS[at(4, OTHERS.len())]),
            0 => drop(tokens.remove(first)),
            1 => tokens.insert(first, tokens[first]),
            2 => tokens.swap(first, second),
            3 => tokens[first] = tokens[second],
            _ => tokens.insert(first, OTHERS[at(4, OTHERS.len())]),
        }
    }
    head.to_owned() + &tokens.concat()
}

/// All of a graph that a pipeline says.
fn described(graph: &Graph) -> String {
    let mut text = format!("{:?} {:?}\n", graph.inputs, graph.outputs);
    for node in &graph.nodes {
        let values: Vec<String> = node.instance.values().iter().map(ToString::to_string).collect();
        let (kind, when) = (node.instance.kind().name(), node.when.as_ref().map(ToString::to_string));
        let rest = (&node.wires, when, node.off, node.format, &node.label, &node.states);
        writeln!(text, "{} {kind} {values:?} {rest:?}", node.name).expect("a string grows");
    }
    text
}

fn described_kind(kind: &NodeKind) -> String {
    let (params, inputs, outputs) = (kind.params(), kind.inputs(), kind.outputs());
    format!("{} {} {params:?} {inputs:?} {outputs:?}", kind.name(), kind.doc())
}

/// A line of the table.
#[derive(Default)]
struct Row {
    accepted: usize,
    problems: usize,
    hash: u64,
}

impl Row {
    fn add(&mut self, result: Result<(String, usize), Diagnostics>) {
        let text = match result {
            Ok((described, warnings)) => {
                self.accepted += 1;
                self.problems += warnings;
                described
            }
            Err(errors) => {
                self.problems += errors.len();
                errors.to_string()
            }
        };
        let fnv = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        self.hash = text.bytes().fold(self.hash, fnv);
    }

    fn of(text: &str, report: impl Fn(&str) -> Result<(String, usize), Diagnostics>) -> Self {
        let mut row = Self { hash: 0xcbf2_9ce4_8422_2325, ..Self::default() };
        (0..TEXTS).for_each(|seed| row.add(report(&mutated(text, seed))));
        row
    }

    fn line(&self, name: &str) -> String {
        format!("{name}\t{}\t{}\t{:016x}\n", self.accepted, self.problems, self.hash)
    }
}

fn pipeline(text: &str) -> Result<(String, usize), Diagnostics> {
    checked("case.ron", text).map(|(graph, warnings)| (format!("{}{warnings}", described(&graph)), warnings.len()))
}

#[test]
fn what_many_wrong_files_are_reported_changes_only_where_it_is_meant_to() {
    let files = std::fs::read_dir(folder()).expect("the folder of cases").map(|entry| entry.expect("an entry").path());
    let mut cases: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "ron")).collect();
    cases.sort();
    let mut table = Row::of(LYNX, pipeline).line("a good pipeline");
    for case in cases {
        let text = std::fs::read_to_string(&case).expect("a case is text");
        let name = case.file_stem().expect("a file has a name").to_string_lossy().into_owned();
        table += &Row::of(&text, pipeline).line(&name);
    }
    let kind = |declaration: &str, shader: &str| {
        folder_kind(("node.ron", declaration), ("posterize.wgsl", shader)).map(|kind| (described_kind(&kind), 0))
    };
    table += &Row::of(DECLARATION, |text| kind(text, SHADER)).line("a declaration");
    table += &Row::of(SHADER, |text| kind(DECLARATION, text)).line("a shader");
    let path = folder().join("mutated.tsv");
    if std::env::var_os("AFTERIMAGE_BLESS").is_some() {
        std::fs::write(&path, &table).expect("the folder of cases can be written");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let changed: Vec<(&str, &str)> = known.lines().zip(table.lines()).filter(|(old, new)| old != new).collect();
    assert!(changed.is_empty(), "if this is meant, set AFTERIMAGE_BLESS=1: {changed:#?}");
    assert_eq!(known.lines().count(), table.lines().count());
}
