//! The tested parameter values: both ends of every domain, every choice, neutral values, and pairs of extremes.

use afterimage_graph::check::Graph;
use afterimage_graph::value::{Param, Type, Value};

use super::target::{Overrides, Target};
use crate::shell_word;

/// A parameter and the values to test.
struct Axis {
    name: String,
    ends: Vec<Value>,
    neutral: Option<Value>,
}

impl Axis {
    /// The override with a value, as pipeline files write it.
    fn at(&self, value: &Value) -> (String, String) {
        (self.name.clone(), value.to_string())
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change {
    pub(crate) overrides: Overrides,
    /// True if it is tested with all images. Pairs are many, and are tested with a few.
    pub(crate) is_single: bool,
}

/// The defaults first, then each parameter on its own, then all neutral values at once, then at most `pairs` pairs of
/// extremes.
pub(crate) fn sweep(target: &Target, graph: &Graph, pairs: usize) -> Vec<Change> {
    let axes = axes(target, graph);
    let mut changes = vec![Change { overrides: Overrides::new(), is_single: true }];
    for axis in &axes {
        for value in axis.ends.iter().chain(&axis.neutral) {
            changes.push(Change { overrides: vec![axis.at(value)], is_single: true });
        }
    }
    let neutral: Overrides = axes.iter().filter_map(|axis| Some(axis.at(axis.neutral.as_ref()?))).collect();
    if neutral.len() > 1 {
        changes.push(Change { overrides: neutral, is_single: true });
    }
    let mut all = Vec::new();
    for (index, first) in axes.iter().enumerate() {
        for second in &axes[index + 1..] {
            for a in &first.ends {
                all.extend(second.ends.iter().map(|b| vec![first.at(a), second.at(b)]));
            }
        }
    }
    let step = all.len().div_ceil(pairs.max(1)).max(1);
    let some = all.into_iter().step_by(step).take(pairs);
    changes.extend(some.map(|overrides| Change { overrides, is_single: false }));
    changes
}

fn axes(target: &Target, graph: &Graph) -> Vec<Axis> {
    let mut axes = Vec::new();
    for node in graph.nodes.iter().filter(|node| target.sweeps(&node.name)) {
        for (param, value) in node.kind().params().iter().zip(node.instance.values()) {
            let name = format!("{}.{}", node.name, param.name);
            let ends = ends(param).into_iter().filter(|end| end != value).collect();
            let neutral = param.neutral.clone().filter(|neutral| neutral != value);
            axes.push(Axis { name, ends, neutral });
        }
    }
    axes
}

/// The extreme values of a parameter.
fn ends(param: &Param) -> Vec<Value> {
    match (param.ty, param.domain) {
        (Type::Bool, _) => vec![Value::Bool(false), Value::Bool(true)],
        (Type::Choice(choices), _) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        (Type::Int, Some((low, high))) => vec![Value::Int(low as i64), Value::Int(high as i64)],
        (Type::Float, Some((low, high))) => vec![Value::Float(low), Value::Float(high)],
        (Type::Vector(n), Some((low, high))) => {
            let vectors = [[low; 4], [high; 4], [low, high, high, high]];
            let of_length = |x: [f64; 4]| std::array::from_fn(|index| if index < n { x[index] } else { 0.0 });
            vectors.map(|numbers| Value::Vector(of_length(numbers), n)).into()
        }
        (Type::Text | Type::File | Type::Int | Type::Float | Type::Vector(_), _) => Vec::new(),
    }
}

/// Overrides as arguments of the command line.
pub(crate) fn arguments(overrides: &Overrides) -> String {
    let mut words = String::new();
    for (name, value) in overrides {
        words += &format!(" --set {}", shell_word(&format!("{name}={value}")));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::super::registry;
    use super::super::target::Target;
    use super::{arguments, sweep};

    #[test]
    fn both_ends_neutral_and_pairs() {
        let registry = registry(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
        let kind = registry.get("Contrast").expect("a built-in kind");
        let target = Target::kind(&registry, kind, false).expect("every built-in kind can run alone");
        let graph = target.graph(&Vec::new()).expect("defaults are right");
        let all: Vec<String> = sweep(&target, &graph, 3).iter().map(|change| arguments(&change.overrides)).collect();
        assert_eq!(all[0], "");
        for expected in
            [" --set it.amount=0.0", " --set it.amount=8.0", " --set it.pivot=16.0", " --set it.form=Linear"]
        {
            assert!(all.iter().any(|words| words == expected), "{all:?}");
        }
        assert_eq!(all.iter().filter(|words| words.matches("--set").count() == 2).count(), 3);
    }

    #[test]
    fn every_built_in_kind_can_run_alone() {
        let registry = registry(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
        for kind in afterimage_nodes::ALL {
            for bare in [false, true] {
                let target = Target::kind(&registry, kind, bare).unwrap_or_else(|why| panic!("{kind:?}: {why}"));
                let graph = target.graph(&Vec::new());
                assert!(graph.is_ok(), "{kind:?}: {}", graph.expect_err("checked"));
            }
        }
    }
}
