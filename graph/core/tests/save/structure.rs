//! Edits of nodes and wires by example: the whole text before and after each of them.

use afterimage_graph::check::{Edit, Reader, Saver};

use super::{Folder, registry};

const BASE: &str = r#"Pipeline(
    inputs: { "scene": Color, "albedo": Data(optional: true) },
    nodes: {
        "counted": Histogram(source: "scene"), // of the scene
        "metered": AutoExposure(histogram: "counted"),
        "exposed": Exposure(source: "scene", meter: "metered"),

        // Light that spreads.
        "bright": Extract(source: "exposed", before: "bright.peaks@previous", threshold: 1.0),
        "mips": Downsample(source: "bright", levels: 4),
        "bloom": Upsample(source: "mips"),
        "lit": Composite(base: "exposed", bloom: "bloom", strength: 0.1),
        "mapped": ToneMap(source: "lit"),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display", "light": "lit" },
    set: { "bright.knee": 0.5 },
    tiers: {
        "low": { "bright.threshold": 2.0, "mapped.source": "exposed", "bloom": Off },
        "high": {},
    },
)
"#;

fn reader(node: &str, port: &str) -> Reader {
    Reader::input(node, port)
}

fn connect(reader: Reader, wire: &str) -> Edit {
    Edit::Connect { reader, wire: Some(wire.into()) }
}

fn insert(kind: &str, name: &str, reader: Reader) -> Edit {
    Edit::Insert { kind: kind.into(), name: name.into(), reader }
}

fn remove(node: &str) -> Edit {
    Edit::Remove { node: node.into() }
}

fn rename(node: &str, name: &str) -> Edit {
    Edit::Rename { node: node.into(), name: name.into() }
}

impl Folder {
    fn edit(&self, text: &str, tier: Option<&str>, edit: &Edit) -> Result<String, String> {
        let saver = Saver::new("a.ron", text, registry(), self).expect("the text has no syntax errors");
        saver.edit(tier, edit).map_err(|errors| {
            assert!(errors.iter().all(|error| !error.labels.is_empty()), "{errors}");
            let first = errors.iter().find(|error| error.code != "wrong-at-tier").expect("an error");
            format!("{}: {}", first.code, first.message)
        })
    }
}

fn edited(text: &str, tier: Option<&str>, edit: &Edit) -> Result<String, String> {
    Folder::default().edit(text, tier, edit)
}

/// A text with some of its parts replaced, each of which it has once.
fn replaced(text: &str, parts: &[(&str, &str)]) -> String {
    parts.iter().fold(text.to_owned(), |text, (old, new)| {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text.replace(old, new)
    })
}

#[test]
fn a_wire_changes_where_it_is_written() {
    let mapped = replaced(BASE, &[("ToneMap(source: \"lit\")", "ToneMap(source: \"exposed\")")]);
    assert_eq!(edited(BASE, None, &connect(reader("mapped", "source"), "exposed")).unwrap(), mapped);
    let of_tier = replaced(BASE, &[("\"mapped.source\": \"exposed\"", "\"mapped.source\": \"lit@previous\"")]);
    assert_eq!(edited(BASE, Some("low"), &connect(reader("mapped", "source"), "lit@previous")).unwrap(), of_tier);
    let output = replaced(BASE, &[("\"light\": \"lit\"", "\"light\": \"bright.peaks\"")]);
    assert_eq!(edited(BASE, None, &connect(Reader::Output("light".into()), "bright.peaks")).unwrap(), output);
}

#[test]
fn an_optional_input_gets_a_field_and_loses_it() {
    let albedo = connect(reader("counted", "albedo"), "albedo");
    let wired = replaced(BASE, &[("Histogram(source: \"scene\")", "Histogram(source: \"scene\", albedo: \"albedo\")")]);
    assert_eq!(edited(BASE, None, &albedo).unwrap(), wired);
    let none = Edit::Connect { reader: reader("counted", "albedo"), wire: None };
    assert_eq!(edited(&wired, None, &none).unwrap(), BASE);
    assert_eq!(edited(BASE, None, &none).unwrap(), BASE);
    let needed = Edit::Connect { reader: reader("counted", "source"), wire: None };
    assert_eq!(edited(BASE, None, &needed).unwrap_err(), "missing-port: `counted` has no `source`");
}

