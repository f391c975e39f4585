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
    /// How many passes it still waits for.
    waiting: Vec<usize>,
    done: Vec<bool>,
    /// How many passes will still use each item.
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
