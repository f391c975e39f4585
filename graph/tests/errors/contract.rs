//! The contract of node kinds: good tables pass, and each broken promise is named.

use afterimage_graph::node::contract;
use afterimage_graph::prelude::*;

static SHADER: Shader = Shader::new(
    "plugin/Careless.wgsl",
    "struct Careless { amount: f32 }\n\
     fn helper(x: f32) -> f32 { return x; }\n\
     fn careless(source: vec4f, params: Careless) -> vec4f { return source * helper(params.amount); }\n\
     fn careless_lost(elsewhere: vec4f) -> vec4f { return elsewhere; }\n",
);

choices! {
    /// What goes wrong.
    pub enum Mistake {
        /// Nothing.
        Nothing,
        /// An argument that is no port.
        Argument,
        /// Nothing is given.
        Gift,
    }
}

params! {
    /// Breaks promises.
    pub struct Careless {
        /// In its domain.
        pub amount: f32 = 2.0 => within(0.0..=1.0);
        /// Without a domain.
        pub open: f32 = 0.0;
        /// Which promise.
        pub mistake: Mistake = Mistake::Nothing;
    }
}

impl Node for Careless {
    const INPUTS: &'static [Input] =
        &[Input::image("source", ""), Input::new("target", PortType::Value, "A word of WGSL.").optional()];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("sauce"), "The picture.").or_input("target")];

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        match self.mistake {
            Mistake::Nothing => drop(pass.function(&SHADER, "careless").write("result", desc)),
            Mistake::Argument => drop(pass.function(&SHADER, "careless_lost").write("result", desc)),
            Mistake::Gift => {}
        }
    }
}

#[test]
fn every_broken_promise_is_named() {
    let complaints = contract(&[NodeKind::of::<Careless>()]).expect_err("it breaks many");
    for part in [
        "`Careless`: the input `source` has no doc",
        "`target` is a word of WGSL",
        "the state of `result` follows `sauce`, which is no required image input",
        "the fallback of `result` (Image) is `target` (Value)",
        "the default of `amount` is not acceptable: `amount` must be within 0 and 1",
        "the numbers of `open` have no domain",
        "the file `plugin/Careless.wgsl` is not called after a kind, in snake_case",
        "recording fails: `Careless` has no input `elsewhere`",
        "the output `result` is wanted and not given as a Image",
    ] {
        assert!(
            complaints.iter().any(|complaint| complaint.contains(part)),
            "{part} is not in\n{}",
            complaints.join("\n")
        );
    }
}

#[test]
fn the_built_in_kinds_keep_it() {
    contract(afterimage_nodes::ALL).unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
}

params! {
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
}

impl Node for Loose {
    const INPUTS: &'static [Input] = &[Input::image("source", "A picture.")];
    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::same("source"), "The picture.").or_input("source"),
        Output::image("Result", OutputState::same("source"), ""),
    ];

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        pass.give("result", Arrival::Image(source));
        pass.give("Result", Arrival::Image(source));
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
