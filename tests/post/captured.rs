//! Frames that the crate `afterimage` writes for the report of a bug, and that the program renders.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use afterimage::host::{Camera, Executor, Rectangle, Snapshot, caps, download, upload};
use afterimage::{Frame, FrameKind, Gpu, Post, Source, wgpu};
use afterimage_graph::image::Size;

use super::opened::{DARKER, DARKER_SHADER, Folder};
use super::{scene, scene_texels};
use crate::support::command::program;
use crate::support::gpu::gpu;

const BASE: &str = r#"Pipeline(
    inputs: { "scene": Color, "depth": Depth, "camera": Camera },
    nodes: {
        "darker": Darker(source: "scene"),
        "exposed": Exposure(source: "darker", stops: 0.0),
        "red": WhiteBalance(source: "exposed", temperature: 4000.0, when: "red"),
        "far": LinearDepth(depth: "depth", camera: "camera"),
        "mapped": ToneMap(source: "red", curve: Reinhard),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "light": "red", "far": "far", "display": "display" },
    tiers: { "low": { "red.temperature": 9000.0 } },
)"#;

/// Depth at half of the way, as a renderer's depth buffer.
fn depth(gpu: &Gpu, size: Size) -> wgpu::TextureView {
    let usage =
        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("depth"),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let load = wgpu::Operations { load: wgpu::LoadOp::Clear(0.9), store: wgpu::StoreOp::Store };
    drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(load),
            stencil_ops: None,
        }),
        ..Default::default()
    }));
    gpu.queue.submit([encoder.finish()]);
    view
}

fn render(gpu: &Gpu, post: &mut Post, frame: &Frame<'_>) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    post.executor().count_from(0);
    post.encode(&mut encoder, frame).unwrap_or_else(|error| panic!("{error}"));
    gpu.queue.submit([encoder.finish()]);
    post.finish_changes().unwrap_or_else(|error| panic!("{error}"));
}

/// Runs the script of a capture.
fn replay(folder: &Path, arguments: &[&str]) {
    let program = program(folder);
    let mut script = std::process::Command::new("sh");
    script.arg(folder.join("render.sh")).args(arguments).env("AFTERIMAGE", program.get_program());
    for (name, value) in program.get_envs() {
        script.env(name, value.unwrap_or_default());
    }
    let output = script.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A pipeline of three folders at a tier, with a value, a fact, a camera, a depth buffer and rectangles.
#[test]
#[cfg_attr(any(no_gpu, windows), ignore = "AFTERIMAGE_NO_GPU is set, or there is no shell")]
fn the_program_renders_a_captured_frame() {
    let gpu = gpu();
    let folder = Folder::new("captured");
    folder.write("kinds/darker/node.ron", DARKER);
    folder.write("kinds/darker/darker.wgsl", &DARKER_SHADER.replace("FACTOR", "0.5"));
    let base = folder.write("shared/base.ron", BASE);
    let file = folder.write("looks/it's.ron", "Pipeline(extends: \"../shared/base.ron\")");
    let source = Source::from(&file).allow(base.parent().unwrap()).folder(folder.0.join("kinds")).tier("low");
    let mut post = Post::open(&gpu, source).unwrap_or_else(|error| panic!("{error}"));
    let stops = post.parameter::<f32>("exposed.stops").unwrap();
    post.set(stops, -1.25).unwrap();
    post.set_fact("red", true);
    let size = Size::new(96, 54);
    let (scene, depth) = (scene(&gpu, size), depth(&gpu, size));
    let view = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.8, 0.6, 0.0], [0.0, -0.6, 0.8, 0.0], [0.5, -1.0, -3.0, 1.0]];
    let projection = [[1.2, 0.0, 0.0, 0.0], [0.0, 2.1, 0.0, 0.0], [0.1, 0.2, -1.01, -1.0], [0.0, 0.0, -0.101, 0.0]];
    let camera = Camera::still(view, projection).data().unwrap();
    let part = Rectangle { x: 9, y: 4, width: 80, height: 48 };
    let frame = Frame {
        inputs: &[("scene", &scene), ("depth", &depth)],
        blocks: &[("camera", &camera)],
        rectangles: &[("scene", part), ("depth", part)],
        kind: FrameKind::Cut,
        ..Frame::default()
    };
    // The first frame asks for the plan of what is set.
    (0..2).for_each(|_| render(&gpu, &mut post, &frame));
    let capture = folder.0.join("a capture");
    post.capture(&gpu, &frame, &capture).unwrap_or_else(|error| panic!("{error}"));
    replay(&capture, &["--depth", "32"]);
    assert!(capture.join("display.png").is_file());
    for (name, channels) in [("light", 3), ("far", 1)] {
        let texels = download(&gpu.device, &gpu.queue, post.output(name).unwrap()).unwrap();
        let file =
            afterimage_media::read(&afterimage_media::Source::file(capture.join(format!("{name}.exr")))).unwrap();
        assert_eq!((file.width, file.height), (80, 48));
        let expected = texels.to_floats();
        for (left, right) in expected.iter().zip(file.pixels.to_f32().as_chunks::<4>().0) {
            assert_eq!(left[..channels], right[..channels], "{name}");
        }
        assert!(expected.iter().all(|texel| texel[0] > 0.0), "{name}");
    }
    let script = std::fs::read_to_string(capture.join("render.sh")).unwrap();
    for word in ["'exposed.stops=-1.25'", "'low'", "'red=true'", r"'pipeline/looks/it'\''s.ron'"] {
        assert!(script.contains(word), "{script}");
    }
}

