//! What a host pays in microseconds for a frame in which nothing, a parameter, a fact or its images change.
//!
//! Medians of the time to record a frame on the CPU; the GPU has always finished the frame before. Run it with
//! `cargo bench -p afterimage --bench host`.
#![allow(clippy::print_stdout, reason = "a benchmark's figures are its output")]

use std::error::Error;
use std::time::{Duration, Instant};

use afterimage::Post;
use afterimage::host::{ExpectedFrame, HostImage, Parameter};
use afterimage_gpu::{Frame, Gpu, Opening, Texels, upload, wgpu};
use afterimage_graph::check::{CheckOptions, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;

const SIZE: Size = Size { width: 256, height: 144, depth: 1 };
const WARM_UP: usize = 20;
const TIMED: usize = 300;

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo test` runs benchmarks with this flag, to check that they start.
    let frames = if std::env::args().any(|argument| argument == "--test") { 1 } else { TIMED };
    let gpu = Gpu::open(&Opening::default())?;
    println!("microseconds to record a frame, median of {frames}, on {}:", gpu.name());
    println!("  {:<48} {:.2}", "one `create_bind_group` of three entries", bind_group(&gpu, frames)?);
    println!("  {:<48} {:.2}", "one `write_buffer` of 16 bytes", write(&gpu, frames)?);
    for pipeline in ["lynx", "tsushima"] {
        let mut host = Host::new(&gpu, pipeline)?;
        println!("{pipeline}.ron:");
        let strength = host.post.parameter::<f32>("lit.strength")?;
        parameter(&mut host, frames, strength)?;
        let shown = host.measure(frames, &mut |host, _| host.renew_output())?;
        print(&host, "a new view of the output", shown);
        let renewed = host.measure(frames, &mut |host, _| host.renew_input().and(host.renew_output()))?;
        print(&host, "new views of all images", renewed);
        let mut set_fact = |host: &mut Host<'_>, frame: usize| {
            host.post.set_fact("emissive", frame % 20 < 10);
            Ok(())
        };
        let fact = host.measure(frames, &mut set_fact)?;
        print(&host, "a fact, whose plans come in from the background", fact);
        sizes(&mut host, frames)?;
        views(&host)?;
    }
    Ok(())
}

/// Frames in which nothing changes, and frames in which a parameter is set, in turns: so that both meet the same
/// clock rate and the same caches.
fn parameter(host: &mut Host<'_>, frames: usize, strength: Parameter<f32>) -> Result<(), Box<dyn Error>> {
    let times = host.times(2 * frames, &mut |_, _| Ok(()), Some(strength))?;
    let [steady, moved] = [0, 1].map(|first| summary(times.iter().copied().skip(first).step_by(2).collect()));
    print(host, "nothing changes", steady);
    print(host, "a parameter with a handle is set", moved);
    println!("  {:<48} {:.1}", "of these for the parameter", moved.0 - steady.0);
    Ok(())
}

/// Another size in every fourth frame: known from before, and never seen.
fn sizes(host: &mut Host<'_>, frames: usize) -> Result<(), Box<dyn Error>> {
    let smaller = |step: usize| Size::new(SIZE.width - 16 * step as u32, SIZE.height - 9 * step as u32);
    let image = |size: Size| HostImage::new(size.width, size.height, wgpu::TextureFormat::Rgba16Float);
    let inputs = [0, 1, 2, 3].map(|step| [("scene", image(smaller(step)))]);
    host.post.prepare(&inputs.each_ref().map(|inputs| ExpectedFrame { inputs, ..ExpectedFrame::default() }))?;
    while !host.post.is_prepared()? {
        host.measure(1, &mut |_, _| Ok(()))?;
    }
    let mut resize = |host: &mut Host<'_>, frame: usize| host.resize(smaller(frame / 4 % 4));
    let (usual, longest, changes) = host.changes(frames, &mut resize)?;
    println!(
        "  {:<48} {changes:.1}; frames between {usual:.1}, longest {longest:.1}",
        "another size that was expected"
    );
    let mut resize = |host: &mut Host<'_>, frame: usize| host.resize(Size::new(400 + frame as u32 / 4, 300));
    let (usual, longest, changes) = host.changes(frames.min(80), &mut resize)?;
    println!("  {:<48} {changes:.1}; frames between {usual:.1}, longest {longest:.1}", "another size that is new");
    Ok(())
}

/// The first frame of a pipeline, and of a second view of it.
fn views(host: &Host<'_>) -> Result<(), Box<dyn Error>> {
    let first_frame = |post: &mut Post| {
        let start = Instant::now();
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        let (inputs, outputs) = (&[("scene", &host.views[0])], &[("display", &host.views[1])]);
        post.encode(&mut encoder, &Frame { inputs, outputs, ..Frame::default() })?;
        let time = start.elapsed();
        host.gpu.queue.submit([encoder.finish()]);
        Ok::<f64, Box<dyn Error>>(time.as_secs_f64() * 1e6)
    };
    let mut post = Post::new(host.gpu, host.post.graph().clone());
    let first = first_frame(&mut post)?;
    let second = first_frame(&mut post.clone_for_view())?;
    println!("  {:<48} {first:.0}; of a second view {second:.0}", "the first frame, with its plan and pipelines");
    Ok(())
}

fn print(host: &Host<'_>, what: &str, (median, longest): (f64, f64)) {
    let passes = host.post.plan().map_or(0, |plan| plan.passes.len());
    println!("  {what:<48} {median:.1}; longest {longest:.1} ({passes} passes)");
}

struct Host<'g> {
    gpu: &'g Gpu,
    post: Post,
    input: wgpu::Texture,
    output: wgpu::Texture,
    views: [wgpu::TextureView; 2],
}

/// What the host does before a frame, by its number.
type Before<'c, 'g> = &'c mut dyn FnMut(&mut Host<'g>, usize) -> Result<(), Box<dyn Error>>;

impl<'g> Host<'g> {
    fn new(gpu: &'g Gpu, pipeline: &str) -> Result<Self, Box<dyn Error>> {
        let path = format!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/{}.ron"), pipeline);
        let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
        let document = parse(&path, &std::fs::read_to_string(&path)?)?;
        let (graph, _) = check(&document, &Registry::new(&[afterimage_nodes::ALL])?, &options)?;
        let pixels: Vec<_> = (0..SIZE.texels()).map(|at| [at as f32 * 1e-4, 0.5, 2.0, 1.0]).collect();
        let texels = Texels::from_floats_as_half(SIZE.width, SIZE.height, &pixels);
        let (input, output) = (upload(&gpu.device, &gpu.queue, &texels)?, screen(gpu, SIZE));
        let views = [&input, &output].map(|texture| texture.create_view(&Default::default()));
        Ok(Self { gpu, post: Post::new(gpu, graph), input, output, views })
    }

    fn resize(&mut self, size: Size) -> Result<(), Box<dyn Error>> {
        if size.width == self.input.width() {
            return Ok(());
        }
        let pixels: Vec<_> = (0..size.texels()).map(|at| [at as f32 * 1e-4, 0.5, 2.0, 1.0]).collect();
        let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
        (self.input, self.output) = (upload(&self.gpu.device, &self.gpu.queue, &texels)?, screen(self.gpu, size));
        self.renew_input().and(self.renew_output())
    }

    /// The usual and the longest time of a frame, and the median of every fourth, in which something changes.
    fn changes(&mut self, frames: usize, before: Before<'_, 'g>) -> Result<(f64, f64, f64), Box<dyn Error>> {
        let times = self.times(frames.next_multiple_of(4), before, None)?;
        let changes: Vec<Duration> = times.iter().copied().step_by(4).collect();
        let (usual, longest) = summary(times);
        Ok((usual, longest, summary(changes).0))
    }

    fn renew_input(&mut self) -> Result<(), Box<dyn Error>> {
        self.views[0] = self.input.create_view(&Default::default());
        Ok(())
    }

    fn renew_output(&mut self) -> Result<(), Box<dyn Error>> {
        self.views[1] = self.output.create_view(&Default::default());
        Ok(())
    }

    /// The median and the longest time to record a frame, without a first few. What the host does in `before` is its
    /// own.
    fn measure(&mut self, frames: usize, before: Before<'_, 'g>) -> Result<(f64, f64), Box<dyn Error>> {
        Ok(summary(self.times(frames, before, None)?))
    }

    /// The times to record frames, without a first few. Every second frame sets a parameter, if there is one, and its
    /// time counts.
    fn times(
        &mut self,
        frames: usize,
        before: Before<'_, 'g>,
        parameter: Option<Parameter<f32>>,
    ) -> Result<Vec<Duration>, Box<dyn Error>> {
        let mut times = Vec::new();
        for frame in 0..WARM_UP + frames {
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            before(self, frame)?;
            let start = Instant::now();
            if let Some(parameter) = parameter.filter(|_| frame % 2 == 1) {
                self.post.set(parameter, 0.001 * (frame % 500) as f32)?;
            }
            let (inputs, outputs) = (&[("scene", &self.views[0])], &[("display", &self.views[1])]);
            let time = frame as f64 / 60.0;
            let step = Frame { inputs, outputs, time, dt: 1.0 / 60.0, ..Frame::default() };
            self.post.encode(&mut encoder, &step)?;
            times.push(start.elapsed());
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        }
        Ok(times.split_off(WARM_UP))
    }
}

fn summary(mut times: Vec<Duration>) -> (f64, f64) {
    times.sort();
    let microseconds = |time: Duration| time.as_secs_f64() * 1e6;
    (microseconds(times[times.len() / 2]), microseconds(times[times.len() - 1]))
}

fn screen(gpu: &Gpu, size: Size) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("screen"),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Bgra8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

/// The median time to write to a buffer, with an empty submission after each.
fn write(gpu: &Gpu, times: usize) -> Result<f64, Box<dyn Error>> {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let buffer =
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label: None, size: 256, usage, mapped_at_creation: false });
    let mut measured = Vec::new();
    for number in 0..times {
        let start = Instant::now();
        gpu.queue.write_buffer(&buffer, 0, &[number as u8; 16]);
        measured.push(start.elapsed());
        gpu.queue.submit([]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
    }
    Ok(summary(measured).0)
}

/// The median time to make a bind group with an image, a sampler and a buffer, which few passes exceed.
fn bind_group(gpu: &Gpu, times: usize) -> Result<f64, Box<dyn Error>> {
    let device = &gpu.device;
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None };
    let sample_type = wgpu::TextureSampleType::Float { filterable: true };
    let view_dimension = wgpu::TextureViewDimension::D2;
    let buffer_type = wgpu::BufferBindingType::Uniform;
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[
            entry(0, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }),
            entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            entry(2, wgpu::BindingType::Buffer { ty: buffer_type, has_dynamic_offset: false, min_binding_size: None }),
        ],
    });
    let texels = Texels::from_floats_as_half(1, 1, &[[0.5; 4]]);
    let view = upload(device, &gpu.queue, &texels)?.create_view(&Default::default());
    let sampler = device.create_sampler(&Default::default());
    let usage = wgpu::BufferUsages::UNIFORM;
    let buffer =
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: 256, usage, mapped_at_creation: false });
    let resources = [
        wgpu::BindingResource::TextureView(&view),
        wgpu::BindingResource::Sampler(&sampler),
        buffer.as_entire_binding(),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    let times = (0..times).map(|_| {
        let start = Instant::now();
        let group =
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let time = start.elapsed();
        drop(group);
        time
    });
    Ok(summary(times.collect()).0)
}
