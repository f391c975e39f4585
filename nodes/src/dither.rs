//! Dither: quantization with noise against banding.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("dither");

/// Half floats keep codes apart up to this many bits, also on devices that round toward 0.
const HALF_BITS: u32 = 10;

node_kind! {
    /// Quantizes an encoded image to the codes of a file or a display, with noise against banding.
    ///
    /// The noise has a triangular distribution, so neither the mean nor the variance of the error depends on the image.
    /// It fades within half a code of black and white, so that solid black and white stay solid. The results are exact
    /// codes: any later rounding keeps them. They are stored in half floats up to 10 bits and in 32-bit floats beyond,
    /// unless `format` says otherwise. Use it as the last node. Do not use it where the target stores floats. Equal
    /// seeds and frames give equal noise on every device.
    ///
    /// `bits` is for a host that shows or stores the image itself. The program `afterimage` quantizes once, when it
    /// writes the file, with this noise and at the depth of the file.
    pub struct Dither {
        /// Bits per channel of the file or the display.
        pub bits: u32 = 8 => within(1.0..=12.0), usually(8.0..=10.0), unit("bits");
        /// Whether each frame has different noise: less visible in motion, but harder to compress as video.
        pub animate: bool = false;
        /// Selects the noise.
        pub seed: u32 = 0 => within(0.0..=65535.0), live();
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The encoded image.").accepts(&[ColorState::Encoded])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image in exact codes, 0 to 1.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl Node for Dither {
    fn verify_format(&self, format: Format) -> Result<(), String> {
        let bits = self.bits;
        let keeps = match format {
            // Codes of fewer bits lie on codes of more if their largest divides the other: 255, or 1023.
            Format::Rgba8Unorm => matches!(bits, 1 | 2 | 4 | 8),
            Format::Rgb10a2Unorm => matches!(bits, 1 | 2 | 5 | 10),
            // Blue has five bits of mantissa.
            Format::Rg11b10Ufloat => bits <= 6,
            Format::R16Float | Format::Rg16Float | Format::Rgba16Float => bits <= HALF_BITS,
            Format::R32Float | Format::Rgba32Float | Format::Depth16Unorm | Format::Depth32Float => true,
        };
        if keeps { Ok(()) } else { Err(format!("`{}` does not keep codes of {bits} bits", format.name())) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let desc = if self.bits > HALF_BITS { desc.format(Format::Rgba32Float) } else { desc };
        let kernel = if self.animate { "dither_animated" } else { "dither" };
        pass.function(&SHADER, kernel).write("result", desc);
    }
}
