//! The metrics of `measure` against published figures and independent programs.
//!
//! The pair of pictures is made from whole numbers by a formula, so that another program can make the very same pair. The figures of
//! other programs come from scikit-image 0.26.0 (SSIM and PSNR), color-science 0.4.7 (CIEDE2000 and dE ITP), flip-evaluator 1.7
//! (FLIP) and cvvdp 0.5.7 with torch 2.15.0 (JOD), all on Python 3.11.

use afterimage_lab::metrics::{
    Display, NO_DIFFERENCE, PIXELS_PER_DEGREE, Range, Shown, ciede2000, ciede2000_of, delta_e_itp, delta_e_itp_of,
    difference, flip, jod, lab_of_srgb, mean, nits_of_pq, percentile, psnr, pu21, ssim,
};

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// 8-bit codes of the reference and of a picture with noise and a pattern of brighter squares.
fn codes(x: usize, y: usize, channel: usize) -> [i64; 2] {
    let mixed = (x as u64 * 73856093) ^ (y as u64 * 19349663) ^ (channel as u64 * 83492791);
    let hash = ((mixed * 2654435761) & 0xffff_ffff) as i64;
    let first = (x * 3 + y * 2 + channel * 40) as i64 % 200 + (hash >> 24) % 40;
    let square = if (x / 8 + y / 8) % 2 == 1 { 10 } else { 0 };
    [first, (first + (hash >> 16 & 15) - 8 + square).clamp(0, 255)]
}

/// The pair, each code made a number by `number`.
fn pair(range: Range, number: impl Fn(f64) -> f64) -> [Shown; 2] {
    [0, 1].map(|which| {
        let pixel = |x, y| [0, 1, 2].map(|channel| number(codes(x, y, channel)[which] as f64) as f32);
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Shown { width: WIDTH, height: HEIGHT, range, pixels }
    })
}

fn sdr() -> [Shown; 2] {
    pair(Range::Sdr, |code| code / 255.0)
}

/// Light from 0 to 1016 cd/m².
fn hdr() -> [Shown; 2] {
    pair(Range::Hdr, |code| code * code / 64.0)
}

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} within {tolerance}");
}

#[test]
fn the_pair_is_the_one_that_other_programs_saw() {
    assert_eq!([0, 1, 2].map(|c| codes(5, 3, c)), [[35, 34], [77, 73], [117, 110]]);
    let sum = |which: usize| -> i64 {
        (0..HEIGHT)
            .flat_map(|y| (0..WIDTH).map(move |x| (x, y)))
            .map(|(x, y)| (0..3).map(|c| codes(x, y, c)[which]).sum::<i64>())
            .sum()
    };
    assert_eq!([sum(0), sum(1)], [1096776, 1137997]);
}

#[test]
fn ciede2000_gives_the_published_differences() {
    let mut pairs = 0;
    for line in include_str!("metrics/ciede2000.txt").lines().filter(|line| !line.starts_with('#')) {
        let n: Vec<f64> = line.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let (first, second) = ([n[0], n[1], n[2]], [n[3], n[4], n[5]]);
        close(ciede2000_of(first, second), n[6], 5.1e-5);
        close(ciede2000_of(second, first), n[6], 5.1e-5);
        pairs += 1;
    }
    assert_eq!(pairs, 34);
}

#[test]
fn ciede2000_of_a_pair_of_pictures() {
    let [reference, other] = sdr();
    // The other program derives its matrix here from the primaries; by default it takes the four printed digits.
    let all = ciede2000(&reference.pixels, &other.pixels);
    close(mean(&all), 2.94562299, 1e-5);
    close(percentile(&all, 0.999), 9.09190027, 1e-5);
    close(percentile(&all, 1.0), 10.5145559, 1e-5);
    let lab = lab_of_srgb([200.0 / 255.0, 50.0 / 255.0, 25.0 / 255.0]);
    lab.iter().zip([45.12723658, 57.4564502, 49.15830444]).for_each(|(found, expected)| close(*found, expected, 1e-4));
}

#[test]
fn delta_e_itp_of_lights_and_of_a_pair_of_pictures() {
    for (reference, other, expected) in [
        ([100.0, 100.0, 100.0], [101.0, 101.0, 101.0], 0.7192686),
        ([10.0, 20.0, 30.0], [10.5, 20.0, 30.0], 1.2236440),
        ([1000.0, 200.0, 5.0], [900.0, 210.0, 6.0], 10.6814271),
        ([0.0, 0.0, 0.0], [0.01, 0.01, 0.01], 15.4695476),
        ([203.0, 203.0, 203.0], [203.0, 200.0, 203.0], 1.0781725),
    ] {
        close(delta_e_itp_of(reference, other), expected, 3e-3);
    }
    let [reference, other] = hdr();
    let all = delta_e_itp(&reference.pixels, &other.pixels);
    close(mean(&all), 9.9924291, 5e-3);
    close(percentile(&all, 1.0), 40.5453537, 2e-2);
}

