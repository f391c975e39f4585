//! Documents: RON text becomes a structure in which everything has a location.
//!
//! [`parse`] reads the sections of a `Pipeline( ... )` and keeps the location of every key, kind, port, parameter and
//! value. It goes on after errors, so that all errors of a file are reported. Whether names, types and wires are valid
//! is checked by the next step, [`check`](crate::check::check).
//!
//! ```
//! let text = r#"Pipeline(
//!     inputs: { "scene": Color },
//!     nodes: { "display": Encode(source: "scene", transfer: Srgb) },
//!     outputs: { "display": "display" },
//! )"#;
//! let document = afterimage_graph::document::parse("look.ron", text).expect("the text is a pipeline");
//! assert_eq!(document.nodes[0].kind.value, "Encode");
//! ```
//!
//! # Sections
//!
//! | section | holds |
//! |---|---|
//! | `inputs` | `"name": Color` for each image that the host gives, see below |
//! | `nodes` | `"name": Kind(port: "other", parameter: value)`; every node also takes `when`, `format` and `label` |
//! | `outputs` | `"name": "node"` for each image that the host gets |
//! | `set` | overrides, `"node.parameter": value` or `"node": Off`, of inherited nodes or nodes of this file |
//! | `tiers` | `"low": { ... }` with the same entries as `set`, or `"film": "film.ron"` for another file |
//! | `extends` | a file whose entries this one inherits; an entry of the same name replaces the inherited one |
//! | `facts` | `"name": "its meaning"` for each fact that `when` may use; without the section, any name may be used |
//!
//! An input of type `Color` is scene-referred. `Exposed`, `LogLuminance`, `DisplayLinear` and `Encoded` are images of
//! later color states; `Data`, `Depth`, `Normals` and `Mask` are not colors. `Color(optional: true)` may be left out.
//!
//! A pipeline is itself a node: `"glow": Pipeline(file: "bloom.ron", source: "exposed", set: {"mips.levels": 3})`. Its
//! inputs are the ports; `"glow"` is its first output, `"glow.name"` another one, and its nodes are called `glow/mips`
//! and so on.

mod balance;
mod bracket;
mod entries;
mod misfits;
mod parser;
mod quotes;
mod read;
mod renamed;
mod shape;
mod syntax;
mod token;
mod tree;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Sources};

use parser::Parsed;

pub use entries::{Document, InputEntry, NodeEntry, Override, Tier};
pub(crate) use parser::read as read_tree;
pub(crate) use read::{doubled, settings};
pub(crate) use renamed::{present_name, renamed};
pub(crate) use tree::{Field, Group, Item, Tree};

/// The largest file that is read, in bytes. A pipeline of a thousand nodes has a tenth of it.
pub const LONGEST_FILE: usize = 4 << 20;

/// Reads a pipeline file. The name is the one that messages show, and that files named in it are relative to.
///
/// Reading goes on after a syntax error: the document holds what could be read, [`Document::problems`] the errors.
///
/// # Errors
/// When the text holds no `Pipeline( ... )`.
pub fn parse(file_name: &str, text: &str) -> Result<Document, Diagnostics> {
    let text = without_mark(text);
    let mut sources = Sources::default();
    let file = sources.insert(file_name, if text.len() > LONGEST_FILE { "" } else { text });
    let mut problems = Diagnostics::new(sources);
    if let Err(error) = check_length(&file, text) {
        problems.push(error);
        return Err(problems);
    }
    let Parsed { tree, errors } = read_tree(&file, text);
    errors.into_iter().for_each(|error| problems.push(error));
    read::document(&file, tree, problems)
}

/// The text without the byte order mark that some editors begin a file with.
pub(crate) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

fn check_length(file: &Arc<str>, text: &str) -> Result<(), Diagnostic> {
    let start = Location::new(file, 0..0);
    if text.len() > LONGEST_FILE {
        let message = format!("the file has {} bytes, more than a pipeline can have", text.len());
        return Err(Diagnostic::error("file-too-long", message)
            .at(&start, "")
            .help(format!("a pipeline file has at most {LONGEST_FILE} bytes")));
    }
    if parser::is_blank(file, text) {
        return Err(Diagnostic::error("empty-file", "the file is empty").at(&start, "").help(SMALLEST));
    }
    Ok(())
}

const SMALLEST: &str =
    "the smallest pipeline is `Pipeline(inputs: { \"scene\": Color }, nodes: {}, outputs: { \"display\": \"scene\" })`";
