//! All choices of all switches of a pipeline.

use afterimage_graph::check::Graph;
use afterimage_plan::Plan;

use crate::failure::Failure;
use crate::measure::runner::run_alike;
use crate::measure::variants::{Switch, switches, verify};

/// The switches that change something, each with at least two choices. A choice of all is the place of each switch's choice.
pub(crate) struct Space {
    pub(crate) switches: Vec<Switch>,
}

impl Space {
    /// Leaves out what makes no other plan than the choice before it.
    pub(super) fn new(written: &Graph, plan: &dyn Fn(&Graph) -> Result<Plan, Failure>) -> Result<Self, Failure> {
        let mut all = switches(written);
        let mut exact = written.clone();
        all.iter().for_each(|switch| switch.turn(&mut exact, 0));
        for switch in &mut all {
            let mut plans: Vec<Plan> = Vec::new();
            let mut kept = Vec::new();
            for at in 0..switch.choices.len() {
                let mut graph = exact.clone();
                switch.turn(&mut graph, at);
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

    /// Every switch at its most exact.
    pub(super) fn exact(&self) -> Vec<usize> {
        vec![0; self.switches.len()]
    }

    /// The pipeline with that choice.
    pub(super) fn graph(&self, written: &Graph, choice: &[usize]) -> Graph {
        let mut graph = written.clone();
        for (switch, at) in self.switches.iter().zip(choice) {
            switch.turn(&mut graph, *at);
        }
        graph
    }

    /// The choice in words: what differs from the most exact.
    pub(super) fn key(&self, choice: &[usize]) -> String {
        let turned = self.switches.iter().zip(choice).filter(|(_, at)| **at > 0);
        let words: Vec<String> = turned
            .map(|(switch, at)| format!("{}={}", switch.key, switch.choices[*at].text().unwrap_or_default()))
            .collect();
        if words.is_empty() { "most exact".to_owned() } else { words.join(" ") }
    }

    /// Names of all choices of all switches.
    pub(super) fn names(&self) -> Vec<String> {
        let name = |switch: &Switch| {
            let choices: Vec<String> =
                switch.choices.iter().map(|choice| choice.text().unwrap_or("(own)".into())).collect();
            format!("{}: {}", switch.key, choices.join(", "))
        };
        self.switches.iter().map(name).collect()
    }

    /// How many choices each switch has.
    pub(super) fn sizes(&self) -> Vec<usize> {
        self.switches.iter().map(|switch| switch.choices.len()).collect()
    }
}
