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
