//! The ways in which the contract uses a kind: its values, what is wired, and sizes.

use std::collections::BTreeMap;

use super::recorded::{Around, Use, defaults, one, records, variants};
use super::unread::Uses;
use super::violations::Violations;
use crate::node::{NodeInstance, NodeKind, Recording};
use afterimage_base::image::Size;

/// An image as tests have it, a single pixel, and the largest images that every device has.
const SIZES: [(u32, u32); 4] = [(64, 36), (1, 1), (7680, 4320), (8192, 8192)];

pub(super) fn look(kind: &NodeKind, violations: &mut Violations, seen: &mut dyn FnMut(&Recording)) {
    let mut uses = Uses::new(kind);
    for variant in variants(kind) {
        let node = NodeInstance::new(kind.clone(), variant.values);
        let is_default = variant.param.is_none();
        // The defaults are used in every way; each extreme with everything wired, which is where it can do most.
        let ways: &[(bool, bool)] =
            if is_default { &[(true, false), (false, false), (true, true)] } else { &[(true, false)] };
        for (is_fully_wired, is_exact) in ways.iter().copied() {
            let mut computed = BTreeMap::new();
            for size in SIZES.map(|(width, height)| Size::new(width, height)) {
                let around = if is_fully_wired { Around::Everything } else { Around::Required };
                let way = Use { node: &node, dynamic: &[], size, around, is_exact, is_default };
                let recorded = records(&way).then(|| one(&way, &mut computed, violations, seen)).flatten();
                match recorded {
                    Some(recorded) => uses.add(size, variant.param, recorded),
                    None => uses.add_unrecorded(variant.param),
                }
            }
        }
    }
    match uses.is_recorded() {
        // What is recorded wrongly would look like something that nothing reads.
        true if violations.of_kind() == 0 => uses.finish(violations),
        true => {}
        false => skipped(kind, violations),
    }
}

/// No value that was tried lets the kind record.
fn skipped(kind: &NodeKind, violations: &mut Violations) {
    let why = match NodeInstance::new(kind.clone(), defaults(kind)).verify() {
        Err(why) => format!("its defaults are refused ({why})"),
        Ok(()) => "each output equals its fallback at the defaults".into(),
    };
    violations.skip(format!(
        "no pass is checked, because {why}, and so it is at each parameter's extremes: give it defaults at which it \
         runs, or test it in a pipeline"
    ));
}
