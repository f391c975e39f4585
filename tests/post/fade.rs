//! Cross-fades between two plans. Each frame of a fade is compared with a mix, in f64, of the frames of two other hosts:
//! one that never changes, and one that changes without a fade.

mod ends;
mod refused;

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::PostError;
use afterimage_gpu::{Frame, FrameKind, Rectangle, Texels, upload, wgpu};
use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;

use crate::support::gpu::{Picture, Shared, gpu, graph, texture_bytes};
use crate::support::layer;

const SIZE: Size = Size { width: 96, height: 54, depth: 1 };
const FRAMES: u16 = 4;
/// What a frame of a fade may differ from the mix of codes: half a code for rounding, and what f32 adds.
const MAX_OFF: f64 = 0.501;

/// An adaptation, a trail and, at night, a trail that begins and goes on by itself.
const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "bins": Histogram(source: "scene"),
        "meter": AutoExposure(histogram: "bins"),
        "exposed": Exposure(source: "scene", meter: "meter", stops: 0.5),
        "trail": Composite(base: "exposed", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
        "gray": Saturation(source: "trail", amount: 0.0, when: "night"),
        "blur": Composite(base: "gray", bloom: "blur@previous", blend: Mix, strength: 0.7, when: "night"),
        "mapped": ToneMap(source: "blur", curve: Reinhard),
        "encoded": Encode(source: "mapped", transfer: Srgb),
        "display": Dither(source: "encoded", bits: 8, format: Rgba8Unorm),
    },
    outputs: { "display": "display" },
)"#;

/// A host whose plans are made at once, so that they come in with the frame after the one that asks for them.
struct Host {
    gpu: Shared,
    post: Post,
    scenes: Vec<wgpu::TextureView>,
    target: wgpu::Texture,
    view: wgpu::TextureView,
    rectangle: Option<Rectangle>,
    frame: usize,
}

impl Host {
    fn new(text: &str) -> Self {
        Self::of(graph(text))
    }

    fn of(graph: Graph) -> Self {
        let gpu = gpu();
        let mut post = Post::new(&gpu, graph);
        post.set_task_pool(Arc::new(|task| task()));
        post.set_fact("night", false);
        let target = target(&gpu, SIZE, BGRA);
        let view = target.create_view(&Default::default());
        let mut host = Self { target, view, scenes: Vec::new(), post, gpu, rectangle: None, frame: 0 };
        host.scenes = host.scenes_of(SIZE);
        host
    }

    /// Three scenes, which frames have in turn: what a history holds differs from frame to frame.
    fn scenes_of(&self, size: Size) -> Vec<wgpu::TextureView> {
        let scene = |number: u32| {
            let light = |x: u32, y: u32| {
                let (u, v) = (x as f32 / size.width as f32, y as f32 / size.height as f32);
                [0.1 + (number + 1) as f32 * u * v, 0.2 + v, 0.3 + (u * 40.0 + number as f32).sin().abs(), 1.0]
            };
            let picture = Picture::new(size.width, size.height, light);
            let texels = Texels::from_floats_as_half(size.width, size.height, &picture.pixels);
            upload(&self.gpu.device, &self.gpu.queue, &texels).unwrap().create_view(&Default::default())
        };
        (0..3).map(scene).collect()
    }

    fn show_in(&mut self, size: Size, format: wgpu::TextureFormat) {
        self.target = target(&self.gpu, size, format);
        self.view = self.target.create_view(&Default::default());
    }

    fn night(&mut self, night: bool) {
        self.post.set_fact("night", night);
    }

    fn encode(&mut self, outputs: &[(&str, &wgpu::TextureView)], reset: bool) -> Result<(), PostError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let inputs = &[("scene", &self.scenes[self.frame % 3])];
        let rectangle = self.rectangle.map(|rectangle| ("display", rectangle));
        let (rectangles, dt) = (rectangle.as_slice(), 0.1);
        let frame = Frame { inputs, outputs, rectangles, dt, kind: FrameKind::cut_if(reset), ..Frame::default() };
        let recorded = self.post.encode(&mut encoder, &frame);
        self.gpu.queue.submit([encoder.finish()]);
        self.frame += 1;
        recorded
    }

    /// The codes that a frame leaves in the target.
    fn codes(&mut self, reset: bool) -> Vec<u8> {
        let view = self.view.clone();
        self.encode(&[("display", &view)], reset).unwrap_or_else(|error| panic!("{error}"));
        texture_bytes(&self.gpu, &self.target, 4)
    }

    fn shown(&mut self) -> Vec<u8> {
        self.codes(false)
    }

    /// True if the last change was not faded, or not to its end, for that reason.
    fn missed(&self, why: &str) -> bool {
        self.post.fade_skip_reason().is_some_and(|reason| reason.contains(why)) && !self.post.is_fading()
    }
}

