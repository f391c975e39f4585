//! Filters that halve and double images of any size (formula book, 12.3 to 12.5).
//!
//! The thirteen taps are those of Jimenez (SIGGRAPH 2014), the weighting that of Karis (2013). Halvings follow the
//! definition of a filter as boxes of whole texels of the result, integrated over the texels of the source, which has
//! a meaning at every size. At exactly 2:1 such a box is a bilinear tap at the corner of four texels.

use super::image::{Image, add_weighted, rgb};
use super::math::{Rgb, largest};

/// A bilinear tap: its offset in texels of the source, and its weight.
type Tap = ([f64; 2], f64);

/// The filters of a downsample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Down {
    Box,
    FourTap,
    NineTap,
    ThirteenTap,
    Binomial,
}

/// The weighting of single bright pixels in the first downsample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Firefly {
    Off,
    /// The thirteen taps in five groups of four. Instead of any other filter, four taps, each weighted as a fifth of
    /// itself and four fifths of the tap in the middle.
    Groups,
    Taps,
}

/// The filters of an upsample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Up {
    Bilinear,
    Tent,
}

/// Half of a size, never below one pixel.
pub(crate) fn half_size(width: usize, height: usize) -> [usize; 2] {
    [(width / 2).max(1), (height / 2).max(1)]
}

/// The taps of a filter; their weights sum to 1.
fn taps(filter: Down) -> Vec<Tap> {
    match filter {
        Down::Box => vec![([0.0, 0.0], 1.0)],
        Down::FourTap => corners([0.0, 0.0], 1.0, 1.0),
        Down::NineTap => tent(1.0),
        Down::ThirteenTap => groups(filter, Firefly::Groups).concat(),
        Down::Binomial => {
            let side = [(-2.0, 1.0), (-1.0, 4.0), (0.0, 6.0), (1.0, 4.0), (2.0, 1.0)];
            let row = |(y, b): (f64, f64)| side.map(|(x, a)| ([x, y], a * b / 256.0));
            side.into_iter().flat_map(row).collect()
        }
    }
}

