//! Each rule by an example: what is saved, and the whole text before and after it.

use afterimage_graph::check::Saver;
use afterimage_graph::value::{FileValue, Value};

use super::{Folder, float, registry, switch, value, values};

const BASE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 0.5),
        "bright": Extract(source: "exposed", threshold: 1.0),
        "white": WhiteBalance(source: "bright", target: (1.0, 0.5, 1)),
        "mapped": ToneMap(source: "white"),
    },
    outputs: { "display": "mapped" },
    tiers: {
        "low": { "bright.threshold": 2.0, "white": Off },
        "high": { "bright.threshold": 3.0 },
    },
)
"#;

/// Saves in a file alone; the text after it.
fn saved(text: &str, tier: Option<&str>, changes: &[afterimage_graph::check::Change]) -> String {
    saved_in(&Folder::default(), text, tier, changes)
}

fn saved_in(folder: &Folder, text: &str, tier: Option<&str>, changes: &[afterimage_graph::check::Change]) -> String {
    folder.save(text, tier, changes).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The first error of a save.
fn refused(folder: &Folder, text: &str, tier: Option<&str>, changes: &[afterimage_graph::check::Change]) -> String {
    let errors = folder.save(text, tier, changes).expect_err("the change is wrong");
    assert!(errors.iter().all(|error| !error.labels.is_empty()), "{errors}");
    let first = errors.iter().next().expect("an error");
    format!("{}: {}", first.code, first.message)
}

#[test]
fn a_value_changes_where_it_is_written() {
    let number = saved(BASE, None, &[float("exposed.stops", -2.0)]);
    assert_eq!(number, BASE.replace("stops: 0.5", "stops: -2.0"));
    let vector = value("white.target", Value::Vector([1.0, 0.25, 1.0, 0.0], 3));
    assert_eq!(saved(BASE, None, &[vector]), BASE.replace("(1.0, 0.5, 1)", "(1.0, 0.25, 1)"));
}

#[test]
fn a_default_becomes_a_field_of_its_node() {
    let choice = value("mapped.curve", Value::Choice("AgX"));
    assert_eq!(saved(BASE, None, &[choice]), BASE.replace("\"white\")", "\"white\", curve: AgX)"));
}

#[test]
fn values_of_before_change_nothing() {
    let graph = Folder::default().graph(BASE, Some("low"));
    let same = graph.parameters().map(|id| value(&graph.parameter_name(id), graph.value(id).clone()));
    let switches = graph.nodes.iter().map(|node| switch(&node.name, !node.off));
    let all: Vec<_> = same.chain(switches).collect();
    assert!(all.len() > 20);
    assert_eq!(saved(BASE, Some("low"), &all), BASE);
    let twice = [float("exposed.stops", 3.0), float("exposed.stops", 0.5)];
    assert_eq!(saved(BASE, None, &twice), BASE);
}

#[test]
fn a_value_of_a_tier_changes_in_the_tier() {
    let low = saved(BASE, Some("low"), &[float("bright.threshold", 7.0), switch("white", true)]);
    assert_eq!(low, BASE.replace("2.0, \"white\": Off", "7.0, \"white\": On"));
    // Another value is that of all tiers.
    let both = saved(BASE, Some("low"), &[float("exposed.stops", 1.0)]);
    assert_eq!(both, BASE.replace("stops: 0.5", "stops: 1.0"));
}

#[test]
fn a_switch_is_an_override_in_set() {
    let off = saved(BASE, None, &[switch("mapped", false)]);
    assert_eq!(off, BASE.replace("    },\n)", "    },\n    set: {\n        \"mapped\": Off,\n    },\n)"));
    assert_eq!(saved(&off, None, &[switch("mapped", true)]), off.replace("Off,\n    },\n)", "On,\n    },\n)"));
}

#[test]
fn an_inherited_value_becomes_an_override() {
    let folder = Folder::of(&[("base.ron", BASE)]);
    let own = "Pipeline(extends: \"base.ron\")";
    let expected = "Pipeline(extends: \"base.ron\", set: { \"exposed.stops\": 2.0 })";
    let text = saved_in(&folder, own, None, &[float("exposed.stops", 2.0)]);
    assert_eq!(text, expected);
    let more = saved_in(&folder, &text, None, &[value("mapped.curve", Value::Choice("AgX"))]);
    assert_eq!(more, expected.replace("2.0 }", "2.0, \"mapped.curve\": AgX }"));
}

#[test]
fn an_inherited_tier_is_copied_when_it_gives_the_value() {
    let folder = Folder::of(&[("base.ron", BASE)]);
    let own = "Pipeline(\r\n\textends: \"base.ron\",\r\n)\r\n";
    let text = saved_in(&folder, own, Some("low"), &[float("bright.threshold", 1e-7)]);
    let expected = "Pipeline(\r\n\textends: \"base.ron\",\r\n\ttiers: {\r\n\t\t\"low\": {\r\n\
                    \t\t\t\"bright.threshold\": 1e-7,\r\n\t\t\t\"white\": Off,\r\n\t\t},\r\n\t},\r\n)\r\n";
    assert_eq!(text, expected);
    assert_eq!(values(&folder.graph(&text, Some("high"))), values(&folder.graph(own, Some("high"))));
}

/// A pipeline used as a node has tiers of its own names; an override in `set` hides them.
#[test]
fn a_nested_value_becomes_an_override_and_tiers_keep_theirs() {
    let folder = Folder::of(&[("inner.ron", BASE)]);
    let own = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "look": Pipeline(file: "inner.ron", scene: "scene") },
    outputs: { "display": "look" },
    tiers: { "low": {}, "other": {} }
)"#;
    let text = saved_in(&folder, own, None, &[float("look/bright.threshold", 5.0)]);
    let low = "\"low\": {\n        \"look/bright.threshold\": 2.0,\n    }";
    let set = ",\n    set: {\n        \"look/bright.threshold\": 5.0,\n    }\n)";
    assert_eq!(text, own.replace("\"low\": {}", low).replace("\n)", set));
    // At the tier, the inner tier gives the value.
    let tier = saved_in(&folder, own, Some("low"), &[float("look/bright.threshold", 5.0)]);
    assert_eq!(tier, own.replace("\"low\": {}", &low.replace("2.0", "5.0")));
}

