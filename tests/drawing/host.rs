//! Passes that a host fills with its own draws.

use afterimage::Post;
use afterimage_gpu::{DrawTargets, Frame, Gpu, HostDraw, download, wgpu};
use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::verify;

use super::kinds::{self, CLEARS, LARGE, OTHER, Vertex};
use super::{SAMPLES, SIZE, assert_texels, at, color_or};
use crate::support::gpu::{Picture, gpu};
use crate::support::layer;

fn graph(nodes: &str, outputs: &str) -> Graph {
    let text = format!("Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})");
    let document = parse("host.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let tables = [afterimage_nodes::ALL, afterimage_nodes::HOST, kinds::ALL];
    let registry = Registry::new(&tables).expect("no two share a name");
    check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
}

fn post(gpu: &Gpu, nodes: &str, outputs: &str) -> Post {
    let mut post = Post::with_executor(gpu.executor(), graph(nodes, outputs));
    post.set_size(Some(SIZE));
    post
}

/// One frame with these draws.
fn frame(gpu: &Gpu, post: &mut Post, draws: &mut [HostDraw<'_>]) -> Result<(), String> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    post.encode_drawing(&mut encoder, &Frame::default(), draws).map_err(|error| error.to_string())?;
    gpu.queue.submit([encoder.finish()]);
    Ok(())
}

fn shown(gpu: &Gpu, post: &Post, output: &str) -> Picture {
    Picture::of(&download(&gpu.device, &gpu.queue, post.output(output).unwrap()).expect("the device is there"))
}

/// A host's pipeline that draws triangles whose numbers are in its shader; a third number is light.
fn pipeline(gpu: &Gpu, targets: &DrawTargets, vertices: &[Vertex], light: &str) -> wgpu::RenderPipeline {
    let places: Vec<String> =
        vertices.iter().map(|([x, y, z], _)| format!("vec4f({x:?}, {y:?}, {z:?}, 1.0)")).collect();
    let text = format!(
        "@vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {{
            var places = array({});
            return places[index];
        }}
        @fragment fn light(@builtin(position) at: vec4f) -> @location(0) vec4f {{ return {light}; }}",
        places.join(", ")
    );
    let source = wgpu::ShaderSource::Wgsl(text.into());
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let colors: Vec<_> = targets.colors.iter().map(|format| Some((*format).into())).collect();
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        fragment: (!colors.is_empty()).then_some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("light"),
            compilation_options: Default::default(),
            targets: &colors,
        }),
        primitive: Default::default(),
        depth_stencil: targets.depth.map(|format| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: targets.samples, ..Default::default() },
        multiview_mask: None,
        cache: None,
    })
}

