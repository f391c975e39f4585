//! A kind from a folder.

use afterimage_graph::node::{NodeKind, folder_kind};

const DECLARATION: &str = r#"Kind(
    name: "Posterize",
    doc: "Leaves only a few levels of each color.",
    inputs: { "source": Image(doc: "The picture.", accepts: [DisplayLinear]) },
    outputs: { "result": Image(doc: "The picture in levels.", state: Same("source")) },
    parameters: { "levels": Float(doc: "Levels.", default: 4.0, within: (2.0, 256.0), unit: "levels") },
)"#;

const SHADER: &str = "struct Posterize { levels: f32 }

fn posterize(source: vec4f, params: Posterize) -> vec4f {
    return vec4f(round(source.rgb * params.levels) / params.levels, source.a);
}
";

/// Loads it.
pub(crate) fn posterize() -> NodeKind {
    let kind = folder_kind(("posterize/node.ron", DECLARATION), ("posterize/posterize.wgsl", SHADER));
    kind.unwrap_or_else(|errors| panic!("{errors}"))
}