#[test]
fn an_inserted_node_is_one_line_and_one_wire() {
    let inserted = replaced(
        BASE,
        &[
            ("0.1),\n", "0.1),\n        \"dark\": Vignette(source: \"lit\"),\n"),
            ("ToneMap(source: \"lit\")", "ToneMap(source: \"dark\")"),
        ],
    );
    assert_eq!(edited(BASE, None, &insert("Vignette", "dark", reader("mapped", "source"))).unwrap(), inserted);
    assert_eq!(edited(&inserted, None, &remove("dark")).unwrap(), BASE);
    // Of an input of the pipeline, it is the first node.
    let first = edited(BASE, None, &insert("Vignette", "dark", reader("exposed", "source"))).unwrap();
    let line = "nodes: {\n        \"dark\": Vignette(source: \"scene\"),\n";
    let wire = ("Exposure(source: \"scene\"", "Exposure(source: \"dark\"");
    assert_eq!(first, replaced(BASE, &[("nodes: {\n", line), wire]));
    assert_eq!(edited(&first, None, &remove("dark")).unwrap(), BASE);
}

#[test]
fn what_does_not_fit_on_a_wire_is_refused_with_the_error_of_the_check() {
    let refusal = |kind, reader| edited(BASE, None, &insert(kind, "new", reader)).unwrap_err();
    assert!(refusal("Encode", reader("mapped", "source")).starts_with("state-conflict: "));
    assert!(refusal("Vignettes", reader("mapped", "source")).starts_with("unknown-kind: "));
    assert!(refusal("DemoScene", reader("mapped", "source")).starts_with("not-edited: "));
    let taken = edited(BASE, None, &insert("Vignette", "lit", reader("mapped", "source")));
    assert_eq!(taken.unwrap_err(), "doubled: a node is called `lit` already");
    let cycle = edited(BASE, None, &connect(reader("bright", "source"), "lit"));
    assert!(cycle.unwrap_err().starts_with("cycle: "));
}

#[test]
fn a_removed_node_is_read_no_more() {
    // Its readers get its source; overrides of it go, in the tier and in `set`.
    let extract =
        "        \"bright\": Extract(source: \"exposed\", before: \"bright.peaks@previous\", threshold: 1.0),\n";
    let without = replaced(
        BASE,
        &[
            (extract, ""),
            ("Downsample(source: \"bright\"", "Downsample(source: \"exposed\""),
            ("    set: { \"bright.knee\": 0.5 },\n", ""),
            ("\"bright.threshold\": 2.0, ", ""),
        ],
    );
    assert_eq!(edited(BASE, None, &remove("bright")).unwrap(), without);
    // What nothing can take the place of loses its wire, if it can be without.
    let unmetered = edited(BASE, None, &remove("metered")).unwrap();
    let line = ("        \"metered\": AutoExposure(histogram: \"counted\"),\n", "");
    assert_eq!(
        unmetered,
        replaced(BASE, &[line, ("Exposure(source: \"scene\", meter: \"metered\")", "Exposure(source: \"scene\")")])
    );
    let dark = edited(BASE, None, &remove("bloom")).unwrap();
    let bloom = ("        \"bloom\": Upsample(source: \"mips\"),\n", "");
    let parts = [bloom, (", bloom: \"bloom\"", ""), (", \"bloom\": Off", "")];
    assert_eq!(dark, replaced(BASE, &parts));
    assert!(edited(BASE, None, &remove("mapped")).unwrap_err().starts_with("state-conflict: "));
}

