//! The table of outcomes.

use crate::classes::Class;
use crate::outcome::{Budget, Verdict};

/// The results of a class.
pub(crate) struct Row {
    name: &'static str,
    what: &'static str,
    budget: Budget,
    counts: [u64; Verdict::ALL.len()],
    most_seconds: f64,
    most_megabytes: u64,
    slowest: u64,
    largest: u64,
}

impl Row {
    pub(crate) fn new(class: &Class) -> Self {
        let Class { name, what, budget, .. } = *class;
        let counts = [0; Verdict::ALL.len()];
        Self { name, what, budget, counts, most_seconds: 0.0, most_megabytes: 0, slowest: 0, largest: 0 }
    }

    pub(crate) fn add(&mut self, number: u64, verdict: Verdict, seconds: f64, megabytes: u64) {
        self.counts[verdict as usize] += 1;
        if seconds > self.most_seconds {
            (self.most_seconds, self.slowest) = (seconds, number);
        }
        if megabytes > self.most_megabytes {
            (self.most_megabytes, self.largest) = (megabytes, number);
        }
    }

    pub(crate) fn cases(&self) -> u64 {
        self.counts.iter().sum()
    }

    pub(crate) fn faults(&self) -> u64 {
        Verdict::ALL.iter().filter(|verdict| verdict.is_fault()).map(|verdict| self.counts[*verdict as usize]).sum()
    }

    /// For the terminal.
    pub(crate) fn line(&self) -> String {
        format!(
            "{}: {} cases, good, refused, abort, panic, hang, over budget, unclean {:?}; at most {:.2} s (case {}), {} MB (case {})",
            self.name,
            self.cases(),
            self.counts,
            self.most_seconds,
            self.slowest,
            self.most_megabytes,
            self.largest
        )
    }

    fn markdown(&self) -> String {
        let Budget { seconds, megabytes } = self.budget;
        format!(
            "| `{}`: {} | {} | {} | {} | {} | {:.1} of {seconds:.0} | {} of {megabytes} |\n",
            self.name,
            self.what,
            self.cases(),
            self.counts[Verdict::Good as usize],
            self.counts[Verdict::Refused as usize],
            self.faults(),
            self.most_seconds,
            self.most_megabytes
        )
    }
}

/// The rows as Markdown.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let head = "| input | cases | ok | clean error | faults | seconds | MB |\n\
                | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n";
    head.to_owned() + &rows.iter().map(Row::markdown).collect::<String>()
}