#[test]
fn a_pipeline_used_as_a_node_is_switched() {
    let folder = Folder::of(&[("inner.ron", BASE)]);
    let own = r#"Pipeline(inputs: { "scene": Color }, nodes: { "look": Pipeline(file: "inner.ron", scene: "scene") },
    outputs: { "display": "look" }, set: { "look": Off })"#;
    assert_eq!(saved_in(&folder, own, None, &[switch("look", true)]), own.replace("Off", "On"));
    // The nodes inside are off with it.
    assert_eq!(saved_in(&folder, own, None, &[switch("look/mapped", false)]), own);
    let inside = refused(&folder, own, None, &[switch("look/mapped", true)]);
    assert_eq!(inside, "off-around: `look/mapped` cannot be on while `look` is off");
    let both = [switch("look/mapped", false), switch("look", true)];
    let expected = own.replace("Off", "On, \"look/mapped\": Off");
    assert_eq!(saved_in(&folder, own, None, &both), expected);
}

#[test]
fn a_file_is_named_from_the_saved_file() {
    let cube = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 0.9 1\n";
    let base = r#"Pipeline(inputs: { "scene": Encoded }, nodes: { "look": ColorLut(source: "scene") },
    outputs: { "display": "look" }, tiers: { "a": { "look.file": "one.cube", "look.strength": 0.5 } })"#;
    let folder = Folder::of(&[("looks/base.ron", base), ("looks/one.cube", cube), ("two \"b\".cube", cube)]);
    let own = "Pipeline(extends: \"looks/base.ron\")";
    let path = value("look.file", Value::File(FileValue { path: "two \"b\".cube".into(), bytes: None }));
    let text = saved_in(&folder, own, None, std::slice::from_ref(&path));
    assert_eq!(text, r#"Pipeline(extends: "looks/base.ron", set: { "look.file": "two \"b\".cube" })"#);
    // What a copied tier names lies in the folder of the file that it comes from.
    let copied = saved_in(&folder, own, Some("a"), &[float("look.strength", 0.25)]);
    let tier = r#"{ "a": { "look.file": "looks/one.cube", "look.strength": 0.25 } }"#;
    assert_eq!(copied, format!("Pipeline(extends: \"looks/base.ron\", tiers: {tier})"));
    let missing = value("look.file", Value::File(FileValue { path: "no.cube".into(), bytes: None }));
    let told = refused(&folder, own, None, &[missing]);
    assert_eq!(told, "unreadable-file: cannot read `no.cube`: there is no such file");
}