#[test]
fn a_tier_that_gives_the_source_of_a_removed_node_gives_that_of_its_readers() {
    let text = replaced(BASE, &[("\"high\": {}", "\"high\": { \"lit.base\": \"bright\" }")]);
    // An output is the same at all tiers.
    let output = edited(&text, None, &remove("lit")).unwrap_err();
    assert!(output.starts_with("not-saved: `light` cannot be saved"), "{output}");
    let text = replaced(&text, &[(", \"light\": \"lit\"", "")]);
    let high = "\"high\": {\n            \"mapped.source\": \"bright\",\n        }";
    let line = "        \"lit\": Composite(base: \"exposed\", bloom: \"bloom\", strength: 0.1),\n";
    let source = ("ToneMap(source: \"lit\")", "ToneMap(source: \"exposed\")");
    let expected = replaced(&text, &[(line, ""), source, ("\"high\": { \"lit.base\": \"bright\" }", high)]);
    assert_eq!(edited(&text, None, &remove("lit")).unwrap(), expected);
}

#[test]
fn a_name_changes_in_every_wire_and_override() {
    let renamed = edited(BASE, None, &rename("bright", "the \"glow\"")).unwrap();
    let expected = replaced(
        BASE,
        &[
            ("\"bright\": Extract", "\"the \\\"glow\\\"\": Extract"),
            ("\"bright.peaks@previous\"", "\"the \\\"glow\\\".peaks@previous\""),
            ("Downsample(source: \"bright\"", "Downsample(source: \"the \\\"glow\\\"\""),
            ("\"bright.knee\"", "\"the \\\"glow\\\".knee\""),
            ("\"bright.threshold\"", "\"the \\\"glow\\\".threshold\""),
        ],
    );
    assert_eq!(renamed, expected);
    assert_eq!(edited(&renamed, None, &rename("the \"glow\"", "bright")).unwrap(), BASE);
    let switched = edited(BASE, Some("low"), &rename("bloom", "light")).unwrap();
    assert!(switched.contains("\"light\": Off") && switched.contains("bloom: \"light\""), "{switched}");
    for (name, error) in [("lit", "doubled"), ("scene", "doubled"), ("a.b", "bad-name"), ("", "bad-name")] {
        let refusal = edited(BASE, None, &rename("bright", name)).unwrap_err();
        assert!(refusal.starts_with(error), "{name}: {refusal}");
    }
}

#[test]
fn a_node_is_switched_at_a_tier_alone() {
    let off = Edit::SwitchAtTier { node: "bright".into(), on: Some(false) };
    let high = edited(BASE, Some("high"), &off).unwrap();
    assert_eq!(high, BASE.replace("\"high\": {},", "\"high\": {\n            \"bright\": Off,\n        },"));
    assert_eq!(edited(BASE, None, &off).unwrap_err(), "not-edited: no tier is shown at which `bright` could differ");
    let again = Edit::SwitchAtTier { node: "bright".into(), on: None };
    assert_eq!(edited(&high, Some("high"), &again).unwrap(), BASE);
    let on = Edit::SwitchAtTier { node: "bloom".into(), on: Some(true) };
    assert_eq!(edited(BASE, Some("low"), &on).unwrap(), BASE.replace("\"bloom\": Off", "\"bloom\": On"));
    let elsewhere = Edit::SwitchAtTier { node: "bloom".into(), on: None };
    assert_eq!(edited(BASE, Some("low"), &elsewhere).unwrap(), BASE.replace(", \"bloom\": Off", ""));
}

