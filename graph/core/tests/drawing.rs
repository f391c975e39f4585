//! Drawing passes that no device, or not every device, can run: what is said of them.

mod draws;

use std::panic::{AssertUnwindSafe, catch_unwind};

use afterimage_graph::caps::Caps;
use afterimage_graph::node::{
    BufferLife, Compare, Cull, DepthTest, DrawPass, ImageId, Load, NodeColors, OutputUse, Raster, RecorderContext,
    Recording, Topology, UniformValues, VertexFormat, contract,
};
use afterimage_graph::node_kind;
use afterimage_graph::prelude::*;

const TEXT: &str = "
@group(0) @binding(0) var seen: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;
struct Corner { @builtin(position) place: vec4f, @location(0) tint: vec3f, @location(1) @interpolate(flat) part: u32 }
@vertex fn corner(@location(0) place: vec3f, @location(1) part: u32) -> Corner {
    return Corner(vec4f(place, 1.0), place, part);
}
@vertex fn alone(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f { return vec4f(f32(index)); }
@fragment fn tint(@location(0) tint: vec3f) -> @location(0) vec4f { return vec4f(tint, 1.0); }
@fragment fn plain() -> @location(0) vec4f { return vec4f(1.0); }
@fragment fn narrow() -> @location(0) vec2f { return vec2f(1.0); }
@fragment fn see() -> @location(0) vec4f { return textureLoad(seen, vec2i(), 0); }
@fragment fn count() -> @location(0) vec4f { counts[0] = 1u; return vec4f(1.0); }
struct Pair { @location(0) first: vec4f, @location(1) second: vec4f }
@fragment fn pair() -> Pair { return Pair(vec4f(1.0), vec4f(2.0)); }
";
static SHADER: Shader = Shader::new("canvas.wgsl", TEXT);

node_kind! {
    /// Something to record for.
    pub struct Canvas {}

    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "What is drawn.").or(Fallback::Absent)];
}

impl Node for Canvas {
    fn record(&self, pass: &mut Recorder<'_>) {
        let result = pass.output("result", ImageDesc::new(Size::new(4, 4)));
        pass.clear("clear").color(result, Load::Clear([0.0; 4])).record();
    }
}

const CLEAR: Load<[f64; 4]> = Load::Clear([0.0; 4]);

