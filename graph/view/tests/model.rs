//! The model: frames, comparison and inspection, without a window.

use crate::support::{SIZE, apart, gpu, model, of, parameter, picture, render, settle, texels};
use afterimage::offline::Session;
use afterimage_gpu::{FrameStep, Texels, wgpu};
use afterimage_graph::check::{Fact, Facts, Source};
use afterimage_graph::node::{Origin, PortType, Registry, folder_kind};
use afterimage_graph::value::Value;
use afterimage_plan::Options;
use afterimage_view::render::{Flags, Painter, Placement, Shown};
use afterimage_view::{CompareWith, InspectedWire, Model, Problem, Rendered, Target, TextProject};

#[test]
fn nothing_is_rendered_while_nothing_changes() {
    let mut model = model("lynx");
    settle(&mut model);
    assert_eq!(render(&mut model), Rendered::Same);
    model.clock().step();
    assert_eq!(render(&mut model), Rendered::New);
}

#[test]
fn a_slider_changes_the_next_frame_and_undo_brings_the_old_picture_back() {
    let mut model = model("lynx");
    settle(&mut model);
    let before = picture(&model);
    model.set(&parameter("lit.strength"), Some(Value::Float(0.9)));
    model.release();
    settle(&mut model);
    let changed = picture(&model);
    assert!(apart(&changed, &before) > 5);
    model.set(&parameter("lit.strength"), Some(Value::Float(0.5)));
    assert_eq!(render(&mut model), Rendered::New);
    assert!(!model.shown().unwrap().is_changing(), "a slider that has moved before needs no plan");
    model.undo();
    model.undo();
    settle(&mut model);
    assert!(apart(&picture(&model), &before) <= 1);
    assert!(model.editor().changes().is_empty());
}

#[test]
fn a_value_that_a_node_refuses_changes_nothing_and_is_the_problem() {
    let mut model = model("lynx");
    settle(&mut model);
    model.set(&parameter("lit.strength"), Some(Value::Float(-1e9)));
    assert!(model.problem().unwrap().to_string().contains("strength"), "{:?}", model.problem());
    assert!(model.editor().changes().is_empty());
    model.set(&parameter("lit.strength"), Some(Value::Float(0.2)));
    assert!(model.problem().is_none() && model.editor().changes().len() == 1);
}

#[test]
fn a_node_can_be_switched_off_and_on() {
    let mut model = model("tsushima");
    settle(&mut model);
    let before = picture(&model);
    let vignette = Target::Node("vignette".into());
    model.set(&vignette, Some(Value::Bool(false)));
    model.clock().cut();
    settle(&mut model);
    assert!(model.shown().unwrap().plan().unwrap().savings.skipped.iter().any(|skipped| skipped.node == "vignette"));
    assert!(apart(&picture(&model), &before) > 5);
    model.set(&vignette, Some(Value::Bool(true)));
    assert!(model.editor().changes().is_empty(), "that is what the file says");
}

#[test]
fn a_fact_is_unknown_until_it_is_set_and_can_become_unknown_again() {
    let mut model = model("caracal");
    settle(&mut model);
    let runs = |model: &Model| {
        let plan = model.shown().unwrap().plan().unwrap();
        !plan.savings.skipped.iter().any(|skipped| skipped.node == "glowing")
    };
    assert!(model.fact("emissive").is_none() && runs(&model));
    assert!(
        model
            .editor()
            .checked()
            .unwrap()
            .fact_meaning("emissive")
            .is_some_and(|meaning| meaning.contains("gives out light"))
    );
    model.set_fact("emissive", Some(Fact::Flag(false)));
    settle(&mut model);
    assert!(!runs(&model));
    model.set_fact("emissive", None);
    settle(&mut model);
    assert!(model.fact("emissive").is_none() && runs(&model));
}

#[test]
fn a_parameter_that_does_nothing_is_known_with_the_reason_and_another_choice_wakes_it() {
    let mut model = model("lynx");
    let graph = model.editor().graph().unwrap().clone();
    let mapped = graph.nodes.iter().find(|node| node.kind().name() == "ToneMap").unwrap().name.clone();
    let named = |name: &str| format!("{mapped}.{name}");
    let toe = graph.parameter(&named("toe")).unwrap();
    assert_eq!(model.inactive_reason(graph.parameter(&named("keep_hue")).unwrap()), None);
    assert_eq!(model.inactive_reason(toe).unwrap(), "Has an effect only while `curve` is Uchimura.");
    model.set(&parameter(&named("curve")), Some(Value::Choice("Uchimura")));
    model.release();
    assert_eq!(model.inactive_reason(toe), None);
}

