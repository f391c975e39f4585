//! The figures that are measured so far, in a file that survives an interruption.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use afterimage_graph::diagnostic::shown_path;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::measurer::Confirmed;
use super::target::Measured;
use crate::LabError;
use crate::files::MAX_TEXT;
use afterimage_media::{read_text, rewrite};

pub(super) struct SearchState {
    path: Option<PathBuf>,
    content: Content,
}

#[derive(Serialize, Deserialize)]
struct Content {
    /// The settings on which the figures depend.
    identity: Value,
    measured: BTreeMap<String, Measured>,
    /// Figures of all pictures, also of those that the search does not see.
    #[serde(default)]
    confirmed: BTreeMap<String, Confirmed>,
}

impl SearchState {
    /// Opens the figures of an earlier search, if the file exists and has the same identity.
    pub(super) fn open(path: Option<&Path>, identity: Value) -> Result<Self, LabError> {
        let fresh = Content { identity, measured: BTreeMap::new(), confirmed: BTreeMap::new() };
        let known = path.filter(|path| path.exists());
        let content = match known {
            None => fresh,
            Some(path) => read(path, &fresh.identity)?,
        };
        Ok(Self { path: path.map(Path::to_owned), content })
    }

    pub(super) fn measured(&self, choice: &str) -> Option<Measured> {
        self.content.measured.get(choice).copied()
    }

    /// Adds figures, and writes them to the file.
    pub(super) fn insert(&mut self, choice: String, measured: Measured) -> Result<(), LabError> {
        self.content.measured.insert(choice, measured);
        self.write()
    }

    pub(super) fn confirmed(&self, choice: &str) -> Option<Confirmed> {
        self.content.confirmed.get(choice).cloned()
    }

    /// Adds figures of all pictures, and writes them to the file.
    pub(super) fn confirm(&mut self, choice: String, confirmed: Confirmed) -> Result<(), LabError> {
        self.content.confirmed.insert(choice, confirmed);
        self.write()
    }

    fn write(&self) -> Result<(), LabError> {
        let Some(path) = &self.path else { return Ok(()) };
        let text = serde_json::to_string_pretty(&self.content)
            .map_err(|error| LabError::Machine(format!("cannot write the state: {error}")))?;
        Ok(rewrite(path, format!("{text}\n").as_bytes())?)
    }

    /// The number of measured choices.
    pub(super) fn len(&self) -> usize {
        self.content.measured.len()
    }
}

fn read(path: &Path, identity: &Value) -> Result<Content, LabError> {
    let shown = shown_path(path);
    let text = read_text(path, MAX_TEXT)?;
    let content: Content = serde_json::from_str(&text).map_err(|error| {
        LabError::request(format!("`{shown}` is not the state of a search: {error}")).hint("name another file")
    })?;
    let confirmed = content.confirmed.values().map(|confirmed| &confirmed.measured);
    let figures = content.measured.values().chain(confirmed);
    if !figures.clone().all(Measured::is_possible) {
        return Err(LabError::request(format!("`{shown}` has figures below 0, which nothing has measured"))
            .hint("remove it, or name another file"));
    }
    if content.identity != *identity {
        return Err(LabError::request(format!(
            "the state `{shown}` is of another pipeline, other images or another device"
        ))
        .hint("remove it, or name another file"));
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_state_with_any_number_changed_is_refused_or_possible() {
        let folder = std::env::temp_dir().join(format!("afterimage-search-state-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        let path = folder.join("state.json");
        let identity = json!({ "size": 8 });
        let mut state = SearchState::open(Some(&path), identity.clone()).expect("there is none");
        let (p999_without_worst, bytes, bytes_moved) = (Some(4.0), 6, 7);
        let measured = Measured { ms: 2.0, p999: 3.0, p999_without_worst, max: 5.0, bytes, bytes_moved };
        state.insert("a=1".to_owned(), measured).expect("it is written");
        state.confirm("a=1".to_owned(), Confirmed { measured, worst: "b".to_owned() }).expect("it is written");
        let text = std::fs::read_to_string(&path).expect("it was written");
        let mut refused = 0;
        for (at, digit) in text.match_indices(|c: char| c.is_ascii_digit()) {
            for number in ["-1", "-1e300", "1e999", "null", "[]", "1e300"] {
                let changed = [&text[..at], number, &text[at + digit.len()..]].concat();
                std::fs::write(&path, changed).expect("a temporary file");
                match SearchState::open(Some(&path), identity.clone()) {
                    Ok(state) => assert!(state.measured("a=1").is_none_or(|figures| figures.is_possible()), "{number}"),
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > 0);
        std::fs::remove_dir_all(folder).expect("it was made");
    }
}
