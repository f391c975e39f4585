//! A camera walks from the room to the window of the built-in scene, rests there, and the film cuts back: what the exposure does.

use std::sync::Arc;

use afterimage_gpu::{Executor, Frame, Gpu, Texels, download, upload};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{GivenImage, Options, PlanRequest, plan};

use crate::args::PipelineOptions;
use crate::failure::Failure;
use crate::pipeline::check_text;
use crate::shipped::SCENE;

/// Frames in a second.
pub(super) const RATES: [u32; 3] = [24, 60, 144];
/// Seconds from the room to the window: 96 frames at 24 in a second.
pub(super) const WALK: f64 = 4.0;
/// When the film cuts back to the room. A whole number of frames at every rate.
pub(super) const CUT: f64 = 5.5;
pub(super) const END: f64 = 7.0;
/// How often in a second the rates are compared: they all have frames there.
pub(super) const COMMON: u32 = 12;

/// Pixels of the view: a meter needs few.
const WIDTH: u32 = 64;
const HEIGHT: u32 = 36;

/// What a light of 1 becomes tells the exposure.
const METER: &str = r#"Pipeline(
    inputs: { "scene": Color, "one": Color },
    nodes: {
        "counted": Histogram(source: "scene"),
        "metered": AutoExposure(histogram: "counted"),
        "exposed": Exposure(source: "one", meter: "metered"),
    },
    outputs: { "exposed": "exposed" },
)"#;

/// An exposure over time.
pub(super) struct Track {
    pub(super) rate: u32,
    /// Frame by frame.
    pub(super) stops: Vec<f64>,
}

impl Track {
    /// Seconds and stops.
    pub(super) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.stops.iter().enumerate().map(|(frame, stops)| (frame as f64 / f64::from(self.rate), *stops))
    }

    /// Those frames that every rate has.
    pub(super) fn common(&self) -> impl Iterator<Item = (f64, f64)> {
        self.points().step_by((self.rate / COMMON) as usize)
    }
}

/// What was measured.
pub(super) struct Walk {
    /// What each view asks for by itself.
    pub(super) wanted: Track,
    /// What it becomes at each of the rates, with the cut declared.
    pub(super) followed: Vec<Track>,
    /// The same without declaring the cut, at the highest rate.
    pub(super) undeclared: Track,
}

impl Walk {
    /// By how many per cent of light a rate differs from the highest one, over time.
    pub(super) fn difference(&self, track: &Track) -> Vec<(f64, f64)> {
        let highest = self.followed.last().into_iter().flat_map(Track::common);
        let percent = |a: f64, b: f64| ((a - b).exp2() - 1.0) * 100.0;
        track.common().zip(highest).map(|((seconds, a), (_, b))| (seconds, percent(a, b))).collect()
    }

    /// The largest difference of each rate, as a line.
    pub(super) fn summary(&self) -> String {
        let (_, others) = self.followed.split_last().expect("there are several rates");
        let worst =
            |track| self.difference(track).into_iter().map(|(_, percent)| percent.abs()).fold(0.0_f64, f64::max);
        let parts: Vec<String> = others.iter().map(|t| format!("{:.2} % at {}", worst(t), t.rate)).collect();
        format!("from {} frames in a second the exposure differs by {}", RATES[RATES.len() - 1], parts.join(", "))
    }
}

/// Walks at every rate.
pub(super) fn measure(gpu: &Gpu, registry: &Registry) -> Result<Walk, Failure> {
    let mut camera = Camera { gpu, registry, executor: executor(gpu), seen: None };
    let highest = RATES[RATES.len() - 1];
    let is_cut = |frame: u32, rate: u32| frame == 0 || f64::from(frame) == CUT * f64::from(rate);
    let followed =
        RATES.iter().map(|rate| camera.walk(*rate, |frame| is_cut(frame, *rate))).collect::<Result<_, _>>()?;
    let wanted = camera.walk(highest, |_| true)?;
    let undeclared = camera.walk(highest, |frame| frame == 0)?;
    Ok(Walk { wanted, followed, undeclared })
}

/// From 0 deep in the room to 1 at the window.
fn place(seconds: f64) -> f64 {
    if seconds < CUT { (seconds / WALK).min(1.0) } else { 0.0 }
}

fn executor(gpu: &Gpu) -> Executor {
    Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone())
}

struct Camera<'g> {
    gpu: &'g Gpu,
    registry: &'g Registry,
    executor: Executor,
    /// Where the camera stands, and what it sees.
    seen: Option<(f64, wgpu::TextureView)>,
}

