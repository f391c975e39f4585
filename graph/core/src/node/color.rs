//! Colorimetry of the images on wires, and changes of it by nodes.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer, Xy};
use afterimage_base::image::ColorState;

/// Color state of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageColor {
    /// Its color state.
    pub state: ColorState,
    /// Its primaries, transfer function, reference white and peak. Without a meaning for `Data` and `LogLuminance`.
    pub colorimetry: Colorimetry,
}

impl ImageColor {
    /// An image of that state about which nothing more is known: linear Rec.709, or sRGB if it is encoded.
    pub const fn of(state: ColorState) -> Self {
        let colorimetry = match state {
            ColorState::Encoded => Colorimetry::SRGB,
            _ => Colorimetry::linear(Chromaticities::REC709),
        };
        Self { state, colorimetry }
    }

    /// Returns whether it is a picture, and not data or a map of luminance.
    pub fn is_picture(&self) -> bool {
        !matches!(self.state, ColorState::Data | ColorState::LogLuminance)
    }

    /// Returns whether a sum of both images has a meaning: equal states, primaries and transfer functions.
    pub fn mixes_with(&self, other: &Self) -> bool {
        let same = |a: &Colorimetry, b: &Colorimetry| a.primaries == b.primaries && a.transfer == b.transfer;
        self.state == other.state && same(&self.colorimetry, &other.colorimetry)
    }

    /// Color of the result of a node that changes no colorimetry and declares `state`. A node that declares `Encoded`
    /// for light, and does not say how it encodes, is taken to encode for sRGB.
    pub(crate) fn kept_as(self, state: ColorState) -> Self {
        let result = Self { state, ..self };
        if state == self.state {
            return self;
        }
        match (result.is_picture() && self.is_picture(), state) {
            (false, _) => Self::of(state),
            (true, ColorState::Encoded) => result.with_transfer(Transfer::Srgb),
            (true, _) => result.with_transfer(Transfer::Linear),
        }
    }

    fn with_transfer(self, transfer: Transfer) -> Self {
        Self { colorimetry: Colorimetry { transfer, ..self.colorimetry }, ..self }
    }
}

/// Change of colorimetry by a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorChange {
    /// Nothing: the results have the colorimetry of the input whose color state they have, or else of the first image
    /// input.
    #[default]
    Keep,
    /// Scene light becomes light of a display: linear, in the primaries of the display that the images after it are
    /// encoded for; in Rec.709 if none is encoded. Where several are encoded, the widest primaries count.
    ToDisplay,
    /// Scene light becomes light of a display: linear, in these primaries, whatever follows.
    Display(Chromaticities),
    /// The results are encoded for a display or a file with this colorimetry.
    Encode(Colorimetry),
    /// Light of one display is fitted to another. The images before are for a display with these luminances of SDR
    /// white and of the peak, in cd/m2, and with the primaries of the display after it.
    Refit {
        /// The luminance of display-linear 1.
        white_nits: Decimal,
        /// The highest luminance.
        peak_nits: Decimal,
    },
    /// The image is adapted: this chromaticity is its white now.
    Adapt(Xy),
}
