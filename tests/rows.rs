//! Halvings by rows against halvings texel by texel, and columns of pixels against others.

use afterimage_graph::node::{Pass, PassKind};
use afterimage_plan::{Options, When};

use crate::reference::bloom::{gate_weight, without_fireflies};
use crate::reference::math::largest;
use crate::reference::resample::{Down, Firefly, downsample, downsample_karis, half_size};
use crate::support::gpu::{Picture, Run, gpu, graph};
use crate::support::harness::image;
use crate::support::sequence::Sequence;
use crate::support::sweep;

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
    // A texture unit weighs texels with eight bits of fraction, which shows beside the spike; Mesa on the processor has
    // more of them.
    let allowed = if gpu().is_processor() { 6e-3 } else { 4e-2 };
    for filter in ["filter: Tap13, firefly: Groups", "filter: Tap13", "filter: Tap4", "filter: Box"] {
        let text = BLOOM.replace("filter: Tap13, firefly: Groups", filter);
        // Of the five levels, all have a source with even sides, four of them, and two.
        for (width, height) in [(256, 256), (640, 360), (641, 359)] {
            let (apart, by_rows, rows) = both(&text, width, height);
            assert_eq!(rows, 5, "{filter} at {width}x{height}");
            let worst = difference(&apart, &by_rows);
            assert!(worst < allowed, "{filter} at {width}x{height}: differs by {worst}");
        }
    }
}

/// Selects light without single bright pixels and halves it. `exposed` is what the light is selected from.
fn limited(exposed: &str, history: &str, filter: &str) -> String {
    format!(
        r#"Pipeline(
    inputs: {{ "scene": Color }},
    nodes: {{
        "exposed": Exposure(source: "scene", stops: 1.0),
        "bright": Extract(source: "{exposed}", {history}method: Gate, threshold: 1.0, knee: 0.3, fireflies: Limit),
        "mips": Downsample(source: "bright", levels: 1, {filter}),
        "half": Downsample(source: "mips.coarsest", levels: 1, filter: Box),
        "lit": Composite(base: "{exposed}", bloom: "mips.coarsest", blend: Add, strength: 1.0, filter: Bilinear),
        "past": Saturation(source: "bright.peaks@previous", amount: 0.9),
    }},
    outputs: {{ "half": "half.coarsest", "past": "past", "lit": "lit" }},
)"#
    )
}

const HISTORY: &str = r#"before: "bright.peaks@previous", "#;

/// Noise with a spark in one of eleven pixels, in other places in odd frames; there are sparks at borders, in corners
/// and side by side.
fn sparks(width: u32, height: u32, frame: u32) -> Picture {
    let hash = |x: u32, y: u32| {
        let mixed = (x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77)).wrapping_mul(0xC2B2_AE3D);
        (mixed ^ mixed >> 15).wrapping_mul(0x27D4_EB2F) >> 8
    };
    Picture::new(width, height, |x, y| {
        let noise = hash(x, y) as f32 / (1 << 24) as f32;
        let spark = if hash(x + 17 * (frame % 2), y + 3).is_multiple_of(199) { 3.0 + 400.0 * noise } else { 0.0 };
        [0.1 + noise + spark, 0.5 * noise, 0.3 + 0.2 * noise + 0.1 * spark, 0.25 + 0.5 * noise]
    })
}

/// A scene with numbers that are not finite: alone, side by side, in a line and at the border.
fn damaged(mut picture: Picture) -> Picture {
    let [width, height] = [picture.width, picture.height].map(|side| side as usize);
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, y) = (index % width, index / width);
        match (x + 5 * y) % 61 {
            0 => *pixel = [f32::NAN; 4],
            1 => pixel[1] = f32::INFINITY,
            2 => pixel[0] = f32::NEG_INFINITY,
            3 => pixel[2] = -3.0,
            _ if y == height / 2 => pixel[0] = f32::NAN,
            _ if x == 0 => pixel[2] = f32::INFINITY,
            _ => {}
        }
    }
    picture
}

/// The outputs of three frames, unfused and by rows, and how many passes by rows look at neighbors.
fn frames(text: &str, pictures: &[Picture; 2]) -> ([Vec<Vec<Picture>>; 2], usize) {
    let graph = graph(text);
    let mut apart = Run::new(&graph);
    apart.options = Options { fuse: false, row_downsample: When::Never, ..Options::default() };
    let mut by_rows = Run::new(&graph);
    by_rows.options.row_downsample = When::Always;
    let plan = by_rows.plan(&gpu(), &[("scene", &pictures[0])]);
    let looks = |pass: &&Pass| matches!(&pass.kind, PassKind::RowDownsample(rows) if rows.around.is_some());
    let found = plan.work().filter(looks).count();
    let shown = |run: &Run<'_>| {
        let mut sequence = Sequence::new(run);
        let mut frame = |number: usize| {
            sequence.frame(&[("scene", &pictures[number % 2])], 0.0, number == 0);
            sequence.outputs()
        };
        (0..3).map(&mut frame).collect::<Vec<_>>()
    };
    ([shown(&apart), shown(&by_rows)], found)
}