/// What recording these passes fails with; empty if it does not.
fn said(describe: impl FnOnce(&mut Recorder<'_>)) -> String {
    recorded(describe).err().unwrap_or_default()
}

/// These passes, or what recording them fails with.
fn recorded(describe: impl FnOnce(&mut Recorder<'_>)) -> Result<Recording, String> {
    let kind = NodeKind::of::<Canvas>();
    let (caps, mut recording) = (Caps::default(), Recording::default());
    let context = RecorderContext {
        node: "canvas",
        kind: kind.signature(),
        parameters: UniformValues::default(),
        dynamic: &[],
        inputs: &[],
        format: None,
        frame_size: Size::new(64, 32),
        caps: &caps,
        exact: false,
        used_outputs: &[OutputUse::Whole],
        colors: NodeColors::default(),
    };
    let mut recorder = Recorder::new(context, &mut recording);
    match catch_unwind(AssertUnwindSafe(|| describe(&mut recorder))) {
        Ok(()) => Ok(recording),
        Err(panic) => Err(panic.downcast_ref::<String>().cloned().unwrap_or_else(|| "no message".into())),
    }
}

fn desc() -> ImageDesc {
    ImageDesc::new(Size::new(64, 32))
}

fn image(pass: &mut Recorder<'_>, name: &str, desc: ImageDesc) -> ImageId {
    pass.transient(name, desc)
}

fn depth(pass: &mut Recorder<'_>) -> ImageId {
    image(pass, "depth", desc().format(Format::Depth32Float))
}

/// A draw of three vertices into an image of that description.
fn draw<'r, 'a>(pass: &'r mut Recorder<'a>, desc: ImageDesc) -> DrawPass<'r, 'a> {
    let color = image(pass, "color", desc);
    pass.draw(&SHADER, "alone").fragment("plain").color(color, CLEAR)
}

#[test]
fn a_drawing_pass_that_fits_is_recorded() {
    assert_eq!(said(|pass| draw(pass, desc()).record(3, 1)), "");
    assert_eq!(contract(&[NodeKind::of::<Canvas>()]), Ok(Vec::new()));
    let all = |pass: &mut Recorder<'_>| {
        let depth = depth(pass);
        let vertices = pass.add_buffer("vertices", 3 * 16, BufferLife::Frame);
        let color = image(pass, "color", desc());
        let raster = Raster { cull: Cull::Back, bias: 2, slope_bias: 1.5, ..Raster::default() };
        let draw = pass.draw(&SHADER, "corner").fragment("tint").color(color, CLEAR);
        let formats = [VertexFormat::Float32x3, VertexFormat::Uint32];
        draw.depth(depth, DepthTest::default()).vertices(vertices, &formats).raster(raster).record(3, 1);
        let kept = DepthTest { load: Load::Keep, compare: Compare::Equal, write: false };
        pass.draw(&SHADER, "alone").fragment("plain").color(color, Load::Keep).depth(depth, kept).record(3, 7);
    };
    assert_eq!(said(all), "");
}

#[test]
fn attachments_that_do_not_fit_are_refused_with_their_names() {
    let cases: Vec<(String, &str)> = vec![
        (said(|pass| pass.draw(&SHADER, "alone").record(3, 1)), "draws into nothing: add an attachment"),
        (
            said(|pass| {
                let (color, small) = (image(pass, "color", desc()), image(pass, "small", desc().half()));
                pass.clear("both").color(color, CLEAR).color(small, CLEAR).record();
            }),
            "draws into `canvas.color` and `canvas.small`, which have 64x32 and 32x16 texels",
        ),
        (
            said(|pass| {
                let depth = depth(pass);
                draw(pass, desc().multisampled(4)).depth(depth, DepthTest::default()).record(3, 1);
            }),
            "draws into `canvas.color` and `canvas.depth`, which have 4 and 1 samples",
        ),
        (
            said(|pass| draw(pass, desc().multisampled(2)).record(3, 1)),
            "draws 2 samples into `canvas.color`: every device draws 1 or 4",
        ),
        (
            said(|pass| draw(pass, desc().multisampled(4).with_levels(3)).record(3, 1)),
            "draws into `canvas.color`: its image has 4 samples, 3 levels and 1 layer, but an image with samples has \
             one level and one layer",
        ),
        (
            said(|pass| draw(pass, desc().multisampled(4).format(Format::Rgba32Float)).record(3, 1)),
            "draws samples of the format `Rgba32Float` into `canvas.color`, which no device has to have",
        ),
        (
            said(|pass| draw(pass, desc().format(Format::Depth16Unorm)).record(3, 1)),
            "draws color into `canvas.color`, whose format `Depth16Unorm` holds a depth",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc().format(Format::R32Float));
                pass.draw(&SHADER, "alone").depth(color, DepthTest::default()).record(3, 1);
            }),
            "draws depth into `canvas.color`, whose format `R32Float` holds none: use `Depth32Float` or `Depth16Unorm`",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc().with_levels(2).with_layers(3));
                pass.clear("far").color(color.level(2).layer(1), CLEAR).record();
            }),
            "draws into level 2 of layer 1 of `canvas.color`: its image has 1 sample, 2 levels and 3 layers",
        ),
        (
            said(|pass| draw(pass, desc().with_levels(8)).record(3, 1)),
            "draws into `canvas.color`, which has 8 levels, but 64x32 has at most 7",
        ),
        (
            said(|pass| draw(pass, ImageDesc::volume(Size::volume(4, 4, 4))).record(3, 1)),
            "draws into the volume `canvas.color`",
        ),
        (
            said(|pass| {
                let constant = pass.constant("table", desc(), vec![0; desc().bytes() as usize]);
                pass.clear("table").color(constant, CLEAR).record();
            }),
            "draws into `canvas.table`, which is not its own",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc());
                pass.clear("twice").color(color, CLEAR).color(color, CLEAR).record();
            }),
            "draws into `canvas.color` twice",
        ),
        (
            said(|pass| {
                let colors: Vec<ImageId> = (0..5).map(|at| image(pass, &format!("color{at}"), desc())).collect();
                colors.into_iter().fold(pass.clear("many"), |pass, color| pass.color(color, CLEAR)).record();
            }),
            "has 5 attachments for color with 40 bytes a sample; the limit of a device may be 8 with 32",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc().with_levels(2));
                pass.clear("one").color(color.level(1), CLEAR).record();
                pass.clear("other").color(color, Load::Keep).record();
            }),
            "the drawing pass `other` keeps what `canvas.color` holds, but no pass before has written it: clear it",
        ),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted), "{said:?} is not {wanted:?}");
    }
}

