//! A kind from a folder is freed with what holds it.

use std::sync::Arc;

use afterimage_graph::node::{NodeKind, Registry, folder_kind};

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

fn load() -> NodeKind {
    let kind = folder_kind(("posterize/node.ron", DECLARATION), ("posterize/posterize.wgsl", SHADER));
    kind.unwrap_or_else(|errors| panic!("{errors}"))
}

#[test]
fn a_kind_is_dropped_with_its_registry() {
    let kind = load();
    let held = Arc::downgrade(kind.counted().expect("a kind from a folder is counted"));
    let registry = Registry::new(&[&[kind]]).expect("one kind has one name");
    assert!(held.upgrade().is_some() && registry.get("Posterize").is_some());
    drop(registry);
    assert!(held.upgrade().is_none(), "something holds the kind");
}
