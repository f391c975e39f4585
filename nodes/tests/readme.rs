//! The list of kinds in the README.

use std::collections::BTreeSet;

/// The names of kinds in the items of the list: words in backticks with small and capital letters.
fn listed(text: &str) -> BTreeSet<&str> {
    let (_, list) = text.split_once("\n## The kinds\n").expect("the README lists the kinds");
    let items = list.lines().filter(|line| line.starts_with("* "));
    let words = items.flat_map(|item| item.split('`').skip(1).step_by(2));
    let is_kind = |word: &&str| word.starts_with(char::is_uppercase) && word.contains(char::is_lowercase);
    words.filter(is_kind).collect()
}

#[test]
fn the_readme_lists_every_kind_and_no_other() {
    let kinds = afterimage_nodes::ALL.iter().chain(afterimage_nodes::HOST).map(|kind| kind.name()).collect();
    let listed = listed(include_str!("../README.md"));
    let missing: Vec<&&str> = listed.symmetric_difference(&kinds).collect();
    assert!(missing.is_empty(), "in the list or in the program alone: {missing:?}");
}