/// Four taps in a square around `center`, at distance `reach` in x and y, sharing `weight`.
fn corners([x, y]: [f64; 2], reach: f64, weight: f64) -> Vec<Tap> {
    [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
        .map(|[i, j]| ([x + i * reach, y + j * reach], weight / 4.0))
        .to_vec()
}

/// The tent of nine taps, [1 2 1]² / 16, spaced by `step` texels.
fn tent(step: f64) -> Vec<Tap> {
    let side = [(-1.0, 0.25), (0.0, 0.5), (1.0, 0.25)];
    let row = |(y, b): (f64, f64)| side.map(|(x, a)| ([x * step, y * step], a * b));
    side.into_iter().flat_map(row).collect()
}

/// The groups whose averages are weighted against each other.
fn groups(filter: Down, firefly: Firefly) -> Vec<Vec<Tap>> {
    if filter == Down::ThirteenTap && firefly == Firefly::Groups {
        let mut groups = vec![corners([0.0, 0.0], 1.0, 0.5)];
        groups.extend(corners([0.0, 0.0], 1.0, 0.5).into_iter().map(|(c, w)| corners(c, 1.0, w)));
        return groups;
    }
    taps(filter).into_iter().map(|tap| vec![tap]).collect()
}

/// A smaller image of `size` pixels.
pub(crate) fn downsample(image: &Image, size: [usize; 2], filter: Down) -> Image {
    let taps = taps(filter);
    Image::from_uv(size[0], size[1], |uv| match filter {
        Down::NineTap => tent_mean(image, size, uv),
        _ => gather_boxes(image, size, uv, &taps),
    })
}

/// A smaller image of `size` pixels whose groups of taps weigh `1 / (1 + brightness)`, with
/// brightness the largest channel, and the weights made to sum to 1 again.
pub(crate) fn downsample_karis(image: &Image, size: [usize; 2], filter: Down, firefly: Firefly) -> Image {
    let filter = match (filter, firefly) {
        (Down::Binomial, Firefly::Taps | Firefly::Groups) => Down::ThirteenTap,
        _ => filter,
    };
    match firefly {
        Firefly::Off => return downsample(image, size, filter),
        Firefly::Taps if filter == Down::Box => return downsample_texels(image, size),
        Firefly::Groups if filter != Down::ThirteenTap => return downsample_corners(image, size),
        Firefly::Groups | Firefly::Taps => {}
    }
    let groups = groups(filter, firefly);
    Image::from_uv(size[0], size[1], |uv| {
        let mut sum = [0.0; 4];
        let mut total = 0.0;
        for group in &groups {
            let share: f64 = group.iter().map(|(_, weight)| weight).sum();
            let mean = gather_boxes(image, size, uv, group).map(|x| x / share);
            let weight = share * karis_weight(rgb(mean), largest);
            sum = add_weighted(sum, mean, weight);
            total += weight;
        }
        sum.map(|x| x / total)
    })
}

/// The weighting of the thirteen taps' groups, with four taps and the one between them.
fn downsample_corners(image: &Image, size: [usize; 2]) -> Image {
    Image::from_uv(size[0], size[1], |uv| {
        let middle = box_mean(image, size, uv, [0.0, 0.0]);
        let mut sum = [0.0; 4];
        let mut total = 0.0;
        for (offset, share) in taps(Down::FourTap) {
            let corner = box_mean(image, size, uv, offset);
            let square = [0, 1, 2, 3].map(|i| 0.2 * corner[i] + 0.8 * middle[i]);
            let weight = share * karis_weight(rgb(square), largest);
            sum = add_weighted(sum, corner, weight);
            total += weight;
        }
        sum.map(|x| x / total)
    })
}

/// A box whose texels weigh `1 / (1 + brightness)`.
fn downsample_texels(image: &Image, size: [usize; 2]) -> Image {
    Image::from_uv(size[0], size[1], |uv| {
        let mut sum = [0.0; 4];
        let mut total = 0.0;
        for (texel, share) in box_texels(image, size, uv, [0.0, 0.0]) {
            let weight = share * karis_weight(rgb(texel), largest);
            sum = add_weighted(sum, texel, weight);
            total += weight;
        }
        sum.map(|x| x / total)
    })
}

/// The texels of the source under a box of one texel of the result around `uv`, moved by `offset` in halves of a texel
/// of the result, and the share of each in the box.
fn box_texels(image: &Image, size: [usize; 2], uv: [f64; 2], offset: [f64; 2]) -> Vec<([f64; 4], f64)> {
    let source = [image.width as f64, image.height as f64];
    let [columns, rows] = [0, 1].map(|axis| {
        let scale = source[axis] / size[axis] as f64;
        let start = uv[axis] * source[axis] + (0.5 * offset[axis] - 0.5) * scale;
        let end = start + scale;
        let share = |texel: i64| (end.min(texel as f64 + 1.0) - start.max(texel as f64)).max(0.0) / scale;
        (start.floor() as i64..end.ceil() as i64).map(|texel| (texel, share(texel))).collect::<Vec<_>>()
    });
    let mut texels = Vec::new();
    for &(y, down) in &rows {
        for &(x, across) in &columns {
            texels.push((image.texel(x, y), across * down));
        }
    }
    texels
}

/// The mean over a tent that is a texel of the result wide to each side of `uv`: a box of one texel convolved with
/// itself.
fn tent_mean(image: &Image, size: [usize; 2], uv: [f64; 2]) -> [f64; 4] {
    let source = [image.width as f64, image.height as f64];
    let [columns, rows] = [0, 1].map(|axis| {
        let scale = source[axis] / size[axis] as f64;
        let center = uv[axis] * source[axis];
        let share = |texel: i64| {
            // A tent is straight between these: its mean over a part is its height in the middle of the part.
            let ends = [-1.0, 0.0, 1.0].map(|kink| center + kink * scale);
            let parts = ends.windows(2).map(|part| {
                let (start, end) = (part[0].max(texel as f64), part[1].min(texel as f64 + 1.0));
                let height = 1.0 - ((start + end) / 2.0 - center).abs() / scale;
                (end - start).max(0.0) * height / scale
            });
            parts.sum::<f64>()
        };
        let reached = (center - scale).floor() as i64..(center + scale).ceil() as i64;
        reached.map(|texel| (texel, share(texel))).collect::<Vec<_>>()
    });
    let mut sum = [0.0; 4];
    for &(y, down) in &rows {
        for &(x, across) in &columns {
            sum = add_weighted(sum, image.texel(x, y), across * down);
        }
    }
    sum
}

fn box_mean(image: &Image, size: [usize; 2], uv: [f64; 2], offset: [f64; 2]) -> [f64; 4] {
    let texels = box_texels(image, size, uv, offset);
    texels.into_iter().fold([0.0; 4], |sum, (texel, share)| add_weighted(sum, texel, share))
}

fn gather_boxes(image: &Image, size: [usize; 2], uv: [f64; 2], taps: &[Tap]) -> [f64; 4] {
    taps.iter().fold([0.0; 4], |sum, &(offset, weight)| add_weighted(sum, box_mean(image, size, uv, offset), weight))
}

/// An image of `size` pixels; the tent's taps are `radius` texels of the source apart.
pub(crate) fn upsample(image: &Image, size: [usize; 2], filter: Up, radius: f64) -> Image {
    let taps = match filter {
        Up::Bilinear => vec![([0.0, 0.0], 1.0)],
        Up::Tent => tent(radius),
    };
    Image::from_uv(size[0], size[1], |uv| gather(image, uv, &taps))
}

fn gather(image: &Image, uv: [f64; 2], taps: &[Tap]) -> [f64; 4] {
    taps.iter().fold([0.0; 4], |sum, &(offset, weight)| add_weighted(sum, image.tap_offset(uv, offset), weight))
}

/// `1 / (1 + brightness)`.
pub(crate) fn karis_weight(rgb: Rgb, brightness: fn(Rgb) -> f64) -> f64 {
    1.0 / (1.0 + brightness(rgb))
}

/// The mean of samples weighted by [`karis_weight`].
pub(crate) fn karis_average(samples: &[Rgb], brightness: fn(Rgb) -> f64) -> Rgb {
    let mut sum = [0.0; 3];
    let mut total = 0.0;
    for &sample in samples {
        let weight = karis_weight(sample, brightness);
        sum = [0, 1, 2].map(|i| sum[i] + weight * sample[i]);
        total += weight;
    }
    sum.map(|x| x / total)
}

/// Each pixel of the result is the mean of the area it covers in the source, edges in part.
pub(crate) fn area_average(image: &Image, size: [usize; 2]) -> Image {
    let [width, height] = size;
    Image::new(width, height, |x, y| {
        let columns = cover(x, width, image.width);
        let rows = cover(y, height, image.height);
        let mut sum = [0.0; 4];
        for &(row, down) in &rows {
            for &(column, across) in &columns {
                sum = add_weighted(sum, image.texel(column, row), across * down);
            }
        }
        sum
    })
}

/// The source texels that destination texel `i` of `n` covers, and the share of each.
fn cover(i: usize, n: usize, source: usize) -> Vec<(i64, f64)> {
    let scale = source as f64 / n as f64;
    let (start, end) = (i as f64 * scale, (i + 1) as f64 * scale);
    (start.floor() as usize..end.ceil() as usize)
        .map(|texel| {
            let share = end.min(texel as f64 + 1.0) - start.max(texel as f64);
            (texel as i64, share / scale)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::image::gray;

    const FILTERS: [Down; 5] = [Down::Box, Down::FourTap, Down::NineTap, Down::ThirteenTap, Down::Binomial];

    #[test]
    fn a_constant_survives_every_filter_at_odd_sizes() {
        let image = Image::new(7, 3, |_, _| [5.0, 0.5, 2.0, 1.0]);
        let same = |result: Image| {
            result.pixels.iter().all(|pixel| (0..4).all(|i| (pixel[i] - image.pixels[0][i]).abs() < 1e-13))
        };
        for filter in FILTERS {
            for firefly in [Firefly::Off, Firefly::Groups, Firefly::Taps] {
                assert!(same(downsample_karis(&image, [3, 1], filter, firefly)), "{filter:?}");
            }
        }
        assert!(same(upsample(&image, [15, 8], Up::Tent, 1.5)));
        assert!(same(upsample(&image, [15, 8], Up::Bilinear, 1.0)));
        assert!(same(area_average(&image, [3, 2])));
    }

    /// The sum of a halving over a light of one texel, times the texels that one of the result stands for: 1 anywhere
    /// but at the border, at all four parities.
    #[test]
    fn a_light_of_one_texel_keeps_its_energy_at_every_size() {
        for [width, height] in [[16, 12], [17, 12], [16, 13], [17, 13], [11, 19]] {
            let half = half_size(width, height);
            let area = (width * height) as f64 / (half[0] * half[1]) as f64;
            for filter in FILTERS {
                for at in (0..16).map(|step| (4 + step % (width - 8), 4 + step / 3 % (height - 8))) {
                    let light = Image::new(width, height, |x, y| gray(if (x, y) == at { 1.0 } else { 0.0 }));
                    let small = downsample(&light, half, filter);
                    let energy = area * small.pixels.iter().map(|pixel| pixel[0]).sum::<f64>();
                    assert!((energy - 1.0).abs() < 1e-12, "{filter:?} {width}x{height} {at:?}: {energy}");
                }
            }
        }
    }

    #[test]
    fn at_exactly_half_the_size_a_filter_is_the_taps_of_its_source() {
        let image = Image::new(12, 8, |x, y| gray((x * x + 7 * y) as f64));
        for filter in FILTERS {
            let small = downsample(&image, [6, 4], filter);
            let tapped = Image::from_uv(6, 4, |uv| gather(&image, uv, &taps(filter)));
            let is_close = small.pixels.iter().zip(&tapped.pixels).all(|(a, b)| (a[0] - b[0]).abs() < 1e-12);
            assert!(is_close, "{filter:?}");
        }
    }

    /// Formula book, corrections: a box from 2m + 1 texels to m.
    #[test]
    fn a_box_of_an_odd_side_has_the_published_weights() {
        let (m, n) = (4, 9);
        for light in 0..n {
            let image = Image::new(n, 1, |x, _| gray(if x == light { 1.0 } else { 0.0 }));
            let small = downsample(&image, [m, 1], Down::Box);
            for i in 0..m {
                let weights = [m - i, m, i + 1].map(|weight| weight as f64 / n as f64);
                let expected = light.checked_sub(2 * i).and_then(|k| weights.get(k)).copied().unwrap_or(0.0);
                assert!((small.pixels[i][0] - expected).abs() < 1e-12, "{light} {i}");
            }
        }
    }

    #[test]
    fn karis_groups_keep_more_of_a_firefly_than_single_taps() {
        let spike = Image::new(16, 16, |x, y| gray(if (x, y) == (7, 7) { 500.0 } else { 0.1 }));
        let energy = |firefly, filter| {
            let small = downsample_karis(&spike, [8, 8], filter, firefly);
            small.pixels.iter().map(|pixel| pixel[0] - 0.1).sum::<f64>()
        };
        let off = energy(Firefly::Off, Down::ThirteenTap);
        let groups = energy(Firefly::Groups, Down::ThirteenTap);
        let corners = energy(Firefly::Groups, Down::FourTap);
        let taps = energy(Firefly::Taps, Down::FourTap);
        assert!((groups / off - 0.32).abs() < 0.01, "{}", groups / off);
        assert!((corners / off - 0.25).abs() < 0.02, "{}", corners / off);
        assert!((taps / off - 0.012).abs() < 0.003, "{}", taps / off);
    }

    /// The least and the most energy, in percent, that the thirteen taps keep of a square light between pixels.
    fn kept(side: f64, firefly: Firefly) -> [f64; 2] {
        let energies = (0..8).map(|phase| {
            let start = 20.0 + 0.25 * f64::from(phase);
            let share = |pixel: usize| ((start + side).min(pixel as f64 + 1.0) - start.max(pixel as f64)).max(0.0);
            let light = Image::new(64, 64, |x, y| gray(200.0 * share(x) * share(y)));
            let small = downsample_karis(&light, [32, 32], Down::ThirteenTap, firefly);
            small.pixels.iter().map(|pixel| pixel[0]).sum::<f64>() * 4.0 / (2.0 * side * side)
        });
        energies.fold([f64::INFINITY, 0.0], |[least, most], energy| [least.min(energy), most.max(energy)])
    }

    /// The figures of the manual of `Downsample`.
    #[test]
    fn weights_against_fireflies_take_energy_from_lights_that_move() {
        let table = [
            (Firefly::Off, [[100.0, 100.0], [100.0, 100.0], [100.0, 100.0]]),
            (Firefly::Groups, [[39.0, 69.0], [33.0, 64.0], [53.0, 73.0]]),
            (Firefly::Taps, [[2.0, 8.0], [2.0, 4.0], [2.0, 17.0]]),
        ];
        for (firefly, rows) in table {
            for (side, wanted) in [1.0, 2.0, 4.0].into_iter().zip(rows) {
                let found = kept(side, firefly);
                let is_near = (0..2).all(|i| (found[i] - wanted[i]).abs() < 0.6);
                assert!(is_near, "{firefly:?} {side}: {found:?}, the manual has {wanted:?}");
            }
        }
    }

    #[test]
    fn an_area_average_keeps_the_mean_at_any_size() {
        let image = Image::new(7, 5, |x, y| gray((x * x + 3 * y) as f64));
        let mean = |image: &Image| image.pixels.iter().map(|pixel| pixel[0]).sum::<f64>() / image.pixels.len() as f64;
        assert!((mean(&area_average(&image, [3, 2])) - mean(&image)).abs() < 1e-12);
    }

    #[test]
    fn a_wider_tent_reaches_farther() {
        let dot = Image::new(9, 9, |x, y| gray(if (x, y) == (4, 4) { 1.0 } else { 0.0 }));
        let reach = |radius| {
            let wide = upsample(&dot, [18, 18], Up::Tent, radius);
            wide.pixels.iter().filter(|pixel| pixel[0] > 0.0).count()
        };
        assert!(reach(2.0) > reach(1.0), "{} {}", reach(2.0), reach(1.0));
    }
}
