//! Multisampled textures that a renderer draws, and what `Resolve` makes of them.

use afterimage::Post;
use afterimage_gpu::wgpu::{self, TextureFormat, TextureUsages};
use afterimage_gpu::{Frame, Gpu, download};
use afterimage_graph::check::Graph;
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::{Arg, ImageId};
use afterimage_plan::{HostImageDesc, HostInputs, PlanError};

use crate::support::gpu::{Picture, Run, gpu};
use crate::support::harness::Nodes;
use crate::support::player::Player;

const SIZE: u32 = 32;

/// A lamp of 50 whose edge crosses every kind of pixel, in front of a dark wall.
const SCENE: &str = "
@vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let places = array(vec2f(-0.9, -0.8), vec2f(0.95, -0.35), vec2f(-0.4, 0.9));
    return vec4f(places[index], 0.25, 1.0);
}
@fragment fn lamp() -> @location(0) vec4f { return vec4f(50.0, 50.0, 50.0, 1.0); }
";

/// The textures of a renderer: color and depth with this many samples, and the color that the device resolves.
struct Drawn {
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    resolved: wgpu::Texture,
}

fn texture(gpu: &Gpu, format: TextureFormat, samples: u32) -> wgpu::Texture {
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: if samples == 1 { usage | TextureUsages::COPY_SRC } else { usage },
        view_formats: &[],
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&Default::default())
}

fn lamp(gpu: &Gpu) -> Drawn {
    let source = wgpu::ShaderSource::Wgsl(SCENE.into());
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(TextureFormat::Rgba16Float.into())],
        }),
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: 4, ..Default::default() },
        multiview_mask: None,
        cache: None,
    });
    let color = view(&texture(gpu, TextureFormat::Rgba16Float, 4));
    let depth = view(&texture(gpu, TextureFormat::Depth32Float, 4));
    let resolved = texture(gpu, TextureFormat::Rgba16Float, 1);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &color,
            depth_slice: None,
            resolve_target: Some(&view(&resolved)),
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.draw(0..3, 0..1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    Drawn { color, depth, resolved }
}

fn graph(node: &str, state: &str) -> Graph {
    Nodes::new(&format!("\"result\": {node}"), &[("in", &format!("{state}(multisampled: true)"))]).graph()
}

