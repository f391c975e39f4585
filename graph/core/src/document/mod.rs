//! Documents: RON text becomes a structure in which everything has a location.
//!
//! [`parse`] reads the sections of a `Pipeline( ... )` and keeps the location of every key, kind, port, parameter and
//! value. It continues after errors, so that all errors of a file are reported. Whether names, types and wires are
//! valid is checked by the next step, [`check`](crate::check::check).
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
//! | `claims` | `"low": Claim(ms: 0.2, jod: 9.7, for: "desk", on: "a GPU at 3840x2160")`: what was measured of a tier |
//! | `extends` | a file whose entries this one inherits; an entry of the same name replaces the inherited one |
//! | `facts` | `"name": "its meaning"` for each fact that `when` may use; without the section, any name may be used |
//! | `usual` | `"node.parameter": "its meaning"` for the parameters that people change first |
//!
//! An input of type `Color` is scene-referred. `Exposed`, `LogLuminance`, `DisplayLinear` and `Encoded` are images of
//! later color states; `Data`, `Depth`, `Normals` and `Mask` are not colors. `Color(optional: true)` may be left out,
//! and the alpha of `Color(needs_alpha: true)` is a mask.
//!
//! Alpha of an output may be a mask, too, so files for a display are opaque. `"display": Output(source: "node", alpha:
//! Coverage)` declares that it is the share of the pixel that the picture covers.
//!
//! A pipeline is itself a node: `"glow": Pipeline(file: "bloom.ron", source: "exposed", set: {"mips.levels": 3})`. Its
//! inputs are the ports; `"glow"` is its first output, `"glow.name"` another one, and its nodes are called `glow/mips`
//! and so on.

mod balance;
mod bracket;
mod claim;
pub(crate) mod edit;
mod entries;
pub(crate) mod entry;
mod input_options;
mod literal;
mod output;
mod parser;
mod quotes;
mod read;
mod recover;
mod scan;
mod shape;
mod syntax;
mod token;
mod tokens;
mod tree;
mod unknown;

#[cfg(test)]
mod tests;

pub use claim::Claim;
pub use entries::{Document, InputEntry, NodeEntry, OutputEntry, Override, Tier};
pub use input_options::image_type_names;
pub(crate) use parser::read as read_tree;
pub use read::{MAX_FILE, SECTIONS, parse, without_mark};
pub(crate) use read::{doubled, settings};
pub use scan::{TextToken, TokenKind, tokens};
pub(crate) use tree::{Field, Group, Item, Tree};
