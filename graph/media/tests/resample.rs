//! Pictures scaled into frames of other sizes.

use super::picture;
use afterimage_media::*;

#[test]
fn the_same_size_is_the_same_picture() {
    let picture = picture(13, 7);
    assert_eq!(picture.fitted(13, 7).pixels, picture.pixels);
    assert_eq!(picture.scaled(13, 7).pixels, picture.pixels);
}

#[test]
fn light_is_neither_lost_nor_made() {
    // A lamp of one pixel: each of four halvings spreads its light, whose sum is a quarter of that before.
    let mut values = vec![0.0; 32 * 32 * 4];
    values[(17 * 32 + 14) * 4] = 4096.0;
    let mut picture = Picture::new(32, 32, Pixels::Float(values));
    for size in [16, 8] {
        let before: f64 = picture.pixels.to_f32().iter().map(|value| f64::from(*value)).sum();
        picture = picture.fitted(size, size);
        let after: f64 = picture.pixels.to_f32().iter().map(|value| f64::from(*value)).sum();
        assert!((after * 4.0 - before).abs() < 1e-3 * before, "{size}: {before} {after}");
    }
}

#[test]
fn a_ramp_stays_a_ramp_and_the_frame_around_it_is_empty() {
    let values = (0..8 * 4).flat_map(|i| [(i % 8) as f32 + 0.5, 1.0, 1.0, 1.0]).collect();
    let ramp = Picture::new(8, 4, Pixels::Float(values));
    let fitted = ramp.fitted(16, 12);
    assert_eq!((fitted.width, fitted.height), (16, 12));
    assert_eq!(fitted.pixel(3, 1), [0.0; 4], "above the picture of 16x8");
    assert_eq!(fitted.pixel(3, 10), [0.0; 4]);
    for x in 1..15 {
        let found = fitted.pixel(x, 6)[0];
        assert!((found - (x as f32 + 0.5) / 2.0).abs() < 1e-5, "{x}: {found}");
    }
    assert_eq!(fitted.pixel(0, 2)[1..], [1.0; 3], "white has no edge");
}
