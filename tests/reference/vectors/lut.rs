//! Look-up tables.

use super::{Case, Op, flat};
use crate::reference::lut::{Cube, coordinate, lookup, tiled_coordinates};

pub(super) const OPS: &[Op] = &[
    ("lut1d", |case| vec![lookup(&flat(case.part("table")), case.part_number("x"))]),
    ("lut3d_trilinear", |case| cube(case).trilinear(case.rgb()).to_vec()),
    ("lut3d_tetrahedral", |case| cube(case).tetrahedral(case.rgb()).to_vec()),
    ("lut3d_uvw", |case| {
        let [c, n] = case.array();
        vec![coordinate(c, n as usize)]
    }),
    ("tiled_lut_uv", |case| {
        let (first, second, fraction) = tiled_coordinates(case.rgb());
        [first.as_slice(), &second, &[fraction]].concat()
    }),
];

/// The table that the operator lists as rows of place and color.
fn cube(case: &Case) -> Cube {
    let listed = flat(&case.params["entries"]);
    Cube::new(2, |place| {
        let row = listed.chunks(6).find(|row| row[..3] == place).expect("every corner is listed");
        [row[3], row[4], row[5]]
    })
}

#[test]
fn lut_references_agree_with_the_vectors() {
    super::check(OPS);
}
