//! Curves, mixers and tints.

use crate::reference::color::luminance;
use crate::reference::image::rgb;
use crate::reference::math::Rgb;
use crate::reference::oklab::{chroma, from_oklab, hue, oklab, turn};
use crate::reference::transfer::{srgb_decode, srgb_encode};
use crate::support::gpu::Picture;
use crate::support::harness::Nodes;

/// The colors that a kind makes of colors.
fn graded(node: &str, colors: &[Rgb]) -> Vec<Rgb> {
    let picture = Picture::new(colors.len() as u32, 1, |x, _| {
        let [r, g, b] = colors[x as usize].map(|channel| channel as f32);
        [r, g, b, 0.5]
    });
    let text = format!("\"result\": {node}");
    let found = Nodes::new(&text, &[("in", "DisplayLinear")]).exact(&[&picture]);
    assert!(found.pixels.iter().all(|pixel| pixel[3] == 0.5), "alpha has changed");
    found.pixels.iter().map(|pixel| rgb(pixel.map(f64::from))).collect()
}

/// The results of a curve for codes of gray.
fn bent(node: &str, codes: &[f64]) -> Vec<f64> {
    let grays: Vec<Rgb> = codes.iter().map(|code| [srgb_decode(*code); 3]).collect();
    graded(node, &grays).iter().map(|color| srgb_encode(color[1])).collect()
}

/// The values of a curve by `PchipInterpolator` of SciPy 1.17.1.
struct Spline {
    points: [[f64; 2]; 5],
    values: [[f64; 2]; 12],
}

const SPLINES: [Spline; 2] = [
    Spline {
        points: [[0.0, 0.02], [0.2, 0.1], [0.5, 0.55], [0.8, 0.9], [1.0, 0.97]],
        values: [
            [0.0, 0.02],
            [0.0909, 0.0408503],
            [0.1818, 0.0889882],
            [0.2727, 0.1743305],
            [0.3636, 0.3228422],
            [0.4545, 0.4826684],
            [0.5455, 0.6116455],
            [0.6364, 0.7369256],
            [0.7273, 0.8441263],
            [0.8182, 0.9094153],
            [0.9091, 0.9508478],
            [1.0, 0.97],
        ],
    },
    // With a level part, a turn, and ends inside.
    Spline {
        points: [[0.1, 0.0], [0.3, 0.4], [0.45, 0.4], [0.7, 0.3], [0.9, 1.0]],
        values: [
            [0.1, 0.0],
            [0.1727, 0.2127016],
            [0.2455, 0.3610367],
            [0.3182, 0.4],
            [0.3909, 0.4],
            [0.4636, 0.3991444],
            [0.5364, 0.3724238],
            [0.6091, 0.3300475],
            [0.6818, 0.3015128],
            [0.7545, 0.3710669],
            [0.8273, 0.6356264],
            [0.9, 1.0],
        ],
    },
];

