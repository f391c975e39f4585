//! Images of a plan in bands.

use afterimage_graph::check::Facts;
use afterimage_graph::image::Format;
use afterimage_plan::{BandLimits, Halos, HostLimits, Options, Plan, Requirement};

use super::support::{all_formats, checked, plan_images};

/// A plan that filters an image of its own.
fn smoothed() -> Plan {
    let text = r#"Pipeline(
        inputs: { "scene": DisplayLinear },
        nodes: { "shown": Encode(source: "scene"), "smooth": Fxaa(source: "shown") },
        outputs: { "display": "smooth" },
    )"#;
    plan_images(&checked(text), Format::Rgba16Float, Facts::default(), all_formats(), Options::default())
}

/// The sampler of a graphics card rounds places in a texture of fewer rows in other ways than in one of the image.
#[test]
fn what_a_sampler_filters_is_in_bands_only_where_that_is_allowed() {
    let plan = smoothed();
    let shown = plan.images.iter().position(|image| image.label == "shown.result").expect("it is stored");
    let (bytes, parts, rows, host) = (1 << 30, None, None, HostLimits::NONE);
    let is_in_bands = |filters: bool| {
        let limits = BandLimits { bytes, taken: 0, block: 0, side: 4096, filters, least: 4, parts, rows, host };
        let banding = plan.banding(limits, &Halos::default(), &Requirement::typical);
        banding.unwrap_or_else(|error| panic!("{error}")).images[shown].is_some()
    };
    assert_eq!([true, false].map(is_in_bands), [true, false]);
}

/// Rows that a host wants alone, such as a crop: the bands have them all, once, and no more than whole workgroups.
#[test]
fn bands_have_the_rows_that_are_wanted() {
    let plan = smoothed();
    let height = plan.image(plan.outputs[0].image).desc.size.height;
    let last = height - 1;
    for wanted in [
        None,
        Some([0, height]),
        Some([0, 1]),
        Some([100, 101]),
        Some([100, 180]),
        Some([last, height]),
        Some([last, u32::MAX]),
        Some([height, height + 9]),
        Some([height + 9, u32::MAX]),
    ] {
        let (bytes, parts, host) = (8 << 20, None, HostLimits::NONE);
        let limits =
            BandLimits { bytes, taken: 0, block: 0, side: 4096, filters: true, least: 4, parts, rows: wanted, host };
        let banding = plan.banding(limits, &Halos::default(), &Requirement::typical);
        let banding = banding.unwrap_or_else(|error| panic!("{wanted:?}: {error}"));
        let bands = banding.sweeps.iter().flat_map(|sweep| &sweep.bands);
        let rows: Vec<_> = bands.flat_map(|band| &band.outputs).map(|(_, rows)| rows.clone()).collect();
        assert!(rows.windows(2).all(|pair| pair[0].end == pair[1].start), "{wanted:?}: {rows:?}");
        let (first, end) = (rows[0].start, rows[rows.len() - 1].end);
        // There are none below the picture.
        let [least, most] = wanted.unwrap_or([0, height]).map(|row| row.min(height));
        assert!(first <= least && end >= most, "{wanted:?}: {rows:?}");
        assert!(least - first < 32 && end - most < 32, "{wanted:?}: {rows:?}");
    }
}
