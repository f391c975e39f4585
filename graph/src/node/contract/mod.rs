//! The contract of node kinds: what a table of kinds must hold so that no graph, plan or device can trip over it.
//!
//! A plug-in author calls [`contract`] on her own table in a test:
//!
//! ```no_run
//! # const ALL: &[afterimage_graph::node::NodeKind] = &[];
//! if let Err(complaints) = afterimage_graph::node::contract(ALL) {
//!     panic!("{}", complaints.join("\n"));
//! }
//! ```

mod declared;
mod names;
mod recorded;

use std::collections::BTreeSet;

use super::kind::NodeKind;
use super::recorder::Recording;

pub(super) use names::{belongs, is_pascal, items, snake, stem};

/// Looks at all that a table of kinds promises.
///
/// * Everything has a manual text: kinds, ports, parameters, choices.
/// * Names are well formed (`PascalCase` kinds and choices, `snake_case` ports and parameters), no words of WGSL, and not given twice.
/// * Defaults, neutral values and quality levels are in their domains, and domains are finite.
/// * Stand-ins and states name real inputs of fitting types.
/// * Every kind records, at its defaults and at each parameter's extremes, with and without its optional inputs, for a picture and for a
///   single pixel; it says the same each time, gives every output that is wanted, and writes only to images of its own.
/// * The items of every shader file begin with the name of the file.
///
/// # Errors
/// All complaints, one sentence each, with the kind's name in front.
pub fn contract(kinds: &[NodeKind]) -> Result<(), Vec<String>> {
    let mut complaints = Complaints::default();
    let mut names = BTreeSet::new();
    for kind in kinds {
        complaints.about(kind.name());
        if !names.insert(kind.name()) {
            complaints.add("another kind has the same name");
        }
        declared::look(kind, &mut complaints);
        recorded::look(kind, &mut complaints, &mut |_| {});
    }
    if complaints.all.is_empty() { Ok(()) } else { Err(complaints.all) }
}

/// Calls `seen` with every recording that [`contract`] makes of a kind: at its defaults and at each parameter's extremes, with and without its
/// optional inputs.
pub fn for_each_recording(kind: &NodeKind, seen: &mut dyn FnMut(&Recording)) {
    recorded::look(kind, &mut Complaints::default(), seen);
}

/// What is wrong so far; nothing is said twice.
#[derive(Default)]
struct Complaints {
    kind: String,
    all: Vec<String>,
}

impl Complaints {
    fn about(&mut self, kind: &str) {
        self.kind = kind.to_owned();
    }

    fn add(&mut self, what: impl std::fmt::Display) {
        let complaint = format!("`{}`: {what}", self.kind);
        if !self.all.contains(&complaint) {
            self.all.push(complaint);
        }
    }

    fn require(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.add(what());
        }
    }
}
