//! The pipelines in the binary.

use std::sync::Arc;

use afterimage_graph::check::Loader;

/// Name and text of every file in `pipelines/`. The last ones extend another or name a table, which [`BuiltIn`] loads.
pub(crate) const PIPELINES: &[(&str, &str)] = &[
    ("caracal", include_str!("../../../pipelines/caracal.ron")),
    ("cookbook", include_str!("../../../pipelines/cookbook.ron")),
    ("exposure", include_str!("../../../pipelines/exposure.ron")),
    ("glare", include_str!("../../../pipelines/glare.ron")),
    ("hdr", include_str!("../../../pipelines/hdr.ron")),
    ("lynx", include_str!("../../../pipelines/lynx.ron")),
    ("mobile", include_str!("../../../pipelines/mobile.ron")),
    ("tsushima", include_str!("../../../pipelines/tsushima.ron")),
    ("cinematic", include_str!("../../../pipelines/cinematic.ron")),
    ("course", include_str!("../../../pipelines/course.ron")),
    ("grade", include_str!("../../../pipelines/grade.ron")),
    ("tsushima-night", include_str!("../../../pipelines/tsushima-night.ron")),
];

/// Loads the files that built-in pipelines name from the binary.
pub(crate) struct BuiltIn;

impl Loader for BuiltIn {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let pipeline = || PIPELINES.iter().find(|(name, _)| path.strip_suffix(".ron") == Some(name));
        match path {
            "looks/dusk.cube" => Ok(include_bytes!("../../../pipelines/looks/dusk.cube").as_slice().into()),
            _ => pipeline().map(|(_, text)| text.as_bytes().into()).ok_or_else(|| "it is not built in".into()),
        }
    }
}

/// The built-in scene.
pub(crate) const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "scene": "scene" },
)"#;

/// The built-in scene, with what a renderer gives besides its light.
pub(crate) const RENDERER: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "scene": "scene", "depth": "scene.projected", "normal": "scene.normal", "motion": "scene.motion" },
)"#;
