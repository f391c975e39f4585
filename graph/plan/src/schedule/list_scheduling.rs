//! List scheduling: topological orders to choose from, each found by another heuristic, all in close to linear time.
//!
//! No heuristic is best on every graph, and each is cheap, so the planner tries them all and compares the results.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::schedule_graph::ScheduleGraph;

/// The order of recording first, then the others, none twice.
pub(crate) fn candidate_orders(graph: &ScheduleGraph) -> Vec<Vec<usize>> {
    let backwards = graph.reversed();
    let recorded: Vec<usize> = (0..graph.len()).collect();
    let mut orders = vec![recorded, greedy(graph, false), reverse(greedy(&backwards, true)), demanded(graph)];
    for at in 0..orders.len() {
        let late = late(graph, &orders[at]);
        let early = reverse(self::late(&backwards, &reverse(late.clone())));
        orders.extend([late, early]);
    }
    let mut distinct: Vec<Vec<usize>> = Vec::new();
    for order in orders {
        if !distinct.contains(&order) {
            distinct.push(order);
        }
    }
    distinct
}

fn reverse(mut order: Vec<usize>) -> Vec<usize> {
    order.reverse();
    order
}

/// Always the ready pass that adds the fewest bytes to what lives; among equals the one recorded first, or last.
fn greedy(graph: &ScheduleGraph, last_first: bool) -> Vec<usize> {
    let mut state = Greedy::new(graph, last_first);
    let mut order = Vec::with_capacity(graph.len());
    while let Some(Reverse((bytes, _, pass))) = state.ready.pop() {
        if !state.done[pass] && state.adds[pass] == bytes {
            state.run(pass);
            order.push(pass);
        }
    }
    order
}

struct Greedy<'a> {
    graph: &'a ScheduleGraph,
    last_first: bool,
    /// Bytes by which what lives grows when the pass runs next.
    adds: Vec<i64>,
    /// Passes that it still waits for.
    waiting: Vec<usize>,
    done: Vec<bool>,
    /// Passes that will still use each item.
    left: Vec<usize>,
    /// Ready passes; entries whose bytes have changed since are passed over.
    ready: BinaryHeap<Reverse<(i64, usize, usize)>>,
}

impl<'a> Greedy<'a> {
    fn new(graph: &'a ScheduleGraph, last_first: bool) -> Self {
        let kept = |item: &usize| if graph.items[*item].users.len() > 1 { graph.items[*item].bytes as i64 } else { 0 };
        let mut state = Self {
            graph,
            last_first,
            adds: graph.uses.iter().map(|items| items.iter().map(kept).sum()).collect(),
            waiting: graph.before.iter().map(Vec::len).collect(),
            done: vec![false; graph.len()],
            left: graph.items.iter().map(|item| item.users.len()).collect(),
            ready: BinaryHeap::new(),
        };
        (0..graph.len()).for_each(|pass| state.offer(pass));
        state
    }

    fn offer(&mut self, pass: usize) {
        if self.waiting[pass] == 0 && !self.done[pass] {
            let rank = if self.last_first { self.graph.len() - pass } else { pass };
            self.ready.push(Reverse((self.adds[pass], rank, pass)));
        }
    }

    fn run(&mut self, pass: usize) {
        self.done[pass] = true;
        for item in &self.graph.uses[pass] {
            self.use_item(*item);
        }
        for later in &self.graph.after[pass] {
            self.waiting[*later] -= 1;
            self.offer(*later);
        }
    }

    fn use_item(&mut self, item: usize) {
        let users = &self.graph.items[item].users;
        if self.left[item] == users.len() {
            users.iter().for_each(|user| self.lighten(*user, item));
        }
        self.left[item] -= 1;
        if self.left[item] == 1 {
            let last = users.iter().find(|user| !self.done[**user]);
            last.into_iter().for_each(|user| self.lighten(*user, item));
        }
    }

    /// The pass no longer brings the item to life, or now ends its life.
    fn lighten(&mut self, pass: usize, item: usize) {
        self.adds[pass] -= self.graph.items[item].bytes as i64;
        self.offer(pass);
    }
}

