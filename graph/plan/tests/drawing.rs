//! Plans with drawing passes that blend and that draw ranges of a buffer: against the interpreter, for devices that
//! cannot blend, and in reports.

use std::collections::BTreeSet;

use afterimage_generators::Rng;
use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{
    Blend, ColorAttachment, DepthTest, DrawContents, Drawing, Draws, Geometry, IndirectDraws, Load, PassKind, Registry,
    WriteMask,
};
use afterimage_graph::prelude::*;
use afterimage_plan::{
    BandLimits, Caps, Halos, HostLimits, Options, Plan, PlanError, PlannedPass, Requirement, Stage, contract, verify,
};

use super::fusion::{RESULT, SOURCE, kind, like_source, planned_at};
use super::machine::Machine;
use super::model::{PLAIN, assert_computes_the_same, blurs, change, variants};
use super::support::{FRAME, all_formats, plan_on};

/// A change that breaks a plan.
type Break = fn(&mut Plan);

static PANES: Shader = Shader::new(
    "panes.wgsl",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
        return vec4f(f32(index % 2u), f32(index / 2u), 0.5, 1.0);
    }
    @fragment fn pane(@builtin(position) at: vec4f) -> @location(0) vec4f {
        return texel(source, vec2i(at.xy));
    }",
);
static COUNT: Shader = Shader::new(
    "pane_count.wgsl",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var<storage, read_write> ranges: array<u32>;
    @compute @workgroup_size(1)
    fn pane_count() {
        ranges[0] = 3u;
        ranges[1] = u32(texel(source, vec2i(0)).x > 0.5);
    }",
);
static HALF: Shader = Shader::new("pane_half.wgsl", "fn pane_half(below: vec4f) -> vec4f { return 0.5 * below; }");

kind!(Panes, "Draws over what it has drawn, as often as a kernel says.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let (color, between) = (pass.output("result", desc), pass.transient("between", desc));
    let depth = pass.transient("depth", desc.format(Format::Depth32Float));
    let ranges = pass.add_buffer("ranges", 32, BufferLife::Frame);
    pass.compute(&COUNT, "pane_count").buffer("ranges", ranges).dispatch([1, 1, 1]);
    let draw = pass.draw(&PANES, "corner").fragment("pane").label("first").color(color, Load::Clear([0.0; 4]));
    draw.depth(depth, DepthTest::default()).record(3, 1);
    pass.function(&HALF, "pane_half").read("below", color).write_to(between);
    let draw = pass.draw(&PANES, "corner").fragment("pane").label("second").image("source", between);
    let draw = draw.color(color, Load::Keep).blend(Blend::OVER);
    draw.record_indirect(IndirectDraws { buffer: ranges, offset: 0, ranges: 2 });
});

/// Random pipelines with that kind.
fn drawn(seed: u64) -> (String, String) {
    let (nodes, outputs) = blurs(seed);
    (nodes.replace("Far(", "Panes(").replace("Late(", "Panes("), outputs)
}

const SIZE: Size = Size { width: 97, height: 61, depth: 1 };

#[test]
fn draws_see_in_every_way_to_run_a_pipeline_what_they_see_as_recorded() {
    let mut draws = 0;
    for seed in 0..60 {
        let (nodes, outputs) = drawn(seed);
        let plain = planned_at(SIZE, &nodes, &outputs, PLAIN);
        for (name, options) in variants() {
            let plan = planned_at(SIZE, &nodes, &outputs, options);
            assert_computes_the_same(&plan, &plain, &format!("pipeline {seed}, {name}: {nodes}"));
            draws += plan.work().filter_map(|pass| pass.drawing()).count();
        }
    }
    assert!(draws > 400, "{draws} passes draw");
}

