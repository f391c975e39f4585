//! LinearDepth: the distance of what a depth buffer shows.

use afterimage_graph::node::CAMERA;
use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("linear_depth");

choices! {
    /// The encoding of a depth image.
    pub enum DepthEncoding {
        /// What the camera's projection writes to a depth buffer: from 0 to 1, with the near plane at either end.
        Projected,
        /// The distance along the view axis in meters, as files have it.
        Distance,
    }
}

node_kind! {
    /// Turns a depth buffer into the distance along the view axis, in meters if the world is.
    ///
    /// The projection of the camera may be any: perspective or orthographic, with the near plane at 0 or at 1, and with
    /// a far plane at an infinite distance. Distances above 65504 m, the largest half float, become 65504 m, and so
    /// does what lies behind the camera. `camera` is required, and must be the one that made the depth buffer. All
    /// kinds that take a `depth` expect such distances.
    pub struct LinearDepth {
        /// What the numbers of `depth` are. Distances pass as they are.
        pub encoding: DepthEncoding = DepthEncoding::Projected;
    }

    const INPUTS: &'static [Input] = &[
        Input::image("depth", "The depth, in x.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera that made it."),
    ];
    const OUTPUTS: &'static [Output] = &[Output::image(
        "result",
        OutputState::Always(ColorState::Data),
        "The distance along the view axis, in x; 0.001 to 65504.",
    )
    .or_input("depth")];
}

impl Node for LinearDepth {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.encoding == DepthEncoding::Distance
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let depth = pass.image("depth");
        let desc = pass.desc(depth);
        match self.encoding {
            DepthEncoding::Projected => {
                let desc = ImageDesc::new(desc.size).format(Format::R32Float);
                pass.function(&SHADER, "linear_depth").read("depth", depth).write("result", desc)
            }
            DepthEncoding::Distance => {
                pass.function(&SHADER, "linear_depth_distance").read("depth", depth).write("result", desc)
            }
        };
    }
}
