//! The display that Eetf adapts to.

use afterimage_graph::color::{Chromaticities, Colorimetry, Transfer};
use afterimage_graph::prelude::Node;
use afterimage_nodes::Eetf;

#[test]
fn an_image_that_is_darker_than_its_display_fits() {
    let verified = |source_nits, peak_nits, display: f64| {
        let display = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, display);
        Eetf { source_nits, peak_nits, ..Eetf::default() }.verify_display(&display).is_ok()
    };
    assert!(verified(400.0, 1000.0, 400.0), "nothing is brighter than the source");
    assert!(verified(4000.0, 1000.0, 1000.0) && !verified(4000.0, 1000.0, 400.0));
}
