//! Errors in shaders, at the author's file and line.

use afterimage_base::diagnostic::shown;

/// An error in a shader, at the author's file and line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderError {
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1; 0 if unknown.
    pub column: u32,
    pub message: String,
    /// Remarks at places, that of the error included.
    pub labels: Vec<ShaderLabel>,
    pub help: Option<Box<str>>,
    /// True if the system had no thread to read the shader on, which may be right.
    pub is_of_system: bool,
    /// Further errors of the same module.
    pub others: Box<[ShaderError]>,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The byte in the line, from 1.
    pub column: u32,
}

/// A remark at a place of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderLabel {
    pub place: Place,
    pub text: String,
}

impl ShaderError {
    /// An error at a line and a column, both counted from 1; 0 if unknown.
    pub fn new(file: &str, (line, column): (u32, u32), message: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            line,
            column,
            message: message.into(),
            labels: Vec::new(),
            help: None,
            is_of_system: false,
            others: Box::default(),
        }
    }

    pub(crate) fn first_line(&self) -> String {
        format!("{}:{}:{}: {}", shown(&self.file), self.line, self.column.max(1), self.message)
    }
}

impl std::fmt::Display for ShaderError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.first_line())?;
        for ShaderLabel { place: Place { file, line, column }, text } in &self.labels {
            let file = shown(file);
            write!(f, "\n  {file}:{line}:{column}: {text}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        for other in &self.others {
            write!(f, "\n{other}")?;
        }
        Ok(())
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
