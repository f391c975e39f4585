//! A small edit of a graph changes little in the order of its passes.

use afterimage_generators::{Recipe, Rng};
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::PortType;
use afterimage_plan::{Options, Plan};

use super::support::{FRAME, plan_at};

const SEEDS: std::ops::Range<u64> = 0..40;

fn planned(graph: &Graph) -> Plan {
    // Fusion depends on every wire; these tests are about the order alone.
    let options = Options { fuse: false, ..Options::default() };
    plan_at(graph, FRAME, options).unwrap_or_else(|error| panic!("{error}"))
}

/// Passes that both plans have and that come in the same order in both, of those that both have.
fn in_order(first: &Plan, second: &Plan) -> (usize, usize) {
    let (first, second) = (first.pass_names(), second.pass_names());
    let places: Vec<usize> = first.iter().filter_map(|name| second.iter().position(|other| other == name)).collect();
    // The longest rising sequence (Schensted, "Longest increasing and decreasing subsequences", 1961).
    let mut ends: Vec<usize> = Vec::new();
    for place in &places {
        let at = ends.partition_point(|end| end < place);
        ends.truncate(ends.len().max(at));
        match ends.get_mut(at) {
            Some(end) => *end = *place,
            None => ends.push(*place),
        }
    }
    (ends.len(), places.len())
}

/// The share of passes that keep their order when each graph is edited.
fn kept(edit: impl Fn(&mut Graph, &mut Rng)) -> f64 {
    let (mut kept, mut all) = (0, 0);
    for seed in SEEDS {
        let before = Recipe { seed, nodes: 40, histories: 2, off: 5 }.graph();
        let mut after = before.clone();
        edit(&mut after, &mut Rng::new(seed));
        let (same, common) = in_order(&planned(&before), &planned(&after));
        assert!(common > 10, "seed {seed}: only {common} passes are in both");
        kept += same;
        all += common;
    }
    kept as f64 / all as f64
}

#[test]
fn other_names_do_not_change_the_order() {
    for seed in SEEDS {
        let graph = Recipe { seed, nodes: 40, histories: 2, off: 5 }.graph();
        let mut renamed = graph.clone();
        renamed.nodes.iter_mut().enumerate().for_each(|(at, node)| node.name = format!("z{}", 1000 - at));
        let [before, after] = [&graph, &renamed].map(planned);
        let recorded = |plan: &Plan| plan.passes.iter().map(|planned| planned.recorded).collect::<Vec<_>>();
        let offsets = |plan: &Plan| plan.images.iter().map(|image| image.offset).collect::<Vec<_>>();
        assert_eq!(recorded(&before), recorded(&after), "seed {seed}");
        assert_eq!(offsets(&before), offsets(&after), "seed {seed}");
        assert_eq!((before.batches, before.memory), (after.batches, after.memory), "seed {seed}");
    }
}

#[test]
fn a_disabled_node_changes_the_order_little() {
    let kept = kept(|graph, rng| {
        let can_be_off = |at: &usize| graph.nodes[*at].kind().can_be_off() && !graph.nodes[*at].off;
        let nodes: Vec<usize> = (0..graph.nodes.len()).filter(can_be_off).collect();
        graph.nodes[nodes[rng.below(nodes.len())]].off = true;
    });
    assert!(kept > 0.85, "{kept}");
}

#[test]
fn a_rewired_input_changes_the_order_little() {
    let kept = kept(|graph, rng| {
        let lays: Vec<usize> = (0..graph.nodes.len()).filter(|at| graph.nodes[*at].kind().name() == "Lay").collect();
        let reader = lays[rng.below(lays.len())];
        let makes_image = |at: &usize| graph.nodes[*at].kind().outputs()[0].ty == PortType::Image;
        let earlier: Vec<usize> = (0..reader).filter(makes_image).collect();
        let wire = match earlier.is_empty() {
            true => Source::Input(0),
            false => Source::Node { node: earlier[rng.below(earlier.len())], output: 0, previous: 0 },
        };
        rewire(graph, reader, wire);
    });
    assert!(kept > 0.85, "{kept}");
}

/// Gives the second input of a node another source.
fn rewire(graph: &mut Graph, reader: usize, wire: Source) {
    graph.nodes[reader].wires[1] = Some(wire);
    graph.wires.clear_edges();
    for at in 0..graph.nodes.len() {
        for source in graph.nodes[at].wires.clone().into_iter().flatten() {
            if let Source::Node { node, previous: 0, .. } = source {
                graph.wires.add_edge((node as u32).into(), (at as u32).into(), ());
            }
        }
    }
}
