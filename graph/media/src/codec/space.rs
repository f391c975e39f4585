//! Color spaces with names, for files that state none and for files that are to have another than Rec.709.

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};

/// A color space that people and files call by a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColorSpace {
    /// The name: `ACEScg`.
    pub name: &'static str,
    /// The primaries and the white.
    pub primaries: Chromaticities,
    /// The transfer function; `Linear` for the spaces of EXR files.
    pub transfer: Transfer,
}

impl ColorSpace {
    /// All spaces. The linear ones come first.
    pub const ALL: [Self; 9] = [
        Self::linear("Rec709", Chromaticities::REC709),
        Self::linear("P3", Chromaticities::DISPLAY_P3),
        Self::linear("Rec2020", Chromaticities::REC2020),
        Self::linear("ACEScg", Chromaticities::ACES_CG),
        Self::linear("ACES2065-1", Chromaticities::ACES_AP0),
        Self::encoded("sRGB", Chromaticities::REC709, Transfer::Srgb),
        Self::encoded("DisplayP3", Chromaticities::DISPLAY_P3, Transfer::Srgb),
        Self::encoded("Rec2100-PQ", Chromaticities::REC2020, Transfer::Pq),
        Self::encoded("Rec2100-HLG", Chromaticities::REC2020, Transfer::Hlg),
    ];

    const fn linear(name: &'static str, primaries: Chromaticities) -> Self {
        Self { name, primaries, transfer: Transfer::Linear }
    }

    const fn encoded(name: &'static str, primaries: Chromaticities, transfer: Transfer) -> Self {
        Self { name, primaries, transfer }
    }

    /// The space of that name, in any case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|space| space.name.eq_ignore_ascii_case(name))
    }

    /// True if its values are linear, as those of an EXR.
    pub fn is_linear(&self) -> bool {
        self.transfer == Transfer::Linear
    }

    /// The colorimetry of its numbers.
    pub fn color(&self) -> Colorimetry {
        Colorimetry::new(self.primaries, self.transfer)
    }
}
