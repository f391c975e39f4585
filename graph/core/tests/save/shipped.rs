//! Parameters of every shipped pipeline at every tier: one of twelve, or all for `tests/sweeps.sh`.

use std::path::{Path, PathBuf};

use afterimage_graph::check::{Checker, Graph, ParameterId, Saver};
use afterimage_graph::document::parse;
use afterimage_graph::value::{FileValue, Type, Value};

use super::{Folder, inserted, is_within, registry, tokens, value, values};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines")
}

const OTHER_LOOK: &str = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 0.9 1\n";

/// The shipped pipelines and the files that they may name.
pub(super) fn shipped() -> (Folder, Vec<(String, String)>) {
    let mut files = Folder::default();
    let mut pipelines = Vec::new();
    for place in [folder(), folder().join("looks")] {
        for entry in std::fs::read_dir(place).expect("the folder of pipelines") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(folder()).expect("it lies in the folder").to_string_lossy().into_owned();
            let Some(end) = path.extension() else { continue };
            let bytes = std::fs::read(&path).expect("a file can be read");
            if end == "ron" {
                pipelines.push((name.clone(), String::from_utf8(bytes.clone()).expect("a pipeline is text")));
            }
            files.0.insert(name, bytes.into());
        }
    }
    files.0.insert("looks/other.cube".to_owned(), OTHER_LOOK.as_bytes().into());
    pipelines.sort();
    (files, pipelines)
}

/// Parameters that take no other value alone: other values do not fit the format, the file or the curve of the node.
const FIXED: [&str; 8] = [
    "display.bits",
    "dithered.bits",
    "sdr.bits",
    "look.state",
    "looked.state",
    "graded.space",
    "mapped.space",
    "hdr-mapped.space",
];

/// Values near the present one, within the domain and not.
fn candidates(graph: &Graph, id: ParameterId) -> Vec<Value> {
    let moved = |x: f64| [x + 0.125, x - 0.125, x * 0.5, x + 1.0, x - 1.0, x + 0.015625];
    match (graph.declaration(id).ty, graph.value(id)) {
        (Type::Choice(choices), Value::Choice(present)) => {
            choices.iter().filter(|choice| choice.name != *present).map(|choice| Value::Choice(choice.name)).collect()
        }
        (_, Value::Bool(flag)) => vec![Value::Bool(!flag)],
        (_, Value::Int(whole)) => [1, -1, 2, 3].map(|step| Value::Int(whole + step)).into(),
        (_, Value::Float(x)) => moved(*x).map(Value::Float).into(),
        (_, Value::Vector(v, n)) => moved(0.0).map(|step| Value::Vector([v[0], v[1] + step, v[2], v[3]], *n)).into(),
        (_, Value::Text(text)) => vec![Value::Text(format!("{text} \"new\" \\ \u{e9}\n").as_str().into())],
        (_, Value::File(_)) => vec![Value::File(FileValue { path: "looks/other.cube".into(), bytes: None })],
        (_, Value::Choice(_)) => Vec::new(),
    }
}

/// The part of a pipeline text that holds a tier.
fn tier_text<'t>(text: &'t str, tier: &str) -> &'t str {
    let after = text.split_once("tiers: {").map_or("", |(_, after)| after);
    let own = after.split_once(&format!("\"{tier}\": {{")).map_or("", |(_, own)| own);
    own.split_once('}').map_or("", |(own, _)| own)
}

/// A pipeline at its tiers.
#[derive(Clone)]
struct Pipeline<'a> {
    files: &'a Folder,
    name: &'a str,
    text: &'a str,
    /// The text of the file that it extends; otherwise its own.
    base: &'a str,
    /// The text whose tiers it has: its own, that of the file that it extends or of the one that it uses as a node.
    tiers_text: &'a str,
    /// What the names of nodes in that text begin with here.
    prefix: &'a str,
    tiers: Vec<Option<String>>,
}

/// A pipeline with what is read of it once.
struct Read<'a> {
    pipeline: &'a Pipeline<'a>,
    checker: Checker<'a>,
    saver: Saver<'a>,
}

