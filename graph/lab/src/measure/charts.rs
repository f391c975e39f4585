//! Synthetic pictures whose errors are larger than those of photographs: stills stress meters and downsampling, and
//! short sequences stress what is kept from frame to frame.

use afterimage_gpu::Texels;

/// A synthetic picture, or a sequence of them.
struct Chart {
    name: &'static str,
    frames: u32,
    /// The color at a position in a frame, scene-linear; 0.18 is middle gray.
    color: fn(u32, u32, u32) -> [f32; 3],
}

/// Width and height of a still: neither is a multiple of the halvings. Glow has one level less than in a frame of 1080
/// lines.
const WIDTH: u32 = 963;
const HEIGHT: u32 = 541;
/// Those of a sequence: small, because each of its frames is measured.
const MOVING_WIDTH: u32 = 483;
const MOVING_HEIGHT: u32 = 271;
/// The brightest half float.
const SUN: f32 = 65504.0;
/// Luminance of a landscape under stars, beside 0.18 for a gray card in a room.
const NIGHT: f32 = 1e-3;

const CHARTS: [Chart; 15] = [
    still("lines", |x, y, _| gray(if (if y < HEIGHT / 2 { x } else { y }) % 5 == 0 { 8.0 } else { 0.05 })),
    still("dots", |x, y, _| gray(if x % 17 == 0 && y % 17 == 0 { 200.0 } else { 0.05 })),
    still("dots shifted", |x, y, _| gray(if x % 17 == 1 && y % 17 == 1 { 200.0 } else { 0.05 })),
    still("one sun", |x, y, _| gray(if (x, y) == (397, 253) { SUN } else { 0.18 })),
    still("suns in the night", |x, y, _| gray(if x % 64 == 9 && y % 64 == 9 { SUN } else { NIGHT })),
    still("lamps", lamps),
    still("steps", steps),
    still("colors", colors),
    still("white", |_, _, _| gray(1.0)),
    still("black", |_, _, _| gray(0.0)),
    still("night", |x, y, _| gray(NIGHT * (1.0 + (x * y) as f32 / (WIDTH * HEIGHT) as f32))),
    // Each lamp is switched in another frame, so that what is kept for up to six frames misses it.
    Chart { name: "lamps switched", frames: 9, color: lamps_switched },
    Chart { name: "lamps in motion", frames: 8, color: lamps_in_motion },
    Chart { name: "pan", frames: 8, color: pan },
    Chart { name: "cuts", frames: 12, color: cuts },
];

/// Those that a search of tiers sees; the others confirm what it finds.
const SEARCHED: [&str; 6] = ["lines", "suns in the night", "lamps", "colors", "lamps switched", "pan"];

const fn still(name: &'static str, color: fn(u32, u32, u32) -> [f32; 3]) -> Chart {
    Chart { name, frames: 1, color }
}

const fn gray(value: f32) -> [f32; 3] {
    [value; 3]
}

/// A street at night: lamps of one to eight pixels, from dim to blinding. Those of more than a pixel are not removed as
/// fireflies, so errors in downsampled images show when they are enlarged.
fn lamps(x: u32, y: u32, _: u32) -> [f32; 3] {
    const CELL: u32 = 120;
    let (column, row) = (x / CELL, y / CELL);
    // Each lamp lies elsewhere in its cell, so that its edges meet those of halved images in all ways.
    let (left, top) = (50 + (column * 5 + row * 3) % 13, 50 + (column * 7 + row * 11) % 13);
    let side = 1 + column;
    let is_lamp = (left..left + side).contains(&(x % CELL)) && (top..top + side).contains(&(y % CELL));
    if is_lamp { gray(2.0_f32.powi(2 * row as i32 + 1)) } else { gray(0.01) }
}

/// Twenty-two grays, a stop from one to the next, with hard edges.
fn steps(x: u32, _: u32, _: u32) -> [f32; 3] {
    gray(2.0_f32.powi((x / 44) as i32 - 12))
}

