//! An image in f64 with the two ways of reading that shaders have: one texel, one bilinear tap.

/// What lies beyond the border of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Beyond {
    Edge,
    /// Half of the edge, along each axis.
    Open,
}

/// Rows from the top, pixels from the left, four channels each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Image {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<[f64; 4]>,
    pub(crate) beyond: Beyond,
}

impl Image {
    /// An image whose pixel (x, y) is `pixel(x, y)`.
    pub(crate) fn new(width: usize, height: usize, pixel: impl Fn(usize, usize) -> [f64; 4]) -> Image {
        assert!(width > 0 && height > 0, "an image has at least one pixel");
        let pixels = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
        Image { width, height, pixels, beyond: Beyond::Edge }
    }

    /// The same image with half of the edge beyond its border.
    pub(crate) fn with_open_beyond(&self) -> Image {
        Image { beyond: Beyond::Open, ..self.clone() }
    }

    /// Calls `pixel` with the texture coordinate of every pixel's center.
    pub(crate) fn from_uv(width: usize, height: usize, pixel: impl Fn([f64; 2]) -> [f64; 4]) -> Image {
        Image::new(width, height, |x, y| pixel(center_uv(x, y, width, height)))
    }

    /// The pixel at (x, y); beyond the border the one at the edge, or a share of it.
    pub(crate) fn texel(&self, x: i64, y: i64) -> [f64; 4] {
        let axes = [(0..self.width as i64).contains(&x), (0..self.height as i64).contains(&y)];
        let outside = axes.iter().filter(|is_inside| !**is_inside).count();
        let share = if self.beyond == Beyond::Open { 0.5_f64.powi(outside as i32) } else { 1.0 };
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        self.pixels[y * self.width + x].map(|number| share * number)
    }

    /// A bilinear sample at `uv` in [0, 1]: WebGPU's linear filter without
    /// the rounding of its weights.
    pub(crate) fn tap(&self, uv: [f64; 2]) -> [f64; 4] {
        let x = uv[0] * self.width as f64 - 0.5;
        let y = uv[1] * self.height as f64 - 0.5;
        let (left, top) = (x.floor() as i64, y.floor() as i64);
        let row = |y| mix4(self.texel(left, y), self.texel(left + 1, y), x - x.floor());
        mix4(row(top), row(top + 1), y - y.floor())
    }

    /// A bilinear sample at `uv` moved by an offset in texels of this image.
    pub(crate) fn tap_offset(&self, uv: [f64; 2], [x, y]: [f64; 2]) -> [f64; 4] {
        self.tap([uv[0] + x / self.width as f64, uv[1] + y / self.height as f64])
    }

    /// The same image with `f` applied to each pixel.
    pub(crate) fn map(&self, f: impl Fn([f64; 4]) -> [f64; 4]) -> Image {
        Image { pixels: self.pixels.iter().map(|&pixel| f(pixel)).collect(), ..*self }
    }

    /// The same image with `f` applied to the color of each pixel, alpha untouched.
    pub(crate) fn map_rgb(&self, f: impl Fn([f64; 3]) -> [f64; 3]) -> Image {
        self.map(|[r, g, b, a]| {
            let [r, g, b] = f([r, g, b]);
            [r, g, b, a]
        })
    }
}

/// The texture coordinate of the center of pixel (x, y).
pub(crate) fn center_uv(x: usize, y: usize, width: usize, height: usize) -> [f64; 2] {
    [(x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64]
}

/// The color of a pixel without its alpha.
pub(crate) fn rgb([r, g, b, _]: [f64; 4]) -> [f64; 3] {
    [r, g, b]
}

pub(crate) fn gray(value: f64) -> [f64; 4] {
    [value, value, value, 1.0]
}

/// `a` at t = 0, `b` at t = 1, in all four channels.
pub(crate) fn mix4(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| a[i] * (1.0 - t) + b[i] * t)
}

/// `total + pixel · weight`, the step of every filter.
pub(crate) fn add_weighted(total: [f64; 4], pixel: [f64; 4], weight: f64) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| total[i] + pixel[i] * weight)
}

#[test]
fn a_tap_hits_centers_and_halves_and_clamps() {
    let image = Image::new(3, 2, |x, y| gray((x + 10 * y) as f64));
    assert_eq!(image.tap([0.5, 0.25])[0], 1.0);
    assert_eq!(image.tap([1.0 / 3.0, 0.5])[0], 5.5);
    assert_eq!(image.tap([4.0, 4.0])[0], 12.0);
    assert_eq!(image.tap([-1.0, 0.75])[0], 10.0);
}

#[test]
fn a_map_of_colors_leaves_alpha() {
    let image = Image::new(2, 1, |x, _| [1.0, 2.0, 3.0, x as f64]);
    let doubled = image.map_rgb(|rgb| rgb.map(|x| 2.0 * x));
    assert_eq!(doubled.pixels, [[2.0, 4.0, 6.0, 0.0], [2.0, 4.0, 6.0, 1.0]]);
}
