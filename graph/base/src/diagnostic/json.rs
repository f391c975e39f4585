//! Diagnostics for editors and scripts.

use serde::Serialize;

use super::diagnostics::{Diagnostic, Diagnostics, Label, Severity};
use super::fix::Fix;
use super::location::Sources;

#[derive(Serialize)]
struct JsonDiagnostic<'a> {
    code: &'a str,
    severity: Severity,
    message: &'a str,
    labels: Vec<JsonLabel<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    help: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fix: Option<JsonFix>,
}

/// `start` and `end` are bytes from 0.
#[derive(Serialize)]
struct JsonFix {
    file: String,
    start: usize,
    end: usize,
    replacement: String,
}

/// Lines and columns count from 1, columns in characters; `start` and `end` are bytes from 0.
#[derive(Serialize)]
struct JsonLabel<'a> {
    file: &'a str,
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
    start: usize,
    end: usize,
    primary: bool,
    text: &'a str,
}

impl Diagnostics {
    /// An array with one object for each diagnostic: `code`, `severity` (`error` or `warning`), `message`, `labels`
    /// and, if they are known, `help` and `fix`: the `replacement` of the bytes from `start` to `end` of `file`.
    ///
    /// A label has `file`, `line`, `column`, `end_line`, `end_column` (from 1, columns in characters), `start`, `end`
    /// (bytes from 0), `primary` and `text`.
    pub fn to_json(&self) -> serde_json::Value {
        let all: Vec<_> = self.iter().map(|d| diagnostic(d, self)).collect();
        serde_json::to_value(all).expect("names, numbers and strings are all that is in it")
    }
}

fn diagnostic<'a>(d: &'a Diagnostic, all: &Diagnostics) -> JsonDiagnostic<'a> {
    let labels = d.labels.iter().map(|l| label(l, &all.sources)).collect();
    let fix = all.fix(d).map(|Fix { location, replacement }| JsonFix {
        file: location.file.to_string(),
        start: location.start,
        end: location.end,
        replacement,
    });
    JsonDiagnostic { code: d.code, severity: d.severity, message: &d.message, labels, help: d.help.as_deref(), fix }
}

fn label<'a>(label: &'a Label, sources: &Sources) -> JsonLabel<'a> {
    let location = &label.location;
    let at = |byte| sources.position(&location.file, byte).map_or((0, 0), |p| (p.line, p.column));
    let ((line, column), (end_line, end_column)) = (at(location.start), at(location.end));
    JsonLabel {
        file: &location.file,
        line,
        column,
        end_line,
        end_column,
        start: location.start,
        end: location.end,
        primary: label.primary,
        text: &label.text,
    }
}
