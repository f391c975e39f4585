//! Frames that a host announces, so that their plans are made before the first of them.

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::{ExpectedFrame, HostImage};
use afterimage_gpu::{Executor, Frame, FrameKind, Gpu, Rectangle, download, wgpu};
use afterimage_graph::image::Size;

use super::{assert_same, scene};
use crate::support::gpu::{Shared, changed, gpu, graph};

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
        // Executors of the device would share what is compiled.
        let executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
        let mut post = Post::with_executor(executor, changed("caracal.ron", None, &[]));
        post.set_task_pool(Arc::new(|task| task()));
        encode(&gpu, &mut post, &whole);
        if is_announced {
            let inputs = &[("scene", HostImage::new(96, 54, wgpu::TextureFormat::Rgba16Float))];
            let rectangles = &[("scene", Size::new(64, 40))];
            let part = ExpectedFrame { inputs, rectangles, ..ExpectedFrame::default() };
            post.prepare(&[part]).unwrap_or_else(|error| panic!("{error}"));
        }
        for _ in 0..3 {
            encode(&gpu, &mut post, &whole);
        }
        assert!(post.is_prepared().unwrap());
        let before = pipelines(&instance);
        let plan = post.plan().cloned().expect("a frame was rendered");
        post.executor().count_from(0);
        encode(&gpu, &mut post, &part);
        assert!(!Arc::ptr_eq(&plan, post.plan().expect("a frame was rendered")), "the rectangle has a plan of its own");
        made.push(pipelines(&instance) - before);
        shown.push(download(&gpu.device, &gpu.queue, post.output("display").unwrap()).unwrap().bytes);
    }
    assert_eq!(made[0], 0, "all pipelines of the announced frame are there");
    assert!(made[1] > 0, "without the announcement the frame compiles");
    assert_same(&shown[0], &shown[1]);
}

/// The plan, its pipelines and those that draw into the host's format are there before any frame.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_first_frame_that_was_prepared_makes_no_plan_and_no_pipeline() {
    let (instance, gpu) = alone();
    let sizes = [Size::new(96, 54), Size::new(64, 36)];
    let lights = sizes.map(|size| scene(&gpu, size));
    let screens = sizes.map(|size| {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Bgra8UnormSrgb,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        texture.create_view(&Default::default())
    });
    let image = |size: Size, format| HostImage::new(size.width, size.height, format);
    let inputs = sizes.map(|size| [("scene", image(size, wgpu::TextureFormat::Rgba16Float))]);
    let outputs = sizes.map(|size| [("display", image(size, wgpu::TextureFormat::Bgra8UnormSrgb))]);
    let expected =
        [0, 1].map(|at| ExpectedFrame { inputs: &inputs[at], outputs: &outputs[at], ..ExpectedFrame::default() });
    let mut post = Post::new(&gpu, changed("caracal.ron", None, &[]));
    post.prepare(&expected[..1]).unwrap_or_else(|error| panic!("{error}"));
    wait(&mut post);
    // What changes before the first frame is prepared again.
    post.set_fact("emissive", false);
    post.parameter::<f32>("lit.strength").unwrap();
    assert!(!post.is_prepared().unwrap(), "the plan is of the old fact");
    wait(&mut post);
    let made = pipelines(&instance);
    assert!(made > 0);
    let frame = |at: usize, post: &mut Post| {
        let (inputs, outputs) = (&[("scene", &lights[at])], &[("display", &screens[at])]);
        encode(&gpu, post, &Frame { inputs, outputs, ..Frame::default() });
    };
    frame(0, &mut post);
    assert_eq!(pipelines(&instance), made, "the first frame compiles nothing");
    // A frame may come while its plan is being made: it is not made twice.
    post.prepare(&expected).unwrap_or_else(|error| panic!("{error}"));
    frame(1, &mut post);
    wait(&mut post);
    let made = pipelines(&instance);
    frame(1, &mut post);
    assert_eq!(pipelines(&instance), made);
}

fn wait(post: &mut Post) {
    while !post.is_prepared().unwrap_or_else(|error| panic!("{error}")) {
        std::thread::yield_now();
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_that_cannot_be_prepared_is_an_error() {
    let gpu = gpu();
    let mut post = Post::new(&gpu, changed("caracal.ron", None, &[]));
    let nothing = ExpectedFrame::default();
    let error = post.prepare(&[nothing]).unwrap_err().to_string();
    assert_eq!(error, "the pipeline needs an image for its input `scene`");
    let volume = HostImage { volume: true, ..HostImage::new(8, 8, wgpu::TextureFormat::Rgba16Float) };
    let error = post.prepare(&[ExpectedFrame { inputs: &[("scene", volume)], ..nothing }]).unwrap_err().to_string();
    assert!(error.contains("it is a 3-D texture"), "{error}");
    let error = post.prepare(&[nothing; 17]).unwrap_err().to_string();
    assert_eq!(error, "17 frames are announced, and plans are prepared for at most 16");
    assert!(post.is_prepared().unwrap(), "nothing is announced");
}

/// A block that must be there is in each frame, and an optional one where it is announced.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_announced_frame_has_the_blocks_that_must_be_there() {
    let gpu = gpu();
    let text = r#"Pipeline(
        inputs: { "depth": Depth, "camera": Camera },
        nodes: { "far": LinearDepth(depth: "depth", camera: "camera") },
        outputs: { "far": "far" },
    )"#;
    let mut post = Post::new(&gpu, graph(text));
    post.set_task_pool(Arc::new(|task| task()));
    let inputs = &[("depth", HostImage::new(16, 8, wgpu::TextureFormat::R32Float))];
    let prepared = post.prepare(&[ExpectedFrame { inputs, ..ExpectedFrame::default() }]);
    prepared.unwrap_or_else(|error| panic!("{error}"));
    let is_ready = |_| post.is_prepared().unwrap_or_else(|error| panic!("{error}"));
    assert!((0..3).any(is_ready), "a plan with the camera is made");
}