/// A node of `Curves` with the points of one curve.
fn curve(name: &str, points: &[[f64; 2]; 5]) -> String {
    let names = ["black", "shadows", "middle", "highlights", "white"].iter().zip(points);
    let points: String = names.map(|(point, [x, y])| format!(", {name}_{point}: ({x:?}, {y:?})")).collect();
    format!("Curves(source: \"in\"{points})")
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn curves_are_those_of_another_implementation_and_exact_at_their_points() {
    for Spline { points, values } in &SPLINES {
        let codes = values.map(|[x, _]| x);
        for name in ["rgb", "luminance"] {
            let node = curve(name, points);
            for (found, [x, wanted]) in bent(&node, &codes).iter().zip(values) {
                assert!((found - wanted).abs() < 2e-5, "{name} at {x}: {found} instead of {wanted}");
            }
            let at_points = bent(&node, &points.map(|[x, _]| x));
            for (found, [x, wanted]) in at_points.iter().zip(points) {
                assert!((found - wanted).abs() < 4e-6, "{name} at the point {x}: {found} instead of {wanted}");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_curve_rises_between_rising_points_and_beyond_its_ends() {
    let codes: Vec<f64> = (0..=1200).map(|step| f64::from(step) / 1000.0).collect();
    let steep = [[0.05, 0.0], [0.06, 0.4], [0.5, 0.41], [0.51, 0.9], [0.8, 0.95]];
    let level = [[0.0, 0.0], [0.3, 0.6], [0.4, 0.6], [0.6, 0.6], [1.0, 1.0]];
    for points in [steep, level, SPLINES[0].points] {
        let found = bent(&curve("rgb", &points), &codes);
        let falls = found.windows(2).position(|pair| pair[1] < pair[0] - 1e-6);
        assert_eq!(falls, None, "{points:?}");
        assert!(found[1200] > points[4][1], "{points:?}: light above white does not go on");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_curve_of_a_channel_leaves_the_others_and_that_of_the_luminance_the_hue() {
    let color = [0.2, 0.4, 0.1];
    let points = &SPLINES[0].points;
    for (at, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let found = graded(&curve(name, points), &[color])[0];
        let of_all = graded(&curve("rgb", points), &[color])[0];
        let is_right = |channel: usize| {
            let wanted = if channel == at { of_all[channel] } else { color[channel] };
            (found[channel] - wanted).abs() < 1e-6
        };
        assert!((0..3).all(is_right), "{name}: {found:?}");
    }
    let found = graded(&curve("luminance", points), &[color])[0];
    let wanted = srgb_decode(bent(&curve("rgb", points), &[srgb_encode(luminance(color))])[0]);
    assert!((luminance(found) - wanted).abs() < 1e-6, "{found:?}");
    assert!((found[0] / found[1] - 0.5).abs() < 1e-5 && (found[2] / found[1] - 0.25).abs() < 1e-5, "{found:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn points_out_of_order_follow_each_other() {
    let codes: Vec<f64> = (0..=100).map(|step| f64::from(step) / 100.0).collect();
    let found = bent("Curves(source: \"in\", rgb_shadows: (0.9, 0.2), rgb_middle: (0.1, 0.5))", &codes);
    assert!(found.iter().all(|code| (-1e-6..=1.0 + 1e-6).contains(code)), "{found:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_mixer_permutes_channels_and_weighs_them() {
    let colors = [[0.1, 0.2, 0.3], [4.0, 0.5, 0.0]];
    let node = "ChannelMixer(source: \"in\", red: (0.0, 1.0, 0.0), green: (0.0, 0.0, 1.0), blue: (1.0, 0.0, 0.0))";
    for ([r, g, b], found) in colors.into_iter().zip(graded(node, &colors)) {
        assert_eq!(found, [g, b, r].map(|channel| f64::from(channel as f32)));
    }
    let row = "(0.25, 0.5, 0.125)";
    let node = format!("ChannelMixer(source: \"in\", red: {row}, green: {row}, blue: {row})");
    for ([r, g, b], found) in colors.into_iter().zip(graded(&node, &colors)) {
        let wanted = 0.25 * r + 0.5 * g + 0.125 * b;
        assert!(found.iter().all(|channel| (channel - wanted).abs() < 1e-6), "{found:?} instead of {wanted}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tints_keep_lightness_and_the_ends_and_have_their_hues() {
    let gray = |lightness: f64| [lightness.powi(3); 3];
    let grays = [0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0].map(gray);
    let node = "SplitToning(source: \"in\", shadow_hue: 250.0, shadow_amount: 0.4, highlight_hue: 80.0, \
                highlight_amount: 0.4)";
    let found = graded(node, &grays);
    for (gray, found) in grays.iter().zip(&found) {
        let [wanted, got] = [gray, found].map(|color| oklab(*color)[0]);
        assert!((wanted - got).abs() < 2e-4, "lightness {got} instead of {wanted}");
    }
    for end in [0, 6] {
        assert!(found[end].iter().all(|channel| (channel - grays[end][0]).abs() < 1e-5), "{:?}", found[end]);
    }
    let is_tinted = |color: Rgb, angle: f64| {
        (hue(color).rem_euclid(360.0) - angle).abs() < 0.5 && (0.01..0.04).contains(&chroma(color))
    };
    assert!(is_tinted(found[1], 250.0), "{} {}", hue(found[1]), chroma(found[1]));
    assert!(is_tinted(found[5], 80.0), "{} {}", hue(found[5]), chroma(found[5]));
    // Half of each, of opposite hues, is gray.
    let opposite = "SplitToning(source: \"in\", shadow_hue: 20.0, highlight_hue: 200.0)";
    assert!(chroma(graded(opposite, &[gray(0.5)])[0]) < 1e-4);
}

/// Colors of one lightness and chroma, at these hues in degrees.
fn ring(hues: &[f64]) -> Vec<Rgb> {
    let color = |hue: f64| from_oklab([0.7, 0.06 * hue.to_radians().cos(), 0.06 * hue.to_radians().sin()]);
    hues.iter().map(|hue| color(*hue)).collect()
}

/// The closed curve through the turns 10, -20, 0, 30, 5, 0, -15 and 40 degrees, by `PchipInterpolator` of SciPy 1.17.1
/// on three rounds of the points: hues and turns.
const TURNS: [[f64; 2]; 15] = [
    [29.0, 10.0],
    [40.0, -0.04671],
    [65.0, -20.0],
    [90.0, -12.13878],
    [125.0, 16.20069],
    [142.0, 30.0],
    [170.0, 17.34544],
    [230.0, 2.48153],
    [264.0, 0.0],
    [290.0, -11.4872],
    [310.0, -4.47872],
    [328.0, 40.0],
    [350.0, 34.31704],
    [5.0, 25.86297],
    [20.0, 15.90352],
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hues_turn_by_the_closed_curve_of_another_implementation() {
    let colors = ring(&TURNS.map(|[hue, _]| hue));
    let node = "HueCurves(source: \"in\", hue_red: 10.0, hue_orange: -20.0, hue_green: 30.0, hue_cyan: 5.0, \
                hue_purple: -15.0, hue_magenta: 40.0)";
    for ([from, by], found) in TURNS.into_iter().zip(graded(node, &colors)) {
        let wanted = ring(&[from + by])[0];
        assert!(turn(found, wanted) < 0.02, "at {from}: {} instead of {}", hue(found), from + by);
        assert!((chroma(found) - 0.06).abs() < 1e-4 && (oklab(found)[0] - 0.7).abs() < 1e-4, "{:?}", oklab(found));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn chroma_and_light_change_at_one_hue_alone() {
    let colors = ring(&[29.0, 65.0, 142.0, 264.0]);
    let found = graded("HueCurves(source: \"in\", saturation_green: 0.0)", &colors);
    assert!(chroma(found[2]) < 1e-4 && (oklab(found[2])[0] - 0.7).abs() < 1e-4, "{:?}", oklab(found[2]));
    let lit = graded("HueCurves(source: \"in\", lightness_green: 1.0)", &colors);
    for channel in 0..3 {
        assert!((lit[2][channel] - 2.0 * colors[2][channel]).abs() < 1e-4, "{:?}", lit[2]);
    }
    for other in [0, 1, 3] {
        for changed in [found[other], lit[other]] {
            let error = (0..3).map(|c| (changed[c] - colors[other][c]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-5, "{changed:?} instead of {:?}", colors[other]);
        }
    }
    // Gray has no hue.
    assert_eq!(graded("HueCurves(source: \"in\", lightness_red: 2.0)", &[[0.25; 3]]), [[0.25; 3]]);
}

/// Oklab of a mixture, back in light.
fn mixed(a: Rgb, b: Rgb, share: f64) -> Rgb {
    let [a, b] = [oklab(a), oklab(b)];
    from_oklab([0, 1, 2].map(|i| a[i] + share * (b[i] - a[i])))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_gradient_has_its_colors_at_quarters_and_mixes_them_in_oklab() {
    let stops: [Rgb; 5] = [[0.0, 0.02, 0.1], [0.3, 0.0, 0.2], [0.5, 0.4, 0.1], [0.2, 0.7, 0.6], [1.0, 0.9, 0.5]];
    let names = ["black", "shadows", "middle", "highlights", "white"].iter().zip(stops);
    let colors: String = names.map(|(name, [r, g, b])| format!(", {name}: ({r:?}, {g:?}, {b:?})")).collect();
    let node = format!("GradientMap(source: \"in\"{colors})");
    let codes: Vec<f64> = (0..=40).map(|step| f64::from(step) / 40.0).collect();
    let grays: Vec<Rgb> = codes.iter().map(|code| [srgb_decode(*code); 3]).collect();
    for (code, found) in codes.iter().zip(graded(&node, &grays)) {
        let before = (4.0 * code).floor().min(3.0);
        let wanted = mixed(stops[before as usize], stops[before as usize + 1], 4.0 * code - before);
        let off = (0..3).map(|c| (found[c] - wanted[c]).abs()).fold(0.0, f64::max);
        assert!(off < 2e-5, "at {code}: {found:?} instead of {wanted:?}");
    }
    // A color counts by its luminance, and light above white goes on.
    let green = [0.0, 0.3, 0.0];
    let [colored, gray] = [green, [luminance(green); 3]].map(|color| graded(&node, &[color])[0]);
    assert!((0..3).all(|c| (colored[c] - gray[c]).abs() < 1e-5), "{colored:?} and {gray:?}");
    let bright = graded(&node, &[[4.0; 3]])[0];
    assert!((0..3).all(|c| (bright[c] - 4.0 * stops[4][c]).abs() < 1e-5), "{bright:?}");
    let half = graded(&format!("GradientMap(source: \"in\", amount: 0.5{colors})"), &[[1.0; 3]])[0];
    assert!((0..3).all(|c| (half[c] - 0.5 - 0.5 * stops[4][c]).abs() < 2e-5), "{half:?}");
}

/// The curve of chroma through 0.2, 1.4, 0.9, 0.9 and 2 by `PchipInterpolator` of SciPy 1.17.1.
const CHROMAS: [[f64; 2]; 11] = [
    [0.0, 0.2],
    [0.1, 0.9176],
    [0.2, 1.3408],
    [0.25, 1.4],
    [0.35, 1.224],
    [0.5, 0.9],
    [0.6, 0.9],
    [0.8, 0.9616],
    [0.9, 1.3752],
    [1.0, 2.0],
    [1.3, 2.0],
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn chroma_follows_the_curve_over_lightness_of_another_implementation() {
    let color = |lightness: f64| from_oklab([lightness, 0.02 * lightness, -0.03 * lightness]);
    let node = "SaturationCurves(source: \"in\", black: 0.2, shadows: 1.4, middle: 0.9, highlights: 0.9, white: 2.0)";
    let colors = CHROMAS.map(|[lightness, _]| color(lightness));
    for (([lightness, factor], own), found) in CHROMAS.into_iter().zip(colors).zip(graded(node, &colors)) {
        let [l, a, b] = oklab(found);
        let wanted = [lightness, 0.02 * lightness * factor, -0.03 * lightness * factor];
        let off = (l - wanted[0]).abs().max((a - wanted[1]).abs()).max((b - wanted[2]).abs());
        assert!(off < 3e-5, "{own:?} becomes {:?} instead of {wanted:?}", oklab(found));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn vibrance_is_for_muted_colors_and_keeps_their_order() {
    // Of one hue and lightness, from gray to a chroma of 0.6 of the lightness.
    let colors: Vec<Rgb> = (0..=60).map(|step| from_oklab([0.5, 0.005 * f64::from(step), 0.0])).collect();
    for vibrance in [-1.0, -0.4, 0.5, 1.0] {
        // Of a scene, whose colors may leave the triangle of a display.
        let node = format!("\"result\": SaturationCurves(source: \"in\", vibrance: {vibrance:?})");
        let picture = Picture::new(61, 1, |x, _| {
            let [r, g, b] = colors[x as usize].map(|channel| channel as f32);
            [r, g, b, 1.0]
        });
        let found = Nodes::new(&node, &[("in", "Exposed")]).exact(&[&picture]);
        let found: Vec<Rgb> = found.pixels.iter().map(|pixel| rgb(pixel.map(f64::from))).collect();
        let chromas: Vec<f64> = found.iter().map(|color| chroma(*color)).collect();
        assert!(chromas.windows(2).all(|pair| pair[1] > pair[0] - 1e-5), "{vibrance}: {chromas:?}");
        let change = |step: usize| chromas[step] / chroma(colors[step]) - 1.0;
        assert!((change(1) - vibrance * 0.9604).abs() < 4e-3, "{vibrance}: {}", change(1));
        assert!(change(50).abs() < 1e-4 && change(60).abs() < 1e-4, "{vibrance}: {}", change(50));
        assert!(found.iter().all(|color| (oklab(*color)[0] - 0.5).abs() < 1e-4));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn wheels_move_light_by_their_stops_within_their_ranges() {
    let node = "LogWheels(source: \"in\", shadows: (-1.0, 0.0, 1.0), midtones: (0.5, 0.5, 0.0), \
                highlights: (2.0, -1.0, 0.0), low: -3.0, high: 1.0, softness: 2.0)";
    // Stops from middle gray, and those that are added: where ranges meet, the mean of both.
    for (stops, wanted) in [
        (-9.0, [-1.0, 0.0, 1.0]),
        (-4.0, [-1.0, 0.0, 1.0]),
        (-3.0, [-0.25, 0.25, 0.5]),
        (-2.0, [0.5, 0.5, 0.0]),
        (0.0, [0.5, 0.5, 0.0]),
        (1.0, [1.25, -0.25, 0.0]),
        (2.0, [2.0, -1.0, 0.0]),
        (12.0, [2.0, -1.0, 0.0]),
    ] {
        let light = 0.18 * f64::exp2(stops);
        let picture = Picture::new(1, 1, |_, _| [light as f32, light as f32, light as f32, 0.5]);
        let text = format!("\"result\": {node}");
        let found = Nodes::new(&text, &[("in", "Exposed")]).exact(&[&picture]).at(0, 0);
        for (found, wanted) in found.into_iter().zip(wanted) {
            let added = (f64::from(found) / light).log2();
            assert!((added - wanted).abs() < 1e-5, "at {stops} stops: {added} instead of {wanted}");
        }
    }
}