/// Renders until faults are counted, a few frames after the picture.
fn count_faults(model: &mut Model) {
    for _ in 0..2000 {
        render(model);
        if !model.kernel_faults().is_empty() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("{:?}", model.problem());
}

#[test]
fn infinities_of_a_kind_in_a_folder_are_counted_until_no_shown_pipeline_uses_it() {
    let declaration = r#"Kind(
    name: "Overflow",
    doc: "Multiplies until nothing is finite.",
    inputs: { "source": Image(doc: "Any image.") },
    outputs: { "result": Image(doc: "Infinities.", state: Same("source")) },
)"#;
    let shader = "fn overflow(source: vec4f) -> vec4f {\n    return (source + 1.0) * 1e30 * 1e30;\n}\n";
    let kind = folder_kind(("overflow/node.ron", declaration), ("overflow/overflow.wgsl", shader)).unwrap();
    let registry = Registry::new(&[afterimage_nodes::ALL, &[kind]]).unwrap();
    let text = |source: &str| {
        format!(
            r#"Pipeline(
    inputs: {{ "scene": Color }},
    nodes: {{
        "wrong": Overflow(source: "scene"),
        "exposed": Exposure(source: "{source}", stops: 1.0),
        "mapped": ToneMap(source: "exposed"),
        "display": Encode(source: "mapped"),
    }},
    outputs: {{ "display": "display" }},
)"#
        )
    };
    let project = TextProject::with_registry("wrong.ron", &text("wrong"), registry);
    let mut model = of(Box::new(project));
    count_faults(&mut model);
    let [faults] = model.kernel_faults() else { panic!("{:?} {:?}", model.kernel_faults(), model.problem()) };
    let pixels = u64::from(SIZE.width * SIZE.height);
    assert_eq!((faults.not_finite, faults.cut_loops, faults.pixels), (pixels, 0, pixels));
    assert_eq!((&*faults.node, &*faults.file, faults.line), ("wrong", "overflow/overflow.wgsl", 1));
    assert_eq!(render(&mut model), Rendered::Same, "it is counted once");
    model.edit(&text("scene"));
    settle(&mut model);
    assert!(model.kernel_faults().is_empty(), "{:?}", model.kernel_faults());
    model.edit(&text("wrong"));
    count_faults(&mut model);
    model.open(Box::new(TextProject::built_in("lynx").unwrap()));
    assert!(model.kernel_faults().is_empty(), "those are of another pipeline");
}

#[test]
fn another_pipeline_with_errors_shows_nothing_of_the_one_before() {
    let mut model = model("tsushima");
    model.set_tier(Some("low".into()));
    model.set_fact("emissive", Some(Fact::Flag(false)));
    model.inspect_wire(Some(InspectedWire::new("exposed.result")));
    model.set_compared(Some(CompareWith::Written));
    let good = TextProject::built_in("lynx").unwrap().text().to_owned();
    model.open(Box::new(TextProject::new("broken.ron", &good.replace("Composite(", "Compositor("))));
    assert!(matches!(model.problem(), Some(Problem::Pipeline(_))), "{:?}", model.problem());
    let editor = model.editor();
    assert!(editor.checked().is_none() && editor.tiers().is_empty() && editor.tier().is_none());
    assert!(model.shown().is_none() && model.compared().is_none() && model.inspector().wire().is_none());
    assert!(model.fact("emissive").is_none());
    assert_eq!(render(&mut model), Rendered::Same, "there is nothing to render");
    model.edit(&good);
    settle(&mut model);
    assert!(model.problem().is_none() && model.shown().is_some_and(|shown| shown.picture().is_some()));
}

#[test]
fn a_broken_text_keeps_the_picture_and_says_where_it_is_wrong() {
    let mut model = model("lynx");
    settle(&mut model);
    let (before, good) = (picture(&model), model.editor().text().to_owned());
    let broken = good.replace("Composite(", "Compositor(");
    model.edit(&broken);
    let Some(Problem::Pipeline(errors)) = model.problem() else { panic!("{:?}", model.problem()) };
    assert!(errors.to_string().contains("lynx.ron:"), "{errors}");
    model.clock().step();
    assert_eq!(render(&mut model), Rendered::New);
    assert!(model.problem().is_some(), "a frame of the old pipeline does not mend the text");
    model.set(&parameter("lit.strength"), Some(Value::Float(0.4)));
    model.undo();
    assert!(matches!(model.problem(), Some(Problem::Pipeline(_))), "nor does a slider or its undo");
    model.edit(&good);
    assert!(model.problem().is_none());
    model.clock().seek(0.0);
    settle(&mut model);
    assert!(apart(&picture(&model), &before) <= 1);
}

