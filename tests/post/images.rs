//! Images of hosts in the formats that they have.

use afterimage::Post;
use afterimage_gpu::{Frame, FrameKind, Gpu, download, upload_bytes, wgpu};
use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};

use super::{Host, assert_same};
use crate::support::gpu::{Picture, Shared, another_device, changed, gpu, texture_bytes};

/// What a host sees in a target of this format, after a first frame.
fn in_target(host: &mut Host, size: Size, of_texture: wgpu::TextureFormat, of_view: wgpu::TextureFormat) -> Vec<u8> {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let texture = host.gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: of_texture,
        usage,
        view_formats: &[of_view],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor { format: Some(of_view), ..Default::default() });
    let (inputs, outputs) = (&[("scene", &host.scene)], &[("display", &view)]);
    let formats: &[_] = if of_view == of_texture { &[] } else { &[("display", of_view)] };
    let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
    let frame = Frame { inputs, outputs, formats, dt: 0.1, kind: FrameKind::Cut, ..Frame::default() };
    host.post.executor().count_from(0);
    host.post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
    host.gpu.queue.submit([encoder.finish()]);
    texture_bytes(&host.gpu, &texture, 4)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_encoded_pipeline_looks_the_same_in_every_kind_of_target() {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
    let size = Size::new(96, 54);
    for pipeline in ["lynx.ron", "tsushima.ron"] {
        let mut host = Host::new(changed(pipeline, None, &[]));
        let wanted = in_target(&mut host, size, Rgba8Unorm, Rgba8Unorm);
        assert!(wanted.iter().any(|code| *code != wanted[0]));
        let swapped: Vec<u8> = wanted.as_chunks::<4>().0.iter().flat_map(|[r, g, b, a]| [*b, *g, *r, *a]).collect();
        for (of_texture, of_view) in [
            (Rgba8UnormSrgb, Rgba8UnormSrgb),
            (Bgra8UnormSrgb, Bgra8UnormSrgb),
            (Bgra8Unorm, Bgra8Unorm),
            // The same texture, first as it is and then with a view that encodes.
            (Bgra8Unorm, Bgra8UnormSrgb),
            (Bgra8UnormSrgb, Bgra8Unorm),
        ] {
            let shown = in_target(&mut host, size, of_texture, of_view);
            let wanted = if of_texture.remove_srgb_suffix() == Rgba8Unorm { &wanted } else { &swapped };
            assert_same(&shown, wanted);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_output_that_holds_linear_light_is_decoded() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let codes = host.shown();
    host.post.set_output_linear("display");
    host.frame().unwrap();
    let texture = host.post.output("display").unwrap();
    let texels = download(&host.gpu.device, &host.gpu.queue, texture).unwrap();
    let picture = Picture::of(&texels);
    let encoded = |x: f64| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    let mut seen = std::collections::BTreeSet::new();
    for (code, pixel) in codes.as_chunks::<4>().0.iter().zip(&picture.pixels) {
        for channel in 0..3 {
            let again = (255.0 * encoded(f64::from(pixel[channel]))).round();
            assert!((again - f64::from(code[channel])).abs() < 0.5, "{code:?} {pixel:?}");
            seen.insert(code[channel]);
        }
    }
    assert!(seen.len() > 100, "the picture has many codes: {}", seen.len());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn inputs_of_an_engine_are_read_as_they_are() {
    use wgpu::TextureFormat::{Bgra8Unorm, Depth32Float, R8Unorm, Rg8Unorm, Rgb10a2Unorm, Rgba8UnormSrgb};
    let gpu = gpu();
    // The output has half floats.
    const HALF: f32 = 5e-4;
    // A device may decode sRGB with an error of half a code, which is 3e-3 at 188.
    let ten_bits = (3_u32 << 30 | 512 << 20 | 1023 << 10 | 256).to_le_bytes();
    let cases: [(_, &[u8], [f32; 4], f32); 5] = [
        (Bgra8Unorm, &[51, 102, 204, 255], [0.8, 0.4, 0.2, 1.0], HALF),
        (Rgba8UnormSrgb, &[255, 188, 0, 255], [1.0, 0.502_886, 0.0, 1.0], 3e-3),
        (R8Unorm, &[51], [0.2, 0.0, 0.0, 1.0], HALF),
        (Rg8Unorm, &[51, 102], [0.2, 0.4, 0.0, 1.0], HALF),
        (Rgb10a2Unorm, &ten_bits, [0.250_24, 1.0, 0.500_49, 1.0], HALF),
    ];
    let described = |format, usage| wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    };
    let mut post = Post::new(&gpu, same_pixels());
    let mut read = |texture: &wgpu::Texture| {
        let view = texture.create_view(&Default::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = Frame { inputs: &[("in", &view)], kind: FrameKind::Cut, ..Frame::default() };
        post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        Picture::of(&download(&gpu.device, &gpu.queue, post.output("out").unwrap()).unwrap()).at(0, 0)
    };
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    for (format, bytes, wanted, tolerance) in cases {
        let texture = gpu.device.create_texture(&described(format, usage));
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: None, rows_per_image: None };
        gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        let got = read(&texture);
        let off = got.iter().zip(wanted).map(|(got, wanted)| (got - wanted).abs()).fold(0.0, f32::max);
        assert!(off < tolerance, "{format:?}: {got:?}, not {wanted:?}");
    }
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT;
    let depth = gpu.device.create_texture(&described(Depth32Float, usage));
    clear_depth(&gpu, &depth);
    assert_eq!(read(&depth)[0], 0.625);
}

/// Clears a depth to 0.625, and the stencil next to it, if there is one.
fn clear_depth(gpu: &Gpu, texture: &wgpu::Texture) {
    clear_level(gpu, texture, 0, 0.625);
}

fn view_of_level(texture: &wgpu::Texture, level: u32) -> wgpu::TextureView {
    let one = wgpu::TextureViewDescriptor { base_mip_level: level, mip_level_count: Some(1), ..Default::default() };
    texture.create_view(&one)
}

fn clear_level(gpu: &Gpu, texture: &wgpu::Texture, level: u32, depth: f32) {
    let view = view_of_level(texture, level);
    let stencil = wgpu::Operations { load: wgpu::LoadOp::Clear(3), store: wgpu::StoreOp::Store };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(depth), store: wgpu::StoreOp::Store }),
            stencil_ops: texture.format().has_stencil_aspect().then_some(stencil),
        }),
        ..Default::default()
    });
    gpu.queue.submit([encoder.finish()]);
}

