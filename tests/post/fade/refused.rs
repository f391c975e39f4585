//! Changes that cannot be faded come in at once, and the reason can be read.

use afterimage::Post;
use afterimage_gpu::{Frame, HostDraw, wgpu};
use afterimage_graph::image::Size;
use afterimage_graph::node::DepthTest;
use afterimage_graph::prelude::*;

use super::{BGRA, FRAMES, Host, LOOK, target};
use crate::support::gpu::{gpu, graph_with};

/// A host that fades, after a first frame.
fn host(text: &str) -> Host {
    let mut host = Host::new(text);
    host.post.set_fade(FRAMES);
    host.shown();
    assert_eq!(host.post.fade_skip_reason(), None);
    host
}

/// Two frames, of which the second one has the other plan.
fn change(host: &mut Host) {
    host.night(true);
    let before = host.post.plan().unwrap().hash();
    host.shown();
    host.shown();
    assert_ne!(before, host.post.plan().unwrap().hash(), "another plan comes in");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn plans_with_several_outputs_and_an_output_that_a_pass_reads() {
    let several = LOOK.replace(r#""display": "display" }"#, r#""display": "display", "more": "trail" }"#);
    let read = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "bins": Histogram(source: "trail@previous"),
            "meter": AutoExposure(histogram: "bins"),
            "exposed": Exposure(source: "scene", meter: "meter"),
            "shown": Gaussian(source: "exposed", sigma: 3.0),
            "gray": Saturation(source: "shown", amount: 0.0, when: "night"),
            "trail": Composite(base: "shown", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
        },
        outputs: { "display": "gray" },
    )"#;
    for (text, format, why) in [
        (several.as_str(), BGRA, "the plans do not have one output each, of the same name and size"),
        (read, wgpu::TextureFormat::Rgba16Float, "a pass reads the output"),
    ] {
        let mut host = Host::new(text);
        host.show_in(super::SIZE, format);
        host.post.set_fade(FRAMES);
        let view = host.view.clone();
        for frame in 0..3 {
            host.night(frame > 0);
            host.encode(&[("display", &view)], false).unwrap();
        }
        assert!(host.missed(why), "{:?}", host.post.fade_skip_reason());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_host_that_gives_no_view_or_one_that_cannot_be_drawn_to() {
    let mut host = Host::new(LOOK);
    host.post.set_fade(FRAMES);
    let texture = host.gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: host.target.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    for (number, outputs) in [&[][..], &[("display", &view)]].into_iter().enumerate() {
        host.night(number == 1);
        for _ in 0..3 {
            host.encode(outputs, false).unwrap();
        }
        host.night(number == 0);
        for _ in 0..2 {
            host.encode(outputs, false).unwrap();
        }
        assert!(host.missed("gives no view"), "{:?}", host.post.fade_skip_reason());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_that_resets_or_has_other_images() {
    let mut host = host(LOOK);
    host.night(true);
    host.shown();
    host.codes(true);
    assert!(host.missed("does not follow"));
    let size = Size::new(64, 40);
    host.scenes = host.scenes_of(size);
    host.show_in(size, BGRA);
    host.shown();
    assert!(host.missed("have changed"));
    host.night(false);
    host.post.finish_changes().unwrap();
    assert!(host.missed("has waited"));
    change(&mut host);
    assert!(host.post.is_fading() && host.post.fade_skip_reason().is_none());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fade_that_is_set_late_or_taken_back() {
    let mut host = host(LOOK);
    host.post.set_fade(0);
    host.night(true);
    host.shown();
    host.post.set_fade(FRAMES);
    host.shown();
    assert!(host.missed("after the plan was begun"), "{:?}", host.post.fade_skip_reason());
    host.night(false);
    host.shown();
    host.post.set_fade(0);
    host.shown();
    assert!(!host.post.is_fading() && host.post.fade_skip_reason().is_none());
}

/// A second view has the same fade, and none of the first one's changes.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn another_view_fades_by_itself() {
    let mut host = host(LOOK);
    change(&mut host);
    let mut other = Host { post: host.post.clone_for_view(), ..Host::new(LOOK) };
    assert!(host.post.is_fading() && !other.post.is_fading());
    other.shown();
    other.night(false);
    other.shown();
    other.shown();
    assert!(other.post.is_fading());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn plans_that_the_host_draws_into() {
    let text = r#"Pipeline(
        inputs: {},
        nodes: { "frame": Draw(), "lit": Exposure(source: "frame", stops: 1.0, when: "night") },
        outputs: { "display": "lit" },
    )"#;
    let gpu = gpu();
    let mut post = Post::new(&gpu, graph_with(text, afterimage_nodes::HOST));
    post.set_task_pool(std::sync::Arc::new(|task| task()));
    post.set_fade(FRAMES);
    let view = target(&gpu, super::SIZE, wgpu::TextureFormat::Rgba16Float).create_view(&Default::default());
    for frame in 0..3 {
        post.set_fact("night", frame > 0);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let draws = &mut [HostDraw { node: "frame", fill: &mut |_| {} }];
        post.encode_drawing(&mut encoder, &Frame { outputs: &[("display", &view)], ..Frame::default() }, draws)
            .unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
    }
    assert_eq!(
        (post.fade_skip_reason(), post.is_fading()),
        (Some("the host draws into images of the pipeline"), false)
    );
}

static PICK: Shader = Shader::new(
    "past_depth.wgsl",
    "fn past_depth(depth: texture_2d<f32>, at: Point) -> vec4f { return vec4f(texel(depth, at.pixel).r); }",
);

node_kind! {
    /// Clears a depth.
    pub struct ClearedDepth {}

    const OUTPUTS: &'static [Output] =
        &[Output::image("depth", OutputState::Always(ColorState::Data), "The depth.").or(Fallback::Absent)];
}

impl Node for ClearedDepth {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size).format(Format::Depth32Float);
        let depth = pass.output("depth", desc);
        pass.clear("clear").depth(depth, DepthTest::default()).record();
    }
}

node_kind! {
    /// Shows a depth as light.
    pub struct PastDepth {}

    const INPUTS: &'static [Input] = &[Input::image("depth", "The depth.").accepts(&[ColorState::Data])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Scene), "The light.").or(Fallback::Absent)];
}

impl Node for PastDepth {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(pass.frame_size);
        pass.function(&PICK, "past_depth").write("result", desc);
    }
}

/// Our depths have no usage to be copied to, so the old plan could not go on with what a frame before has left.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn plans_whose_history_is_a_depth() {
    let text = r#"Pipeline(
        inputs: {},
        nodes: {
            "now": ClearedDepth(),
            "past": PastDepth(depth: "now.depth@previous"),
            "lit": Exposure(source: "past", stops: 1.0, when: "night"),
        },
        outputs: { "display": "lit" },
    )"#;
    let kinds = [NodeKind::of::<ClearedDepth>(), NodeKind::of::<PastDepth>()];
    let mut host = Host::of(graph_with(text, &kinds));
    host.post.set_fade(FRAMES);
    let light = |host: &mut Host| host.shown()[0];
    let before = [light(&mut host), light(&mut host)];
    // A history begins with zeros; then it has the depth that the frame before has cleared, 1.
    assert_eq!(before, [0, 255]);
    change(&mut host);
    assert!(host.missed("depth or multisampled"), "{:?}", host.post.fade_skip_reason());
    // The new plan goes on with it.
    assert_eq!(light(&mut host), 255);
}
