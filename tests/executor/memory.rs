//! Buffers that outlive frames: where they begin, and that they go on through a change of plan.

use afterimage::host::PostError;
use afterimage_gpu::{Frame, FrameKind, FrameStep, GpuError, InputImage};
use afterimage_graph::check::Graph;
use afterimage_graph::node::NodeKind;
use afterimage_graph::prelude::*;

use super::{flat, without_features};
use crate::support::gpu::{Picture, Run, graph_with};
use crate::support::player::Player;

static COUNT: Shader = Shader::new(
    "count",
    "@group(0) @binding(0) var result: texture_storage_2d<rgba16float, write>;
    @group(0) @binding(1) var<uniform> frame: Frame;
    @group(0) @binding(2) var<storage, read_write> counted: array<f32>;
    @group(0) @binding(3) var<storage, read> shown: array<f32>;
    @compute @workgroup_size(1)
    fn count_step() {
        counted[0] = counted[0] + 1.0;
        counted[1] = select(counted[1], 10.0, frame.reset != 0u) + 1.0;
    }
    @compute @workgroup_size(1)
    fn count_show(@builtin(global_invocation_id) id: vec3u) {
        textureStore(result, id.xy, vec4f(shown[0], shown[1], 0.0, 1.0));
    }",
);

node_kind! {
    /// Counts frames: in red those since its memory was zero, in green those since a reset, from 10 on.
    pub struct Count {
        /// Its memory is larger by this many times 16 bytes.
        pub more: i32 = 0 => within(0.0..=8.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image, for the size.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The counts.").or_input("source")];
}

impl Node for Count {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let counted = pass.add_buffer("counted", 16 * (1 + self.more as u64), BufferLife::Persistent);
        let result = pass.output("result", desc);
        pass.compute(&COUNT, "count_step").buffer("counted", counted).dispatch([1, 1, 1]);
        let groups = [desc.size.width, desc.size.height, 1];
        pass.compute(&COUNT, "count_show").image("result", result).buffer("shown", counted).dispatch(groups);
    }
}

fn graph(counters: &[&str]) -> Graph {
    let nodes: String = counters.iter().map(|name| format!("\"{name}\": Count(source: \"scene\"), ")).collect();
    let outputs: String = counters.iter().map(|name| format!("\"{name}\": \"{name}\", ")).collect();
    graph_of(&nodes, &outputs)
}

fn graph_of(nodes: &str, outputs: &str) -> Graph {
    let text = format!("Pipeline(inputs: {{\"scene\": Color}}, nodes: {{{nodes}}}, outputs: {{{outputs}}})");
    graph_with(&text, &[NodeKind::of::<Count>(), NodeKind::of::<Mark>(), NodeKind::of::<Table>()])
}

/// The value of a counter after one more frame.
fn step(player: &mut Player, reset: bool, counter: &str) -> [f32; 2] {
    player.frame(&[("scene", &flat(4, 2, 1.0))], 0.1, reset);
    counts(player, counter)
}

fn counts(player: &Player, counter: &str) -> [f32; 2] {
    let [red, green, ..] = player.output(counter).at(3, 1);
    [red, green]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_is_zero_in_a_first_frame_and_after_a_reset() {
    let mut player = Player::new();
    player.load(&Run::new(&graph(&["a"])), &[("scene", &flat(4, 2, 1.0))]);
    let shown = [false, false, false, true, false].map(|reset| step(&mut player, reset, "a"));
    assert_eq!(shown, [[1.0, 11.0], [2.0, 12.0], [3.0, 13.0], [1.0, 11.0], [2.0, 12.0]]);
    player.executor.reset();
    assert_eq!(step(&mut player, false, "a"), [1.0, 11.0]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_that_begins_with_a_plan_begins_as_in_a_first_frame_and_the_other_goes_on() {
    let mut player = Player::new();
    let scene = flat(4, 2, 1.0);
    player.load(&Run::new(&graph(&["a"])), &[("scene", &scene)]);
    assert_eq!([(); 2].map(|()| step(&mut player, false, "a")), [[1.0, 11.0], [2.0, 12.0]]);
    player.load(&Run::new(&graph(&["a", "b"])), &[("scene", &scene)]);
    assert_eq!(step(&mut player, false, "a"), [3.0, 13.0]);
    assert_eq!(counts(&player, "b"), [1.0, 11.0], "the new memory begins with this frame");
    assert_eq!(step(&mut player, false, "b"), [2.0, 12.0], "and only with this one");
}

/// A plan is prepared for the memory of the plan that runs then. If another one has run since, it takes that one's.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_does_not_come_in_on_memory_that_another_has_left() {
    let mut player = Player::new();
    let scene = flat(4, 2, 1.0);
    player.load(&Run::new(&graph(&["a"])), &[("scene", &scene)]);
    assert_eq!([(); 2].map(|()| step(&mut player, false, "a")), [[1.0, 11.0], [2.0, 12.0]]);
    let later = Run::new(&graph(&["a", "b"])).plan(&player.gpu, &[("scene", &scene)]);
    let preparation = player.executor.prepare(later.into());
    while !preparation.is_ready() {
        std::thread::yield_now();
    }
    player.load(&Run::new(&graph(&["b"])), &[("scene", &scene)]);
    assert_eq!(step(&mut player, false, "b"), [1.0, 11.0]);
    player.executor.swap(preparation).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(step(&mut player, false, "b"), [2.0, 12.0], "it goes on");
    assert_eq!(counts(&player, "a"), [1.0, 11.0], "the plan between had no such memory");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_begins_again_after_a_frame_that_the_queue_refuses() {
    let player = Player::new();
    let nodes = "\"a\": Count(source: \"scene\"), \"soft\": Gaussian(source: \"scene\", sigma: 1.0)";
    let graph = graph_of(nodes, "\"a\": \"a\", \"soft\": \"soft\"");
    let mut session = Run::new(&graph).session(&player.gpu);
    let desc = ImageDesc::new(Size::new(4, 2)).format(Format::Rgba32Float);
    let [lasting, destroyed] = [(); 2].map(|()| player.upload(&flat(4, 2, 1.0)));
    let mut frame = |view: &wgpu::TextureView| {
        let images = [InputImage { input: "scene".into(), view: view.clone(), desc, finite: false }];
        session.render(desc.size, &images, FrameStep { time: 0.0, dt: 0.1, kind: FrameKind::Next })?;
        let [red, green, ..] = Picture::of(&session.output("a")?).at(3, 1);
        Ok::<_, PostError>([red, green])
    };
    assert_eq!(frame(&lasting).unwrap(), [1.0, 11.0]);
    assert_eq!(frame(&destroyed).unwrap(), [2.0, 12.0]);
    destroyed.texture().destroy();
    let error = frame(&destroyed).expect_err("a blur reads the texture");
    assert!(
        matches!(&error, PostError::Gpu(GpuError::Refused { what, .. }) if what == "the commands of a frame"),
        "{error}"
    );
    assert_eq!(frame(&lasting).unwrap(), [1.0, 11.0]);
    assert_eq!(frame(&lasting).unwrap(), [2.0, 12.0]);
}

static MARK: Shader = Shader::new(
    "mark",
    "fn mark(source: vec4f, frame: Frame) -> vec4f { return vec4f(source.r, f32(frame.reset), source.g, 1.0); }",
);

node_kind! {
    /// Red stays, green is 1 in a pass that resets, and blue is what the green of the source was.
    pub struct Mark {}

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The marks.").or_input("source")];
}

impl Node for Mark {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&MARK, "mark").write("result", desc);
    }
}

/// The pass that writes the image of a history and the one that reads its past begin with the plan, each by itself; a
/// pass of before goes on.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn passes_of_a_history_that_begins_with_a_plan_are_told_of_it() {
    told_once(Player::new());
    // There the numbers of the frame are in a buffer.
    told_once(Player::on(without_features()));
}

fn told_once(mut player: Player) {
    let scene = flat(4, 2, 1.0);
    let load = |player: &mut Player, more: &str, outputs: &str| {
        let nodes = format!("\"a\": Mark(source: \"scene\"), {more}");
        player.load(&Run::new(&graph_of(&nodes, &format!("\"a\": \"a\", {outputs}"))), &[("scene", &scene)]);
    };
    let shown = |player: &Player, name: &str| {
        let [red, green, blue, _] = player.output(name).at(3, 1);
        [red, green, blue]
    };
    load(&mut player, "", "");
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(shown(&player, "a"), [1.0, 1.0, 1.0]);
    load(&mut player, "\"b\": Mark(source: \"scene\"), \"p\": Mark(source: \"b@previous\")", "\"p\": \"p\"");
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(shown(&player, "a")[1], 0.0, "it was there before");
    assert_eq!(shown(&player, "p"), [0.0, 1.0, 0.0], "a past that begins is black, and its reader begins");
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(shown(&player, "p"), [1.0, 0.0, 1.0], "the pass that wrote it began, too, and both only once");
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(shown(&player, "p"), [1.0, 0.0, 0.0]);
}

/// A buffer of another size is another buffer: its numbers begin again.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_of_another_size_begins_as_in_a_first_frame() {
    let mut player = Player::new();
    let scene = flat(4, 2, 1.0);
    let mut before = None;
    for more in [0, 1, 0, 0] {
        let nodes = format!("\"a\": Count(source: \"scene\", more: {more})");
        player.load(&Run::new(&graph_of(&nodes, "\"a\": \"a\"")), &[("scene", &scene)]);
        let begin = if before == Some(more) { 2.0 } else { 0.0 };
        let counted = [(); 2].map(|()| step(&mut player, false, "a")[0]);
        assert_eq!(counted, [begin + 1.0, begin + 2.0], "{more} after {before:?}");
        before = Some(more);
    }
}

