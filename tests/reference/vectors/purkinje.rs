//! The Purkinje shift.

use super::Op;
use crate::reference::purkinje::{full, simple, strength_linear, strength_log};

pub(super) const OPS: &[Op] = &[
    ("purkinje_strength_log", |case| vec![strength_log(case.number())]),
    ("purkinje_strength_lin", |case| vec![strength_linear(case.number())]),
    ("purkinje_full", |case| full(case.rgb(), case.param("strength"), case.param("s")).to_vec()),
    ("purkinje_full_half", |case| full(case.rgb(), case.param("strength"), case.param("s")).to_vec()),
    ("purkinje_simple", |case| simple(case.part_rgb("rgb"), case.part_number("E")).to_vec()),
];

#[test]
fn purkinje_references_agree_with_the_vectors() {
    super::check(OPS);
}
