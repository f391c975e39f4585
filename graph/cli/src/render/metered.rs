//! Measurements of the meters of a pipeline in each frame: the files that `meter` writes and `render --meter` reads.
//!
//! A frame is a line of JSON, so files of several machines are joined line by line, in any order.

use std::collections::BTreeMap;
use std::path::Path;

use afterimage_media::sequence::Pattern;
use afterimage_media::{read_text, run_files, write_atomic};
use afterimage_plan::{Metering, Plan, StateContent, StateItem};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::jobs::tell_other_numbers;
use crate::failure::Failure;
use crate::frame_ranges::ranges;

/// The most bytes of a file: those of 100,000 frames.
const MAX_BYTES: u64 = 256 << 20;
/// The version of the format.
const VERSION: u32 = 1;

/// The measurements of a frame.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct MeteredFrame {
    /// The version of the format.
    afterimage_meter: u32,
    /// The number of the frame.
    pub(super) frame: u32,
    /// The exposure of the frame without those before it, for people.
    #[serde(skip_deserializing)]
    exposure: Value,
    /// The hash of the passes that have measured.
    passes: String,
    /// The words of each buffer: counts, or the bits of 32-bit floats.
    measured: BTreeMap<String, Vec<u32>>,
}

impl MeteredFrame {
    pub(super) fn new(plan: &Plan, metering: &Metering, frame: u32, exposure: Value, measured: &[Vec<u8>]) -> Self {
        let names = plan.buffer_names();
        let mut words = BTreeMap::new();
        for (buffer, bytes) in metering.measured.iter().zip(measured) {
            let name = names[buffer.0 as usize].clone();
            words.insert(name, bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect());
        }
        let passes = plan.measuring_hash(metering).to_string();
        Self { afterimage_meter: VERSION, frame, exposure, passes, measured: words }
    }

    /// The bytes of the buffers of a plan.
    ///
    /// # Errors
    /// Another plan has measured.
    pub(super) fn for_plan(&self, plan: &MeasuringPlan) -> Result<Vec<Vec<u8>>, Failure> {
        let mut measured = Vec::new();
        for (name, bytes) in &plan.buffers {
            let words = self.measured.get(name).filter(|words| 4 * words.len() == *bytes);
            measured.extend(words.map(|words| bytemuck::cast_slice::<u32, u8>(words).to_vec()));
        }
        match self.passes == plan.passes && measured.len() == plan.buffers.len() {
            true => Ok(measured),
            false => Err(Failure::user(format!("`--meter`: frame {} was measured by other passes", self.frame))
                .hint("measure it with the same pipeline, options, size, adapter and program")),
        }
    }

    /// The line of a file.
    pub(super) fn line(&self) -> String {
        let line = serde_json::to_string(self).expect("a frame has names and numbers only");
        format!("{line}\n")
    }
}

/// The plan that measured frames must fit.
pub(super) struct MeasuringPlan {
    /// The hash of the passes that measure.
    passes: String,
    /// The names of the buffers and their bytes.
    buffers: Vec<(String, usize)>,
}

impl MeasuringPlan {
    pub(super) fn new(plan: &Plan, metering: &Metering) -> Self {
        let names = plan.buffer_names();
        let measured = metering.measured.iter().map(|buffer| buffer.0 as usize);
        let buffers = measured.map(|buffer| (names[buffer].clone(), plan.buffers[buffer].bytes as usize));
        Self { passes: plan.measuring_hash(metering).to_string(), buffers: buffers.collect() }
    }
}

/// The measurements of a sequence.
pub(super) struct Metered {
    /// The name on the command line.
    name: String,
    frames: BTreeMap<u32, MeteredFrame>,
}

impl Metered {
    /// Reads a file, or all files of a numbered name.
    pub(super) fn read(name: &str) -> Result<Self, Failure> {
        let pattern = if Path::new(name).is_file() { None } else { Pattern::parse(name)? };
        let paths = match &pattern {
            Some(pattern) => pattern.frames()?.into_iter().map(|frame| pattern.at(frame)).collect(),
            None => vec![name.into()],
        };
        tell_other_numbers(name);
        let mut frames = BTreeMap::new();
        for path in &paths {
            for frame in frames_of(path)? {
                match frames.get(&frame.frame) {
                    Some(known) if *known != frame => {
                        let number = frame.frame;
                        return Err(Failure::user(format!("{name}: frame {number} was measured twice, differently"))
                            .hint("keep one of the lines"));
                    }
                    _ => drop(frames.insert(frame.frame, frame)),
                }
            }
        }
        Ok(Self { name: name.to_owned(), frames })
    }

    /// The first frame.
    pub(super) fn first(&self) -> Option<u32> {
        self.frames.keys().next().copied()
    }

    /// The least distance of two frames.
    pub(super) fn step(&self) -> Option<u32> {
        let numbers: Vec<u32> = self.frames.keys().copied().collect();
        numbers.windows(2).map(|pair| pair[1] - pair[0]).min()
    }

