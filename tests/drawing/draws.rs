//! Ranges of draws: those that are known, and those that kernels write.

use afterimage_graph::node::{
    BufferId, BufferLife, DrawContents, DrawRange, Draws, IndirectDraws, Load, PassKind, Recorder, Resource,
    VertexFormat,
};
use afterimage_graph::prelude::*;
use afterimage_plan::{Use, verify};

use super::kinds::{CLEARS, FORMATS, LARGE, OTHER, RESULT, SHADER, Vertex, buffer, desc};
use super::{CENTER, SIZE, assert_texels, at, drawn, graph, result};
use crate::support::gpu::{Picture, Run, gpu};
use crate::support::layer;

/// A triangle that no range names: drawn, it covers most of the picture.
const UNUSED: [Vertex; 3] = [
    ([-0.96875, -0.984375, 0.25], [9.0, 9.0, 9.0, 9.0]),
    ([0.984375, -0.96875, 0.25], [9.0, 9.0, 9.0, 9.0]),
    ([0.015625, 0.984375, 0.25], [9.0, 9.0, 9.0, 9.0]),
];
/// The offset of each instance, and the factor of its color. No range has the first.
const MOVES: [[f32; 4]; 4] =
    [[0.0, 0.0, 0.0, 7.0], [-0.25, 0.125, 0.0, 0.5], [0.5, -0.25, 0.0, 2.0], [0.125, 0.375, 0.0, 0.25]];

fn moves(pass: &mut Recorder<'_>) -> BufferId {
    let bytes: Vec<u8> = MOVES.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
    pass.constant_buffer("moves", bytes)
}

fn words(pass: &mut Recorder<'_>, name: &str, words: &[u32]) -> BufferId {
    pass.constant_buffer(name, words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>())
}

/// Triangles, and by which of [`MOVES`] each is moved, in the order of drawing.
fn painted(pixel: (u32, u32), drawn: &[([Vertex; 3], usize)]) -> [f64; 4] {
    drawn.iter().fold(CLEARS[0], |below, (triangle, instance)| {
        let [x, y, z, light] = MOVES[*instance];
        let moved = triangle
            .map(|(place, color)| ([place[0] + x, place[1] + y, place[2] + z], color.map(|channel| channel * light)));
        at(&moved, SIZE, pixel, CENTER).map_or(below, |(color, _)| color)
    })
}

node_kind! {
    /// Some of the triangles of a buffer, in several ranges.
    pub struct Pieces {
        /// True if by indices.
        pub indexed: bool = false;
    }

    const OUTPUTS: &'static [Output] = RESULT;
}

/// The vertices of each.
fn triangles(pass: &mut Recorder<'_>) -> BufferId {
    buffer(pass, &[UNUSED, OTHER, LARGE].concat())
}

/// Numbers of the vertices of the second triangle, which a base vertex moves to others.
const INDICES: [u32; 9] = [0, 1, 2, 4, 5, 3, 8, 7, 6];
/// By them, the second triangle, the third twice, and the second by the numbers of the third.
const INDEXED: [DrawRange; 3] = [
    DrawRange { first: 3, first_instance: 1, ..DrawRange::new(3, 1) },
    DrawRange { first: 3, base_vertex: 3, first_instance: 2, ..DrawRange::new(3, 2) },
    DrawRange { first: 6, base_vertex: -3, first_instance: 3, ..DrawRange::new(3, 1) },
];
const INDEXED_SHOWS: [([Vertex; 3], usize); 4] = [(OTHER, 1), (LARGE, 2), (LARGE, 3), (OTHER, 3)];
/// The third triangle, and the second twice.
const PLAIN: [DrawRange; 2] = [
    DrawRange { first: 6, first_instance: 1, ..DrawRange::new(3, 1) },
    DrawRange { first: 3, first_instance: 2, ..DrawRange::new(3, 2) },
];
const PLAIN_SHOWS: [([Vertex; 3], usize); 3] = [(LARGE, 1), (OTHER, 2), (OTHER, 3)];