/// Patches of the primaries and their mixes, from dim to ten times white.
fn colors(x: u32, y: u32, _: u32) -> [f32; 3] {
    const PATCHES: [[f32; 3]; 6] =
        [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let brightness = [0.02, 0.18, 1.0, 10.0][(y / 136) as usize % 4];
    PATCHES[(x / 161) as usize % PATCHES.len()].map(|channel| channel * brightness)
}

/// Pixels a frame of what moves.
const SPEEDS: [f32; 3] = [0.3, 1.4, 5.0];
/// The cells of lamps in a sequence.
const LAMP_CELL: u32 = 40;

/// Lamps of one to eight pixels, each lit for one or three frames, then dark for as many.
fn lamps_switched(x: u32, y: u32, frame: u32) -> [f32; 3] {
    let (column, row) = (x / LAMP_CELL, y / LAMP_CELL);
    let (side, length) = (1 + column % 8, if (column + row).is_multiple_of(2) { 3 } else { 1 });
    let inside = |at: u32| (16..16 + side).contains(&(at % LAMP_CELL));
    let is_lit = ((frame + column + 2 * row) / length).is_multiple_of(2);
    gray(if inside(x) && inside(y) && is_lit { 2.0_f32.powi(1 + row as i32) } else { 0.01 })
}

/// Rows of lamps of one to eight pixels that move to the right at three speeds. Between pixels, both have a part.
fn lamps_in_motion(x: u32, y: u32, frame: u32) -> [f32; 3] {
    let row = y / LAMP_CELL;
    let moved = SPEEDS[row as usize % 3] * frame as f32;
    // The part of the pixel that lies in the lamp.
    let lit = (0..=MOVING_WIDTH / LAMP_CELL).map(|column| {
        let side = (1 + column % 8) as f32;
        let left = (column * LAMP_CELL) as f32 + moved;
        let part = (left + side).min(x as f32 + 1.0) - left.max(x as f32);
        if ((y % LAMP_CELL) as f32) < side { part.max(0.0) } else { 0.0 }
    });
    gray(0.01 + lit.sum::<f32>() * 2.0_f32.powi(1 + row as i32))
}

/// Three bands of a picture that move at three speeds.
fn pan(x: u32, y: u32, frame: u32) -> [f32; 3] {
    let speed = SPEEDS[(3 * y / MOVING_HEIGHT) as usize];
    texture(x as f32 + speed * frame as f32, y as f32, 0)
}

/// A picture, four others, and the first again five stops brighter, after unequal numbers of frames, without notice.
fn cuts(x: u32, y: u32, frame: u32) -> [f32; 3] {
    let (picture, stops) = match frame {
        0..3 => (0, 0),
        3..5 => (1, -3),
        5..10 => (2, 2),
        _ => (0, 5),
    };
    texture(x as f32, y as f32, picture).map(|channel| channel * 2.0_f32.powi(stops))
}

/// A colored texture of detail from 64 to 4 pixels in ten stops: a tenth of it is brighter than white.
fn texture(x: f32, y: f32, picture: u32) -> [f32; 3] {
    let octave = |scale: f32, seed: u32| smooth_noise(x / scale, y / scale, 8 * picture + seed);
    let light = 0.5 * octave(64.0, 0) + 0.3 * octave(16.0, 1) + 0.2 * octave(4.0, 2);
    let warm = octave(40.0, 3) - 0.5;
    [warm, 0.0, -warm].map(|tint| 2.0_f32.powf(14.0 * light - 9.0 + 2.0 * tint))
}

/// Noise from 0 to 1 with a random value at each integer position, smooth between them.
fn smooth_noise(x: f32, y: f32, seed: u32) -> f32 {
    let (left, top) = (x.floor(), y.floor());
    let value = |dx: u32, dy: u32| {
        let place = (left as u32 + dx).wrapping_mul(0x9E37_79B1) ^ (top as u32 + dy).wrapping_mul(0x85EB_CA77);
        let mixed = (place ^ seed.wrapping_mul(0xC2B2_AE3D)).wrapping_mul(0x27D4_EB2F);
        ((mixed ^ mixed >> 15).wrapping_mul(0x9E37_79B1) >> 8) as f32 / (1 << 24) as f32
    };
    let [u, v] = [x - left, y - top].map(|t| t * t * (3.0 - 2.0 * t));
    let across = |dy: u32| value(0, dy) + u * (value(1, dy) - value(0, dy));
    across(0) + v * (across(1) - across(0))
}

/// The names of all charts.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    CHARTS.iter().map(|chart| chart.name)
}

