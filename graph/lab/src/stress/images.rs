//! The extreme images: each is a function from a position to a pixel.

use afterimage_graph::color::rec709_luminance;
use afterimage_graph::image::{Signedness, Size};

/// The largest finite half float, the limit of sanitized images.
const MAX_HALF: f32 = 65504.0;
/// The smallest subnormal half float.
const MIN_HALF: f32 = 5.960_464_5e-8;
const MIN_FLOAT: f32 = 1.4e-45;

#[derive(Clone, Copy)]
pub(crate) struct Extreme {
    /// Its name, for `--case`.
    pub(crate) name: &'static str,
    rule: Rule,
}

#[derive(Clone, Copy)]
enum Rule {
    Place(fn(Place) -> [f32; 4]),
    Constant([f32; 4]),
}

/// A position and the size of the image.
#[derive(Clone, Copy)]
struct Place {
    x: u32,
    y: u32,
    size: Size,
}

impl Place {
    fn is_middle(self) -> bool {
        self.x == self.size.width / 2 && self.y == self.size.height / 2
    }

    /// From 0 to 1 along the longer side.
    fn along(self) -> f32 {
        let (at, last) = match self.size.width >= self.size.height {
            true => (self.x, self.size.width - 1),
            false => (self.y, self.size.height - 1),
        };
        at as f32 / last.max(1) as f32
    }

    fn is_first_half(self) -> bool {
        self.along() < 0.5
    }
}

const fn constant(value: f32) -> [f32; 4] {
    [value, value, value, 1.0]
}

const GRAY: [f32; 4] = constant(0.18);

/// One pixel of another value in a gray image.
fn spot(place: Place, value: f32) -> [f32; 4] {
    if place.is_middle() { [value; 4] } else { GRAY }
}

/// All extreme images, the harmless ones first.
pub(crate) const ALL: &[Extreme] = &[
    Extreme { name: "gray", rule: Rule::Constant(GRAY) },
    Extreme { name: "bright", rule: Rule::Constant(constant(18.0)) },
    Extreme { name: "black", rule: Rule::Constant(constant(0.0)) },
    Extreme { name: "white", rule: Rule::Constant(constant(1.0)) },
    Extreme { name: "nan", rule: Rule::Place(|place| spot(place, f32::NAN)) },
    Extreme { name: "inf", rule: Rule::Place(|place| spot(place, f32::INFINITY)) },
    Extreme { name: "minus-inf", rule: Rule::Place(|place| spot(place, f32::NEG_INFINITY)) },
    Extreme { name: "all-nan", rule: Rule::Constant([f32::NAN; 4]) },
    Extreme { name: "all-inf", rule: Rule::Constant([f32::INFINITY; 4]) },
    Extreme {
        name: "negative",
        rule: Rule::Place(|place| if place.is_first_half() { constant(-1000.0) } else { GRAY }),
    },
    Extreme { name: "minus-zero", rule: Rule::Constant([-0.0; 4]) },
    Extreme { name: "largest-half", rule: Rule::Constant([MAX_HALF; 4]) },
    Extreme { name: "largest-float", rule: Rule::Constant([f32::MAX; 4]) },
    Extreme { name: "subnormal-half", rule: Rule::Constant(constant(MIN_HALF)) },
    Extreme { name: "subnormal-float", rule: Rule::Constant(constant(MIN_FLOAT)) },
    Extreme { name: "tiny", rule: Rule::Constant(constant(1e-30)) },
    Extreme { name: "firefly", rule: Rule::Place(|place| constant(if place.is_middle() { MAX_HALF } else { 0.0 })) },
    Extreme { name: "edge", rule: Rule::Place(|place| constant(if place.is_first_half() { 0.01 } else { 10_000.0 })) },
    Extreme { name: "checkerboard", rule: Rule::Place(|place| constant(((place.x + place.y) % 2) as f32)) },
    Extreme {
        name: "diagonal",
        rule: Rule::Place(|place| inner(place, place.x + place.size.height / 2 == place.y + place.size.width / 2)),
    },
    Extreme { name: "board", rule: Rule::Place(|place| inner(place, (place.x + place.y).is_multiple_of(2))) },
    Extreme { name: "ramp", rule: Rule::Place(|place| constant((24.0 * place.along() - 12.0).exp2())) },
    Extreme { name: "primaries", rule: Rule::Place(primaries) },
    Extreme { name: "wide", rule: Rule::Place(wide) },
    Extreme { name: "mixed", rule: Rule::Place(mixed) },
    Extreme { name: "light-without-alpha", rule: Rule::Constant([1.0, 0.5, 0.25, 0.0]) },
    Extreme { name: "clear", rule: Rule::Place(|place| [1.0, 0.5, 0.25, f32::from(u8::from(place.is_first_half()))]) },
];

