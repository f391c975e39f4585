//! Whether this adapter is faster with draws or with dispatches, and whether half floats and subgroups pay.

use std::collections::BTreeMap;
use std::path::Path;

use afterimage_gpu::wgpu::{BindGroupEntry, BindingResource, TextureFormat, TextureUsages, TextureView};
use afterimage_gpu::{Clock, FrameStep, Gpu, Recording, Session, texture_format};
use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::Options;
use serde::{Deserialize, Serialize};

use super::raw::{compute_pipeline, dispatch, draw, draw_pipeline, group, groups, module, target};
use super::report::table;
use crate::{LabError, scene};

/// A time counts as shorter if it is below this share of the other one; the rest is noise.
const NOISE: f64 = 0.95;

/// The figures of a calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The times of a point pass at one size, by the name of the result's format.
    pub formats: BTreeMap<String, StageTimes>,
    /// Half floats in the sums of a pyramid, if the adapter has them.
    #[serde(default)]
    pub half: Option<Gain>,
    /// Subgroups in the reductions of a meter, if the adapter has them.
    #[serde(default)]
    pub subgroups: Option<Gain>,
}

/// The same work without an option and with it, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gain {
    /// Without the option.
    pub without_ms: f64,
    /// With the option.
    pub with_ms: f64,
}

impl Gain {
    /// Whether it is faster with the option, by more than noise.
    pub fn pays(self) -> bool {
        self.with_ms < NOISE * self.without_ms
    }
}

/// The same work in both stages, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageTimes {
    /// Dispatched.
    pub compute_ms: f64,
    /// Drawn.
    pub fragment_ms: f64,
}

impl Calibration {
    /// Whether draws are faster over all formats, by more than noise.
    pub fn prefers_fragment(&self) -> bool {
        let compute: f64 = self.formats.values().map(|times| times.compute_ms).sum();
        let fragment: f64 = self.formats.values().map(|times| times.fragment_ms).sum();
        fragment < NOISE * compute
    }
}

/// Calibrates an adapter; the result has the size of the measured image.
///
/// # Errors
/// Errors of the device.
pub fn calibrate(gpu: &Gpu, registry: &Registry, samples: u32) -> Result<(Calibration, Size), LabError> {
    let clock = Clock::new(gpu)?;
    let side = if gpu.is_processor() { (1280, 720) } else { (3840, 2160) };
    let size = Size::new(side.0.min(gpu.caps.max_side), side.1.min(gpu.caps.max_side));
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let source = target(gpu, size, TextureFormat::Rgba16Float, usage);
    let mut calibration = Calibration::default();
    for format in Format::ALL {
        if gpu.caps.storage.contains(&format) && gpu.caps.renderable.contains(&format) {
            let times = stages(gpu, &clock, &source, (size, format), samples)?;
            calibration.formats.insert(format.name().to_owned(), times);
        }
    }
    let gain = |text, options| gain(gpu, registry, &clock, (text, size), samples, options);
    if gpu.caps.half_arithmetic {
        calibration.half = Some(gain(PYRAMID, Options { half: true, ..Options::default() })?);
    }
    if gpu.caps.subgroups {
        calibration.subgroups = Some(gain(METER, Options { subgroups: true, ..Options::default() })?);
    }
    Ok((calibration, size))
}

fn stages(
    gpu: &Gpu,
    clock: &Clock,
    source: &TextureView,
    (size, format): (Size, Format),
    samples: u32,
) -> Result<StageTimes, LabError> {
    let module = module(gpu, &include_str!("calibrate.wgsl").replace("FORMAT", format.wgsl()));
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let result = target(gpu, size, texture_format(format), usage);
    let entry = |binding, view| BindGroupEntry { binding, resource: BindingResource::TextureView(view) };
    let compute = compute_pipeline(gpu, &module, "dispatched");
    let compute_group = group(gpu, &compute.get_bind_group_layout(0), &[entry(0, source), entry(1, &result)]);
    let dispatched: Recording<'_> = Box::new(|encoder| {
        dispatch(&mut encoder.begin_compute_pass(&Default::default()), &compute, &compute_group, groups(size));
        Ok(())
    });
    let fragment = draw_pipeline(gpu, &module, "drawn", texture_format(format));
    let fragment_group = group(gpu, &fragment.get_bind_group_layout(0), &[entry(0, source)]);
    let drawn: Recording<'_> = Box::new(|encoder| {
        draw(encoder, &fragment, &fragment_group, &result);
        Ok(())
    });
    let times = clock.medians(samples, &mut [dispatched, drawn])?;
    Ok(StageTimes { compute_ms: times[0].ms(), fragment_ms: times[1].ms() })
}

