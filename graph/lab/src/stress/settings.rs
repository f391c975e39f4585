//! The tested parameter values: both ends of every domain, every choice, neutral values, and pairs of extremes.

use afterimage_graph::check::Graph;
use afterimage_graph::value::{Param, Type, Value};

use super::subject::{Overrides, Subject};

/// A parameter and the values to test.
struct Axis {
    name: String,
    ends: Vec<Value>,
    neutral: Option<Value>,
}

/// Overrides to test together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change {
    pub(crate) overrides: Overrides,
    /// Whether it is tested with all images; pairs are many and get a few.
    pub(crate) is_single: bool,
}

/// The defaults first, then each parameter on its own, then all neutral values at once, then at most `pairs` pairs of
/// extremes.
pub(crate) fn sweep(subject: &Subject, graph: &Graph, pairs: usize) -> Vec<Change> {
    let axes = axes(subject, graph);
    let one = |axis: &Axis, value: &Value| (axis.name.clone(), as_text(value));
    let single = |overrides: Overrides| Change { overrides, is_single: true };
    let mut changes = vec![single(Overrides::new())];
    for axis in &axes {
        changes.extend(axis.ends.iter().chain(&axis.neutral).map(|value| single(vec![one(axis, value)])));
    }
    let neutral: Overrides = axes.iter().filter_map(|axis| Some(one(axis, axis.neutral.as_ref()?))).collect();
    if neutral.len() > 1 {
        changes.push(single(neutral));
    }
    let mut all = Vec::new();
    for (index, first) in axes.iter().enumerate() {
        for second in &axes[index + 1..] {
            let both = |a| second.ends.iter().map(move |b| vec![one(first, a), one(second, b)]);
            all.extend(first.ends.iter().flat_map(both));
        }
    }
    let step = all.len().div_ceil(pairs.max(1)).max(1);
    let some = all.into_iter().step_by(step).take(pairs);
    changes.extend(some.map(|overrides| Change { overrides, is_single: false }));
    changes
}

fn axes(subject: &Subject, graph: &Graph) -> Vec<Axis> {
    let mut axes = Vec::new();
    for node in graph.nodes.iter().filter(|node| subject.sweeps(&node.name)) {
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
    let vector = |n: usize, at: &dyn Fn(usize) -> f64| {
        let mut all = [0.0; 4];
        all.iter_mut().take(n).enumerate().for_each(|(index, x)| *x = at(index));
        Value::Vector(all, n)
    };
    match (param.ty, param.domain) {
        (Type::Bool, _) => vec![Value::Bool(false), Value::Bool(true)],
        (Type::Choice(choices), _) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        (Type::Int, Some((low, high))) => vec![Value::Int(low as i64), Value::Int(high as i64)],
        (Type::Float, Some((low, high))) => vec![Value::Float(low), Value::Float(high)],
        (Type::Vector(n), Some((low, high))) => {
            vec![vector(n, &|_| low), vector(n, &|_| high), vector(n, &|index| if index == 0 { low } else { high })]
        }
        (Type::Text | Type::File | Type::Int | Type::Float | Type::Vector(_), _) => Vec::new(),
    }
}

/// A value as pipeline files write it.
fn as_text(value: &Value) -> String {
    value.to_string()
}

/// Overrides as arguments of the command line.
pub(crate) fn arguments(overrides: &Overrides) -> String {
    let word = |(name, value): &(String, String)| {
        let set = format!("{name}={value}");
        if set.contains([' ', '(', '"', '/']) { format!(" --set '{set}'") } else { format!(" --set {set}") }
    };
    overrides.iter().map(word).collect()
}

#[cfg(test)]
mod tests {
    use afterimage_graph::node::Registry;

    use super::super::subject::Subject;
    use super::{arguments, sweep};

    fn subject(kind: &str) -> (Registry, Subject) {
        let tables = [afterimage_nodes::ALL, super::super::probes::ALL];
        let registry = Registry::new(&tables).expect("no two kinds share a name");
        let kind = registry.get(kind).expect("a built-in kind");
        let subject = Subject::kind(&registry, kind, false, false).expect("every built-in kind can run alone");
        (registry, subject)
    }

    #[test]
    fn both_ends_neutral_and_pairs() {
        let (registry, subject) = subject("Contrast");
        let graph = subject.graph(&registry, &Vec::new()).expect("defaults are right");
        let all: Vec<String> = sweep(&subject, &graph, 3).iter().map(|change| arguments(&change.overrides)).collect();
        assert_eq!(all[0], "");
        for wanted in [" --set it.amount=0.0", " --set it.amount=8.0", " --set it.pivot=16.0", " --set it.form=Linear"]
        {
            assert!(all.iter().any(|words| words == wanted), "{all:?}");
        }
        assert_eq!(all.iter().filter(|words| words.matches("--set").count() == 2).count(), 3);
    }

    #[test]
    fn every_built_in_kind_can_run_alone() {
        for kind in afterimage_nodes::ALL {
            for (bare, signed) in [(false, false), (true, false), (false, true), (true, true)] {
                let (registry, _) = subject("Contrast");
                let subject =
                    Subject::kind(&registry, kind, bare, signed).unwrap_or_else(|why| panic!("{kind:?}: {why}"));
                let graph = subject.graph(&registry, &Vec::new());
                assert!(graph.is_ok(), "{kind:?}: {}", graph.expect_err("checked"));
            }
        }
    }
}
