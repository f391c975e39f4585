//! Drawing passes: what they draw, compared with triangles that are computed in f64.

mod blend;
mod blend_modes;
mod draws;
mod host;
mod kinds;
mod raster;

use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{Drawing, PassKind, Registry};
use afterimage_plan::{Alias, Plan, Stage, Use, verify};

use crate::support::gpu::{Picture, Run, gpu};
use crate::support::layer;
use kinds::{CLEARS, LARGE, OTHER, SHIFTS, Vertex};

/// The places of four samples in a pixel, as every device has them.
const SAMPLES: [[f64; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];
const CENTER: [f64; 2] = [0.5, 0.5];
const SIZE: Size = Size { width: 64, height: 32, depth: 1 };

/// A graph with these outputs, commas between them.
fn graph(nodes: &str, outputs: &str) -> Graph {
    let outputs = outputs.split(',').enumerate().map(|(at, output)| format!("\"out{at}\": \"{output}\", "));
    let outputs = outputs.collect::<String>();
    let text = format!("Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})");
    let document = parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL, kinds::ALL]).expect("no two kinds share a name");
    check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// The plan and the picture of an output.
fn drawn(nodes: &str, output: &str) -> (Plan, Picture) {
    let (plan, mut pictures) = all_drawn(nodes, output);
    (plan, pictures.remove(0))
}

/// The plan and the pictures of all outputs, after the layer has seen two frames and found nothing.
fn all_drawn(nodes: &str, output: &str) -> (Plan, Vec<Picture>) {
    let _alone = layer::alone();
    let graph = graph(nodes, output);
    let mut run = Run::new(&graph).exact();
    run.size = SIZE;
    let plan = run.plan(&gpu(), &[]);
    verify(&plan).unwrap_or_else(|faults| panic!("{faults:?}"));
    layer::messages();
    let mut pictures = run.frames(&[], &[(0.0, true), (0.1, false)]);
    assert_eq!(layer::messages(), Vec::<String>::new(), "{nodes}");
    let last = pictures.pop().expect("two frames");
    assert_eq!(pictures, std::slice::from_ref(&last), "{nodes}: the second frame is another");
    (plan, last)
}

fn result(node: &str) -> Picture {
    drawn(&format!("\"result\": {node}"), "result").1
}

/// Color and depth of a triangle at a place of a pixel; `None` outside.
fn at(triangle: &[Vertex; 3], size: Size, (x, y): (u32, u32), place: [f64; 2]) -> Option<([f64; 4], f64)> {
    let sides = [f64::from(size.width), f64::from(size.height)];
    let corner = |vertex: &Vertex| {
        let [u, v, _] = vertex.0.map(f64::from);
        [(u + 1.0) / 2.0 * sides[0], (1.0 - v) / 2.0 * sides[1]]
    };
    let corners = triangle.each_ref().map(corner);
    let here = [f64::from(x) + place[0], f64::from(y) + place[1]];
    let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let whole = area(corners[0], corners[1], corners[2]);
    let shares = [1, 2, 0].map(|first| area(corners[first], corners[(first + 1) % 3], here) / whole);
    assert!(shares.iter().all(|share| share.abs() > 1e-9), "{x}, {y} is on an edge");
    let mix = |number: &dyn Fn(&Vertex) -> f32| -> f64 {
        triangle.iter().zip(shares).map(|(vertex, share)| f64::from(number(vertex)) * share).sum()
    };
    let color = [0, 1, 2, 3].map(|channel| mix(&|vertex| vertex.1[channel]));
    shares.iter().all(|share| *share > 0.0).then(|| (color, mix(&|vertex| vertex.0[2])))
}

fn assert_texels(found: &Picture, size: Size, expected: impl Fn((u32, u32)) -> [f64; 4]) {
    assert_eq!((found.width, found.height), (size.width, size.height));
    for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
        let (found, expected) = (found.at(x, y), expected((x, y)));
        let differs = (0..4).any(|channel| (f64::from(found[channel]) - expected[channel]).abs() > 1e-5 * 8.0);
        assert!(!differs, "{x}, {y}: {found:?} is not {expected:?}");
    }
}

