//! The pixels that a kind with a sampling stride reads.

use super::image::Image;

/// PCG output permutation over one LCG step (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020).
fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747796405).wrapping_add(2891336453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277803737);
    (word >> 22) ^ word
}

/// The pixel of a cell. Cells are `step` pixels wide in an image whose sides are multiples of the step, and others are
/// scaled to that.
pub(crate) fn sampled_pixel(cell: [usize; 2], size: [usize; 2], step: usize) -> [usize; 2] {
    let random = hash((cell[0] / step) as u32 ^ hash((cell[1] / step) as u32)) as usize;
    let [shift_x, shift_y, slope] = [0, 8, 16].map(|bit| (random >> bit) % 256);
    let x = (cell[1] % step + shift_x) % step;
    let y = (cell[0] % step + slope * x + shift_y) % step;
    [0, 1].map(|axis| {
        let pixels = size[axis].div_ceil(step) * step;
        let center = (cell[axis] * step + [x, y][axis]) as f64 + 0.5;
        (center * size[axis] as f64 / pixels as f64) as usize
    })
}

/// The image of the pixels that are read.
pub(crate) fn sampled(image: &Image, step: usize) -> Image {
    let size = [image.width, image.height];
    Image::new(image.width.div_ceil(step), image.height.div_ceil(step), |x, y| {
        let [x, y] = sampled_pixel([x, y], size, step);
        image.texel(x as i64, y as i64)
    })
}

/// Lines along an axis are counted exactly, wherever they are.
#[test]
fn a_block_has_one_pixel_of_each_row_column_and_place_in_a_cell() {
    for step in 1..=8 {
        let mut layouts = std::collections::BTreeSet::new();
        for block in [[0, 0], [1, 0], [0, 1], [3, 2], [7, 9]] {
            let (mut rows, mut columns) = (vec![0; step * step], vec![0; step * step]);
            let mut places = vec![0; step * step];
            let mut layout = Vec::new();
            for (u, v) in (0..step).flat_map(|v| (0..step).map(move |u| (u, v))) {
                let cell = [block[0] * step + u, block[1] * step + v];
                let [x, y] = sampled_pixel(cell, [100 * step; 2], step);
                assert_eq!([x / step, y / step], cell, "a pixel of the cell");
                columns[x - block[0] * step * step] += 1;
                rows[y - block[1] * step * step] += 1;
                places[x % step + y % step * step] += 1;
                layout.push([x % step, y % step]);
            }
            assert!([&rows, &columns, &places].iter().all(|counts| counts.iter().all(|count| *count == 1)), "{step}");
            layouts.insert(layout);
        }
        assert!(step == 1 || layouts.len() > 1, "blocks differ");
    }
}

#[test]
fn every_part_of_an_odd_image_is_read_equally() {
    let [width, height, step] = [1281, 719, 4];
    let mut columns = vec![0.0; width];
    for (x, y) in (0..height / step).flat_map(|y| (0..width.div_ceil(step)).map(move |x| (x, y))) {
        columns[sampled_pixel([x, y], [width, height], step)[0]] += 1.0;
    }
    let mean = columns.iter().sum::<f64>() / width as f64;
    let eighth = |part: usize| columns[part * width / 8..(part + 1) * width / 8].iter().sum::<f64>();
    for part in 0..8 {
        assert!((eighth(part) / (mean * width as f64 / 8.0) - 1.0).abs() < 0.02, "part {part}");
    }
}
