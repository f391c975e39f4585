//! Luminance, matrices, space conversions and white balance.

use super::{Case, Op, rows};
use crate::reference::color::{
    ACES_WHITE, AP1, BRADFORD, CAT16, CUSTOM, D65, P3_D65, REC709, REC2020, Space, adaptation, conversion, daylight_xy,
    from_xyz, luminance, planck_xy, to_xyz, white_balance_scene, white_balance_target, xyz,
};
use crate::reference::curves::{HILL_IN, HILL_OUT};
use crate::reference::math::{Matrix, diagonal, inverse, product, transform};
use crate::reference::{agx, gt7, purkinje};

pub(super) const OPS: &[Op] = &[
    ("luminance709", |case| vec![luminance(case.rgb())]),
    ("matrices_row_major", |case| match case.word() {
        "lmsr_from_rec709" => [purkinje::LMS_FROM_REC709.as_flattened(), &purkinje::ROD_FROM_REC709].concat(),
        name => rows(&matrix(name)),
    }),
    ("convert_rec709_to_custom", |case| converted(case, &CUSTOM)),
    ("convert_rec709_to_ap1", |case| converted(case, &AP1)),
    ("convert_rec709_to_rec2020", |case| converted(case, &REC2020)),
    ("wb_matrix_target", |case| rows(&white_balance_target(&BRADFORD, case.rgb(), true))),
    ("wb_apply_target", |case| {
        let balance = white_balance_target(&BRADFORD, case.part_rgb("target"), true);
        transform(&balance, case.part_rgb("rgb")).to_vec()
    }),
    ("daylight_xy", |case| daylight_xy(case.number()).to_vec()),
    ("planck_xy", |case| planck_xy(case.number()).to_vec()),
    ("wb_scene_white", |case| transform(&white_balance_scene(&BRADFORD, case.number(), 0.0), [1.0; 3]).to_vec()),
];

fn converted(case: &Case, space: &Space) -> Vec<f64> {
    transform(&conversion(&REC709, space), case.rgb()).to_vec()
}

fn space(name: &str) -> Option<&'static Space> {
    let space = match name {
        "rec709" => &REC709,
        "p3d65" => &P3_D65,
        "rec2020" => &REC2020,
        "ap1" => &AP1,
        "custom" => &CUSTOM,
        _ => return None,
    };
    Some(space)
}

/// The matrix of a name in the file: one of a kind, or `<space>_to_<space>`.
fn matrix(name: &str) -> Matrix {
    single_matrix(name).unwrap_or_else(|| {
        let (source, destination) = name.split_once("_to_").expect("a name of two spaces");
        match (space(source), space(destination)) {
            (Some(source), Some(destination)) => conversion(source, destination),
            (Some(source), None) => to_xyz(source),
            (None, Some(destination)) => from_xyz(destination),
            (None, None) => panic!("no matrix is called `{name}`"),
        }
    })
}

fn single_matrix(name: &str) -> Option<Matrix> {
    let matrix = match name {
        "bradford" => BRADFORD,
        "bradford_inv" => inverse(&BRADFORD),
        "cat16" => CAT16,
        "cat16_inv" => inverse(&CAT16),
        "cat_bradford_D65_to_D60" => adaptation(&BRADFORD, xyz(D65), xyz(ACES_WHITE)),
        "cat_bradford_D60_to_D65" => adaptation(&BRADFORD, xyz(ACES_WHITE), xyz(D65)),
        "agx_inset" => agx::INSET,
        "agx_outset" => inverse(&agx::INSET),
        "agx2020_inset" => agx::INSET_2020,
        "agx2020_outset" => agx::OUTSET_2020,
        "hill_in_derived" => product(&ap1_saturation(0.96), &conversion(&REC709, &AP1)),
        "hill_out_derived" => product(&conversion(&AP1, &REC709), &ap1_saturation(0.93)),
        "hill_in_published" => HILL_IN,
        "hill_out_published" => HILL_OUT,
        "rec709_from_lms" => inverse(&purkinje::LMS_FROM_REC709),
        "purkinje_C" => purkinje::rod_matrix(),
        "ictcp_lms_from_rec2020" => gt7::LMS_FROM_REC2020,
        "rec2020_from_ictcp_lms" => inverse(&gt7::LMS_FROM_REC2020),
        "ictcp_from_lms" => gt7::ICTCP_FROM_LMS,
        "lms_from_ictcp" => inverse(&gt7::ICTCP_FROM_LMS),
        _ => return None,
    };
    Some(matrix)
}

/// The saturation matrices of the ACES transforms: a blend with AP1's luminance.
fn ap1_saturation(amount: f64) -> Matrix {
    let luminance = to_xyz(&AP1)[1].map(|weight| weight * (1.0 - amount));
    let gray = [luminance; 3];
    let own = diagonal([amount; 3]);
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| own[row][column] + gray[row][column]))
}

#[test]
fn color_references_agree_with_the_vectors() {
    super::check(OPS);
}

#[test]
fn conversions_keep_white() {
    let spaces = [REC709, P3_D65, REC2020, AP1, CUSTOM];
    for source in &spaces {
        for destination in &spaces {
            for channel in transform(&conversion(source, destination), [1.0; 3]) {
                assert!((channel - 1.0).abs() < 1e-13, "{source:?} to {destination:?}");
            }
        }
    }
}
