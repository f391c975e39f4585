//! All choices of the quality switches of a pipeline.

use std::sync::Arc;

use afterimage_graph::check::Graph;
use afterimage_plan::Plan;

use crate::LabError;
use crate::measure::sequence_runner::run_alike;
use crate::measure::variants::{Switch, switches, verify};

/// The switches that change the plan, each with at least two choices. A choice is an index for each switch.
pub(super) struct Space {
    switches: Vec<Switch>,
}

impl Space {
    /// All switches, without choices that give the same plan as another one.
    pub(super) fn new(
        written: &Graph,
        plan: &mut dyn FnMut(&Graph) -> Result<Arc<Plan>, LabError>,
    ) -> Result<Self, LabError> {
        let mut all = switches(written);
        let mut exact = written.clone();
        all.iter().for_each(|switch| switch.apply(&mut exact, 0));
        for switch in &mut all {
            let mut plans: Vec<Arc<Plan>> = Vec::new();
            let mut kept = Vec::new();
            for at in 0..switch.choices.len() {
                let mut graph = exact.clone();
                switch.apply(&mut graph, at);
                if at > 0 && verify(&graph).is_err() {
                    continue;
                }
                let plan = plan(&graph)?;
                if !plans.iter().any(|known| run_alike(known, &plan)) {
                    plans.push(plan);
                    kept.push(at);
                }
            }
            switch.keep(&kept);
        }
        all.retain(|switch| switch.choices.len() > 1);
        Ok(Self { switches: all })
    }

    /// Every switch at its most accurate.
    pub(super) fn most_accurate(&self) -> Vec<usize> {
        vec![0; self.switches.len()]
    }

    /// The pipeline with that choice.
    pub(super) fn graph(&self, written: &Graph, choice: &[usize]) -> Graph {
        let mut graph = written.clone();
        for (switch, at) in self.switches.iter().zip(choice) {
            switch.apply(&mut graph, *at);
        }
        graph
    }

    /// The choice as text: the switches that are not at their most accurate.
    pub(super) fn key(&self, choice: &[usize]) -> String {
        let changed = self.switches.iter().zip(choice).filter(|(_, at)| **at > 0);
        let words: Vec<String> = changed
            .map(|(switch, at)| format!("{}={}", switch.key, switch.choices[*at].text().unwrap_or_default()))
            .collect();
        if words.is_empty() { "most accurate".to_owned() } else { words.join(" ") }
    }

    /// Names of all choices of all switches.
    pub(super) fn names(&self) -> Vec<String> {
        let name = |switch: &Switch| {
            let choices: Vec<String> =
                switch.choices.iter().map(|choice| choice.text().unwrap_or("(default)".into())).collect();
            format!("{}: {}", switch.key, choices.join(", "))
        };
        self.switches.iter().map(name).collect()
    }

    /// The number of choices of each switch.
    pub(super) fn sizes(&self) -> Vec<usize> {
        self.switches.iter().map(|switch| switch.choices.len()).collect()
    }
}
