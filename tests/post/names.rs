//! Names of a host that the pipeline does not know, and images that belong to other names.

use afterimage_gpu::{Frame, Gpu, Post, PostError, wgpu};
use afterimage_graph::image::Size;

use super::scene;
use crate::support::gpu::{Shared, gpu, graph};

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
    let post = Post::new(&gpu.adapter, &gpu.device, &gpu.queue, graph(LOOK));
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
    post.set_fact("lampz", true);
    post.watch("metred.result");
    encode(&gpu, &mut post, inputs).unwrap_or_else(|error| panic!("{error}"));
    let wanted = [
        "no condition of the pipeline tests the fact `lampz`: did you mean `lamps`?",
        "the pipeline has no table or value `metred.result`: did you mean `metered.result`?",
    ];
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
