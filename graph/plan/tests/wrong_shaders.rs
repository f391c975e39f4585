//! Errors in the shaders of kinds in Rust are values of the planner, at the author's line.

use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_plan::{Options, PlanError};

use super::fusion::{RESULT, SOURCE, kind, like_source};
use super::planned::{FRAME, plan_at};

static IMPORTING: Shader = Shader::new(
    "importing.wgsl",
    "// Light.\n#import luminanse\nfn bright(source: vec4f) -> vec4f { return source; }\n",
);
static NAMED: Shader = Shader::new("named.wgsl", "fn bright(source: vec4f) -> vec4f { return source; }\n");

kind!(Importing, "Imports a file that does not exist.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&IMPORTING, "bright").write("result", desc);
});
kind!(Named, "Calls a function that does not exist.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&NAMED, "brihgt").write("result", desc);
});

#[test]
fn errors_in_shaders_of_kinds_in_rust_are_values_at_the_authors_line() {
    let cases = [
        ("Importing", NodeKind::of::<Importing>(), "importing.wgsl:2:", "luminanse"),
        ("Named", NodeKind::of::<Named>(), "named.wgsl:1:", "brihgt"),
    ];
    for (name, kind, place, cause) in cases {
        let text = format!(
            r#"Pipeline(
                inputs: {{ "picture": Color }},
                nodes: {{ "node": {name}(source: "picture") }},
                outputs: {{ "out": "node" }},
            )"#
        );
        let registry = Registry::new(&[&[kind]]).unwrap();
        let (graph, _) = check(&parse("test.ron", &text).unwrap(), &registry, &CheckOptions::default()).unwrap();
        let error = plan_at(&graph, FRAME, Options::default()).unwrap_err();
        assert!(matches!(&error, PlanError::Shader { node, .. } if node == "node"), "{error:?}");
        let error = error.to_string();
        assert!(error.starts_with(&format!("the shader of node `node` is wrong: {place}")), "{error}");
        assert!(error.contains(cause), "{error}");
    }
}

params! {
    /// Lists its shader, which imports a file that does not exist.
    pub struct Listing {}
}

impl Node for Listing {
    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[RESULT];
    const SHADERS: &'static [&'static Shader] = &[&IMPORTING];

    fn record(&self, _: &mut Recorder<'_>) {}
}

#[test]
fn an_error_in_a_listed_shader_is_an_error_of_the_registry() {
    let error = Registry::new(&[&[NodeKind::of::<Listing>()]]).unwrap_err().to_string();
    assert!(error.starts_with("the shader of `Listing` is wrong: importing.wgsl:2:"), "{error}");
    assert!(error.contains("luminanse"), "{error}");
}
