//! The report of `render`: of each frame its outcome, the metered exposure and the repaired pixels; of the run what
//! made it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use afterimage::offline::Session;
use afterimage_graph::check::Graph;
use afterimage_media::{Repairs, write_atomic};
use afterimage_nodes::EV100_OF_LUMINANCE;
use serde::Serialize;

use super::jobs::Job;
use crate::failure::Failure;

/// The kinds whose value is an exposure: stops, metered mean in log2, lux, and 1 once they are valid.
const METERS: [&str; 2] = ["Adapt", "AutoExposure"];

/// The reading of a meter after a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Reading {
    /// The node.
    pub(crate) meter: String,
    /// The exposure in stops: log2 of its factor.
    pub(crate) stops: f32,
    /// The metered brightness, for luminance in cd/m2.
    pub(crate) ev100: f32,
    /// The estimated illuminance.
    pub(crate) lux: f32,
}

/// The outcome of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Outcome {
    /// All of its files are written.
    Good,
    /// Its files existed.
    Skipped,
    /// It could not be read, rendered or written.
    Failed,
    /// It was rendered, and the run ended before it was written.
    Unwritten,
}

/// The report of a frame.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FrameReport {
    /// Its number in the sequence.
    pub(crate) frame: Option<u32>,
    /// The files that it was written to.
    pub(crate) files: Vec<PathBuf>,
    pub(crate) outcome: Outcome,
    /// The error, if it failed.
    pub(crate) error: Option<String>,
    /// Time of rendering, without reading and writing.
    pub(crate) seconds: f64,
    /// None if the exposure is manual, or if nothing was metered yet.
    pub(crate) exposure: Vec<Reading>,
    /// Pixels of each input that the graph repaired.
    pub(crate) repaired: BTreeMap<String, Repairs>,
}

impl FrameReport {
    /// Of a frame that was not rendered.
    pub(super) fn without_picture(job: &Job, outcome: Outcome, error: Option<String>) -> Self {
        let (files, exposure, repaired) = (job.out.clone(), Vec::new(), BTreeMap::new());
        Self { frame: job.frame, files, outcome, error, seconds: 0.0, exposure, repaired }
    }
}

/// The report of a run, also of one that fails.
#[derive(Default)]
pub(crate) struct Report {
    /// The adapter and its driver, once the device is open.
    pub(super) adapter: Option<[String; 2]>,
    /// The hash of the plan of the first frame.
    pub(super) plan: Option<String>,
    /// The frames that are written, by the index of their job.
    pub(super) frames: BTreeMap<usize, FrameReport>,
    /// The frames whose files existed.
    pub(super) skipped: Vec<FrameReport>,
}

