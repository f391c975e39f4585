//! Ranges and domains of parameters, and the ports of a kind.

use afterimage_graph::node::contract;
use afterimage_graph::prelude::*;

node_kind! {
    /// Keeps every promise but those of its parameters.
    pub struct Loose {
        /// A range that leaves its domain at the lower end.
        pub low: f32 = 0.5 => within(0.0..=1.0), usually(-1.0..=0.5);
        /// A range that leaves its domain at the upper end.
        pub high: f32 = 0.5 => within(0.0..=1.0), usually(0.5..=2.0);
        /// An empty range.
        pub empty: f32 = 0.5 => within(0.0..=1.0), usually(0.5..=0.5);
        /// A range that is its domain.
        pub whole: f32 = 0.5 => within(0.0..=1.0), usually(0.0..=1.0);
        /// An empty domain.
        pub nowhere: f32 = 0.5 => within(0.5..=0.5);
        /// A domain without an end.
        pub endless: f32 = 0.5 => within(0.0..=f64::INFINITY);
        /// A neutral value outside.
        pub neutral: f32 = 0.5 => within(0.0..=1.0), neutral(2.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "A picture.")];
    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::same("source"), "The picture.").or_input("source"),
        Output::image("Result", OutputState::same("source"), ""),
    ];
}

impl Node for Loose {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        pass.set_output("result", InputValue::Image(source));
        pass.set_output("Result", InputValue::Image(source));
    }
}

#[test]
fn ranges_and_domains_are_checked() {
    let complaints = contract(&[NodeKind::of::<Loose>()]).expect_err("it breaks many");
    let named = |part: &str| complaints.iter().any(|complaint| complaint.contains(part));
    for part in [
        "the usual range of `low` leaves its domain",
        "the usual range of `high` leaves its domain",
        "the usual range of `empty` leaves its domain",
        "the domain of `nowhere` is not finite",
        "the domain of `endless` is not finite",
        "the neutral value of `neutral` is not acceptable",
        "the output `Result` has no doc",
    ] {
        assert!(named(part), "{part} is not in\n{}", complaints.join("\n"));
    }
    assert!(!named("`whole`") && !named("the output `result` has no doc"), "{}", complaints.join("\n"));
}

#[test]
fn a_kind_has_its_ports_and_no_others() {
    let kind = NodeKind::of::<Loose>();
    let names = |name| kind.output(name).map(|port| port.name.to_string());
    assert_eq!(names("result").as_deref(), Some("result"));
    assert_eq!(names("Result").as_deref(), Some("Result"));
    assert!(kind.output("source").is_none() && kind.input("result").is_none());
    assert_eq!(kind.input("source").map(|port| port.name.to_string()).as_deref(), Some("source"));
    assert_eq!(kind.param("whole").map(|(at, param)| (at, param.name.to_string())), Some((3, "whole".into())));
}
