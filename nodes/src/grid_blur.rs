//! GridBlur: blurs a bilateral grid.

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
/// Cells of a workgroup; one that limits the slope has all of a column, of which a grid has at most so many.
const GROUP: [u32; 3] = [8, 8, 4];
const COLUMN: [u32; 3] = [1, 1, 256];
/// The axis of luminance.
const LUMINANCE: usize = 2;

impl Node for GridBlur {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.slope >= NO_SLOPE && GaussianWeights::of_axes(&self.sigma, REACH, |_| false).next().is_none()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let mut cells = pass.image("source");
        let desc = pass.desc(cells);
        let size = desc.size;
        let is_limited = self.slope < NO_SLOPE || pass.is_dynamic("slope");
        let may_change = pass.is_dynamic("sigma");
        let is_needed = |axis| may_change || is_limited && axis == LUMINANCE;
        let mut axes = GaussianWeights::of_axes(&self.sigma, REACH, is_needed).peekable();
        while let Some((axis, weights)) = axes.next() {
            let last = axes.peek().is_none();
            let name = ["x", "y", "z"][axis];
            let result = if last { pass.output("result", desc) } else { pass.transient(name, desc) };
            let (entry, group) = match is_limited && axis == LUMINANCE {
                true => ("grid_blur_slope", COLUMN),
                false => ("grid_blur", GROUP),
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
                .dispatch([
                    size.width.div_ceil(group[0]),
                    size.height.div_ceil(group[1]),
                    size.depth.div_ceil(group[2]),
                ]);
            cells = result;
        }
    }
}