fn color_or(triangle: &[Vertex; 3], size: Size, pixel: (u32, u32), clear: [f64; 4]) -> [f64; 4] {
    at(triangle, size, pixel, CENTER).map_or(clear, |(color, _)| color)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_triangle_in_one_mip_level_leaves_the_others() {
    for level in 0..4_u32 {
        let size = Size::new(SIZE.width >> level, SIZE.height >> level);
        let found = result(&format!("Mips(level: {level})"));
        let drawn = found.pixels.iter().filter(|pixel| pixel.map(f64::from) != CLEARS[level as usize]).count();
        assert_eq!(drawn > 0, level == 2, "{drawn} pixels of level {level}");
        assert_texels(&found, size, |pixel| match level {
            2 => color_or(&LARGE, size, pixel, CLEARS[2]),
            _ => CLEARS[level as usize],
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_layer_has_what_was_drawn_into_it() {
    for layer in 0..3 {
        let found = result(&format!("Layers(layer: {layer})"));
        assert_texels(&found, SIZE, |pixel| match layer {
            0 => CLEARS[0],
            1 => color_or(&LARGE, SIZE, pixel, CLEARS[1]),
            _ => color_or(&OTHER, SIZE, pixel, CLEARS[2]),
        });
    }
}

/// Color and depth in a pixel of two triangles.
fn overlap(pixel: (u32, u32), stays: &str) -> ([f64; 4], f64) {
    let empty = (CLEARS[0], if stays == "Far" { 0.0 } else { 1.0 });
    let of = |triangle| at(triangle, SIZE, pixel, CENTER);
    match (of(&LARGE), of(&OTHER)) {
        (None, None) => empty,
        (Some(one), None) | (None, Some(one)) => one,
        (Some(first), Some(second)) => match stays {
            "Near" if first.1 <= second.1 => first,
            "Far" if first.1 >= second.1 => first,
            _ => second,
        },
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_depth_test_decides_in_each_pixel() {
    let near = result("Overlap()");
    for stays in ["Near", "Far", "Last"] {
        for apart in [false, true] {
            let node = format!("Overlap(stays: {stays}, apart: {apart})");
            let found = result(&node);
            assert_texels(&found, SIZE, |pixel| overlap(pixel, stays).0);
            assert_eq!(found.pixels == near.pixels, stays == "Near", "{node}");
            let (_, depth) = drawn(&format!("\"result\": {node}"), "result.depth");
            assert_texels(&depth, SIZE, |pixel| [overlap(pixel, stays).1, 0.0, 0.0, 1.0]);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_depth_of_16_bits_is_one_of_the_two_steps_around_it() {
    let (plan, depth) = drawn("\"result\": Overlap(short: true)", "result.depth");
    let wide = drawn("\"result\": Overlap()", "result.depth").1;
    let format =
        |label: &str| plan.images.iter().find(|image| image.label == label).map(|image| image.desc.format.name());
    // The reference of `measure` has 32 bits everywhere.
    assert_eq!(format("result.depth"), Some("Depth32Float"));
    assert_eq!(depth.pixels, wide.pixels);
    let graph = graph("\"result\": Overlap(short: true)", "result.depth");
    let mut run = Run::new(&graph);
    run.size = SIZE;
    let short = run.frame(&[]).remove(0);
    let steps = |value: f32| f64::from(value) * 65535.0;
    let mut differ = 0;
    for (short, wide) in short.pixels.iter().zip(&wide.pixels) {
        // A device may round to either.
        assert!((steps(short[0]) - steps(wide[0])).abs() < 1.01, "{short:?} is not {wide:?}");
        differ += usize::from(short[0] != wide[0]);
    }
    assert!(differ > 100, "only {differ} pixels are rounded");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn four_samples_are_drawn_where_the_triangle_covers_them() {
    let nodes = "\"edge\": Edge(), \"result\": Resolve(source: \"edge\", gain: 0.0)";
    let (plan, found) = drawn(nodes, "result");
    let samples: Vec<u32> =
        plan.images.iter().filter(|image| image.lifetime.is_some()).map(|i| i.desc.samples).collect();
    assert!(samples.contains(&4), "{samples:?}");
    let covered = |pixel| SAMPLES.iter().filter(|place| at(&LARGE, SIZE, pixel, **place).is_some()).count();
    let mut seen = [0; 5];
    for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
        let count = covered((x, y));
        seen[count] += 1;
        let share = count as f32 / 4.0;
        assert_eq!(found.at(x, y), [50.0 * share, 25.0 * share, 5.0 * share, share], "{x}, {y}: {count} samples");
    }
    assert!(seen.iter().all(|count| *count >= 3), "pixels with 0 to 4 covered samples: {seen:?}");
    let nodes = "\"edge\": Edge(), \"result\": Resolve(source: \"edge.depth\", filter: Smallest)";
    let (_, nearest) = drawn(nodes, "result");
    for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
        let expected = if covered((x, y)) > 0 { 0.25 } else { 1.0 };
        assert_eq!(nearest.at(x, y)[0], expected, "{x}, {y}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pass_keeps_or_clears_what_is_there() {
    let over = |pixel, below: [f64; 4]| color_or(&OTHER, SIZE, pixel, below);
    let first = |pixel| color_or(&LARGE, SIZE, pixel, CLEARS[0]);
    assert_texels(&result("Twice()"), SIZE, |pixel| over(pixel, first(pixel)));
    assert_texels(&result("Twice(clears: true)"), SIZE, |pixel| over(pixel, CLEARS[1]));
    for clears in [false, true] {
        // What is read between the two is what the first has drawn.
        let (_, both) = all_drawn(&format!("\"result\": Twice(clears: {clears})"), "result,result.between");
        assert_texels(&both[1], SIZE, first);
        assert_texels(&both[0], SIZE, |pixel| over(pixel, if clears { CLEARS[1] } else { first(pixel) }));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn indices_and_instances_draw_moved_triangles() {
    let moved = SHIFTS.map(|[x, y, z, light]| {
        LARGE.map(|(place, color)| ([place[0] + x, place[1] + y, place[2] + z], color.map(|channel| channel * light)))
    });
    assert_texels(&result("Indexed()"), SIZE, |pixel| {
        let first = color_or(&moved[0], SIZE, pixel, CLEARS[0]);
        color_or(&moved[1], SIZE, pixel, first)
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn attachments_share_memory_as_little_as_the_order_allows() {
    let (plan, found) = drawn("\"result\": Chain()", "result");
    assert_texels(&found, SIZE, |pixel| {
        let below = color_or(&LARGE, SIZE, pixel, CLEARS[0]);
        match at(&OTHER, SIZE, pixel, CENTER) {
            Some((color, _)) => [0, 1, 2, 3].map(|channel| color[channel] + below[channel]),
            None => CLEARS[1],
        }
    });
    let memory = &plan.memory;
    assert_eq!(plan.options.alias, Alias::Pool, "images that are drawn into have layouts of their own");
    assert_eq!(memory.pooled, memory.lower_bound, "{}", plan.to_text());
    assert!(memory.pooled < memory.unshared);
    let slot = |label: &str| plan.images.iter().find(|image| image.label == label).and_then(|image| image.slot);
    assert!(slot("result.first_depth").is_some());
    assert_eq!(slot("result.first_depth"), slot("result.second_depth"));
    let draws = plan.passes.iter().filter(|planned| planned.pass.drawing().is_some());
    let stores: Vec<&[bool]> = draws.map(|planned| planned.stores.as_slice()).collect();
    assert_eq!(stores, [[true, false], [true, false]], "a depth that nothing reads is not stored");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn passes_that_nothing_reads_are_not_in_the_plan() {
    let plan = |output: &str| {
        let graph = graph("\"result\": Twice()", output);
        let mut run = Run::new(&graph);
        run.size = SIZE;
        run.plan(&gpu(), &[])
    };
    let drawings = |plan: &Plan| plan.work().filter(|pass| matches!(pass.kind, PassKind::Drawing(_))).count();
    assert_eq!(drawings(&plan("result")), 2);
    assert_eq!(drawings(&plan("result.between")), 1, "only the first is seen");
    assert_eq!(drawings(&plan("result.other")), 1);
}

#[test]
fn the_kinds_of_these_tests_keep_the_contract() {
    assert_eq!(afterimage_plan::contract(kinds::ALL), Ok(Vec::new()));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn verify_finds_what_is_wrong_with_a_drawing_pass() {
    type Change = fn(&mut Drawing);
    let changed = |node: &str, change: Change| {
        let mut plan = drawn(&format!("\"result\": {node}"), "result").0;
        let drawing = plan.passes.iter_mut().find(|planned| planned.pass.label == "corner").expect("a triangle");
        let PassKind::Drawing(drawing) = &mut drawing.pass.kind else { panic!("it is drawn") };
        change(drawing);
        plan
    };
    let mut unstored = drawn("\"result\": Chain()", "result").0;
    unstored.passes[0].stores[0] = false;
    let mut dispatched = drawn("\"result\": Chain()", "result").0;
    dispatched.passes[0].stage = Stage::Compute;
    let mut as_color = drawn("\"result\": Chain()", "result").0;
    let depth = as_color.batches[0].transitions.iter_mut().find(|transition| transition.to == Use::DepthAttachment);
    depth.expect("a depth is drawn").to = Use::ColorAttachment;
    let cases = [
        (
            changed("Layers(layer: 1)", |drawing| drawing.colors[0].target.layer = 0),
            "reads level 0 of layer 1 of `result.layers`, which no pass has drawn",
        ),
        (
            changed("Mips()", |drawing| drawing.colors[0].target.level = 7),
            "draws into level 7 of layer 0 of `result.mips`",
        ),
        (
            changed("Mips()", |drawing| drawing.colors[0].target.layer = 1),
            "draws into level 2 of layer 1 of `result.mips`",
        ),
        (changed("Mips()", |drawing| drawing.colors.clear()), "has 0 attachments and stores [true]"),
        (unstored, "reads `result.first`, which was not stored"),
        (dispatched, "is planned as Compute, which it is not"),
        (as_color, "from Undefined to ColorAttachment, but it must go from Undefined to DepthAttachment"),
    ];
    for (plan, wanted) in cases {
        let faults = verify(&plan).expect_err(wanted);
        assert!(faults.iter().any(|fault| fault.to_string().contains(wanted)), "{faults:?} is not {wanted:?}");
    }
}