impl Read<'_> {
    /// What the pipeline says at a tier with overrides; none if that is an error.
    fn graph(&self, tier: Option<&str>, sets: &[(String, String)]) -> Option<Graph> {
        self.checker.check(tier, sets).ok().map(|(graph, _)| graph)
    }

    /// Saves other values of parameters at a tier; the number of all parameters, and those without another value.
    fn each_parameter(&self, tier: Option<&str>) -> (usize, Vec<String>) {
        let graph = self.graph(tier, &[]).expect("a shipped pipeline is right");
        let mut fixed = Vec::new();
        let is_whole = std::env::var("AFTERIMAGE_SWEEPS").is_ok_and(|asked| asked == "all");
        let step = if is_whole { 1 } else { 12 };
        // Other parameters in each pipeline and at each tier.
        let first = (self.pipeline.name.len() + tier.map_or(0, str::len)) % step;
        for id in graph.parameters().skip(first).step_by(step) {
            let key = graph.parameter_name(id);
            let set = |value: &Value| vec![(key.clone(), value.to_string())];
            let present = graph.value(id).to_string();
            let others = candidates(&graph, id).into_iter().filter(|value| value.to_string() != present);
            let accepted = others.into_iter().find_map(|value| {
                let wanted = self.graph(tier, &set(&value))?;
                let saved = self.saver.save(tier, &[super::value(&key, value.clone())]).ok()?;
                Some((wanted, value, saved))
            });
            match accepted {
                Some((wanted, value, saved)) => self.compare(tier, &key, (&value, &saved), &wanted),
                None => fixed.push(key),
            }
        }
        (graph.parameters().count(), fixed)
    }

    /// What the saved text says at every tier, and how it differs from the text before.
    fn compare(&self, tier: Option<&str>, key: &str, (new, saved): (&Value, &str), wanted: &Graph) {
        let Pipeline { files, name, text, tiers_text, prefix, tiers, .. } = self.pipeline;
        let what = format!("{name} {tier:?} {key} {new}\n{saved}");
        let document = parse(name, saved).unwrap_or_else(|errors| panic!("{errors}\n{what}"));
        let checker = Checker::new(&document, registry(), *files);
        let found = |tier| checker.check(tier, &[]).ok().map(|(graph, _)| values(&graph));
        assert_eq!(found(tier), Some(values(wanted)), "{what}");
        let quoted = format!("\"{}\"", key.strip_prefix(prefix).expect("all nodes are in it"));
        let gives = |tier: Option<&str>| tier.is_some_and(|tier| tier_text(tiers_text, tier).contains(&quoted));
        for other in tiers.iter().map(Option::as_deref).filter(|other| *other != tier) {
            let keeps = gives(tier) || gives(other);
            let sets = if keeps { Vec::new() } else { vec![(key.to_owned(), new.to_string())] };
            assert_eq!(found(other), self.graph(other, &sets).map(|graph| values(&graph)), "at {other:?}: {what}");
        }
        if prefix.is_empty() {
            self.pipeline.compare_texts(key, (new, saved), gives(tier), &what);
        } else {
            assert!(is_within(text, saved) && saved.contains(&format!("\"{key}\": {new}")), "{what}");
        }
        // Saved again, nothing changes.
        let again = Saver::new(name, saved, registry(), *files).unwrap_or_else(|errors| panic!("{errors}\n{what}"));
        let change = value(key, new.clone());
        assert_eq!(again.save(tier, &[change]).unwrap_or_else(|errors| panic!("{errors}\n{what}")), *saved);
    }
}

impl Pipeline<'_> {
    fn compare_texts(&self, key: &str, (new, saved): (&Value, &str), is_of_tier: bool, what: &str) {
        let (old_tokens, new_tokens) = (tokens(self.text), tokens(saved));
        if old_tokens.len() == new_tokens.len() {
            let differ = old_tokens.iter().zip(&new_tokens).filter(|(old, new)| old != new);
            let differ: Vec<_> = differ.collect();
            assert_eq!(differ.len(), 1, "{differ:?}: {what}");
            assert!(new.to_string().contains(differ[0].1), "{differ:?}: {what}");
            return;
        }
        let added = inserted(self.text, saved).unwrap_or_else(|| panic!("more than an insertion: {what}"));
        let (node, field) = key.rsplit_once('.').expect("a parameter of a node");
        let name = format!("\"{node}\"");
        // Tiers are behind the nodes, and may switch off one of another file by its name.
        let nodes = self.text.split_once("tiers: {").map_or(self.text, |(nodes, _)| nodes);
        let is_own = tokens(nodes).windows(2).any(|pair| pair == [name.as_str(), ":"]);
        let added = tokens(added).into_iter().filter(|token| !token.trim().is_empty()).collect::<Vec<_>>().join(" ");
        let value = tokens(&new.to_string()).into_iter().filter(|t| !t.trim().is_empty()).collect::<Vec<_>>().join(" ");
        let override_ = format!("\"{key}\" : {value}");
        match (is_own, is_of_tier) {
            (true, false) => {
                // The text differs from its end, or from its beginning where both are alike.
                let field = format!("{field} : {value}");
                let forms = [format!(", {field}"), format!("{field} ,")];
                assert!(forms.iter().any(|form| is_rotated(form, &added)), "{added}: {what}");
            }
            (false, false) => {
                let forms = [format!("{override_} ,"), format!("set : {{ {override_} , }} ,")];
                assert!(forms.iter().any(|form| is_rotated(form, &added)), "{added}: {what}");
            }
            // The tier is inherited, and copied.
            (_, true) => assert!(added.contains("tiers : {") && added.contains(&override_), "{added}: {what}"),
        }
    }
}