/// Files that an engine has loaded by itself, and what cannot be written.
#[test]
#[cfg_attr(any(no_gpu, windows), ignore = "AFTERIMAGE_NO_GPU is set, or there is no shell")]
fn a_snapshot_is_captured_and_an_image_without_copies_is_an_error() {
    let gpu = gpu();
    let folder = Folder::new("captured-snapshot");
    let mut snapshot = Snapshot::of_text("own.ron", "Pipeline(extends: \"caracal.ron\")", &[]).unwrap();
    let caracal = std::fs::read(crate::support::gpu::pipelines().join("caracal.ron")).unwrap();
    snapshot.insert("caracal.ron".into(), Ok(caracal.into()));
    let executor = Executor::with_caps(&gpu.device, &gpu.queue, caps(&gpu.adapter, &gpu.device));
    let mut post = Post::of_snapshot(executor, snapshot, None).unwrap_or_else(|error| panic!("{error}"));
    let size = Size::new(48, 32);
    let scene = scene(&gpu, size);
    let frame = Frame { inputs: &[("scene", &scene)], kind: FrameKind::Cut, ..Frame::default() };
    render(&gpu, &mut post, &frame);
    post.capture(&gpu, &frame, &folder.0).unwrap_or_else(|error| panic!("{error}"));
    replay(&folder.0, &[]);
    let png = png::Decoder::new(BufReader::new(File::open(folder.0.join("display.png")).unwrap()));
    let mut png = png.read_info().unwrap();
    let mut codes = vec![0; png.output_buffer_size().unwrap()];
    assert_eq!(png.next_frame(&mut codes).unwrap().color_type, png::ColorType::Rgb);
    let display = download(&gpu.device, &gpu.queue, post.output("display").unwrap()).unwrap().bytes;
    let display: Vec<u8> = display.as_chunks::<4>().0.iter().flat_map(|texel| &texel[..3]).copied().collect();
    super::assert_same(&codes, &display);
    let image = afterimage_media::read(&afterimage_media::Source::file(folder.0.join("scene.exr"))).unwrap();
    assert_eq!(image.bytes(), scene_texels(size).bytes);

    let texture = upload(&gpu.device, &gpu.queue, &scene_texels(size)).unwrap();
    let closed = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("closed"),
        size: texture.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: texture.format(),
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let closed = closed.create_view(&Default::default());
    let frame = Frame { inputs: &[("scene", &closed)], ..frame };
    let error = post.capture(&gpu, &frame, &folder.0).unwrap_err().to_string();
    assert!(error.contains("`scene`") && error.contains("`COPY_SRC`"), "{error}");
}

/// A picture and a mask of 8 bits, in formats that no image of a plan has.
#[test]
#[cfg_attr(any(no_gpu, windows), ignore = "AFTERIMAGE_NO_GPU is set, or there is no shell")]
fn images_of_8_bits_are_captured_as_shaders_read_them() {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, R8Unorm, Rg8Unorm, Rgba8UnormSrgb};
    const PIPELINE: &str = r#"Pipeline(
        inputs: { "scene": Color, "mask": Mask },
        nodes: { "gray": Saturation(source: "scene", amount: 0.0), "within": Mix(source: "scene", other: "gray", mask: "mask") },
        outputs: { "light": "within" },
    )"#;
    let gpu = gpu();
    let view = |format: wgpu::TextureFormat, texel: &[u8]| {
        let size = wgpu::Extent3d { width: 7, height: 3, depth_or_array_layers: 1 };
        let usage =
            wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("8 bits"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        });
        let bytes_per_row = Some(7 * texel.len() as u32);
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row, ..Default::default() };
        gpu.queue.write_texture(texture.as_image_copy(), &texel.repeat(21), layout, size);
        texture.create_view(&Default::default())
    };
    // The sRGB codes 13 and 188 are 0.004024 and 0.502886 of light (IEC 61966-2-1).
    for (color, [red, green]) in [
        (view(Bgra8UnormSrgb, &[0, 188, 13, 255]), [0.004_024, 0.502_886]),
        (view(Rgba8UnormSrgb, &[13, 188, 0, 255]), [0.004_024, 0.502_886]),
        (view(Bgra8Unorm, &[0, 51, 102, 255]), [0.4, 0.2]),
        (view(Rg8Unorm, &[102, 51]), [0.4, 0.2]),
    ] {
        let folder = Folder::new("captured-8-bits");
        let file = folder.write("mask.ron", PIPELINE);
        let mut post = Post::open(&gpu, Source::from(&file)).unwrap_or_else(|error| panic!("{error}"));
        let mask = view(R8Unorm, &[51]);
        let inputs = &[("scene", &color), ("mask", &mask)];
        let frame = Frame { inputs, kind: FrameKind::Cut, ..Frame::default() };
        render(&gpu, &mut post, &frame);
        let texels = download(&gpu.device, &gpu.queue, color.texture()).unwrap().to_floats();
        for (found, wanted) in texels[20].into_iter().zip([red, green, 0.0, 1.0]) {
            assert!((found - wanted).abs() < 1e-6, "{:?}: {found} instead of {wanted}", color.texture().format());
        }
        let capture = folder.0.join("capture");
        post.capture(&gpu, &frame, &capture).unwrap_or_else(|error| panic!("{error}"));
        replay(&capture, &["--depth", "32"]);
        let file = afterimage_media::read(&afterimage_media::Source::file(capture.join("light.exr"))).unwrap();
        let rendered = download(&gpu.device, &gpu.queue, post.output("light").unwrap()).unwrap().to_floats();
        let luminance = 0.2126 * red + 0.7152 * green;
        for (left, right) in rendered.iter().zip(file.pixels.to_f32().as_chunks::<4>().0) {
            // A fifth of the way to gray, in half floats.
            assert!((left[0] - (red + 0.2 * (luminance - red))).abs() < 1e-3, "{left:?}");
            assert!(left.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-3), "{left:?} {right:?}");
        }
    }
}
