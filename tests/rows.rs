//! Halvings by rows against halvings texel by texel.

use afterimage_graph::node::PassKind;
use afterimage_plan::When;

use crate::support::gpu::{Picture, Run, gpu, graph};

/// Light with sharp edges, a spike and a smooth ramp: whatever a workgroup gets wrong at its border shows.
fn scene(width: u32, height: u32) -> Picture {
    let hash =
        |x: u32, y: u32| (x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77)).wrapping_mul(0xC2B2_AE3D) >> 8;
    Picture::new(width, height, |x, y| {
        let noise = hash(x, y) as f32 / (1 << 24) as f32;
        let ramp = x as f32 / width as f32;
        let spike = if (x, y) == (width / 2, height / 3) { 4000.0 } else { 0.0 };
        [0.2 + noise + spike, ramp * 3.0, 1.5 * noise * ramp + spike, 1.0]
    })
}

/// The largest difference, each pixel's as a share of 1 + its brightness there.
fn difference(a: &Picture, b: &Picture) -> f32 {
    let channels = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    channels.map(|(a, b)| (a - b).abs() / (1.0 + a.abs())).fold(0.0, f32::max)
}

const BLOOM: &str = r#"Pipeline(
    inputs: { "scene": Exposed },
    nodes: {
        "bright": Extract(source: "scene", method: Gate, threshold: 1.0, knee: 0.3),
        "mips": Downsample(source: "bright", levels: 5, filter: Tap13, firefly: Groups),
        "bloom": Upsample(source: "mips", blend: Add, filter: Tent, radius: 0.85),
        "lit": Composite(base: "scene", bloom: "bloom", blend: Add, strength: 0.5),
    },
    outputs: { "lit": "lit" },
)"#;

/// The result texel by texel and by rows, and how many passes of the second halve by rows.
fn both(text: &str, width: u32, height: u32) -> (Picture, Picture, usize) {
    let graph = graph(text);
    let picture = scene(width, height);
    let inputs = [("scene", &picture)];
    let mut apart = Run::new(&graph);
    apart.options.row_downsample = When::Never;
    let mut by_rows = Run::new(&graph);
    by_rows.options.row_downsample = When::Always;
    let plan = by_rows.plan(&gpu(), &inputs);
    let rows = plan.work().filter(|pass| matches!(pass.kind, PassKind::RowDownsample(_))).count();
    (apart.frame(&inputs).remove(0), by_rows.frame(&inputs).remove(0), rows)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn half_floats_by_rows_round_like_half_floats_in_memory() {
    // A texture unit weighs texels with eight bits of fraction, which shows beside the spike; Mesa on the processor has more of them.
    let allowed = if gpu().is_processor() { 6e-3 } else { 4e-2 };
    for filter in ["filter: Tap13, firefly: Groups", "filter: Tap13", "filter: Tap4", "filter: Box"] {
        let text = BLOOM.replace("filter: Tap13, firefly: Groups", filter);
        // Each of the five levels has a source with even sides, four of them, and two.
        for (width, height, halvings) in [(256, 256, 5), (640, 360, 4), (641, 359, 2)] {
            let (apart, by_rows, rows) = both(&text, width, height);
            assert_eq!(rows, halvings, "{filter} at {width}x{height}");
            let worst = difference(&apart, &by_rows);
            assert!(worst < allowed, "{filter} at {width}x{height}: differs by {worst}");
        }
    }
}
