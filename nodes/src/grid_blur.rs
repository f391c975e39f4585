//! GridBlur: blurs a bilateral grid.

use afterimage_graph::prelude::*;

use crate::gaussian_weights::GaussianWeights;

static SHADER: Shader = shader!("grid_blur");

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

impl Node for GridBlur {
    fn is_identity(&self, _: &InputValues) -> bool {
        GaussianWeights::of_axes(&self.sigma, REACH, false).next().is_none()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let mut cells = pass.image("source");
        let desc = pass.desc(cells);
        let size = desc.size;
        let mut axes = GaussianWeights::of_axes(&self.sigma, REACH, pass.is_dynamic("sigma")).peekable();
        while let Some((axis, weights)) = axes.next() {
            let last = axes.peek().is_none();
            let name = ["x", "y", "z"][axis];
            let result = if last { pass.output("result", desc) } else { pass.transient(name, desc) };
            let mut along = [0_u32; 3];
            along[axis] = 1;
            pass.compute(&SHADER, "grid_blur")
                .label(format_args!("grid_blur {name}"))
                .image("cells", cells)
                .image("result", result)
                .set("axis", along)
                .set("radius", weights.radius)
                .set("falloff", weights.falloff)
                .set("scale", weights.scale)
                .dispatch([
                    size.width.div_ceil(GROUP[0]),
                    size.height.div_ceil(GROUP[1]),
                    size.depth.div_ceil(GROUP[2]),
                ]);
            cells = result;
        }
    }
}