static TABLE: Shader = Shader::new(
    "table",
    "@group(0) @binding(0) var result: texture_storage_2d<rgba16float, write>;
    @group(0) @binding(1) var<storage, read> table: array<f32>;
    @compute @workgroup_size(1)
    fn table_show(@builtin(global_invocation_id) id: vec3u) {
        textureStore(result, id.xy, vec4f(table[0], table[1], table[2], table[3]));
    }",
);

node_kind! {
    /// Shows four numbers of a buffer that is computed with the plan.
    pub struct Table {
        /// The first of them.
        pub first: f32 = 0.25 => within(0.0..=8.0), replans();
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image, for the size.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The numbers.").or_input("source")];
}

impl Node for Table {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let numbers = [self.first, 0.5, 2.0, 1.0];
        let table =
            pass.constant_buffer("numbers", numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>());
        let result = pass.output("result", desc);
        let groups = [desc.size.width, desc.size.height, 1];
        pass.compute(&TABLE, "table_show").image("result", result).buffer("table", table).dispatch(groups);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_buffer_that_is_computed_with_the_plan_holds_its_numbers_in_every_frame() {
    let mut player = Player::new();
    let scene = flat(4, 2, 1.0);
    for first in [0.25, 4.0] {
        let nodes = format!("\"a\": Table(source: \"scene\", first: {first:?})");
        player.load(&Run::new(&graph_of(&nodes, "\"a\": \"a\"")), &[("scene", &scene)]);
        for reset in [true, false, true] {
            player.frame(&[("scene", &scene)], 0.1, reset);
            assert_eq!(player.output("a").at(3, 1), [first, 0.5, 2.0, 1.0]);
        }
    }
}

/// Textures of the old plan that hold light are left over, and have the size and format of the history.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_begins_black_where_an_old_plan_has_left_textures() {
    let mut player = Player::new();
    let scene = flat(4, 2, 1.0);
    let names = ["s", "t", "u", "v", "w"];
    let nodes: String = names.iter().map(|name| format!("\"{name}\": Mark(source: \"scene\"), ")).collect();
    let outputs: String = names.iter().map(|name| format!("\"{name}\": \"{name}\", ")).collect();
    player.load(&Run::new(&graph_of(&nodes, &outputs)), &[("scene", &scene)]);
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(names.map(|name| player.output(name).at(3, 1)[0]), [1.0; 5]);
    let nodes = "\"b\": Mark(source: \"scene\"), \"p\": Mark(source: \"b@previous\")";
    player.load(&Run::new(&graph_of(nodes, "\"p\": \"p\"")), &[("scene", &scene)]);
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(player.output("p").at(3, 1)[0], 0.0);
    player.frame(&[("scene", &scene)], 0.1, false);
    assert_eq!(player.output("p").at(3, 1)[0], 1.0);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_draw_into_the_host_s_image_has_the_numbers_of_its_frame() {
    let mut player = Player::new();
    let scene = flat(4, 2, 1.0);
    player.load(&Run::new(&graph_of("\"a\": Mark(source: \"scene\")", "\"a\": \"a\"")), &[("scene", &scene)]);
    let input = player.upload(&scene);
    let image = player.gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width: 4, height: 2, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = image.create_view(&Default::default());
    let (inputs, outputs) = (&[("scene", &input)], &[("a", &view)]);
    let shown = [false, false, true, false].map(|reset| {
        player
            .run(&Frame { inputs, outputs, kind: FrameKind::cut_if(reset), ..Frame::default() })
            .unwrap_or_else(|error| panic!("{error}"));
        player.read(&image).at(3, 1)[1]
    });
    assert_eq!(shown, [1.0, 0.0, 1.0, 0.0], "green is 1 in a frame that resets");
}
