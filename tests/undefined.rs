//! Operations whose results WGSL or SPIR-V leaves open, in kinds without Rust: other nodes read finite numbers.

use afterimage_graph::node::{NodeKind, folder_kind};

use crate::support::gpu::{Picture, Run, graph_with};

/// Kinds, each with the four numbers of its result. `zero` is a zero that a compiler can find, `big` is large.
const KINDS: [(&str, [&str; 4]); 8] = [
    ("Quotients", ["source.x / zero", "zero / zero", "source.x / 0.0", "1.0 / (source.x * 0.0)"]),
    (
        "Vectors",
        ["(source / vec4f(0.0, 0.0, 0.0, 1.0)).x", "normalize(source.xyz * zero).x", "source.y % zero", "zero % zero"],
    ),
    (
        "Integers",
        [
            "f32(i32(source.x) / i32(zero))",
            "f32(i32(big) % i32(zero))",
            "f32((i32(zero) - 2147483647 - 1) / (i32(zero) - 1))",
            "f32((i32(zero) - 2147483647 - 1) % (i32(zero) - 1))",
        ],
    ),
    (
        "Shifts",
        [
            "f32(1u << (u32(zero) + 40u))",
            "f32(-8 >> (u32(zero) + 33u))",
            "f32(extractBits(7u, u32(big), 40u))",
            "f32(insertBits(1u, 2u, 30u, u32(big)))",
        ],
    ),
    (
        "Conversions",
        ["f32(i32(big * big))", "f32(u32(-big))", "f32(i32(zero / zero))", "unpack2x16float(0x7c00fe00u).x"],
    ),
    ("Roots", ["sqrt(-big)", "inverseSqrt(zero)", "pow(-big, 0.5)", "log(-big) + log2(zero)"]),
    ("Angles", ["asin(big)", "acos(-big)", "atan2(zero, zero)", "acosh(zero) + atanh(big)"]),
    (
        "Ranges",
        [
            "smoothstep(source.x, source.x + zero, source.y)",
            "clamp(source.x, big, zero)",
            "ldexp(source.x, i32(big)) + exp2(big)",
            "refract(source.xyz, source.yzx, big).x + table[i32(source.x / zero)] + bitcast<f32>(0x7fc00000u | u32(big))",
        ],
    ),
];

fn kind(name: &str, numbers: [&str; 4]) -> NodeKind {
    let declaration = format!(
        r#"Kind(
            name: "{name}", doc: "Numbers that are not defined.",
            inputs: {{ "source": Image(doc: "A picture.", accepts: [Exposed]) }},
            outputs: {{ "result": Image(doc: "Numbers.", state: Same("source")) }},
        )"#
    );
    let file = name.to_lowercase();
    let shader = format!(
        "fn {file}(source: vec4f) -> vec4f {{
    let zero = source.x - source.x;
    let big = 1e30 + source.y;
    var table = array(1.0, 2.0, 3.0, source.z);
    return vec4f({});
}}",
        numbers.join(", ")
    );
    folder_kind(("node.ron", &declaration), (&format!("{file}.wgsl"), &shader))
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_the_language_leaves_undefined_is_finite_for_other_nodes() {
    let kinds = KINDS.map(|(name, numbers)| kind(name, numbers));
    let names = KINDS.map(|(name, _)| name.to_lowercase());
    let nodes = KINDS.map(|(name, _)| {
        let node = name.to_lowercase();
        format!("\"{node}\": {name}(source: \"lit\"), \"of_{node}\": Vignette(source: \"{node}\", amount: 0.5)")
    });
    // The first half is stored, and the second becomes part of the pass that reads it.
    let outputs: Vec<String> =
        names[..4].iter().cloned().chain(names.iter().map(|name| format!("of_{name}"))).collect();
    let shown: Vec<String> = outputs.iter().map(|name| format!("\"{name}\": \"{name}\"")).collect();
    let graph = graph_with(
        &format!(
            "Pipeline(inputs: {{ \"in\": Color }}, nodes: {{ \"lit\": Exposure(source: \"in\", stops: 0.5), {} }}, \
             outputs: {{ {} }})",
            nodes.join(", "),
            shown.join(", ")
        ),
        &kinds,
    );
    let scene = Picture::new(4, 3, |x, y| [0.25 + x as f32, y as f32, 0.5, 1.0]);
    for (output, picture) in outputs.iter().zip(Run::new(&graph).frame(&[("in", &scene)])) {
        for (x, y) in (0..3).flat_map(|y| (0..4).map(move |x| (x, y))) {
            let pixel = picture.at(x, y);
            assert!(pixel.iter().all(|number| number.abs() <= 65504.0), "{output} at {x}, {y}: {pixel:?}");
        }
    }
}