/// A bright pixel where `is_lit`, in the middle of a black image: no filter loses energy at the border.
fn inner(place: Place, is_lit: bool) -> [f32; 4] {
    let is_inner = |at: u32, side: u32| at.abs_diff(side / 2) <= (side / 8).max(1);
    let is_lit = is_lit && is_inner(place.x, place.size.width) && is_inner(place.y, place.size.height);
    constant(if is_lit { 100.0 } else { 0.0 })
}

/// Diagonal lines of one pixel, each image moved by a pixel.
pub(crate) const MOVING: [Extreme; 4] = [
    Extreme { name: "lines", rule: Rule::Place(|place| lines(place, 0)) },
    Extreme { name: "lines", rule: Rule::Place(|place| lines(place, 1)) },
    Extreme { name: "lines", rule: Rule::Place(|place| lines(place, 2)) },
    Extreme { name: "lines", rule: Rule::Place(|place| lines(place, 3)) },
];

fn lines(place: Place, shift: u32) -> [f32; 4] {
    constant(if (place.x + 31 * place.y + shift).is_multiple_of(32) { 8.0 } else { 0.02 })
}

/// Colors with zeros in one or two channels and the largest half float in the others.
fn primaries(place: Place) -> [f32; 4] {
    let index = place.x + place.y * 3;
    let channel = |c: u32| if (index % 6 + 1) >> c & 1 == 1 { MAX_HALF } else { 0.0 };
    [channel(0), channel(1), channel(2), 1.0]
}

/// Colors outside of Rec.709, from dim to bright: the green of Rec.2020 and the blue of ACEScg in the Rec.709 basis,
/// and a color of almost no luminance.
fn wide(place: Place) -> [f32; 4] {
    const COLORS: [[f32; 3]; 4] =
        [[-0.587_64, 1.132_90, -0.100_58], [-0.081_02, -0.014_27, 1.153_00], [1.0, -0.29, 0.0], [0.18; 3]];
    let [r, g, b] = COLORS[((place.x + place.y) % 4) as usize].map(|x| x * (8.0 * place.along() - 4.0).exp2());
    [r, g, b, 1.0]
}

/// A ramp with every bad value in it, for targets that are too large for all images.
fn mixed(place: Place) -> [f32; 4] {
    const ODD: [f32; 7] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1000.0, f32::MAX, MIN_HALF, -0.0];
    let index = (place.x + place.y * place.size.width) as usize;
    match index % 5 {
        3 => [ODD[index / 5 % 7]; 4],
        4 if index.is_multiple_of(2) => primaries(place),
        _ => constant((24.0 * place.along() - 12.0).exp2()),
    }
}

impl Extreme {
    /// The image of that name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        ALL.iter().copied().find(|image| image.name == name)
    }

    pub(crate) fn pixels(self, size: Size) -> Vec<[f32; 4]> {
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| Place { x, y, size }));
        match self.rule {
            Rule::Place(rule) => places.map(rule).collect(),
            Rule::Constant(pixel) => places.map(|_| pixel).collect(),
        }
    }

    /// True if sanitizing changes it.
    pub(crate) fn is_sanitized(self, size: Size) -> bool {
        let bits = |pixels: &[[f32; 4]]| pixels.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
        let pixels = self.pixels(size);
        bits(&sanitized(&pixels, size, Signedness::Unsigned)) != bits(&pixels)
    }
}

/// An image after sanitizing, which happens at the inputs of every graph: NaN, negative infinity, and an infinity that
/// no neighbor of the pixel shares become the least of four: of each pair of opposite neighbors the larger finite
/// number; then all is limited.
pub(crate) fn sanitized(pixels: &[[f32; 4]], size: Size, signedness: Signedness) -> Vec<[f32; 4]> {
    let mut clean = pixels.to_vec();
    for (index, pixel) in clean.iter_mut().enumerate() {
        if !pixel.iter().all(|x| x.is_finite()) {
            let pairs = opposite_neighbors(pixels, size, index);
            *pixel = [0, 1, 2, 3].map(|c| repaired(pixel[c], pairs.map(|pair| pair.map(|pixel| pixel[c]))));
        }
        *pixel = limited(*pixel, signedness);
    }
    clean
}

/// Samples after sanitizing: each by itself, because its neighbors may show other surfaces. A sample with a number that
/// is not known is not known at all: kernels leave it out.
pub(crate) fn sanitized_samples(samples: &[[f32; 4]], signedness: Signedness) -> Vec<[f32; 4]> {
    let is_known = |sample: &[f32; 4]| sample.iter().all(|x| !x.is_nan() && *x != f32::NEG_INFINITY);
    samples.iter().map(|sample| if is_known(sample) { limited(*sample, signedness) } else { [f32::NAN; 4] }).collect()
}

