//! The pipelines that come with the program.

/// Name and text of every file in `pipelines/` that needs no other file.
pub(crate) const PIPELINES: &[(&str, &str)] = &[
    ("caracal", include_str!("../../../pipelines/caracal.ron")),
    ("exposure", include_str!("../../../pipelines/exposure.ron")),
    ("glare", include_str!("../../../pipelines/glare.ron")),
    ("lynx", include_str!("../../../pipelines/lynx.ron")),
    ("tsushima", include_str!("../../../pipelines/tsushima.ron")),
];

/// The built-in scene.
pub(crate) const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "scene": "scene" },
)"#;
