//! Ports of the kinds that smooth the edges of a finished image.

use afterimage_graph::prelude::*;

pub(crate) const INPUTS: &[Input] = &[Input::image("source", "The image, after the tone curve.")
    .accepts(&[ColorState::DisplayLinear, ColorState::Encoded])];

pub(crate) const OUTPUTS: &[Output] =
    &[Output::image("result", OutputState::same("source"), "The image with smooth edges.").or_input("source")];

/// True for linear color, false for encoded.
pub(crate) fn is_linear(pass: &Recorder<'_>) -> bool {
    pass.color("source").state == ColorState::DisplayLinear
}
