//! A kind from a folder is freed with what holds it.

use std::sync::Arc;

use afterimage_graph::node::Registry;

use super::posterize::posterize;

#[test]
fn a_kind_is_dropped_with_its_registry() {
    let kind = posterize();
    let held = Arc::downgrade(kind.counted().expect("a kind from a folder is counted"));
    let registry = Registry::new(&[&[kind]]).expect("one kind has one name");
    assert!(held.upgrade().is_some() && registry.get("Posterize").is_some());
    drop(registry);
    assert!(held.upgrade().is_none(), "something holds the kind");
}
