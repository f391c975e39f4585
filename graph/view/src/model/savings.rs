//! GPU time that each node would save if it were off: a second pipeline runs without the node.

use std::collections::VecDeque;

use afterimage_gpu::wgpu;
use afterimage_graph::check::Graph;

use super::{Chain, FrameImages, Moment};

/// Frames that a median is taken from.
const FRAMES: usize = 24;
/// Frames before them, in which caches and clocks settle.
const UNTIMED: usize = 4;

/// What a node would save.
#[derive(Clone, Debug)]
pub struct Saving {
    pub node: String,
    /// Milliseconds of GPU time for a frame, or why the pipeline cannot do without the node. A small number may be
    /// below zero: both times vary.
    pub ms: Result<f64, String>,
}

/// The measurement, node by node.
pub struct Savings {
    graph: Graph,
    waiting: VecDeque<String>,
    trial: Option<Trial>,
    found: Vec<Saving>,
}

/// The pipeline without a node.
struct Trial {
    node: String,
    chain: Chain,
    without: Times,
    with: Times,
}

#[derive(Default)]
struct Times {
    last: u64,
    count: usize,
    ms: Vec<f64>,
}

impl Times {
    /// Takes the newest time of a chain.
    fn take(&mut self, chain: &Chain) {
        let Some(times) = chain.pass_times().filter(|times| times.frame != self.last) else { return };
        (self.last, self.count) = (times.frame, self.count + 1);
        if self.count > UNTIMED {
            self.ms.push(times.sum());
        }
    }

    fn median(&self) -> Option<f64> {
        let mut sorted = self.ms.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().filter(|_| sorted.len() >= FRAMES)
    }
}

impl Savings {
    /// Measures the nodes that run in a chain.
    pub(super) fn of(shown: &Chain, graph: Graph) -> Option<Self> {
        let plan = shown.plan()?;
        let runs = |name: &str| !plan.skipped.iter().any(|skipped| skipped.node == name);
        let nodes = graph.nodes.iter().filter(|node| !node.off && runs(&node.name));
        let waiting = nodes.map(|node| node.name.clone()).collect();
        Some(Self { graph, waiting, trial: None, found: Vec::new() })
    }

    /// What is known so far.
    pub fn found(&self) -> &[Saving] {
        &self.found
    }

    /// Nodes that are still to be measured.
    pub fn left(&self) -> usize {
        self.waiting.len() + usize::from(self.trial.is_some())
    }

    /// Records a frame of the pipeline without the present node.
    pub(super) fn frame(
        &mut self,
        shown: &Chain,
        encoder: &mut wgpu::CommandEncoder,
        images: &FrameImages,
        moment: Moment,
    ) {
        if self.trial.is_none() {
            self.trial = self.waiting.pop_front().map(|node| Trial::new(shown, &self.graph, node));
        }
        let Some(trial) = &mut self.trial else { return };
        if let Some(ms) = trial.frame(shown, encoder, images, moment) {
            self.found.push(Saving { node: trial.node.clone(), ms });
            self.trial = None;
        }
    }
}

impl Trial {
    fn new(shown: &Chain, graph: &Graph, node: String) -> Self {
        let mut graph = graph.clone();
        graph.nodes.iter_mut().filter(|other| other.name == node).for_each(|node| node.off = true);
        Self { node, chain: shown.clone_with(graph), without: Times::default(), with: Times::default() }
    }

    /// Records a frame; the difference once it is known.
    fn frame(
        &mut self,
        shown: &Chain,
        encoder: &mut wgpu::CommandEncoder,
        images: &FrameImages,
        moment: Moment,
    ) -> Option<Result<f64, String>> {
        if let Err(problem) = self.chain.frame(encoder, images, moment) {
            return Some(Err(problem.to_string()));
        }
        self.with.take(shown);
        self.without.take(&self.chain);
        Some(Ok(self.with.median()? - self.without.median()?))
    }
}
