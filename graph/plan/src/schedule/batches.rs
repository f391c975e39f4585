//! Batches: groups of passes that may run side by side.

use std::collections::BTreeSet;

use super::profile::Profile;
use super::schedule_graph::ScheduleGraph;

/// The passes of each batch, in the order of the batches.
pub(super) type Batches = Vec<Vec<usize>>;

/// After this many ready passes that do not fit, a batch is closed: it keeps the search linear.
const MISSES: usize = 16;

/// Runs the passes in this order, but lets as many as possible run together as long as no more than `budget` bytes ever
/// live at once.
///
/// The budget is at least the peak of the order. Passes are pulled forward only where the bytes that live longer for it
/// fit, so the result never needs more than the budget.
pub(crate) fn group_within_budget(graph: &ScheduleGraph, order: &[usize], budget: u64) -> Batches {
    let mut state = BatchBuilder::new(graph, order, budget);
    std::iter::from_fn(|| (!state.ready.is_empty()).then(|| state.batch())).collect()
}

struct BatchBuilder<'a> {
    graph: &'a ScheduleGraph,
    order: &'a [usize],
    budget: i64,
    /// Places in the order of passes that wait for nothing outside of earlier batches.
    ready: BTreeSet<usize>,
    waiting: Vec<usize>,
    place: Vec<usize>,
    done: Vec<bool>,
    /// Bytes that live at each place if all that is left runs one by one.
    profile: Profile,
    /// Bytes that earlier batches have left alive.
    live: i64,
    left: Vec<usize>,
    /// For each item, the places of its users, the last one at the end; users that have run are dropped.
    places: Vec<Vec<usize>>,
}

impl<'a> BatchBuilder<'a> {
    fn new(graph: &'a ScheduleGraph, order: &'a [usize], budget: u64) -> Self {
        let waiting: Vec<usize> = graph.before.iter().map(Vec::len).collect();
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(at, pass)| place[*pass] = at);
        let mut places: Vec<Vec<usize>> = Vec::with_capacity(graph.items.len());
        for item in &graph.items {
            let mut users: Vec<usize> = item.users.iter().map(|user| place[*user]).collect();
            users.sort_unstable();
            places.push(users);
        }
        let mut steps = vec![0_i64; order.len() + 1];
        for (item, places) in graph.items.iter().zip(&places) {
            steps[places[0]] += item.bytes as i64;
            steps[places[places.len() - 1] + 1] -= item.bytes as i64;
        }
        Self {
            graph,
            order,
            budget: i64::try_from(budget).unwrap_or(i64::MAX),
            ready: (0..order.len()).filter(|at| waiting[order[*at]] == 0).collect(),
            waiting,
            done: vec![false; order.len()],
            profile: Profile::new(&steps[..order.len()]),
            live: 0,
            left: graph.items.iter().map(|item| item.users.len()).collect(),
            places,
            place,
        }
    }

    fn batch(&mut self) -> Vec<usize> {
        let mut batch = Vec::new();
        let mut misses = 0;
        let mut at = self.ready.first().copied();
        while let Some(place) = at.filter(|_| misses < MISSES) {
            let pass = self.order[place];
            let born = self.born(pass);
            if batch.is_empty() || self.has_room(place, born) {
                self.take(place, born);
                batch.push(pass);
            } else {
                misses += 1;
            }
            at = self.ready.range(place + 1..).next().copied();
        }
        self.close(&batch);
        batch
    }

    fn born(&self, pass: usize) -> i64 {
        let items = self.graph.uses[pass].iter();
        let new = items.filter(|item| self.left[**item] == self.graph.items[**item].users.len());
        new.map(|item| self.graph.items[*item].bytes as i64).sum()
    }

    fn has_room(&self, place: usize, born: i64) -> bool {
        // What it brings to life lives through everything that it overtakes.
        let most = self.profile.most_before(place).max(self.live);
        most.saturating_add(born) <= self.budget
    }

    fn take(&mut self, place: usize, born: i64) {
        let pass = self.order[place];
        self.ready.remove(&place);
        self.done[pass] = true;
        self.live += born;
        self.profile.add(0..place, born);
        self.profile.remove(place);
        for item in &self.graph.uses[pass] {
            let places = &mut self.places[*item];
            if places.last() != Some(&place) {
                continue;
            }
            while places.last().is_some_and(|at| self.done[self.order[*at]]) {
                places.pop();
            }
            let end = places.last().map_or(0, |at| at + 1);
            self.profile.add(end..place, -(self.graph.items[*item].bytes as i64));
        }
    }

    fn close(&mut self, batch: &[usize]) {
        for pass in batch {
            for item in &self.graph.uses[*pass] {
                self.left[*item] -= 1;
                if self.left[*item] == 0 {
                    self.live -= self.graph.items[*item].bytes as i64;
                }
            }
            for later in &self.graph.after[*pass] {
                self.waiting[*later] -= 1;
                if self.waiting[*later] == 0 {
                    self.ready.insert(self.place[*later]);
                }
            }
        }
    }
}

