//! Outputs that hold linear light: what the pipeline has encoded for a display is decoded again.

use afterimage_base::color::{Colorimetry, Transfer};
use afterimage_base::image::{ColorState, ImageDesc};
use afterimage_graph::node::{Arg, ImageColor, ImageId, KernelCall, Pass};
use afterimage_wgsl::{Shader, UniformValue};

/// The inverse of sRGB, and that of a power.
static DECODE: Shader = Shader::new(
    "decode.wgsl",
    "import afterimage::transfer::srgb_decode;
struct Decode { gamma: f32 }
fn decode_srgb(source: vec4f) -> vec4f {
    return vec4f(srgb_decode(source.r), srgb_decode(source.g), srgb_decode(source.b), source.a);
}
fn decode_gamma(source: vec4f, params: Decode) -> vec4f {
    return vec4f(pow(max(source.rgb, vec3f()), vec3f(params.gamma)), source.a);
}",
);

/// The transfer function that turns an encoded image into linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Decoding {
    Srgb,
    Gamma(f32),
}

impl Decoding {
    /// The decoding of an image; `None` if it is linear light already, or encoded for an HDR display.
    pub(crate) fn of(color: ImageColor) -> Option<Self> {
        match color.colorimetry.transfer {
            Transfer::Srgb if color.state == ColorState::Encoded => Some(Self::Srgb),
            Transfer::Gamma(gamma) if color.state == ColorState::Encoded => Some(Self::Gamma(gamma.get() as f32)),
            _ => None,
        }
    }

    /// The meaning of the decoded image.
    pub(crate) fn decoded(color: ImageColor) -> ImageColor {
        let colorimetry = Colorimetry { transfer: Transfer::Linear, ..color.colorimetry };
        ImageColor { state: ColorState::DisplayLinear, colorimetry }
    }

    /// The pass that decodes the pixels of an image. It fuses with the pass that makes them.
    pub(crate) fn pass(self, output: &str, source: ImageId, result: ImageId) -> Pass {
        let source = ("source", Arg::Pixel(source));
        let kernel = match self {
            Self::Srgb => KernelCall::function(output, &DECODE, "decode_srgb", &[source]),
            Self::Gamma(gamma) => {
                let reflection = DECODE.reflect().expect("the shader is valid");
                let uniform = reflection.pack("Decode", &[("gamma", UniformValue::Floats(vec![gamma]))]);
                let args = [source, ("params", Arg::Params)];
                let call = KernelCall::function(output, &DECODE, "decode_gamma", &args);
                KernelCall { uniform: uniform.expect("the struct has one number"), ..call }
            }
        };
        Pass::of_functions(vec![output.to_owned()], "decode".into(), vec![kernel], result)
    }
}

/// The description of the decoded image. Codes of eight bits are further apart than half floats in linear light.
pub(crate) fn decoded_desc(encoded: ImageDesc) -> ImageDesc {
    encoded.format(crate::builder::float_format(encoded.format))
}

#[cfg(test)]
mod tests {
    use afterimage_base::color::Chromaticities;

    use super::*;

    #[test]
    fn only_what_is_encoded_for_an_sdr_display_is_decoded() {
        let gamma = Transfer::Gamma(2.2.into());
        for (transfer, decoding) in [
            (Transfer::Linear, None),
            (Transfer::Srgb, Some(Decoding::Srgb)),
            (gamma, Some(Decoding::Gamma(2.2))),
            (Transfer::Pq, None),
            (Transfer::Hlg, None),
        ] {
            for state in ColorState::ALL {
                let colorimetry = Colorimetry::new(Chromaticities::REC709, transfer);
                let expected = decoding.filter(|_| state == ColorState::Encoded);
                assert_eq!(Decoding::of(ImageColor { state, colorimetry }), expected, "{transfer:?} {state:?}");
            }
        }
    }
}