    /// The measurements of these frames, from which the state at frame `first` follows.
    ///
    /// # Errors
    /// Some are missing.
    pub(super) fn take(mut self, needed: &[u32], first: u32) -> Result<Vec<MeteredFrame>, Failure> {
        let missing: Vec<u32> = needed.iter().copied().filter(|frame| !self.frames.contains_key(frame)).collect();
        if missing.is_empty() {
            return Ok(needed.iter().filter_map(|frame| self.frames.remove(frame)).collect());
        }
        let name = &self.name;
        let (frames, are) = if missing.len() == 1 { ("frame", "is") } else { ("frames", "are") };
        let missing = ranges(&missing);
        Err(Failure::user(format!("{name}: frame {first} follows from {frames} {missing}, which {are} not measured"))
            .hint(format!(
                "measure them: `afterimage meter ... --frames {missing}`; `--cut` names frames that begin anew"
            )))
    }
}

/// The frames of a file.
fn frames_of(path: &Path) -> Result<Vec<MeteredFrame>, Failure> {
    run_files::reads(path, "a file of `--meter`");
    parse(path, &read_text(path, MAX_BYTES)?)
}

fn parse(path: &Path, text: &str) -> Result<Vec<MeteredFrame>, Failure> {
    let mut frames = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let wrong = |why: String| {
            let (path, line) = (path.display(), index + 1);
            Failure::unreadable(format!("{path}:{line}: this is no measured frame: {why}"))
        };
        let frame: MeteredFrame = serde_json::from_str(line).map_err(|error| wrong(error.to_string()))?;
        if frame.afterimage_meter != VERSION {
            return Err(wrong("another version of the program wrote it".to_owned()));
        }
        frames.push(frame);
    }
    Ok(frames)
}

/// Writes frames, each to a file of its own or all to one.
pub(super) fn write_frames(path: &Path, frames: &[MeteredFrame]) -> Result<(), Failure> {
    let text: String = frames.iter().map(MeteredFrame::line).collect();
    Ok(write_atomic(path, text.as_bytes())?)
}

/// True if some state of a plan follows from what frames measure, each alone.
pub(super) fn has_meter(plan: &Plan) -> bool {
    !plan.metering().state.is_empty()
}

/// The state that does not follow from what frames measure, each alone.
pub(super) fn unmetered(plan: &Plan) -> impl Iterator<Item = StateItem> + use<> {
    let metered = plan.metering().state;
    plan.state().into_iter().filter(move |item| match item.content {
        StateContent::Buffer { buffer, .. } => !metered.contains(&buffer),
        StateContent::History { .. } => true,
    })
}

/// The error of a plan whose frames cannot be measured.
pub(super) fn no_meter(plan: &Plan) -> Failure {
    let state = plan.state();
    if state.is_empty() {
        return Failure::user("this pipeline has no meter, and each of its frames is rendered alone")
            .hint("render any range of frames");
    }
    let names = names(&state);
    Failure::user(format!("this pipeline has no meter that measures a frame alone: earlier frames make {names}"))
        .hint("`--preroll COUNT` renders frames before the range")
}

/// The names of items as a list.
pub(super) fn names<'a>(items: impl IntoIterator<Item = &'a StateItem>) -> String {
    let names: Vec<String> = items.into_iter().map(|item| format!("`{}`", item.name)).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use afterimage_graph::check::{Checker, NoFiles};
    use afterimage_graph::document;
    use afterimage_graph::image::Size;
    use afterimage_graph::node::Registry;

    use super::*;
    use crate::pipeline::plan_without_device;

    const METERED: &str = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "mean": MeanLuminance(source: "scene"),
            "meter": Adapt(mean: "mean"),
            "lit": Exposure(source: "scene", meter: "meter"),
        },
        outputs: { "light": "lit" },
    )"#;

    #[test]
    fn a_frame_with_any_byte_changed_is_refused_or_fits_the_plan() {
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names differ");
        let document = document::parse("meter.ron", METERED).expect("it is a pipeline");
        let checked = Checker::new(&document, &registry, &NoFiles).check(None, &[]);
        let (graph, _) = checked.unwrap_or_else(|errors| panic!("{errors:?}"));
        let plan = plan_without_device(&graph, Size::new(64, 32), Default::default(), Default::default());
        let plan = plan.expect("it can be planned");
        let metering = plan.metering();
        let sizes: Vec<usize> =
            metering.measured.iter().map(|buffer| plan.buffers[buffer.0 as usize].bytes as usize).collect();
        let zeros: Vec<Vec<u8>> = sizes.iter().map(|bytes| vec![0; *bytes]).collect();
        let fit = MeasuringPlan::new(&plan, &metering);
        let line = MeteredFrame::new(&plan, &metering, 7, Value::Null, &zeros).line();
        let (mut seed, mut fitting, mut refused) = (1_u32, 0, 0);
        for at in 0..line.len() {
            for _ in 0..8 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let mut bytes = line.clone().into_bytes();
                bytes[at] = b' ' + (seed >> 24) as u8 % 95;
                let text = String::from_utf8(bytes).expect("it is ASCII");
                for frame in parse(Path::new("a.meter"), &text).unwrap_or_default() {
                    match frame.for_plan(&fit) {
                        Ok(bytes) => {
                            assert!(bytes.iter().map(Vec::len).eq(sizes.iter().copied()), "{text}");
                            fitting += 1;
                        }
                        Err(_) => refused += 1,
                    }
                }
            }
        }
        assert!(fitting > 0 && refused > 0, "{fitting} {refused}");
    }
}