/// Sizes around the borders of workgroups, odd ones, and sides that are not halved.
const SIZES: [(u32, u32); 18] = [
    (2, 2),
    (4, 2),
    (2, 36),
    (64, 64),
    (118, 30),
    (120, 32),
    (122, 34),
    (246, 66),
    (1, 1),
    (2, 1),
    (65, 64),
    (130, 67),
    (3, 3),
    (3, 36),
    (117, 31),
    (119, 33),
    (120, 35),
    (237, 64),
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_is_limited_by_rows_as_in_passes_of_its_own() {
    let chains = [
        ("scene", HISTORY, "filter: Tap13"),
        ("exposed", HISTORY, "filter: Tap13"),
        ("scene", "", "filter: Tap13, firefly: Groups"),
        ("exposed", "", "filter: Tap4"),
        ("scene", HISTORY, "filter: Box"),
    ];
    let cases = chains.into_iter().flat_map(|chain| SIZES.map(|size| (chain, size)));
    for ((exposed, history, filter), (width, height)) in sweep::some(cases, 11) {
        let text = limited(exposed, history, filter);
        for is_damaged in [false, true] {
            let pictures = [0, 1].map(|frame| sparks(width, height, frame));
            let pictures = if is_damaged { pictures.map(damaged) } else { pictures };
            let ([apart, by_rows], found) = frames(&text, &pictures);
            let what = format!("{exposed}, {history}{filter} at {width}x{height}, damaged: {is_damaged}");
            assert_eq!(found, usize::from(width > 1 && height > 1), "{what}");
            // At an odd size, a texture unit weighs the texels of the passes apart with few bits of fraction.
            let allowed = match (width % 2 + height % 2, gpu().is_processor()) {
                (0, _) => 6e-3,
                (_, true) => 1e-2,
                (_, false) => 4e-2,
            };
            for (number, (apart, by_rows)) in apart.iter().zip(&by_rows).enumerate() {
                let [half, past, lit] = [0, 1, 2].map(|output| difference(&apart[output], &by_rows[output]));
                assert!(half < allowed, "{what}: the light of frame {number} differs by {half}");
                assert!(lit < allowed, "{what}: the result of frame {number} differs by {lit}");
                // Peaks of the scene are the same numbers; the exposed ones are rounded once less.
                let allowed = if exposed == "scene" { 0.0 } else { 1e-3 };
                assert!(past <= allowed, "{what}: the peaks before frame {number} differ by {past}");
            }
        }
    }
}

/// The light by rows against its definition.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_that_is_limited_by_rows_is_as_in_the_cpu_reference() {
    let text = limited("scene", HISTORY, "filter: Tap13");
    for (width, height) in [(2, 2), (64, 36), (244, 70), (3, 3), (65, 36), (64, 37), (245, 71)] {
        let pictures = [0, 1].map(|frame| sparks(width, height, frame));
        let ([_, by_rows], found) = frames(&text, &pictures);
        assert_eq!(found, 1, "{width}x{height}");
        let [first, second] = pictures.each_ref().map(image);
        for (frame, now, before) in [(0, &first, None), (1, &second, Some(&first)), (2, &first, Some(&second))] {
            // Without a frame before, all light stays.
            let limited = before.map_or_else(|| now.clone(), |before| without_fireflies(now, Some(before)));
            assert!(
                frame == 0 || limited != *now || now.pixels.len() < 200,
                "something is limited at {width}x{height}"
            );
            let bright = limited.map_rgb(|color| color.map(|c| c * gate_weight(largest(color), 1.0, 0.3)));
            let bright = bright.with_open_beyond();
            let wanted = downsample(&bright, half_size(bright.width, bright.height), Down::ThirteenTap);
            let wanted = downsample(&wanted, half_size(wanted.width, wanted.height), Down::Box);
            let shown = image(&by_rows[frame][0]);
            let channels = wanted.pixels.as_flattened().iter().zip(shown.pixels.as_flattened());
            let worst = channels.map(|(a, b)| (a - b).abs() / (1.0 + a.abs())).fold(0.0, f64::max);
            assert!(worst < 6e-3, "frame {frame} at {width}x{height} differs by {worst}");
        }
    }
}

