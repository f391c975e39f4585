//! Chains in workgroup memory against the same passes one by one.

use afterimage_plan::When;

use crate::support::gpu::{Picture, Run, gpu, graph};

/// Light with sharp edges, a spike and a smooth ramp: whatever a tile gets wrong at its border shows.
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

fn both(text: &str, size: (u32, u32), exact: bool) -> (Picture, Picture, usize) {
    let graph = graph(text);
    let picture = scene(size.0, size.1);
    let mut apart = Run::new(&graph);
    apart.options.exact = exact;
    apart.options.tile = When::Never;
    apart.options.row_downsample = When::Never;
    let mut joined = Run::new(&graph);
    joined.options.exact = exact;
    joined.options.tile = When::Always;
    joined.options.row_downsample = When::Always;
    let inputs = [("scene", &picture)];
    let passes = joined.plan(&gpu(), &inputs).passes.len();
    (apart.frame(&inputs).remove(0), joined.frame(&inputs).remove(0), passes)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_bloom_in_tiles_is_the_bloom_pass_by_pass() {
    for size in [(64, 64), (256, 128), (641, 359), (33, 7), (5, 3), (2, 3), (1, 1), (1, 40)] {
        let (apart, joined, passes) = both(BLOOM, size, true);
        assert!(passes < 8 || size.0 * size.1 < 64, "{size:?}: {passes} passes are not joined");
        let worst = difference(&apart, &joined);
        assert!(worst < 2e-5, "{size:?}: differs by {worst}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn half_floats_in_tiles_round_like_half_floats_in_memory() {
    // A texture unit weighs texels with eight bits of fraction, which shows beside the spike; Mesa on the processor has more of them.
    let allowed = if gpu().is_processor() { 6e-3 } else { 4e-2 };
    for filter in ["filter: Tap13, firefly: Groups", "filter: Tap13", "filter: Tap4", "filter: Box"] {
        let text = BLOOM.replace("filter: Tap13, firefly: Groups", filter);
        for size in [(256, 256), (640, 360), (641, 359)] {
            let (apart, joined, _) = both(&text, size, false);
            let worst = difference(&apart, &joined);
            assert!(worst < allowed, "{filter} at {size:?}: differs by {worst}");
        }
    }
}