#[test]
fn pu21_gives_the_published_ends() {
    // The range that the authors state: 5.4705e-10 at 0.005 cd/m², 595.3939 at 10000.
    close(pu21(0.005), 5.4705e-10, 1e-13);
    close(pu21(10_000.0), 595.3939, 5e-5);
    close(pu21(100.0), 256.383897, 1e-5);
    close(pu21(1.0), 36.5439111, 1e-6);
    assert_eq!([pu21(-1.0), pu21(1e9)], [pu21(0.005), pu21(10_000.0)]);
}

#[test]
fn pq_gives_the_levels_of_bt_2408() {
    // 203 cd/m² is 58 % of the signal, 100 cd/m² is 50.8 %.
    close(nits_of_pq(0.580689), 203.0, 1e-3);
    close(nits_of_pq(0.508078), 100.0, 1e-3);
    close(nits_of_pq(1.0), 10_000.0, 1e-6);
    close(nits_of_pq(0.0), 0.0, 1e-12);
}

#[test]
fn psnr_and_ssim_of_a_pair_of_pictures() {
    let [reference, other] = sdr();
    close(psnr(&reference.codes(), &other.codes(), 255.0), 29.9153257, 1e-5);
    close(ssim(&reference, &other), 0.9218049199, 1e-6);
    let [reference, other] = hdr();
    close(psnr(&reference.codes(), &other.codes(), 256.0), 25.4248053, 1e-5);
    close(ssim(&reference, &other), 0.9267314563, 1e-5);
}

#[test]
fn flip_of_a_pair_of_pictures() {
    let [reference, other] = sdr();
    let map = flip(&reference, &other, PIXELS_PER_DEGREE);
    close(PIXELS_PER_DEGREE, 67.0206451, 1e-5);
    close(mean(&map), 0.1407039, 5e-5);
    close(percentile(&map, 1.0), 0.3103253, 2e-4);
    close(f64::from(map[10 * WIDTH + 20]), 0.1760720, 2e-4);
    close(f64::from(map[30 * WIDTH + 40]), 0.0482797, 2e-4);
}

#[test]
fn flip_of_a_pair_of_hdr_pictures() {
    let [reference, other] = hdr();
    let map = flip(&reference, &other, PIXELS_PER_DEGREE);
    close(mean(&map), 0.1735979, 5e-5);
    close(f64::from(map[10 * WIDTH + 20]), 0.1767051, 2e-4);
    // Three exposures instead of two.
    let [reference, other] = pair(Range::Hdr, |code| code.powi(4) / 65536.0);
    let map = flip(&reference, &other, PIXELS_PER_DEGREE);
    close(mean(&map), 0.2190125, 5e-5);
    close(percentile(&map, 1.0), 0.570229, 3e-4);
}

/// The quality in JOD of pictures on a display, at 24 frames per second.
#[track_caller]
fn judged(display: &Display, reference: &[Shown], other: &[Shown]) -> f64 {
    jod(reference, other, 24.0, display).expect("the frame rate is one of a film")
}

/// Five frames of both pictures of the pair, which move to the left by three pixels a frame.
fn clip() -> [Vec<Shown>; 2] {
    [0, 1].map(|which| {
        let number = |x, y, channel| codes(x, y, channel)[which] as f32 / 255.0;
        let frame = |left| {
            let places = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x + left, y)));
            let pixels = places.map(|(x, y)| [0, 1, 2].map(|channel| number(x, y, channel))).collect();
            Shown { width: WIDTH, height: HEIGHT, range: Range::Sdr, pixels }
        };
        [0, 3, 6, 9, 12].map(frame).into()
    })
}

#[test]
fn jod_of_pictures_and_of_a_clip_on_three_displays() {
    let [reference, other] = sdr().map(|picture| [picture]);
    close(judged(&Display::DESK, &reference, &other), 9.274424, 1e-4);
    close(judged(&Display::TV_HDR, &reference, &other), 9.379864, 1e-4);
    let [reference, other] = hdr().map(|picture| [picture]);
    close(judged(&Display::TV_HDR, &reference, &other), 9.211223, 1e-4);
    let [reference, other] = clip();
    close(judged(&Display::PHONE, &reference, &other), 9.225200, 1e-4);
    close(jod(&reference, &other, 60.0, &Display::PHONE).expect("a frame rate"), 9.139511, 1e-4);
    assert!(jod(&reference, &other, 0.0, &Display::PHONE).is_err_and(|error| error.to_string().contains("frame rate")));
}

