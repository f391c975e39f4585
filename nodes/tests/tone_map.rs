//! Parameters of ToneMap that exclude each other.

use afterimage_graph::prelude::Node;
use afterimage_nodes::{AgxLook, Curve, ToneMap, WorkingSpace};

#[test]
fn parameters_that_exclude_each_other_are_reported() {
    let message = |node: ToneMap| node.verify().expect_err("an error");
    let own = ToneMap { curve: Curve::AgX, space: WorkingSpace::Rec2020, ..ToneMap::default() };
    assert!(message(own).contains("`AgX` brings its own working space"));
    let line = ToneMap {
        space: WorkingSpace::Custom,
        red: [0.1, 0.1],
        green: [0.2, 0.2],
        blue: [0.3, 0.3],
        ..ToneMap::default()
    };
    assert!(message(line).contains("span a triangle"));
    let low = ToneMap { curve: Curve::Uchimura, maximum: 0.2, ..ToneMap::default() };
    assert!(message(low).contains("`maximum` must be above"));
    let looked = ToneMap { curve: Curve::AgX, peak: 4.0, look: AgxLook::Punchy, ..ToneMap::default() };
    assert!(message(looked).contains("needs a `peak` of 1"));
    assert_eq!(ToneMap::default().verify(), Ok(()));
}
