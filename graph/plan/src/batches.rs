//! Batches: groups of passes that may run side by side.

use std::collections::BTreeSet;

use crate::schedule_graph::ScheduleGraph;

/// After so many ready passes that do not fit, a batch is closed: it keeps the search linear.
const MISSES: usize = 16;

/// Runs the passes in this order, but lets as many as possible run together as long as no more than `budget` bytes ever live at once.
///
/// The budget is at least the peak of the order. Passes are pulled forward only where what they keep alive for longer has room, so the
/// result never needs more than the budget.
pub(crate) fn within(flow: &ScheduleGraph, order: &[usize], budget: u64) -> Vec<Vec<usize>> {
    let mut state = Within::new(flow, order, budget);
    let mut batches = Vec::new();
    while !state.ready.is_empty() {
        batches.push(state.batch());
    }
    batches
}

struct Within<'a> {
    flow: &'a ScheduleGraph,
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

impl<'a> Within<'a> {
    fn new(flow: &'a ScheduleGraph, order: &'a [usize], budget: u64) -> Self {
        let waiting: Vec<usize> = flow.before.iter().map(Vec::len).collect();
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(at, pass)| place[*pass] = at);
        let sorted = |users: &Vec<usize>| {
            let mut places: Vec<usize> = users.iter().map(|user| place[*user]).collect();
            places.sort_unstable();
            places
        };
        let places: Vec<Vec<usize>> = flow.items.iter().map(|item| sorted(&item.users)).collect();
        let mut steps = vec![0_i64; order.len() + 1];
        for (item, places) in flow.items.iter().zip(&places) {
            steps[places[0]] += item.bytes as i64;
            steps[places[places.len() - 1] + 1] -= item.bytes as i64;
        }
        Self {
            flow,
            order,
            budget: i64::try_from(budget).unwrap_or(i64::MAX),
            ready: (0..order.len()).filter(|at| waiting[order[*at]] == 0).collect(),
            waiting,
            done: vec![false; order.len()],
            profile: Profile::new(&steps[..order.len()]),
            live: 0,
            left: flow.items.iter().map(|item| item.users.len()).collect(),
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
        let items = self.flow.touches[pass].iter();
        let new = items.filter(|item| self.left[**item] == self.flow.items[**item].users.len());
        new.map(|item| self.flow.items[*item].bytes as i64).sum()
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
        for item in &self.flow.touches[pass] {
            let places = &mut self.places[*item];
            if places.last() != Some(&place) {
                continue;
            }
            while places.last().is_some_and(|at| self.done[self.order[*at]]) {
                places.pop();
            }
            let end = places.last().map_or(0, |at| at + 1);
            self.profile.add(end..place, -(self.flow.items[*item].bytes as i64));
        }
    }

    fn close(&mut self, batch: &[usize]) {
        for pass in batch {
            for item in &self.flow.touches[*pass] {
                self.left[*item] -= 1;
                if self.left[*item] == 0 {
                    self.live -= self.flow.items[*item].bytes as i64;
                }
            }
            for later in &self.flow.after[*pass] {
                self.waiting[*later] -= 1;
                if self.waiting[*later] == 0 {
                    self.ready.insert(self.place[*later]);
                }
            }
        }
    }
}

/// Numbers in a row: adds to ranges and finds the most of a prefix, each in logarithmic time (a segment tree).
struct Profile {
    leaves: usize,
    /// The most of each node's range, without what its ancestors add.
    most: Vec<i64>,
    /// What each node adds to its whole range.
    plus: Vec<i64>,
}

/// Stands for "no pass here any more"; far from overflow when bytes are added.
const NONE: i64 = i64::MIN / 4;

impl Profile {
    /// From the differences of neighbours.
    fn new(steps: &[i64]) -> Self {
        let leaves = steps.len().next_power_of_two();
        let mut most = vec![NONE; 2 * leaves];
        let mut sum = 0;
        for (at, step) in steps.iter().enumerate() {
            sum += step;
            most[leaves + at] = sum;
        }
        for node in (1..leaves).rev() {
            most[node] = most[2 * node].max(most[2 * node + 1]);
        }
        Self { leaves, plus: vec![0; most.len()], most }
    }

    fn add(&mut self, range: std::ops::Range<usize>, value: i64) {
        if !range.is_empty() && value != 0 {
            self.add_under(1, 0..self.leaves, &range, value);
        }
    }

