//! Cdl: the color decision list of the American Society of Cinematographers.

use std::sync::Arc;

use afterimage_graph::prelude::*;

use afterimage_color::adaptation::luminance_weights;
use afterimage_color::lut::{ColorCorrection, LutError, parse_correction};

static SHADER: Shader = shader!("cdl");

node_kind! {
    /// An ASC color decision list: slope, offset, power and saturation, as cameras and grading programs exchange them.
    ///
    /// `(source * slope + offset)^power`, then `saturation` scales the distance from the gray of the same luminance.
    /// Values at or below 0 skip the power and may stay below 0, and values above 1 stay: the style `FwdNoClamp` of the
    /// Common LUT Format. With neutral values the node is skipped.
    ///
    /// A `.cdl`, `.cc` or `.ccc` file states the values instead of the parameters, which must be neutral then. Other
    /// styles, and lists in a row, are the matter of a `.clf` file in a `ColorLut`.
    pub struct Cdl {
        /// A `.cdl`, `.cc` or `.ccc` file with the values.
        pub file: FileValue = FileValue::default();
        /// The id of the color correction in the file. A file with one correction needs none.
        pub id: Arc<str> = Arc::from("");
        /// Factor of each channel.
        pub slope: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Added to each channel after the slope.
        pub offset: [f32; 3] = [0.0, 0.0, 0.0] => within(-4.0..=4.0), usually(-0.2..=0.2), neutral([0.0, 0.0, 0.0]);
        /// Exponent of each channel. Below 1 brightens midtones, above 1 darkens them.
        pub power: [f32; 3] = [1.0, 1.0, 1.0] => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]);
        /// Factor of the distance from gray. 0 is gray, 1 changes nothing.
        pub saturation: f32 = 1.0 => within(0.0..=4.0), usually(0.0..=2.0), neutral(1.0);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image, in the color state that the list was made for.").accepts(&[
            ColorState::Exposed,
            ColorState::DisplayLinear,
            ColorState::Encoded,
        ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The graded image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { non_negative: false, ..Invariants::OF_COLOR };
}

impl Node for Cdl {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.values().is_ok_and(|values| values == ColorCorrection::NEUTRAL)
    }

    fn verify(&self) -> Result<(), String> {
        if self.file.bytes.is_none() {
            return match &*self.id {
                "" => Ok(()),
                _ => Err("`id` needs a `file`".into()),
            };
        }
        if self.own() != ColorCorrection::NEUTRAL {
            return Err("`file` states slope, offset, power and saturation: remove these parameters".into());
        }
        let values = self.values().map_err(|error| format!("`{}`: {error}", self.file.path))?;
        within_domains(values).map_err(|why| format!("`{}`: {why}", self.file.path))
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let weights = luminance_weights(&pass.color("source").colorimetry.primaries);
        let mut kernel = pass.function(&SHADER, "cdl").set("luminance_weights", weights.to_array());
        if self.file.bytes.is_some() {
            // `verify` has rejected files that cannot be read.
            let ColorCorrection { slope, offset, power, saturation } =
                self.values().unwrap_or(ColorCorrection::NEUTRAL);
            let [slope, offset, power] = [slope, offset, power].map(|v| v.map(f64::from));
            kernel = kernel.set("slope", slope).set("offset", offset).set("power", power);
            kernel = kernel.set("saturation", saturation);
        }
        kernel.write("result", desc);
    }
}

impl Cdl {
    /// The values of the parameters.
    fn own(&self) -> ColorCorrection {
        let Self { slope, offset, power, saturation, .. } = *self;
        ColorCorrection { slope, offset, power, saturation }
    }

    /// The values of the file, or else of the parameters.
    fn values(&self) -> Result<ColorCorrection, LutError> {
        let Some(bytes) = &self.file.bytes else { return Ok(self.own()) };
        match std::str::from_utf8(bytes) {
            Ok(text) => parse_correction(text, &self.id),
            Err(_) => Err(LutError { line: 0, message: "the file is no text".into() }),
        }
    }
}

/// The values of a file have the domains of the parameters.
fn within_domains(values: ColorCorrection) -> Result<(), String> {
    let ColorCorrection { slope, offset, power, saturation } = values;
    let value = |name: &str| match name {
        "slope" => Some(slope.into_value()),
        "offset" => Some(offset.into_value()),
        "power" => Some(power.into_value()),
        "saturation" => Some(saturation.into_value()),
        _ => None,
    };
    Cdl::table().iter().try_for_each(|param| value(&param.name).map_or(Ok(()), |value| param.accepts(&value)))
}
