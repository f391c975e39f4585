//! Frames that are recorded before the one before is submitted, and frames that are never submitted.

use afterimage::Post;
use afterimage_gpu::{Frame, FrameKind, Gpu, Rectangle, Texels, download, upload, wanted_features, wgpu};
use afterimage_graph::image::Size;
use afterimage_graph::node::Camera;

use super::{Host, assert_same, fresh, scene_texels};
use crate::support::gpu::{Shared, another_device, changed, gpu, graph};

/// What depends on the camera, on a parameter, on time, on the frame before and on the number of the frame.
const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color, "depth": Depth, "camera": Camera },
    nodes: {
        "fogged": Fog(source: "scene", depth: "depth", camera: "camera", falloff: 0.5),
        "bins": Histogram(source: "fogged"),
        "metered": AutoExposure(histogram: "bins"),
        "exposed": Exposure(source: "fogged", meter: "metered"),
        "mapped": ToneMap(source: "exposed", curve: Reinhard),
        "encoded": Encode(source: "mapped", transfer: Srgb),
        "display": Dither(source: "encoded", bits: 8, format: Rgba8Unorm),
    },
    outputs: { "display": "display" },
)"#;

const SIZE: Size = Size { width: 48, height: 27, depth: 1 };
const FRAMES: u16 = 6;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    Alone,
    /// Three command buffers in each submission.
    Together,
    /// Three frames in each command buffer.
    OneEncoder,
    /// The third is recorded and dropped; the next one resets.
    ThirdDropped,
    /// The third is not recorded; the next one resets.
    ThirdLeftOut,
}

fn image(gpu: &Gpu, texels: &Texels) -> wgpu::TextureView {
    let texture = upload(&gpu.device, &gpu.queue, texels).unwrap_or_else(|error| panic!("{error}"));
    texture.create_view(&Default::default())
}

