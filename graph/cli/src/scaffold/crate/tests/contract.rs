//! The contract of kinds: what the framework requires of every kind, and that its shaders are valid in all their forms.

#[test]
fn the_kinds_of_this_crate_keep_the_contract() {
    let checked = afterimage_plan::contract(my_kind::ALL);
    let skipped = checked.unwrap_or_else(|violations| panic!("{}", violations.join("\n")));
    assert!(skipped.is_empty(), "not checked: {}", skipped.join("\n"));
}
