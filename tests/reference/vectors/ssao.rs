//! Ambient occlusion by points in a hemisphere.

use super::{Case, Op};
use crate::reference::ssao::{before_plane, kernel};

pub(super) const OPS: &[Op] = &[
    ("ssao_kernel", |case| kernel(case.number() as usize).iter().flat_map(|point| point.to_array()).collect()),
    ("ssao_uniform_depth", |case: &Case| {
        let [own, plane, radius, bias] = ["frag_z", "plane_z", "radius", "bias"].map(|name| case.part_number(name));
        vec![before_plane(own, plane, radius, bias)]
    }),
];
