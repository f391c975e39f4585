//! Volumes of a host: how they come in, what is repaired, and what does not fit.

use afterimage::Post;
use afterimage_gpu::wgpu::TextureView;
use afterimage_gpu::{Frame, Gpu, GpuError, Texels, download, upload};
use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{HostImageDesc, HostInputs, PlanError};

use super::camera::depths;
use super::color::light;
use crate::support::gpu::{Picture, Run, SLICES, gpu};
use crate::support::harness::Nodes;
use crate::support::player::Player;

/// Fog that is thicker in each slice, with light that differs from cell to cell: slices one below the other, coarser
/// than the picture.
pub(super) fn fog([width, height]: [u32; 2]) -> Picture {
    let rows = (height / 2).max(1);
    Picture::new((width / 3).max(1), rows * SLICES, |x, y| {
        let slice = (y / rows + 1) as f32 / SLICES as f32;
        let cell = 0.5 + 0.5 * (1.7 * x as f32 + 0.9 * (y % rows) as f32).sin();
        [slice * (1.0 + cell), 0.75 * slice, slice * slice * (2.0 - cell), (-slice * (0.5 + cell)).exp()]
    })
}

const INPUTS: [(&str, &str); 3] = [("in", "Color"), ("depth", "Depth"), ("fog", "Color(volume: true)")];

/// A node that reads the three inputs, with these parameters.
fn node(parameters: &str) -> String {
    format!("\"result\": VolumetricComposite(source: \"in\", depth: \"depth\", volume: \"fog\"{parameters})")
}

fn composite(parameters: &str, pictures: [&Picture; 3]) -> Picture {
    Nodes::new(&node(parameters), &INPUTS).exact(&pictures)
}

