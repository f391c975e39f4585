//! The kinds of this test. Each has a function in closed form twice: of a kernel at one pixel, for plans, and of whole
//! images, for graphs.

use afterimage_graph::prelude::*;

use super::reference::image::{Image, add_weighted};
use super::reference::sanitize::extended;
use crate::fusion::{SOURCE, kind, like_source};

static PIXELS: Shader = Shader::new(
    "pixels.wgsl",
    "fn dim(source: vec4f) -> vec4f { return 0.5 * source; }
    fn turn(source: vec4f) -> vec4f { return source.gbra; }
    fn add(source: vec4f, other: vec4f) -> vec4f { return source + 0.75 * other; }
    fn right(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel + vec2i(1, 0)); }
    fn below(source: texture_2d<f32>, at: Point, other: vec4f) -> vec4f {
        return other + 0.25 * texel(source, at.pixel + vec2i(0, 1));
    }
    fn raw(source: texture_2d<f32>, at: Point) -> vec4f { return 2.0 * textureLoad(source, at.pixel, 0); }
    fn filtered(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return tap(source, source_sampler, at.uv);
    }
    fn to_right(at: Point) -> vec4f { return vec4f(at.uv + vec2f(1.0, 0.0) / at.size, 0.0, 0.0); }
    fn to_below(at: Point) -> vec4f { return vec4f(at.uv + vec2f(0.0, 1.0) / at.size, 0.0, 0.0); }
    fn mirrored(at: Point) -> vec4f { return vec4f(1.0 - at.uv.x, at.uv.y, 0.0, 0.0); }",
);

const OTHER: Input = Input::image("other", "An image.");
const SWITCHED: Output = Output::image("result", OutputState::same("source"), "An image.").or_input("source");

kind!(Darker, "Half of each pixel.", [SOURCE], SWITCHED, |pass| {
    let desc = like_source(pass);
    pass.function(&PIXELS, "dim").write("result", desc);
});
kind!(Sum, "Adds three quarters of another image.", [SOURCE, OTHER], SWITCHED, |pass| {
    let desc = like_source(pass);
    pass.function(&PIXELS, "add").write("result", desc);
});
kind!(Right, "The pixel to the right.", [SOURCE], SWITCHED, |pass| {
    let desc = like_source(pass);
    pass.function(&PIXELS, "right").write("result", desc);
});
kind!(
    Below,
    "Adds a quarter of the pixel below to another image, which remains where it is off.",
    [SOURCE, OTHER],
    Output::image("result", OutputState::same("source"), "An image.").or_input("other"),
    |pass| {
        let desc = like_source(pass);
        pass.function(&PIXELS, "below").write("result", desc);
    }
);
kind!(Raw, "Twice each texel, which it loads itself.", [SOURCE], SWITCHED, |pass| {
    let desc = like_source(pass);
    pass.function(&PIXELS, "raw").write("result", desc);
});
kind!(Soft, "Down to half the size, and up again.", [SOURCE], SWITCHED, |pass| {
    let desc = like_source(pass);
    let half = pass.transient("half", desc.half());
    pass.function(&PIXELS, "filtered").write_to(half);
    pass.function(&PIXELS, "filtered").read("source", half).write("result", desc);
});
kind!(Slide, "A warp to the right.", [SOURCE], SWITCHED, |pass| {
    let (source, desc) = (pass.image("source"), like_source(pass));
    pass.warp(&PIXELS, "to_right", source).write("result", desc);
});
kind!(Mirror, "A warp that exchanges left and right.", [SOURCE], SWITCHED, |pass| {
    let (source, desc) = (pass.image("source"), like_source(pass));
    pass.warp(&PIXELS, "mirrored", source).write("result", desc);
});
kind!(Fringe, "A warp with a place for each channel.", [SOURCE], SWITCHED, |pass| {
    let (source, desc) = (pass.image("source"), like_source(pass));
    pass.warp_channels(&PIXELS, ["to_right", "mirrored", "to_below"], source).write("result", desc);
});

node_kind! {
    /// Two images of one.
    pub struct Pair {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] =
        &[SWITCHED, Output::image("turned", OutputState::same("source"), "An image.").or_input("source")];
}

impl Node for Pair {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = like_source(pass);
        pass.function(&PIXELS, "right").write("result", desc);
        pass.function(&PIXELS, "turn").write("turned", desc);
    }
}

pub const KINDS: &[NodeKind] = &[
    NodeKind::of::<Darker>(),
    NodeKind::of::<Sum>(),
    NodeKind::of::<Right>(),
    NodeKind::of::<Below>(),
    NodeKind::of::<Raw>(),
    NodeKind::of::<Soft>(),
    NodeKind::of::<Slide>(),
    NodeKind::of::<Mirror>(),
    NodeKind::of::<Fringe>(),
    NodeKind::of::<Pair>(),
];

