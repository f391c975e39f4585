//! Upsample on the GPU, compared with its CPU reference.

use afterimage_gpu::Gpu;
use afterimage_graph::node::PassKind;

use super::{SAMPLED, check, check_on, levels, picture};
use crate::reference::bloom;
use crate::reference::image::Image;
use crate::reference::resample::{Down, Firefly, Up};
use crate::support::gpu::{Picture, Run, gpu, graph};
use crate::support::harness::{assert_close, image};
use crate::support::player::Player;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn upsample_joins_levels_as_its_cpu_reference() {
    let nodes = |rest: &str| {
        format!(
            r#""mips": Downsample(source: "scene", levels: 4, filter: Tap4),
            "result": Upsample(source: "mips", {rest})"#
        )
    };
    let mips = |image: &Image| levels(image, 4, Down::FourTap, Firefly::Off);
    for (name, up) in [("Tent", Up::Tent), ("Bilinear", Up::Bilinear)] {
        let mixed = nodes(&format!("blend: Mix, spread: 0.7, filter: {name}, radius: 0.85"));
        check(&mixed, SAMPLED, |image| bloom::lerp_chain(&mips(image), 0.7, up, 0.85));
        let added = nodes(&format!("blend: Add, filter: {name}, radius: 1.25"));
        check(&added, SAMPLED, |image| bloom::additive_chain(&mips(image), up, 1.25));
    }
    let smooth = nodes("blend: Add, filter: Tent, smooth: true");
    check(&smooth, SAMPLED, |image| bloom::smoothed(&bloom::additive_chain(&mips(image), Up::Tent, 1.0)));
    let alone = nodes("blend: Add, smooth: true").replace("levels: 4", "levels: 1");
    check(&alone, SAMPLED, |image| bloom::smoothed(&mips(image)[0]));
    check(&nodes("spread: 0.0"), SAMPLED, |image| mips(image).swap_remove(0));
    check(&nodes("spread: 1.0"), SAMPLED, |image| bloom::lerp_chain(&mips(image), 1.0, Up::Tent, 1.0));
}

/// With a repeated border, light that is the same everywhere stays so up to the border.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_repeated_border_keeps_a_constant() {
    let [scene, half] = [(41, 24), (20, 12)].map(|(w, h)| Picture::new(w, h, |_, _| [0.5, 0.25, 2.0, 1.0]));
    for rest in ["blend: Add", "blend: Add, smooth: true", "blend: Mix, filter: Bilinear", "blend: Mix, smooth: true"] {
        let nodes = format!(
            r#""mips": Downsample(source: "scene", levels: 3, border: Edge),
            "result": Upsample(source: "mips", border: Edge, {rest})"#
        );
        check_on(&nodes, &scene, &image(&half), SAMPLED);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn levels_that_are_not_normalized_are_summed() {
    let nodes = r#"
        "mips": Downsample(source: "scene", levels: 3, filter: Tap4),
        "result": Upsample(source: "mips", blend: Add, normalize: false)"#;
    let scene = picture([40, 24], false);
    let mips = levels(&image(&scene), 3, Down::FourTap, Firefly::Off);
    let sum = bloom::additive_chain(&mips, Up::Tent, 1.0).map(|pixel| pixel.map(|v| 3.0 * v));
    check_on(nodes, &scene, &sum, SAMPLED);
}

/// On devices whose workgroups have fast memory, the last enlargement and the smoothing are one pass, which must make the
/// picture of two: also where tiles of 16x16 texels meet, at borders of both kinds, and in half floats.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_last_enlargement_is_smoothed_in_the_memory_of_workgroups() {
    let graph = graph(
        r#"Pipeline(inputs: { "scene": Color }, outputs: { "open": "open", "edge": "edge" }, nodes: {
            "mips": Downsample(source: "scene", levels: 3, filter: Tap4),
            "open": Upsample(source: "mips", blend: Add, smooth: true),
            "edge": Upsample(source: "mips", blend: Add, smooth: true, border: Edge),
        })"#,
    );
    for size in [[8, 8], [64, 64], [88, 40]] {
        let scene = picture(size, true);
        let rendered = |fast_workgroup_memory, exact| {
            let mut run = Run::new(&graph);
            run.options.exact = exact;
            let mut gpu: Gpu = (*gpu()).clone();
            gpu.caps.fast_workgroup_memory = fast_workgroup_memory;
            let mut player = Player::on(gpu);
            let plan = player.load(&run, &[("scene", &scene)]);
            let joined = plan.work().filter(|pass| matches!(pass.kind, PassKind::Workgroup(_))).count();
            assert_eq!(joined, if fast_workgroup_memory { 2 } else { 0 }, "{}", plan.to_text());
            player.frame(&[("scene", &scene)], 0.0, true);
            ["open", "edge"].map(|output| player.output(output))
        };
        for (exact, precision) in [(true, SAMPLED.exact), (false, SAMPLED.half)] {
            let (two, one) = (rendered(false, exact), rendered(true, exact));
            for (of_two, of_one) in two.iter().zip(&one) {
                let tolerance = SAMPLED.within(precision, 0.0);
                assert_close(&format!("{size:?} {exact}"), of_one, &image(of_two), &tolerance);
            }
        }
    }
}

/// The mean light of a picture, and the variance of the light around its center as a share of the squared height.
fn glow(picture: &Picture) -> [f64; 2] {
    let (mut light, mut squares) = (0.0, 0.0);
    let [width, height] = [picture.width, picture.height].map(f64::from);
    for (at, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (at as u32 % picture.width, at as u32 / picture.width);
        let [x, y] = [(x, width), (y, height)].map(|(at, side)| (f64::from(at) + 0.5 - 0.5 * side) / height);
        light += f64::from(pixel[0]);
        squares += f64::from(pixel[0]) * (x * x + y * y);
    }
    [light / (width * height), squares / light]
}

/// The second moment of a sum of filters is the sum of theirs: at any height it must be the same share of the picture.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_glow_keeps_its_share_of_a_picture_of_any_height() {
    let measured = |blend: &str, sides: &[u32], lines: u32| {
        let spot = |side: u32| {
            Picture::new(side, side, |x, y| {
                let [x, y] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(side) - 0.5);
                let light = (-(x * x + y * y) / (2.0 * 0.02_f64.powi(2))).exp() as f32;
                [light, light, light, 1.0]
            })
        };
        let graph = graph(&format!(
            r#"Pipeline(inputs: {{ "in": Exposed }}, outputs: {{ "out": "result" }}, nodes: {{
                "mips": Downsample(source: "in", levels: 4, lines: {lines}),
                "result": Upsample(source: "mips", {blend}, lines: {lines}),
            }})"#
        ));
        let spots: Vec<Picture> = sides.iter().map(|side| spot(*side)).collect();
        Run::new(&graph).shown(&spots.iter().collect::<Vec<_>>()).iter().map(glow).collect::<Vec<_>>()
    };
    let sides = [512, 181, 256, 362, 430, 600, 724, 1024];
    for blend in ["blend: Add", "blend: Mix, spread: 0.8"] {
        let all = measured(blend, &sides, 512);
        let [light, width] = all[0];
        for (side, found) in sides.iter().zip(&all) {
            let [of_light, of_width] = [found[0] / light, found[1] / width].map(|ratio| (ratio - 1.0).abs());
            assert!(of_light < 0.005 && of_width < 0.06, "{blend} {side}: {found:?} and not {light} {width}");
        }
        let [_, in_texels] = measured(blend, &[1024], 0)[0];
        assert!(in_texels < 0.6 * width, "{blend}: levels in texels make a smaller glow: {in_texels} and {width}");
    }
}