impl Node for Pieces {
    fn record(&self, pass: &mut Recorder<'_>) {
        let (vertices, moves) = (triangles(pass), moves(pass));
        let indices = words(pass, "indices", &INDICES);
        let color = pass.output("result", desc(pass));
        let draw = pass.draw(&SHADER, "shifted").fragment("colored").color(color, Load::Clear(CLEARS[0]));
        let draw = draw.vertices(vertices, &FORMATS).instances(moves, &[VertexFormat::Float32x4]);
        match self.indexed {
            true => draw.indices(indices).record_ranges(INDEXED),
            false => draw.record_ranges(PLAIN),
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn ranges_are_drawn_one_after_the_other() {
    assert_texels(&result("Pieces()"), SIZE, |pixel| painted(pixel, &PLAIN_SHOWS));
    assert_texels(&result("Pieces(indexed: true)"), SIZE, |pixel| painted(pixel, &INDEXED_SHOWS));
}

choices! {
    /// The arguments of a draw, written by a kernel.
    pub enum Case {
        /// As many triangles as frames were before.
        Growing,
        /// Numbers that are not in the buffers.
        Hostile,
    }
}

node_kind! {
    /// Triangles that a kernel chooses in each frame.
    pub struct Chosen {
        /// The arguments that it writes.
        pub case: Case = Case::Growing;
        /// True if by indices.
        pub indexed: bool = false;
        /// True if the first instance is another one than the first of the buffer.
        pub later: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "What is drawn.").or(Fallback::Absent),
        Output::image("other", OutputState::Always(ColorState::Data), "Another one.").or(Fallback::Absent),
    ];
}

/// A kernel that writes two ranges behind a word of something else. Of the ranges, frame 0 has none, frame 1 the first,
/// and later frames both.
static CHOOSE: Shader = Shader::new(
    "draw_choose.wgsl",
    "struct Choice { is_indexed: f32, first_instance: f32, is_hostile: f32 }
@group(0) @binding(0) var<uniform> params: Choice;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read_write> ranges: array<u32>;
@compute @workgroup_size(2)
fn choose(@builtin(local_invocation_index) range: u32) {
    let instances = select(0u, 1u + range, frame.index > range);
    let first_instance = u32(params.first_instance);
    let first = select(6u - 3u * range, 3u, params.is_indexed > 0.0);
    let count = select(3u, 0xfffffff0u, params.is_hostile > 0.0);
    ranges[0] = 0xffffffffu;
    if params.is_indexed > 0.0 {
        let base = 1u + 5u * range;
        ranges[base] = count;
        ranges[base + 1u] = instances;
        ranges[base + 2u] = first;
        ranges[base + 3u] = 3u - 3u * range;
        ranges[base + 4u] = first_instance;
    } else {
        let base = 1u + 4u * range;
        ranges[base] = count;
        ranges[base + 1u] = instances;
        ranges[base + 2u] = first;
        ranges[base + 3u] = first_instance;
    }
}",
);

impl Node for Chosen {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        let other = pass.output("other", desc);
        pass.clear("other").color(other, Load::Clear(CLEARS[3])).record();
        let ranges = pass.add_buffer("ranges", 44, BufferLife::Frame);
        let number = |is: bool| if is { 1.0_f32 } else { 0.0 };
        let choose = pass.compute(&CHOOSE, "choose").buffer("ranges", ranges);
        let choose = choose.set("is_indexed", number(self.indexed)).set("first_instance", number(self.later));
        choose.set("is_hostile", number(self.case == Case::Hostile)).dispatch([1, 1, 1]);
        let (vertices, moves) = (triangles(pass), moves(pass));
        let indices = words(pass, "indices", &INDICES);
        let color = pass.output("result", desc);
        let draw = pass.draw(&SHADER, "shifted").fragment("colored").color(color, Load::Clear(CLEARS[0]));
        let draw = draw.vertices(vertices, &FORMATS).instances(moves, &[VertexFormat::Float32x4]);
        let draw = if self.indexed { draw.indices(indices) } else { draw };
        draw.record_indirect(IndirectDraws { buffer: ranges, offset: 4, ranges: 2 });
    }
}

/// Frames whose counts a kernel has written, after the layer has found nothing.
fn frames(node: &str, count: usize) -> Vec<Picture> {
    let _alone = layer::alone();
    let graph = graph(&format!("\"result\": {node}"), "result");
    let mut run = Run::new(&graph).exact();
    run.size = SIZE;
    verify(&run.plan(&gpu(), &[])).unwrap_or_else(|faults| panic!("{faults:?}"));
    layer::messages();
    let frames: Vec<(f32, bool)> = (0..count).map(|frame| (0.1, frame == 0)).collect();
    let mut found = run.frames(&[], &frames);
    assert_eq!(layer::messages(), Vec::<String>::new(), "{node}");
    found.iter_mut().map(|outputs| outputs.remove(0)).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_kernel_chooses_what_a_later_pass_draws_in_each_frame() {
    let later_instances = gpu().caps.indirect_first_instance;
    for indexed in [false, true] {
        for later in [false, true].into_iter().filter(|later| !later || later_instances) {
            let found = frames(&format!("Chosen(indexed: {indexed}, later: {later})"), 4);
            let first = usize::from(later);
            let [near, far] = [(LARGE, first), (OTHER, first)];
            let shows: [&[_]; 4] = [&[], &[near], &[near, far, (OTHER, first + 1)], &[near, far, (OTHER, first + 1)]];
            for (picture, shown) in found.iter().zip(shows) {
                assert_texels(picture, SIZE, |pixel| painted(pixel, shown));
            }
        }
    }
}

/// wgpu looks at the numbers before the draw, as the devices that we open ask it to.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn ranges_beyond_the_buffers_draw_nothing() {
    for indexed in [false, true] {
        for picture in frames(&format!("Chosen(case: Hostile, indexed: {indexed})"), 3) {
            assert_texels(&picture, SIZE, |_| CLEARS[0]);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_kernel_runs_only_where_its_ranges_are_drawn() {
    let labels = |output: &str| {
        let graph = graph("\"result\": Chosen()", output);
        let mut run = Run::new(&graph);
        run.size = SIZE;
        let plan = run.plan(&gpu(), &[]);
        plan.work().map(|pass| pass.label.clone()).filter(|label| label != "copy").collect::<Vec<_>>()
    };
    assert_eq!(labels("result"), ["choose", "shifted"]);
    assert_eq!(labels("result.other"), ["other"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn verify_finds_what_is_wrong_with_ranges_in_a_buffer() {
    let plan = drawn("\"result\": Pieces()", "result").0;
    assert_eq!(verify(&plan), Ok(()));
    let graph = graph("\"result\": Chosen()", "result");
    let mut run = Run::new(&graph);
    run.size = SIZE;
    let plan = run.plan(&gpu(), &[]);
    let draws = |change: fn(&mut IndirectDraws)| {
        let mut plan = plan.clone();
        let pass = plan.passes.iter_mut().find(|planned| planned.pass.label == "shifted").expect("it is drawn");
        let PassKind::Drawing(drawing) = &mut pass.pass.kind else { panic!("it is drawn") };
        let DrawContents::Geometry(geometry) = &mut drawing.contents else { panic!("it has geometry") };
        let Draws::Indirect(ranges) = &mut geometry.draws else { panic!("its ranges are in a buffer") };
        change(ranges);
        plan
    };
    let mut unordered = plan.clone();
    let ranges = unordered.buffers.iter().position(|buffer| buffer.label == "result.ranges").expect("it is there");
    let is_ranges = |resource| resource == Resource::Buffer(BufferId(ranges as u32));
    for batch in &mut unordered.batches {
        batch.transitions.retain(|transition| !(is_ranges(transition.resource) && transition.to == Use::Read));
    }
    let mut unwritten = plan.clone();
    let choose = unwritten.passes.iter_mut().find(|planned| planned.pass.label == "choose").expect("it is there");
    choose.pass.kernels[0].args.clear();
    let cases = [
        (unwritten, "pass `result: shifted` reads `result.ranges` before any pass has written it"),
        (draws(|ranges| ranges.offset = 2), "reads 2 ranges from byte 2 of `result.ranges`, which has 44"),
        (draws(|ranges| ranges.offset = 16), "reads 2 ranges from byte 16 of `result.ranges`, which has 44"),
        (draws(|ranges| ranges.ranges = 3), "reads 3 ranges from byte 4 of `result.ranges`, which has 44"),
        (unordered, "uses `result.ranges` as Read, but no barrier orders that after StorageReadWrite"),
    ];
    for (plan, wanted) in cases {
        let faults = verify(&plan).expect_err(wanted);
        assert!(faults.iter().any(|fault| fault.to_string().contains(wanted)), "{faults:?} is not {wanted:?}");
    }
}
