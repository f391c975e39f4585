//! The figures that are measured so far, in a file that survives an interruption.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::measurer::Confirmed;
use super::search::Measured;
use crate::LabError;
use crate::files::MAX_TEXT;
use afterimage_media::{read_text, write_atomic};

/// Figures by choice.
pub(super) struct SearchState {
    path: Option<PathBuf>,
    content: Content,
}

#[derive(Serialize, Deserialize)]
struct Content {
    /// What the figures depend on.
    identity: Value,
    measured: BTreeMap<String, Measured>,
    /// Errors that were predicted, without times.
    #[serde(default)]
    predicted: BTreeMap<String, Measured>,
    /// Figures of all pictures, also of those that the search does not see.
    #[serde(default)]
    confirmed: BTreeMap<String, Confirmed>,
}

impl SearchState {
    /// Opens the figures of an earlier search, if the file exists and has the same identity.
    pub(super) fn open(path: Option<&Path>, identity: Value) -> Result<Self, LabError> {
        let fresh =
            Content { identity, measured: BTreeMap::new(), predicted: BTreeMap::new(), confirmed: BTreeMap::new() };
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

    pub(super) fn predicted(&self, choice: &str) -> Option<Measured> {
        self.content.predicted.get(choice).copied()
    }

    /// Keeps predicted errors; [`Self::write`] writes them.
    pub(super) fn predict(&mut self, choice: String, errors: Measured) {
        self.content.predicted.insert(choice, errors);
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

    pub(super) fn write(&self) -> Result<(), LabError> {
        let Some(path) = &self.path else { return Ok(()) };
        let text = serde_json::to_string_pretty(&self.content)
            .map_err(|error| LabError::Machine(format!("cannot write the state: {error}")))?;
        Ok(write_atomic(path, format!("{text}\n").as_bytes())?)
    }

    /// The number of measured choices.
    pub(super) fn len(&self) -> usize {
        self.content.measured.len()
    }
}

fn read(path: &Path, identity: &Value) -> Result<Content, LabError> {
    let shown = path.display();
    let text = read_text(path, MAX_TEXT)?;
    let content: Content = serde_json::from_str(&text).map_err(|error| {
        LabError::request(format!("`{shown}` is not the state of a search: {error}")).hint("name another file")
    })?;
    if content.identity != *identity {
        return Err(LabError::request(format!(
            "the state `{shown}` is of another pipeline, other images or another device"
        ))
        .hint("remove it, or name another file"));
    }
    Ok(content)
}