/// A pipeline that mostly sums taps.
const PYRAMID: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "mips": Downsample(source: "scene", levels: 6, filter: Tap13),
        "bloom": Upsample(source: "mips", filter: Tent, radius: 1.0),
        "lit": Composite(base: "scene", bloom: "bloom", blend: Mix, strength: 0.1),
    },
    outputs: { "lit": "lit" },
)"#;

/// A pipeline that mostly sums over workgroups.
const METER: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "mean": MeanLuminance(source: "scene"),
        "meter": Adapt(mean: "mean"),
        "lit": Exposure(source: "scene", meter: "meter"),
    },
    outputs: { "lit": "lit" },
)"#;

/// A pipeline without an option and with it, each measured twice: the shorter time counts, so that other load in one
/// of the measurements does not decide.
fn gain(
    gpu: &Gpu,
    registry: &Registry,
    clock: &Clock,
    (text, size): (&str, Size),
    samples: u32,
    options: Options,
) -> Result<Gain, LabError> {
    let graph = scene::graph(registry, "calibration.ron", text)?;
    let images = scene::still(gpu, registry, &graph, size)?;
    let session = |options| -> Result<Session, LabError> {
        let mut session = Session::new(gpu, graph.clone(), Facts::default(), options);
        session.load(size, &images)?;
        Ok(session)
    };
    let (mut without, mut with) = (session(Options::default())?, session(options)?);
    let record = |session: &mut Session, encoder: &mut _| session.encode(encoder, &images, FrameStep::FIRST);
    let mut work: [Recording<'_>; 2] =
        [Box::new(|encoder| record(&mut without, encoder)), Box::new(|encoder| record(&mut with, encoder))];
    let mut round = || clock.medians(samples, &mut work);
    let (first, second) = (round()?, round()?);
    let best = |at: usize| first[at].ms().min(second[at].ms());
    Ok(Gain { without_ms: best(0), with_ms: best(1) })
}

/// A calibration as text. `kept` is the file that it is stored in.
pub fn describe(calibration: &Calibration, adapter: &str, size: Size, kept: Option<&Path>) -> String {
    let row = |(format, times): (&String, &StageTimes)| {
        vec![format.clone(), format!("{:.4}", times.compute_ms), format!("{:.4}", times.fragment_ms)]
    };
    let table = table(&["result", "dispatched, ms", "drawn, ms"], calibration.formats.iter().map(row));
    let verdict = if calibration.prefers_fragment() { "drawn" } else { "dispatched" };
    let options = [("half", "a pyramid", calibration.half), ("subgroups", "a meter", calibration.subgroups)];
    let gains: String =
        options.iter().filter_map(|(option, work, gain)| Some(sentence(option, work, (*gain)?))).collect();
    let stored =
        kept.map_or("the calibration could not be stored".into(), |path| format!("stored in {}", path.display()));
    format!(
        "one point pass at {size} on {adapter}\n{table}\n\
         by default, point passes are now {verdict} here\n{gains}{stored}"
    )
}

fn sentence(option: &str, work: &str, gain: Gain) -> String {
    let Gain { without_ms, with_ms } = gain;
    let verdict = if gain.pays() { "on" } else { "off" };
    format!(
        "{work} takes {with_ms:.4} ms with `--{option}` and {without_ms:.4} ms without: \
         by default it is now {verdict}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::{Calibration, Gain, StageTimes};

    #[test]
    fn draws_are_preferred_if_they_are_faster_by_more_than_noise() {
        let of = |compute_ms, fragment_ms| Calibration {
            formats: [("f".into(), StageTimes { compute_ms, fragment_ms })].into(),
            ..Calibration::default()
        };
        assert!(of(1.0, 0.9).prefers_fragment());
        assert!(!of(1.0, 0.97).prefers_fragment());
        assert!(!of(1.0, 20.0).prefers_fragment());
        assert!(!Calibration::default().prefers_fragment());
    }

    #[test]
    fn an_option_pays_if_it_is_faster_by_more_than_noise() {
        let gain = |with_ms| Gain { without_ms: 1.0, with_ms };
        assert_eq!([0.5, 0.94, 0.96, 1.1].map(|with_ms| gain(with_ms).pays()), [true, true, false, false]);
    }

    #[test]
    fn calibrations_of_earlier_versions_are_read() {
        let known =
            serde_json::from_str::<Calibration>(r#"{"formats": {}}"#).expect("missing figures are not measured");
        assert_eq!(known, Calibration::default());
    }
}