/// A halving of half floats whose result is no output, so that it can be done by rows; the light is four times as
/// large.
fn halved(filter: &str) -> String {
    format!(
        r#"Pipeline(
    inputs: {{ "scene": Color }},
    nodes: {{
        "exposed": Exposure(source: "scene", stops: 1.0),
        "mips": Downsample(source: "exposed", levels: 1, {filter}),
        "out": Composite(base: "mips.coarsest", bloom: "mips.coarsest", blend: Add, strength: 1.0, filter: Bilinear),
    }},
    outputs: {{ "out": "out" }},
)"#
    )
}

/// Halvings by rows against their definition, at all four parities and around the borders of workgroups.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_halving_by_rows_is_as_in_the_cpu_reference() {
    for (name, filter, firefly) in [
        ("Tap13", Down::ThirteenTap, Firefly::Off),
        ("Tap13", Down::ThirteenTap, Firefly::Groups),
        ("Tap9", Down::NineTap, Firefly::Off),
        ("Tap4", Down::FourTap, Firefly::Off),
        ("Box", Down::Box, Firefly::Off),
        ("Binomial", Down::Binomial, Firefly::Off),
    ] {
        let graph = graph(&halved(&format!("filter: {name}, firefly: {firefly:?}")));
        for (width, height) in [(64, 36), (3, 2), (123, 33), (124, 35), (245, 66), (481, 269)] {
            let scene = scene(width, height);
            let mut run = Run::new(&graph);
            run.options.row_downsample = When::Always;
            let plan = run.plan(&gpu(), &[("scene", &scene)]);
            let is_by_rows = plan.work().any(|pass| matches!(pass.kind, PassKind::RowDownsample(_)));
            assert_eq!(is_by_rows, name != "Tap9" || (width % 2, height % 2) == (0, 0), "{name} at {width}x{height}");
            let shown = image(&run.frame(&[("scene", &scene)]).remove(0));
            let source = image(&scene).map_rgb(|color| color.map(|c| 2.0 * c));
            let source = source.with_open_beyond();
            let wanted = downsample_karis(&source, half_size(source.width, source.height), filter, firefly);
            let wanted = wanted.map_rgb(|color| color.map(|c| 2.0 * c));
            let channels = wanted.pixels.as_flattened().iter().zip(shown.pixels.as_flattened());
            let worst = channels.map(|(a, b)| (a - b).abs() / (1.0 + a.abs())).fold(0.0, f64::max);
            assert!(worst < 2e-3, "{name} {firefly:?} at {width}x{height} differs by {worst}");
        }
    }
}

/// Lights of one pixel, far from each other: each keeps its energy by rows, wherever it is.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_light_of_one_pixel_keeps_its_energy_by_rows() {
    let graph = graph(&halved("filter: Tap13"));
    for (width, height) in [(256, 128), (257, 128), (256, 129), (257, 129), (1281, 65)] {
        let mut run = Run::new(&graph);
        run.options.row_downsample = When::Always;
        let mut sequence = Sequence::new(&run);
        for at in (0..24).map(|step| (9 + 37 * step % (width - 18), 9 + 5 * step % (height - 18))) {
            let light = Picture::new(width, height, |x, y| [if (x, y) == at { 1000.0 } else { 0.0 }, 0.0, 0.0, 1.0]);
            sequence.frame(&[("scene", &light)], 0.0, false);
            let half = sequence.output("out");
            let area = f64::from(width * height) / f64::from(half.width * half.height);
            let energy = half.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() * area / 4000.0;
            assert!((energy - 1.0).abs() < 2e-3, "{width}x{height} {at:?}: {energy}");
        }
    }
}

/// An invocation makes several pixels of a large image: beside each other if its columns end at the border, and else
/// eight rows apart.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pixels_are_the_same_in_columns_of_both_kinds() {
    for node in ["Cas(source: \"mapped\", amount: 0.9)", "Sharpen(source: \"mapped\", amount: 0.5)"] {
        let graph = graph(&format!(
            r#"Pipeline(inputs: {{ "scene": Color }}, outputs: {{ "out": "out" }}, nodes: {{
                "exposed": Exposure(source: "scene"),
                "mapped": ToneMap(source: "exposed", curve: AcesNarkowicz),
                "out": {node},
            }})"#
        ));
        let picture = |height| {
            let noise = scene(512, 1);
            Picture::new(512, height, |x, y| noise.at((x * 31 + y * 17) % 512, 0))
        };
        let pictures = [picture(512), picture(513)];
        let shown = Run::new(&graph).shown(&pictures.each_ref());
        let [beside, apart] = shown.as_slice() else { panic!("one result for each picture") };
        // Those at the bottom read the row more.
        for y in 0..500 {
            for x in 0..512 {
                assert_eq!(beside.at(x, y), apart.at(x, y), "{node} at {x}, {y}");
            }
        }
    }
}
