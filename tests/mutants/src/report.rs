//! The score of a sample with its interval, by crate, and the mutants that no test notices.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

use crate::list::Mutant;

/// The numbers of mutants of a crate by their ends.
#[derive(Clone, Copy, Default)]
struct Counts {
    noticed: u64,
    survived: u64,
    refused: u64,
}

/// The outcomes of a sample.
pub(crate) struct Report {
    by_crate: BTreeMap<String, Counts>,
    unnoticed: Vec<String>,
    refused: Vec<String>,
}

impl Report {
    /// The outcomes of the sample in a table of results.
    pub(crate) fn read(results: &Path, sample: &[Mutant]) -> Self {
        let table = std::fs::read_to_string(results).unwrap_or_default();
        let outcomes: BTreeMap<&str, &str> = table.lines().filter_map(|line| line.split_once('\t')).collect();
        let mut report = Self { by_crate: BTreeMap::new(), unnoticed: Vec::new(), refused: Vec::new() };
        for mutant in sample {
            let Some(outcome) = outcomes.get(mutant.name.as_str()) else { continue };
            let counts = report.by_crate.entry(mutant.package.clone()).or_default();
            match outcome.split('\t').next() {
                Some("noticed") => counts.noticed += 1,
                Some("refused") => {
                    counts.refused += 1;
                    report.refused.push(mutant.name.clone());
                }
                _ => {
                    counts.survived += 1;
                    report.unnoticed.push(format!("{} ({outcome})", mutant.name));
                }
            }
        }
        report
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut all = Counts::default();
        writeln!(f, "\n| crate | mutants | noticed | not compiled |")?;
        writeln!(f, "|---|---:|---:|---:|")?;
        for (name, counts) in &self.by_crate {
            row(f, name, counts)?;
            all.noticed += counts.noticed;
            all.survived += counts.survived;
            all.refused += counts.refused;
        }
        row(f, "all", &all)?;
        writeln!(f, "\nnot noticed:")?;
        self.unnoticed.iter().try_for_each(|name| writeln!(f, "  {name}"))?;
        writeln!(f, "\nnot compiled behind a condition:")?;
        self.refused.iter().try_for_each(|name| writeln!(f, "  {name}"))
    }
}

fn row(f: &mut Formatter<'_>, name: &str, counts: &Counts) -> fmt::Result {
    let Counts { noticed, survived, refused } = *counts;
    let count = noticed + survived;
    writeln!(f, "| {name} | {count} | {} | {refused} |", share(noticed, count))
}

/// A share in per cent with the interval of Wilson at 95 %.
fn share(part: u64, count: u64) -> String {
    const Z: f64 = 1.959_964;
    let (k, n) = (part as f64, count.max(1) as f64);
    let (p, z2) = (k / n, Z * Z / n);
    let middle = (p + z2 / 2.0) / (1.0 + z2);
    let half = Z / (1.0 + z2) * (p * (1.0 - p) / n + z2 / (4.0 * n)).sqrt();
    format!("{part}, {:.1} % ({:.1} to {:.1})", 100.0 * p, 100.0 * (middle - half).max(0.0), 100.0 * (middle + half))
}

#[cfg(test)]
mod tests {
    use super::share;

    /// Newcombe (1998), Statistics in Medicine 17, table I, method 3: 81 of 263 is 0.2553 to 0.3662, 0 of 20 is 0 to
    /// 0.1611.
    #[test]
    fn the_interval_is_that_of_the_literature() {
        assert_eq!(share(81, 263), "81, 30.8 % (25.5 to 36.6)");
        assert_eq!(share(0, 20), "0, 0.0 % (0.0 to 16.1)");
    }
}
