//! Warps: lens distortion and lateral chromatic aberration. A warp is a function from a place of the result to one of
//! the source; places are relative to the center, and 1 is half of the diagonal.

use super::image::Image;

/// A function from a place of the result to one of the source.
pub(crate) type Warp<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];

/// Coefficients of Brown and Conrady, as OpenCV names them; those of the division model are k1 and k2.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lens {
    pub(crate) k: [f64; 3],
    pub(crate) p: [f64; 2],
}

impl Lens {
    /// The place in the image of the lens of a straight place.
    pub(crate) fn brown(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([k1, k2, k3], [p1, p2]) = (self.k, self.p);
        let s = x * x + y * y;
        let factor = 1.0 + k1 * s + k2 * s.powi(2) + k3 * s.powi(3);
        [x * factor + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x), y * factor + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y]
    }

    /// The straight place of a place in the image of the lens.
    pub(crate) fn division(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let s = x * x + y * y;
        let below = 1.0 + self.k[0] * s + self.k[1] * s * s;
        [x / below, y / below]
    }
}

/// The place that `warp` maps to `wanted`: Newton's method with differences, from the place itself.
pub(crate) fn inverse(warp: impl Fn([f64; 2]) -> [f64; 2], wanted: [f64; 2]) -> [f64; 2] {
    let mut place = wanted;
    for _ in 0..60 {
        let [x, y] = place;
        let h = 1e-6;
        let [at, right, down] = [warp(place), warp([x + h, y]), warp([x, y + h])];
        let [a, c] = [(right[0] - at[0]) / h, (right[1] - at[1]) / h];
        let [b, d] = [(down[0] - at[0]) / h, (down[1] - at[1]) / h];
        let miss = [wanted[0] - at[0], wanted[1] - at[1]];
        let det = a * d - b * c;
        place = [x + (d * miss[0] - b * miss[1]) / det, y + (a * miss[1] - c * miss[0]) / det];
    }
    place
}

/// The uv of a place.
fn uv(image: &Image, [x, y]: [f64; 2]) -> [f64; 2] {
    let half = 0.5 * (image.width as f64).hypot(image.height as f64);
    [0.5 + x * half / image.width as f64, 0.5 + y * half / image.height as f64]
}

/// The image whose channels are read at the places that the three warps give, with the mean of their alphas.
pub(crate) fn warped(image: &Image, warps: [Warp<'_>; 3]) -> Image {
    let half = 0.5 * (image.width as f64).hypot(image.height as f64);
    Image::new(image.width, image.height, |x, y| {
        let place = [x as f64 + 0.5 - 0.5 * image.width as f64, y as f64 + 0.5 - 0.5 * image.height as f64];
        let [red, green, blue] = warps.map(|warp| image.tap(uv(image, warp(place.map(|t| t / half)))));
        [red[0], green[1], blue[2], (red[3] + green[3] + blue[3]) / 3.0]
    })
}

/// The place of a channel with this magnification in the corners, less 1.
pub(crate) fn aberration(magnification: f64, growth: f64) -> impl Fn([f64; 2]) -> [f64; 2] {
    move |[x, y]| {
        let scale = 1.0 + magnification * (1.0 - growth + growth * (x * x + y * y));
        [x / scale, y / scale]
    }
}

#[test]
fn an_inverse_undoes_a_lens() {
    let lens = Lens { k: [-0.2, 0.05, -0.01], p: [0.004, -0.006] };
    for place in [[0.0, 0.0], [0.3, -0.2], [-0.8, 0.45], [0.05, 0.5]] {
        let back = inverse(|place| lens.brown(place), lens.brown(place));
        assert!((0..2).all(|i| (back[i] - place[i]).abs() < 1e-12), "{place:?}: {back:?}");
    }
    // By hand, at r^2 = 0.13.
    let [x, y] = lens.brown([0.3, -0.2]);
    let s: f64 = 0.13;
    let factor = 1.0 - 0.2 * s + 0.05 * s * s - 0.01 * s * s * s;
    assert!((x - (0.3 * factor + 2.0 * 0.004 * -0.06 - 0.006 * (s + 0.18))).abs() < 1e-15);
    assert!((y - (-0.2 * factor + 0.004 * (s + 0.08) + 2.0 * -0.006 * -0.06)).abs() < 1e-15);
}