const BGRA: wgpu::TextureFormat = wgpu::TextureFormat::Bgra8Unorm;

fn target(gpu: &afterimage_gpu::Gpu, size: Size, format: wgpu::TextureFormat) -> wgpu::Texture {
    let usage =
        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// A host that never changes, one that changes at once, and one that fades over that many frames.
fn hosts(frames: u16) -> [Host; 3] {
    let mut hosts = [(); 3].map(|()| Host::new(LOOK));
    hosts[2].post.set_fade(frames);
    hosts
}

fn all(hosts: &mut [Host; 3]) -> [Vec<u8>; 3] {
    hosts.each_mut().map(Host::shown)
}

/// By how many codes a picture differs at most from the mix of two in f64.
fn off(shown: &[u8], [old, new]: [&[u8]; 2], weight: f64) -> f64 {
    assert_eq!([shown.len(), old.len()], [new.len(); 2]);
    let wanted = old.iter().zip(new).map(|(old, new)| f64::from(*old) * (1.0 - weight) + f64::from(*new) * weight);
    shown.iter().zip(wanted).map(|(shown, wanted)| (f64::from(*shown) - wanted).abs()).fold(0.0, f64::max)
}

/// All hosts show the same, also in the frame that asks for the other plan.
fn until_the_change(hosts: &mut [Host; 3], to: bool) {
    hosts[1..].iter_mut().for_each(|host| host.night(to));
    let [old, new, shown] = all(hosts);
    assert!(old == shown && new == shown, "the old plan alone, bit for bit");
    assert!(hosts[2].post.is_changing() && !hosts[2].post.is_fading());
}

/// A frame of a fade over so many frames.
#[track_caller]
fn one_frame(hosts: &mut [Host; 3], number: u16, frames: u16) {
    let [old, new, shown] = all(hosts);
    let weight = f64::from(number) / f64::from(frames + 1);
    let error = off(&shown, [&old, &new], weight);
    assert!(error < MAX_OFF, "frame {number} is {error} codes from the mix");
    let apart = off(&old, [&old, &new], 1.0);
    assert!(apart > 10.0, "the plans differ by {apart} codes");
    assert_eq!(hosts[2].post.is_fading(), number < frames);
    assert_eq!(hosts[2].post.fade_skip_reason(), None);
}

/// Both plans go on as if each was alone, also where one begins a history of its own, and each frame lies between them.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_frame_of_a_fade_is_a_mix_of_both_plans_and_the_one_after_it_of_the_new_plan() {
    let _alone = layer::alone();
    assert!(layer::is_installed(), "the validation layer is missing: apt-get install vulkan-validationlayers");
    for to in [true, false] {
        layer::messages();
        let mut hosts = hosts(FRAMES);
        hosts.iter_mut().for_each(|host| host.night(!to));
        for _ in 0..3 {
            let [old, new, shown] = all(&mut hosts);
            assert!(old == shown && new == shown, "nothing changes");
        }
        until_the_change(&mut hosts, to);
        for number in 1..=FRAMES {
            one_frame(&mut hosts, number, FRAMES);
        }
        let [_, new, faded] = &mut hosts;
        for _ in 0..4 {
            assert!(new.shown() == faded.shown(), "the new plan alone, bit for bit");
        }
        assert_eq!(faded.post.executor().passes_bound(), 0, "a steady frame");
        assert_eq!(layer::messages(), Vec::<String>::new());
    }
}

/// The memory of the old plan is copied in the first frame of a fade.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fade_whose_first_frame_is_dropped_ends() {
    let [_, mut new, mut faded] = hosts(FRAMES);
    for host in [&mut new, &mut faded] {
        host.shown();
        host.night(true);
        host.shown();
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        let frame = Frame {
            inputs: &[("scene", &host.scenes[host.frame % 3])],
            outputs: &[("display", &host.view)],
            dt: 0.1,
            ..Frame::default()
        };
        host.post.encode(&mut encoder, &frame).unwrap();
    }
    assert!(faded.post.is_fading());
    for _ in 0..3 {
        assert!(new.shown() == faded.shown());
        assert!(faded.missed("does not follow"));
    }
}

