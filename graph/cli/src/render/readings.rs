//! What `render` reports of each frame: the metered exposure and the repaired pixels.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use afterimage_gpu::Session;
use afterimage_graph::check::Graph;
use afterimage_media::write_atomic;
use afterimage_nodes::EV100_OF_LUMINANCE;
use serde::Serialize;

use super::repairs::Repairs;
use crate::failure::Failure;

/// The kinds whose value is an exposure: stops, metered mean in log2, lux, and 1 once they are valid.
const METERS: [&str; 2] = ["Adapt", "AutoExposure"];

/// The reading of a meter after a frame.
#[derive(Clone, Debug, Serialize)]
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

/// What is reported of a frame.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FrameReport {
    /// Its number in the sequence.
    pub(crate) frame: Option<u32>,
    /// The files that it was written to.
    pub(crate) files: Vec<PathBuf>,
    /// None if the exposure is manual, or if nothing was metered yet.
    pub(crate) exposure: Vec<Reading>,
    /// Pixels of each input that the graph repaired.
    pub(crate) repaired: BTreeMap<String, Repairs>,
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
        if let Some([stops, mean, lux, 1.0]) = session.value(&format!("{meter}.result"))? {
            readings.push(Reading { meter: meter.clone(), stops, ev100: mean + EV100_OF_LUMINANCE, lux });
        }
    }
    Ok(readings)
}

/// The summary of all frames, a line for each meter and for each input with repaired pixels.
pub(crate) fn summary(frames: &[FrameReport]) -> Vec<String> {
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

/// Writes the reports of all frames.
pub(crate) fn write_json(path: &Path, frames: &[FrameReport]) -> Result<(), Failure> {
    let text = serde_json::json!({ "frames": frames });
    Ok(write_atomic(path, format!("{text:#}\n").as_bytes())?)
}