    fn add_under(&mut self, node: usize, span: std::ops::Range<usize>, range: &std::ops::Range<usize>, value: i64) {
        if range.end <= span.start || span.end <= range.start {
            return;
        }
        if range.start <= span.start && span.end <= range.end {
            self.most[node] += value;
            self.plus[node] += value;
            return;
        }
        let middle = span.start.midpoint(span.end);
        self.add_under(2 * node, span.start..middle, range, value);
        self.add_under(2 * node + 1, middle..span.end, range, value);
        self.most[node] = self.most[2 * node].max(self.most[2 * node + 1]) + self.plus[node];
    }

    fn remove(&mut self, at: usize) {
        self.add(at..at + 1, NONE);
    }

    /// The most of all places before `end`; far below zero if there are none.
    fn most_before(&self, end: usize) -> i64 {
        self.most_under(1, 0..self.leaves, end)
    }

    fn most_under(&self, node: usize, span: std::ops::Range<usize>, end: usize) -> i64 {
        if end <= span.start {
            return NONE;
        }
        if span.end <= end {
            return self.most[node];
        }
        let middle = span.start.midpoint(span.end);
        let (left, right) =
            (self.most_under(2 * node, span.start..middle, end), self.most_under(2 * node + 1, middle..span.end, end));
        left.max(right) + self.plus[node]
    }
}

/// The fewest batches that there can be, with each pass as early, as late, or as cheap as it can be.
pub(crate) fn fewest(flow: &ScheduleGraph) -> Vec<Vec<Vec<usize>>> {
    let latest = latest(flow);
    let soon = by_wave(&earliest(flow));
    let lazy = lazy(flow, &latest);
    vec![soon, by_wave(&latest), lazy]
}

fn earliest(flow: &ScheduleGraph) -> Vec<usize> {
    let mut batch = vec![0; flow.len()];
    for pass in 0..flow.len() {
        batch[pass] = flow.before[pass].iter().map(|earlier| batch[*earlier] + 1).max().unwrap_or(0);
    }
    batch
}

fn latest(flow: &ScheduleGraph) -> Vec<usize> {
    let deepest = earliest(flow).into_iter().max().unwrap_or(0);
    let mut batch = vec![deepest; flow.len()];
    for pass in (0..flow.len()).rev() {
        batch[pass] = flow.after[pass].iter().map(|later| batch[*later] - 1).min().unwrap_or(deepest);
    }
    batch
}

fn by_wave(batch_of: &[usize]) -> Vec<Vec<usize>> {
    let count = batch_of.iter().max().map_or(0, |last| last + 1);
    let mut batches = vec![Vec::new(); count];
    batch_of.iter().enumerate().for_each(|(pass, batch)| batches[*batch].push(pass));
    batches
}

/// A pass runs at once if it frees at least what it brings to life, at the last moment otherwise.
fn lazy(flow: &ScheduleGraph, latest: &[usize]) -> Vec<Vec<usize>> {
    let count = latest.iter().max().map_or(0, |last| last + 1);
    let mut due = by_wave(latest);
    let mut waiting: Vec<usize> = flow.before.iter().map(Vec::len).collect();
    let mut left: Vec<usize> = flow.items.iter().map(|item| item.users.len()).collect();
    let mut done = vec![false; flow.len()];
    let mut fresh: Vec<usize> = (0..flow.len()).filter(|pass| waiting[*pass] == 0).collect();
    let mut batches = Vec::with_capacity(count);
    for due in &mut due {
        let mut batch = std::mem::take(due);
        batch.retain(|pass| !done[*pass]);
        batch.extend(fresh.drain(..).filter(|pass| !done[*pass] && frees(flow, &left, *pass)));
        batch.sort_unstable();
        batch.dedup();
        for pass in &batch {
            done[*pass] = true;
            flow.touches[*pass].iter().for_each(|item| left[*item] -= 1);
        }
        for later in batch.iter().flat_map(|pass| &flow.after[*pass]) {
            waiting[*later] -= 1;
            if waiting[*later] == 0 {
                fresh.push(*later);
            }
        }
        batches.push(batch);
    }
    batches
}

fn frees(flow: &ScheduleGraph, left: &[usize], pass: usize) -> bool {
    let (mut born, mut freed) = (0, 0);
    for item in &flow.touches[pass] {
        let whole = flow.items[*item].users.len();
        if left[*item] == whole {
            born += flow.items[*item].bytes;
        }
        if left[*item] == 1 {
            freed += flow.items[*item].bytes;
        }
    }
    freed >= born
}
