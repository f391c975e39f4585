//! The exposure while a camera walks from the room to the window of the built-in scene, stays there, and cuts back.

use afterimage_gpu::{FrameStep, Gpu, InputImage, Session, Texels, input_image};
use afterimage_graph::check::Facts;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::Options;

use super::graph::{SCENE, graph};
use crate::failure::Failure;

/// Frames per second.
pub(super) const RATES: [u32; 3] = [24, 60, 144];
/// Seconds from the room to the window: 96 frames at 24 per second.
pub(super) const WALK: f64 = 4.0;
/// The time of the cut back to the room: a whole number of frames at every rate.
pub(super) const CUT: f64 = 5.5;
pub(super) const END: f64 = 7.0;
/// Comparisons per second: all rates have frames at these times.
pub(super) const COMMON: u32 = 12;

/// Pixels of the view: metering needs few.
const SIZE: Size = Size { width: 64, height: 36, depth: 1 };

/// The output of the light 1 is the exposure.
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

    /// The frames at the times that all rates have.
    pub(super) fn common(&self) -> impl Iterator<Item = (f64, f64)> {
        self.points().step_by((self.rate / COMMON) as usize)
    }
}

/// The measured exposures.
pub(super) struct Walk {
    /// The exposure of each view on its own.
    pub(super) wanted: Track,
    /// The exposure at each rate, with a reset at the cut.
    pub(super) followed: Vec<Track>,
    /// The exposure at the highest rate, without a reset at the cut.
    pub(super) undeclared: Track,
}

impl Walk {
    /// The difference of a rate from the highest one over time, in percent of light.
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
        format!("from {} frames per second the exposure differs by {}", RATES[RATES.len() - 1], parts.join(", "))
    }
}

/// Walks at every rate.
pub(super) fn measure(gpu: &Gpu, registry: &Registry) -> Result<Walk, Failure> {
    let mut camera = Camera::new(gpu, registry)?;
    let highest = RATES[RATES.len() - 1];
    let is_cut = |frame: u32, rate: u32| frame == 0 || f64::from(frame) == CUT * f64::from(rate);
    let followed =
        RATES.iter().map(|rate| camera.walk(*rate, |frame| is_cut(frame, *rate))).collect::<Result<_, _>>()?;
    let wanted = camera.walk(highest, |_| true)?;
    let undeclared = camera.walk(highest, |frame| frame == 0)?;
    Ok(Walk { wanted, followed, undeclared })
}

/// The position of the camera: 0 deep in the room, 1 at the window.
fn position(seconds: f64) -> f64 {
    if seconds < CUT { (seconds / WALK).min(1.0) } else { 0.0 }
}

/// The view of the scene from a position.
struct Camera<'g> {
    gpu: &'g Gpu,
    registry: &'g Registry,
    scene: Session,
    /// The position of the last view.
    position: Option<f64>,
}

impl<'g> Camera<'g> {
    fn new(gpu: &'g Gpu, registry: &'g Registry) -> Result<Self, Failure> {
        let scene = graph(registry, "scene", SCENE, Vec::new())?;
        let scene = Session::new(gpu, scene, Facts::default(), Options::default());
        Ok(Self { gpu, registry, scene, position: None })
    }

    /// The exposure over a walk; `reset` tells before which frames the history starts again.
    fn walk(&mut self, rate: u32, reset: impl Fn(u32) -> bool) -> Result<Track, Failure> {
        let mut meter = Meter::new(self.gpu, self.registry)?;
        let mut stops = Vec::new();
        for frame in 0..=(END * f64::from(rate)) as u32 {
            let view = self.view(position(f64::from(frame) / f64::from(rate)))?;
            stops.push(meter.stops(view, 1.0 / rate as f32, reset(frame))?);
        }
        Ok(Track { rate, stops })
    }

    fn view(&mut self, position: f64) -> Result<InputImage, Failure> {
        if self.position != Some(position) {
            let scene = graph(self.registry, "scene", SCENE, vec![format!("scene.walk={position:?}")])?;
            self.scene.change(scene, Options::default());
            self.scene.render(SIZE, &[], FrameStep::FIRST)?;
            self.position = Some(position);
        }
        Ok(self.scene.output_image("scene", "scene"))
    }
}

/// Measures the exposure of a sequence of views.
struct Meter {
    session: Session,
    one: InputImage,
}

impl Meter {
    fn new(gpu: &Gpu, registry: &Registry) -> Result<Self, Failure> {
        let one = Texels::from_floats(1, 1, &[[1.0; 4]]);
        let one = input_image(gpu, "one", one.desc, &one.bytes)?;
        let options = Options { exact: true, ..Options::default() };
        let session = Session::new(gpu, graph(registry, "meter", METER, Vec::new())?, Facts::default(), options);
        Ok(Self { session, one })
    }

    /// The exposure after one more frame.
    fn stops(&mut self, view: InputImage, dt: f32, reset: bool) -> Result<f64, Failure> {
        let images = [view, self.one.clone()];
        self.session.render(SIZE, &images, FrameStep { time: 0.0, dt, reset })?;
        let exposed = self.session.output("exposed")?.to_floats();
        Ok(f64::from(exposed[0][0]).log2())
    }
}

#[cfg(test)]
mod tests {
    use super::{COMMON, CUT, END, RATES, Track, Walk, position};

    #[test]
    fn the_camera_walks_rests_and_is_back() {
        assert_eq!([0.0, 2.0, 4.0, 5.4, CUT, END].map(position), [0.0, 0.5, 1.0, 1.0, 0.0, 0.0]);
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
        let expected = "from 144 frames per second the exposure differs by 2.00 % at 24, 1.00 % at 60";
        assert_eq!(walk.summary(), expected);
    }
}
