//! The graphs of kinds on their own, and what their plans read and write.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::check::Graph;
use afterimage_graph::node::{NodeKind, Pass, Registry, Resource};
use afterimage_graph::value::{Param, Value};
use afterimage_lab::LabError;
use afterimage_lab::stress::{NODE, Target};
use afterimage_plan::{Plan, PlannedPass};

use super::figures::SkippedKind;

/// A kind on its own.
pub(super) struct KindAlone {
    pub(super) kind: String,
    subject: Target,
    /// Values in the place of the defaults that change nothing.
    pub(super) changed: Vec<(String, String)>,
}

impl KindAlone {
    /// The graph with these values of parameters.
    pub(super) fn graph(&self, values: &[(String, String)]) -> Result<Graph, LabError> {
        let overrides = values.iter().map(|(name, value)| (format!("{NODE}.{name}"), value.clone())).collect();
        Ok(self.subject.graph(&overrides)?)
    }
}

/// Each kind of these tables on its own, and those that cannot be.
pub(super) fn alone(registry: &Arc<Registry>, tables: &[&[NodeKind]]) -> (Vec<KindAlone>, Vec<SkippedKind>) {
    let (mut subjects, mut skipped) = (Vec::new(), Vec::new());
    for kind in tables.iter().copied().flatten() {
        let name = kind.name().to_owned();
        match Target::typical(registry, kind) {
            Ok(subject) => subjects.push(KindAlone { kind: name, subject, changed: changed(kind) }),
            Err(why) => skipped.push(SkippedKind { kind: name, why }),
        }
    }
    (subjects, skipped)
}

/// A value of each parameter whose default changes nothing: at three quarters of its slider.
fn changed(kind: &NodeKind) -> Vec<(String, String)> {
    let is_neutral = |param: &&Param| param.neutral.as_ref() == Some(&param.default);
    kind.params().iter().filter(is_neutral).filter_map(|param| Some((param.name.to_string(), within(param)?))).collect()
}

fn within(param: &Param) -> Option<String> {
    let (low, high) = param.usual.or(param.domain)?;
    // With few digits.
    let at = |share: f64| (1000.0 * (low + share * (high - low))).round() / 1000.0;
    let value = match param.default {
        Value::Float(_) => Value::Float(at(0.75)),
        Value::Int(_) => Value::Int(at(0.75).round() as i64),
        Value::Vector(_, count) => {
            let mut numbers = [0.0; 4];
            let all = numbers.iter_mut().take(count).enumerate();
            all.for_each(|(index, number)| *number = at(0.75 - 0.1 * index as f64));
            Value::Vector(numbers, count)
        }
        _ => return None,
    };
    Some(value.to_string())
}

/// True if a pass computes the kind, and not an input of it.
pub(super) fn is_own(planned: &PlannedPass) -> bool {
    planned.pass.nodes.iter().any(|node| node == NODE)
}

/// Bytes of the images that the kind's passes read from elsewhere, and of those that others read: each once.
pub(super) fn least_bytes(plan: &Plan) -> u64 {
    let images = |own: bool, of: fn(&Pass) -> Vec<Resource>| -> BTreeSet<u32> {
        let passes = plan.passes.iter().filter(|planned| is_own(planned) == own);
        passes.flat_map(|planned| of(&planned.pass)).filter_map(Resource::image).map(|image| image.0).collect()
    };
    let (reads, writes) = (images(true, Pass::reads), images(true, Pass::writes));
    let mut wanted = images(false, Pass::reads);
    wanted.extend(plan.outputs.iter().map(|output| output.image.0));
    let bytes = |image: &u32| plan.images[*image as usize].desc.bytes();
    reads.difference(&writes).map(bytes).sum::<u64>() + writes.intersection(&wanted).map(bytes).sum::<u64>()
}

/// Bytes that the kind's passes read and write.
pub(super) fn moved_bytes(plan: &Plan) -> u64 {
    let own = (0..plan.passes.len()).filter(|pass| is_own(&plan.passes[*pass]));
    own.map(|pass| plan.bytes_moved_by(pass)).sum()
}

#[cfg(test)]
mod tests {
    use afterimage_lab::stress::{NODE, registry};

    use super::alone;

    #[test]
    fn every_built_in_kind_runs_alone_at_its_defaults_and_with_the_changed_values() {
        let tables = [afterimage_nodes::ALL];
        let registry = registry(&tables).expect("no two kinds share a name");
        let (subjects, skipped) = alone(&registry, &tables);
        assert!(skipped.is_empty(), "{skipped:?}");
        assert_eq!(subjects.len(), afterimage_nodes::ALL.len());
        for subject in &subjects {
            for values in [&[], subject.changed.as_slice()] {
                let graph = subject.graph(values).unwrap_or_else(|error| panic!("{}: {error}", subject.kind));
                assert!(graph.nodes.iter().any(|node| node.name == NODE), "{}", subject.kind);
                assert!(!graph.outputs.is_empty(), "{}", subject.kind);
            }
        }
    }

    #[test]
    fn a_default_that_changes_nothing_gets_another_value() {
        let tables = [afterimage_nodes::ALL];
        let registry = registry(&tables).expect("no two kinds share a name");
        let (subjects, _) = alone(&registry, &tables);
        let changed = |kind: &str| &subjects.iter().find(|subject| subject.kind == kind).expect("a kind").changed;
        assert_eq!(changed("Saturation"), &[("amount".to_owned(), "1.5".to_owned())]);
        assert!(changed("DepthOfField").is_empty());
    }
}
