//! Edits of nodes and wires, and those that take them back: the bytes of before, and graphs that differ by the edit.
//! Every node, input and output of every shipped pipeline, also with other line ends and in a file that extends it.

use std::collections::BTreeMap;

use proptest::prelude::*;

use afterimage_graph::check::{Checker, Edit, Graph, GraphNode, Reader, Saver, Source};
use afterimage_graph::document::parse;
use afterimage_graph::node::Fallback;

use super::layouts::{OWN, folder, laid_out};
use super::shipped::shipped;
use super::{Folder, registry, tokens};

/// Kinds of nodes by the names of the nodes, and sources by the names of inputs and outputs.
type Wires = BTreeMap<String, String>;

fn source_name(graph: &Graph, source: Source) -> String {
    match source {
        Source::Input(input) => graph.inputs[input].name.clone(),
        Source::Node { node, output, previous } => {
            let node = &graph.nodes[node];
            format!("{}.{}@{previous}", node.name, node.kind().outputs()[output].name)
        }
    }
}

fn wires(graph: &Graph) -> Wires {
    let of_node = |node: &GraphNode| {
        let wired = node.kind().inputs().iter().zip(&node.wires);
        let name = node.name.clone();
        let wires: Vec<_> = wired
            .filter_map(|(port, wire)| Some((format!("{name}.{}", port.name), source_name(graph, (*wire)?))))
            .collect();
        wires.into_iter().chain([(node.name.clone(), node.kind().name().to_owned())])
    };
    let outputs = graph.outputs.iter().map(|output| (format!("@{}", output.name), source_name(graph, output.source)));
    graph.nodes.iter().flat_map(of_node).chain(outputs).collect()
}

/// A pipeline file with the files that it may name.
struct File<'a> {
    files: &'a Folder,
    name: &'a str,
    text: String,
}

