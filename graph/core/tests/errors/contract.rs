//! The contract of node kinds: good tables pass, and each broken promise is named.

use afterimage_graph::node::contract;
use afterimage_graph::prelude::*;

static SHADER: Shader = Shader::new(
    "plugin/Careless.wgsl",
    "struct Careless { amount: f32 }\n\
     fn helper(x: f32) -> f32 { return x; }\n\
     fn careless(source: vec4f, params: Careless) -> vec4f { return source * helper(params.amount); }\n\
     fn careless_lost(elsewhere: vec4f) -> vec4f { return elsewhere; }\n",
);

choices! {
    /// What goes wrong.
    pub enum Mistake {
        /// Nothing.
        Nothing,
        /// An argument that is no port.
        Argument,
        /// Nothing is given.
        Gift,
    }
}

node_kind! {
    /// Breaks promises.
    pub struct Careless {
        /// In its domain.
        pub amount: f32 = 2.0 => within(0.0..=1.0);
        /// Without a domain.
        pub open: f32 = 0.0;
        /// Which promise.
        pub mistake: Mistake = Mistake::Nothing;
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", ""), Input::new("target", PortType::Value, "A word of WGSL.").optional()];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("sauce"), "The picture.").or_input("target")];
}

impl Node for Careless {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        match self.mistake {
            Mistake::Nothing => drop(pass.function(&SHADER, "careless").write("result", desc)),
            Mistake::Argument => drop(pass.function(&SHADER, "careless_lost").write("result", desc)),
            Mistake::Gift => {}
        }
    }
}

#[test]
fn every_broken_promise_is_named() {
    let complaints = contract(&[NodeKind::of::<Careless>()]).expect_err("it breaks many");
    for part in [
        "`Careless`: the input `source` has no doc",
        "`target` is a word of WGSL",
        "the state of `result` follows `sauce`, which is not a required image input",
        "the fallback of `result` (Image) is `target` (Value)",
        "the default of `amount` is not acceptable: `amount` must be within 0 and 1",
        "the numbers of `open` have no domain",
        "the file `plugin/Careless.wgsl` is not called after a kind, in snake_case",
        "recording fails: plugin/Careless.wgsl:4:1: `Careless` has no input `elsewhere`",
        "the output `result` is used and not given as a Image",
    ] {
        assert!(
            complaints.iter().any(|complaint| complaint.contains(part)),
            "{part} is not in\n{}",
            complaints.join("\n")
        );
    }
}

#[test]
fn the_built_in_kinds_keep_it() {
    contract(afterimage_nodes::ALL).unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
}

static LARGE: Shader = Shader::new(
    "large.wgsl",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var<storage, read_write> sums: array<vec4f>;
    @compute @workgroup_size(16, 32)
    fn large(@builtin(workgroup_id) id: vec3u) { sums[id.x] = textureLoad(source, vec2i(id.xy), 0); }",
);

node_kind! {
    /// Fits into the limits of a device for small images.
    pub struct Large {}

    const INPUTS: &'static [Input] = &[Input::image("source", "The picture.")];
    const OUTPUTS: &'static [Output] = &[Output::new("result", PortType::Table, OutputState::Nothing, "Sums.")];
}

impl Node for Large {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let texels = pass.desc(source).size.texels();
        let sums = pass.output_table("result", texels * 16, BufferLife::Frame);
        let groups = texels.div_ceil(256) as u32;
        pass.compute(&LARGE, "large").buffer("sums", sums).dispatch([groups, 1, 1]);
    }
}

#[test]
fn limits_of_devices_hold_for_large_images() {
    let complaints = contract(&[NodeKind::of::<Large>()]).expect_err("it exceeds limits").join("\n");
    for part in [
        "`Large`: the output `result` is a table, which its readers must know: name its layout by `content`",
        "the pass `large` at 64x36 has 512 invocations in a workgroup; the limit of a device may be 256",
        "the pass `large` at 7680x4320 has 129600 workgroups in one direction; the limit of a device may be 65535",
        "the buffer `node.result` has 530841600 bytes at 7680x4320; the limit of a device may be 134217728",
    ] {
        assert!(complaints.contains(part), "{part} is missing in:\n{complaints}");
    }
    assert!(!complaints.contains("at 64x36 has 9 workgroups"), "{complaints}");
}

static WASTE: Shader = Shader::new(
    "waste.wgsl",
    "struct Waste { amount: f32 }
fn waste(source: vec4f, params: Waste) -> vec4f { return params.amount * source; }
fn waste_far(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}
fn waste_both(source: vec4f, half: vec4f) -> vec4f { return source + half; }
",
);

