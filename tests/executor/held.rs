//! Resources of an executor, as wgpu counts them: the textures of old plans and of those that failed are freed, and the
//! pipelines that draw into an image of the host are compiled with the plan.

use std::sync::Arc;

use afterimage_gpu::{Frame, Gpu, GpuError};
use afterimage_graph::check::Graph;
use afterimage_graph::node::NodeKind;
use afterimage_graph::prelude::*;
use afterimage_plan::Alias;
use wgpu::{TextureFormat, TextureUsages};

use super::lively;
use crate::support::gpu::{Run, another_device, built_in, graph_with};
use crate::support::player::Player;

/// A player on a device of an instance that no other test uses, which may have lower limits than its adapter.
fn alone(lower: impl FnOnce(&mut wgpu::Limits)) -> (wgpu::Instance, Player) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let wanted = std::env::var("AFTERIMAGE_ADAPTER").ok();
    let opened = pollster::block_on(Gpu::open_on(&instance, wanted.as_deref()));
    let gpu = opened.unwrap_or_else(|error| panic!("{error}"));
    let mut limits = gpu.device.limits();
    lower(&mut limits);
    (instance, Player::on(another_device(&gpu, gpu.device.features(), limits)))
}

/// The numbers of textures and render pipelines.
fn held(instance: &wgpu::Instance) -> (usize, usize) {
    let report = instance.generate_report().expect("the instance is wgpu's own");
    let hub = report.hub_report();
    (hub.textures.num_allocated, hub.render_pipelines.num_allocated)
}

static TINT: Shader = Shader::new(
    "tint.wgsl",
    "fn tint(source: vec4f, texels: texture_2d<f32>) -> vec4f { return source * texel(texels, vec2i(0)); }",
);

node_kind! {
    /// Multiplies with the texel of an image that is known with the plan.
    pub struct Tint {
        /// The factor of red.
        pub red: f32 = 2.0 => within(0.0..=8.0), replans();
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "Its product.").or_input("source")];
}

impl Node for Tint {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let bytes: Vec<_> = [self.red, 3.0, 4.0, 1.0].iter().flat_map(|number| number.to_le_bytes()).collect();
        let texels = pass.constant("texels", ImageDesc::new(Size::new(1, 1)).format(Format::Rgba32Float), bytes);
        pass.function(&TINT, "tint").read("texels", texels).write("result", desc);
    }
}

/// A blur, whose image between its two passes is of the plan, and two constant images.
fn tinted_blur() -> Graph {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "wide": Gaussian(source: "scene", sigma: 5.0),
            "once": Tint(source: "wide"),
            "tinted": Tint(source: "once", red: 5.0),
        },
        outputs: { "tinted": "tinted" },
    )"#;
    graph_with(text, &[NodeKind::of::<Tint>()])
}

/// A device that takes 64 pixels in a row.
fn narrow() -> (wgpu::Instance, Player) {
    alone(|limits| limits.max_texture_dimension_2d = 64)
}

fn pooled(graph: &Graph) -> Run<'_> {
    let mut run = Run::new(graph);
    run.options.alias = Alias::Pool;
    run
}

/// Loads a plan that a narrow device refuses.
fn fail(player: &mut Player, run: &Run<'_>) {
    let plan = Arc::new(run.plan(&player.gpu, &[("scene", &lively(96, 54))]));
    let error = player.executor.load(plan).expect_err("an image has 96 pixels in a row");
    assert!(matches!(error, GpuError::Refused { .. }), "{error}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn constant_images_of_a_plan_that_failed_are_made_again() {
    let (_instance, mut player) = narrow();
    let graph = tinted_blur();
    let run = pooled(&graph);
    fail(&mut player, &run);
    let scene = super::flat(32, 18, 0.5);
    player.load(&run, &[("scene", &scene)]);
    player.frame(&[("scene", &scene)], 0.0, true);
    let found = player.output("tinted").at(7, 3);
    for (found, wanted) in found.into_iter().zip([5.0, 4.5, 8.0, 1.0]) {
        assert!((found - wanted).abs() < 1e-2, "{found} is not {wanted}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_textures_of_old_plans_are_freed() {
    let (instance, mut player) = alone(|_| ());
    let scene = lively(160, 90);
    let graphs = [None, Some("low")].map(|tier| built_in("lynx.ron", tier));
    for alias in [Alias::Placed, Alias::Pool] {
        let mut round = || {
            for graph in &graphs {
                let mut run = Run::new(graph);
                run.options.alias = alias;
                player.load(&run, &[("scene", &scene)]);
                player.frame(&[("scene", &scene)], 0.0, false);
            }
            held(&instance).0
        };
        let counts = [(); 4].map(|()| round());
        assert_eq!([counts[2], counts[3]], [counts[1]; 2], "{alias:?}: {counts:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_textures_of_a_plan_that_failed_are_freed() {
    let (instance, mut player) = narrow();
    let graph = tinted_blur();
    let run = pooled(&graph);
    let small = lively(32, 18);
    player.load(&run, &[("scene", &small)]);
    player.frame(&[("scene", &small)], 0.0, true);
    let textures = held(&instance).0;
    assert!(textures > 0, "wgpu counts textures");
    for _ in 0..3 {
        fail(&mut player, &run);
        assert_eq!(held(&instance).0, textures);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pipelines_that_draw_for_the_host_are_compiled_with_the_next_plan() {
    let (instance, mut player) = alone(|_| ());
    let scene = lively(64, 36);
    let input = player.upload(&scene);
    let image = player.gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width: 64, height: 36, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Bgra8Unorm,
        usage: TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = image.create_view(&Default::default());
    let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", &view)], ..Frame::default() };
    let mut drawn = Vec::new();
    for name in ["lynx.ron", "tsushima.ron"] {
        player.load(&Run::new(&built_in(name, None)), &[("scene", &scene)]);
        let loaded = held(&instance).1;
        player.run(&frame).unwrap_or_else(|error| panic!("{name}: {error}"));
        drawn.push((loaded, held(&instance).1));
    }
    let [(first_loaded, first_run), (second_loaded, second_run)] = drawn[..] else { panic!("two plans") };
    assert_eq!((first_loaded, first_run), (0, 1), "nothing is known of the host's image before the first frame");
    assert_eq!((second_loaded, second_run), (2, 2), "the other plan is compiled for the image of the frame before");
}