impl File<'_> {
    fn graph(&self, text: &str) -> Graph {
        let document = parse(self.name, text).unwrap_or_else(|errors| panic!("{errors}\n{text}"));
        let checked = Checker::new(&document, registry(), self.files).check(None, &[]);
        checked.unwrap_or_else(|errors| panic!("{errors}\n{text}")).0
    }

    fn edit(&self, text: &str, edit: &Edit) -> Result<String, String> {
        let saver = Saver::new(self.name, text, registry(), self.files).unwrap_or_else(|errors| panic!("{errors}"));
        saver.edit(None, edit).map_err(|errors| errors.to_string())
    }

    /// Makes an edit and another one that takes it back. The text between says `expected`; comments and line ends stay.
    fn there_and_back(&self, edit: &Edit, back: &Edit, expected: &Wires) {
        let what = format!("{}: {edit:?}", self.name);
        let edited = self.edit(&self.text, edit).unwrap_or_else(|errors| panic!("{what}\n{errors}\n{}", self.text));
        assert_eq!(wires(&self.graph(&edited)), *expected, "{what}\n{edited}");
        assert_eq!(comments(&edited), comments(&self.text), "{what}");
        if self.text.contains("\r\n") {
            assert_eq!(edited.matches('\n').count(), edited.matches("\r\n").count(), "{what}");
        }
        let again = self.edit(&edited, back).unwrap_or_else(|errors| panic!("{what}\n{errors}\n{edited}"));
        assert_eq!(again, self.text, "{what}\n{edited}");
    }

    /// The nodes that the file itself writes and that stand for no inherited ones.
    fn own_nodes(&self) -> Vec<String> {
        let document = parse(self.name, &self.text).expect("it is right");
        if document.extends.is_some() {
            return Vec::new();
        }
        document.nodes.iter().map(|node| node.name.value.clone()).collect()
    }

    fn rename_each_node(&self) {
        let before = wires(&self.graph(&self.text));
        for node in self.own_nodes() {
            let name = "a \"new\" na\u{ef}ve name";
            let renamed = |text: &String| match text.strip_prefix(&node) {
                Some(rest) if rest.is_empty() || rest.starts_with(['.', '/']) => format!("{name}{rest}"),
                _ => text.clone(),
            };
            let is_kind = |key: &String| !key.contains(['.', '@']);
            let expected = before
                .iter()
                .map(|(key, value)| (renamed(key), if is_kind(key) { value.clone() } else { renamed(value) }));
            let rename = |node: &str, name: &str| Edit::Rename { node: node.into(), name: name.into() };
            self.there_and_back(&rename(&node, name), &rename(name, &node), &expected.collect());
        }
    }

    /// Ends of wires at the top, with what they read.
    fn readers(&self, graph: &Graph) -> Vec<(Reader, Source)> {
        let of_node = |node: &GraphNode| {
            let wired = node.kind().inputs().iter().zip(node.wires.clone());
            let readers = wired.filter_map(|(port, wire)| Some((Reader::input(&node.name, &port.name), wire?)));
            readers.collect::<Vec<_>>()
        };
        let nodes = graph.nodes.iter().filter(|node| !node.name.contains('/')).flat_map(of_node);
        let outputs = graph.outputs.iter().map(|output| (Reader::Output(output.name.clone()), output.source));
        nodes.chain(outputs).collect()
    }

    /// Inserts a node before each reader, and removes it again; the number of readers. Kinds without other inputs that
    /// accept any image come in turn, and a kind for pyramids, tables and values does not exist.
    fn insert_on_each_wire(&self, step: usize) -> usize {
        let graph = self.graph(&self.text);
        let before = wires(&graph);
        let mut inserted = 0;
        for (reader, source) in self.readers(&graph).into_iter().step_by(step) {
            let state = match source {
                Source::Input(input) => Some(graph.inputs[input].state),
                Source::Node { node, output, .. } => graph.nodes[node].states[output],
            };
            let kinds = ["Vignette", "Sharpen", "Dither", "FilmGrain", "ColorGrade", "GridBlur", "Crop"];
            let of_kind = |kind: &str| {
                let edit = Edit::Insert { kind: kind.into(), name: "new".into(), reader: reader.clone() };
                let edited = self.edit(&self.text, &edit).ok()?;
                let graph = self.graph(&edited);
                let (_, new) = graph.node("new").expect("it is there");
                (new.states.first().copied().flatten() == state).then_some((edit, kind.to_owned()))
            };
            let Some((edit, kind)) = kinds.into_iter().find_map(of_kind) else { continue };
            let declared = registry().get(&kind).expect("it is built in");
            let key = key(&reader);
            let mut expected = before.clone();
            let old = expected.insert(key, format!("new.{}@0", declared.outputs()[0].name)).expect("it is wired");
            expected.insert(format!("new.{}", declared.inputs()[0].name), old);
            expected.insert("new".into(), kind);
            self.there_and_back(&edit, &Edit::Remove { node: "new".into() }, &expected);
            inserted += 1;
        }
        inserted
    }

    /// Connects each reader to what it reads, a frame earlier, and back; the number of readers.
    fn connect_each_reader(&self, step: usize) -> usize {
        let graph = self.graph(&self.text);
        let before = wires(&graph);
        let mut connected = 0;
        for (reader, source) in self.readers(&graph).into_iter().step_by(step) {
            let Source::Node { node, output, previous } = source else { continue };
            let maker = &graph.nodes[node];
            let path = match output {
                0 => maker.name.clone(),
                _ => format!("{}.{}", maker.name, maker.kind().outputs()[output].name),
            };
            let earlier =
                Edit::Connect { reader: reader.clone(), wire: Some(format!("{path}@previous:{}", previous + 1)) };
            if maker.name.contains('/') || self.edit(&self.text, &earlier).is_err() {
                continue;
            }
            let written = match previous {
                0 => path,
                1 => format!("{path}@previous"),
                _ => format!("{path}@previous:{previous}"),
            };
            let back = Edit::Connect { reader: reader.clone(), wire: Some(written) };
            let mut expected = before.clone();
            let later = Source::Node { node, output, previous: previous + 1 };
            expected.insert(key(&reader), source_name(&graph, later));
            self.there_and_back(&earlier, &back, &expected);
            connected += 1;
        }
        connected
    }

    /// Removes each node; the number of those that can be removed. Lines without a word of the node stay.
    fn remove_each_node(&self) -> usize {
        let graph = self.graph(&self.text);
        let mut removed = 0;
        for node in self.own_nodes() {
            let Ok(edited) = self.edit(&self.text, &Edit::Remove { node: node.clone() }) else { continue };
            removed += 1;
            let Some((_, found)) = graph.node(&node) else { continue };
            assert_eq!(wires(&self.graph(&edited)), without(&wires(&graph), found), "{node}\n{edited}");
            let kept: Vec<&str> = edited.lines().collect();
            let quoted = [format!("\"{node}\""), format!("\"{node}."), format!("\"{node}@")];
            let others = self.text.lines().filter(|line| line.trim_start().starts_with('"') && line.ends_with("),"));
            for line in others.filter(|line| !quoted.iter().any(|name| line.contains(name))) {
                assert!(kept.contains(&line), "{node}: {line}\n{edited}");
            }
        }
        removed
    }

    fn switch_each_node_at_its_tiers(&self, step: usize) {
        let document = parse(self.name, &self.text).expect("it is right");
        // An emptied map is written as `{}`, whatever space it had between its brackets.
        let is_spaced = |name: &String| {
            let after = self.text.split_once(&format!("\"{name}\": {{")).map_or("", |(_, after)| after);
            after.starts_with(char::is_whitespace) && after.trim_start().starts_with('}')
        };
        let names = document.tiers.iter().map(|(name, _)| name.value.clone());
        let own: Vec<String> = names.filter(|name| !is_spaced(name)).collect();
        let graph = self.graph(&self.text);
        for (index, node) in graph.nodes.iter().enumerate().step_by(step) {
            let Some(tier) = own.get(index / step % own.len().max(1)) else { return };
            if self.text.contains(&format!("\"{}\": O", node.name)) {
                continue;
            }
            let saver = |text| Saver::new(self.name, text, registry(), self.files).expect("it is right");
            let switch = |on| Edit::SwitchAtTier { node: node.name.clone(), on };
            let off =
                saver(&self.text).edit(Some(tier), &switch(Some(false))).unwrap_or_else(|errors| panic!("{errors}"));
            let document = parse(self.name, &off).expect("it is right");
            let checker = Checker::new(&document, registry(), self.files);
            for other in checker.tiers().iter().map(Some).chain([None]) {
                let (graph, _) = checker.check(other.map(String::as_str), &[]).expect("it was right before");
                assert_eq!(graph.nodes[index].off, other == Some(tier), "{} at {other:?}\n{off}", node.name);
            }
            let again = saver(&off).edit(Some(tier), &switch(None)).unwrap_or_else(|errors| panic!("{errors}"));
            assert_eq!(again, self.text, "{}\n{off}", node.name);
        }
    }
}