/// Nothing reads the depth, so no device needs to write it to memory.
#[test]
fn attachments_that_nothing_reads_are_not_stored() {
    let plan = planned_at(SIZE, r#""out": Panes(source: "in")"#, r#""out": "out""#, Options::default());
    let stores = |label: &str| plan.passes.iter().find(|planned| planned.pass.label == label).map(|p| &p.stores[..]);
    assert_eq!((stores("first"), stores("second")), (Some(&[true, false][..]), Some(&[true][..])));
}

/// Whatever little memory there is, the reason is what no memory mends.
#[test]
fn geometry_is_why_an_image_cannot_be_rendered_in_bands() {
    let plan = planned_at(SIZE, r#""out": Panes(source: "in")"#, r#""out": "out""#, Options::default());
    let (parts, rows, host) = (None, None, HostLimits::NONE);
    for bytes in [1, 1 << 30] {
        let limits = BandLimits { bytes, taken: 0, block: 0, side: 4096, filters: true, least: 1, parts, rows, host };
        let error = plan.banding(limits, &Halos::default(), &Requirement::typical).expect_err("it draws");
        assert!(error.to_string().contains("it draws geometry"), "{error}");
    }
}

#[test]
fn verify_finds_what_the_interpreter_notices_of_draws() {
    let (mut noticed, mut rng) = (std::collections::BTreeMap::<&str, usize>::new(), Rng::new(1));
    for seed in 0..40 {
        let (nodes, outputs) = drawn(seed);
        let plan = planned_at(SIZE, &nodes, &outputs, Options::default());
        let wanted = Machine::frames(&plan, 3);
        for at in 0..16 {
            let mut changed = plan.clone();
            let what = if at % 4 == 0 { drop_one(&mut changed, &mut rng) } else { change(&mut changed, &mut rng) };
            let Some(what) = what.filter(|_| Machine::frames(&changed, 3) != wanted) else { continue };
            *noticed.entry(what).or_default() += 1;
            assert!(verify(&changed).is_err(), "pipeline {seed}: {what}:\n{}", changed.to_text());
        }
    }
    assert!(noticed["an attachment is not stored"] >= 20 && noticed["a transition is missing"] >= 20, "{noticed:?}");
}

/// Each fault of a drawing pass is reported with the pass and the image.
#[test]
fn faults_of_draws_are_reported_in_words() {
    fn drawing<'p>(plan: &'p mut Plan, label: &str) -> &'p mut Drawing {
        match &mut planned(plan, label).pass.kind {
            PassKind::Drawing(drawing) => drawing,
            _ => panic!("`{label}` draws"),
        }
    }
    fn planned<'p>(plan: &'p mut Plan, label: &str) -> &'p mut PlannedPass {
        plan.passes.iter_mut().find(|planned| planned.pass.label == label).expect("the pass is there")
    }
    fn desc<'p>(plan: &'p mut Plan, image: &str) -> &'p mut ImageDesc {
        &mut plan.images.iter_mut().find(|planned| planned.label == image).expect("the image is there").desc
    }
    fn ranges(plan: &mut Plan) -> &mut Geometry {
        match &mut drawing(plan, "second").contents {
            DrawContents::Geometry(geometry) => geometry,
            _ => panic!("it draws geometry"),
        }
    }
    fn at_byte(plan: &mut Plan, byte: u64) {
        if let Draws::Indirect(draws) = &mut ranges(plan).draws {
            draws.offset = byte;
        }
    }
    let table: [(Break, &str); 14] = [
        (|plan| planned(plan, "first").stores.truncate(1), "pass `out: first` has 2 attachments and stores [true]"),
        (
            |plan| planned(plan, "first").stores[0] = false,
            "pass `out: pane_half` reads `out.result`, which was not stored",
        ),
        (
            |plan| planned(plan, "first").stores[0] = false,
            "pass `out: second` reads `out.result`, which was not stored",
        ),
        (
            |plan| drawing(plan, "second").colors[0].target.level = 1,
            "pass `out: second` draws into level 1 of layer 0 of `out.result`, which is not there",
        ),
        (
            |plan| drawing(plan, "first").colors[0].target.layer = 1,
            "pass `out: first` draws into level 0 of layer 1 of `out.result`, which is not there",
        ),
        (|plan| desc(plan, "out.depth").format = Format::R32Float, "draws depth into `out.depth` (R32Float)"),
        (|plan| desc(plan, "out.result").format = Format::Depth32Float, "draws color into `out.result` (Depth32Float)"),
        (|plan| desc(plan, "out.depth").size.width += 1, "pass `out: first` draws into attachments of 2 shapes"),
        (|plan| desc(plan, "out.depth").samples = 4, "pass `out: first` draws into attachments of 2 shapes"),
        (|plan| at_byte(plan, 4), "pass `out: second` reads 2 ranges from byte 4 of `out.ranges`, which has 32"),
        (|plan| at_byte(plan, 2), "reads 2 ranges from byte 2 of `out.ranges`"),
        (|plan| ranges(plan).indices = Some(BufferId(0)), "reads 2 ranges from byte 0 of `out.ranges`"),
        (|plan| planned(plan, "first").stage = Stage::Compute, "pass `first` is planned as Compute, which it is not"),
        (
            |plan| desc(plan, "out.between").levels = 2,
            "pass `out: second` reads level 1 of layer 0 of `out.between`, which no pass has drawn",
        ),
    ];
    let plan = planned_at(SIZE, r#""out": Panes(source: "in")"#, r#""out": "out""#, Options::default());
    assert_eq!(verify(&plan), Ok(()));
    for (change, told) in table {
        let mut changed = plan.clone();
        change(&mut changed);
        let faults = verify(&changed).expect_err(told);
        assert!(faults.iter().any(|fault| fault.to_string().contains(told)), "{told}: {faults:?}");
    }
}

