//! The pipelines that come with the program.

/// Name and text of every file in `pipelines/` that renders one colour image.
pub(crate) const PIPELINES: &[(&str, &str)] = &[
    ("caracal", include_str!("../../../pipelines/caracal.ron")),
    ("glare", include_str!("../../../pipelines/glare.ron")),
    ("lynx", include_str!("../../../pipelines/lynx.ron")),
];

/// The built-in scene, with all that it knows.
pub(crate) const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "scene": "scene" },
)"#;
