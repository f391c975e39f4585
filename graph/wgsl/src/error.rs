//! Errors in shaders, at the author's file and line.

use afterimage_base::diagnostic::{Diagnostic, Diagnostics};

use crate::Shader;
use crate::import::SourceMap;
use crate::lints;

/// A mistake in a shader, at the author's file and line.
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
    /// An error in a line, counted from 1.
    pub fn at(file: &str, line: u32, message: impl Into<String>) -> Self {
        Self { file: file.into(), line, column: 0, message: message.into() }
    }
}

impl ShaderError {
    /// Adds the error to diagnostics, with an excerpt if it lies in `shader`'s own file.
    pub fn report(&self, shader: &Shader, diagnostics: &mut Diagnostics) {
        if self.file == shader.file() {
            diagnostics.add_source(shader.file(), shader.source());
        }
        diagnostics.push(match diagnostics.locate(&self.file, self.line, self.column) {
            Some(place) => Diagnostic::error("shader", self.message.clone()).at(&place, ""),
            None => Diagnostic::error("shader", self.to_string()),
        });
    }
}

impl std::fmt::Display for ShaderError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column.max(1), self.message)
    }
}

impl std::error::Error for ShaderError {}

/// Parses and validates a module; the first error otherwise.
///
/// # Errors
/// What naga or the lints refuse, at the author's line.
pub fn validate(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| {
        let place = error.location(source);
        place_error(map, place.map(|p| (p.line_number, p.line_position)), error.message().to_owned())
    })?;
    let capabilities = naga::valid::Capabilities::all();
    let flags = naga::valid::ValidationFlags::all();
    if let Some((span, why)) = lints::first(&module) {
        let place = span.location(source);
        return Err(place_error(map, Some((place.line_number, place.line_position)), why.into()));
    }
    naga::valid::Validator::new(flags, capabilities).validate(&module).map_err(|error| {
        // Of all the places that the error goes through, the narrowest says most.
        let spans =
            error.spans().map(|(span, _)| *span).filter(|span| span.to_range().is_some_and(|range| !range.is_empty()));
        let narrowest = spans.min_by_key(|span| span.to_range().map_or(usize::MAX, |range| range.len()));
        let place = narrowest.map(|span| span.location(source)).or_else(|| error.location(source));
        place_error(map, place.map(|p| (p.line_number, p.line_position)), root_cause(error.as_inner()))
    })?;
    Ok(module)
}

fn root_cause(error: &dyn std::error::Error) -> String {
    let mut parts = vec![error.to_string()];
    let mut source = error.source();
    while let Some(inner) = source {
        parts.push(inner.to_string());
        source = inner.source();
    }
    // "Function [10] is invalid" and the like only lead to what is said last.
    let last = parts.len() - 1;
    let says_more = |(at, part): &(usize, String)| *at == last || !part.ends_with("is invalid");
    parts.into_iter().enumerate().filter(says_more).map(|(_, part)| part).collect::<Vec<_>>().join(": ")
}

fn place_error(map: &SourceMap, place: Option<(u32, u32)>, mut message: String) -> ShaderError {
    // naga's sentences begin with a capital letter, ours do not; names stay as they are.
    let is_sentence = message.chars().nth(1).is_some_and(|second| second.is_ascii_lowercase() || second == ' ');
    if let Some(first) = message.get_mut(..1).filter(|_| is_sentence) {
        first.make_ascii_lowercase();
    }
    let (line, column) = place.unwrap_or((0, 0));
    let (file, line) = map.locate(line);
    ShaderError { file: file.into(), line, column, message }
}
