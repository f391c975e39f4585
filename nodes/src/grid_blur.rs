//! GridBlur: blurs a bilateral grid.

use std::array::from_fn;

use afterimage_graph::prelude::*;

use crate::gaussian_weights::GaussianWeights;

static SHADER: Shader = shader!("grid_blur");

/// A `slope` that limits nothing.
const NO_SLOPE: f32 = 64.0;

node_kind! {
    /// Blurs a bilateral grid by a Gaussian along x, y and luminance.
    ///
    /// Cells outside of the grid are empty. Sums and weights are blurred alike, so their quotient is a mean of existing
    /// cells, also at the borders. The kernel ends at three sigmas. An axis with a sigma of at most 0.2 is not blurred.
    pub struct GridBlur {
        /// Standard deviations along x, y and luminance. 0 does not blur an axis. Along luminance the sigma separates
        /// edges from detail: the default is one stop in the default grid, with which differences of under 1 stop are
        /// detail, and those of over 3 stops are edges.
        pub sigma: [f32; 3] = [2.5, 1.25, 4.0]
            => within(0.0..=16.0), usually(0.0..=4.0), unit("cells"), neutral([0.0f32; 3]);
        /// The largest change of the means of a place along luminance, in stops per stop, where two regions meet.
        /// Without a limit they change by D^2 / 4 between regions D stops apart, if the third sigma is a stop. Where
        /// they change by more than detail / (detail - contrast) of a `LocalToneMap`, its result falls where the image
        /// rises: soft edges get dark lines. Cells of much different weights do not limit each other, so hard edges
        /// stay without halos. 64 limits nothing.
        pub slope: f32 = 1.5
            => within(1.0..=64.0), usually(1.0..=4.0), unit("stops per stop"), neutral(NO_SLOPE);
    }

    const INPUTS: &'static [Input] =
        &[Input::new("source", PortType::Volume, "The result of a `GridBuild`.").content("bilateral-grid")];
    const OUTPUTS: &'static [Output] =
        &[Output::new("result", PortType::Volume, OutputState::same("source"), "The blurred grid.")
            .content("bilateral-grid")
            .or_input("source")];
}

const REACH: f32 = 3.0;
const GROUP: [u32; 3] = [8, 8, 4];
/// The axis of luminance.
const LUMINANCE: usize = 2;

impl GridBlur {
    /// The axes to blur with their kernels. Luminance is one of them where its slope is limited.
    fn axes(&self, may_change: bool, is_limited: bool) -> impl Iterator<Item = (usize, GaussianWeights)> {
        let kernel = move |(axis, sigma): (usize, f32)| {
            let is_needed = may_change || is_limited && axis == LUMINANCE;
            let weights = GaussianWeights::new(sigma, REACH).or(is_needed.then_some(GaussianWeights::COPY))?;
            Some((axis, weights))
        };
        self.sigma.into_iter().enumerate().filter_map(kernel)
    }
}

impl Node for GridBlur {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.axes(false, self.slope < NO_SLOPE).next().is_none()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let mut cells = pass.image("source");
        let desc = pass.desc(cells);
        let size = desc.size;
        let is_limited = self.slope < NO_SLOPE || pass.is_dynamic("slope");
        let mut axes = self.axes(pass.is_dynamic("sigma"), is_limited).peekable();
        while let Some((axis, weights)) = axes.next() {
            let last = axes.peek().is_none();
            let name = ["x", "y", "z"][axis];
            let result = if last { pass.output("result", desc) } else { pass.transient(name, desc) };
            let (entry, groups) = match is_limited && axis == LUMINANCE {
                true => ("grid_blur_slope", [size.width, size.height, 1]),
                false => ("grid_blur", {
                    let sides = [size.width, size.height, size.depth];
                    from_fn(|side| sides[side].div_ceil(GROUP[side]))
                }),
            };
            let mut along = [0_u32; 3];
            along[axis] = 1;
            pass.compute(&SHADER, entry)
                .label(format_args!("{entry} {name}"))
                .image("cells", cells)
                .image("result", result)
                .set("axis", along)
                .set("radius", weights.radius)
                .set("falloff", weights.falloff)
                .set("scale", weights.scale)
                .set("slope", self.slope)
                .dispatch(groups);
            cells = result;
        }
    }
}
