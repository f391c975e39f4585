//! What a graph promises beyond finite numbers.

use afterimage_graph::check::Graph;
use afterimage_graph::node::Invariants;

/// All promises about images: what a node keeps that only makes values visible.
pub(super) const ALL: Invariants = Invariants {
    constant: true,
    keeps_constant: true,
    symmetric: true,
    keeps_sum: true,
    monotone: true,
    non_negative: true,
    settles: true,
    is_exposure: false,
    of_color: true,
};

/// What all nodes of a graph promise together; it gives an exposure if one of them does.
pub(super) fn promises(graph: &Graph) -> Invariants {
    let mut all = ALL;
    for node in &graph.nodes {
        let one = node.instance.invariants();
        all = Invariants {
            constant: all.constant && one.constant,
            keeps_constant: all.keeps_constant && one.keeps_constant,
            symmetric: all.symmetric && one.symmetric,
            keeps_sum: all.keeps_sum && one.keeps_sum,
            monotone: all.monotone && one.monotone,
            non_negative: all.non_negative && one.non_negative,
            settles: all.settles && one.settles,
            is_exposure: all.is_exposure || one.is_exposure,
            of_color: all.of_color && one.of_color,
        };
    }
    all
}
