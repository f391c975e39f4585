//! The chains written by hand have the pictures of the kinds and of the pipeline, and the figures agree.

use afterimage_gpu::{Gpu, Opening};
use afterimage_graph::image::Size;

use crate::kinds::KindsReport;

fn gpu() -> Gpu {
    Gpu::open(&Opening::default()).expect("a graphics adapter")
}

/// The figures of these kinds on their own.
fn kinds_alone(names: &[&str], size: Size) -> KindsReport {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    crate::named_kinds(&gpu(), &names, &[size], 1).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[ignore = "needs a GPU: cargo test -p afterimage-bench -- --ignored"]
fn the_chain_of_lynx_has_the_picture_of_the_pipeline() {
    let report = crate::lynx_report(&gpu(), Size::new(320, 180), 3).unwrap_or_else(|error| panic!("{error}"));
    let (less, same) = (&report.baseline.light, &report.baseline.same);
    for times in [less, same] {
        assert!(times.fragment_ms > 0.0 && times.compute_ms > 0.0, "{report:?}");
    }
    // With the same filters, weights and noise only roundings and the noise at black and white are left: far below one code of 255.
    assert!(same.mean_difference < 0.001, "{report:?}");
    // Its light comes from half the pixels' means, so bright edges differ; a chain that is wired wrongly is off by far more on average.
    assert!(less.mean_difference < 0.03, "{report:?}");
}

#[test]
#[ignore = "needs a GPU: cargo test -p afterimage-bench -- --ignored"]
fn the_baselines_of_kinds_have_the_pictures_of_the_kinds() {
    // In a smaller image hardly a circle is larger than a pixel.
    let lens = kinds_alone(&["DepthOfField"], Size::new(960, 540));
    let others = kinds_alone(&["Gtao", "Taa"], Size::new(480, 270));
    assert_eq!((lens.kinds.len(), others.kinds.len()), (1, 2));
    let rows = [(&lens, &lens.kinds[0]), (&others, &others.kinds[0]), (&others, &others.kinds[1])];
    for (report, row) in rows {
        let baseline = row.sizes[0].baseline.as_ref().unwrap_or_else(|| panic!("`{}` has no baseline", row.kind));
        // Both results are half floats, which differ by one unit where roundings differ: by 2^-11 of the light, which
        // the compression takes to at most 2^-13. Intermediate images round once more.
        let rounding = 2.0_f64.powi(-12);
        assert!(baseline.mean_difference < rounding, "{report}");
        // The kind does far more than that, so a baseline that does less fails: without one of the two means of `Gtao`
        // they differ by 0.0013, without the limit of the history of `Taa` by 0.0029.
        assert!(baseline.effect > 8.0 * rounding, "{report}");
    }
}

#[test]
#[ignore = "needs a GPU: cargo test -p afterimage-bench -- --ignored"]
fn kinds_read_and_write_at_least_their_images() {
    let report = kinds_alone(&["Saturation", "Upsample", "Gaussian", "Resolve", "Fog"], Size::new(64, 32));
    assert!(report.skipped.is_empty() && report.kinds.len() == 5, "{report}");
    let halves = 64 * 32 * 8;
    let figures = |kind: &str| {
        let row = report.kinds.iter().find(|row| row.kind == kind).unwrap_or_else(|| panic!("{report}"));
        (row, &row.sizes[0])
    };
    for (kind, bytes) in [
        ("Saturation", 2 * halves),
        ("Gaussian", 2 * halves),
        // Four samples.
        ("Resolve", 5 * halves),
        // The depth has one float.
        ("Fog", 2 * halves + halves / 2),
    ] {
        let (row, figures) = figures(kind);
        assert_eq!((figures.least_bytes, row.with_others), (bytes, false), "{kind}: {report}");
        assert!(figures.moved_bytes >= bytes && figures.ms > 0.0, "{kind}: {report}");
    }
    // Between its two passes.
    assert_eq!(figures("Gaussian").1.moved_bytes, 4 * halves);
    // Its pyramid has a maker, and begins with half of the image.
    let (row, figures) = figures("Upsample");
    assert!(row.with_others && figures.least_bytes < halves, "{report}");
    assert_eq!(report.kinds[0].set, ["amount=1.5"]);
}
