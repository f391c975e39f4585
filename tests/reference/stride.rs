//! The pixels that a kind with a sampling stride reads.

use super::image::Image;

/// PCG output permutation over one LCG step (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020).
fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747796405).wrapping_add(2891336453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277803737);
    (word >> 22) ^ word
}

/// Pixels of a side of the squares that are read.
const SQUARE: usize = 4;

/// The size of the image of the pixels that are read.
pub(crate) fn sampled_size(size: [usize; 2], step: usize) -> [usize; 2] {
    if step == 1 { size } else { size.map(|side| side.div_ceil(SQUARE * step) * SQUARE) }
}

/// The pixel that is read for a place in the smaller image. Cells are `step` squares wide in an image whose sides are
/// multiples of theirs, and others are scaled to that.
pub(crate) fn sampled_pixel(place: [usize; 2], size: [usize; 2], step: usize) -> [usize; 2] {
    if step == 1 {
        return place;
    }
    let cell = place.map(|at| at / SQUARE);
    let random = hash((cell[0] / step) as u32 ^ hash((cell[1] / step) as u32)) as usize;
    let [shift_x, shift_y, slope] = [0, 8, 16].map(|bit| (random >> bit) % 256);
    let x = (cell[1] % step + shift_x) % step;
    let y = (cell[0] % step + slope * x + shift_y) % step;
    [0, 1].map(|axis| {
        let pixels = sampled_size(size, step)[axis] * step;
        let center = (SQUARE * (cell[axis] * step + [x, y][axis]) + place[axis] % SQUARE) as f64 + 0.5;
        (center * size[axis] as f64 / pixels as f64) as usize
    })
}

/// The image of the pixels that are read.
pub(crate) fn sampled(image: &Image, step: usize) -> Image {
    let size = [image.width, image.height];
    let [width, height] = sampled_size(size, step);
    Image::new(width, height, |x, y| {
        let [x, y] = sampled_pixel([x, y], size, step);
        image.texel(x as i64, y as i64)
    })
}

/// Lines along an axis are counted exactly, wherever they are.
#[test]
fn a_block_has_one_square_of_each_row_column_and_place_in_a_cell() {
    for step in 2..=8 {
        let mut layouts = std::collections::BTreeSet::new();
        for block in [[0, 0], [1, 0], [0, 1], [3, 2], [7, 9]] {
            let side = SQUARE * step;
            let (mut rows, mut columns) = (vec![0; side * step], vec![0; side * step]);
            let mut places = vec![0; side * side];
            let mut layout = Vec::new();
            for (u, v) in (0..side).flat_map(|v| (0..side).map(move |u| (u, v))) {
                let place = [block[0] * side + u, block[1] * side + v];
                let [x, y] = sampled_pixel(place, [100 * side; 2], step);
                assert_eq!([x / side, y / side], place.map(|at| at / SQUARE), "a pixel of the cell");
                columns[x - block[0] * side * step] += 1;
                rows[y - block[1] * side * step] += 1;
                places[x % side + y % side * side] += 1;
                layout.push([x % side, y % side]);
            }
            let is_even = |counts: &[usize], each: usize| counts.iter().all(|count| *count == each);
            assert!(is_even(&rows, SQUARE) && is_even(&columns, SQUARE) && is_even(&places, 1), "{step}");
            layouts.insert(layout);
        }
        assert!(layouts.len() > 1, "blocks differ");
    }
}

#[test]
fn every_part_of_an_odd_image_is_read_equally() {
    let [width, height, step] = [1281, 719, 4];
    let mut columns = vec![0.0; width];
    let [across, down] = sampled_size([width, height], step);
    for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x, y))) {
        columns[sampled_pixel([x, y], [width, height], step)[0]] += 1.0;
    }
    let mean = columns.iter().sum::<f64>() / width as f64;
    let eighth = |part: usize| columns[part * width / 8..(part + 1) * width / 8].iter().sum::<f64>();
    for part in 0..8 {
        assert!((eighth(part) / (mean * width as f64 / 8.0) - 1.0).abs() < 0.02, "part {part}");
    }
}
