//! A host that changes what hosts change: 120 frames with a scene pass of its own, in which `caracal.ron` changes its
//! size twice, its tier three times, a fact four times, once with a cross-fade, and a parameter in every second frame.
//!
//! Prints the median and the longest time of the host's thread in Afterimage for each kind of frame, that of whole
//! frames, from the first call to the end of the device's work, and how many are longer than twice the median. Run it
//! on a fast device with
//!
//! ```text
//! cargo bench -p afterimage --bench embedding -- 120 1920x1080 5
//! ```
//!
//! The numbers are frames per second, 0 for one frame directly after the other; the size; and how often all of it is
//! repeated, each time with a new pipeline.
#![allow(clippy::print_stdout, reason = "a benchmark's figures are its output")]

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use afterimage::Post;
use afterimage::host::{ExpectedFrame, HostImage};
use afterimage_gpu::{Frame, Gpu, Opening, wgpu};
use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;

const FRAMES: usize = 120;
/// Frames with the first plan, before anything changes. They count as frames of their kinds, but not as long ones.
const WARM_UP: usize = 10;
const FADE: u16 = 8;

/// What a frame is, by what takes longest in it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    First,
    Size,
    ComesIn,
    Fades,
    Tier,
    Fact,
    Parameter,
    Nothing,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::First => "the first frame, with its plan and all pipelines",
            Self::Size => "another size that was expected",
            Self::ComesIn => "a plan comes in from the background",
            Self::Fades => "another frame of a fade",
            Self::Tier => "a tier is asked for, after `check`",
            Self::Fact => "a fact is set: its plan is asked for",
            Self::Parameter => "a parameter moves",
            Self::Nothing => "nothing changes",
        }
    }
}

/// A frame's kind, the host's time in Afterimage, and the time of the whole frame.
type Timed = (Kind, Duration, Duration);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let is_test = std::env::args().any(|argument| argument == "--test");
    let rate: u32 = arguments.first().map_or(Ok(if is_test { 0 } else { 120 }), |text| text.parse())?;
    let size = arguments.get(1).and_then(|text| text.split_once('x'));
    let size = size.map_or(Ok(Size::new(256, 144)), |(width, height)| {
        Ok::<Size, std::num::ParseIntError>(Size::new(width.parse()?, height.parse()?))
    })?;
    let rounds: usize = arguments.get(2).map_or(Ok(if is_test { 1 } else { 5 }), |text| text.parse())?;
    let gpu = Gpu::open(&Opening::default())?;
    println!("caracal.ron, {size}, {FRAMES} frames, {rate} in a second, on {}; microseconds:", gpu.name());
    let mut all = Vec::new();
    for round in 1..=rounds {
        let frames = Host::new(&gpu, size)?.run(rate)?;
        let [host, whole] = [1, 2].map(|at| long_ones(&frames, at == 1));
        println!("  run {round}: longer than twice the median: {host} in Afterimage; {whole} as a whole");
        all.extend(frames);
    }
    let mut kinds: BTreeMap<Kind, [Vec<Duration>; 2]> = BTreeMap::new();
    for (kind, host, whole) in all {
        let times = kinds.entry(kind).or_default();
        times[0].push(host);
        times[1].push(whole);
    }
    println!("  {:<50} {:>6} {:>10} {:>10} {:>12} {:>10}", "", "frames", "median", "longest", "whole frame", "longest");
    for (kind, times) in kinds {
        let count = times[0].len();
        let [[host, most], [whole, longest]] = times.map(summary);
        println!("  {:<50} {count:>6} {host:>10.1} {most:>10.1} {whole:>12.1} {longest:>10.1}", kind.name());
    }
    Ok(())
}

/// How many frames after the warm-up take longer than twice the median of these, the median and the longest, in words.
fn long_ones(frames: &[Timed], in_afterimage: bool) -> String {
    let counted = frames[WARM_UP..].iter();
    let times: Vec<Duration> = counted.map(|(_, host, whole)| if in_afterimage { *host } else { *whole }).collect();
    let [median, longest] = summary(times.clone());
    let count = times.iter().filter(|time| time.as_secs_f64() * 1e6 > 2.0 * median).count();
    format!("{count} of {}, median {median:.1}, longest {longest:.1}", times.len())
}

