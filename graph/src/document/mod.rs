//! Documents: RON text becomes structure that knows its places.
//!
//! [`parse`] reads the sections of a `Pipeline( ... )` and keeps the place of every key, kind, port, parameter and value. A document may
//! still be nonsense: whether names, types and wires make sense is the next step's question ([`check`](crate::check::check)), so that all
//! mistakes of a file are told at once.
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
//! | `inputs` | `"name": Color` for each image that the host gives. `Color` is scene light; `Exposed`, `LogLuminance`, `DisplayLinear` and `Encoded` are images at later stages; `Data`, `Depth`, `Normals` and `Mask` are not light. Options: `Color(optional: true)`, `Color(allow_negative: true)` |
//! | `nodes` | `"name": Kind(port: "other", parameter: value)`; every node also takes `when`, `format` and `label` |
//! | `outputs` | `"name": "node"` for each image that the host gets |
//! | `set` | `"node.parameter": value`, `"node": Off`: changes to what `extends` brought, or to nodes of this file |
//! | `tiers` | `"low": { ... }` with the same entries as `set`, or `"film": "film.ron"` for another file |
//! | `extends` | a file whose entries this one inherits; an entry of the same name replaces the inherited one |
//! | `facts` | `"name": "what it says"` for each fact that `when` may ask; without the section, any name may be asked |
//!
//! A pipeline is itself a node: `"glow": Pipeline(file: "bloom.ron", source: "exposed", set: {"mips.levels": 3})`. Its inputs are the ports;
//! `"glow"` is its first output, `"glow.name"` another one, and its nodes are called `glow/mips` and so on.

mod read;
mod syntax;
mod tree;

use std::sync::Arc;

use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Place, Sources, Spanned};
use afterimage_base::image::ColorState;

pub(crate) use read::{doubled, settings};
pub(crate) use tree::{Field, Item, Tree, read as read_tree};

/// A pipeline file as it is written. It may be nonsense.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file's name.
    pub file: Arc<str>,
    /// Where `Pipeline` is written.
    pub place: Place,
    /// The file that this one changes.
    pub extends: Option<Spanned<String>>,
    /// The images that the host gives.
    pub inputs: Vec<InputEntry>,
    /// The nodes.
    pub nodes: Vec<NodeEntry>,
    /// The images that the host gets: name and wire.
    pub outputs: Vec<(Spanned<String>, Spanned<String>)>,
    /// Changes to nodes, in the order in which they are made.
    pub set: Vec<Override>,
    /// The quality levels.
    pub tiers: Vec<(Spanned<String>, Tier)>,
    /// The facts that conditions may ask and what each says; `None` where the file does not say which they are.
    pub facts: Option<Vec<(Spanned<String>, String)>>,
    /// Mistakes that can be seen without knowing any node kind.
    pub problems: Diagnostics,
    /// Names whose entries could not be read, so that nobody is told twice.
    pub(crate) unread: Vec<String>,
    /// Whether more names are missing than `unread` knows.
    pub(crate) is_partial: bool,
}

/// An image that the host gives.
#[derive(Clone, Debug, PartialEq)]
pub struct InputEntry {
    /// Its name.
    pub name: Spanned<String>,
    /// What its numbers mean.
    pub state: ColorState,
    /// Whether the host may leave it out.
    pub optional: bool,
    /// Whether negative numbers are meant.
    pub signed: bool,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeEntry {
    /// Its name.
    pub name: Spanned<String>,
    /// The name of its kind.
    pub kind: Spanned<String>,
    /// Ports, parameters and what every node takes, in the order of the file; a name may occur twice.
    pub(crate) fields: Vec<Field>,
}

/// A change to a node: `"mips.levels": 3` or `"local": Off`.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// `node.parameter`, `node`, or either of them behind `outer/`.
    pub key: Spanned<String>,
    pub(crate) value: Item,
}

/// What a quality level is.
#[derive(Clone, Debug, PartialEq)]
pub enum Tier {
    /// The same pipeline with changes.
    Settings(Vec<Override>),
    /// Another file.
    File(Spanned<String>),
}

/// A file longer than this is not read: a pipeline of a thousand nodes has a tenth of it.
pub const LONGEST_FILE: usize = 4 << 20;

/// Reads a pipeline file. The name is the one that messages show, and that files named in it are relative to.
///
/// # Errors
/// When the text is not RON, or not a `Pipeline( ... )`; other mistakes are kept in [`Document::problems`] for the check to tell.
pub fn parse(file_name: &str, text: &str) -> Result<Document, Diagnostics> {
    let text = without_mark(text);
    let mut sources = Sources::default();
    let file = sources.insert(file_name, if text.len() > LONGEST_FILE { "" } else { text });
    let fail = |diagnostic| {
        let mut all = Diagnostics::new(sources.clone());
        all.push(diagnostic);
        all
    };
    check_length(&file, text).map_err(fail)?;
    let tree = read_file(&file, text).map_err(fail)?;
    read::document(&file, tree, &sources).map_err(fail)
}

/// The text without the byte order mark that some editors begin a file with.
pub(crate) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// The tree of any RON file, with the wording of a pipeline's syntax errors.
pub(crate) fn read_file(file: &Arc<str>, text: &str) -> Result<Item, Diagnostic> {
    tree::read(file, text).map_err(|why| syntax::diagnose(file, text, &why))
}

fn check_length(file: &Arc<str>, text: &str) -> Result<(), Diagnostic> {
    let start = Place::new(file, 0..0);
    if text.len() > LONGEST_FILE {
        let message = format!("the file has {} bytes, more than a pipeline can have", text.len());
        return Err(Diagnostic::error("file-too-long", message)
            .at(&start, "")
            .help(format!("a pipeline file has at most {LONGEST_FILE} bytes")));
    }
    if is_blank(text) {
        return Err(Diagnostic::error("empty-file", "the file is empty").at(&start, "").help(SMALLEST));
    }
    Ok(())
}

const SMALLEST: &str =
    "the smallest pipeline is `Pipeline(inputs: { \"scene\": Color }, nodes: {}, outputs: { \"display\": \"scene\" })`";

/// Whether there is nothing but spaces and comments.
fn is_blank(text: &str) -> bool {
    ron::de::Deserializer::from_str(text).is_ok_and(|rest| rest.remainder().trim().is_empty())
}
