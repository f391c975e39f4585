//! Matrices against published ones.

use afterimage_base::color::{Chromaticities, Decimal, Xy};
use glam::{DMat3, DVec3, Mat3};

use crate::codec::{convert, to_rec709};

fn assert_rows(matrix: DMat3, rows: [[f64; 3]; 3]) {
    let expected = DMat3::from_cols_array_2d(&rows).transpose();
    assert!(matrix.abs_diff_eq(expected, 1e-9), "{matrix} is not {expected}");
}

#[test]
fn acescg_is_adapted_from_its_own_white() {
    let rows = [
        [1.705050992658, -0.621792120657, -0.083258872001],
        [-0.130256417507, 1.140804736575, -0.010548319068],
        [-0.024003356805, -0.128968976065, 1.152972332870],
    ];
    assert_rows(to_rec709(&Chromaticities::ACES_CG).unwrap(), rows);
}

/// Academy TB-2014-004, which has ten digits.
#[test]
fn ap0_becomes_ap1_by_the_matrix_of_the_academy() {
    let rows = [
        [1.4514393161, -0.2365107469, -0.2149285693],
        [-0.0765537734, 1.1762296998, -0.0996759264],
        [0.0083161484, -0.0060324498, 0.9977163014],
    ];
    assert_rows(Chromaticities::ACES_AP0.conversion(&Chromaticities::ACES_CG), rows);
}

#[test]
fn p3_with_the_same_white_needs_no_adaptation() {
    let rows = [
        [1.224940176281, -0.224940176281, 0.0],
        [-0.042056954710, 1.042056954710, 0.0],
        [-0.019637554590, -0.078636045551, 1.098273600141],
    ];
    assert_rows(to_rec709(&Chromaticities::DISPLAY_P3).unwrap(), rows);
}

#[test]
fn tristimulus_values_are_taken_as_they_are() {
    let third = 1.0 / 3.0;
    let xyz = Chromaticities::from_numbers([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, third, third]).unwrap();
    let matrix = to_rec709(&xyz).unwrap();
    let d65 = DVec3::new(0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290);
    assert!((matrix * d65).abs_diff_eq(DVec3::ONE, 1e-12));
}

#[test]
fn white_stays_white_whatever_the_primaries() {
    let wide = Chromaticities { red: Xy::new(0.75, 0.27), white: Xy::new(0.34, 0.35), ..Chromaticities::ACES_CG };
    for space in [Chromaticities::ACES_CG, wide] {
        let white = to_rec709(&space).unwrap() * DVec3::ONE;
        assert!(white.abs_diff_eq(DVec3::ONE, 1e-12), "{white}");
    }
}

#[test]
fn rec709_within_a_thousandth_is_left_alone() {
    let rec709 = Chromaticities::REC709;
    let moved = |by| Chromaticities { red: Xy { x: Decimal::new(0.640 + by), ..rec709.red }, ..rec709 };
    assert_eq!(to_rec709(&moved(9e-4)), None);
    assert!(to_rec709(&moved(2e-3)).is_some());
}

#[test]
fn one_overflowed_channel_does_not_poison_the_others() {
    let matrix = to_rec709(&Chromaticities::ACES_CG).unwrap().as_mat3();
    let [r, g, b] = convert(&matrix, [f32::INFINITY, 1.0, f32::NAN]);
    assert!((r - 1.705051 * 65504.0).abs() < 1.0, "{r}");
    assert!((g + 0.130256 * 65504.0).abs() < 2.0, "{g}");
    assert!(b < -1000.0 && b.is_finite(), "negatives are kept: {b}");
    let huge = convert(&matrix, [f32::MAX, -f32::MAX, f32::MAX]);
    assert!(huge.iter().all(|v| v.is_finite()));
    assert_eq!(convert(&Mat3::IDENTITY, [0.5, -2.0, 70000.0]), [0.5, -2.0, 70000.0]);
}