/// The median and the longest, in microseconds.
fn summary(mut times: Vec<Duration>) -> [f64; 2] {
    times.sort();
    [times[times.len() / 2], times[times.len() - 1]].map(|time| time.as_secs_f64() * 1e6)
}

struct Host<'g> {
    gpu: &'g Gpu,
    post: Post,
    size: Size,
    /// The scene, and what is shown.
    views: [wgpu::TextureView; 2],
}

impl<'g> Host<'g> {
    fn new(gpu: &'g Gpu, size: Size) -> Result<Self, Box<dyn Error>> {
        let post = Post::new(gpu, graph(None)?);
        Ok(Self { gpu, post, size, views: views(gpu, size) })
    }

    fn run(&mut self, rate: u32) -> Result<Vec<Timed>, Box<dyn Error>> {
        let strength = self.post.parameter::<f32>("lit.strength")?;
        let smaller = Size::new(self.size.width * 3 / 4, self.size.height * 3 / 4);
        let sizes = [self.size, smaller];
        let image = |size: Size| HostImage::new(size.width, size.height, wgpu::TextureFormat::Rgba16Float);
        let inputs = sizes.map(|size| [("scene", image(size))]);
        self.post.prepare(&inputs.each_ref().map(|inputs| ExpectedFrame { inputs, ..ExpectedFrame::default() }))?;
        self.post.set_fact("emissive", false);
        // A host does this on another thread.
        let mut tiers = BTreeMap::from([(30, graph(Some("low"))?), (70, graph(Some("high"))?), (95, graph(None)?)]);
        let mut timed = Vec::new();
        for number in 0..FRAMES {
            let start = Instant::now();
            let size = sizes[usize::from((50..85).contains(&number))];
            let is_resized = size != self.size;
            if is_resized {
                (self.size, self.views) = (size, views(self.gpu, size));
            }
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            self.draw_scene(&mut encoder, number);

            let before = Instant::now();
            let old = self.post.plan().map(Arc::as_ptr);
            let mut kind = Kind::Nothing;
            if number % 2 == 1 {
                self.post.set(strength, 0.002 + 0.00002 * number as f32)?;
                kind = Kind::Parameter;
            }
            if [20, 40, 60, 105].contains(&number) {
                self.post.set_fade(if number == 60 { FADE } else { 0 });
                self.post.set_fact("emissive", number % 40 == 20);
                kind = Kind::Fact;
            }
            if let Some(graph) = tiers.remove(&number) {
                self.post.change(graph);
                kind = Kind::Tier;
            }
            let is_fading = self.post.is_fading();
            let (inputs, outputs) = (&[("scene", &self.views[0])], &[("display", &self.views[1])]);
            self.post.encode(&mut encoder, &Frame { inputs, outputs, dt: 1.0 / 60.0, ..Frame::default() })?;
            let host = before.elapsed();

            let kind = match old {
                None => Kind::First,
                _ if is_resized => Kind::Size,
                Some(old) if self.post.plan().map(Arc::as_ptr) != Some(old) => Kind::ComesIn,
                Some(_) if is_fading => Kind::Fades,
                Some(_) => kind,
            };
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
            timed.push((kind, host, start.elapsed()));
            if let Some(rest) = 1_000_000_u64.checked_div(rate.into()) {
                std::thread::sleep(Duration::from_micros(rest).saturating_sub(start.elapsed()));
            }
        }
        Ok(timed)
    }

    /// The host's own pass.
    fn draw_scene(&self, encoder: &mut wgpu::CommandEncoder, number: usize) {
        let color = wgpu::Color { r: 0.01 * number as f64, g: 0.5, b: 2.0, a: 1.0 };
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store };
        let attachment =
            wgpu::RenderPassColorAttachment { view: &self.views[0], depth_slice: None, resolve_target: None, ops };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
    }
}

fn graph(tier: Option<&str>) -> Result<Graph, Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/caracal.ron");
    let options = CheckOptions { tier: tier.map(str::to_owned), sets: Vec::new(), loader: &NoFiles };
    let document = parse(path, &std::fs::read_to_string(path)?)?;
    Ok(check(&document, &Registry::new(&[afterimage_nodes::ALL])?, &options)?.0)
}

/// The scene and the screen.
fn views(gpu: &Gpu, size: Size) -> [wgpu::TextureView; 2] {
    [wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Bgra8Unorm].map(|format| {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("image of the host"),
            size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&Default::default())
    })
}