/// Three schedules with the fewest batches that there can be: each pass as early as possible, as late as possible, or
/// where it frees most memory.
pub(crate) fn fewest_batches(graph: &ScheduleGraph) -> Vec<Batches> {
    let latest = latest(graph);
    let soon = by_batch(&earliest(graph));
    let lazy = lazy(graph, &latest);
    vec![soon, by_batch(&latest), lazy]
}

fn earliest(graph: &ScheduleGraph) -> Vec<usize> {
    let mut batch = vec![0; graph.len()];
    for pass in 0..graph.len() {
        batch[pass] = graph.before[pass].iter().map(|earlier| batch[*earlier] + 1).max().unwrap_or(0);
    }
    batch
}

fn latest(graph: &ScheduleGraph) -> Vec<usize> {
    let deepest = earliest(graph).into_iter().max().unwrap_or(0);
    let mut batch = vec![deepest; graph.len()];
    for pass in (0..graph.len()).rev() {
        batch[pass] = graph.after[pass].iter().map(|later| batch[*later] - 1).min().unwrap_or(deepest);
    }
    batch
}

fn by_batch(batch_of: &[usize]) -> Batches {
    let count = batch_of.iter().max().map_or(0, |last| last + 1);
    let mut batches = vec![Vec::new(); count];
    batch_of.iter().enumerate().for_each(|(pass, batch)| batches[*batch].push(pass));
    batches
}

/// A pass runs at once if it frees at least what it brings to life, at the last moment otherwise.
fn lazy(graph: &ScheduleGraph, latest: &[usize]) -> Batches {
    let count = latest.iter().max().map_or(0, |last| last + 1);
    let mut due = by_batch(latest);
    let mut waiting: Vec<usize> = graph.before.iter().map(Vec::len).collect();
    let mut left: Vec<usize> = graph.items.iter().map(|item| item.users.len()).collect();
    let mut done = vec![false; graph.len()];
    let mut fresh: Vec<usize> = (0..graph.len()).filter(|pass| waiting[*pass] == 0).collect();
    let mut batches = Vec::with_capacity(count);
    for due in &mut due {
        let mut batch = std::mem::take(due);
        batch.retain(|pass| !done[*pass]);
        batch.extend(fresh.drain(..).filter(|pass| !done[*pass] && frees(graph, &left, *pass)));
        batch.sort_unstable();
        batch.dedup();
        for pass in &batch {
            done[*pass] = true;
            graph.uses[*pass].iter().for_each(|item| left[*item] -= 1);
        }
        for later in batch.iter().flat_map(|pass| &graph.after[*pass]) {
            waiting[*later] -= 1;
            if waiting[*later] == 0 {
                fresh.push(*later);
            }
        }
        batches.push(batch);
    }
    batches
}

fn frees(graph: &ScheduleGraph, left: &[usize], pass: usize) -> bool {
    let (mut freed, mut made) = (0, 0);
    for item in &graph.uses[pass] {
        let bytes = graph.items[*item].bytes;
        freed += if left[*item] == 1 { bytes } else { 0 };
        made += if left[*item] == graph.items[*item].users.len() { bytes } else { 0 };
    }
    freed >= made
}
