//! What was measured so far, in a file that survives an interruption.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::search::Measured;
use crate::failure::Failure;
use afterimage_media::write_atomic;

/// Figures by the choice that they belong to.
pub(super) struct SearchState {
    path: Option<PathBuf>,
    content: Content,
}

#[derive(Serialize, Deserialize)]
struct Content {
    /// What the figures are good for.
    problem: Value,
    measured: BTreeMap<String, Measured>,
}

impl SearchState {
    /// Goes on from a file, if there is one and it is about the same problem.
    pub(super) fn open(path: Option<&Path>, problem: Value) -> Result<Self, Failure> {
        let fresh = Content { problem, measured: BTreeMap::new() };
        let known = path.filter(|path| path.exists());
        let content = match known {
            None => fresh,
            Some(path) => read(path, &fresh.problem)?,
        };
        Ok(Self { path: path.map(Path::to_owned), content })
    }

    pub(super) fn get(&self, choice: &str) -> Option<Measured> {
        self.content.measured.get(choice).copied()
    }

    /// Keeps the figures, in the file too.
    pub(super) fn insert(&mut self, choice: String, measured: Measured) -> Result<(), Failure> {
        self.content.measured.insert(choice, measured);
        let Some(path) = &self.path else { return Ok(()) };
        let text = serde_json::to_string_pretty(&self.content)
            .map_err(|error| Failure::machine(format!("cannot write the state: {error}")))?;
        Ok(write_atomic(path, format!("{text}\n").as_bytes())?)
    }

    /// How many choices were measured.
    pub(super) fn len(&self) -> usize {
        self.content.measured.len()
    }
}

fn read(path: &Path, problem: &Value) -> Result<Content, Failure> {
    let shown = path.display();
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::user(format!("cannot read the state `{shown}`: {error}")))?;
    let content: Content = serde_json::from_str(&text).map_err(|error| {
        Failure::user(format!("`{shown}` is no state of a search: {error}")).hint("name another file")
    })?;
    if content.problem != *problem {
        return Err(Failure::user(format!(
            "the state `{shown}` is of another pipeline, other images or another device"
        ))
        .hint("remove it, or name another file"));
    }
    Ok(content)
}
