//! The picture beside the shown one, to compare them.

use afterimage_gpu::wgpu;

use super::beside::CompareWith;
use super::{Chain, Model, Project, Purpose, Target};
use crate::Problem;

impl Model {
    /// What the shown picture is compared with.
    pub fn beside(&self) -> Option<&CompareWith> {
        self.beside.as_ref().map(|(beside, _)| beside)
    }

    /// Renders another picture beside the shown one, or no more. If it cannot be made, that is the problem.
    pub fn set_beside(&mut self, beside: Option<CompareWith>) {
        self.beside = None;
        let Some(beside) = beside else { return };
        match self.make_beside(&beside) {
            Ok(chain) => self.beside = Some((beside, chain)),
            Err(problem) => self.problem = Some(problem),
        }
        self.is_stale = true;
    }

    /// The texture of the picture beside.
    pub fn picture_beside(&self) -> Option<&wgpu::Texture> {
        self.beside.as_ref().and_then(|(_, chain)| chain.picture())
    }

    pub(super) fn renew_beside(&mut self) {
        let beside = self.beside.take().map(|(beside, _)| beside);
        self.set_beside(beside);
    }

    fn make_beside(&mut self, beside: &CompareWith) -> Result<Chain, Problem> {
        let no_pipeline = || Problem::said("there is no pipeline to compare with");
        let purpose = if *beside == CompareWith::Reference { Purpose::Reference } else { Purpose::Show };
        let graph = match beside {
            CompareWith::Written => self.graph.as_deref().cloned(),
            CompareWith::Reference => self.present_graph(),
            CompareWith::Tier(tier) => {
                let checked = self.project.check(self.changes.text(), tier.as_deref());
                Some(checked.map_err(Problem::Pipeline)?.graph)
            }
            CompareWith::Pipeline(name) => {
                let mut other = super::TextProject::built_in(name).ok_or_else(no_pipeline)?;
                let text = other.read().map_err(Problem::Pipeline)?;
                Some(other.check(&text, None).map_err(Problem::Pipeline)?.graph)
            }
        };
        let mut chain = Chain::new(&self.gpu, graph.ok_or_else(no_pipeline)?, purpose);
        chain.post().set_facts(self.facts.clone());
        if matches!(beside, CompareWith::Reference | CompareWith::Tier(_)) {
            self.give_values(&mut chain);
        }
        Ok(chain)
    }

    /// Sets what the user has changed in a chain that is new.
    pub(super) fn give_values(&self, chain: &mut Chain) {
        for (target, value) in self.changes.iter() {
            let Target::Parameter(name) = target else { continue };
            // Another tier or pipeline may have no such parameter, and keeps its own values.
            let _ = chain.set(name, value);
        }
    }
}