/// The output of a pipeline over one texture of a host.
fn shown(gpu: &Gpu, graph: &Graph, input: &wgpu::TextureView) -> Result<Picture, String> {
    let mut post = Post::with_executor(gpu.executor(), graph.clone());
    post.set_options(afterimage_plan::Options { exact: true, ..Default::default() });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = Frame { inputs: &[("in", input)], ..Frame::default() };
    post.encode(&mut encoder, &frame).map_err(|error| error.to_string())?;
    gpu.queue.submit([encoder.finish()]);
    let texels = post.output("out").and_then(|texture| download(&gpu.device, &gpu.queue, texture));
    Ok(Picture::of(&texels.map_err(|error| error.to_string())?))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plain_mean_is_what_the_device_resolves_and_weights_keep_the_edge() {
    let gpu = gpu();
    let drawn = lamp(&gpu);
    let resolved = Picture::of(&download(&gpu.device, &gpu.queue, &drawn.resolved).expect("the device is there"));
    let plain = shown(&gpu, &graph("Resolve(source: \"in\", gain: 0.0)", "Color"), &drawn.color);
    let plain = plain.expect("the texture fits");
    assert_eq!(plain.pixels, resolved.pixels);
    let weighted = shown(&gpu, &graph("Resolve(source: \"in\")", "Color"), &drawn.color).expect("the texture fits");
    let reinhard = |light: f32| light / (1.0 + light);
    let mut seen = [0; 5];
    for (found, mean) in weighted.pixels.iter().zip(&resolved.pixels) {
        let covered = (mean[3] * 4.0).round() as usize;
        seen[covered] += 1;
        let ideal = reinhard(50.0) * covered as f32 / 4.0;
        assert!((reinhard(found[0]) - ideal).abs() < 1e-5, "{covered} samples: {found:?}");
        assert_eq!(found[3], mean[3], "alpha is not weighted");
    }
    assert!(seen.iter().all(|count| *count >= 3), "pixels with 0 to 4 covered samples: {seen:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_depth_is_that_of_one_of_its_surfaces() {
    let gpu = gpu();
    let drawn = lamp(&gpu);
    let of = |filter: &str| {
        let node = format!("Resolve(source: \"in\", filter: {filter})");
        shown(&gpu, &graph(&node, "Depth"), &drawn.depth).expect("the texture fits")
    };
    let (near, far) = (of("Smallest"), of("Largest"));
    let covered = Picture::of(&download(&gpu.device, &gpu.queue, &drawn.resolved).expect("the device is there"));
    for ((near, far), covered) in near.pixels.iter().zip(&far.pixels).zip(&covered.pixels) {
        assert_eq!(near[0], if covered[3] > 0.0 { 0.25 } else { 1.0 });
        assert_eq!(far[0], if covered[3] == 1.0 { 0.25 } else { 1.0 });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_sample_that_is_not_a_number_leaves_the_mean_of_the_others() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.5];
    // One pixel with one bad sample and three others, and a good neighbor, which gives nothing. Infinity is light, and
    // a negative number is part of a wide color.
    let samples = |bad: f32| Picture::new(2, 4, |x, y| [if (x, y) == (0, 1) { bad } else { 2.0 }, 1.0, 4.0, 1.0]);
    let found = bad.map(|bad| {
        let node = Nodes::new("\"result\": Resolve(source: \"in\", gain: 0.0)", &[("in", "Color(multisampled: true)")]);
        node.exact(&[&samples(bad)])
    });
    let red = found.each_ref().map(|picture| picture.at(0, 0)[0]);
    assert_eq!(red, [2.0, (65504.0 + 6.0) / 4.0, 2.0, 1.375]);
    assert!(found.iter().all(|picture| picture.at(0, 0)[1..] == [1.0, 4.0, 1.0] && picture.at(1, 0)[0] == 2.0));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn samples_that_do_not_fit_are_errors() {
    let gpu = gpu();
    let drawn = lamp(&gpu);
    let resolve = graph("Resolve(source: \"in\")", "Color");
    let error = shown(&gpu, &resolve, &view(&drawn.resolved)).expect_err("it has one sample");
    assert!(error.contains("it has one sample in each pixel, and the pipeline requires more"), "{error}");
    let plain = Nodes::new("\"result\": Exposure(source: \"in\", stops: 1.0)", &[("in", "Color")]).graph();
    let error = shown(&gpu, &plain, &drawn.color).expect_err("it has four samples");
    assert!(error.contains("declare the input as `multisampled: true` and wire it to a `Resolve`"), "{error}");
    drop(gpu);
    let given = |samples: u32| {
        let desc = afterimage_graph::image::ImageDesc::new(Size::new(SIZE, SIZE)).multisampled(samples);
        let inputs = [("in".to_owned(), HostImageDesc { desc, finite: false })].into();
        HostInputs { inputs, ..HostInputs::none(desc.size) }
    };
    let planned = |samples: u32| {
        let gpu = crate::support::gpu::gpu();
        Run::new(&resolve).session(&gpu).post().plan_for(given(samples))
    };
    assert_eq!(planned(1).err(), Some(PlanError::WrongSamples { input: "in".into(), given: 1 }));
    // A plan for eight samples does not take a texture of four.
    let plan = planned(8).expect("plans know no limit of samples");
    assert_eq!(plan.images.iter().map(|image| image.desc.samples).max(), Some(8));
    let mut player = Player::new();
    player.executor.load(plan).expect("the layout is that of any number of samples");
    let error = player.run(&Frame { inputs: &[("in", &drawn.color)], ..Frame::default() }).expect_err("it has four");
    assert!(error.to_string().contains("it has 4 samples in each pixel, and the plan is made for 8"), "{error}");
}

/// A point node after the resolve is in its pass: the samples are read, and one image is written.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nodes_of_a_pixel_are_fused_into_a_resolve() {
    let text = "\"one\": Resolve(source: \"in\"), \"result\": Exposure(source: \"one\", stops: 1.0)";
    let graph = Nodes::new(text, &[("in", "Color(multisampled: true)")]).graph();
    let picture = Picture::new(8, 16, |x, y| [(x + y) as f32, 1.0, 0.5, 1.0]);
    let plan = Run::new(&graph).plan(&gpu(), &[("in", &picture)]);
    let [pass] = plan.passes.as_slice() else { panic!("{} passes", plan.passes.len()) };
    assert_eq!(pass.pass.nodes, ["one", "result"]);
    let read = pass.pass.kernels[0].arg("source");
    let image = |id: ImageId| (plan.image(id).desc.samples, plan.image(id).desc.format);
    assert!(matches!(read, Some(Arg::Texture(id)) if image(id) == (4, Format::Rgba16Float)), "{read:?}");
}