fn key(reader: &Reader) -> String {
    match reader {
        Reader::Input { node, port } => format!("{node}.{port}"),
        Reader::Output(name) => format!("@{name}"),
    }
}

fn comments(text: &str) -> Vec<&str> {
    tokens(text).into_iter().filter(|token| token.starts_with("//") || token.starts_with("/*")).collect()
}

/// The wires without a node: what reads it reads what it falls back to, or its first input of the same type.
fn without(before: &Wires, node: &GraphNode) -> Wires {
    let kind = node.kind();
    let mut after = Wires::new();
    for (key, source) in
        before.iter().filter(|(key, _)| **key != node.name && !key.starts_with(&format!("{}.", node.name)))
    {
        let read = source.strip_prefix(&format!("{}.", node.name)).and_then(|rest| rest.split_once('@'));
        let Some((port, frames)) = read.filter(|_| key.contains(['.', '@'])) else {
            after.insert(key.clone(), source.clone());
            continue;
        };
        let output = kind.outputs().iter().find(|output| &*output.name == port).expect("it has the output");
        let inputs: Vec<&str> = match &output.fallback {
            Fallback::Input(input) => vec![&**input],
            _ => kind.inputs().iter().filter(|input| input.ty == output.ty).map(|input| &*input.name).collect(),
        };
        let is_other = |source: &&String| !source.starts_with(&format!("{}.", node.name));
        let main = inputs.iter().find_map(|input| before.get(&format!("{}.{input}", node.name)).filter(is_other));
        if let Some(main) = main {
            let (path, own) = main.split_once('@').unwrap_or((main, ""));
            let frames: u32 = frames.parse::<u32>().unwrap() + own.parse::<u32>().unwrap_or(0);
            after.insert(key.clone(), if own.is_empty() { path.into() } else { format!("{path}@{frames}") });
        }
    }
    after
}

