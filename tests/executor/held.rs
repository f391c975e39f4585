//! Resources of an executor, as wgpu counts them: the textures of old plans and of those that failed are freed, and the
//! pipelines that draw into an image of the host are compiled with the plan.

use std::sync::Arc;

use afterimage_gpu::{Executor, Frame, Gpu, GpuError};
use afterimage_graph::check::Graph;
use afterimage_graph::node::NodeKind;
use afterimage_graph::prelude::*;
use afterimage_plan::{Alias, Plan};
use wgpu::{TextureFormat, TextureUsages};

use super::lively;
use crate::support::gpu::{Picture, Run, another_device, built_in, graph, graph_with};
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

params! {
    /// Multiplies with the texel of an image that is known with the plan.
    pub struct Tint {
        /// The factor of red.
        pub red: f32 = 2.0 => within(0.0..=8.0), replans();
    }
}

impl Node for Tint {
    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "Its product.").or_input("source")];

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
    let graphs = [None, Some("low")].map(|tier| built_in("tsushima.ron", tier));
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

/// The plan of a curve with this number, of which colors are in a table.
fn baked(player: &Player, white: f32, picture: &Picture) -> Arc<Plan> {
    let graph = graph(&format!(
        r#"Pipeline(inputs: {{ "scene": Exposed }}, nodes: {{
            "mapped": ToneMap(source: "scene", curve: ReinhardExtended, white_level: {white:?}, bake: 33),
            "shown": Encode(source: "mapped", format: Rgba32Float),
        }}, outputs: {{ "shown": "shown" }})"#
    ));
    let plan = Run::new(&graph).plan(&player.gpu, &[("scene", picture)]);
    assert_eq!(plan.baked.len(), 1);
    Arc::new(plan)
}

fn shown(player: &Player, executor: &mut Executor, picture: &Picture) -> Picture {
    let view = player.upload(picture);
    let mut encoder = player.gpu.device.create_command_encoder(&Default::default());
    executor.encode(&mut encoder, &Frame { inputs: &[("scene", &view)], ..Frame::default() }).expect("a frame");
    player.gpu.queue.submit([encoder.finish()]);
    player.read(executor.output("shown").expect("it keeps a texture"))
}

/// The same by an executor that shares nothing.
fn by_itself(player: &Player, white: f32, picture: &Picture) -> Picture {
    shown(player, &mut player.spare(baked(player, white, picture)), picture)
}

/// Two views of different sizes have one table. When a number in that of one of them changes, both show what they would
/// show alone; when one is left, it changes its table where it is, and nobody else gets that.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn views_share_a_table_until_a_number_in_it_changes() {
    let (instance, player) = alone(|_| {});
    let picture = |width, height| Picture::new(width, height, |x, y| [0.3 * x as f32, 0.1 * y as f32, 0.5, 1.0]);
    let (small, large) = (picture(40, 30), picture(64, 36));
    let [four, eight, two] =
        [(4.0, &small), (8.0, &large), (2.0, &large)].map(|(white, picture)| by_itself(&player, white, picture));
    let textures_of = |executor: &mut Executor, white: f32, picture: &Picture| {
        let before = held(&instance).0;
        executor.load(baked(&player, white, picture)).expect("it can be loaded");
        held(&instance).0 - before
    };
    let [mut left, mut right, mut third] = [0; 3].map(|_| player.executor.clone_for_view());
    let own = textures_of(&mut left, 4.0, &small);
    assert_eq!(textures_of(&mut right, 4.0, &large), own - 1, "the table is that of the other view");
    assert!(
        shown(&player, &mut right, &large) == by_itself(&player, 4.0, &large),
        "it is filled by who reads it first"
    );
    assert!(shown(&player, &mut left, &small) == four);

    right.load(baked(&player, 8.0, &large)).expect("it can be loaded");
    assert!(shown(&player, &mut right, &large) == eight && shown(&player, &mut left, &small) == four);
    assert!(!left.has_filled_tables(), "its table is as it was");

    assert_eq!(textures_of(&mut right, 2.0, &large), 0, "nobody else has the table of 8");
    assert_eq!(textures_of(&mut third, 8.0, &large), own, "which is none of 8 any more");
    assert!(shown(&player, &mut third, &large) == eight && shown(&player, &mut right, &large) == two);
    assert!(shown(&player, &mut third, &large) == eight && shown(&player, &mut left, &small) == four);
}
