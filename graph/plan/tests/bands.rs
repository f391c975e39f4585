//! Images of a plan in bands.

use afterimage_graph::check::Facts;
use afterimage_graph::image::Format;
use afterimage_plan::{BandLimits, Halos, HostLimits, Options, Requirement};

use super::support::{all_formats, checked, plan_images};

/// The sampler of a graphics card rounds places in a texture of fewer rows in other ways than in one of the image.
#[test]
fn what_a_sampler_filters_is_in_bands_only_where_that_is_allowed() {
    let text = r#"Pipeline(
        inputs: { "scene": DisplayLinear },
        nodes: { "shown": Encode(source: "scene"), "smooth": Fxaa(source: "shown") },
        outputs: { "display": "smooth" },
    )"#;
    let plan = plan_images(&checked(text), Format::Rgba16Float, Facts::default(), all_formats(), Options::default());
    let shown = plan.images.iter().position(|image| image.label == "shown.result").expect("it is stored");
    let (bytes, parts, rows, host) = (1 << 30, None, None, HostLimits::NONE);
    let is_in_bands = |filters: bool| {
        let limits = BandLimits { bytes, taken: 0, block: 0, side: 4096, filters, least: 4, parts, rows, host };
        let banding = plan.banding(limits, &Halos::default(), &Requirement::typical);
        banding.unwrap_or_else(|error| panic!("{error}")).images[shown].is_some()
    };
    assert_eq!([true, false].map(is_in_bands), [true, false]);
}
