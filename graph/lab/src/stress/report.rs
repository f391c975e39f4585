//! The results: a table, and for each failed case a line with the command that runs it again.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use afterimage_graph::diagnostic::shown;
use afterimage_graph::image::Size;
use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};
use serde::Serialize;

use super::settings::arguments;
use super::subject::{Overrides, Subject};

/// The results of all cases.
#[derive(Clone, Debug, Default, Serialize)]
pub struct StressReport {
    /// One for each pipeline and kind.
    pub tallies: Vec<Tally>,
}

/// The cases of one pipeline or kind.
#[derive(Clone, Debug, Serialize)]
pub struct Tally {
    pub title: String,
    /// The number of tested frames and sequences.
    pub cases: usize,
    /// Parameter values that the kind refuses.
    pub refused: usize,
    /// How often each promise was tested. Finite values and their range are tested in every case.
    pub verdicts: BTreeMap<&'static str, usize>,
    pub failures: Vec<Failed>,
    /// What functions of kinds in folders do wrong at the defaults, with all images together: a sentence for each.
    pub kernel_faults: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Failed {
    /// The image or the sequence.
    pub case: String,
    /// What is wrong.
    pub why: String,
    /// The command that runs it again.
    pub command: String,
}

impl Tally {
    pub(crate) fn new(subject: &Subject) -> Self {
        Self {
            title: subject.title.clone(),
            cases: 0,
            refused: 0,
            verdicts: BTreeMap::new(),
            failures: Vec::new(),
            kernel_faults: Vec::new(),
        }
    }

    /// Counts a test of a promise.
    pub(crate) fn judged(&mut self, verdict: &'static str) {
        *self.verdicts.entry(verdict).or_default() += 1;
    }

    /// Counts a case, and adds it to the failures if something is wrong.
    pub(crate) fn count(
        &mut self,
        subject: &Subject,
        overrides: &Overrides,
        size: Size,
        case: &str,
        wrong: Vec<String>,
    ) {
        self.cases += 1;
        if wrong.is_empty() {
            return;
        }
        let mut all = subject.base.clone();
        all.extend(overrides.iter().cloned());
        let chosen = if all.is_empty() { " --defaults".to_owned() } else { arguments(&all) };
        let command = format!("afterimage stress {}{chosen} --size {size} --case {case}", subject.words);
        self.failures.push(Failed { case: case.to_owned(), why: wrong.join("; "), command });
    }
}

impl StressReport {
    pub fn cases(&self) -> usize {
        self.tallies.iter().map(|tally| tally.cases).sum()
    }

    pub fn failures(&self) -> impl Iterator<Item = &Failed> {
        self.tallies.iter().flat_map(|tally| &tally.failures)
    }

    /// The table, and a line for each failed case; at most `most` for each pipeline and kind.
    pub fn to_text(&self, most: usize) -> String {
        let mut text = self.table().to_string();
        text.push('\n');
        for (tally, sentence) in
            self.tallies.iter().flat_map(|tally| tally.kernel_faults.iter().map(move |f| (tally, f)))
        {
            let _ = writeln!(text, "{}: {}", tally.title, shown(sentence));
        }
        for tally in self.tallies.iter().filter(|tally| !tally.failures.is_empty()) {
            let _ = writeln!(text, "\n{}", tally.title);
            for failed in tally.failures.iter().take(most) {
                let _ = writeln!(text, "  {}: {}\n    {}", failed.case, failed.why, failed.command);
            }
            if tally.failures.len() > most {
                let _ = writeln!(text, "  and {} more; `--all` lists them", tally.failures.len() - most);
            }
        }
        let failures = self.failures().count();
        let _ = writeln!(text, "\n{} cases, {failures} failed", self.cases());
        text
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(NOTHING).set_header(["", "cases", "failed", "settings refused by the kind"]);
        for tally in &self.tallies {
            let failed = tally.failures.len();
            table.add_row([
                tally.title.clone(),
                tally.cases.to_string(),
                failed.to_string(),
                tally.refused.to_string(),
            ]);
        }
        for column in 1..4 {
            if let Some(column) = table.column_mut(column) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        table
    }
}
