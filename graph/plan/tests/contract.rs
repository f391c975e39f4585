//! The contract with code generation: the built-in kinds keep it, and what it finds beyond declarations.

use afterimage_graph::prelude::*;
use afterimage_plan::{contract, modules};

#[test]
fn the_modules_of_the_built_in_kinds_are_valid_alone_and_fused() {
    contract(afterimage_nodes::ALL).unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
}

static SHARED: Shader = Shader::new(
    "hoard.wgsl",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;
    var<workgroup> hoard_texels: array<vec4f, 1025>;
    @compute @workgroup_size(64)
    fn hoard(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
        hoard_texels[index] = texel(source, vec2i(id.xy));
        textureStore(result, id.xy, hoard_texels[index]);
    }",
);

static BY_HAND: Shader = Shader::new(
    "by_hand.wgsl",
    "const_assert !TAP_BY_HAND;
fn by_hand(source: vec4f) -> vec4f { return source; }
fn by_hand_far(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}",
);

node_kind! {
    /// Its second pass is no module where taps are filtered in the shader.
    pub struct ByHand {}

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "An image.").or_input("source")];
}

impl Node for ByHand {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let between = pass.transient("between", desc);
        pass.function(&BY_HAND, "by_hand").write_to(between);
        pass.function(&BY_HAND, "by_hand_far").read("source", between).write("result", desc);
    }
}

#[test]
fn every_pass_is_checked_in_every_way_in_which_it_may_be_composed() {
    let complaints = contract(&[NodeKind::of::<ByHand>()]).expect_err("the second pass is no module");
    let of_by_hand = "`ByHand`: the pass `by_hand_far` is no valid module";
    assert!(complaints.iter().all(|complaint| complaint.starts_with(of_by_hand)), "{complaints:?}");
    assert_eq!(complaints.len(), 1, "{complaints:?}");
}

node_kind! {
    /// Has one texel more of workgroup memory than every device has.
    pub struct Hoard {}

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "An image.").or_input("source")];
}

impl Node for Hoard {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let result = pass.output("result", desc);
        let groups = desc.size.div_up(64);
        pass.compute(&SHARED, "hoard").image("result", result).dispatch([groups.width, desc.size.height, 1]);
    }
}

#[test]
fn workgroup_memory_is_within_what_every_device_has() {
    let complaints = contract(&[NodeKind::of::<Hoard>()]).expect_err("it has too much").join("\n");
    let memory = "the pass `hoard` has 16400 bytes of workgroup memory; the limit of a device may be 16384";
    assert!(complaints.contains(memory), "{complaints}");
}

/// Devices without optional features have no immediates.
#[test]
fn modules_for_other_validators_are_all_of_them_without_immediates() {
    let of_time = ["FilmGrain", "Dither", "Glitch"];
    let kinds: Vec<NodeKind> =
        afterimage_nodes::ALL.iter().filter(|kind| of_time.contains(&kind.name())).cloned().collect();
    let found = modules(&kinds);
    let entries = |words: &str| found.iter().filter(|source| source.contains(words)).count();
    assert!(kinds.len() == 3 && found.len() > 10, "{} modules of {} kinds", found.len(), kinds.len());
    assert_eq!(entries("var<immediate>"), 0);
    assert!(entries("frame") > 0, "the time is that of a uniform");
}