#[test]
fn what_an_inherited_node_reads_is_an_override() {
    let folder = Folder::of(&[("base.ron", BASE)]);
    let own = "Pipeline(\r\n\textends: \"base.ron\", // the look\r\n)\r\n";
    let wire = connect(reader("mapped", "source"), "exposed");
    let set = "look\r\n\tset: {\r\n\t\t\"mapped.source\": \"exposed\",\r\n\t},\r\n";
    let wired = folder.edit(own, None, &wire).unwrap();
    assert_eq!(wired, own.replace("look\r\n", set));
    assert_eq!(folder.edit(&wired, None, &connect(reader("mapped", "source"), "lit")).unwrap(), own);
    let inserted = folder.edit(own, None, &insert("Vignette", "dark", reader("mapped", "source"))).unwrap();
    let node = "look\r\n\tnodes: {\r\n\t\t\"dark\": Vignette(source: \"lit\"),\r\n\t},\r\n\tset: {\r\n\t\t\
                \"mapped.source\": \"dark\",\r\n\t},\r\n";
    assert_eq!(inserted, own.replace("look\r\n", node));
    assert_eq!(folder.edit(&inserted, None, &remove("dark")).unwrap(), own);
    let output = folder.edit(own, None, &connect(Reader::Output("light".into()), "bright")).unwrap();
    let outputs = "look\r\n\toutputs: {\r\n\t\t\"light\": \"bright\",\r\n\t},\r\n";
    assert_eq!(output, own.replace("look\r\n", outputs));
}

#[test]
fn nodes_of_other_files_are_refused_with_their_places() {
    let inner = r#"Pipeline(inputs: { "scene": Color }, nodes: { "kept": Extract(source: "scene") },
        outputs: { "light": "kept" })"#;
    let folder = Folder::of(&[("base.ron", BASE), ("looks/inner.ron", inner)]);
    let own = r#"Pipeline(extends: "base.ron", nodes: { "lit": Composite(base: "exposed", bloom: "bloom"),
        "glow": Pipeline(file: "looks/inner.ron", scene: "scene") }, outputs: { "light": "glow" })"#;
    let refusal = |edit: &Edit| folder.edit(own, None, edit).unwrap_err();
    let inherited = "not-edited: `bright` is written in `base.ron`, which this file extends";
    assert_eq!(refusal(&remove("bright")), inherited);
    assert_eq!(refusal(&rename("bright", "x")), inherited);
    let replacing = "not-edited: `lit` takes the place of a node of `base.ron`";
    assert_eq!(refusal(&remove("lit")), replacing);
    assert_eq!(refusal(&rename("lit", "x")), replacing);
    let nested = "not-edited: `glow/kept` is written in `looks/inner.ron`, which `glow` uses";
    assert_eq!(refusal(&remove("glow/kept")), nested);
    assert_eq!(refusal(&connect(reader("glow/kept", "source"), "scene")), nested);
    assert_eq!(refusal(&insert("Vignette", "x", reader("glow/kept", "source"))), nested);
    let none = Edit::Connect { reader: reader("mapped", "source"), wire: None };
    let kept = "not-edited: the wire to `source` of `mapped` is written in `base.ron`: no override takes it away";
    assert_eq!(refusal(&none), kept);
    let unknown = refusal(&connect(reader("mapped", "sauce"), "lit"));
    assert_eq!(unknown, "unknown-field: `mapped` has no input `sauce`");
    assert_eq!(refusal(&remove("nothing")), "unknown-node: no node is called `nothing`");
    let nowhere = refusal(&connect(Reader::Output("lights".into()), "lit"));
    assert_eq!(nowhere, "unknown-output: the pipeline has no output `lights`");
}

#[test]
fn a_pipeline_used_as_a_node_is_edited_like_a_node() {
    let folder = Folder::of(&[("inner.ron", BASE)]);
    let own = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": WhiteBalance(source: "scene"),
        "look": Pipeline(file: "inner.ron", scene: "exposed", set: { "lit.strength": 0.5 }),
    },
    outputs: { "display": "look", "light": "look.light" },
    tiers: { "low": { "look/bloom": Off } },
)
"#;
    let wired = folder.edit(own, None, &connect(reader("look", "scene"), "scene")).unwrap();
    assert_eq!(wired, own.replace("scene: \"exposed\"", "scene: \"scene\""));
    let renamed = folder.edit(own, None, &rename("look", "chain")).unwrap();
    assert_eq!(renamed, own.replace("\"look", "\"chain"));
    let graph = folder.graph(&renamed, Some("low"));
    assert!(graph.node("chain/bloom").is_some_and(|(_, node)| node.off));
}