fn each(mut edit: impl FnMut(&str, &File<'_>)) {
    let (files, pipelines) = shipped();
    assert!(pipelines.len() >= 13);
    for (name, text) in pipelines {
        edit(&text, &File { files: &files, name: &name, text: text.clone() });
    }
}

#[test]
fn every_node_of_every_pipeline_is_renamed_and_named_as_before() {
    each(|_, file| file.rename_each_node());
}

#[test]
fn every_node_of_every_pipeline_is_removed_or_the_check_says_why_not() {
    let mut removed = 0;
    each(|_, file| {
        let count = file.remove_each_node();
        removed += count;
    });
    assert!(removed > 60, "{removed}");
}

#[test]
fn a_node_comes_on_every_wire_of_every_pipeline_and_goes() {
    each(|_, file| {
        let inserted = file.insert_on_each_wire(1);
        assert!(inserted > 4, "{}: {inserted}", file.name);
    });
}

#[test]
fn every_input_of_every_pipeline_reads_an_earlier_frame_and_this_one_again() {
    each(|_, file| {
        let connected = file.connect_each_reader(1);
        assert!(connected > 3, "{}: {connected}", file.name);
    });
}

#[test]
fn every_node_is_off_at_one_tier_and_then_what_it_is_elsewhere() {
    each(|_, file| file.switch_each_node_at_its_tiers(2));
}

#[test]
fn line_ends_tabs_and_marks_stay() {
    each(|text, file| {
        let text = format!("\u{feff}{}", text.replace("    ", "\t").replace('\n', "\r\n"));
        let file = File { text, ..*file };
        file.rename_each_node();
        assert!(file.insert_on_each_wire(4) > 0, "{}", file.name);
        file.connect_each_reader(4);
        file.switch_each_node_at_its_tiers(5);
    });
}

#[test]
fn what_a_file_inherits_is_overridden_and_as_before() {
    each(|_, file| {
        let text = format!("// Own.\r\nPipeline(\r\n\textends: \"{}\", /* a look */\r\n)\r\n", file.name);
        let file = File { name: "own.ron", text, ..*file };
        assert!(file.insert_on_each_wire(3) > 0);
        assert!(file.connect_each_reader(3) > 0);
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn edits_that_are_taken_back_leave_any_layout(
        (own, gaps, windows) in (0..OWN.len(), proptest::collection::vec(any::<u8>(), 1..90), any::<bool>()),
    ) {
        let text = laid_out(OWN[own], &gaps, if windows { "\r\n" } else { "\n" });
        let files = folder();
        let file = File { files: &files, name: "a.ron", text };
        file.rename_each_node();
        // An empty `set` is one whose last override went.
        if !OWN[own].contains("set: {}") {
            file.insert_on_each_wire(1);
            file.connect_each_reader(1);
        }
    }
}