/// A texture with a scene in its second level.
fn with_levels(gpu: &Gpu, usage: wgpu::TextureUsages) -> wgpu::Texture {
    let texels = super::scene_texels(Size::new(48, 27));
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 96, height: 54, depth_or_array_layers: 1 },
        mip_level_count: 3,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: usage | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let to = wgpu::TexelCopyTextureInfo { mip_level: 1, ..texture.as_image_copy() };
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(48 * 8), rows_per_image: None };
    let size = wgpu::Extent3d { width: 48, height: 27, depth_or_array_layers: 1 };
    gpu.queue.write_texture(to, &texels.bytes, layout, size);
    texture
}

fn level(texture: &wgpu::Texture, base_mip_level: u32, mip_level_count: Option<u32>) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor { base_mip_level, mip_level_count, ..Default::default() })
}

/// wgpu does not say which level a view shows. It is found where it can be tried, and stated elsewhere.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_view_of_a_level_has_the_size_of_that_level() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    host.scene = super::scene(&host.gpu, Size::new(48, 27));
    let wanted = host.shown();
    let drawable = with_levels(&host.gpu, wgpu::TextureUsages::RENDER_ATTACHMENT);
    host.scene = level(&drawable, 1, Some(1));
    assert_same(&host.shown(), &wanted);
    assert_eq!(host.plan().size, Size::new(48, 27));
    // Of all levels from the second on, and of a texture that nothing can be tried with.
    let closed = with_levels(&host.gpu, wgpu::TextureUsages::empty());
    for view in [level(&drawable, 1, None), level(&closed, 1, Some(1))] {
        host.scene = view;
        let error = host.frame().unwrap_err().to_string();
        assert!(error.contains("has 3 levels") && error.contains(r#"`levels: &[("scene", 0)]`"#), "{error}");
        let inputs = &[("scene", &host.scene)];
        let frame = Frame { inputs, levels: &[("scene", 1)], dt: 0.1, kind: FrameKind::Cut, ..Frame::default() };
        host.post.executor().count_from(0);
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        host.post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        host.gpu.queue.submit([encoder.finish()]);
        let shown = download(&host.gpu.device, &host.gpu.queue, host.post.output("display").unwrap()).unwrap();
        assert_same(&shown.bytes, &wanted);
        let frame = Frame { levels: &[("scene", 3)], ..frame };
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        let error = host.post.encode(&mut encoder, &frame).unwrap_err().to_string();
        assert!(error.contains("the level 3 is stated, and its texture has 3"), "{error}");
    }
    // An output, too: a pipeline without inputs has its size.
    let shown = level(&drawable, 2, Some(1));
    let text = r#"Pipeline(nodes: { "scene": DemoScene() }, outputs: { "scene": "scene" })"#;
    let document = parse("scene.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let graph = check(&document, &crate::support::gpu::registry(), &CheckOptions::default()).unwrap().0;
    let mut post = Post::new(&host.gpu, graph);
    let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
    let frame = Frame { outputs: &[("scene", &shown)], ..Frame::default() };
    post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
    host.gpu.queue.submit([encoder.finish()]);
    assert_eq!(post.plan().map(|plan| plan.size), Some(Size::new(24, 13)));
}

/// Each error names what is wrong, and nothing else.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_image_that_does_not_fit_is_told_by_the_one_difference_that_matters() {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba16Float};
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    host.frame().unwrap();
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let mut error = |[width, height]: [u32; 2], format, view_format: Option<wgpu::TextureFormat>, usage| {
        let texture = host.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: view_format.as_slice(),
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor { format: view_format, ..Default::default() });
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        let frame = Frame { inputs: &[("scene", &host.scene)], outputs: &[("display", &view)], ..Frame::default() };
        host.post.encode(&mut encoder, &frame).map(|()| String::new()).unwrap_or_else(|error| error.to_string())
    };
    let size = [96, 54];
    assert_eq!(
        error([64, 36], Bgra8Unorm, None, usage),
        "the image given for `display` is 64x36, but the plan was made for 96x54"
    );
    let unusable = error(size, Bgra8Unorm, None, wgpu::TextureUsages::COPY_DST);
    assert!(unusable.ends_with("its texture lacks the usage `RENDER_ATTACHMENT`"), "{unusable}");
    let encodes = error(size, Bgra8Unorm, Some(Bgra8UnormSrgb), usage);
    assert!(encodes.contains(r#"`formats: &[("display", TextureFormat::Bgra8UnormSrgb)]` in `Frame`"#), "{encodes}");
    assert_eq!(error(size, Rgba16Float, None, usage), "");
}

/// Engines keep a stencil next to the depth. A shader can read a view of the depth alone, which not every engine makes.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_depth_next_to_a_stencil_is_read_through_any_view() {
    use wgpu::TextureFormat::{Depth24PlusStencil8, Depth32FloatStencil8};
    let features = gpu().device.features() | wgpu::Features::DEPTH32FLOAT_STENCIL8;
    let limits = gpu().device.limits();
    let gpu = Shared::of(another_device(&gpu(), features, limits));
    for format in [Depth24PlusStencil8, Depth32FloatStencil8] {
        let mut post = Post::new(&gpu, same_pixels());
        let depth = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        clear_depth(&gpu, &depth);
        match (format, download(&gpu.device, &gpu.queue, &depth)) {
            (Depth32FloatStencil8, texels) => {
                assert!(texels.unwrap().to_floats().iter().all(|texel| texel[0] == 0.625));
            }
            // WebGPU has no copy of it.
            (_, refused) => assert!(refused.unwrap_err().to_string().contains("Depth24PlusStencil8")),
        }
        for aspect in [wgpu::TextureAspect::All, wgpu::TextureAspect::DepthOnly] {
            let view = depth.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
            for _ in 0..2 {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                let frame = Frame { inputs: &[("in", &view)], ..Frame::default() };
                post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{format:?}, {aspect:?}: {error}"));
                gpu.queue.submit([encoder.finish()]);
            }
            assert_eq!(post.executor().passes_bound(), 0, "{format:?}, {aspect:?}: a view is bound once");
            let shown =
                Picture::of(&download(&gpu.device, &gpu.queue, post.output("out").unwrap()).unwrap()).at(5, 3)[0];
            assert!((shown - 0.625).abs() < 1e-3, "{format:?}, {aspect:?}: {shown}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_stated_level_of_a_depth_next_to_a_stencil_is_read() {
    let gpu = gpu();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 1 },
        mip_level_count: 2,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth24PlusStencil8,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let levels = [(0, 0.25), (1, 0.75)];
    levels.iter().for_each(|(level, depth)| clear_level(&gpu, &texture, *level, *depth));
    let mut post = Post::new(&gpu, same_pixels());
    for (level, depth) in levels {
        let view = view_of_level(&texture, level);
        let frame = Frame { inputs: &[("in", &view)], levels: &[("in", level)], ..Frame::default() };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("level {level}: {error}"));
        gpu.queue.submit([encoder.finish()]);
        let shown = Picture::of(&download(&gpu.device, &gpu.queue, post.output("out").unwrap()).unwrap());
        assert!((shown.at(5, 3)[0] - depth).abs() < 1e-3, "level {level}: {}", shown.at(5, 3)[0]);
    }
}

/// A device says which numbers of samples it has textures with, and does not refuse a view without a name.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn samples_that_a_device_does_not_have_are_named() {
    let gpu = gpu();
    let format = wgpu::TextureFormat::Rgba16Float;
    let offered = gpu.adapter.get_texture_format_features(format).flags;
    let mut refused = 0;
    for samples in [2, 4, 8, 16] {
        let desc = ImageDesc::new(Size::new(4, 4)).multisampled(samples);
        let bytes = vec![0; 4 * 4 * 8 * samples as usize];
        let made = upload_bytes(&gpu.device, &gpu.queue, desc, &bytes);
        if offered.sample_count_supported(samples) {
            assert_eq!(made.unwrap_or_else(|error| panic!("{error}")).sample_count(), samples);
            continue;
        }
        refused += 1;
        let error = made.expect_err("the device has no such textures").to_string();
        let wanted = format!("this device has no Rgba16Float textures with {samples} samples in each pixel; it has ");
        assert!(error.starts_with(&wanted) && error.contains('4'), "{error}");
    }
    assert!(refused > 0, "no device has all of them");
}

/// The pixels of the input `in` as the output `out`.
fn same_pixels() -> Graph {
    let text = r#"Pipeline(inputs: { "in": Data }, nodes: { "out": Mask(source: "in") }, outputs: { "out": "out" })"#;
    let kind = afterimage_graph::node::folder_kind_of(
        (
            "node.ron",
            r#"Kind(name: "Mask", doc: "Its pixels.", inputs: { "source": Image(doc: "Numbers.") },
            outputs: { "result": Image(doc: "The same.", state: Same("source")) })"#,
        ),
        &[("mask.wgsl", "fn mask(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }")],
    );
    let kind = kind.unwrap_or_else(|errors| panic!("{errors}"));
    let registry = afterimage_graph::node::Registry::new(&[&[kind]]).unwrap();
    let document = parse("in.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
}
