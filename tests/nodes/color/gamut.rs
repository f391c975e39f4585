//! ReferenceGamutCompress and Eetf.

use super::{Numbers, TRANSCENDENTAL, compare, light, picture, rgb, run, tolerance};
use crate::reference::color::{AP1, REC709, conversion, luminance};
use crate::reference::gamut::{Eetf, reference_compress};
use crate::reference::math::{largest, transform};
use crate::support::gpu::Picture;
use crate::support::harness::{assert_close, image};
use afterimage_graph::check::NoFiles;

/// Colors of AP0's size: channels of Rec.709 below 0.
fn wide([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x7a31_55e0_c9b8_1f27);
    picture([width, height], move |_| {
        let bright = (10.0 * numbers.next() - 5.0).exp2();
        [0, 1, 2].map(|_| bright * (1.3 * numbers.next() - 0.3))
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_gamut_compression_matches() {
    compare("Exposed", "ReferenceGamutCompress()", light, TRANSCENDENTAL, reference_compress);
    let input = wide([61, 37]);
    let output = run("Exposed", "ReferenceGamutCompress()", &NoFiles, &input);
    let tolerance = tolerance(1e-4, 1e-4, "the distance is a quotient, which is large for dark colors");
    // A color whose largest channel of AP1 is nearly 0 has no defined distance. A negative luminance does not exist.
    let is_lit = |rgb| largest(transform(&conversion(&REC709, &AP1), rgb)) > 0.01 && luminance(rgb) > 1e-3;
    let expected = image(&input).map_rgb(|rgb| if is_lit(rgb) { reference_compress(rgb) } else { [0.0; 3] });
    let lit = |picture: &Picture| {
        Picture::new(61, 37, |x, y| {
            let [.., a] = picture.at(x, y);
            if is_lit(rgb(input.at(x, y))) { picture.at(x, y) } else { [0.0, 0.0, 0.0, a] }
        })
    };
    assert_close("wide colors", &lit(&output), &expected, &tolerance);
    let inside = output.pixels.iter().zip(&input.pixels).filter(|(_, from)| is_lit(rgb(**from)));
    for (to, from) in inside {
        let ap1 = transform(&conversion(&REC709, &AP1), rgb(*to));
        let least = ap1[0].min(ap1[1]).min(ap1[2]);
        assert!(least > -0.35 * largest(ap1), "{from:?} became {ap1:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bt_2390_matches() {
    let tolerance = tolerance(1e-5, 5e-5, "PQ and its inverse in f32");
    for (source_peak, peak, black) in [(1000.0, 600.0, 0.0), (4000.0, 300.0, 0.05), (1000.0, 2000.0, 0.0)] {
        let eetf = Eetf { source_peak, peak, black };
        let parameters =
            format!("source_nits: {source_peak:?}, peak_nits: {peak:?}, black_nits: {black:?}, white_nits: 200.0");
        let scaled = |rgb: [f64; 3], curve: &dyn Fn([f64; 3]) -> [f64; 3]| {
            curve(rgb.map(|x| (200.0 * x).min(source_peak))).map(|x| x / 200.0)
        };
        let input = bright([61, 37]);
        let largest = run("DisplayLinear", &format!("Eetf({parameters})"), &NoFiles, &input);
        let expected = image(&input).map_rgb(|rgb| scaled(rgb, &|nits| eetf.on_largest(nits)));
        assert_close(&format!("{eetf:?}, largest"), &largest, &expected, &tolerance);
        let channels = run("DisplayLinear", &format!("Eetf({parameters}, on: Channels)"), &NoFiles, &input);
        let expected = image(&input).map_rgb(|rgb| scaled(rgb, &|nits| nits.map(|x| eetf.apply(x))));
        assert_close(&format!("{eetf:?}, channels"), &channels, &expected, &tolerance);
    }
}

/// Display-linear light up to five times white, with black.
fn bright(size: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x2b7e_1516_28ae_d2a6);
    picture(size, move |index| if index == 0 { [0.0; 3] } else { [0, 1, 2].map(|_| 5.0 * numbers.next().powi(3)) })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn extremes_stay_finite() {
    let input = light([61, 37]);
    for (state, node, most) in [
        ("Exposed", "ReferenceGamutCompress()", 2.0 * 65504.0),
        ("DisplayLinear", "Eetf()", 600.1 / 203.0),
        ("DisplayLinear", "Eetf(peak_nits: 80.0, black_nits: 5.0, on: Channels)", 80.1 / 203.0),
    ] {
        let output = run(state, node, &NoFiles, &input);
        let finite = output.pixels.iter().flat_map(|p| &p[..3]).all(|x| x.is_finite() && f64::from(*x) <= most);
        assert!(finite, "{node}");
    }
}