#[test]
fn geometry_and_entry_points_that_do_not_fit_are_refused() {
    let with_vertices = |bytes: u64, formats: &'static [VertexFormat], fragment: &'static str| {
        said(move |pass| {
            let vertices = pass.add_buffer("vertices", bytes, BufferLife::Frame);
            let color = image(pass, "color", desc());
            let draw = pass.draw(&SHADER, "corner").fragment(fragment).color(color, CLEAR);
            draw.vertices(vertices, formats).record(3, 1);
        })
    };
    let fits = &[VertexFormat::Float32x3, VertexFormat::Uint32];
    let cases: Vec<(String, &str)> = vec![
        (with_vertices(48, fits, "plain"), ""),
        (with_vertices(47, fits, "plain"), "reads 48 bytes of the buffer `canvas.vertices`, which has 47"),
        (
            with_vertices(64, &[VertexFormat::Float32x3, VertexFormat::Float32], "plain"),
            "gives `corner` `@location(0) vec3<f32>`, `@location(1) f32`, but it takes `@location(0) vec3<f32>`, \
             `@location(1) u32`",
        ),
        (
            with_vertices(64, fits, "pair"),
            "takes `@location(0) vec4<f32>` for its attachments, but `pair` gives `@location(0) vec4<f32>`, \
             `@location(1) vec4<f32>`",
        ),
        (with_vertices(64, fits, "narrow"), "but `narrow` gives `@location(0) vec2<f32>`"),
        (with_vertices(64, fits, "missing"), "needs `missing`, which is not a @fragment entry point of its module"),
        (
            said(|pass| {
                let color = image(pass, "color", desc());
                pass.draw(&SHADER, "alone").fragment("tint").color(color, CLEAR).record(3, 1);
            }),
            "has no @location(0) vec3<f32> for `tint` from `alone`",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc());
                pass.draw(&SHADER, "plain").fragment("plain").color(color, CLEAR).record(3, 1);
            }),
            "needs `plain`, which is not a @vertex entry point of its module",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc());
                pass.draw(&SHADER, "alone").color(color, CLEAR).record(3, 1);
            }),
            "has an attachment for color, but no fragment entry point",
        ),
        (
            said(|pass| {
                let indices: Vec<u8> = [0_u32, 1, 5].into_iter().flat_map(u32::to_le_bytes).collect();
                let indices = pass.constant_buffer("indices", indices);
                let vertices = pass.add_buffer("vertices", 48, BufferLife::Frame);
                let color = image(pass, "color", desc());
                let draw = pass.draw(&SHADER, "corner").fragment("plain").color(color, CLEAR).indices(indices);
                draw.vertices(vertices, fits).record(4, 1);
            }),
            "reads 96 bytes of the buffer `canvas.vertices`, which has 48, and reads 16 bytes of the buffer \
             `canvas.indices`, which has 12",
        ),
        (said(|pass| draw(pass, desc()).record(0, 1)), "draws 0 vertices of 1 instances"),
        (
            said(|pass| draw(pass, desc()).raster(Raster { bias: 1, ..Raster::default() }).record(3, 1)),
            "has a depth bias, but no attachment for depth",
        ),
        (
            said(|pass| {
                let depth = depth(pass);
                let raster = Raster { slope_bias: 1.0, topology: Topology::Lines, ..Raster::default() };
                draw(pass, desc()).depth(depth, DepthTest::default()).raster(raster).record(3, 1);
            }),
            "has a depth bias, which lines and points have not",
        ),
        (
            said(|pass| {
                let color = image(pass, "color", desc());
                let draw = pass.draw(&SHADER, "alone").fragment("see").color(color, CLEAR);
                draw.image("seen", color).record(3, 1);
            }),
            "reads `canvas.color` while it draws into it",
        ),
        (
            said(|pass| {
                let (color, counts) = (image(pass, "color", desc()), pass.add_buffer("counts", 16, BufferLife::Frame));
                let draw = pass.draw(&SHADER, "alone").fragment("count").color(color, CLEAR);
                draw.buffer("counts", counts).record(3, 1);
            }),
            "writes the variable `counts`: only attachments are written",
        ),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted) && wanted.is_empty() == said.is_empty(), "{said:?} is not {wanted:?}");
    }
}