fn screen(gpu: &Gpu) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 96, height: 54, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// The pictures of frames in which everything moves, and the exposures that arrive.
fn pictures(gpu: &Gpu, order: Order) -> (Vec<Vec<u8>>, Vec<[f32; 4]>) {
    let mut post = Post::new(gpu, graph(LOOK));
    let density = post.parameter::<f32>("fogged.density").unwrap_or_else(|error| panic!("{error}"));
    let watch = post.watch("metered.result");
    let scene = image(gpu, &scene_texels(Size::new(96, 54)));
    let depth = image(gpu, &Texels::from_floats_as_half(48, 27, &[[12.0, 0.0, 0.0, 1.0]; 48 * 27]));
    let screens: Vec<wgpu::Texture> = (0..FRAMES).map(|_| screen(gpu)).collect();
    let mut commands = Vec::new();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut readings = Vec::new();
    for (number, screen) in (0..FRAMES).zip(&screens) {
        let step = f32::from(number);
        if order == Order::ThirdLeftOut && number == 2 {
            continue;
        }
        // From the third frame on it does not change.
        post.set(density, 0.02 * step.min(2.0)).unwrap_or_else(|error| panic!("{error}"));
        let view = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -step, 0.0, 1.0]];
        let projection = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
        let camera = Camera::still(view, projection).data().unwrap_or_else(|error| panic!("{error}"));
        let at = |x, y| Rectangle { x, y, width: SIZE.width, height: SIZE.height };
        let shown = screen.create_view(&Default::default());
        let dropped = matches!(order, Order::ThirdDropped | Order::ThirdLeftOut);
        let frame = Frame {
            inputs: &[("scene", &scene), ("depth", &depth)],
            outputs: &[("display", &shown)],
            blocks: &[("camera", &camera)],
            rectangles: &[("scene", at(4 * u32::from(number), 3)), ("display", at(2, 2 * u32::from(number)))],
            factors: &[("scene", 0.5 + step)],
            time: f64::from(step),
            dt: 0.1 + step,
            kind: FrameKind::cut_if(number == 0 || dropped && number == 3),
            ..Frame::default()
        };
        if dropped && number == 3 {
            // Noise and the places of histories follow the number.
            post.executor().count_from(3);
        }
        post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        let is_dropped = order == Order::ThirdDropped && number == 2;
        if is_dropped || order != Order::OneEncoder || number % 3 == 2 {
            let fresh = gpu.device.create_command_encoder(&Default::default());
            let recorded = std::mem::replace(&mut encoder, fresh).finish();
            commands.extend((!is_dropped).then_some(recorded));
        }
        if !matches!(order, Order::Together | Order::OneEncoder) || number % 3 == 2 {
            gpu.queue.submit(commands.drain(..));
        }
        gpu.wait().unwrap_or_else(|error| panic!("{error}"));
        readings.extend(post.reading(watch).unwrap().cloned());
    }
    readings.dedup();
    let bytes = |screen| download(&gpu.device, &gpu.queue, screen).unwrap_or_else(|error| panic!("{error}")).bytes;
    (screens.iter().map(bytes).collect(), readings.iter().filter_map(|reading| reading.value()).collect())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn frames_are_right_before_the_one_before_is_submitted() {
    let gpu = gpu();
    let features = wanted_features(&gpu.adapter) - wgpu::Features::IMMEDIATES;
    let without_immediates = Shared::of(another_device(&gpu, features, gpu.adapter.limits()));
    for gpu in [gpu, without_immediates] {
        let (alone, exposures) = pictures(&gpu, Order::Alone);
        assert!(exposures.len() > 2, "{exposures:?}");
        for (number, picture) in alone.iter().enumerate().skip(1) {
            assert!(*picture != alone[number - 1], "frame {number} is another picture");
        }
        for order in [Order::Together, Order::OneEncoder] {
            let (shown, arrived) = pictures(&gpu, order);
            shown.iter().zip(&alone).for_each(|(shown, alone)| assert_same(shown, alone));
            assert!(!arrived.is_empty() && arrived.iter().all(|known| exposures.contains(known)), "{arrived:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_that_is_not_submitted_leaves_nothing_after_a_reset() {
    let gpu = gpu();
    let (shown, _) = pictures(&gpu, Order::ThirdDropped);
    let (wanted, _) = pictures(&gpu, Order::ThirdLeftOut);
    assert!(shown[2].iter().all(|code| *code == 0), "the third is not shown");
    shown.iter().zip(&wanted).for_each(|(shown, wanted)| assert_same(shown, wanted));
}

/// A host whose frames are dropped as encoders or as finished command buffers.
fn drop_frame(host: &mut Host, is_finished: bool) {
    let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
    let frame = Frame { inputs: &[("scene", &host.scene)], dt: 0.1, kind: FrameKind::Next, ..Frame::default() };
    host.post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
    if is_finished {
        drop(encoder.finish());
    }
}

/// What it shows in a frame that is no cut, but the first one that is submitted.
fn shown_next(host: &mut Host) -> Vec<u8> {
    host.time = 0.1;
    host.frame().unwrap_or_else(|error| panic!("{error}"));
    download(&host.gpu.device, &host.gpu.queue, host.post.output("display").unwrap()).unwrap().bytes
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_whose_first_frame_is_dropped_begins_in_the_next_one() {
    // It has a baked LUT, which its first frame evaluates.
    let wanted = fresh("lynx.ron", Some("high"), &[]);
    for is_finished in [false, true] {
        let mut host = Host::new(changed("lynx.ron", Some("high"), &[]));
        drop_frame(&mut host, is_finished);
        assert_same(&shown_next(&mut host), &wanted);
        // So does a table that a value has made stale.
        let hue = host.post.parameter::<f32>("mapped.keep_hue").unwrap();
        host.frame().unwrap();
        host.post.finish_changes().unwrap();
        host.frame().unwrap();
        host.post.set(hue, 0.5).unwrap();
        drop_frame(&mut host, is_finished);
        assert_same(&shown_next(&mut host), &fresh("lynx.ron", Some("high"), &[("mapped.keep_hue", "0.5")]));
        // And the plan of another tier.
        host.post.change(changed("lynx.ron", None, &[]));
        host.post.finish_changes().unwrap();
        drop_frame(&mut host, is_finished);
        assert_same(&shown_next(&mut host), &fresh("lynx.ron", None, &[("mapped.keep_hue", "0.5")]));
    }
}

/// Cached results, histories and meters begin in the first frame that is submitted.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn results_that_last_begin_in_the_first_frame_that_is_submitted() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "cached": Vignette(source: "scene", amount: 0.5, every: 4),
            "lit": Composite(base: "scene", bloom: "cached", strength: 0.5),
            "bins": Histogram(source: "lit"),
            "meter": AutoExposure(histogram: "bins"),
            "exposed": Exposure(source: "lit", meter: "meter"),
            "trail": Composite(base: "exposed", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
            "mapped": ToneMap(source: "trail", curve: Reinhard),
            "display": Encode(source: "mapped", transfer: Srgb),
        },
        outputs: { "display": "display" },
    )"#;
    let mut alone = Host::new(graph(text));
    alone.post.parameter::<f32>("cached.amount").unwrap();
    let wanted = alone.shown();
    let mut host = Host::new(graph(text));
    let amount = host.post.parameter::<f32>("cached.amount").unwrap();
    drop_frame(&mut host, false);
    assert_same(&shown_next(&mut host), &wanted);
    // The value of a dropped frame is that of the next one, too.
    host.post.set(amount, 0.9).unwrap();
    drop_frame(&mut host, true);
    let same = alone.post.parameter::<f32>("cached.amount").unwrap();
    alone.post.set(same, 0.9).unwrap();
    assert_same(&host.shown(), &alone.shown());
}