/// True for the charts that a search of tiers sees.
pub(crate) fn is_searched(name: &str) -> bool {
    SEARCHED.contains(&name)
}

/// The frames of the chart of that name, opaque.
///
/// # Panics
/// There is none.
pub(crate) fn frames(name: &str) -> Vec<Texels> {
    let chart = CHARTS.iter().find(|chart| chart.name == name).expect("the name is one of `names`");
    let (width, height) = if chart.frames == 1 { (WIDTH, HEIGHT) } else { (MOVING_WIDTH, MOVING_HEIGHT) };
    let frame = |frame| {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels: Vec<[f32; 4]> = places
            .map(|(x, y)| {
                let [red, green, blue] = (chart.color)(x, y, frame);
                [red, green, blue, 1.0]
            })
            .collect();
        Texels::from_floats_as_half(width, height, &pixels)
    };
    (0..chart.frames).map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest channel of a pixel.
    fn light(chart: fn(u32, u32, u32) -> [f32; 3], x: u32, y: u32, frame: u32) -> f32 {
        chart(x, y, frame).into_iter().fold(0.0, f32::max)
    }

    #[test]
    fn a_lamp_is_switched_in_each_frame_and_in_all_phases_of_each_period() {
        let lamps = |frame: u32| {
            let centers = (0..MOVING_HEIGHT / LAMP_CELL).flat_map(|row| (0..12).map(move |column| (column, row)));
            centers
                .map(move |(column, row)| light(lamps_switched, column * LAMP_CELL + 16, row * LAMP_CELL + 16, frame))
        };
        for frame in 1..9 {
            let changed: Vec<bool> =
                lamps(frame).zip(lamps(frame - 1)).map(|(now, before)| (now > 1.0) != (before > 1.0)).collect();
            assert!(changed.iter().any(|changed| *changed) && !changed.iter().all(|changed| *changed), "{frame}");
        }
    }

    #[test]
    fn lamps_that_move_between_pixels_keep_their_light() {
        for row in 0..MOVING_HEIGHT / LAMP_CELL {
            let sum = |frame: u32| -> f64 {
                let pixels = (0..LAMP_CELL).flat_map(|y| (0..200).map(move |x| (x, row * LAMP_CELL + y)));
                pixels.map(|(x, y)| f64::from(light(lamps_in_motion, x, y, frame))).sum()
            };
            let first = sum(0);
            // The lamps of the first five cells stay left of column 200.
            for frame in 1..8 {
                assert!((sum(frame) / first - 1.0).abs() < 1e-4, "row {row}, frame {frame}: {} of {first}", sum(frame));
            }
        }
    }

    #[test]
    fn a_pan_moves_its_picture_by_whole_pixels_where_the_speed_is_whole() {
        let last = MOVING_HEIGHT - 1;
        for x in 0..200 {
            assert_eq!(pan(x, last, 3), pan(x + 15, last, 0), "five pixels a frame");
        }
        let bright = (0..MOVING_WIDTH).filter(|x| (0..MOVING_HEIGHT).any(|y| light(pan, *x, y, 0) > 1.0)).count();
        assert!(bright > 50, "light gets bloom in {bright} columns");
    }

    #[test]
    fn a_cut_falls_between_the_frames_of_each_period() {
        let is_cut = |frame: &u32| (0..40).any(|x| cuts(x, 7, *frame) != cuts(x, 7, *frame - 1));
        let cuts: Vec<u32> = (1..12).filter(is_cut).collect();
        assert_eq!(cuts, [3, 5, 10]);
        for (period, phase) in [(2, 0), (2, 1), (3, 0), (3, 1), (3, 2), (4, 0), (4, 1), (4, 2), (4, 3)] {
            assert!(cuts.iter().any(|frame| frame % period != phase), "{period} {phase}");
        }
    }

    #[test]
    fn all_frames_of_a_chart_have_one_size() {
        for name in names() {
            let frames = frames(name);
            assert!(frames.iter().all(|frame| frame.desc.size == frames[0].desc.size), "{name}");
        }
        assert_eq!((frames("lamps").len(), frames("cuts").len()), (1, 12));
    }
}
