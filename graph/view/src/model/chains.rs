//! All pipelines that render a model's graph.

use afterimage_gpu::Gpu;
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::value::Value;

use super::{Chain, Changes, CompareWith, Purpose, Target};
use crate::Problem;

/// The pipelines on the device. All but the compared one have the present graph and its values.
#[derive(Default)]
pub(super) struct Chains {
    pub(super) shown: Option<Chain>,
    /// Stores every image.
    pub(super) inspected: Option<Chain>,
    /// Stores every image in 32 bits.
    pub(super) reference: Option<Chain>,
    /// Counts what functions of kinds in folders do wrong, if there are any.
    pub(super) counting: Option<Chain>,
    pub(super) compared: Option<(CompareWith, Chain)>,
}

impl Chains {
    fn of_graph(&mut self) -> impl Iterator<Item = &mut Chain> {
        [&mut self.shown, &mut self.inspected, &mut self.reference, &mut self.counting].into_iter().flatten()
    }

    pub(super) fn set_graph(&mut self, gpu: &Gpu, graph: &Graph, facts: &Facts) {
        if self.shown.is_none() {
            self.shown = Some(Chain::new(gpu, graph.clone(), Purpose::Show));
        }
        for chain in self.of_graph() {
            chain.change(graph.clone(), facts.clone());
        }
    }

    pub(super) fn set_facts(&mut self, facts: &Facts) {
        for chain in self.of_graph() {
            chain.post().set_facts(facts.clone());
        }
    }

    pub(super) fn set(&mut self, name: &str, value: &Value) -> Result<(), Problem> {
        let mut result = Ok(());
        for chain in self.of_graph() {
            result = result.and(chain.set(name, value));
        }
        result
    }

    /// Sets all parameters to the values of the graph, and then to those of the user.
    pub(super) fn reset_values(&mut self, changes: &Changes) {
        for chain in self.of_graph() {
            chain.forget_values();
            chain.set_changes(changes);
        }
    }

    pub(super) fn rebuild(&mut self, gpu: &Gpu) {
        for chain in self.of_graph() {
            chain.rebuild(gpu);
        }
        if let Some((_, chain)) = &mut self.compared {
            chain.rebuild(gpu);
        }
    }
}

impl Chain {
    /// Sets what the user has changed.
    pub(super) fn set_changes(&mut self, changes: &Changes) {
        for (target, value) in changes.iter() {
            if let Target::Parameter(name) = target {
                // Another tier, pipeline or text may have no such parameter, and keeps its own values.
                let _ = self.set(name, value);
            }
        }
    }
}
