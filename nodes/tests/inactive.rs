//! Parameters that do nothing under the present choices.

use std::collections::BTreeMap;

use afterimage_graph::image::Size;
use afterimage_graph::node::{Decisive, Inactive, InactiveParameters, NodeInUse, NodeInstance, NodeKind};
use afterimage_graph::value::Value;

fn kind(name: &str) -> &'static NodeKind {
    afterimage_nodes::ALL.iter().find(|kind| kind.name() == name).expect("it is built in")
}

/// A node with these values, and the defaults of the others.
fn node(name: &str, values: &[(&str, Value)]) -> NodeInstance {
    let kind = kind(name);
    let mut node = NodeInstance::new(kind.clone(), kind.params().iter().map(|param| param.default.clone()).collect());
    for (name, value) in values {
        let (index, _) = kind.param(name).expect("the kind has it");
        node.set(index, value.clone());
    }
    node
}

/// What decides whether a parameter does something.
fn decisive(node: &NodeInstance, name: &str) -> Option<String> {
    let wired = vec![true; node.kind().inputs().len()];
    let in_use = NodeInUse { instance: node, wired: &wired, size: Size::new(1920, 1080) };
    let (index, _) = node.kind().param(name)?;
    Some(match InactiveParameters::default().decisive(in_use, index)? {
        Decisive::Parameter(other, values) => {
            let values: Vec<String> = values.iter().map(Value::to_string).collect();
            format!("{}: {}", node.kind().params()[other].name, values.join(", "))
        }
        Decisive::Input(input) => format!("the input {}", node.kind().inputs()[input].name),
    })
}

/// The parameters that do nothing, with the reasons.
fn inactive(node: &NodeInstance) -> BTreeMap<String, Inactive> {
    let wired = vec![true; node.kind().inputs().len()];
    let in_use = NodeInUse { instance: node, wired: &wired, size: Size::new(1920, 1080) };
    let found = InactiveParameters::default().of(in_use);
    let named = node.kind().params().iter().zip(found);
    named.filter_map(|(param, why)| Some((param.name.to_string(), why?))).collect()
}

fn names(found: &BTreeMap<String, Inactive>) -> Vec<&str> {
    found.keys().map(String::as_str).collect()
}

const UCHIMURA: [&str; 6] = ["contrast", "linear_length", "linear_start", "maximum", "pedestal", "toe"];

#[test]
fn fourteen_parameters_of_a_tone_map_wait_for_another_curve_or_space() {
    let found = inactive(&node("ToneMap", &[]));
    let mut expected = UCHIMURA.to_vec();
    expected.extend(["blue", "exposure", "green", "look", "red", "sigmoid", "white", "white_level"]);
    expected.sort_unstable();
    assert_eq!(names(&found), expected);
    let decisive = |name: &str| decisive(&node("ToneMap", &[]), name);
    assert_eq!(decisive("toe"), Some("curve: Uchimura".into()));
    assert_eq!(decisive("white_level"), Some("curve: ReinhardExtended, ReinhardLuminance".into()));
    assert_eq!(decisive("red"), Some("space: Custom".into()));
}

#[test]
fn a_choice_wakes_its_parameters_and_others_fall_asleep() {
    let found = inactive(&node("ToneMap", &[("curve", Value::Choice("Uchimura")), ("gamut", Value::Choice("Clip"))]));
    assert!(UCHIMURA.iter().all(|name| !found.contains_key(*name)), "{found:?}");
    assert!(found.contains_key("gamut_knee") && found.contains_key("white_level"), "{found:?}");
    let found = inactive(&node("ToneMap", &[("curve", Value::Choice("AgX"))]));
    assert!(!found.contains_key("look") && !found.contains_key("sigmoid"), "{found:?}");
    assert!(matches!(&found["space"], Inactive::Refused(why) if why.contains("own working space")), "{found:?}");
}

#[test]
fn an_input_that_is_wired_makes_the_parameters_idle_that_it_replaces() {
    let dirt = node("LensDirt", &[]);
    assert_eq!(names(&inactive(&dirt)), ["scale", "seed"]);
    assert_eq!(decisive(&dirt, "seed"), Some("the input dirt".into()));
}

#[test]
fn of_every_kind_something_can_be_asked_and_not_all_parameters_are_idle() {
    for kind in afterimage_nodes::ALL {
        let found = inactive(&node(kind.name(), &[]));
        assert!(kind.params().is_empty() || found.len() < kind.params().len(), "{}: {found:?}", kind.name());
    }
}