#[test]
fn a_worse_picture_has_fewer_jod() {
    let [reference, other] = sdr();
    let with = |share: f32| {
        let mut mixed = reference.clone();
        for (mixed, other) in mixed.pixels.iter_mut().flatten().zip(other.pixels.iter().flatten()) {
            *mixed += share * (other - *mixed);
        }
        judged(&Display::DESK, std::slice::from_ref(&reference), &[mixed])
    };
    let all = [0.0, 0.1, 0.3, 1.0].map(with);
    assert_eq!(all[0], NO_DIFFERENCE);
    assert!(all.is_sorted_by(|a, b| a > b), "{all:?}");
}

#[test]
fn jod_of_a_clip_depend_on_the_order_of_its_frames() {
    let [reference, _] = clip();
    let order = |frames: [usize; 5]| frames.map(|frame| reference[frame].clone());
    assert_eq!(judged(&Display::DESK, &reference, &order([0, 1, 2, 3, 4])), NO_DIFFERENCE);
    let held = judged(&Display::DESK, &reference, &order([0, 1, 2, 2, 4]));
    let held_longer = judged(&Display::DESK, &reference, &order([0, 1, 1, 1, 4]));
    assert!(held_longer < held && held < NO_DIFFERENCE - 0.5, "{held} {held_longer}");
    // The same frames with the same errors: what comes and goes is seen, what stays less.
    let [picture, other] = sdr();
    let still = [0; 5].map(|_| picture.clone());
    let seen = |wrong: [bool; 5]| {
        let frames = wrong.map(|wrong| if wrong { other.clone() } else { picture.clone() });
        judged(&Display::DESK, &still, &frames)
    };
    let (steady, flickering) = (seen([false, false, true, true, true]), seen([true, false, true, false, true]));
    assert!(flickering < steady - 0.01, "{flickering} {steady}");
}

/// Contrasts count, and not the brightness around them: FLIP and codes see what JOD do not.
#[test]
fn a_change_of_all_light_is_not_seen_by_jod() {
    let gray = |code: f32| Shown { width: 64, height: 64, range: Range::Sdr, pixels: vec![[code; 3]; 64 * 64] };
    let (reference, other) = (gray(0.5), gray(0.6));
    close(judged(&Display::DESK, std::slice::from_ref(&reference), std::slice::from_ref(&other)), NO_DIFFERENCE, 1e-6);
    assert!(mean(&flip(&reference, &other, PIXELS_PER_DEGREE)) > 0.05);
}

#[test]
fn tiny_pictures_are_judged() {
    let [reference, other] = sdr();
    let part = |of: &Shown, width: usize, height: usize| {
        let rows = of.pixels.chunks(WIDTH).take(height).flat_map(|row| row[..width].to_vec());
        [Shown { width, height, range: Range::Sdr, pixels: rows.collect() }]
    };
    close(judged(&Display::DESK, &part(&reference, 7, 5), &part(&other, 7, 5)), 9.885662, 1e-4);
    for (width, height) in [(1, 1), (1, 9), (2, 3), (33, 1), (4, 4), (5, 33)] {
        let found = judged(&Display::DESK, &part(&reference, width, height), &part(&other, width, height));
        assert!((8.0..=NO_DIFFERENCE).contains(&found), "{width}x{height}: {found}");
    }
}

#[test]
fn equal_pictures_have_no_error() {
    for [reference, _] in [sdr(), hdr()] {
        assert_eq!(percentile(&difference(&reference.codes(), &reference.codes()), 1.0), 0.0);
        assert_eq!(psnr(&reference.codes(), &reference.codes(), reference.range.peak()), f64::INFINITY);
        close(ssim(&reference, &reference), 1.0, 1e-12);
        assert_eq!(mean(&flip(&reference, &reference, PIXELS_PER_DEGREE)), 0.0);
        let again = [reference.clone()];
        assert!(Display::ALL.iter().all(|display| judged(display, &again, &again) == NO_DIFFERENCE));
    }
}

#[test]
fn pictures_of_one_pixel_can_be_judged() {
    let one = |range, pixel| Shown { width: 1, height: 1, range, pixels: vec![pixel] };
    let (black, white) = (one(Range::Sdr, [0.0; 3]), one(Range::Sdr, [1.0; 3]));
    close(mean(&flip(&black, &white, PIXELS_PER_DEGREE)), 0.9673883, 1e-4);
    assert!(ssim(&black, &white) < 0.01);
    let dark = one(Range::Hdr, [0.0; 3]);
    assert_eq!(mean(&flip(&dark, &dark, PIXELS_PER_DEGREE)), 0.0);
}

#[test]
fn a_percentile_is_a_number_that_occurs() {
    let numbers: Vec<f32> = (0..1000).rev().map(|i| i as f32).collect();
    assert_eq!(percentile(&numbers, 0.999), 998.0);
    assert_eq!(percentile(&numbers, 1.0), 999.0);
    assert_eq!(percentile(&numbers[..1], 0.5), 999.0);
    assert_eq!(percentile(&[], 0.5), 0.0);
}