#[test]
fn changes_are_saved_as_a_tier_and_the_rest_of_the_file_stays() {
    let mut model = model("lynx");
    model.set(&parameter("lit.strength"), Some(Value::Float(0.45)));
    let before = model.editor().text().to_owned();
    model.save(Some("strong")).unwrap();
    assert_eq!((model.editor().tier(), model.editor().changes().is_empty()), (Some("strong"), true));
    assert_eq!(model.editor().written(&parameter("lit.strength")), Some(Value::Float(0.45)));
    model.set_tier(None);
    assert_ne!(model.editor().written(&parameter("lit.strength")), Some(Value::Float(0.45)));
    let text = model.editor().text().to_owned();
    let kept = before.lines().filter(|line| text.lines().any(|other| other == *line)).count();
    assert!(kept + 2 >= before.lines().count(), "{text}");
}

#[test]
fn a_tier_a_pipeline_and_the_reference_stand_beside_the_picture() {
    let mut model = model("tsushima");
    for beside in [
        CompareWith::Written,
        CompareWith::Reference,
        CompareWith::Tier(Some("low".into())),
        CompareWith::Pipeline("lynx".into()),
    ] {
        model.set_compared(Some(beside.clone()));
        model.clock().cut();
        settle(&mut model);
        assert!(model.problem().is_none(), "{beside:?}: {:?}", model.problem());
        let other = texels(model.compared_picture().unwrap());
        assert_eq!((other.desc.size.width, other.desc.size.height), (SIZE.width, SIZE.height));
        let floats = (picture(&model).to_floats(), other.to_floats());
        let mean =
            floats.0.iter().zip(&floats.1).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f32>() / floats.0.len() as f32;
        let limit = if beside == CompareWith::Written || beside == CompareWith::Reference { 0.004 } else { 0.5 };
        assert!(mean < limit, "{beside:?}: {mean}");
        assert!(mean > 0.005 || limit < 0.01 || matches!(beside, CompareWith::Tier(_)), "{beside:?}: {mean}");
    }
}

/// A texture that images are drawn into.
fn target(width: u32, height: u32) -> wgpu::Texture {
    gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn plain(width: u32, height: u32) -> Placement {
    Placement {
        origin: [0.0; 2],
        extent: [width as f32, height as f32],
        gain: 1.0,
        bias: 0.0,
        wipe: 0.0,
        difference: 8.0,
        channel: 4,
        flags: 0,
        slice: 0,
        peak: 1.0,
    }
}

/// An image as the viewer draws it, texel by texel.
fn drawn(image: &wgpu::Texture, placement: Placement) -> Vec<[f32; 4]> {
    let painter = Painter::new(gpu(), wgpu::TextureFormat::Rgba32Float);
    let target = target(image.width(), image.height());
    let view = target.create_view(&Default::default());
    let mut encoder = gpu().encoder();
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    painter.drawn(&Shown { image, other: None, placement }).draw(&mut pass);
    drop(pass);
    gpu().queue.submit([encoder.finish()]);
    texels(&target).to_floats()
}

/// The images of all wires that the run stores, by wire.
fn wires(model: &Model) -> Vec<(String, PortType)> {
    let graph = model.editor().graph().unwrap();
    let outputs = graph.nodes.iter().flat_map(|node| {
        node.kind().outputs().iter().map(move |output| (format!("{}.{}", node.name, output.name), output.ty))
    });
    outputs.collect()
}

#[test]
fn every_transient_can_be_looked_at_in_every_level_and_slice() {
    let mut model = model("tsushima");
    model.inspect_wire(Some(InspectedWire::new("exposed.result")));
    settle(&mut model);
    let (mut images, mut slices, mut levels) = (0, 0, 0);
    let plan = model.inspector().stored().unwrap().plan().unwrap().clone();
    let mut seen = std::collections::BTreeSet::new();
    for (wire, ty) in wires(&model) {
        for (index, image) in model.inspector().images(&wire).into_iter().enumerate() {
            levels += usize::from(ty == PortType::Pyramid && index > 0);
            for slice in 0..image.desc.size.depth {
                model.inspect_wire(Some(InspectedWire { wire: wire.clone(), index, slice }));
                let (inspected, texture) = model.inspected_image().unwrap();
                assert_eq!(inspected.name, image.name);
                let mut placement = plain(texture.width(), texture.height());
                (placement.slice, placement.peak) = (slice, 1e30);
                let shown = drawn(&texture, placement);
                let stored = texels(&texture).to_floats();
                let begin = slice as usize * shown.len();
                for (shown, stored) in shown.iter().zip(&stored[begin..]) {
                    let wanted = [0, 1, 2].map(|channel| stored[channel].max(0.0));
                    let is_same = (0..3).all(|c| (shown[c] - wanted[c]).abs() <= 1e-6 * wanted[c].abs());
                    assert!(is_same, "{} slice {slice}: {shown:?} {stored:?}", image.name);
                }
                slices += usize::from(image.desc.volume);
            }
            images += 1;
            seen.insert(image.name);
        }
    }
    assert!(levels >= 2 && slices >= 128 && images >= 20, "{images} images, {levels} levels, {slices} slices");
    let names = plan.image_names().into_iter().zip(&plan.images);
    let inputs: Vec<&str> = plan.inputs.iter().map(|(name, _)| name.as_str()).collect();
    for (name, image) in names.filter(|(_, image)| image.lifetime.is_some()) {
        let is_given =
            inputs.iter().any(|input| name.starts_with(input)) || matches!(image.origin, Origin::Constant(_));
        assert!(seen.contains(&name) || is_given, "{name}: {:?}", image.origin);
    }
}

#[test]
fn an_image_that_is_looked_at_is_what_the_pipeline_gives_for_that_wire() {
    let mut model = model("tsushima");
    // Without a table, which no plan has for an image inside of it.
    model.set_tier(Some("ultra".into()));
    model.inspect_wire(Some(InspectedWire::new("exposed.result")));
    settle(&mut model);
    model.clock().cut();
    render(&mut model);
    let mut compared = 0;
    for wire in ["exposed.result", "local.result", "lit.result", "vignette.result", "mapped.result", "encoded.result"] {
        model.inspect_wire(Some(InspectedWire::new(wire)));
        let shown = texels(&model.inspected_image().unwrap().1).to_floats();
        let given = given(&mut model, wire);
        let apart =
            shown.iter().zip(&given).flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs() / (1.0 + b[c].abs())));
        let worst = apart.fold(0.0, f32::max);
        // Halves are rounded between nodes that the other plan joins.
        assert!(worst < 0.03, "{wire}: {worst}");
        compared += 1;
    }
    assert_eq!(compared, 6);
}