/// The device decodes and encodes, so that light is mixed.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_is_mixed_where_the_image_holds_light() {
    let mut hosts = hosts(1);
    hosts.iter_mut().for_each(|host| host.show_in(SIZE, wgpu::TextureFormat::Bgra8UnormSrgb));
    all(&mut hosts);
    until_the_change(&mut hosts, true);
    let [old, new, shown] = all(&mut hosts);
    let light = |code: f64| {
        let code = code / 255.0;
        if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
    };
    let code =
        |light: f64| 255.0 * if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    let (mut error, mut of_codes) = (0.0_f64, 0.0_f64);
    for ((old, new), shown) in
        old.iter().zip(&new).zip(&shown).enumerate().filter(|(at, _)| at % 4 < 3).map(|all| all.1)
    {
        let [old, new, shown] = [old, new, shown].map(|code| f64::from(*code));
        error = error.max((shown - code(0.5 * (light(old) + light(new)))).abs());
        of_codes = of_codes.max((shown - 0.5 * (old + new)).abs());
    }
    // Half a code for rounding, 0.03 for the half floats in which both pictures are kept, and the encoding of the
    // device, which may be off by a tenth of a code.
    assert!(error < 0.75, "{error} codes from the mix of light");
    assert!(of_codes > 3.0, "a mix of codes would be another one");
}

/// What is around a rectangle stays, also while it moves.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fade_stays_in_the_rectangle_of_its_output() {
    let wide = Size::new(SIZE.width + 20, SIZE.height + 10);
    let mut hosts = hosts(2);
    hosts.iter_mut().for_each(|host| host.show_in(wide, BGRA));
    let places = [(3, 2), (3, 2), (5, 7), (20, 10), (0, 0)];
    for (number, (x, y)) in places.into_iter().enumerate() {
        if number == 1 {
            hosts[1..].iter_mut().for_each(|host| host.night(true));
        }
        let before = texture_bytes(&hosts[2].gpu, &hosts[2].target, 4);
        for host in &mut hosts {
            host.rectangle = Some(Rectangle { x, y, width: SIZE.width, height: SIZE.height });
        }
        let all = all(&mut hosts);
        let row = 4 * wide.width as usize;
        let is_inside = |at: &usize| {
            let (column, line) = (at % row / 4, at / row);
            (x as usize..(x + SIZE.width) as usize).contains(&column)
                && (y as usize..(y + SIZE.height) as usize).contains(&line)
        };
        let inside = |codes: &[u8]| -> Vec<u8> { (0..codes.len()).filter(is_inside).map(|at| codes[at]).collect() };
        let [old, new, shown] = all.each_ref().map(|codes| inside(codes));
        let weight = [0.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0][number];
        let error = off(&shown, [&old, &new], weight);
        assert!(error < MAX_OFF, "frame {number} is {error} codes from the mix");
        let mut around = (0..before.len()).filter(|at| !is_inside(at));
        assert!(around.all(|at| before[at] == all[2][at]), "frame {number} changes what is around");
        assert!(number != 4 || shown == new);
    }
    assert_eq!(hosts[2].post.fade_skip_reason(), None);
}

/// Values are set in both plans.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_parameter_that_is_set_during_a_fade_moves_both_pictures() {
    let mut hosts = hosts(FRAMES);
    let stops = hosts.each_mut().map(|host| host.post.parameter::<f32>("exposed.stops").unwrap());
    all(&mut hosts);
    until_the_change(&mut hosts, true);
    for number in 1..=FRAMES {
        let before = hosts[2].post.plan().cloned();
        for (host, stops) in hosts.iter_mut().zip(stops) {
            host.post.set(stops, 0.5 - 0.4 * f32::from(number)).unwrap();
        }
        one_frame(&mut hosts, number, FRAMES);
        let same = before.as_ref().map(Arc::as_ptr) == hosts[2].post.plan().map(Arc::as_ptr);
        assert!(number == 1 || same, "no plan is made");
    }
    let [_, new, faded] = &mut hosts;
    assert!(new.shown() == faded.shown());
}

/// Another graph, in which nodes have other numbers. What the host sets reaches both plans, also before the other one
/// is there.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fade_leads_from_one_pipeline_to_another() {
    let other = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "exposed": Exposure(source: "scene", stops: -0.5),
            "trail": Composite(base: "exposed", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
            "mapped": ToneMap(source: "trail", curve: Reinhard),
            "rose": Saturation(source: "mapped", amount: 2.0),
            "encoded": Encode(source: "rose", transfer: Srgb),
            "display": Dither(source: "encoded", bits: 8, format: Rgba8Unorm),
        },
        outputs: { "display": "display" },
    )"#;
    let mut hosts = hosts(FRAMES);
    let stops = hosts.each_mut().map(|host| host.post.parameter::<f32>("exposed.stops").unwrap());
    all(&mut hosts);
    for host in &mut hosts[1..] {
        host.post.change(graph(other));
    }
    for number in 0..=FRAMES {
        for (host, stops) in hosts.iter_mut().zip(stops) {
            host.post.set(stops, 0.2 * f32::from(number)).unwrap();
        }
        match number {
            0 => {
                let [old, new, shown] = all(&mut hosts);
                assert!(old == shown && new == shown, "the old plan alone, bit for bit");
            }
            _ => one_frame(&mut hosts, number, FRAMES),
        }
    }
    let [_, new, faded] = &mut hosts;
    assert!(new.shown() == faded.shown());
}
