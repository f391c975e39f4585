//! Profiles of lenses, beside LensFun.

use crate::support::gpu::Picture;
use crate::support::harness::Nodes;

const SIZE: [u32; 2] = [96, 64];

/// The places that are read, in pixels: the column in red and blue, the line in green.
fn places() -> Picture {
    Picture::new(SIZE[0], SIZE[1], |x, y| [x as f32 + 0.5, y as f32 + 0.5, x as f32 + 0.5, 1.0])
}

fn made(nodes: &str, picture: &Picture) -> Picture {
    Nodes::new(nodes, &[("in", "Exposed")]).exact(&[picture])
}

/// Pixels at which LensFun was asked.
const PIXELS: [[u32; 2]; 4] = [[20, 8], [80, 20], [47, 60], [70, 40]];

/// A profile, and the columns of red, lines of green and columns of blue that LensFun 0.3.4 reads at the pixels: with
/// `ModifyFlags` of distortion and fringes, on an image of twice as many pixels and one, in which the middles of pixels
/// here are pixels.
struct Lens {
    parameters: &'static str,
    read: [[f32; 3]; 4],
}

const LENSES: [Lens; 9] = [
    Lens {
        parameters: "ptlens: (0.02964, -0.07853, 0.02943)",
        read: [
            [20.6322, 8.6129, 20.6322],
            [80.4052, 20.5336, 80.4052],
            [47.4978, 60.6229, 47.4978],
            [70.7205, 40.5833, 70.7205],
        ],
    },
    Lens {
        parameters: "ptlens: (0.02964, -0.07853, 0.02943), add: true",
        read: [
            [20.3618, 8.3819, 20.3618],
            [80.599, 20.465, 80.599],
            [47.5022, 60.3731, 47.5022],
            [70.2752, 40.4151, 70.2752],
        ],
    },
    Lens {
        parameters: "ptlens: (0.02964, -0.07853, 0.02943), crop: 0.6666667",
        read: [
            [20.2326, 8.2715, 20.2326],
            [80.8598, 20.3727, 80.8598],
            [47.4923, 60.9403, 47.4923],
            [70.9099, 40.6549, 70.9099],
        ],
    },
    Lens {
        parameters: "ptlens: (0.0, -0.05, 0.0)",
        read: [
            [20.882, 8.8265, 20.882],
            [80.239, 20.5924, 80.239],
            [47.4948, 60.7943, 47.4948],
            [70.9894, 40.6849, 70.9894],
        ],
    },
    Lens {
        parameters: "ptlens: (0.0, -0.05, 0.0), add: true",
        read: [
            [20.0533, 8.1183, 20.0533],
            [80.7986, 20.3943, 80.7986],
            [47.5055, 60.1843, 47.5055],
            [69.9939, 40.3088, 69.9939],
        ],
    },
    Lens {
        parameters: "poly5: (-0.030571633, 0.004658548)",
        read: [
            [21.3651, 9.2393, 21.3651],
            [79.5508, 20.8359, 79.5508],
            [47.5107, 59.8923, 47.5107],
            [70.1449, 40.3658, 70.1449],
        ],
    },
    Lens {
        parameters: "poly5: (-0.030571633, 0.004658548), add: true",
        read: [
            [19.5591, 7.696, 19.5591],
            [81.5278, 20.1363, 81.5278],
            [47.4887, 61.1459, 47.4887],
            [70.8716, 40.6404, 70.8716],
        ],
    },
    Lens {
        parameters: "ptlens: (0.0, -0.02, 0.0), red: (1.004, 0.003, -0.002), blue: (0.994, -0.004, 0.006)",
        read: [
            [20.5203, 8.6306, 20.7325],
            [80.5548, 20.5369, 80.2862],
            [47.4954, 60.6177, 47.5003],
            [70.8121, 40.574, 70.569],
        ],
    },
    Lens {
        parameters: "ptlens: (0.0, -0.02, 0.0), red: (1.004, 0.003, -0.002), blue: (0.994, -0.004, 0.006), \
                     crop: 0.6666667",
        read: [
            [20.1203, 8.2969, 20.417],
            [80.9829, 20.3886, 80.6262],
            [47.491, 60.869, 47.4967],
            [70.9514, 40.6273, 70.689],
        ],
    },
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn profiles_read_the_places_that_lensfun_reads() {
    for lens in LENSES {
        let found = made(&format!("\"result\": LensProfile(source: \"in\", {})", lens.parameters), &places());
        for ([x, y], wanted) in PIXELS.into_iter().zip(lens.read) {
            let found = found.at(x, y);
            let error = (0..3).map(|i| (found[i] - wanted[i]).abs()).fold(0.0, f32::max);
            assert!(error < 1e-3, "{} at {x}, {y}: {found:?} instead of {wanted:?}", lens.parameters);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn falloff_is_that_of_lensfun() {
    let flat = Picture::new(SIZE[0], SIZE[1], |_, _| [1.0; 4]);
    for (parameters, wanted) in [
        ("", [1.40592, 1.36379, 1.2389, 1.16603]),
        (", add: true", [0.71128, 0.73325, 0.80717, 0.85761]),
        (", crop: 0.6666667", [1.16696, 1.15082, 1.10135, 1.0714]),
    ] {
        let node = format!("\"result\": LensProfile(source: \"in\", falloff: (-0.9, 0.5, -0.2){parameters})");
        let found = made(&node, &flat);
        for ([x, y], wanted) in PIXELS.into_iter().zip(wanted) {
            let light = found.at(x, y)[1];
            assert!((light / wanted - 1.0).abs() < 1e-4, "{parameters} at {x}, {y}: {light} instead of {wanted}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_a_profile_adds_it_removes() {
    let lens = "ptlens: (0.01, -0.04, 0.02), red: (1.004, 0.003, -0.002), blue: (0.994, -0.004, 0.006), \
                falloff: (-0.4, 0.1, 0.0)";
    let nodes = format!(
        "\"result\": LensProfile(source: \"bent\", {lens}), \"bent\": LensProfile(source: \"in\", add: true, {lens})"
    );
    let found = made(&nodes, &places());
    // Near the border, what was moved out of the image is lost.
    for (x, y) in (8..56).flat_map(|y| (8..88).map(move |x| (x, y))) {
        let [found, own] = [found.at(x, y), places().at(x, y)];
        let error = (0..3).map(|i| (found[i] - own[i]).abs()).fold(0.0, f32::max);
        assert!(error < 0.03, "at {x}, {y}: {found:?} instead of {own:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_profile_that_folds_the_image_keeps_numbers_finite() {
    let picture = Picture::new(33, 17, |x, y| [(x * y) as f32, 65504.0, y as f32, 1.0]);
    for parameters in [
        "ptlens: (-1.0, -1.0, -1.0), poly5: (-1.0, -1.0)",
        "ptlens: (1.0, 1.0, 1.0), poly5: (1.0, 1.0), red: (-2.0, -2.0, -2.0), crop: 0.1",
        "falloff: (-8.0, -8.0, -8.0), zoom: 0.25, crop: 0.1, blue: (2.0, 2.0, 2.0)",
    ] {
        for add in [false, true] {
            let node = format!("\"result\": LensProfile(source: \"in\", add: {add}, {parameters})");
            let found = made(&node, &picture);
            let is_good = |pixel: &[f32; 4]| pixel[..3].iter().all(|x| (0.0..=65504.0).contains(x));
            assert!(found.pixels.iter().all(is_good), "{parameters}, add: {add}");
        }
    }
}