impl Report {
    /// Notes what has become of each file of a frame.
    pub(super) fn note_written(&mut self, written: Vec<(usize, Option<String>)>, files: usize) {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, error) in written {
            let count = counts.entry(index).or_default();
            *count += 1;
            let Some(frame) = self.frames.get_mut(&index) else { continue };
            match error {
                Some(error) => (frame.outcome, frame.error) = (Outcome::Failed, Some(error)),
                None if *count == files && frame.outcome == Outcome::Unwritten => frame.outcome = Outcome::Good,
                None => {}
            }
        }
    }

    /// The number of frames with this outcome.
    pub(super) fn count(&self, outcome: Outcome) -> usize {
        self.all().filter(|frame| frame.outcome == outcome).count()
    }

    fn all(&self) -> impl Iterator<Item = &FrameReport> {
        self.skipped.iter().chain(self.frames.values())
    }

    /// The number of frames with repaired pixels.
    fn repaired(&self) -> usize {
        self.all().filter(|frame| frame.repaired.values().any(|repairs| !repairs.is_none())).count()
    }

    /// The summary of all frames: a line for each meter and for each input with repaired pixels, and for a sequence one
    /// with the outcomes.
    pub(super) fn summary(&self) -> Vec<String> {
        let mut lines = summary(self.all());
        if self.all().any(|frame| frame.frame.is_some()) {
            let [good, skipped, failed, unwritten] =
                [Outcome::Good, Outcome::Skipped, Outcome::Failed, Outcome::Unwritten].map(|one| self.count(one));
            let unwritten = if unwritten > 0 { format!(", {unwritten} not written") } else { String::new() };
            let repaired = self.repaired();
            lines.push(format!(
                "frames: {good} good, {skipped} skipped, {failed} failed{unwritten}; {repaired} repaired"
            ));
        }
        lines
    }

    /// Writes the report of a run that has taken so long, and why it failed, if it did.
    pub(super) fn write_json(
        &self,
        path: &Path,
        pipeline: &Path,
        seconds: f64,
        failure: Option<&Failure>,
    ) -> Result<(), Failure> {
        let mut frames: Vec<&FrameReport> = self.all().collect();
        frames.sort_by_key(|frame| frame.frame);
        let [adapter, driver] = match &self.adapter {
            Some([adapter, driver]) => [Some(adapter), Some(driver)],
            None => [None, None],
        };
        let text = serde_json::json!({
            "adapter": adapter,
            "driver": driver,
            "failure": failure.map(Failure::message),
            "frames": frames,
            "pipeline": pipeline.display().to_string(),
            "plan": self.plan,
            "seconds": seconds,
            "summary": {
                "failed": self.count(Outcome::Failed),
                "good": self.count(Outcome::Good),
                "repaired": self.repaired(),
                "skipped": self.count(Outcome::Skipped),
                "unwritten": self.count(Outcome::Unwritten),
            },
            "version": env!("CARGO_PKG_VERSION"),
        });
        Ok(write_atomic(path, format!("{text:#}\n").as_bytes())?)
    }
}

/// The names of the nodes that meter.
pub(crate) fn meters(graph: &Graph) -> Vec<String> {
    let meters = graph.nodes.iter().filter(|node| METERS.contains(&node.kind().name()));
    meters.map(|node| node.name.clone()).collect()
}

/// The readings of these meters after the last frame. Waits for the GPU.
pub(crate) fn read_meters(session: &Session, meters: &[String]) -> Result<Vec<Reading>, Failure> {
    let mut readings = Vec::new();
    for meter in meters {
        readings.extend(reading(meter, session.value(&value_of(meter))?));
    }
    Ok(readings)
}

/// The name of the value of a meter.
pub(crate) fn value_of(meter: &str) -> String {
    format!("{meter}.result")
}

/// The reading of a meter with that value; `None` before it is valid.
pub(crate) fn reading(meter: &str, value: Option<[f32; 4]>) -> Option<Reading> {
    let Some([stops, mean, lux, 1.0]) = value else { return None };
    Some(Reading { meter: meter.to_owned(), stops, ev100: mean + EV100_OF_LUMINANCE, lux })
}

/// A line for each meter and for each input with repaired pixels.
fn summary<'a>(frames: impl Iterator<Item = &'a FrameReport>) -> Vec<String> {
    let mut meters: BTreeMap<&str, Vec<&Reading>> = BTreeMap::new();
    let mut repairs: BTreeMap<&str, Repairs> = BTreeMap::new();
    for frame in frames {
        frame.exposure.iter().for_each(|reading| meters.entry(&reading.meter).or_default().push(reading));
        for (input, repaired) in &frame.repaired {
            let sum = repairs.entry(input).or_default();
            *sum = sum.and(*repaired);
        }
    }
    let exposures = meters.iter().map(|(meter, readings)| exposure_line(meter, readings));
    let repaired = repairs.iter().filter(|(_, repaired)| !repaired.is_none());
    let repaired = repaired.map(|(input, repaired)| format!("repaired pixels of `{input}`: {repaired}"));
    exposures.chain(repaired).collect()
}

fn exposure_line(meter: &str, readings: &[&Reading]) -> String {
    let range = |of: fn(&Reading) -> f32| {
        let (least, most) = readings.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), reading| {
            (least.min(of(reading)), most.max(of(reading)))
        });
        if least == most { format!("{least:.2}") } else { format!("{least:.2} to {most:.2}") }
    };
    format!("exposure of `{meter}`: {} stops, at EV100 {}", range(|r| r.stops), range(|r| r.ev100))
}
