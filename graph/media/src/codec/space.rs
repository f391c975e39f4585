//! Color spaces with names, for files that state none and for files that are to have another than Rec.709.

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};

/// A color space that people and files call by a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColorSpace {
    /// The name: `ACEScg`.
    pub name: &'static str,
    /// The primaries and the white.
    pub primaries: Chromaticities,
    /// The function between light and numbers; `Linear` for the spaces of EXR files.
    pub transfer: Transfer,
    /// What `colorInteropID` calls scene light in this space (Color Interop Forum, "Color Space Encodings for Texture
    /// Assets and CG Rendering"); `None` for spaces of which an EXR has no numbers.
    interop_id: Option<&'static str>,
}

impl ColorSpace {
    /// All spaces. The linear ones come first.
    pub const ALL: [Self; 9] = [
        Self::linear("Rec709", Chromaticities::REC709, "lin_rec709_scene"),
        Self::linear("P3", Chromaticities::DISPLAY_P3, "lin_p3d65_scene"),
        Self::linear("Rec2020", Chromaticities::REC2020, "lin_rec2020_scene"),
        Self::linear("ACEScg", Chromaticities::ACES_CG, "lin_ap1_scene"),
        Self::linear("ACES2065-1", Chromaticities::ACES_AP0, "lin_ap0_scene"),
        Self::encoded("sRGB", Chromaticities::REC709, Transfer::Srgb),
        Self::encoded("DisplayP3", Chromaticities::DISPLAY_P3, Transfer::Srgb),
        Self::encoded("Rec2100-PQ", Chromaticities::REC2020, Transfer::Pq),
        Self::encoded("Rec2100-HLG", Chromaticities::REC2020, Transfer::Hlg),
    ];

    const fn linear(name: &'static str, primaries: Chromaticities, id: &'static str) -> Self {
        Self { name, primaries, transfer: Transfer::Linear, interop_id: Some(id) }
    }

    const fn encoded(name: &'static str, primaries: Chromaticities, transfer: Transfer) -> Self {
        Self { name, primaries, transfer, interop_id: None }
    }

    /// The space of that name, in any case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|space| space.name.eq_ignore_ascii_case(name))
    }

    /// Whether its numbers are proportional to light, as those of an EXR.
    pub fn is_linear(&self) -> bool {
        self.transfer == Transfer::Linear
    }

    /// What its numbers mean.
    pub fn color(&self) -> Colorimetry {
        Colorimetry::new(self.primaries, self.transfer)
    }

    /// The space that `colorInteropID` calls so.
    pub(crate) fn of_interop_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|space| space.interop_id == Some(id))
    }

    /// What `colorInteropID` calls linear scene light with these primaries.
    pub(crate) fn interop_id_of(primaries: &Chromaticities) -> Option<&'static str> {
        Self::ALL.into_iter().find(|space| space.primaries == *primaries)?.interop_id
    }
}
