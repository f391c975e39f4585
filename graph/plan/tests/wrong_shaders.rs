//! Errors in the shaders of kinds in Rust are values of the planner, at the author's line.

use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_plan::{NodeShaderError, Options, PlanError};

use super::fusion::{RESULT, SOURCE, kind, like_source};
use super::support::{FRAME, plan_at};

static IMPORTING: Shader = Shader::new(
    "importing.wgsl",
    "// Light.\nimport afterimage::luminanse::luminance;\nfn bright(source: vec4f) -> vec4f { return source; }\n",
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
        let PlanError::Shaders(errors) = &error else { panic!("{error:?}") };
        assert!(matches!(&errors[..], [NodeShaderError { node, .. }] if node == "node"), "{error:?}");
        let error = error.to_string();
        assert!(error.starts_with(&format!("the shader of node `node` is wrong: {place}")), "{error}");
        assert!(error.contains(cause), "{error}");
    }
}

static MISFIT: Shader = Shader::new(
    "misfit.wgsl",
    "struct Misfit { amount: f32 }
fn misfit(source: vec4f, params: Misfit) -> vec4f { return params.amount * source; }
fn misfit_mask(mask: vec4f) -> vec4f { return mask; }
@compute @workgroup_size(1) fn misfit_count() {}
",
);

kind!(Misfit, "Does not fit its shader in three places.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let (first, second) = (pass.transient("first", desc), pass.transient("second", desc));
    pass.function(&MISFIT, "misfit").write_to(first);
    pass.function(&MISFIT, "misfit_mask").write_to(second);
    pass.compute(&MISFIT, "misfit_cout").dispatch([1, 1, 1]);
    pass.function(&IMPORTING, "bright").write("result", desc);
});

/// All errors of all nodes, each once, and none of them ends the thread: hosts may abort where something unwinds.
#[test]
fn the_errors_in_the_shaders_of_all_nodes_are_collected() {
    let kinds = [NodeKind::of::<Misfit>(), NodeKind::of::<Named>()];
    let text = r#"Pipeline(
        inputs: { "picture": Color },
        nodes: { "a": Misfit(source: "picture"), "b": Named(source: "a"), "c": Misfit(source: "b") },
        outputs: { "out": "c" },
    )"#;
    let registry = Registry::new(&[&kinds]).unwrap();
    let (graph, _) = check(&parse("test.ron", text).unwrap(), &registry, &CheckOptions::default()).unwrap();
    let error = plan_at(&graph, FRAME, Options::default()).unwrap_err().to_string();
    let lines: Vec<&str> = error.lines().filter(|line| line.starts_with("the shader of node ")).collect();
    let expected = [
        "the shader of node `a` is wrong: misfit.wgsl:1:1: `Misfit.amount` has no value",
        "the shader of node `a` is wrong: misfit.wgsl:3:1: `Misfit` has no input `mask`",
        "the shader of node `a` is wrong: misfit.wgsl:1:1: there is no entry point `misfit_cout`",
        "the shader of node `a` is wrong: importing.wgsl:2:",
        "the shader of node `b` is wrong: named.wgsl:1:1: there is no kernel function `brihgt`",
    ];
    assert_eq!(lines.len(), expected.len(), "{error}");
    for (line, expected) in lines.iter().zip(expected) {
        assert!(line.starts_with(expected), "{error}");
    }
    assert!(error.contains("help: did you mean `bright`?"), "{error}");
}

static HALF: Shader = Shader::new(
    "half.wgsl",
    "fn half_mean(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}
fn half_joined(source: vec4f, half: vec4f) -> vec4f { return source + half; }
",
);

kind!(Half, "Halves an image.", [SOURCE], RESULT, |pass| {
    let source = pass.image("source");
    let desc = ImageDesc::new(pass.desc(source).size.half());
    pass.function(&HALF, "half_mean").write("result", desc);
});
kind!(
    Joined,
    "Adds the pixels of two images.",
    [SOURCE, Input::image("half", "Another image.").optional()],
    RESULT,
    |pass| {
        let desc = like_source(pass);
        pass.function(&HALF, "half_joined").write("result", desc);
    }
);

#[test]
fn a_pixel_of_an_image_of_another_size_is_refused() {
    let registry = Registry::new(&[&[NodeKind::of::<Half>(), NodeKind::of::<Joined>()]]).unwrap();
    let planned = |nodes: &str| {
        let text = format!(
            r#"Pipeline(inputs: {{ "picture": Color }}, nodes: {{ {nodes} }}, outputs: {{ "out": "joined" }})"#
        );
        let (graph, _) = check(&parse("test.ron", &text).unwrap(), &registry, &CheckOptions::default()).unwrap();
        plan_at(&graph, FRAME, Options::default()).map(|_| ()).map_err(|error| error.to_string())
    };
    let mixed = r#""half": Half(source: "picture"), "joined": Joined(source: "picture", half: "half")"#;
    let refused = "node `joined` takes `half` as a pixel, but `half.result` is 320x180 and the result 640x360: give it \
                   an image of that size, or take a texture in the shader `half.wgsl` and read it with `tap`";
    assert_eq!(planned(mixed), Err(refused.into()));
    let halves = r#""half": Half(source: "picture"), "joined": Joined(source: "half", half: "half")"#;
    assert_eq!(planned(halves), Ok(()));
    let without = r#""joined": Joined(source: "picture")"#;
    assert_eq!(planned(without), Ok(()));
}

node_kind! {
    /// Lists its shader, which imports a file that does not exist.
    pub struct Listing {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[RESULT];
    const SHADERS: &'static [&'static Shader] = &[&IMPORTING];
}

impl Node for Listing {
    fn record(&self, _: &mut Recorder<'_>) {}
}

#[test]
fn an_error_in_a_listed_shader_is_an_error_of_the_registry() {
    let error = Registry::new(&[&[NodeKind::of::<Listing>()]]).unwrap_err().to_string();
    assert!(error.starts_with("the shader of `Listing` is wrong: importing.wgsl:2:"), "{error}");
    assert!(error.contains("luminanse"), "{error}");
}