impl Camera<'_> {
    /// The exposure of a walk; `reset` says before which frames nothing is remembered.
    fn walk(&mut self, rate: u32, reset: impl Fn(u32) -> bool) -> Result<Track, Failure> {
        let mut meter = Meter::new(self.gpu, self.registry)?;
        let mut stops = Vec::new();
        for frame in 0..=(END * f64::from(rate)) as u32 {
            let view = self.look(place(f64::from(frame) / f64::from(rate)))?;
            stops.push(meter.stops(&view, 1.0 / rate as f32, reset(frame))?);
        }
        Ok(Track { rate, stops })
    }

    fn look(&mut self, place: f64) -> Result<wgpu::TextureView, Failure> {
        if let Some((_, view)) = self.seen.as_ref().filter(|(seen, _)| *seen == place) {
            return Ok(view.clone());
        }
        let graph = graph(self.registry, SCENE, vec![format!("scene.walk={place:?}")])?;
        load(self.gpu, &mut self.executor, &graph, &[], Options::default())?;
        submit(self.gpu, &mut self.executor, &Frame::default())?;
        let texture = self.executor.output("scene").expect("it is the output");
        let view = texture.create_view(&Default::default());
        self.seen = Some((place, view.clone()));
        Ok(view)
    }
}

struct Meter<'g> {
    gpu: &'g Gpu,
    executor: Executor,
    one: wgpu::TextureView,
}

impl<'g> Meter<'g> {
    fn new(gpu: &'g Gpu, registry: &Registry) -> Result<Self, Failure> {
        let one = Texels::from_floats(1, 1, &[[1.0; 4]]);
        let inputs = [("scene", ImageDesc::new(Size::new(WIDTH, HEIGHT))), ("one", one.desc)];
        let mut executor = executor(gpu);
        let options = Options { exact: true, ..Options::default() };
        load(gpu, &mut executor, &graph(registry, METER, Vec::new())?, &inputs, options)?;
        let one = upload(&gpu.device, &gpu.queue, &one).create_view(&Default::default());
        Ok(Self { gpu, executor, one })
    }

    /// The exposure after one more frame.
    fn stops(&mut self, scene: &wgpu::TextureView, dt: f32, reset: bool) -> Result<f64, Failure> {
        let inputs = [("scene", scene), ("one", &self.one)];
        submit(self.gpu, &mut self.executor, &Frame { inputs: &inputs, dt, reset, ..Frame::default() })?;
        let texture = self.executor.output("exposed").expect("it is the output");
        let exposed = download(&self.gpu.device, &self.gpu.queue, texture)?.to_floats();
        Ok(f64::from(exposed[0][0]).log2())
    }
}

fn graph(registry: &Registry, text: &str, sets: Vec<String>) -> Result<Graph, Failure> {
    let options = PipelineOptions { sets, facts: Vec::new(), tier: None, nodes: Vec::new() };
    Ok(check_text("walk.ron", text, registry, &options)?.0)
}

fn load(
    gpu: &Gpu,
    executor: &mut Executor,
    graph: &Graph,
    inputs: &[(&str, ImageDesc)],
    options: Options,
) -> Result<(), Failure> {
    let requirement = |desc: &ImageDesc| executor.requirement(desc);
    let given = |(name, desc): &(&str, ImageDesc)| ((*name).to_owned(), GivenImage { desc: *desc, finite: false });
    let setting = PlanRequest {
        size: Size::new(WIDTH, HEIGHT),
        inputs: inputs.iter().map(given).collect(),
        facts: Facts::default(),
        caps: gpu.caps.clone(),
        options,
        requirement: &requirement,
    };
    let plan = plan(graph, &setting)?;
    executor.load(Arc::new(plan))?;
    Ok(())
}

fn submit(gpu: &Gpu, executor: &mut Executor, frame: &Frame<'_>) -> Result<(), Failure> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    executor.encode(&mut encoder, frame)?;
    gpu.queue.submit([encoder.finish()]);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{COMMON, CUT, END, RATES, Track, Walk, place};

    #[test]
    fn the_camera_walks_rests_and_is_back() {
        assert_eq!([0.0, 2.0, 4.0, 5.4, CUT, END].map(place), [0.0, 0.5, 1.0, 1.0, 0.0, 0.0]);
        assert!(RATES.iter().all(|rate| rate % COMMON == 0 && (CUT * f64::from(*rate)).fract() == 0.0));
    }

    #[test]
    fn rates_are_compared_where_all_have_frames() {
        let track = |rate: u32, off: f64| Track {
            rate,
            stops: (0..=rate).map(|frame| f64::from(frame) / f64::from(rate) + off).collect(),
        };
        let followed = vec![track(24, 1.02_f64.log2()), track(60, 0.99_f64.log2()), track(144, 0.0)];
        let walk = Walk { wanted: track(144, 0.0), followed, undeclared: track(144, 0.0) };
        let off = walk.difference(&walk.followed[0]);
        assert_eq!(off.len(), COMMON as usize + 1);
        assert!(off.iter().all(|(_, percent)| (percent - 2.0).abs() < 1e-9), "{off:?}");
        let told = "from 144 frames in a second the exposure differs by 2.00 % at 24, 1.00 % at 60";
        assert_eq!(walk.summary(), told);
    }
}
