//! Half floats as the device stores them.

use afterimage_gpu::Gpu;
use half::f16;

use crate::support::gpu::{Picture, Run, gpu, graph};
use crate::support::numbers::Numbers;
use crate::support::player::Player;

/// A driver may round toward zero where it stores them: all light would be a little too dark, and white 254 in 8 bits.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn half_floats_are_the_nearest_ones() {
    let graph = graph(
        r#"Pipeline(inputs: { "in": Color }, outputs: { "out": "twice" }, nodes: {
            "twice": Exposure(source: "in", stops: 1.0),
        })"#,
    );
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    let scene = Picture::new(48, 32, |_, _| [(); 4].map(|()| (20.0 * numbers.next() - 12.0).exp2() as f32));
    for prefer_fragment in [false, true] {
        let mut gpu: Gpu = (*gpu()).clone();
        gpu.caps.prefer_fragment = prefer_fragment;
        let mut player = Player::on(gpu);
        player.load(&Run::new(&graph), &[("in", &scene)]);
        player.frame(&[("in", &scene)], 0.0, true);
        for (found, of) in player.output("out").pixels.iter().zip(&scene.pixels) {
            let wanted = [2.0 * of[0], 2.0 * of[1], 2.0 * of[2], of[3]].map(|v| f16::from_f32(v).to_f32());
            assert_eq!(*found, wanted, "of {of:?}, drawn: {prefer_fragment}");
        }
    }
}
