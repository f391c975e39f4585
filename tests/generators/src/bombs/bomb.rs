//! A bomb, and the lines that bombs are made of.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use afterimage_graph::check::Loader;

/// A pipeline of built-in kinds, and the files that it names.
#[derive(Clone, Debug, Default)]
pub struct Bomb {
    /// The text of the pipeline.
    pub text: String,
    /// Other files, by their names.
    pub files: BTreeMap<String, String>,
}

impl Loader for Bomb {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let text = self.files.get(path).ok_or_else(|| "there is no such file".to_owned())?;
        Ok(text.as_bytes().into())
    }
}

impl Bomb {
    pub(super) fn of(text: String) -> Self {
        Self { text, files: BTreeMap::new() }
    }
}

/// A pipeline with the input `scene` and the output `out`, with these entries of `nodes`.
pub(super) fn pipeline(nodes: &str, output: &str) -> String {
    format!("Pipeline(inputs: {{\"scene\": Color}}, nodes: {{\n{nodes}}}, outputs: {{\"out\": \"{output}\"}})")
}

/// `count` lines, one for each index.
pub(super) fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, at| {
        writeln!(text, "{},", line(at)).expect("a string takes all text");
        text
    })
}

/// The name of the node before: the input for the first.
pub(super) fn before(at: usize) -> String {
    if at == 0 { "scene".to_owned() } else { format!("n{}", at - 1) }
}

pub(super) fn last(count: usize) -> String {
    before(count)
}
