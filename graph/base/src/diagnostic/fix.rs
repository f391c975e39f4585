//! Changes of files that mend what is wrong with them.

use std::ops::Range;

use super::diagnostics::{Diagnostic, Diagnostics};
use super::location::Location;

/// A change of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// The words to replace.
    pub location: Location,
    /// The replacement.
    pub replacement: String,
}

impl Diagnostics {
    /// The change that mends a diagnostic: its [correction](Diagnostic::correction), if the wrong words occur once in
    /// its primary location.
    pub fn fix(&self, diagnostic: &Diagnostic) -> Option<Fix> {
        let correction = diagnostic.correction.as_ref()?;
        let location = &diagnostic.labels.iter().find(|label| label.primary)?.location;
        let text = self.sources.text(&location.file)?.get(location.span())?;
        let words = match &*correction.wrong {
            "" => 0..text.len(),
            wrong => only_occurrence(text, wrong)?,
        };
        Some(Fix { location: location.part(words), replacement: correction.right.clone() })
    }

    /// The changes that mend a file, from its beginning to its end. Of two that overlap, the first counts.
    pub fn fixes(&self, file: &str) -> Vec<Fix> {
        let mut fixes: Vec<Fix> = self.iter().filter_map(|diagnostic| self.fix(diagnostic)).collect();
        fixes.retain(|fix| *fix.location.file == *file);
        fixes.sort_by_key(|fix| fix.location.start);
        let mut end = 0;
        fixes.retain(|fix| {
            let is_free = fix.location.start >= end;
            end = if is_free { fix.location.end } else { end };
            is_free
        });
        fixes
    }
}

/// The text with changes from its beginning to its end that do not overlap.
///
/// # Panics
///
/// Panics if a location does not lie in the text.
pub fn apply(text: &str, fixes: &[Fix]) -> String {
    let mut fixed = text.to_owned();
    for fix in fixes.iter().rev() {
        fixed.replace_range(fix.location.span(), &fix.replacement);
    }
    fixed
}

/// Place of a whole word that occurs once.
fn only_occurrence(text: &str, words: &str) -> Option<Range<usize>> {
    let mut found = text.match_indices(words).map(|(at, _)| at).filter(|at| is_whole(text, words, *at));
    let first = found.next().filter(|_| found.next().is_none())?;
    Some(first..first + words.len())
}

fn is_whole(text: &str, words: &str, at: usize) -> bool {
    let (before, behind) = (&text[..at], &text[at + words.len()..]);
    let begins = is_joined(before.chars().next_back(), words.chars().next());
    let ends = is_joined(words.chars().next_back(), behind.chars().next());
    !begins && !ends
}

/// Returns whether two characters next to each other are of one word.
fn is_joined(left: Option<char>, right: Option<char>) -> bool {
    [left, right].iter().all(|c| c.is_some_and(|c| c.is_alphanumeric() || c == '_'))
}
