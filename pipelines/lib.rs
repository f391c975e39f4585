//! The built-in pipelines of Afterimage as text, for programs that have no folder of pipelines.

use std::sync::Arc;

use afterimage_graph::check::Loader;

/// Name and text of every pipeline. The last ones extend another or name one of the [`TABLES`]; [`BuiltIn`] loads both.
pub const PIPELINES: &[(&str, &str)] = &[
    ("caracal", include_str!("caracal.ron")),
    ("cookbook", include_str!("cookbook.ron")),
    ("exposure", include_str!("exposure.ron")),
    ("glare", include_str!("glare.ron")),
    ("hdr", include_str!("hdr.ron")),
    ("lynx", include_str!("lynx.ron")),
    ("matinee", include_str!("matinee.ron")),
    ("mobile", include_str!("mobile.ron")),
    ("photo", include_str!("photo.ron")),
    ("portrait", include_str!("portrait.ron")),
    ("silver", include_str!("silver.ron")),
    ("tsushima", include_str!("tsushima.ron")),
    ("cinematic", include_str!("cinematic.ron")),
    ("course", include_str!("course.ron")),
    ("grade", include_str!("grade.ron")),
    ("tsushima-night", include_str!("tsushima-night.ron")),
    ("upscale", include_str!("upscale.ron")),
];

/// Path and bytes of every table that pipelines name.
pub const TABLES: &[(&str, &[u8])] = &[("looks/dusk.cube", include_bytes!("looks/dusk.cube"))];

/// Loads the files that built-in pipelines name from the binary.
pub struct BuiltIn;

impl Loader for BuiltIn {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let pipeline = || PIPELINES.iter().find(|(name, _)| path.strip_suffix(".ron") == Some(name));
        let table = TABLES.iter().find(|(name, _)| path == *name).map(|(_, bytes)| *bytes);
        let bytes = table.or_else(|| pipeline().map(|(_, text)| text.as_bytes()));
        bytes.map(Into::into).ok_or_else(|| "it is not built in".into())
    }
}