#[test]
fn a_node_is_added_with_wires_that_fit() {
    let files = Folder::default();
    let saver = Saver::new("a.ron", BASE, registry(), &files).unwrap();
    let edit = saver.addition(None, "Composite", Some("lit")).unwrap();
    let Edit::Add { inputs, .. } = &edit else { panic!("{edit:?}") };
    assert_eq!(inputs[0], ("base".into(), "lit".into()));
    let added = saver.edit(None, &edit).unwrap();
    assert!(added.contains("        \"composite\": Composite(base: \"lit\"),"), "{added}");
    let edit = saver.addition(None, "Encode", Some("lit")).unwrap();
    let added = saver.edit(None, &edit).unwrap();
    assert!(added.contains("\"encode\": Encode(source: \"mapped\"),"), "{added}");
    assert_eq!(saver.unused_name("LitHaze").unwrap(), "lit_haze");
    assert_eq!(saver.unused_name("Lit").unwrap(), "lit_2");
}

#[test]
fn candidates_are_refused_with_the_error_that_the_edit_has() {
    let files = Folder::default();
    let saver = Saver::new("a.ron", BASE, registry(), &files).unwrap();
    let source = reader("mapped", "source");
    let candidates = saver.candidates(None, saver.sources(None, &source, 0).unwrap());
    let wires: Vec<&str> = candidates.iter().map(|candidate| &*candidate.wire).collect();
    assert_eq!(wires[..4], ["scene", "albedo", "counted", "counted.brightest"]);
    assert!(wires.contains(&"bright.peaks") && wires.contains(&"metered.range"), "{wires:?}");
    let refused: Vec<&str> =
        candidates.iter().filter(|candidate| candidate.refusal.is_some()).map(|candidate| &*candidate.wire).collect();
    assert!(refused.contains(&"display") && refused.contains(&"mips") && refused.contains(&"mapped"), "{refused:?}");
    assert!(!refused.contains(&"exposed") && !refused.contains(&"bright"), "{refused:?}");
    for candidate in candidates {
        let edit = connect(candidate.reader, &candidate.wire);
        let own = saver.edit(None, &edit).err().map(|errors| errors.to_string());
        assert_eq!(candidate.refusal.map(|errors| errors.to_string()), own, "{}", candidate.wire);
    }
    let earlier = saver.candidates(None, saver.sources(None, &source, 1).unwrap());
    let loops = earlier.iter().find(|candidate| candidate.wire == "lit@previous").unwrap();
    assert!(loops.refusal.is_none());
    let readers = saver.candidates(None, saver.readers(None, "metered").unwrap());
    let taken: Vec<String> =
        readers.iter().filter(|candidate| candidate.refusal.is_none()).map(|taken| taken.reader.to_string()).collect();
    assert_eq!(taken, ["`meter` of `exposed`"]);
    let kinds = saver.kinds_between(None, &source).unwrap();
    let names: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
    assert!(names.contains(&"Vignette") && names.contains(&"WhiteBalance"), "{names:?}");
    assert!(!names.contains(&"Encode"), "{names:?}");
}

#[test]
fn usual_parameters_follow_their_nodes() {
    let usual =
        "usual: { \"lit.strength\": \"of the glow\", \"bright.threshold\": \"of white\" }, // first\n    set: {";
    let text = replaced(BASE, &[("set: {", usual)]);
    let renamed = edited(&text, None, &rename("lit", "glowing")).unwrap();
    assert!(renamed.contains("\"glowing.strength\": \"of the glow\""), "{renamed}");
    assert_eq!(edited(&renamed, None, &rename("glowing", "lit")).unwrap(), text);
    let removed = edited(&text, None, &remove("lit")).unwrap();
    assert!(removed.contains("usual: { \"bright.threshold\": \"of white\" }, // first"), "{removed}");
    let read = text.replace(", \"albedo\": Data(optional: true)", "");
    let wrong = read.replace("lit.strength\":", "lit.strenth\":");
    let told = edited(&wrong, None, &rename("mips", "levels")).unwrap_err();
    assert!(told.starts_with("unknown-name: `lit` has no parameter `strenth`"), "{told}");
}
