//! Depths, and the depth maps of lights.

use glam::{DMat4, DVec3};

use super::{Case, Op};
use crate::reference::shadow::{depth_of_position, lit_share, look_at, perspective, position_of_depth, shown_at};

pub(super) const OPS: &[Op] = &[
    ("view_z_from_depth", |case| {
        vec![position_of_depth(case.first(), case.param("near"), case.param("far"), case.is_reversed())]
    }),
    ("depth_from_view_z", |case| vec![depth_of_position(case.first(), 0.1, 100.0, case.is_reversed())]),
    ("light_matrix", |case| rows(if case.word() == "projection" { projection() } else { view() })),
    ("shadow_uvz", |case| shown_at(projection() * view(), DVec3::from_array(case.rgb())).to_vec()),
    ("pcf3x3", |case| {
        let depths = super::flat(case.part("depths"));
        vec![lit_share(case.part_number("z"), case.part_number("bias"), &depths)]
    }),
];

fn projection() -> DMat4 {
    perspective(45_f64.to_radians(), 1.0, 0.1, 100.0)
}

fn view() -> DMat4 {
    look_at(DVec3::new(0.0, 10.0, 0.001), DVec3::ZERO, DVec3::NEG_Z)
}

fn rows(matrix: DMat4) -> Vec<f64> {
    matrix.transpose().to_cols_array().to_vec()
}

impl Case<'_> {
    /// The first of the input's parts.
    fn first(&self) -> f64 {
        super::number(&self.input[0])
    }

    /// True if the near plane is at depth 1.
    fn is_reversed(&self) -> bool {
        self.input[1].as_bool().unwrap_or_else(|| panic!("{} does not say so", self.input))
    }
}