#[test]
fn samples_levels_and_layers_stay_where_they_can_be_read() {
    static PICK: Shader = Shader::new(
        "canvas_pick.wgsl",
        "fn pick(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }",
    );
    let cases: Vec<(String, &str)> = vec![
        (
            said(|pass| {
                let mips = image(pass, "mips", desc().with_levels(2));
                pass.set_output("result", InputValue::Image(mips));
            }),
            "the output `result` of `Canvas` is a Image: its image has 1 sample, 2 levels and 1 layer",
        ),
        (
            said(|pass| {
                let layers = image(pass, "layers", desc().with_layers(2));
                pass.function(&PICK, "pick").read("source", layers).write("result", desc());
            }),
            "the image of `source` in `pick` has 2 layers: use `read_level`",
        ),
        (
            said(|pass| {
                let mips = image(pass, "mips", desc().with_levels(2));
                pass.function(&PICK, "pick").read_level("source", mips.level(2)).write("result", desc());
            }),
            "`pick` names level 2 of layer 0 of `canvas.mips`: its image has 1 sample, 2 levels and 1 layer",
        ),
        (
            said(|pass| {
                let (mips, plain) = (image(pass, "mips", desc().with_levels(2)), image(pass, "plain", desc()));
                pass.function(&PICK, "pick").read("source", plain).write_to(mips);
            }),
            "`pick` writes an image of one sample, level and layer: its image has 1 sample, 2 levels and 1 layer",
        ),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted), "{said:?} is not {wanted:?}");
    }
}

node_kind! {
    /// Reads a level that nothing has drawn.
    pub struct Undrawn {}

    const OUTPUTS: &'static [Output] = Canvas::OUTPUTS;
}

impl Node for Undrawn {
    fn record(&self, pass: &mut Recorder<'_>) {
        static UNDRAWN: Shader = Shader::new(
            "undrawn.wgsl",
            "fn undrawn(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }",
        );
        let desc = ImageDesc::new(Size::new(4, 4));
        let mips = pass.transient("mips", desc.with_levels(2));
        pass.clear("finest").color(mips, CLEAR).record();
        pass.function(&UNDRAWN, "undrawn").read_level("source", mips.level(1)).write("result", desc);
    }
}

node_kind! {
    /// Makes an image once from what each frame changes.
    pub struct Stale {}

    const INPUTS: &'static [Input] = &[Input::image("source", "Any image.")];
    const OUTPUTS: &'static [Output] = Canvas::OUTPUTS;
}

impl Node for Stale {
    fn record(&self, pass: &mut Recorder<'_>) {
        static STALE: Shader = Shader::new(
            "stale.wgsl",
            "fn stale(source: vec4f) -> vec4f { return source; }
fn stale_frame(source: texture_2d<f32>, at: Point, frame: Frame) -> vec4f {
    return texel(source, at.pixel) * f32(frame.index);
}",
        );
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let (first, second) = (pass.retained("first", desc), pass.retained("second", desc));
        pass.function(&STALE, "stale").write_to(first);
        pass.function(&STALE, "stale_frame").read("source", first).write_to(second);
        pass.function(&STALE, "stale").read("source", second).write("result", desc);
    }
}

#[test]
fn the_contract_finds_images_that_are_made_once_from_what_each_frame_changes() {
    let complaints = contract(&[NodeKind::of::<Stale>()]).expect_err("it is stale");
    let wanted = ["stale", "stale_frame"].map(|pass| {
        format!("`Stale`: the pass `{pass}` writes an image that is made once, and reads what each frame changes")
    });
    assert_eq!(complaints, wanted);
}

#[test]
fn the_contract_finds_levels_that_are_read_and_not_drawn() {
    let complaints = contract(&[NodeKind::of::<Undrawn>()]).expect_err("level 1 is not drawn");
    let wanted = "`Undrawn`: the pass `undrawn` reads level 1 of layer 0 of `node.mips`, which is not drawn";
    assert_eq!(complaints, [wanted]);
}
