//! Hot air: places that waver by value noise.

use super::image::{Image, center_uv};

/// PCG's output permutation over one step of its generator.
fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Value noise from 0 to 1, one cell for each unit.
pub(crate) fn noise([x, y]: [f64; 2]) -> f64 {
    let cell = |x: f64, y: f64| f64::from(hash(x as i32 as u32 ^ hash(y as i32 as u32)) >> 8) / 16_777_216.0;
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (left, top) = (x.floor(), y.floor());
    let [u, v] = [smooth(x - left), smooth(y - top)];
    let row = |y: f64| cell(left, y) * (1.0 - u) + cell(left + 1.0, y) * u;
    row(top) * (1.0 - v) + row(top + 1.0) * v
}

/// The parameters of the air.
#[derive(Clone, Copy)]
pub(crate) struct Haze {
    pub(crate) strength: f64,
    pub(crate) scale: f64,
    pub(crate) speed: f64,
    pub(crate) shape: f64,
    pub(crate) time: f64,
}

impl Haze {
    /// The displacement in heights where the mask is 1, for a place in heights.
    pub(crate) fn moved(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [width, height] = [self.scale, self.scale * self.shape];
        let risen = (self.time * self.speed / height).rem_euclid(4096.0);
        let at = [x / width, y / height + risen];
        let waver = |[x, y]: [f64; 2]| [2.0 * noise([x, y]) - 1.0, 2.0 * noise([x + 37.5, y + 11.25]) - 1.0];
        let (wide, fine) = (waver(at), waver([2.0 * at[0] + 5.5, 2.0 * at[1] + 3.25]));
        [0, 1].map(|c| self.strength * (2.0 * wide[c] + fine[c]) / 3.0)
    }

    /// The image behind the air.
    pub(crate) fn apply(&self, image: &Image, mask: Option<&Image>) -> Image {
        let aspect = image.width as f64 / image.height as f64;
        Image::new(image.width, image.height, |x, y| {
            let [u, v] = center_uv(x, y, image.width, image.height);
            let amount = mask.map_or(1.0, |mask| mask.tap([u, v])[0].clamp(0.0, 1.0));
            let [dx, dy] = self.moved([u * aspect, v]);
            image.tap([u + amount * dx / aspect, v + amount * dy])
        })
    }
}

#[test]
fn places_waver_around_where_they_are_and_no_farther_than_the_strength() {
    let haze = Haze { strength: 0.02, scale: 0.05, speed: 0.3, shape: 1.5, time: 2.0 };
    let places = (0..4000).map(|i| [f64::from(i % 80) * 0.03, f64::from(i / 80) * 0.05]);
    let moved: Vec<[f64; 2]> = places.map(|place| haze.moved(place)).collect();
    for c in 0..2 {
        let mean = moved.iter().map(|m| m[c]).sum::<f64>() / 4000.0;
        let far = moved.iter().map(|m| m[c].abs()).fold(0.0, f64::max);
        assert!(mean.abs() < 0.001 && (0.008..=0.02).contains(&far), "{mean} and {far}");
    }
    // Swirls rise: what is seen at a place now was a little lower before.
    let later = Haze { time: 2.5, ..haze };
    let (now, then) = (later.moved([0.4, 0.3]), haze.moved([0.4, 0.45]));
    assert!((0..2).all(|c| (now[c] - then[c]).abs() < 1e-12), "{now:?} and {then:?}");
}