/// Whether two lists of tokens are one, begun at different tokens: an insertion after a comma may be seen from before
/// it.
fn is_rotated(wanted: &str, found: &str) -> bool {
    let (wanted, found): (Vec<&str>, Vec<&str>) = (wanted.split(' ').collect(), found.split(' ').collect());
    wanted.len() == found.len()
        && (0..wanted.len()).any(|by| wanted.iter().cycle().skip(by).zip(&found).all(|(a, b)| a == b))
}

fn each_pipeline(check: impl Fn(&Pipeline<'_>)) {
    let (files, pipelines) = shipped();
    assert!(pipelines.len() >= 8);
    for (name, text) in &pipelines {
        let document = parse(name, text).expect("a shipped pipeline is right");
        let tiers = Checker::new(&document, registry(), &files).tiers().into_iter().map(Some);
        let extended = document.extends.as_ref().map(|base| &base.value);
        let base = pipelines.iter().find(|(name, _)| Some(name) == extended).map_or(text, |(_, text)| text);
        let tiers_text = if document.tiers.is_empty() { base } else { text };
        let tiers = std::iter::once(None).chain(tiers).collect();
        check(&Pipeline { files: &files, name, text, base, tiers_text, prefix: "", tiers });
    }
}

impl Pipeline<'_> {
    fn save_each_parameter(&self) {
        let document = parse(self.name, self.text).unwrap_or_else(|errors| panic!("{errors}\n{}", self.text));
        let checker = Checker::new(&document, registry(), self.files);
        let saver = Saver::new(self.name, self.text, registry(), self.files);
        let read = Read { pipeline: self, checker, saver: saver.unwrap_or_else(|errors| panic!("{errors}")) };
        for tier in &self.tiers {
            let (count, fixed) = read.each_parameter(tier.as_deref());
            let is_known = |key: &String| FIXED.contains(&key.strip_prefix(self.prefix).expect("all nodes are in it"));
            assert!(count > 24 && fixed.iter().all(is_known), "{} {tier:?}: {fixed:?}", self.name);
        }
    }
}

#[test]
fn every_parameter_of_every_pipeline_is_saved_at_every_tier() {
    each_pipeline(|pipeline| pipeline.save_each_parameter());
}

#[test]
fn every_parameter_is_saved_in_a_file_that_inherits_it() {
    each_pipeline(|pipeline| {
        let text = format!("// Own.\nPipeline(\n    extends: \"{}\",\n)\n", pipeline.name);
        let tiers = vec![None, pipeline.tiers.last().cloned().flatten()];
        let own = Pipeline { name: "own.ron", text: &text, tiers, ..pipeline.clone() };
        own.save_each_parameter();
    });
}

/// The entries of the section `inputs`, of the file that is extended and of its own.
fn inputs_of(pipeline: &Pipeline<'_>) -> String {
    let entries = |text: &'_ str| {
        let (_, after) = text.split_once("inputs: {")?;
        Some(after.split_once('}')?.0.trim().trim_end_matches(',').to_owned())
    };
    let texts = [pipeline.base, pipeline.text];
    let own = if texts[0] == texts[1] { &texts[..1] } else { &texts[..] };
    own.iter().filter_map(|text| entries(text)).collect::<Vec<_>>().join(", ")
}

#[test]
fn every_parameter_is_saved_in_a_file_that_nests_it() {
    each_pipeline(|pipeline| {
        let inputs = inputs_of(pipeline);
        let names = inputs.split('"').skip(1).step_by(2);
        let wires: Vec<String> = names.map(|name| format!("{name}: \"{name}\"")).collect();
        let node = format!("Pipeline(file: \"{}\", {})", pipeline.name, wires.join(", "));
        let text = format!(
            "Pipeline(\n    inputs: {{ {inputs} }},\n    nodes: {{ \"outer\": {node} }},\n    \
             outputs: {{ \"display\": \"outer\" }},\n    \
             tiers: {{ \"low\": {{}} }},\n)\n"
        );
        let tiers = vec![None, Some("low".to_owned())];
        let own = Pipeline { name: "own.ron", text: &text, prefix: "outer/", tiers, ..pipeline.clone() };
        own.save_each_parameter();
    });
}