#[test]
fn all_changes_become_a_new_tier() {
    let folder = Folder::of(&[("inner.ron", BASE)]);
    let saver = Saver::new("a.ron", BASE, registry(), &folder).expect("the text is right");
    let changes = [float("bright.threshold", 9.0), float("exposed.stops", 1.0)];
    let text = saver.save_as_tier("mine", Some("low"), &changes).unwrap_or_else(|errors| panic!("{errors}"));
    let tier = "        \"mine\": {\n            \"bright.threshold\": 9.0,\n            \"white\": Off,\n            \
                \"exposed.stops\": 1.0,\n        },\n    },\n)";
    assert_eq!(text, BASE.replace("    },\n)", tier));
    let empty = saver.save_as_tier("same", None, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(empty, BASE.replace("    },\n)", "        \"same\": {},\n    },\n)"));
    let doubled = saver.save_as_tier("low", None, &changes).expect_err("a tier has this name");
    assert!(doubled.to_string().contains("the pipeline has a tier `low` already"), "{doubled}");
}

/// The tiers of a pipeline used as a node do not apply under a new name.
#[test]
fn a_new_tier_has_what_inner_tiers_give() {
    let folder = Folder::of(&[("inner.ron", BASE)]);
    let own = r#"Pipeline(inputs: { "scene": Color }, nodes: { "look": Pipeline(file: "inner.ron", scene: "scene") },
    outputs: { "display": "look" }, tiers: { "low": {} })"#;
    let saver = Saver::new("a.ron", own, registry(), &folder).expect("the text is right");
    let text = saver.save_as_tier("mine", Some("low"), &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let tier = r#""low": {}, "mine": { "look/bright.threshold": 2.0, "look/white": Off } })"#;
    assert_eq!(text, own.replace("\"low\": {} })", tier));
    let hidden = saver.save_as_tier("high", None, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(hidden, own.replace("{} })", r#"{}, "high": { "look/bright.threshold": 1.0 } })"#));
}

#[test]
fn wrong_changes_are_errors() {
    let folder = Folder::of(&[("film.ron", BASE)]);
    let text = BASE.replace("    },\n)", "        \"film\": \"film.ron\",\n    },\n)");
    let refused = |tier, change| refused(&folder, &text, tier, &[change]);
    assert_eq!(refused(None, float("exposed.stop", 1.0)), "unknown-field: `exposed` has no parameter `stop`");
    assert_eq!(refused(None, float("expose.stops", 1.0)), "unknown-node: no node is called `expose`");
    assert_eq!(refused(None, switch("", true)), "unknown-node: no node is called ``");
    let out = refused(None, float("exposed.stops", 1e9));
    assert!(out.starts_with("out-of-domain: `exposed.stops` cannot be saved: `stops` must be within"), "{out}");
    assert!(refused(None, float("exposed.stops", f64::NAN)).ends_with("`stops` must be finite"));
    let ty = refused(None, value("exposed.stops", Value::Int(1)));
    assert_eq!(ty, "out-of-domain: `exposed.stops` cannot be saved: `stops` must be a number");
    assert_eq!(refused(Some("lo"), float("exposed.stops", 1.0)), "unknown-tier: the pipeline has no tier `lo`");
    let film = refused(Some("film"), float("exposed.stops", 1.0));
    assert_eq!(film, "tier-is-a-file: the tier `film` is a file: its values are not saved in this one");
    let broken = folder.save("Pipeline(nodes: {)", None, &[]).expect_err("the text is broken");
    assert!(broken.has_errors());
}

/// A pipeline used as a node may extend the file that uses it, if it replaces that node.
#[test]
fn a_file_that_is_used_twice_is_not_saved() {
    let own = BASE.replace("nodes: {", "nodes: {\n        \"again\": Pipeline(file: \"again.ron\", scene: \"scene\"),");
    let again = r#"Pipeline(extends: "a.ron", nodes: { "again": Exposure(source: "scene") })"#;
    let folder = Folder::of(&[("a.ron", own.as_str()), ("again.ron", again)]);
    assert!(folder.graph(&own, None).node("again/exposed").is_some());
    let told = refused(&folder, &own, None, &[float("exposed.stops", 1.0)]);
    assert_eq!(told, "used-twice: `a.ron` is extended by a pipeline that it uses as a node");
}

/// A kind may refuse two values together: both are saved at once, and one alone is refused for every tier.
#[test]
fn a_tier_that_would_become_wrong_refuses_the_change() {
    let text = r#"Pipeline(inputs: { "scene": Color }, nodes: { "bins": Histogram(source: "scene", lo: -8.0, hi: 8.0),
    "meter": AutoExposure(histogram: "bins"), "display": Exposure(source: "scene", meter: "meter") },
    outputs: { "display": "display" }, tiers: { "a": { "bins.hi": 2.0 } })"#;
    let folder = Folder::default();
    let told = |low| refused(&folder, text, None, &[float("bins.lo", low)]);
    assert_eq!(told(9.0), "unusable: `bins` cannot use its parameters: `hi` must be above `lo`");
    assert_eq!(told(4.0), "wrong-at-tier: the change cannot be saved: at the tier `a` it is wrong");
    assert_eq!(saved(text, None, &[float("bins.lo", 1.0)]), text.replace("-8.0", "1.0"));
    let at = saved(text, Some("a"), &[float("bins.hi", 12.0)]);
    assert_eq!(at, text.replace("2.0", "12.0"));
    let both = [float("bins.lo", 10.0), float("bins.hi", 11.0)];
    assert_eq!(saved(&at, None, &both), at.replace("lo: -8.0, hi: 8.0", "lo: 10.0, hi: 11.0"));
}

#[test]
fn a_mark_at_the_beginning_and_raw_names_stay() {
    let text = format!("\u{feff}{}", BASE.replace("nodes:", "r#nodes:").replace("0.5),", "0_5e-1f64),"));
    let number = "\u{feff}".to_owned() + &BASE.replace("nodes:", "r#nodes:").replace("stops: 0.5", "stops: 1.5");
    assert_eq!(saved(&text, None, &[float("exposed.stops", 1.5)]), number);
    assert_eq!(saved(&text, None, &[float("exposed.stops", 0.5)]), text);
}

/// Numbers are written in the fewest digits that read back.
#[test]
fn numbers_read_back() {
    for (number, text) in [
        (0.1 + 0.2, "0.30000000000000004"),
        (3.0, "3.0"),
        (-0.7, "-0.7"),
        (1e-7, "1e-7"),
        (1.0 / 3.0, "0.3333333333333333"),
    ] {
        let saved = saved(BASE, None, &[float("exposed.stops", number)]);
        assert_eq!(saved, BASE.replace("stops: 0.5", &format!("stops: {text}")));
        let graph = Folder::default().graph(&saved, None);
        let id = graph.parameter("exposed.stops").expect("it exists");
        assert_eq!(graph.value(id), &Value::Float(number));
    }
}