/// Does not store one of the attachments.
fn drop_one(plan: &mut Plan, rng: &mut Rng) -> Option<&'static str> {
    let mut stores: Vec<&mut bool> = plan.passes.iter_mut().flat_map(|planned| &mut planned.stores).collect();
    let at = rng.below(stores.len());
    let stored = stores.get_mut(at).filter(|stored| ***stored)?;
    **stored = false;
    Some("an attachment is not stored")
}

#[test]
fn a_plan_for_a_device_that_cannot_blend_names_the_image() {
    let plan = |format: &str, blends: &[Format], exact: bool| {
        let caps = Caps { blendable: blends.iter().copied().collect(), ..all_formats() };
        let caps = Caps { renderable: Format::ALL.into(), ..caps };
        let nodes = format!("\"pane\": Panes(source: \"picture\", format: {format})");
        let text =
            format!("Pipeline(inputs: {{\"picture\": Color}}, nodes: {{{nodes}}}, outputs: {{\"out\": \"pane\"}})");
        let document = parse("drawing.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
        let registry = Registry::new(&[super::kernels::KINDS]).expect("no two kinds share a name");
        let checked = check(&document, &registry, &CheckOptions::default());
        let graph = checked.unwrap_or_else(|errors| panic!("{errors}")).0;
        plan_on(&graph, FRAME, Options { exact, ..Options::default() }, caps)
    };
    let halves = [Format::Rgba16Float];
    let stored = |format| {
        let plan = plan(format, &halves, false)?;
        Ok(plan.images.iter().find(|image| image.label == "pane.result").map(|image| image.desc.format))
    };
    assert_eq!(stored("Rgba16Float"), Ok(Some(Format::Rgba16Float)));
    assert_eq!(stored("Rg11b10Ufloat"), Ok(Some(Format::Rgba16Float)), "the next format that blends");
    let format = Format::Rgba32Float;
    let error = PlanError::NotBlendable { pass: "second".into(), image: "pane.result".into(), format };
    let message = "pass `second` blends into `pane.result`, but this device cannot blend into its format \
                   `Rgba32Float`; every device blends into `Rgba16Float`";
    assert_eq!(error.to_string(), message);
    assert_eq!(stored("Rgba32Float"), Err(error.clone()));
    assert_eq!(plan("Rgba16Float", &halves, true).map(drop), Err(error), "a reference has 32 bits");
    assert!(plan("Rgba16Float", &[Format::Rgba32Float], true).is_ok());
}

#[test]
fn what_a_pass_draws_is_part_of_the_plan() {
    type Change = fn(&mut Drawing);
    fn color(drawing: &mut Drawing) -> &mut ColorAttachment {
        &mut drawing.colors[0]
    }
    fn ranges(drawing: &mut Drawing) -> &mut IndirectDraws {
        let DrawContents::Geometry(geometry) = &mut drawing.contents else { panic!("it has geometry") };
        let Draws::Indirect(indirect) = &mut geometry.draws else { panic!("its ranges are in a buffer") };
        indirect
    }
    let plan = planned_at(FRAME, r#""pane": Panes(source: "in")"#, r#""out": "pane""#, Options::default());
    let changes: [Change; 6] = [
        |_| {},
        |drawing| color(drawing).blend = Blend::ADD,
        |drawing| color(drawing).writes = WriteMask::COLOR,
        |drawing| color(drawing).load = Load::Clear([0.5; 4]),
        |drawing| ranges(drawing).ranges = 1,
        |drawing| ranges(drawing).offset = 4,
    ];
    let changed = |change: &Change| {
        let mut plan = plan.clone();
        let second = plan.passes.iter_mut().find(|planned| planned.pass.label == "second").expect("it is drawn");
        let PassKind::Drawing(drawing) = &mut second.pass.kind else { panic!("it is drawn") };
        change(drawing);
        plan.hash().to_string()
    };
    assert_eq!(changes.iter().map(changed).collect::<BTreeSet<_>>().len(), changes.len());
    let json: serde_json::Value = serde_json::from_str(&plan.to_json()).expect("it is JSON");
    let passes = json["passes"].as_array().expect("a list");
    let second = &passes.iter().find(|pass| pass["label"] == "second").expect("it is drawn")["kind"]["Drawing"];
    assert_eq!(second["colors"][0]["load"], "Keep");
    let buffer = second["contents"]["Geometry"]["draws"]["Indirect"]["buffer"].as_u64().expect("an index");
    assert_eq!(json["buffers"][buffer as usize]["name"], "pane.ranges");
}

static COMPARED: Shader = Shader::new(
    "compared.wgsl",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var nearest: sampler_comparison;
    @group(0) @binding(2) var depths: texture_depth_2d;
    @vertex fn compared() -> @builtin(position) vec4f { return vec4f(0.0); }
    @fragment fn lit() -> @location(0) vec4f {
        return texel(source, vec2i()) * textureSampleCompareLevel(depths, nearest, vec2f(0.5), 0.5);
    }",
);

kind!(Compared, "Compares depths as no kernel can.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let color = pass.output("result", desc);
    pass.draw(&COMPARED, "compared").fragment("lit").color(color, Load::Clear([0.0; 4])).record(3, 1);
});

#[test]
fn a_binding_that_nothing_can_be_bound_to_is_named() {
    assert_eq!(contract(&[NodeKind::of::<Panes>()]), Ok(Vec::new()));
    let complaints = contract(&[NodeKind::of::<Compared>()]).expect_err("it compares").join("\n");
    let wanted = "has a type that no kernel can bind: textures are `texture_2d<f32>` or `texture_3d<f32>`, and \
                  samplers do not compare";
    assert!(complaints.contains(wanted), "{complaints}");
}

static LOAD: Shader = Shader::new(
    "pane_load.wgsl",
    "fn pane_load(below: texture_2d<f32>, at: Point) -> vec4f { return textureLoad(below, at.pixel, 0); }
fn pane_above(below: texture_2d<f32>, at: Point, above: vec4f) -> vec4f {
    return above + textureLoad(below, at.pixel, 0);
}
fn pane_both(below: texture_2d<f32>, above: texture_2d<f32>, at: Point) -> vec4f {
    return textureLoad(below, at.pixel, 0) + textureLoad(above, at.pixel, 0);
}",
);

kind!(Sums, "Loads texels of sums that may not be finite, of one light and of two.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let (sum, first) = (pass.transient("sum", desc), pass.transient("first", desc));
    let draw = pass.draw(&PANES, "corner").fragment("pane").label("one").color(sum, Load::Clear([0.0; 4]));
    draw.blend(Blend::ADD).record(3, 1);
    pass.function(&LOAD, "pane_load").label("one is read").read("below", sum).write_to(first);
    let draw = pass.draw(&PANES, "corner").fragment("pane").label("two").color(sum, Load::Keep);
    draw.blend(Blend::ADD).image("source", first).record(3, 1);
    pass.function(&LOAD, "pane_load").label("two are read").read("below", sum).write("result", desc);
});
kind!(Layers, "Loads texels of sums in two layers, of the first twice.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let (sums, between) = (pass.transient("sums", desc.with_layers(2)), pass.transient("between", desc));
    let [first, second] = [0, 1].map(|layer| sums.level(0).layer(layer));
    for (label, target) in [("one", first), ("two", second)] {
        let draw = pass.draw(&PANES, "corner").fragment("pane").label(label).color(target, Load::Clear([0.0; 4]));
        draw.blend(Blend::ADD).record(3, 1);
    }
    let both = pass.function(&LOAD, "pane_both").read_level("below", first).read_level("above", second);
    both.write_to(between);
    let again = pass.function(&LOAD, "pane_above").read_level("below", first).read("above", between);
    again.write("result", desc);
});

