//! One variant on one sequence, compared with the reference.

use afterimage::offline::Session;
use afterimage_graph::check::{Graph, GraphOutput, Source};
use afterimage_graph::image::{ColorState, Format};

use super::errors::{ErrorTrace, Errors, SHARE, errors};
use super::sequence_runner::Cost;
use super::sequences::TestSequence;
use super::view::View;
use crate::LabError;
use crate::metrics::{Display, Shown, difference, jod, percentile};

/// The frames of the reference on one sequence.
pub(crate) struct Reference {
    pub(crate) frames: Vec<Shown>,
    codes: Vec<Vec<[f32; 3]>>,
    /// The output that is compared.
    output: String,
}

/// The 99.9th percentile and the largest error, in codes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CodeErrors {
    pub(crate) p999: f64,
    pub(crate) max: f64,
}

/// The figures of a variant on one sequence, or the worst of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    pub cost: Cost,
    pub errors: Errors,
}

impl Figures {
    /// The worse of each figure.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self { cost: self.cost.worst(other.cost), errors: self.errors.worst(other.errors) }
    }
}

/// The output to compare: the named one, the first encoded one, or the first.
pub(crate) fn output<'g>(graph: &'g Graph, name: Option<&str>) -> Result<&'g GraphOutput, LabError> {
    let encoded = graph.outputs.iter().find(|output| output.state == ColorState::Encoded);
    match name {
        None => {
            encoded.or(graph.outputs.first()).ok_or_else(|| LabError::request("the pipeline has no output to compare"))
        }
        Some(name) => graph.outputs.iter().find(|output| output.name == name).ok_or_else(|| {
            let known: Vec<String> = graph.outputs.iter().map(|output| format!("`{}`", output.name)).collect();
            LabError::request(format!("the pipeline has no output `{name}`"))
                .hint(format!("it has {}", known.join(", ")))
        }),
    }
}

/// The pipeline as its errors are measured: an encoded output before dither and quantization.
///
/// Dither turns an error of a thousandth of a code into one of a whole code in one pixel of a thousand, so behind it no
/// error lies between 0 and 1.
pub(crate) fn before_quantization(graph: &Graph, output: &str) -> Graph {
    let mut graph = graph.clone();
    let Some(output) = graph.outputs.iter().find(|known| known.name == output) else { return graph };
    let (mut source, is_encoded) = (output.source, output.state == ColorState::Encoded);
    while let Source::Node { node, .. } = source
        && is_encoded
    {
        let node = &mut graph.nodes[node];
        let wire = node.wires.iter().flatten().next().copied();
        match wire.filter(|_| node.kind().name() == "Dither") {
            Some(wire) => {
                node.off = true;
                source = wire;
            }
            None => {
                node.format = Some(Format::Rgba32Float);
                break;
            }
        }
    }
    graph
}

impl Reference {
    /// Renders the reference, whose plan is loaded.
    pub(crate) fn render(
        session: &mut Session,
        sequence: &TestSequence,
        view: View,
        output: &str,
    ) -> Result<Self, LabError> {
        let mut reference = Self { frames: Vec::new(), codes: Vec::new(), output: output.to_owned() };
        for frame in 0..sequence.len() {
            let shown = reference.shown(session, sequence, view, frame)?;
            reference.codes.push(shown.codes());
            reference.frames.push(shown);
        }
        Ok(reference)
    }

    /// The name of the output that is compared.
    pub(crate) fn output(&self) -> &str {
        &self.output
    }

    /// Renders a frame of the plan that is just loaded, and those before it.
    pub(crate) fn frame(
        &self,
        session: &mut Session,
        sequence: &TestSequence,
        view: View,
        frame: usize,
    ) -> Result<Shown, LabError> {
        for before in 0..frame {
            session.submit(sequence.images(before), sequence.step(before))?;
        }
        self.shown(session, sequence, view, frame)
    }

    /// Renders the next frame of the loaded plan.
    pub(crate) fn shown(
        &self,
        session: &mut Session,
        sequence: &TestSequence,
        view: View,
        frame: usize,
    ) -> Result<Shown, LabError> {
        session.submit(sequence.images(frame), sequence.step(frame))?;
        let shown = view.shown(&session.output(&self.output)?).ok_or_else(|| {
            LabError::request(format!(
                "the output `{}` has values that are not finite, on `{}`",
                self.output, sequence.name
            ))
            .hint("a node of the pipeline lets them through; `afterimage stress` finds which")
        })?;
        self.check_size(&shown)?;
        Ok(shown)
    }

    fn check_size(&self, shown: &Shown) -> Result<(), LabError> {
        match self.frames.first() {
            Some(first) if (first.width, first.height) != (shown.width, shown.height) => {
                let sizes = format!("{}x{}, the reference {}x{}", shown.width, shown.height, first.width, first.height);
                Err(LabError::request(format!("the output `{}` is {sizes}", self.output))
                    .hint("only images of one size can be compared; choose another output with `--output`"))
            }
            _ => Ok(()),
        }
    }

    /// All errors of the loaded plan, as seen on a display; `also` gets each frame and its number.
    pub(crate) fn errors(
        &self,
        session: &mut Session,
        sequence: &TestSequence,
        view: View,
        display: &Display,
        mut also: impl FnMut(usize, &Shown) -> Result<(), LabError>,
    ) -> Result<Errors, LabError> {
        let mut worst = Errors::NONE;
        let mut trace = ErrorTrace::default();
        let mut frames = Vec::with_capacity(self.frames.len());
        for (frame, reference) in self.frames.iter().enumerate() {
            let shown = self.shown(session, sequence, view, frame)?;
            also(frame, &shown)?;
            let flicker = if self.frames.len() > 1 { trace.next(reference, &shown) } else { None };
            worst = worst.worst(Errors { flicker, ..errors(reference, &shown) });
            frames.push(shown);
        }
        let fps = 1.0 / sequence.step(frames.len() - 1).dt;
        Ok(Errors { jod: jod(&self.frames, &frames, fps, display)?, ..worst })
    }

    /// The errors in codes of the loaded plan, the worst of the first `count` frames.
    pub(crate) fn code_errors(
        &self,
        session: &mut Session,
        sequence: &TestSequence,
        view: View,
        count: usize,
    ) -> Result<CodeErrors, LabError> {
        let mut worst = CodeErrors::default();
        for (frame, reference) in self.codes.iter().take(count).enumerate() {
            let differences = difference(reference, &self.shown(session, sequence, view, frame)?.codes());
            worst.p999 = worst.p999.max(percentile(&differences, SHARE));
            worst.max = worst.max.max(percentile(&differences, 1.0));
        }
        Ok(worst)
    }
}