/// Depth first from the passes that no other waits for; inputs first that need the most memory beyond what they leave
/// (Sethi and Ullman's rule for expression trees, "The Generation of Optimal Code for Arithmetic Expressions", 1970).
fn demanded(graph: &ScheduleGraph) -> Vec<usize> {
    let mut leaves = vec![0_u64; graph.len()];
    for item in &graph.items {
        leaves[item.users[0]] += item.bytes;
    }
    let mut needs = vec![0_u64; graph.len()];
    let mut inputs: Vec<Vec<usize>> = graph.before.clone();
    for pass in 0..graph.len() {
        inputs[pass].sort_by_key(|input| (Reverse(needs[*input].saturating_sub(leaves[*input])), *input));
        let mut live = 0;
        for input in &inputs[pass] {
            needs[pass] = needs[pass].max(live + needs[*input]);
            live += leaves[*input];
        }
        needs[pass] = needs[pass].max(live + leaves[pass]);
    }
    let ends = (0..graph.len()).filter(|pass| graph.after[*pass].is_empty());
    depth_first(&inputs, ends)
}

fn depth_first(inputs: &[Vec<usize>], ends: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut order = Vec::with_capacity(inputs.len());
    let mut seen = vec![false; inputs.len()];
    let mut stack = Vec::new();
    for end in ends {
        seen[end] = true;
        stack.push((end, 0));
        while let Some((pass, next)) = stack.pop() {
            let Some(input) = inputs[pass].get(next) else {
                order.push(pass);
                continue;
            };
            stack.push((pass, next + 1));
            if !std::mem::replace(&mut seen[*input], true) {
                stack.push((*input, 0));
            }
        }
    }
    order
}

/// Moves each pass to just before the first that waits for it, unless it frees more than it brings to life.
fn late(graph: &ScheduleGraph, order: &[usize]) -> Vec<usize> {
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, pass)| place[*pass] = at);
    let mut keeps = vec![0_i64; order.len()];
    for item in &graph.items {
        let places = item.users.iter().map(|user| place[*user]);
        let (first, last) = (places.clone().min(), places.max());
        keeps[order[first.expect("an item has users")]] += item.bytes as i64;
        keeps[order[last.expect("an item has users")]] -= item.bytes as i64;
    }
    // Moved passes take the number of the pass that they move to; among equal numbers the old order stands, so inputs
    // stay in front.
    let mut slot = place.clone();
    for pass in order.iter().rev() {
        let reader = graph.after[*pass].iter().map(|later| slot[*later]).min();
        if let Some(reader) = reader.filter(|_| keeps[*pass] >= 0) {
            slot[*pass] = reader;
        }
    }
    let mut moved = order.to_vec();
    moved.sort_by_key(|pass| (slot[*pass], place[*pass]));
    moved
}

#[cfg(test)]
mod tests {
    use super::super::schedule_graph::Item;
    use super::*;
    use crate::topological::transposed;

    /// A graph of what each pass waits for, and of images: their bytes, and the passes that use them.
    fn graph(before: &[&[usize]], images: &[(u64, &[usize])]) -> ScheduleGraph {
        let before: Vec<Vec<usize>> = before.iter().map(|passes| passes.to_vec()).collect();
        let mut uses = vec![Vec::new(); before.len()];
        for (index, (_, users)) in images.iter().enumerate() {
            users.iter().for_each(|pass| uses[*pass].push(index));
        }
        let items = images.iter().map(|(bytes, users)| Item { bytes: *bytes, users: users.to_vec() }).collect();
        ScheduleGraph { after: transposed(&before), before, uses, items }
    }

    #[test]
    fn the_input_that_needs_the_most_memory_comes_first() {
        // Pass 3 reads a small image of pass 0 and a small one of pass 2, for which pass 1 makes a large one.
        let graph = graph(&[&[], &[], &[1], &[0, 2]], &[(1, &[0, 3]), (10, &[1, 2]), (1, &[2, 3])]);
        let order = demanded(&graph);
        assert_eq!(order, [1, 2, 0, 3]);
        assert_eq!([graph.peak(&[0, 1, 2, 3]), graph.peak(&order)], [12, 11]);
        assert!(candidate_orders(&graph).iter().any(|order| graph.peak(order) == 11));
    }

    #[test]
    fn depth_first_runs_what_an_input_waits_for_before_the_next_input() {
        let inputs = [vec![], vec![0], vec![0], vec![2, 1], vec![], vec![4, 3]];
        assert_eq!(depth_first(&inputs, [3, 5].into_iter()), [0, 2, 1, 3, 4, 5]);
        assert_eq!(depth_first(&inputs, [5].into_iter()), [4, 0, 2, 1, 3, 5]);
    }
}
