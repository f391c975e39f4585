//! Figures of plans, computed again from what they are defined by: bytes, names, state, and the uniform buffer.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_generators::Recipe;
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{BufferLife, ImageId, Origin, Resource};
use afterimage_plan::{
    Alias, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, StateContent, When, plan,
};

use super::fusion::planned_at;
use super::support::{FRAME, all_formats, built_in, plan_everything};

/// A device that pads unlike others.
fn padded(desc: &ImageDesc) -> Requirement {
    Requirement { bytes: desc.bytes() + 1000, alignment: 8 }
}

fn planned(graph: &Graph, options: Options) -> Plan {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME), finite: true };
    let request = PlanRequest {
        given: HostInputs::all(FRAME, &graph.inputs, image),
        facts: Facts::default(),
        caps: all_formats(),
        options,
        dynamic: Default::default(),
        requirement: &padded,
    };
    plan(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// Plans of random graphs, and of pipelines with tables, meters, blocks and memories.
fn plans(options: Options) -> Vec<Plan> {
    let graphs = (0..20).map(|seed| Recipe { seed, nodes: 30, histories: 4, off: 4 }.graph());
    let names = ["tsushima.ron", "cinematic.ron", "exposure.ron", "lynx.ron", "cookbook.ron"];
    graphs.chain(names.map(built_in)).map(|graph| planned(&graph, options)).collect()
}

fn bytes(plan: &Plan, image: ImageId) -> u64 {
    padded(&plan.image(image).desc).bytes
}

#[test]
fn the_memory_that_is_kept_is_that_of_outputs_histories_and_tables() {
    let (mut rings, mut tables) = (0, 0);
    for plan in plans(Options::default()) {
        // How many textures each image has: a history of n frames has the present one, too.
        let mut textures: BTreeMap<ImageId, u64> = plan.outputs.iter().map(|output| (output.image, 1)).collect();
        for (past, id) in plan.images.iter().zip(0..) {
            match past.origin {
                Origin::Previous { of, frames } if plan.image(of).origin == Origin::Transient => {
                    let most = textures.get(&of).copied().unwrap_or(0).max(u64::from(frames) + 1);
                    textures.insert(of, most);
                    rings += 1;
                }
                Origin::Previous { of, .. } => drop(textures.insert(of, 1)),
                Origin::Retained => {
                    textures.insert(ImageId(id), 1);
                    tables += 1;
                }
                _ => {}
            }
        }
        let kept: u64 = textures.iter().map(|(image, count)| count * bytes(&plan, *image)).sum();
        assert_eq!(plan.memory.kept, kept, "{}", plan.to_text());
        for alias in [Alias::None, Alias::Pool, Alias::Placed] {
            let memory = &plan.memory;
            let expected = [memory.unshared, memory.pooled, memory.placed][alias as usize];
            assert_eq!(memory.bytes(alias), expected);
        }
    }
    assert!(rings > 20 && tables > 2, "{rings} histories, {tables} tables");
}

/// What fusion removes is counted as if it were stored.
#[test]
fn nodes_describe_the_same_bytes_whether_they_are_fused_or_not() {
    let options = Options { row_downsample: When::Never, ..Options::default() };
    for seed in 0..30 {
        let graph = Recipe { seed, nodes: 30, histories: 2, off: 4 }.graph();
        let (fused, unfused) = (planned(&graph, options), planned(&graph, Options { fuse: false, ..options }));
        assert_eq!(unfused.memory.unaliased, unfused.memory.unshared);
        assert_eq!(fused.memory.unaliased, unfused.memory.unaliased, "{}", fused.to_text());
    }
}

#[test]
fn each_image_of_a_pass_is_moved_once() {
    for plan in plans(Options::default()) {
        let mut all = 0;
        for (at, pass) in plan.work().enumerate() {
            let images: BTreeSet<ImageId> =
                pass.reads().into_iter().chain(pass.writes()).filter_map(Resource::image).collect();
            let moved: u64 = images.iter().map(|image| plan.image(*image).desc.bytes()).sum();
            assert_eq!(plan.bytes_moved_by(at), moved, "{}", pass.label);
            let mut written = pass.writes().into_iter().filter_map(Resource::image);
            let fills = written.any(|image| plan.image(image).origin == Origin::Retained);
            assert_eq!(plan.runs_on_change(at), fills, "{}", pass.label);
            all += if fills { 0 } else { moved };
        }
        assert_eq!(plan.bytes_moved(), all);
        let text = plan.to_text();
        assert!(text.contains(&format!("{:.1} MiB moved a frame", all as f64 / f64::from(1 << 20))), "{text}");
    }
}

#[test]
fn of_an_image_with_a_stride_the_pixels_that_are_read_are_moved() {
    let nodes = r#""counted": Histogram(source: "in", step: 2), "metered": AutoExposure(histogram: "counted"),
        "exposed": Exposure(source: "in", meter: "metered")"#;
    let plan = planned_at(Size::new(3840, 2160), nodes, r#""exposed": "exposed""#, Options::default());
    let at = plan.work().position(|pass| pass.label == "histogram").unwrap();
    // An image of one texel is bound in the place of `albedo` and of `mask`.
    assert_eq!(plan.bytes_moved_by(at), 1920 * 1080 * 8 + 2 * 8 / 4);
    assert_eq!(plan.bytes_moved_by(plan.passes.len() - 1), 2 * 3840 * 2160 * 8);
}

#[test]
fn names_are_labels_and_those_after_the_first_are_numbered() {
    for plan in plans(Options { fuse: false, ..Options::default() }) {
        let labels: Vec<String> = plan.images.iter().map(|image| image.label.clone()).collect();
        let passes: Vec<String> = plan.work().map(|pass| format!("{}: {}", pass.nodes.join("+"), pass.label)).collect();
        let buffers: Vec<String> = plan.buffers.iter().map(|buffer| buffer.label.clone()).collect();
        for (labels, names) in
            [(labels, plan.image_names()), (passes, plan.pass_names()), (buffers, plan.buffer_names())]
        {
            assert_eq!(labels.len(), names.len());
            for (at, (label, name)) in labels.iter().zip(&names).enumerate() {
                let before = labels[..at].iter().filter(|other| *other == label).count();
                let number = if before == 0 { String::new() } else { format!("#{}", before + 1) };
                assert_eq!(*name, format!("{label}{number}"));
            }
        }
    }
}

/// All that an image or a buffer of a frame is made from, pass by pass.
fn made_from(plan: &Plan, what: Resource) -> BTreeSet<Resource> {
    let (mut found, mut open) = (BTreeSet::from([what]), vec![what]);
    while let Some(next) = open.pop() {
        let outlives = |resource: Resource| match resource {
            Resource::Buffer(buffer) => plan.buffers[buffer.0 as usize].life == BufferLife::Persistent,
            Resource::Image(_) => false,
        };
        if outlives(next) {
            continue;
        }
        for pass in plan.work().filter(|pass| pass.writes().contains(&next)) {
            open.extend(pass.reads().into_iter().filter(|read| found.insert(*read)));
        }
    }
    found
}

#[test]
fn the_state_is_what_outlives_frames_and_says_how_far_it_reaches_back() {
    let mut reaches = [0, 0];
    for plan in plans(Options::default()) {
        let mut expected = BTreeMap::new();
        for (buffer, name) in plan.buffers.iter().zip(plan.buffer_names()) {
            if buffer.life == BufferLife::Persistent {
                expected.insert(name, (format!("{} bytes", buffer.bytes), None));
            }
        }
        let names = plan.image_names();
        for image in plan.images.iter().filter(|image| image.lifetime.is_some()) {
            let Origin::Previous { of, .. } = image.origin else { continue };
            let pasts =
                plan.images.iter().filter(|past| past.lifetime.is_some()).filter_map(|past| match past.origin {
                    Origin::Previous { of: other, frames } if other == of => Some(frames),
                    _ => None,
                });
            let frames = pasts.max().expect("it is one of them");
            let ImageDesc { size, format, .. } = plan.image(of).desc;
            let many = if frames == 1 { "frame" } else { "frames" };
            let described = format!("{size} {}, {frames} {many}", format.name());
            let is_past = |resource: &Resource| {
                let image = resource.image().map(|image| plan.image(image));
                image.is_some_and(|image| matches!(image.origin, Origin::Previous { .. }))
            };
            let own = made_from(&plan, Resource::Image(of)).iter().any(is_past);
            reaches[usize::from(own)] += 1;
            expected.insert(names[of.0 as usize].clone(), (described, if own { None } else { Some(frames) }));
        }
        let found: BTreeMap<_, _> =
            plan.state().into_iter().map(|item| (item.name.clone(), (item.described(), item.reach))).collect();
        assert_eq!(found, expected, "{}", plan.to_text());
        let is_sorted = plan.state().is_sorted_by_key(|item| match item.content {
            StateContent::Buffer { buffer, .. } => (0, buffer.0),
            StateContent::History { image, .. } => (1, image.0),
        });
        assert!(is_sorted, "buffers come first");
        let text = plan.to_text();
        for (name, (described, reach)) in &expected {
            let words = match reach {
                Some(1) => "made from 1 frame".to_owned(),
                Some(frames) => format!("made from {frames} frames"),
                None => "made from all frames before".to_owned(),
            };
            let is_row =
                |line: &str| [name, described].iter().all(|part| line.contains(*part)) && line.ends_with(&words);
            assert!(text.lines().any(is_row), "{name} {described} {words}: {text}");
        }
    }
    assert!(reaches.iter().all(|count| *count > 5), "{reaches:?}");
}

/// Each number lies where its pass looks for it, aligned, and nothing lies behind.
#[test]
fn the_uniform_buffer_has_the_numbers_of_every_kernel_at_its_place() {
    let everything = ["cinematic.ron", "lynx.ron"]
        .map(|name| plan_everything(&built_in(name), Format::Rgba16Float, all_formats(), Options::default()));
    for plan in plans(Options::default()).into_iter().chain(everything) {
        let buffer = plan.uniform_buffer();
        let mut end = 0;
        for planned in &plan.passes {
            let block = &planned.uniform;
            assert_eq!((block.offset, block.offset % 256, block.extent_offset % 256), (end, 0, 0));
            let mut place = block.offset as usize;
            for kernel in &planned.pass.kernels {
                assert_eq!(buffer[place..][..kernel.uniform.len()], kernel.uniform[..], "{}", planned.pass.label);
                place = (place + kernel.uniform.len()).next_multiple_of(16);
            }
            assert_eq!(place as u64, block.offset + block.bytes.len() as u64);
            assert!(block.extent_offset >= place as u64 && block.extent_offset - (place as u64) < 256);
            let size = planned.pass.writes().into_iter().find_map(Resource::image);
            let Size { width, height, .. } = size.map_or(Size::new(1, 1), |image| plan.image(image).desc.size);
            let floats: Vec<f32> = buffer[block.extent_offset as usize..][..16]
                .chunks(4)
                .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four bytes")))
                .collect();
            if planned.pass.drawing().is_none() {
                assert_eq!(floats, [width as f32, height as f32, 0.0, 0.0], "{}", planned.pass.label);
            }
            end = block.extent_offset + 256;
        }
        for planned in &plan.blocks {
            assert_eq!(planned.offset, end, "blocks lie behind the passes");
            assert_eq!(plan.block(planned.id).name, planned.name);
            end = planned.offset + (planned.block.bytes() as u64).next_multiple_of(256);
        }
        let last = plan
            .blocks
            .last()
            .map_or(0, |planned| (planned.block.bytes() as u64).next_multiple_of(256) - planned.block.bytes() as u64);
        assert_eq!(buffer.len() as u64, end - last);
    }
}

#[test]
fn an_output_is_found_by_its_name_and_the_first_without_one() {
    let plan = planned(&built_in("cinematic.ron"), Options::default());
    for output in &plan.outputs {
        assert_eq!(plan.output(Some(&output.name)), Some(output));
    }
    assert_eq!((plan.output(None), plan.output(Some("nothing"))), (plan.outputs.first(), None));
}
