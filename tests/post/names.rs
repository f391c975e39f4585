//! Names of a host that the pipeline does not know, and images that belong to other names.

use afterimage::Post;
use afterimage::host::PostError;
use afterimage_gpu::{Frame, Gpu, wgpu};
use afterimage_graph::image::Size;

use super::{Host, scene};
use crate::support::gpu::{Shared, changed, gpu, graph};

const LOOK: &str = r#"Pipeline(
    inputs: {
        "shade": Albedo(optional: true),
        "scene": Color,
        "depth": Depth,
        "motion": Motion(optional: true),
    },
    nodes: {
        "bins": Histogram(source: "scene", albedo: "shade"),
        "metered": AutoExposure(histogram: "bins"),
        "blurred": MotionBlur(source: "scene", depth: "depth", motion: "motion"),
        "exposed": Exposure(source: "blurred", meter: "metered", when: "lamps"),
    },
    outputs: { "display": "exposed" },
)"#;

fn post() -> (Shared, Post) {
    let gpu = gpu();
    let post = Post::new(&gpu, graph(LOOK));
    (gpu, post)
}

fn image(gpu: &Gpu, format: wgpu::TextureFormat) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 96, height: 54, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn encode(gpu: &Gpu, post: &mut Post, inputs: &[(&str, &wgpu::TextureView)]) -> Result<(), PostError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recorded = post.encode(&mut encoder, &Frame { inputs, ..Frame::default() });
    gpu.queue.submit([encoder.finish()]);
    recorded
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_misspelled_input_is_named_with_the_one_that_is_meant() {
    let (gpu, mut post) = post();
    let (light, depth) = (scene(&gpu, Size::new(96, 54)), image(&gpu, wgpu::TextureFormat::R32Float));
    let error = encode(&gpu, &mut post, &[("scene", &light), ("dept", &depth)]).unwrap_err().to_string();
    let wanted = "the pipeline needs an image for its input `depth`; the frame has `dept`, which the pipeline does not \
                  know";
    assert_eq!(error, wanted);
    // An optional one is no error.
    let inputs = &[("scene", &light), ("depth", &depth), ("motoin", &light)];
    encode(&gpu, &mut post, inputs).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(post.warnings(), ["the pipeline has no image input `motoin`: did you mean `motion`?"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn facts_and_watches_that_nothing_knows_are_warnings() {
    let (gpu, mut post) = post();
    let (light, depth) = (scene(&gpu, Size::new(96, 54)), image(&gpu, wgpu::TextureFormat::R32Float));
    let inputs = &[("scene", &light), ("depth", &depth)];
    post.set_fact("lamps", true);
    post.watch("bins.result");
    encode(&gpu, &mut post, inputs).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(post.warnings(), [] as [&str; 0]);
    let wanted = [
        "no condition of the pipeline tests the fact `lampz`: did you mean `lamps`?",
        "the pipeline has no table or value `metred.result`: did you mean `metered.result`?",
    ];
    // Each is noticed in the next frame.
    post.set_fact("lampz", true);
    encode(&gpu, &mut post, inputs).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(post.warnings(), &wanted[..1]);
    post.watch("metred.result");
    encode(&gpu, &mut post, inputs).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(post.warnings(), wanted);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_depth_that_is_given_as_the_motion_is_an_error() {
    let (gpu, mut post) = post();
    let light = scene(&gpu, Size::new(96, 54));
    let [depth, motion] =
        [wgpu::TextureFormat::Depth32Float, wgpu::TextureFormat::Rg16Float].map(|format| image(&gpu, format));
    encode(&gpu, &mut post, &[("scene", &light), ("depth", &depth), ("motion", &motion)])
        .unwrap_or_else(|error| panic!("{error}"));
    let exchanged = &[("scene", &light), ("depth", &motion), ("motion", &depth)];
    let error = encode(&gpu, &mut post, exchanged).unwrap_err().to_string();
    let wanted = "the image given for `motion` cannot be used: its format, Depth32Float, has 1 of the 2 channels that \
                  the pipeline reads; does it belong to another input?";
    assert_eq!(error, wanted);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_missing_image_is_named_and_no_optional_one() {
    let (gpu, mut post) = post();
    let depth = image(&gpu, wgpu::TextureFormat::R32Float);
    for inputs in [&[][..], &[("depth", &depth)]] {
        let error = encode(&gpu, &mut post, inputs).unwrap_err().to_string();
        assert_eq!(error, "the pipeline needs an image for its input `scene`");
    }
}

/// Numbers of handles would be those of other parameters in another pipeline.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_handle_of_another_pipeline_is_an_error() {
    let [mut one, mut other] = [(); 2].map(|()| Host::new(changed("lynx.ron", None, &[])));
    let strength = one.post.parameter::<f32>("lit.strength").unwrap();
    let stops = other.post.parameter::<f32>("exposed.stops").unwrap();
    let wanted =
        |name: &str| format!("the handle of `{name}` is not of this pipeline: ask it for the parameter by its name");
    assert_eq!(one.post.set(stops, 1.0).unwrap_err().to_string(), wanted("exposed.stops"));
    assert_eq!(other.post.unset(strength.control()).unwrap_err().to_string(), wanted("lit.strength"));
    assert_eq!(one.post.value(stops.control()), None);
    // A view has the handles that were made before it.
    let mut view = one.post.clone_for_view();
    view.set(strength, 0.5).unwrap();
    let knee = view.parameter::<f32>("bright.knee").unwrap();
    assert_eq!(one.post.set(knee, 0.5).unwrap_err().to_string(), wanted("bright.knee"));
    drop(view);
    let error = one.post.set(knee, 0.5).unwrap_err().to_string();
    assert_eq!(error, "the handle is not of this pipeline: ask it for the parameter by its name");
    let watch = one.post.watch("meter.result");
    assert!(one.post.reading(watch).unwrap().is_none() && other.post.reading(watch).is_err());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn handles_and_facts_that_a_new_graph_takes_otherwise_are_named() {
    let (gpu, mut post) = post();
    let (light, depth) = (scene(&gpu, Size::new(96, 54)), image(&gpu, wgpu::TextureFormat::R32Float));
    let inputs = &[("scene", &light), ("depth", &depth)];
    let stops = post.parameter::<f32>("exposed.stops").unwrap();
    post.set_fact("lamps", true);
    encode(&gpu, &mut post, inputs).unwrap();
    assert_eq!(post.warnings(), [] as [&str; 0]);
    // The name is now that of a whole number, of a node that is gone, of a fact that is a number.
    let text = LOOK.replace(
        r#""exposed": Exposure(source: "blurred", meter: "metered", when: "lamps")"#,
        r#""exposed": Downsample(source: "blurred", levels: 2, when: "lamps > 3")"#,
    );
    post.change(graph(&text.replace(r#"outputs: { "display": "exposed" }"#, r#"outputs: { "display": "blurred" }"#)));
    encode(&gpu, &mut post, inputs).unwrap();
    post.finish_changes().unwrap();
    encode(&gpu, &mut post, inputs).unwrap();
    let wanted = [
        "the pipeline takes the fact `lamps` as a number, not as true or false",
        "a handle of `exposed.stops` is left over: the pipeline has no such parameter",
    ];
    assert_eq!(post.warnings()[..2], wanted);
    // Its value waits for a graph that has it again.
    post.set(stops, 1.0).unwrap();
    post.set_fact("lamps", f64::NAN);
    encode(&gpu, &mut post, inputs).unwrap();
    assert_eq!(post.warnings()[0], "the fact `lamps` is not a number");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_name_of_a_node_or_of_an_output_in_the_wrong_place_is_told_as_such() {
    let (gpu, mut post) = post();
    assert_eq!(post.output("display").unwrap_err().to_string(), "no plan is loaded");
    let (light, depth) = (scene(&gpu, Size::new(96, 54)), image(&gpu, wgpu::TextureFormat::R32Float));
    let error = post.control("metered").unwrap_err().to_string();
    assert!(error.starts_with("`metered` is a node; it has `metered."), "{error}");
    let error = post.control("scene.stops").unwrap_err().to_string();
    assert_eq!(error, "no node is called `scene`: that is an image input");
    post.watch("metered");
    post.watch("display");
    encode(&gpu, &mut post, &[("scene", &light), ("depth", &depth), ("display", &light)]).unwrap();
    let wanted = [
        "the pipeline has no image input `display`: that is an output",
        "`metered` is a node: watch `metered.result` and `metered.range`",
        "the pipeline has no table or value `display`: that is an output",
    ];
    assert_eq!(post.warnings(), wanted);
    let error = post.output("displai").unwrap_err().to_string();
    assert_eq!(error, "the plan has no output `displai`; it has `display`");
    assert!(post.output("display").is_ok());
}
