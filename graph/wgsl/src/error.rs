//! Errors in shaders, at the author's file and line.

/// An error in a shader, at the author's file and line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1; 0 if unknown.
    pub column: u32,
    /// What is wrong.
    pub message: String,
}

impl ShaderError {
    /// An error at a line and a column, both counted from 1; 0 if unknown.
    pub fn new(file: &str, (line, column): (u32, u32), message: impl Into<String>) -> Self {
        Self { file: file.into(), line, column, message: message.into() }
    }
}

impl std::fmt::Display for ShaderError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column.max(1), self.message)
    }
}

impl std::error::Error for ShaderError {}

/// The line and the column of a byte of a text, both from 1; the column in bytes.
pub(crate) fn position(text: &str, byte: usize) -> (u32, u32) {
    let before = &text.as_bytes()[..byte.min(text.len())];
    let start = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    (line as u32, (before.len() - start) as u32 + 1)
}