/// A pixel within the limits of its signedness.
fn limited(pixel: [f32; 4], signedness: Signedness) -> [f32; 4] {
    let bounded = |lowest: f32| pixel.map(|x| if x.is_nan() { 0.0 } else { x.clamp(lowest, MAX_HALF) });
    match signedness {
        Signedness::Unsigned => bounded(0.0),
        Signedness::Signed => bounded(-MAX_HALF),
        Signedness::Extended => {
            let [r, g, b, a] = pixel.map(|x| if x == f32::NEG_INFINITY { 0.0 } else { x });
            let [r, g, b, _] = limited([r, g, b, a], Signedness::Signed);
            let [r, g, b] = with_luminance([r, g, b]);
            [r, g, b, bounded(0.0)[3]]
        }
    }
}

/// Light whose negative components are as small as it takes for a luminance of 0 or more.
fn with_luminance(rgb: [f32; 3]) -> [f32; 3] {
    let positive = rec709_luminance(rgb.map(|x| x.max(0.0)));
    let negative = -rec709_luminance(rgb.map(|x| x.min(0.0)));
    if negative <= positive { rgb } else { rgb.map(|x| if x < 0.0 { x * (positive / negative) } else { x }) }
}

/// A number of a pixel, from those of the pixels around it.
fn repaired(value: f32, pairs: [[f32; 2]; 4]) -> f32 {
    let is_bright = value == f32::INFINITY && pairs.as_flattened().contains(&f32::INFINITY);
    if value.is_finite() || is_bright {
        return value;
    }
    let larger = |pair: [f32; 2]| pair.into_iter().filter(|x| x.is_finite()).reduce(f32::max);
    pairs.into_iter().filter_map(larger).reduce(f32::min).unwrap_or(value)
}

/// The eight pixels around one, opposite ones together. NaN outside of the image.
fn opposite_neighbors(pixels: &[[f32; 4]], size: Size, index: usize) -> [[[f32; 4]; 2]; 4] {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let (x, y) = (index as i64 % width, index as i64 / width);
    let at = |x: i64, y: i64| {
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        if is_inside { pixels[(x + y * width) as usize] } else { [f32::NAN; 4] }
    };
    [(1, 0), (-1, 1), (0, 1), (1, 1)].map(|(dx, dy)| [at(x + dx, y + dy), at(x - dx, y - dy)])
}

#[cfg(test)]
mod tests {
    use afterimage_graph::image::{Signedness, Size};

    use super::{ALL, Extreme, sanitized};

    #[test]
    fn names_are_different_and_found() {
        for (index, image) in ALL.iter().enumerate() {
            assert!(ALL[..index].iter().all(|other| other.name != image.name));
            assert_eq!(Extreme::named(image.name).map(|found| found.name), Some(image.name));
        }
    }

    #[test]
    fn images_are_what_their_names_say() {
        let size = Size::new(13, 11);
        let of = |name: &str| Extreme::named(name).map(|image| image.pixels(size)).unwrap_or_default();
        assert_eq!(of("nan").iter().filter(|pixel| pixel[0].is_nan()).count(), 1);
        assert_eq!(of("firefly").iter().map(|pixel| pixel[0]).sum::<f32>(), 65504.0);
        let ramp = of("ramp");
        assert_eq!((ramp[12][1] / ramp[0][1]).log2(), 24.0);
        let edge = of("edge");
        assert_eq!(edge[12][0] / edge[0][0], 1e6);
    }

    #[test]
    fn sanitizing_repairs_from_neighbors() {
        let row = |pixels: &[[f32; 4]], sign| sanitized(pixels, Size::new(pixels.len() as u32, 1), sign);
        let one = [f32::NAN, -2.0, f32::INFINITY, 1e-30];
        assert_eq!(row(&[one], Signedness::Unsigned), [[0.0, 0.0, 65504.0, 1e-30]]);
        assert_eq!(row(&[[3.0; 4], one, [0.5; 4]], Signedness::Unsigned)[1], [3.0, 0.0, 3.0, 1e-30]);
        assert_eq!(row(&[one, one], Signedness::Unsigned)[0], [0.0, 0.0, 65504.0, 1e-30]);
        let between = [[f32::INFINITY; 4], [f32::NAN; 4], [3.0; 4]];
        assert_eq!(row(&between, Signedness::Unsigned)[1], [3.0; 4]);
        let signed = [-2.0, f32::NEG_INFINITY, 0.5, f32::MAX];
        assert_eq!(row(&[signed, [-3.0; 4]], Signedness::Signed)[0], [-2.0, -3.0, 0.5, 65504.0]);
    }

    #[test]
    fn scene_light_keeps_negative_components() {
        let of = |pixel: [f32; 4]| sanitized(&[pixel], Size::new(1, 1), Signedness::Extended)[0];
        assert_eq!(of([-0.5, 1.0, f32::NEG_INFINITY, -1.0]), [-0.5, 1.0, 0.0, 0.0]);
        assert_eq!(of([0.0, -7.0, -1000.0, 1.0]), [0.0, 0.0, 0.0, 1.0]);
        let [r, g, b, _] = of([1.0, -7.0, 0.0, 1.0]);
        assert!(r == 1.0 && b == 0.0 && (0.2126 + 0.7152 * g).abs() < 1e-6, "{g}");
    }
}
