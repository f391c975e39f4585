//! What the tiers cost on this device, learned from changes between them.

/// A change of tier, with the median time of the last frames before it and of the first frames after it.
#[derive(Clone, Copy, Debug)]
struct Record {
    from: usize,
    to: usize,
    from_ms: f64,
    to_ms: f64,
}

/// The time of a frame is what no tier changes, plus the load times the cost of its tier. The load is what the scene,
/// the resolution and the clock of the device make of one unit of cost; it changes, and the rest does not.
#[derive(Clone, Debug)]
pub(super) struct Costs {
    /// The costs that were given, and those that explain the records best.
    given: Vec<f64>,
    fitted: Vec<f64>,
    is_measured: Vec<bool>,
    /// Milliseconds that are the same at each tier.
    outside: f64,
    records: Vec<Record>,
}

/// A tier whose cost nobody knows is guessed to cost so much more than the next worse one.
const GUESSED_STEP: f64 = 1.35;
/// Changes that are remembered.
const MAX_RECORDS: usize = 24;
/// How much a given cost counts beside a change.
const GIVEN_WEIGHT: f64 = 0.02;
/// Logarithms of ratios up to this are noise.
const NOISE: f64 = 0.03;
/// The time that no tier changes is this many tenths of the shortest time at most.
const MAX_TENTHS: u32 = 9;
const ITERATIONS: usize = 30;

impl Costs {
    /// Costs as they are given, from the worst tier to the best. What is not above zero is guessed.
    pub(super) fn new(given: impl Iterator<Item = Option<f64>>) -> Self {
        let (mut known, mut costs) = (1.0 / GUESSED_STEP, Vec::new());
        for cost in given {
            known = cost.filter(|cost| cost.is_finite() && *cost > 0.0).unwrap_or(GUESSED_STEP * known);
            costs.push(known);
        }
        let is_measured = vec![false; costs.len()];
        Self {
            fitted: costs.clone(),
            given: costs,
            is_measured,
            outside: 0.0,
            records: Vec::with_capacity(MAX_RECORDS),
        }
    }

    pub(super) fn count(&self) -> usize {
        self.fitted.len()
    }

    /// The cost of a tier relative to the others.
    pub(super) fn cost(&self, tier: usize) -> f64 {
        self.fitted[tier]
    }

    /// Whether the tier was tried here.
    pub(super) fn is_measured(&self, tier: usize) -> bool {
        self.is_measured[tier]
    }

    /// Milliseconds that are the same at each tier.
    pub(super) fn outside_ms(&self) -> f64 {
        self.outside
    }

    /// The factor by which a given cost may be wrong: infinite until two tiers have been tried, and then a little more
    /// than their given costs were wrong.
    pub(super) fn doubt(&self) -> f64 {
        let (mut least, mut most, mut count) = (f64::INFINITY, 0.0_f64, 0);
        for tier in 0..self.count() {
            if self.is_measured[tier] {
                let correction = self.fitted[tier] / self.given[tier];
                (least, most, count) = (least.min(correction), most.max(correction), count + 1);
            }
        }
        if count > 2 { (most / least).powi(2) } else { f64::INFINITY }
    }

    /// The time of a frame at another tier.
    pub(super) fn expected(&self, ms: f64, from: usize, to: usize) -> f64 {
        let outside = self.outside.min(0.95 * ms);
        outside + (ms - outside) * self.fitted[to] / self.fitted[from]
    }

    /// Remembers a change whose new times are not known yet.
    pub(super) fn begin(&mut self, from: usize, to: usize, from_ms: f64) {
        self.records.retain(|record| record.to_ms > 0.0);
        if self.records.len() == MAX_RECORDS {
            self.records.remove(0);
        }
        self.records.push(Record { from, to, from_ms, to_ms: 0.0 });
    }

    /// Learns from the first times after the last change. More of them may come.
    pub(super) fn learn(&mut self, to_ms: f64) {
        let Some(record) = self.records.last_mut() else { return };
        record.to_ms = to_ms;
        self.is_measured[record.to] = true;
        self.is_measured[record.from] = true;
        self.fit();
    }

    /// Finds the costs and the time outside of them that explain all records with the least error.
    fn fit(&mut self) {
        let shortest =
            self.records.iter().fold(f64::INFINITY, |least, record| least.min(record.from_ms.min(record.to_ms)));
        let mut least = f64::INFINITY;
        for tenths in 0..=MAX_TENTHS {
            let outside = 0.1 * f64::from(tenths) * shortest;
            let (costs, error) = self.fit_outside(outside);
            if error < least {
                (least, self.fitted, self.outside) = (error, costs, outside);
            }
        }
        let mut correction = 1.0;
        for tier in 0..self.count() {
            if self.is_measured[tier] {
                correction = self.fitted[tier] / self.given[tier];
            } else {
                // What was not tried is guessed relative to the next worse tier.
                self.fitted[tier] = correction * self.given[tier];
            }
        }
    }

    /// The costs for a time outside of them, and their error: a sum of absolute errors, which a few wrong records and
    /// given costs hardly change.
    fn fit_outside(&self, outside: f64) -> (Vec<f64>, f64) {
        let given: Vec<f64> = self.given.iter().map(|cost| cost.ln()).collect();
        let mut costs: Vec<f64> = self.fitted.iter().map(|cost| cost.ln()).collect();
        let ratio = |record: &Record| ((record.to_ms - outside) / (record.from_ms - outside)).ln();
        for _ in 0..ITERATIONS {
            for tier in 0..costs.len() {
                let weight = GIVEN_WEIGHT / (costs[tier] - given[tier]).abs().max(NOISE);
                let (mut sum, mut weights) = (weight * given[tier], weight);
                for record in &self.records {
                    let expected = match tier {
                        to if to == record.to => costs[record.from] + ratio(record),
                        from if from == record.from => costs[record.to] - ratio(record),
                        _ => continue,
                    };
                    let weight = 1.0 / (costs[tier] - expected).abs().max(NOISE);
                    sum += weight * expected;
                    weights += weight;
                }
                costs[tier] = sum / weights;
            }
        }
        let mut error = 0.0;
        for record in &self.records {
            error += (costs[record.to] - costs[record.from] - ratio(record)).abs();
        }
        for (cost, given) in costs.iter().zip(&given) {
            error += GIVEN_WEIGHT * (cost - given).abs();
        }
        (costs.iter().map(|cost| cost.exp()).collect(), error)
    }
}