fn constant(width: u32, height: u32, pixel: [f32; 4]) -> Picture {
    Picture::new(width, height, |_, _| pixel)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_camera_sees_no_fog_before_the_near_end_and_all_of_it_at_infinity() {
    let scene = constant(7, 1, [8.0, 4.0, 2.0, 0.5]);
    // At the camera, nearly, at the near end, far away, infinitely far, and where nothing was drawn.
    let far = [1e-6, 0.1, 0.5, 1e9, f32::INFINITY, 0.0, -3.0];
    let depth = Picture::new(7, 1, |x, _| [far[x as usize], 0.0, 0.0, 1.0]);
    let volume = Picture::new(1, SLICES, |_, y| [y as f32, 0.5 * y as f32, 0.0, 1.0 - 0.25 * y as f32]);
    let found = composite(", near: 0.5, far: 40.0", [&scene, &depth, &volume]);
    let behind = [8.0 * 0.25 + 3.0, 4.0 * 0.25 + 1.5, 2.0 * 0.25, 0.5];
    for (pixel, wanted) in found.pixels.iter().zip([[8.0, 4.0, 2.0, 0.5]; 3].into_iter().chain([behind; 4])) {
        assert!((0..4).all(|c| (pixel[c] - wanted[c]).abs() < 1e-5), "{pixel:?} instead of {wanted:?}");
    }
}

/// A volume of one texel.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn one_texel_is_a_ramp_of_fog() {
    let gpu = gpu();
    let graph = Nodes::new(&node(", slices: Linear, near: 1.0, far: 5.0"), &INPUTS).graph();
    let far = [1.0, 2.0, 3.0, 5.0];
    let pictures = [[1.0; 4], far].map(|row| Picture::new(4, 1, |x, _| [row[x as usize], 0.0, 0.0, 1.0]));
    let [scene, depth] = pictures.map(|picture| texture(&gpu, &flat(&picture)));
    let volume = texture(&gpu, &slices(&constant(1, 1, [2.0, 1.0, 0.0, 0.25]), 1));
    let found = shown(&gpu, &graph, [&scene, &depth, &volume]).expect("all fit");
    for (pixel, wanted) in found.pixels.iter().zip([1.0, 0.8125 + 0.5, 0.625 + 1.0, 0.25 + 2.0]) {
        assert!((pixel[0] - wanted).abs() < 1e-6, "{pixel:?} instead of {wanted}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_not_finite_in_a_volume_is_repaired_from_its_slice() {
    let size = [24, 12];
    let (scene, depth, clean) = (light(size), depths(size), fog(size));
    let rows = clean.height / SLICES;
    // The least of four in its slice: of each pair of opposite texels the larger.
    let around = |x: u32, y: u32, channel: usize| {
        let number = |index: u32| clean.at(x + index % 3 - 1, y + index / 3 - 1)[channel];
        (0..4).map(|index| number(index).max(number(8 - index))).fold(f32::INFINITY, f32::min)
    };
    let place = (3, rows + 2);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let with = |value: &dyn Fn(usize) -> f32| {
            Picture::new(clean.width, clean.height, |x, y| match (x, y) == place {
                true => std::array::from_fn(
                    |channel| if channel % 2 == 0 { clean.at(x, y)[channel] } else { value(channel) },
                ),
                false => clean.at(x, y),
            })
        };
        let (broken, repaired) = (with(&|_| bad), with(&|channel| around(place.0, place.1, channel)));
        let found = composite(", far: 16.0", [&scene, &depth, &broken]);
        let wanted = composite(", far: 16.0", [&scene, &depth, &repaired]);
        assert_eq!(found.pixels, wanted.pixels, "{bad}");
        assert_ne!(found.pixels, composite(", far: 16.0", [&scene, &depth, &clean]).pixels, "the texel is seen");
    }
    // Without a neighbor that is finite, there is no light, and none passes.
    let lost = composite(", far: 16.0", [&scene, &depth, &constant(3, 2 * SLICES, [f32::NAN; 4])]);
    assert!(lost.pixels.iter().flatten().all(|number| number.is_finite()));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn no_share_of_the_fog_and_no_volume_skip_the_node() {
    let size = [12, 8];
    let (scene, depth, volume) = (light(size), depths(size), fog(size));
    let off = node(", amount: 0.0");
    let off = Nodes::new(&off, &INPUTS);
    let plan = Run::new(&off.graph()).plan(&gpu(), &off.named(&[&scene, &depth, &volume]));
    assert!(plan.savings.skipped.iter().any(|skipped| skipped.node == "result"), "{:?}", plan.savings.skipped);
    let inputs = [INPUTS[0], INPUTS[1], ("fog", "Color(volume: true, optional: true)")];
    let text = node("");
    let graph = Nodes::new(&text, &inputs).graph();
    let plan = Run::new(&graph).plan(&gpu(), &[("in", &scene), ("depth", &depth)]);
    assert!(plan.savings.skipped.iter().any(|skipped| skipped.node == "result"), "{:?}", plan.savings.skipped);
}

/// The size of the frame is that of the images, wherever the volume stands, and the device filters a copy that is
/// finite; where the host promises that the volume is, there is none.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_volume_says_nothing_of_the_frame_and_is_copied_unless_it_is_finite() {
    let gpu = gpu();
    let text = node("");
    let graph = Nodes::new(&text, &[INPUTS[2], INPUTS[0], INPUTS[1]]).graph();
    let size = [24, 12];
    let half = |picture: &Picture| Texels::from_floats_as_half(picture.width, picture.height, &picture.pixels);
    let scene = texture(&gpu, &half(&light(size)));
    let depth = texture(&gpu, &half(&depths(size)));
    let volume = texture(&gpu, &slices_of(half(&fog(size)), SLICES));
    let frame = [("in", &scene), ("depth", &depth), ("fog", &volume)];
    let passes = |is_finite: bool| {
        let mut post = Post::with_executor(gpu.executor(), graph.clone());
        if is_finite {
            post.assume_finite("fog");
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        post.encode(&mut encoder, &Frame { inputs: &frame, ..Frame::default() }).expect("all fit");
        let plan = post.plan().expect("it runs").clone();
        assert_eq!(plan.image(plan.outputs[0].image).desc.size, Size::new(24, 12));
        plan.work().map(|pass| pass.label.clone()).collect::<Vec<_>>()
    };
    assert_eq!(passes(false).len(), 2, "{:?}", passes(false));
    assert!(passes(false).contains(&"sanitize".to_owned()));
    assert_eq!(passes(true).len(), 1, "{:?}", passes(true));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_no_volume_or_another_one_is_an_error() {
    let gpu = gpu();
    let text = node("");
    let graph = Nodes::new(&text, &INPUTS).graph();
    let picture = constant(4, 4, [1.0; 4]);
    let [image, volume] = [flat(&picture), slices(&picture, 4)].map(|texels| texture(&gpu, &texels));
    let error = shown(&gpu, &graph, [&image, &image, &image]).expect_err("no volume");
    assert!(error.contains("it is no 3-D texture, and the pipeline requires a volume"), "{error}");
    let error = shown(&gpu, &graph, [&volume, &image, &volume]).expect_err("a volume");
    assert!(error.contains("it is a 3-D texture: declare the input as `volume: true`"), "{error}");
    drop(gpu);
    let planned = |input: &str, volume: bool| {
        let float = |desc: ImageDesc| HostImageDesc { desc: desc.format(Format::Rgba32Float), finite: false };
        let desc = ImageDesc { volume, ..ImageDesc::new(Size::volume(4, 1, 1)) };
        let mut inputs: std::collections::BTreeMap<_, _> =
            ["in", "depth"].map(|name| (name.to_owned(), float(ImageDesc::new(Size::new(4, 4))))).into();
        inputs.insert("fog".into(), float(ImageDesc::volume(Size::volume(4, 4, 2))));
        inputs.insert(input.into(), float(desc));
        let given = HostInputs { inputs, ..HostInputs::none(Size::new(4, 4)) };
        let gpu = crate::support::gpu::gpu();
        Run::new(&graph).session(&gpu).post().plan_for(given)
    };
    let wrong = |input: &str, given| Some(PlanError::WrongDimension { input: input.into(), given });
    assert_eq!(planned("fog", false).err(), wrong("fog", false));
    assert_eq!(planned("in", true).err(), wrong("in", true));
    // A plan for one slice does not take a texture of four.
    let plan = planned("fog", true).expect("a volume of one slice");
    let mut player = Player::new();
    player.executor.load(plan).expect("it fits the device");
    let frame = [("in", &image), ("depth", &image), ("fog", &volume)];
    let error = player.run(&Frame { inputs: &frame, ..Frame::default() }).expect_err("it has four slices");
    assert!(matches!(error, GpuError::UnfitImage { .. }), "{error}");
    assert!(error.to_string().contains("it has 4 slices, and the plan is made for 1"), "{error}");
}

/// The errors of a pipeline with these inputs and nodes.
fn errors(inputs: &str, nodes: &str) -> String {
    let text = format!("Pipeline(inputs: {{ {inputs} }}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"result\" }})");
    let document = parse("test.ron", &text);
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let checked = document.and_then(|document| check(&document, &registry, &CheckOptions::default()));
    checked.map(drop).expect_err("it is wrong").to_string()
}

#[test]
fn an_input_that_cannot_be_a_volume_is_an_error_with_its_place() {
    let composite = node("");
    let plain = "\"in\": Color, \"depth\": Depth, \"fog\": Color";
    let found = errors(plain, &composite);
    assert!(
        found.contains("`volume` of `VolumetricComposite` accepts a Volume, but the input `fog` is an Image"),
        "{found}"
    );
    let found = errors(&plain.replace("Depth", "Depth(volume: true)"), &composite);
    assert!(
        found.contains("`depth` of `VolumetricComposite` accepts an Image, but the input `depth` is a Volume"),
        "{found}"
    );
    let found = errors(&format!("{plain}(volume: 64)"), &composite);
    assert!(found.contains("`volume` is `true` or `false`") && found.contains("^^ this is a whole number"), "{found}");
    let found = errors(&format!("{plain}(volume: true, scale: 2.0)"), &composite);
    assert!(found.contains("input `fog` is a volume and has a scale") && found.contains("^^^^^"), "{found}");
    let found = errors(&format!("{plain}(volume: true, multisampled: true)"), &composite);
    assert!(found.contains("input `fog` is multisampled and a volume"), "{found}");
    let mapped = "\"result\": LocalToneMap(source: \"in\", grid: \"fog\")";
    let found = errors("\"in\": Exposed, \"fog\": Data(volume: true)", mapped);
    assert!(found.contains("accepts `bilateral-grid`, but the input `fog` is a volume of the host"), "{found}");
}

/// The output of a pipeline over a host's textures, in 32 bits.
fn shown(gpu: &Gpu, graph: &Graph, [scene, depth, fog]: [&TextureView; 3]) -> Result<Picture, String> {
    let mut post = Post::with_executor(gpu.executor(), graph.clone());
    post.set_options(afterimage_plan::Options { exact: true, ..Default::default() });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = Frame { inputs: &[("in", scene), ("depth", depth), ("fog", fog)], ..Frame::default() };
    post.encode(&mut encoder, &frame).map_err(|error| error.to_string())?;
    gpu.queue.submit([encoder.finish()]);
    let texels = post.output("out").and_then(|texture| download(&gpu.device, &gpu.queue, texture));
    Ok(Picture::of(&texels.map_err(|error| error.to_string())?))
}

fn flat(picture: &Picture) -> Texels {
    Texels::from_floats(picture.width, picture.height, &picture.pixels)
}

fn slices(picture: &Picture, count: u32) -> Texels {
    slices_of(flat(picture), count)
}

fn slices_of(texels: Texels, count: u32) -> Texels {
    let Size { width, height, .. } = texels.desc.size;
    let desc = ImageDesc::volume(Size::volume(width, height / count, count)).format(texels.desc.format);
    Texels { desc, ..texels }
}

fn texture(gpu: &Gpu, texels: &Texels) -> TextureView {
    upload(&gpu.device, &gpu.queue, texels).expect("the device is there").create_view(&Default::default())
}