/// What an argument of a kernel holds at a pixel.
pub enum Value<'a> {
    Number([f64; 4]),
    Texture(&'a Image),
    /// A place in texture coordinates.
    At([f64; 2]),
    Nothing,
}

/// Whether a kernel loads or filters texels without the library's `texel`, which sanitizes what it reads.
pub fn reads_texels_as_they_are(function: &str) -> bool {
    matches!(function, "raw" | "filtered" | "warp_tap")
}

/// The value of a kernel for a result with that width and height.
pub fn kernel(function: &str, args: &[Value<'_>], size: [f64; 2]) -> [f64; 4] {
    use Value::{At, Nothing, Number, Texture};
    let pixel = |at: &[f64; 2]| [0, 1].map(|axis| (at[axis] * size[axis]).floor() as i64);
    match (function, args) {
        ("copy", [Number(source)]) => *source,
        ("dim", [Number(source)]) => source.map(|number| 0.5 * number),
        ("turn", [Number([r, g, b, a])]) => [*g, *b, *r, *a],
        ("add", [Number(source), Number(other)]) => add_weighted(*source, *other, 0.75),
        ("right", [Texture(source), At(at)]) => source.texel(pixel(at)[0] + 1, pixel(at)[1]),
        ("below", [Texture(source), At(at), Number(other)]) => {
            add_weighted(*other, source.texel(pixel(at)[0], pixel(at)[1] + 1), 0.25)
        }
        ("raw", [Texture(source), At(at)]) => source.texel(pixel(at)[0], pixel(at)[1]).map(|number| 2.0 * number),
        ("filtered", [Texture(source), Nothing, At(at)]) => source.tap(*at),
        ("to_right", [At([u, v])]) => [u + 1.0 / size[0], *v, 0.0, 0.0],
        ("to_below", [At([u, v])]) => [*u, v + 1.0 / size[1], 0.0, 0.0],
        ("mirrored", [At([u, v])]) => [1.0 - u, *v, 0.0, 0.0],
        // All places are middles of texels: a filter would mix the neighbors with weights of nearly 0.
        ("warp_tap", [Texture(source), Nothing, At([u, v])]) => {
            source.texel((u * size[0]).floor() as i64, (v * size[1]).floor() as i64)
        }
        ("warp_channels", [Number(red), Number(green), Number(blue)]) => {
            let [r, g, b] = extended([red[0], green[1], blue[2]]);
            [r, g, b, green[3]]
        }
        _ => panic!("`{function}` is no kernel of this test, or has other arguments"),
    }
}

/// The images that a node of this kind gives.
pub fn node(kind: &str, source: &Image, other: Option<&Image>) -> Vec<Image> {
    let Image { width, height, .. } = *source;
    let moved = |change: &dyn Fn(i64, i64) -> [i64; 2]| {
        Image::new(width, height, |x, y| {
            let [x, y] = change(x as i64, y as i64);
            source.texel(x, y)
        })
    };
    let to_right = |x: i64, y: i64| [x + 1, y];
    let mirrored = |x: i64, y: i64| [width as i64 - 1 - x, y];
    let below = |x: i64, y: i64| [x, y + 1];
    let sum = |a: &Image, b: &Image, weight: f64| {
        let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| add_weighted(*a, *b, weight)).collect();
        Image { pixels, ..*source }
    };
    let one = match (kind, other) {
        ("Darker", _) => source.map(|pixel| pixel.map(|number| 0.5 * number)),
        ("Sum", Some(other)) => sum(source, other, 0.75),
        ("Right" | "Slide", _) => moved(&to_right),
        ("Below", Some(other)) => sum(other, &moved(&below), 0.25),
        ("Raw", _) => source.map(|pixel| pixel.map(|number| 2.0 * number)),
        ("Soft", _) => {
            let half = Image::from_uv(width / 2, height / 2, |uv| source.tap(uv));
            Image::from_uv(width, height, |uv| half.tap(uv))
        }
        ("Mirror", _) => moved(&mirrored),
        ("Fringe", _) => {
            let [red, green, blue] = [moved(&to_right), moved(&mirrored), moved(&below)];
            Image::new(width, height, |x, y| {
                let at = y * width + x;
                let [r, g, b] = extended([red.pixels[at][0], green.pixels[at][1], blue.pixels[at][2]]);
                [r, g, b, green.pixels[at][3]]
            })
        }
        ("Pair", _) => return vec![moved(&to_right), source.map(|[r, g, b, a]| [g, b, r, a])],
        _ => panic!("`{kind}` is no kind of this test, or lacks an image"),
    };
    vec![one]
}
