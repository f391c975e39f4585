//! One variant on one clip, beside the truth.

use afterimage_graph::check::{Graph, GraphOutput, Source};
use afterimage_graph::image::{ColorState, Format};

use super::clips::Clip;
use super::errors::{Errors, Follower, SHARE, errors};
use super::runner::{Cost, Runner};
use super::view::View;
use crate::failure::Failure;
use afterimage_lab::metrics::{Shown, difference, percentile};

/// The frames of the truth on one clip.
pub(crate) struct Truth {
    pub(crate) frames: Vec<Shown>,
    /// The output that is judged.
    output: String,
}

/// What is measured of a variant on one clip, or the worst of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Figures {
    pub(crate) cost: Cost,
    pub(crate) errors: Errors,
}

impl Figures {
    /// The worse of each.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self { cost: self.cost.worst(other.cost), errors: self.errors.worst(other.errors) }
    }
}

/// The output to judge: the named one, the first encoded one, or the first.
pub(crate) fn output<'g>(graph: &'g Graph, wanted: Option<&str>) -> Result<&'g GraphOutput, Failure> {
    let encoded = graph.outputs.iter().find(|output| output.state == ColorState::Encoded);
    match wanted {
        None => encoded.or(graph.outputs.first()).ok_or_else(|| Failure::user("the pipeline has no output to judge")),
        Some(name) => graph.outputs.iter().find(|output| output.name == name).ok_or_else(|| {
            let known: Vec<String> = graph.outputs.iter().map(|output| format!("`{}`", output.name)).collect();
            Failure::user(format!("the pipeline has no output `{name}`")).hint(format!("it has {}", known.join(", ")))
        }),
    }
}

/// The pipeline as its errors are judged: an encoded output before it is dithered and rounded to codes.
///
/// Dither moves a thousandth of a code to a whole one in one pixel of a thousand, so behind it no error is between 0 and 1.
pub(crate) fn judged(graph: &Graph, output: &str) -> Graph {
    let mut graph = graph.clone();
    let Some(output) = graph.outputs.iter().find(|known| known.name == output) else { return graph };
    let (mut source, is_encoded) = (output.source, output.state == ColorState::Encoded);
    while let Source::Node { node, .. } = source
        && is_encoded
    {
        let node = &mut graph.nodes[node];
        let wire = node.wires.iter().flatten().next().copied();
        match wire.filter(|_| node.kind.name() == "Dither") {
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

impl Truth {
    /// Renders the truth; its plan is loaded.
    pub(crate) fn render(runner: &mut Runner<'_>, clip: &Clip, view: View, output: &str) -> Result<Self, Failure> {
        let mut truth = Self { frames: Vec::new(), output: output.to_owned() };
        for frame in 0..clip.len() {
            let shown = truth.shown(runner, clip, view, frame)?;
            truth.frames.push(shown);
        }
        Ok(truth)
    }

    /// The name of the output that is judged.
    pub(crate) fn output(&self) -> &str {
        &self.output
    }

    /// Renders a frame of the loaded plan.
    pub(crate) fn shown(
        &self,
        runner: &mut Runner<'_>,
        clip: &Clip,
        view: View,
        frame: usize,
    ) -> Result<Shown, Failure> {
        runner.render(clip, frame)?;
        let shown = view.shown(&runner.output(&self.output)?).ok_or_else(|| {
            Failure::user(format!("the output `{}` has numbers that are not finite, on `{}`", self.output, clip.name))
                .hint("a node of the pipeline lets them through; `afterimage stress` finds which")
        })?;
        self.same_size(&shown)?;
        Ok(shown)
    }

    fn same_size(&self, shown: &Shown) -> Result<(), Failure> {
        match self.frames.first() {
            Some(truth) if (truth.width, truth.height) != (shown.width, shown.height) => {
                let sizes = format!("{}x{}, the truth's {}x{}", shown.width, shown.height, truth.width, truth.height);
                Err(Failure::user(format!("the output `{}` is {sizes}", self.output))
                    .hint("only pictures of one size can be compared; choose another output with `--output`"))
            }
            _ => Ok(()),
        }
    }

    /// All errors of the loaded plan; `also` sees each frame and its number.
    pub(crate) fn errors(
        &self,
        runner: &mut Runner<'_>,
        clip: &Clip,
        view: View,
        mut also: impl FnMut(usize, &Shown) -> Result<(), Failure>,
    ) -> Result<Errors, Failure> {
        let mut worst = Errors::NONE;
        let mut follower = Follower::default();
        for (frame, truth) in self.frames.iter().enumerate() {
            let shown = self.shown(runner, clip, view, frame)?;
            also(frame, &shown)?;
            let flicker = if self.frames.len() > 1 { follower.next(truth, &shown) } else { None };
            worst = worst.worst(Errors { flicker, ..errors(truth, &shown) });
        }
        Ok(worst)
    }

    /// Only the 99.9 percentile and the maximum of the loaded plan's error, in codes.
    pub(crate) fn codes_off(&self, runner: &mut Runner<'_>, clip: &Clip, view: View) -> Result<(f64, f64), Failure> {
        let mut worst = (0.0_f64, 0.0_f64);
        for (frame, truth) in self.frames.iter().enumerate() {
            let shown = self.shown(runner, clip, view, frame)?;
            let off = difference(&truth.codes(), &shown.codes());
            worst = (worst.0.max(percentile(&off, SHARE)), worst.1.max(percentile(&off, 1.0)));
        }
        Ok(worst)
    }
}