/// A wire as an output of the same pipeline, rendered by a session.
fn given(model: &mut Model, wire: &str) -> Vec<[f32; 4]> {
    let mut graph = (**model.editor().graph().unwrap()).clone();
    let (node, port) = wire.rsplit_once('.').unwrap();
    let (index, found) = graph.node(node).unwrap();
    let output = found.kind().outputs().iter().position(|output| output.name == port).unwrap();
    let state = found.states[output].unwrap();
    graph.outputs[0].source = Source::Node { node: index, output, previous: 0 };
    graph.outputs[0].state = state;
    let name = graph.outputs[0].name.clone();
    let mut session = Session::new(gpu(), graph, Facts::default(), Options::default());
    let scene = model.frame_images().images.clone();
    let images: Vec<_> = scene
        .iter()
        .map(|(name, view)| {
            let texels = texels(view.texture());
            afterimage_gpu::input_image(gpu(), name, texels.desc, &texels.bytes).unwrap()
        })
        .collect();
    session.render(SIZE, &images, FrameStep::FIRST).unwrap();
    session.output(&name).unwrap().to_floats()
}

#[test]
fn tables_and_values_are_read_as_bytes() {
    let mut model = model("tsushima");
    settle(&mut model);
    for (wire, bytes) in [("counted.result", 256), ("metered.result", 16)] {
        model.inspect_wire(Some(InspectedWire::new(wire)));
        for _ in 0..8 {
            model.clock().step();
            render(&mut model);
            let _ = gpu().wait();
        }
        let read = model.inspected_bytes().unwrap();
        assert!(read.len() >= bytes && read.iter().any(|byte| *byte > 0), "{wire}: {} bytes", read.len());
    }
}

#[test]
fn faults_and_clipped_pixels_are_striped_and_light_is_encoded() {
    let values = [f32::NAN, f32::INFINITY, -0.5, 0.0, 0.18, 2.0];
    let pixels: Vec<[f32; 4]> = values.iter().flat_map(|value| [[*value, *value, *value, 1.0]; 12]).collect();
    let texels = Texels::from_floats(12, values.len() as u32, &pixels);
    let image = afterimage_gpu::upload(&gpu().device, &gpu().queue, &texels).unwrap();
    let mut placement = plain(12, values.len() as u32);
    placement.flags = Flags::FAULTS | Flags::CLIPPING | Flags::IS_LINEAR;
    let shown = drawn(&image, placement);
    let colors = |row: usize| -> std::collections::BTreeSet<[u32; 3]> {
        shown[12 * row..12 * (row + 1)]
            .iter()
            .map(|pixel| [0, 1, 2].map(|c| (pixel[c] * 100.0).round() as u32))
            .collect()
    };
    assert_eq!(colors(0), [[0, 0, 0], [100, 0, 90]].into());
    assert_eq!(colors(1), [[0, 0, 0], [100, 90, 0]].into());
    assert_eq!(colors(2), [[0, 0, 0], [0, 90, 90]].into());
    assert_eq!(colors(3), [[0, 0, 0], [15, 30, 100]].into());
    assert_eq!(colors(4), [[46, 46, 46]].into());
    assert_eq!(colors(5), [[100, 10, 10], [100, 100, 100]].into());
}