#[test]
fn a_sanitized_copy_is_of_what_the_image_holds_where_it_is_read() {
    let recorded = |kind: &str| {
        let plan = planned_at(FRAME, &format!("\"sums\": {kind}(source: \"in\")"), r#""out": "sums""#, PLAIN);
        let pass = |planned: &PlannedPass| (planned.recorded, planned.pass.label.clone());
        let passes: std::collections::BTreeMap<usize, String> = plan.passes.iter().map(pass).collect();
        passes.into_values().collect::<Vec<_>>()
    };
    assert_eq!(recorded("Sums"), ["one", "sanitize", "one is read", "two", "sanitize", "two are read"]);
    assert_eq!(recorded("Layers"), ["one", "two", "sanitize", "sanitize", "pane_both", "pane_above"]);
}

/// Pipelines depend on the format of an attachment, which a host's image need not have.
#[test]
fn an_output_that_a_pass_draws_into_is_copied() {
    let plan = planned_at(FRAME, r#""pane": Panes(source: "in")"#, r#""out": "pane""#, Options::default());
    let drawn: Vec<_> =
        plan.passes.iter().filter_map(|planned| planned.pass.drawing()).flat_map(Drawing::images).collect();
    assert!(!drawn.is_empty() && !drawn.contains(&plan.outputs[0].image), "{}", plan.to_text());
}
