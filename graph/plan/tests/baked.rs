//! Tables in the place of nodes: which runs become one, how it is laid out, and what is counted for it.

use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, Signedness};
use afterimage_graph::node::{Arg, Bake, Origin, Pass};
use afterimage_plan::{Caps, Options, Plan, verify};

use super::support::{FRAME, all_formats, checked, plan_images};

/// The plan of nodes from `in`, which is exposed light, to `out`.
fn planned_with(nodes: &str, caps: Caps, options: Options) -> Plan {
    let graph = checked(&format!(
        r#"Pipeline(inputs: {{ "in": Exposed }}, nodes: {{ {nodes} }}, outputs: {{ "out": "out" }})"#
    ));
    let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), caps, options);
    assert_eq!(verify(&plan), Ok(()));
    plan
}

fn planned(nodes: &str) -> Plan {
    planned_with(nodes, all_formats(), Options::default())
}

/// The nodes of each table, joined.
fn tables(plan: &Plan) -> Vec<String> {
    plan.savings.baked.iter().map(|baked| baked.nodes.join(" ")).collect()
}

#[test]
fn a_run_is_as_long_as_each_node_reads_only_the_color_of_the_one_before() {
    let table = [
        // The nodes, and those of each table.
        (r#""out": ToneMap(source: "in", bake: Auto)"#, &["out"][..]),
        (r#""out": ToneMap(source: "in")"#, &[]),
        (r#""out": ToneMap(source: "in", bake: Off)"#, &[]),
        (
            r#""a": Exposure(source: "in", stops: 1.0), "b": ToneMap(source: "a", bake: Auto),
               "out": Encode(source: "b")"#,
            &["a b out"],
        ),
        (
            r#""a": Exposure(source: "in", stops: 1.0, bake: Off), "b": ToneMap(source: "a", bake: Auto),
               "out": Encode(source: "b")"#,
            &["b out"],
        ),
        // A vignette depends on the place.
        (
            r#""a": ToneMap(source: "in", bake: Auto), "b": Vignette(source: "a", amount: 0.5),
               "out": Encode(source: "b")"#,
            &["a"],
        ),
        // What others read, too, is stored.
        (
            r#""a": Exposure(source: "in", stops: 1.0), "b": ToneMap(source: "a", bake: Auto),
               "c": ToneMap(source: "a"), "out": Composite(base: "b", bloom: "c", strength: 0.5)"#,
            &["b"],
        ),
        // Two functions of what a table makes become two tables, but not beside a reader that needs it stored.
        (
            r#""a": ToneMap(source: "in", bake: Auto), "b": Saturation(source: "a", amount: 0.5),
               "c": Contrast(source: "a", amount: 0.5), "out": Composite(base: "b", bloom: "c", strength: 0.5)"#,
            &["a b", "a c"],
        ),
        (
            r#""a": ToneMap(source: "in", bake: Auto), "b": Saturation(source: "a", amount: 0.5),
               "c": Vignette(source: "a", amount: 0.5), "out": Composite(base: "b", bloom: "c", strength: 0.5)"#,
            &["a"],
        ),
        (
            r#""a": ToneMap(source: "in", bake: Auto), "b": Vignette(source: "a", amount: 0.5),
               "out": Saturation(source: "b", amount: 0.5, bake: 33)"#,
            &["a", "out"],
        ),
    ];
    for (nodes, expected) in table {
        assert_eq!(tables(&planned(nodes)), expected, "{nodes}");
    }
}

#[test]
fn what_all_nodes_are_told_replaces_what_they_ask_for_but_off() {
    let table = [
        ("", None, None),
        ("", Some(Bake::Auto), Some(64)),
        ("", Some(Bake::Size(33)), Some(33)),
        (", bake: 48", None, Some(48)),
        (", bake: Auto", None, Some(64)),
        (", bake: Auto", Some(Bake::Size(33)), Some(33)),
        (", bake: Auto", Some(Bake::Off), None),
        (", bake: Off", Some(Bake::Auto), None),
    ];
    for (asks, replaced, size) in table {
        let options = Options { bake: replaced, ..Options::default() };
        let nodes = format!(r#""out": ToneMap(source: "in"{asks})"#);
        let plan = planned_with(&nodes, all_formats(), options);
        assert_eq!(plan.savings.baked.first().map(|baked| baked.size), size, "{asks} {replaced:?}");
        let exact = planned_with(&nodes, all_formats(), Options { exact: true, ..options });
        assert!(exact.savings.baked.is_empty(), "a reference has no tables");
    }
    let sizes = r#""a": Exposure(source: "in", stops: 1.0, bake: 48), "out": ToneMap(source: "a", bake: 33)"#;
    let baked: Vec<u32> = planned(sizes).savings.baked.iter().map(|baked| baked.size).collect();
    assert_eq!(baked, [48], "the largest one");
}

/// A meter fills its table in every frame, so a size asks for it and `Auto` does not.
#[test]
fn a_value_of_the_device_enters_a_run_that_has_been_given_a_size() {
    let table = [
        // What the meter's node and the curve ask for, what replaces it, and the tables.
        ("", "Auto", None, vec![("b out", 64, false)]),
        ("bake: Auto", "Auto", None, vec![("b out", 64, false)]),
        ("bake: 33", "Auto", None, vec![("a b out", 33, true)]),
        ("bake: 33", "48", None, vec![("a b out", 48, true)]),
        ("bake: 33", "Off", None, vec![("a", 33, true), ("out", 64, false)]),
        ("bake: 33", "Auto", Some(Bake::Auto), vec![("b out", 64, false)]),
        ("bake: 33", "Auto", Some(Bake::Size(48)), vec![("a b out", 48, true)]),
        ("bake: 33", "Auto", Some(Bake::Off), vec![]),
    ];
    for (meter, curve, replaced, expected) in table {
        let nodes = format!(
            r#""bins": Histogram(source: "in"), "meter": AutoExposure(histogram: "bins"),
               "a": Exposure(source: "in", meter: "meter", {meter}), "b": ToneMap(source: "a", bake: {curve}),
               "out": Encode(source: "b", bake: Auto)"#
        );
        let plan = planned_with(&nodes, all_formats(), Options { bake: replaced, ..Options::default() });
        let baked = plan.savings.baked.iter().map(|baked| (baked.nodes.join(" "), baked.size, baked.in_every_frame));
        let expected: Vec<_> = expected.into_iter().map(|(nodes, size, each)| (nodes.to_owned(), size, each)).collect();
        assert_eq!(baked.collect::<Vec<_>>(), expected, "{meter} {curve} {replaced:?}");
        for (baked, (nodes, ..)) in plan.savings.baked.iter().zip(&expected) {
            let fills = |pass: &&Pass| pass.label.starts_with("fill table") && pass.nodes.join(" ") == *nodes;
            let fill = plan.work().find(fills).expect("a pass fills the table");
            let table = plan.image(fill.function_result().expect("it writes it"));
            // What each frame fills is an image of the frame, whose bytes count.
            let origin = if baked.in_every_frame { Origin::Transient } else { Origin::Retained };
            assert_eq!((table.origin.clone(), table.desc.bytes()), (origin, baked.bytes));
            assert_eq!(plan.to_text().contains("evaluated in every frame"), expected.iter().any(|(.., each)| *each));
        }
    }
}

/// The passes that fill a table and that read it.
fn passes(plan: &Plan) -> (&Pass, &Pass) {
    let fills = |at: &usize| plan.runs_on_change(*at);
    let fill = (0..plan.passes.len()).find(fills).expect("a pass fills the table");
    let table = plan.passes[fill].pass.function_result().expect("it writes it");
    let reads = |pass: &&Pass| pass.args().any(|arg| arg == Arg::Texture(table));
    (&plan.passes[fill].pass, plan.work().find(reads).expect("a pass reads it"))
}

#[test]
fn a_table_has_the_layout_that_its_shader_reads() {
    for size in Bake::SIZES {
        let nodes = format!(
            r#""a": Exposure(source: "in", stops: 1.0), "b": ToneMap(source: "a", bake: {size}),
               "out": Encode(source: "b")"#
        );
        let plan = planned(&nodes);
        let (fill, look) = passes(&plan);
        assert!(fill.label.starts_with("fill table"), "{}", fill.label);
        assert!(look.label.contains("look up"), "{}", look.label);
        assert_eq!(fill.nodes, ["a", "b", "out"]);
        let table = plan.image(fill.function_result().expect("it writes it"));
        assert_eq!((table.label.as_str(), table.origin.clone()), ("a.table", Origin::Retained));
        assert_eq!((table.desc.format, table.signedness), (Format::Rgba16Float, Signedness::Unsigned));
        // The first kernel makes the colors, and each other one changes those of the one before.
        let functions: Vec<&str> = fill.kernels.iter().map(|kernel| &*kernel.function).collect();
        assert_eq!((functions[0], functions.len()), ("bake_color", 4));
        for (at, kernel) in fill.kernels.iter().enumerate().skip(1) {
            assert!(kernel.args.iter().any(|arg| arg.value == Arg::Kernel(at - 1)), "{functions:?}");
        }
        let kernel = look.kernels.iter().find(|kernel| &*kernel.function == "bake").expect("it looks colors up");
        let numbers: Vec<f32> = kernel
            .uniform
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four bytes")))
            .collect();
        let [levels, ratios, negative, lowest, x, y] = numbers[..] else { panic!("{numbers:?}") };
        assert_eq!(fill.kernels[0].uniform, kernel.uniform, "both know one layout");
        let (width, height) = (table.desc.size.width, table.desc.size.height);
        // A gray is no mixture, so ratios are whole steps; each level has one more texel than steps; six parts.
        assert!(width.is_power_of_two() && width >= 4096, "{width}");
        assert_eq!((ratios, negative), ((size * 3 / 4) as f32, (size * 3 / 4 * 2 / 3) as f32));
        assert_eq!(height as f32, 6.0 * (ratios + 1.0));
        assert_eq!(levels, (width as f32 / (ratios + 1.0)).floor() - 1.0);
        assert!(levels >= 2.0 * size as f32 - 1.0, "a level for each step of the size: {levels}");
        assert_eq!((lowest, x, y), (0.0, 1.0 / width as f32, 1.0 / height as f32));
        let baked = &plan.savings.baked[0];
        assert_eq!((baked.size, baked.bytes), (size, 8 * u64::from(width) * u64::from(height)));
        let text = plan.to_text();
        let row = text.lines().skip_while(|line| *line != "baked LUTs in place of nodes").nth(1).expect("a LUT");
        let bytes = format!("{:.1} MiB", plan.savings.baked[0].bytes as f64 / f64::from(1 << 20));
        let parts = [row.starts_with("  a + b + out"), row.contains(&format!("size {size}")), row.ends_with(&bytes)];
        assert_eq!(parts, [true; 3], "{row}");
        // Two images are not stored, each of which a pass would write and another one read.
        let saved = 2 * u64::from(FRAME.width) * u64::from(FRAME.height) * 8;
        let fused: Vec<(&str, u64)> =
            plan.savings.fused.iter().map(|fused| (fused.image.as_str(), fused.bytes_saved)).collect();
        assert!(fused.contains(&("a.result", saved)) && fused.contains(&("b.result", saved)), "{fused:?}");
    }
}

#[test]
fn a_plan_of_one_frame_has_the_tables_alone_that_have_a_size() {
    let table = |bake: &str, options| tables(&planned_with(
        &format!(r#""a": ToneMap(source: "in", bake: {bake}), "out": Encode(source: "a")"#),
        all_formats(),
        options,
    ));
    let one_frame = Options { one_frame: true, ..Options::default() };
    assert_eq!(table("Auto", Options::default()), ["a out"]);
    assert!(table("Auto", one_frame).is_empty());
    assert_eq!(table("33", one_frame), ["a out"]);
    // An option of the user outweighs the file.
    assert_eq!(table("Auto", Options { bake: Some(Bake::Auto), ..one_frame }), ["a out"]);
}

#[test]
fn a_table_is_made_only_where_the_device_has_images_as_wide() {
    let nodes = r#""out": ToneMap(source: "in", bake: Auto)"#;
    let width = passes(&planned(nodes)).0.function_result().map(|image| planned(nodes).image(image).desc.size.width);
    let width = width.expect("there is a table");
    let with = |max_side| planned_with(nodes, Caps { max_side, ..all_formats() }, Options::default());
    assert_eq!(tables(&with(width)), ["out"]);
    assert!(tables(&with(width - 1)).is_empty());
}

#[test]
fn a_chain_of_many_nodes_has_tables_of_at_most_48_functions() {
    let chain: String = (1..100)
        .map(|at| {
            let source = if at == 1 { "in".to_owned() } else { format!("n{}", at - 1) };
            format!(r#""n{at}": Exposure(source: "{source}", stops: 0.5, bake: 33), "#)
        })
        .collect();
    let plan = planned(&format!(r#"{chain} "out": ToneMap(source: "n99", bake: 33)"#));
    let lengths: Vec<usize> = plan.savings.baked.iter().map(|baked| baked.nodes.len()).collect();
    assert_eq!(lengths, [48, 48, 4]);
}
