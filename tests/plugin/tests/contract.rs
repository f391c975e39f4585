//! The contract of kinds: what the framework requires of every kind, and that its shaders are valid in all their forms.
#![allow(missing_docs, reason = "a test binary exports nothing")]

#[test]
fn the_kinds_of_this_crate_keep_the_contract() {
    let skipped =
        afterimage_plan::contract(halftone::ALL).unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
    assert!(skipped.is_empty(), "not checked: {}", skipped.join("\n"));
}
