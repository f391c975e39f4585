//! Frames that a host announces, so that their plans are made in the background.

use std::sync::Arc;

use afterimage_gpu::{Frame, FrameKind, Gpu, Post, Rectangle, download, wgpu};
use afterimage_graph::image::Size;

use super::{assert_same, scene};
use crate::support::gpu::{Shared, changed};

/// A device whose instance counts nothing of other tests.
fn alone() -> (wgpu::Instance, Shared) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let wanted = std::env::var("AFTERIMAGE_ADAPTER").ok();
    let gpu = pollster::block_on(Gpu::open_on(&instance, wanted.as_deref()));
    (instance, Shared::of(gpu.unwrap_or_else(|error| panic!("{error}"))))
}

/// The pipelines that the device has.
fn pipelines(instance: &wgpu::Instance) -> usize {
    let report = instance.generate_report().expect("the instance is wgpu's own");
    let hub = report.hub_report();
    hub.compute_pipelines.num_allocated + hub.render_pipelines.num_allocated
}

fn encode(gpu: &Gpu, post: &mut Post, frame: &Frame<'_>) {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    post.encode(&mut encoder, frame).unwrap_or_else(|error| panic!("{error}"));
    gpu.queue.submit([encoder.finish()]);
}

/// A first rectangle needs passes that read a part of the image, and plans for its size.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_first_rectangle_that_was_announced_needs_no_pipeline() {
    let (instance, gpu) = alone();
    let light = scene(&gpu, Size::new(96, 54));
    let whole = Frame { inputs: &[("scene", &light)], ..Frame::default() };
    let rectangles = &[("scene", Rectangle { x: 8, y: 4, width: 64, height: 40 })];
    let part = Frame { rectangles, kind: FrameKind::Cut, ..whole };
    let mut shown = Vec::new();
    let mut made = Vec::new();
    for is_announced in [true, false] {
        let mut post = Post::new(&gpu.adapter, &gpu.device, &gpu.queue, changed("caracal.ron", None, &[]));
        post.set_task_pool(Arc::new(|task| task()));
        encode(&gpu, &mut post, &whole);
        if is_announced {
            post.expect_frames(&[part]).unwrap_or_else(|error| panic!("{error}"));
            assert!(!post.has_expected_plans());
        }
        for _ in 0..3 {
            encode(&gpu, &mut post, &whole);
        }
        assert!(post.has_expected_plans());
        let before = pipelines(&instance);
        let plan = post.plan().cloned().expect("a frame was rendered");
        post.executor().count_from(0);
        encode(&gpu, &mut post, &part);
        assert!(!Arc::ptr_eq(&plan, post.plan().expect("a frame was rendered")), "the rectangle has a plan of its own");
        made.push(pipelines(&instance) - before);
        shown.push(download(&gpu.device, &gpu.queue, post.output("display")).unwrap().bytes);
    }
    assert_eq!(made[0], 0, "all pipelines of the announced frame are there");
    assert!(made[1] > 0, "without the announcement the frame compiles");
    assert_same(&shown[0], &shown[1]);
}
