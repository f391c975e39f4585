//! Declarations of kinds in folders: a kind, or errors with words and places.

use afterimage_graph::node::{NodeKind, Registry, folder_kind_of};

use crate::document::has_words;

/// The shader of every declaration: `tint.wgsl`.
pub const SHADER: &str = "import afterimage::camera::{Camera, camera_distance};
struct Tint { levels: f32, strong: u32, place: vec2f }

fn tint(source: vec4f, params: Tint) -> vec4f { return source * params.levels; }

fn tint_mask(source: vec4f, mask: texture_2d<f32>, mask_sampler: sampler, at: Point) -> vec4f {
    return source * tap(mask, mask_sampler, at.uv).x;
}
fn tint_over(source: texture_2d<f32>, mask: texture_2d<f32>, at: Point) -> vec4f {
    return texel(source, at.pixel) * texel(mask, at.pixel);
}
fn tint_levels(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, 2 * at.pixel); }
fn tint_wide(levels: vec4f, coarser: texture_2d<f32>, low: texture_2d<f32>, at: Point) -> vec4f {
    return levels + texel(coarser, at.pixel / 2) + texel(low, at.pixel);
}
fn tint_end(wide: texture_2d<f32>, at: Point) -> vec4f { return texel(wide, at.pixel / 2); }
fn tint_far(source: vec4f, depth: texture_2d<f32>, camera: Camera, at: Point) -> vec4f {
    return source * camera_distance(camera, at.uv, texel(depth, at.pixel).x);
}
";

/// Declarations with each field, and with few.
pub(crate) const DECLARATIONS: [&str; 5] = [
    r#"Kind(
    name: "Tint",
    doc: "Tints.",
    inputs: {
        "source": Image(doc: "The image.", accepts: [Scene, Exposed, DisplayLinear, Encoded]),
    },
    outputs: { "result": Image(doc: "The result.", state: Same("source"), function: "tint", fallback: "source") },
    parameters: {
        "levels": Float(doc: "Levels.", default: 4.0, within: (2.0, 256.0), usually: (2.0, 16.0), unit: "1", neutral: 256.0),
        "strong": Bool(doc: "Whether it is strong.", default: false),
        "place": Vector2(doc: "A place.", default: (0.5, 0.5), within: (0.0, 1.0)),
    },
)"#,
    r#"Kind(
    name: "Tint",
    doc: "Tints.",
    inputs: { "source": Image(doc: "The image."), "mask": Image(doc: "Where.", optional: true) },
    outputs: {
        "result": Image(doc: "The result.", state: Encoded, function: "tint_over", size: Half),
        "other": Image(doc: "Another.", state: Same("source"), function: "tint_over", size: Fixed(256, 256), fallback: Zero),
    },
)"#,
    r#"Kind(name: "Tint", doc: "Tints.", inputs: { "source": Image(doc: "The image.") }, outputs: { "result": Image(doc: "The result.", state: Same("source"), fallback: Absent) })"#,
    r#"Kind(
    name: "Tint",
    doc: "Tints.",
    inputs: { "source": Image(doc: "The image.") },
    images: {
        "levels": Pyramid(down: "source", levels: 4, format: R32Float),
        "soft": Pyramid(each: "levels", function: "tint_levels", reads: { "source": Level("levels", 0) }),
        "wide": Image(up: "levels", reads: { "low": Level("soft", 2) }),
    },
    outputs: { "result": Image(doc: "The result.", state: Same("source"), function: "tint_end") },
)"#,
    r#"Kind(
    name: "Tint",
    doc: "Tints.",
    inputs: {
        "source": Image(doc: "The image."),
        "depth": Image(doc: "Depth.", accepts: [Data]),
        "camera": Camera(doc: "The camera."),
    },
    outputs: { "result": Image(doc: "The result.", state: Same("source"), function: "tint_far") },
)"#,
];

/// Words that the declarations do not use.
pub(crate) const WORDS: &[&str] = &[
    "Camera",
    "Volume",
    "Value",
    "Int",
    "Vector3",
    "Vector4",
    "Double",
    "Fixed(0, 0)",
    "Fixed(99999, 1)",
    "Mapped",
    "passes",
    "shader",
    "bindings",
    "true",
    "None",
    "\"\"",
    "\"\u{1b}[31m\"",
    "\"a b\"",
    "\"__x\"",
    "\"tint\"",
    "\"fn\"",
    "/*",
    "//",
    "\0",
    "\u{202e}",
];

/// True if the text declares a kind.
pub(crate) fn survives(text: &str) -> bool {
    match folder_kind_of(("node.ron", text), &[("tint.wgsl", SHADER)]) {
        Ok(kind) => {
            is_named(&kind);
            Registry::new(&[&[kind]]).is_ok()
        }
        Err(diagnostics) => {
            assert!(diagnostics.has_errors());
            has_words(&diagnostics);
            false
        }
    }
}

/// Names that pipelines may write.
fn is_named(kind: &NodeKind) {
    assert!(!kind.name().is_empty() && kind.name().chars().all(char::is_alphanumeric), "{:?}", kind.name());
    assert!(!kind.outputs().is_empty());
}
