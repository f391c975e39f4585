//! The results: a table, and for each failed case a line with the command that runs it again.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write as _;

use afterimage_graph::diagnostic::shown;
use afterimage_graph::image::Size;
use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};
use serde::{Deserialize, Serialize};

use super::settings::arguments;
use super::target::{Overrides, Target};

/// The results of all cases.
#[derive(Clone, Debug, Default, Serialize)]
pub struct StressReport {
    /// One for each pipeline and kind.
    pub results: Vec<Results>,
}

/// The cases of one pipeline or kind.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Results {
    pub title: String,
    /// The number of tested frames and sequences.
    pub cases: usize,
    /// Parameter values that the kind refuses.
    pub refused: usize,
    /// The number of tests of each invariant. Finite values and their range are tested in every case.
    pub verdicts: BTreeMap<Cow<'static, str>, usize>,
    pub failures: Vec<Failed>,
    /// Faults of functions of kinds in folders at the defaults, with all images together: a sentence for each.
    pub kernel_faults: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failed {
    /// The image or the sequence.
    pub case: String,
    pub why: String,
    /// The command that runs it again.
    pub command: String,
}

impl Results {
    pub(crate) fn new(target: &Target) -> Self {
        Self {
            title: target.title.clone(),
            cases: 0,
            refused: 0,
            verdicts: BTreeMap::new(),
            failures: Vec::new(),
            kernel_faults: Vec::new(),
        }
    }

    /// The results of a target whose process has ended without any.
    pub fn lost(target: &Target, why: String) -> Self {
        let command = format!("afterimage stress {}{}", target.words, arguments(&target.base));
        let failed = Failed { case: "process".to_owned(), why, command };
        Self { failures: vec![failed], ..Self::new(target) }
    }

    /// Counts a test of an invariant.
    pub(crate) fn judged(&mut self, verdict: &'static str) {
        *self.verdicts.entry(Cow::Borrowed(verdict)).or_default() += 1;
    }

    /// Counts a case, and adds it to the failures if something is wrong.
    pub(crate) fn count(&mut self, target: &Target, overrides: &Overrides, size: Size, case: &str, wrong: Vec<String>) {
        self.cases += 1;
        if wrong.is_empty() {
            return;
        }
        let mut all = target.base.clone();
        all.extend(overrides.iter().cloned());
        let chosen = if all.is_empty() { " --defaults".to_owned() } else { arguments(&all) };
        let command = format!("afterimage stress {}{chosen} --size {size} --case {case}", target.words);
        self.failures.push(Failed { case: case.to_owned(), why: wrong.join("; "), command });
    }
}

impl StressReport {
    pub fn cases(&self) -> usize {
        self.results.iter().map(|results| results.cases).sum()
    }

    pub fn failures(&self) -> impl Iterator<Item = &Failed> {
        self.results.iter().flat_map(|results| &results.failures)
    }

    /// The table, and a line for each failed case; at most `most` for each pipeline and kind.
    pub fn to_text(&self, most: usize) -> String {
        let mut text = self.table().to_string();
        text.push('\n');
        for (results, sentence) in
            self.results.iter().flat_map(|results| results.kernel_faults.iter().map(move |f| (results, f)))
        {
            let _ = writeln!(text, "{}: {}", results.title, shown(sentence));
        }
        for results in self.results.iter().filter(|results| !results.failures.is_empty()) {
            let _ = writeln!(text, "\n{}", results.title);
            for failed in results.failures.iter().take(most) {
                let _ = writeln!(text, "  {}: {}\n    {}", failed.case, failed.why, failed.command);
            }
            if results.failures.len() > most {
                let _ = writeln!(text, "  and {} more; `--all` lists them", results.failures.len() - most);
            }
        }
        let failures = self.failures().count();
        let _ = writeln!(text, "\n{} cases, {failures} failed", self.cases());
        text
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(NOTHING).set_header(["", "cases", "failed", "settings refused by the kind"]);
        for results in &self.results {
            let failed = results.failures.len();
            table.add_row([
                results.title.clone(),
                results.cases.to_string(),
                failed.to_string(),
                results.refused.to_string(),
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