/// The targets of a node, after a frame that draws nothing there.
fn targets(gpu: &Gpu, post: &mut Post, nodes: &[&str]) -> Vec<DrawTargets> {
    let mut nothing: Vec<_> = nodes.iter().map(|_| |_: &mut wgpu::RenderPass<'_>| ()).collect();
    let mut draws: Vec<HostDraw<'_>> =
        nodes.iter().zip(&mut nothing).map(|(node, fill)| HostDraw { node, fill }).collect();
    frame(gpu, post, &mut draws).unwrap_or_else(|error| panic!("{error}"));
    nodes.iter().map(|node| post.draw_targets(node).expect("the plan has the pass")).collect()
}

fn pixels() -> impl Iterator<Item = (u32, u32)> {
    (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_host_fills_a_pass_with_its_own_draws() {
    let _alone = layer::alone();
    let gpu = gpu();
    let nodes = "\"drawn\": Draw(clear: (0.25, 0.5, 1.0, 0.0)), \"bright\": Exposure(source: \"drawn\", stops: 1.0)";
    let mut post = post(&gpu, nodes, "\"out\": \"bright\", \"depth\": \"drawn.depth\"");
    layer::messages();
    let targets = targets(&gpu, &mut post, &["drawn"]).remove(0);
    let wanted = DrawTargets {
        size: SIZE,
        colors: vec![wgpu::TextureFormat::Rgba16Float],
        depth: Some(wgpu::TextureFormat::Depth32Float),
        samples: 1,
    };
    assert_eq!(targets, wanted);
    assert_eq!(shown(&gpu, &post, "out").at(3, 3), [0.5, 1.0, 2.0, 0.0], "without draws there is the clear color");
    let both = [LARGE, OTHER].concat();
    let pipeline = pipeline(&gpu, &targets, &both, "vec4f(4.0 * at.z, 2.0, 0.125, 1.0)");
    let mut calls = 0;
    let mut fill = |pass: &mut wgpu::RenderPass<'_>| {
        calls += 1;
        pass.set_pipeline(&pipeline);
        pass.draw(0..6, 0..1);
    };
    for _ in 0..3 {
        let draws = &mut [HostDraw { node: "other", fill: &mut |_| panic!("no node has this name") }];
        assert!(frame(&gpu, &mut post, draws).is_err(), "the pass is not filled");
        let draws = &mut [HostDraw { node: "drawn", fill: &mut fill }];
        frame(&gpu, &mut post, draws).unwrap_or_else(|error| panic!("{error}"));
    }
    assert_eq!(calls, 3);
    verify(post.plan().expect("it runs")).unwrap_or_else(|faults| panic!("{faults:?}"));
    let (light, depth) = (shown(&gpu, &post, "out"), shown(&gpu, &post, "depth"));
    for (x, y) in pixels() {
        let of = |triangle| at(triangle, SIZE, (x, y), [0.5; 2]).map(|(_, depth)| depth);
        let nearest = [of(&LARGE), of(&OTHER)].into_iter().flatten().reduce(f64::min);
        let found = light.at(x, y).map(f64::from);
        let expected = nearest.map_or([0.5, 1.0, 2.0, 0.0], |depth| [8.0 * depth, 4.0, 0.25, 1.0]);
        assert!((found[0] - expected[0]).abs() < 4e-3 && found[1..] == expected[1..], "{found:?} is not {expected:?}");
        assert!((f64::from(depth.at(x, y)[0]) - nearest.unwrap_or(1.0)).abs() < 1e-6, "{x}, {y}: {:?}", depth.at(x, y));
    }
    assert_eq!(layer::messages(), Vec::<String>::new());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_host_is_told_the_size_of_the_level_that_it_fills() {
    let _alone = layer::alone();
    let gpu = gpu();
    let mut post = post(&gpu, "\"part\": Part()", "\"out\": \"part\"");
    let targets = targets(&gpu, &mut post, &["part"]).remove(0);
    let half = Size::new(SIZE.width / 2, SIZE.height / 2);
    assert_eq!(targets.size, half);
    let light = [1.0, 2.0, 4.0, 1.0];
    let pipeline = pipeline(&gpu, &targets, &LARGE, "vec4f(1.0, 2.0, 4.0, 1.0)");
    let mut fill = |pass: &mut wgpu::RenderPass<'_>| {
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..1);
    };
    frame(&gpu, &mut post, &mut [HostDraw { node: "part", fill: &mut fill }]).unwrap_or_else(|error| panic!("{error}"));
    let lit = LARGE.map(|(place, _)| (place, light));
    assert_texels(&shown(&gpu, &post, "out"), half, |pixel| color_or(&lit, half, pixel, CLEARS[1]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pass_without_draws_is_an_error_that_names_it() {
    let gpu = gpu();
    let mut post = post(&gpu, "\"drawn\": Draw()", "\"out\": \"drawn\"");
    let error = frame(&gpu, &mut post, &mut []).expect_err("nothing fills it");
    assert_eq!(error, "no draws were given for node `drawn`, which the host fills: give them to `encode_drawing`");
    let draws = &mut [HostDraw { node: "drawn", fill: &mut |_| () }];
    assert_eq!(frame(&gpu, &mut post, draws), Ok(()), "the next frame is filled");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn samples_and_a_depth_map_of_the_host_go_to_their_readers() {
    let _alone = layer::alone();
    let gpu = gpu();
    let nodes = "\"map\": DrawDepth(width: 16, height: 8, depth: Depth16Unorm), \"frame\": DrawSamples(),
        \"one\": Resolve(source: \"frame\", gain: 0.0)";
    let mut post = post(&gpu, nodes, "\"out\": \"one\", \"map\": \"map\"");
    layer::messages();
    let targets = targets(&gpu, &mut post, &["frame", "map"]);
    assert_eq!((targets[0].samples, targets[0].size), (4, SIZE));
    assert_eq!((targets[1].samples, targets[1].size), (1, Size::new(16, 8)));
    assert_eq!((targets[1].colors.len(), targets[1].depth), (0, Some(wgpu::TextureFormat::Depth16Unorm)));
    let frames = pipeline(&gpu, &targets[0], &LARGE, "vec4f(8.0, 4.0, 2.0, 1.0)");
    let maps = pipeline(&gpu, &targets[1], &LARGE, "vec4f(1.0)");
    let draw = |pipeline: wgpu::RenderPipeline| {
        move |pass: &mut wgpu::RenderPass<'_>| {
            pass.set_pipeline(&pipeline);
            pass.draw(0..3, 0..1);
        }
    };
    let (mut frames, mut maps) = (draw(frames), draw(maps));
    let draws = &mut [HostDraw { node: "map", fill: &mut maps }, HostDraw { node: "frame", fill: &mut frames }];
    frame(&gpu, &mut post, draws).unwrap_or_else(|error| panic!("{error}"));
    let (light, map) = (shown(&gpu, &post, "out"), shown(&gpu, &post, "map"));
    for (x, y) in pixels() {
        let covered = SAMPLES.iter().filter(|place| at(&LARGE, SIZE, (x, y), **place).is_some()).count();
        let share = covered as f32 / 4.0;
        assert_eq!(light.at(x, y), [8.0 * share, 4.0 * share, 2.0 * share, share], "{x}, {y}");
    }
    let small = Size::new(16, 8);
    for (x, y) in (0..8).flat_map(|y| (0..16).map(move |x| (x, y))) {
        let expected = if at(&LARGE, small, (x, y), [0.5; 2]).is_some() { 0.25 } else { 1.0 };
        assert!((map.at(x, y)[0] - expected).abs() <= 0.5 / 65535.0 + 1e-7, "{x}, {y}: {:?}", map.at(x, y));
    }
    assert_eq!(layer::messages(), Vec::<String>::new());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_depth_of_the_frame_before_is_kept() {
    let _alone = layer::alone();
    let gpu = gpu();
    let mut post = post(&gpu, "\"drawn\": Draw()", "\"out\": \"drawn\", \"past\": \"drawn.depth@previous\"");
    layer::messages();
    let targets = targets(&gpu, &mut post, &["drawn"]).remove(0);
    let past = |post: &Post| shown(&gpu, post, "past");
    assert!(past(&post).pixels.iter().all(|pixel| pixel[0] == 0.0), "before the first frame there is none");
    let pipeline = pipeline(&gpu, &targets, &LARGE, "vec4f(1.0)");
    let mut fill = |pass: &mut wgpu::RenderPass<'_>| {
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..1);
    };
    for frames in 1..4 {
        let draws = &mut [HostDraw { node: "drawn", fill: &mut fill }];
        frame(&gpu, &mut post, draws).unwrap_or_else(|error| panic!("{error}"));
        let past = past(&post);
        for (x, y) in pixels() {
            let is_drawn = frames > 1 && at(&LARGE, SIZE, (x, y), [0.5; 2]).is_some();
            assert_eq!(past.at(x, y)[0], if is_drawn { 0.25 } else { 1.0 }, "{x}, {y} after {frames} frames");
        }
    }
    assert_eq!(layer::messages(), Vec::<String>::new());
}

/// Light that is not finite does not come out of a pass whose contents nobody knows.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_a_host_draws_is_sanitized_where_it_is_read() {
    let gpu = gpu();
    for reader in ["Exposure(source: \"drawn\", stops: 0.0)", "Gaussian(source: \"drawn\", sigma: 2.0)"] {
        let mut post = post(&gpu, &format!("\"drawn\": Draw(), \"read\": {reader}"), "\"out\": \"read\"");
        let targets = targets(&gpu, &mut post, &["drawn"]).remove(0);
        // Zero by zero, which no compiler knows.
        let pipeline = pipeline(&gpu, &targets, &LARGE, "vec4f((at.x - at.x) / (at.y - at.y), 1e30 * at.x, 1.0, 1.0)");
        let mut fill = |pass: &mut wgpu::RenderPass<'_>| {
            pass.set_pipeline(&pipeline);
            pass.draw(0..3, 0..1);
        };
        frame(&gpu, &mut post, &mut [HostDraw { node: "drawn", fill: &mut fill }]).unwrap_or_else(|e| panic!("{e}"));
        let shown = shown(&gpu, &post, "out");
        assert!(shown.pixels.as_flattened().iter().all(|number| number.is_finite()), "{reader}");
        assert!(shown.pixels.iter().any(|pixel| pixel[1] > 60_000.0), "{reader}: infinite light is light");
    }
}

#[test]
fn files_that_ask_for_what_cannot_be_drawn_are_refused() {
    let said = |nodes: &str, output: &str| {
        let text = format!("Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"{output}\" }})");
        let document = parse("host.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
        let registry = Registry::new(&[afterimage_nodes::ALL, afterimage_nodes::HOST]).expect("no two share a name");
        match check(&document, &registry, &CheckOptions::default()) {
            Ok(_) => String::new(),
            Err(errors) => errors.to_string(),
        }
    };
    let resolved = |node: &str| format!("\"drawn\": {node}, \"one\": Resolve(source: \"drawn\")");
    assert_eq!(said(&resolved("DrawSamples(format: Rg16Float)"), "one"), "");
    let cases = [
        (resolved("DrawSamples(format: Rgba32Float)"), "one", "no device has to draw samples of the format"),
        (resolved("DrawSamples(format: Depth32Float)"), "one", "no format is called `Depth32Float`"),
        (resolved("DrawSamples(width: 9000)"), "one", "width"),
        (resolved("Draw()"), "one", "Multisampled"),
        ("\"drawn\": DrawSamples()".into(), "drawn", "Multisampled"),
        ("\"drawn\": DrawSamples(), \"bright\": Exposure(source: \"drawn\")".into(), "bright", "Multisampled"),
    ];
    for (nodes, output, wanted) in cases {
        let said = said(&nodes, output);
        assert!(said.contains(wanted), "{nodes}: {said:?} does not say {wanted:?}");
    }
}

#[test]
fn the_kinds_of_hosts_keep_the_contract() {
    assert_eq!(afterimage_plan::contract(afterimage_nodes::HOST), Ok(Vec::new()));
}
