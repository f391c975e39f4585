//! The contract of node kinds: what graphs, plans and devices rely on.
//!
//! The author of a plug-in calls [`contract`] on the table of the plug-in in a test:
//!
//! ```no_run
//! # const ALL: &[afterimage_graph::node::NodeKind] = &[];
//! if let Err(violations) = afterimage_graph::node::contract(ALL) {
//!     panic!("{}", violations.join("\n"));
//! }
//! ```

mod declared;
mod limits;
mod names;
mod passes;
mod recorded;
mod variants;
mod violations;

use std::collections::BTreeSet;

use super::kind::NodeKind;
use super::recorder::Recording;
use violations::Violations;

pub use names::kind_file_name;
pub(super) use names::{is_pascal, is_snake, snake, stem};

/// Checks the contract for each kind of a table.
///
/// * Kinds, ports, parameters and choices have documentation.
/// * Names are well formed (`PascalCase` kinds and choices, `snake_case` ports and parameters), unique, and no keywords
///   of WGSL.
/// * Defaults, neutral values and quality levels are in their domains, and domains are finite.
/// * Fallbacks and states name existing inputs of matching types.
/// * Every kind records at its defaults and at each parameter's extremes, with and without its optional inputs, for an
///   image, a single pixel, and images of 7680x4320 and 8192x8192. It records the same each time, gives every output
///   that is used, and writes only to its own images.
/// * Each parameter is a member of a uniform or changes what is recorded, each input is read, and so is each image that
///   a pass stores.
/// * A function takes pixels of images of its result's size only.
/// * A mip level or a layer of an image is drawn before a pass reads it.
/// * Dispatches, workgroups, buffers and bindings are within what every WebGPU device allows, also for the largest
///   images.
/// * A parameter whose change needs no new plan changes nothing but uniforms.
///
/// Returns what could not be checked, one sentence each with what makes it reachable: kinds that never record, since
/// they refuse their values or are replaced by their fallbacks.
///
/// # Errors
/// All violations, one sentence each, beginning with the kind's name.
pub fn contract(kinds: &[NodeKind]) -> Result<Vec<String>, Vec<String>> {
    contract_with(kinds, &mut |_| Vec::new())
}

/// Checks the contract of [`contract`], and calls `seen` with every recording, which returns further violations.
///
/// # Errors
/// All violations, one sentence each, beginning with the kind's name.
pub fn contract_with(
    kinds: &[NodeKind],
    seen: &mut dyn FnMut(&Recording) -> Vec<String>,
) -> Result<Vec<String>, Vec<String>> {
    let mut names = BTreeSet::new();
    let (mut all, mut skipped) = (Vec::new(), Vec::new());
    for kind in kinds {
        let mut violations = Violations::default();
        violations.require(names.insert(kind.name()), || "another kind has the same name".into());
        declared::look(kind, &mut violations);
        let unchecked = variants::look(kind, &mut violations, seen);
        let about_kind = |text: String| format!("`{}`: {text}", kind.name());
        skipped.extend(unchecked.map(about_kind));
        all.extend(violations.0.into_iter().map(about_kind));
    }
    if all.is_empty() { Ok(skipped) } else { Err(all) }
}