node_kind! {
    /// Declares and stores what nothing reads.
    pub struct Waste {
        /// A member of a uniform.
        pub amount: f32 = 0.5 => within(0.0..=1.0);
        /// Nothing has it.
        pub idle: f32 = 0.5 => within(0.0..=1.0);
        /// Acts if `wide`, and only then.
        pub reach: f32 = 0.25 => within(0.0..=1.0), when("wide", [true]);
        /// Whether `reach` acts.
        pub wide: bool = false => replans();
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "The picture."), Input::image("mask", "Nothing reads it.").optional()];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The picture.").or_input("source")];
}

impl Node for Waste {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let lost = pass.transient("lost", ImageDesc::new(desc.size.half()));
        pass.function(&WASTE, "waste_far").write_to(lost);
        let amount = if self.wide { self.reach } else { self.amount };
        pass.function(&WASTE, "waste").set("amount", amount).write("result", desc);
    }
}

#[test]
fn what_is_declared_or_stored_and_not_read_is_named() {
    let complaints = contract(&[NodeKind::of::<Waste>()]).expect_err("it wastes much");
    assert_eq!(
        complaints,
        [
            "`Waste`: the pass `waste_far` makes the image `node.lost`, which nothing reads",
            "`Waste`: no pass reads the input `mask`",
            "`Waste`: the parameter `idle` does nothing: no uniform has it, and no pass differs by it; if it depends \
             on another one, declare `when`",
        ]
    );
}

node_kind! {
    /// Takes pixels of an image that is half as large as its result.
    pub struct Outside {}

    const INPUTS: &'static [Input] = &[Input::image("source", "The picture.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The picture.").or_input("source")];
}

impl Node for Outside {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let half = pass.transient("half", ImageDesc::new(desc.size.half()));
        pass.function(&WASTE, "waste_far").write_to(half);
        pass.function(&WASTE, "waste_both").read("half", half).write("result", desc);
    }
}

#[test]
fn a_pixel_of_an_image_of_another_size_is_named() {
    let complaints = contract(&[NodeKind::of::<Outside>()]).expect_err("it reads outside");
    let expected = "`Outside`: `waste_both` takes the pixel `half` of `node.half`, which has another size than its \
                    result: take a texture, and read it with `tap`";
    assert_eq!(complaints, [expected]);
}

node_kind! {
    /// Always refused.
    pub struct Refused {}

    const INPUTS: &'static [Input] = &[Input::image("source", "The picture.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The picture.").or_input("source")];
}

impl Node for Refused {
    fn verify(&self) -> Result<(), String> {
        Err("a file is missing".into())
    }

    fn record(&self, _: &mut Recorder<'_>) {}
}

#[test]
fn a_kind_that_never_records_is_reported_as_skipped() {
    let skipped = contract(&[NodeKind::of::<Refused>()]).expect("nothing is wrong").join("\n");
    assert!(
        skipped.contains("`Refused`: no pass is checked, because its defaults are refused (a file is missing)"),
        "{skipped}"
    );
}

node_kind! {
    /// Has names that mean something else.
    pub struct Misnamed {
        /// An input has this name.
        pub source: f32 = 0.5 => within(0.0..=1.0);
        /// A condition has this name.
        pub when: f32 = 0.5 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "A picture.")];
    const OUTPUTS: &'static [Output] = &[
        Output::image("Result", OutputState::same("source"), "Another."),
        Output::image("double", OutputState::same("source"), "One of two."),
        Output::image("double", OutputState::same("source"), "The other."),
    ];
}

impl Node for Misnamed {
    fn record(&self, _: &mut Recorder<'_>) {}
}

#[test]
fn names_are_given_once_and_to_one_thing() {
    let complaints = contract(&[NodeKind::of::<Misnamed>()]).expect_err("its names are taken").join("\n");
    for part in [
        "the name `source` is given twice",
        "`when` means something else in every pipeline file or shader",
        "the name `Result` is not in snake_case",
        "the name `double` is given twice",
    ] {
        assert!(complaints.contains(part), "{part} is not in\n{complaints}");
    }
}

#[test]
fn the_manual_of_a_kind_is_its_comment() {
    let kind = NodeKind::of::<Misnamed>();
    assert_eq!((kind.name(), kind.doc().trim()), ("Misnamed", "Has names that mean something else."));
    let docs: Vec<&str> = kind.params().iter().map(|param| param.doc.trim()).collect();
    assert_eq!(docs, ["An input has this name.", "A condition has this name."]);
}
