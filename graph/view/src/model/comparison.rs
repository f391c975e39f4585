//! The picture that the shown one is compared with.

use afterimage_gpu::wgpu;

use super::{Chain, CompareWith, Model, Project, Purpose};
use crate::Problem;

impl Model {
    /// What the shown picture is compared with.
    pub fn compared(&self) -> Option<&CompareWith> {
        self.chains.compared.as_ref().map(|(other, _)| other)
    }

    /// Renders another picture to compare the shown one with, or none. If it cannot be made, that is the problem.
    pub fn set_compared(&mut self, other: Option<CompareWith>) {
        self.chains.compared = None;
        let Some(other) = other else { return };
        match self.make_compared(&other) {
            Ok(chain) => self.chains.compared = Some((other, chain)),
            Err(problem) => self.problem = Some(problem),
        }
        self.is_stale = true;
    }

    /// The texture of the other picture.
    pub fn compared_picture(&self) -> Option<&wgpu::Texture> {
        self.chains.compared.as_ref().and_then(|(_, chain)| chain.picture())
    }

    pub(super) fn renew_compared(&mut self) {
        let other = self.chains.compared.take().map(|(other, _)| other);
        self.set_compared(other);
    }

    fn make_compared(&mut self, other: &CompareWith) -> Result<Chain, Problem> {
        let no_pipeline = || Problem::message("there is no pipeline to compare with");
        let purpose = if *other == CompareWith::Reference { Purpose::Reference } else { Purpose::Show };
        let graph = match other {
            CompareWith::Written => self.graph.as_deref().cloned(),
            CompareWith::Reference => self.present_graph(),
            CompareWith::Tier(tier) => {
                let checked = self.project.check(self.changes.text(), tier.as_deref());
                Some(checked.map_err(Problem::Pipeline)?.graph)
            }
            CompareWith::Pipeline(name) => {
                let mut project = super::TextProject::built_in(name).ok_or_else(no_pipeline)?;
                let text = project.text().to_owned();
                Some(project.check(&text, None).map_err(Problem::Pipeline)?.graph)
            }
        };
        let mut chain = Chain::new(&self.gpu, graph.ok_or_else(no_pipeline)?, purpose);
        chain.post().set_facts(self.facts.clone());
        if matches!(other, CompareWith::Reference | CompareWith::Tier(_)) {
            chain.set_changes(&self.changes);
        }
        Ok(chain)
    }
}
