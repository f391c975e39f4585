//! Entries that are added: on one line, or on lines of their own.

/// An entry of a group.
pub(super) enum Entry {
    /// A value with its name.
    Value(String),
    /// A map with its name.
    Map(String, Vec<Entry>),
}

/// How entries on lines of their own are written.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    /// What a level of brackets adds to the indentation.
    pub(super) unit: &'a str,
    /// The end of a line.
    pub(super) end: &'a str,
}

impl Entry {
    /// A field of a node.
    pub(super) fn field(name: &str, value: &str) -> Self {
        Self::Value(format!("{name}: {value}"))
    }

    /// An override.
    pub(super) fn named(key: &str, value: &str) -> Self {
        Self::Value(format!("{key:?}: {value}"))
    }

    /// A section of the pipeline.
    pub(super) fn section(name: &str, entries: Vec<Self>) -> Self {
        Self::Map(name.to_owned(), entries)
    }

    pub(super) fn tier(name: &str, overrides: Vec<Self>) -> Self {
        Self::Map(format!("{name:?}"), overrides)
    }

    /// The entry without line breaks.
    pub(super) fn inline(&self) -> String {
        match self {
            Self::Value(text) => text.clone(),
            Self::Map(name, entries) if entries.is_empty() => format!("{name}: {{}}"),
            Self::Map(name, entries) => format!("{name}: {{ {} }}", inline(entries)),
        }
    }

    /// The entry without its indentation; a map has its entries on lines of their own.
    fn on_lines(&self, indent: &str, lines: Lines<'_>) -> String {
        match self {
            Self::Map(name, entries) if !entries.is_empty() => {
                let inner = on_lines(entries, &format!("{indent}{}", lines.unit), lines);
                format!("{name}: {{{}{inner},{}{indent}}}", lines.end, lines.end)
            }
            _ => self.inline(),
        }
    }
}

/// The entries on one line, with commas between them.
pub(super) fn inline(entries: &[Entry]) -> String {
    entries.iter().map(Entry::inline).collect::<Vec<_>>().join(", ")
}

/// A line for each entry, with commas between them.
pub(super) fn on_lines(entries: &[Entry], indent: &str, lines: Lines<'_>) -> String {
    let line = |entry: &Entry| format!("{indent}{}", entry.on_lines(indent, lines));
    entries.iter().map(line).collect::<Vec<_>>().join(&format!(",{}", lines.end))
}
