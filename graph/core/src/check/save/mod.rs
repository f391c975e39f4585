//! Saving: changed values are written into the text of a pipeline file, and everything else in it stays as it is.
//!
//! A value changes where the file gives it: one number, name or text differs. A default becomes a new field of its
//! node. What the file does not hold, nodes of the file that it `extends` and of pipelines used as nodes, gets an
//! override: in the tier if the tier gives the value, in the section `set` otherwise. The text is then checked again.
//!
//! ```
//! use afterimage_graph::check::{Change, NoFiles, Saver};
//! use afterimage_graph::value::Value;
//! # let registry = afterimage_graph::node::Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
//! let text = r#"Pipeline(
//!     inputs: { "scene": Color },
//!     nodes: { "exposed": Exposure(source: "scene" /* of the camera */) },
//!     outputs: { "display": "exposed" },
//! )"#;
//! let saver = Saver::new("look.ron", text, &registry, &NoFiles)?;
//! let brighter = Change::Value { parameter: "exposed.stops".into(), value: Value::Float(1.0) };
//! let saved = saver.save(None, &[brighter])?;
//! assert_eq!(saved, text.replace("\"scene\" /*", "\"scene\", stops: 1.0 /*"));
//! # Ok::<(), afterimage_graph::diagnostic::Diagnostics>(())
//! ```

//! Nodes and wires are edited the same way, by an [`Edit`]:
//!
//! ```
//! use afterimage_graph::check::{Edit, NoFiles, Reader, Saver};
//! # let registry = afterimage_graph::node::Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
//! let text = r#"Pipeline(
//!     inputs: { "scene": Color },
//!     nodes: { "exposed": Exposure(source: "scene") },
//!     outputs: { "display": "exposed" },
//! )"#;
//! let saver = Saver::new("look.ron", text, &registry, &NoFiles)?;
//! let reader = Reader::Output("display".into());
//! let inserted = saver.edit(None, &Edit::Insert { kind: "Vignette".into(), name: "dark".into(), reader })?;
//! let node = r#"Exposure(source: "scene"), "dark": Vignette(source: "exposed")"#;
//! let text = text.replace(r#"Exposure(source: "scene")"#, node);
//! assert_eq!(inserted, text.replace(r#""display": "exposed""#, r#""display": "dark""#));
//! # Ok::<(), afterimage_graph::diagnostic::Diagnostics>(())
//! ```

mod candidates;
mod edits;
mod file;
mod path;
mod proof;
mod reader;
mod refusals;
mod saver;
mod state;
mod structure;
mod wires;

pub use candidates::{Candidate, Connection};
pub use reader::Reader;
pub use saver::{Change, Saver};
pub use structure::Edit;
