//! Kinds that declare promises which they break.

use afterimage_graph::prelude::*;

use super::{RESULT, SOURCE};

pub(super) mod dark_edges {
    //! A blur whose taps outside the picture are black.
    use super::*;

    node_kind! {
        /// Lets the dark in at the border.
        pub struct DarkEdges {}

        const INPUTS: &'static [Input] = SOURCE;
        const OUTPUTS: &'static [Output] = RESULT;
        const INVARIANTS: Invariants = Invariants { keeps_constant: true, ..Invariants::DEFAULT };
    }

    impl Node for DarkEdges {
        fn record(&self, pass: &mut Recorder<'_>) {
            static SHADER: Shader = Shader::new(
                "dark_edges.wgsl",
                "import afterimage::sampling::texel;
fn dark_edges_inside(source: texture_2d<f32>, p: vec2i) -> vec4f {
    let is_inside = p.x >= 0 && p.x < i32(textureDimensions(source).x);
    return select(vec4f(0.0), texel(source, p), is_inside);
}
fn dark_edges(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    let sides = dark_edges_inside(source, at.pixel - vec2i(1, 0)) + dark_edges_inside(source, at.pixel + vec2i(1, 0));
    return 0.5 * texel(source, at.pixel) + 0.25 * sides;
}",
            );
            let source = pass.image("source");
            let desc = ImageDesc::new(pass.desc(source).size);
            pass.function(&SHADER, "dark_edges").write("result", desc);
        }
    }
}

pub(super) mod cut_off {
    //! A blur that removes the brightest light as if it were an outlier.
    use super::*;

    node_kind! {
        /// Loses what a firefly shines.
        pub struct CutOff {}

        const INPUTS: &'static [Input] = SOURCE;
        const OUTPUTS: &'static [Output] = RESULT;
        const INVARIANTS: Invariants = Invariants { keeps_sum: true, ..Invariants::DEFAULT };
    }
    faulty!(
        CutOff,
        "cut_off",
        |_| false,
        "fn cut_off(source: vec4f) -> vec4f { return vec4f(min(source.rgb, vec3f(1000.0)), source.a); }"
    );
}

pub(super) mod uneven {
    //! A kind of one pixel that looks at where it is.
    use super::*;

    node_kind! {
        /// Darker to the right.
        pub struct Uneven {}

        const INPUTS: &'static [Input] = SOURCE;
        const OUTPUTS: &'static [Output] = RESULT;
    }
    faulty!(
        Uneven,
        "uneven",
        |_| false,
        "fn uneven(source: vec4f, at: Point) -> vec4f { return vec4f(source.rgb * (1.0 - 0.25 * at.uv.x), source.a); }"
    );
}

pub(super) mod leaning {
    //! A kind of one pixel that looks at its neighbor.
    use super::*;

    node_kind! {
        /// Mixes in the pixel to the left.
        pub struct Leaning {}

        const INPUTS: &'static [Input] = SOURCE;
        const OUTPUTS: &'static [Output] = RESULT;
    }

    impl Node for Leaning {
        fn record(&self, pass: &mut Recorder<'_>) {
            static SHADER: Shader = Shader::new(
                "leaning.wgsl",
                "import afterimage::sampling::texel;
fn leaning(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return mix(texel(source, at.pixel), texel(source, at.pixel - vec2i(1, 0)), 0.25);
}",
            );
            let source = pass.image("source");
            let desc = ImageDesc::new(pass.desc(source).size);
            pass.function(&SHADER, "leaning").write("result", desc);
        }
    }
}

pub(super) mod falling {
    //! A curve that turns round.
    use super::*;

    node_kind! {
        /// Falls above middle gray.
        pub struct Falling {}

        const INPUTS: &'static [Input] = SOURCE;
        const OUTPUTS: &'static [Output] = RESULT;
        const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::DEFAULT };
    }
    faulty!(
        Falling,
        "falling",
        |_| false,
        "fn falling(source: vec4f) -> vec4f {
    return vec4f(source.rgb / (1.0 + source.rgb * source.rgb), source.a);
}"
    );
}

pub(super) mod restless {
    //! Restlessation that trusts the clock.
    use super::*;

    node_kind! {
        /// Follows the light of one pixel by a step that it does not look at.
        pub struct Restless {}

        const INPUTS: &'static [Input] = SOURCE;
        const OUTPUTS: &'static [Output] = &[Output::new("result", PortType::Value, OutputState::Nothing, "Stops.")];
        const INVARIANTS: Invariants = Invariants { is_exposure: true, ..Invariants::DEFAULT };
    }

    impl Node for Restless {
        fn record(&self, pass: &mut Recorder<'_>) {
            static SHADER: Shader = Shader::new(
                "restless.wgsl",
                "import afterimage::point::Frame;
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> result: vec4f;
@group(0) @binding(2) var<uniform> frame: Frame;
@compute @workgroup_size(1)
fn restless() {
    let wanted = log2(max(textureLoad(source, vec2i(0), 0).g, 1e-4));
    let share = select(frame.dt * 3.0, 1.0, frame.reset == 1u);
    result = vec4f(mix(result.x, wanted, min(share, 0.5 + f32(frame.reset))), 0.0, 0.0, 1.0);
}",
            );
            let result = pass.output_value("result", BufferLife::Persistent);
            pass.compute(&SHADER, "restless").buffer("result", result).dispatch([1, 1, 1]);
        }
    }
}
