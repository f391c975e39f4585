//! A device that is lost while a plan renders.

use afterimage_gpu::{Clock, Frame, Gpu, GpuError, Opening, download};

use super::{bits, lively};
use crate::support::gpu::{Run, built_in};
use crate::support::player::Player;

fn open() -> Player {
    let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
    Player::on(Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}")))
}

/// wgpu drops commands for a lost device without an error, so a frame is recorded as before, but no plan is loaded.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_lost_device_is_reported_when_texels_are_read_and_the_plan_renders_on_another() {
    let graph = built_in("lynx.ron", None);
    let scene = lively(64, 36);
    let mut player = open();
    let plan = player.load(&Run::new(&graph), &[("scene", &scene)]);
    player.frame(&[("scene", &scene)], 0.0, true);
    let wanted = bits(&player.output("display"));
    let [known, new] = [(); 2].map(|()| player.upload(&scene));
    let frame = |view| [("scene", view)];
    player.run(&Frame { inputs: &frame(&known), ..Frame::default() }).expect("a frame before");
    player.gpu.device.destroy();
    for view in [&known, &new] {
        player.run(&Frame { inputs: &frame(view), ..Frame::default() }).expect("a lost device is not noticed");
    }
    let other =
        std::sync::Arc::new(Run::new(&built_in("lynx.ron", Some("low"))).plan(&player.gpu, &[("scene", &scene)]));
    let error = player.executor.load(other).expect_err("it needs memory");
    assert!(matches!(error, GpuError::DeviceLost { .. }), "{error}");
    let texture = player.executor.output("display").expect("it is an output");
    let error = download(&player.gpu.device, &player.gpu.queue, texture).expect_err("nothing can be read");
    assert!(matches!(error, GpuError::DeviceLost { .. }), "{error}");
    let error = Clock::new(&player.gpu).err().expect("it is not the host's clock instead");
    assert!(matches!(error, GpuError::DeviceLost { .. }), "{error}");
    let mut other = open();
    other.executor.load(plan).expect("a plan holds nothing of a device");
    other.frame(&[("scene", &scene)], 0.0, true);
    assert_eq!(bits(&other.output("display")), wanted);
}
