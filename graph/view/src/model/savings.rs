//! GPU time that each node would save if it were off: a second pipeline runs without the node.

use std::collections::VecDeque;

use afterimage_gpu::{MedianEstimate, wgpu};
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
    /// Milliseconds of GPU time that a frame without the node takes less, or why the pipeline cannot do without it. It
    /// may be below zero: both times vary.
    pub ms: Result<MedianEstimate, String>,
}

/// How the savings of all nodes compare with the time of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SavingsTotal {
    /// Milliseconds that the nodes save one by one, added up.
    pub sum: f64,
    /// Milliseconds of a frame with all nodes.
    pub frame: f64,
    /// How far sum and frame may be off together, with a confidence of 95 %.
    pub error: f64,
}

impl SavingsTotal {
    /// The part of the frame that no node saves alone; below zero if the nodes save more than the frame takes.
    pub fn rest(&self) -> f64 {
        self.frame - self.sum
    }

    /// Why the nodes do not add up to the frame.
    pub fn why(&self) -> &'static str {
        if self.rest().abs() <= self.error {
            "The nodes add up to the frame: the rest is within the error of the measurement."
        } else if self.rest() > 0.0 {
            "What several nodes share remains without any one of them: passes, images that are stored and read, and \
             the outputs."
        } else {
            "Without one node others cost less or do not run either, so that their time is counted for several nodes."
        }
    }
}

/// The measurement, node by node.
pub struct Savings {
    graph: Graph,
    waiting: VecDeque<String>,
    trial: Option<Trial>,
    found: Vec<Saving>,
    /// Milliseconds of the frames with all nodes.
    frames: Vec<f64>,
}

/// The pipeline without a node.
struct Trial {
    node: String,
    chain: Chain,
    times: PairedTimes,
}

/// Times of frames with and without a node, which were rendered one after the other. A clock frequency that changes
/// slowly does not change their difference.
#[derive(Default)]
struct PairedTimes {
    /// The numbers of the last frames, with and without the node.
    last: [u64; 2],
    /// Times that have no partner yet.
    alone: [Option<f64>; 2],
    count: usize,
    with: Vec<f64>,
    differences: Vec<f64>,
}

impl PairedTimes {
    /// Takes the newest time of each chain: the number of its frame and its milliseconds.
    fn take(&mut self, newest: [Option<(u64, f64)>; 2]) {
        for (index, newest) in newest.into_iter().enumerate() {
            if let Some((frame, ms)) = newest.filter(|(frame, _)| *frame != self.last[index]) {
                (self.last[index], self.alone[index]) = (frame, Some(ms));
            }
        }
        let [Some(with), Some(without)] = self.alone else { return };
        (self.alone, self.count) = ([None; 2], self.count + 1);
        if self.count > UNTIMED {
            self.with.push(with);
            self.differences.push(with - without);
        }
    }

    fn saving(&self) -> Option<MedianEstimate> {
        (self.differences.len() >= FRAMES).then(|| MedianEstimate::of(self.differences.clone()))
    }
}

impl Savings {
    /// Measures the nodes that run in a chain.
    pub(super) fn of(shown: &Chain, graph: Graph) -> Option<Self> {
        let plan = shown.plan()?;
        let runs = |name: &str| !plan.skipped.iter().any(|skipped| skipped.node == name);
        let nodes = graph.nodes.iter().filter(|node| !node.off && runs(&node.name));
        let waiting = nodes.map(|node| node.name.clone()).collect();
        Some(Self { graph, waiting, trial: None, found: Vec::new(), frames: Vec::new() })
    }

    /// What is known so far.
    pub fn found(&self) -> &[Saving] {
        &self.found
    }

    /// All of it, once every node is measured.
    pub fn total(&self) -> Option<SavingsTotal> {
        if self.left() > 0 {
            return None;
        }
        let savings = || self.found.iter().filter_map(|saving| saving.ms.as_ref().ok());
        let frame = MedianEstimate::of(self.frames.clone());
        // Errors of measurements that do not depend on each other add up by their squares.
        let squares = savings().chain([&frame]).map(|estimate| estimate.half_width().powi(2)).sum::<f64>();
        let sum = savings().map(|estimate| estimate.median).sum();
        Some(SavingsTotal { sum, frame: frame.median, error: squares.sqrt() })
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
            self.frames.append(&mut trial.times.with);
            self.trial = None;
        }
    }
}

impl Trial {
    fn new(shown: &Chain, graph: &Graph, node: String) -> Self {
        let mut graph = graph.clone();
        graph.nodes.iter_mut().filter(|other| other.name == node).for_each(|node| node.off = true);
        Self { node, chain: shown.clone_with(graph), times: PairedTimes::default() }
    }

    /// Records a frame; what the node saves, once it is known.
    fn frame(
        &mut self,
        shown: &Chain,
        encoder: &mut wgpu::CommandEncoder,
        images: &FrameImages,
        moment: Moment,
    ) -> Option<Result<MedianEstimate, String>> {
        if let Err(problem) = self.chain.frame(encoder, images, moment) {
            return Some(Err(problem.to_string()));
        }
        let newest = [shown, &self.chain].map(|chain| chain.pass_times().map(|times| (times.frame, times.sum())));
        self.times.take(newest);
        self.times.saving().map(Ok)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_slows_down_does_not_change_what_a_node_saves() {
        let mut times = PairedTimes::default();
        let mut frame = 0;
        while times.saving().is_none() {
            frame += 1;
            let slowness = 1.0 + 0.02 * frame as f64;
            // Times arrive now and then, and not always both.
            let with = Some((frame, 0.5 * slowness));
            let without = Some((frame, 0.5 * slowness - 0.1)).filter(|_| frame % 3 > 0);
            times.take([with, without]);
        }
        let saving = times.saving().expect("there are enough frames");
        assert!((saving.median - 0.1).abs() < 1e-9 && saving.half_width() < 1e-9, "{saving:?}");
    }

    #[test]
    fn savings_add_up_to_the_frame_or_a_sentence_states_why_not() {
        let total = |sum: f64| SavingsTotal { sum, frame: 1.0, error: 0.05 };
        assert!(total(0.97).why().contains("add up"));
        assert!(total(0.5).why().contains("share"));
        assert!(total(1.4).why().contains("several nodes"));
        for total in [total(0.97), total(0.5), total(1.4)] {
            assert!((total.sum + total.rest() - total.frame).abs() < 1e-12);
        }
    }
}
