//! Attributes of EXR files about colors, besides `chromaticities`.

use afterimage_base::color::{Chromaticities, Decimal, Transfer, Xy};
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::{Header, LayerAttributes};

use super::text;
use crate::codec::chromaticities::CIE_XYZ;

/// Set by ACES containers (SMPTE ST 2065-4), whose pixels are ACES2065-1.
const ACES_FLAG: &str = "acesImageContainerFlag";

/// The name of a color space, from the Color Interop Forum's list.
const INTEROP_ID: &str = "colorInteropID";

const ADOBE_RGB: Chromaticities =
    Chromaticities { red: Xy::new(0.64, 0.33), green: Xy::new(0.21, 0.71), ..Chromaticities::REC709 };
const G18: Transfer = Transfer::Gamma(Decimal::new(1.8));
const G22: Transfer = Transfer::Gamma(Decimal::new(2.2));
const G24: Transfer = Transfer::Gamma(Decimal::new(2.4));
const G26: Transfer = Transfer::Gamma(Decimal::new(2.6));

/// The names of color spaces (Color Interop Forum, "Color Space Encodings for Texture Assets and CG Rendering" and
/// "Display Color Space IDs"), and those of OpenImageIO for display-linear color and for `g24_rec709_scene`. `data`
/// and `unknown` name none; `g26_xyzd65_display` has a scale that no other has. The linear ones of scenes come first.
const SPACES: [(&str, Chromaticities, Transfer); 29] = [
    ("lin_rec709_scene", Chromaticities::REC709, Transfer::Linear),
    ("lin_p3d65_scene", Chromaticities::DISPLAY_P3, Transfer::Linear),
    ("lin_rec2020_scene", Chromaticities::REC2020, Transfer::Linear),
    ("lin_ap1_scene", Chromaticities::ACES_CG, Transfer::Linear),
    ("lin_ap0_scene", Chromaticities::ACES_AP0, Transfer::Linear),
    ("lin_adobergb_scene", ADOBE_RGB, Transfer::Linear),
    ("lin_ciexyzd65_scene", CIE_XYZ, Transfer::Linear),
    ("srgb_rec709_scene", Chromaticities::REC709, Transfer::Srgb),
    ("g24_rec709_scene", Chromaticities::REC709, G24),
    ("g22_rec709_scene", Chromaticities::REC709, G22),
    ("g18_rec709_scene", Chromaticities::REC709, G18),
    ("srgb_ap1_scene", Chromaticities::ACES_CG, Transfer::Srgb),
    ("g22_ap1_scene", Chromaticities::ACES_CG, G22),
    ("srgb_p3d65_scene", Chromaticities::DISPLAY_P3, Transfer::Srgb),
    ("g22_adobergb_scene", ADOBE_RGB, G22),
    ("lin_rec709_display", Chromaticities::REC709, Transfer::Linear),
    ("lin_p3d65_display", Chromaticities::DISPLAY_P3, Transfer::Linear),
    ("lin_rec2020_display", Chromaticities::REC2020, Transfer::Linear),
    ("srgb_rec709_display", Chromaticities::REC709, Transfer::Srgb),
    ("g24_rec709_display", Chromaticities::REC709, G24),
    ("g22_rec709_display", Chromaticities::REC709, G22),
    ("srgb_p3d65_display", Chromaticities::DISPLAY_P3, Transfer::Srgb),
    ("srgbx_p3d65_display", Chromaticities::DISPLAY_P3, Transfer::Srgb),
    ("g22_adobergb_display", ADOBE_RGB, G22),
    ("g26_p3d65_display", Chromaticities::DISPLAY_P3, G26),
    ("pq_p3d65_display", Chromaticities::DISPLAY_P3, Transfer::Pq),
    ("pq_rec2020_display", Chromaticities::REC2020, Transfer::Pq),
    ("pq_xyzd65_display", CIE_XYZ, Transfer::Pq),
    ("hlg_rec2020_display", Chromaticities::REC2020, Transfer::Hlg),
];

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Interop {
    Space(Chromaticities, Transfer),
    /// The numbers are no colors.
    Data,
    /// A name that is not known, or that no name is known.
    Unknown(String),
}

/// The statement of the attribute `colorInteropID` of a part.
pub(super) fn interop(header: &Header) -> Option<Interop> {
    let Some(AttributeValue::Text(id)) = attribute(header, INTEROP_ID) else { return None };
    let id = text(id);
    let space = SPACES.iter().find(|(known, ..)| known.eq_ignore_ascii_case(&id));
    Some(match space {
        Some((_, primaries, transfer)) => Interop::Space(*primaries, *transfer),
        None if id.eq_ignore_ascii_case("data") => Interop::Data,
        None => Interop::Unknown(id),
    })
}

/// True if the numbers of a part are stated to be no colors.
pub(super) fn is_data(header: &Header) -> bool {
    interop(header) == Some(Interop::Data)
}

/// The colors that the file states by a name, and the attribute that has it.
pub(super) fn named_colors(header: &Header) -> Option<(Chromaticities, Transfer, &'static str)> {
    if let Some(Interop::Space(primaries, transfer)) = interop(header) {
        return Some((primaries, transfer, INTEROP_ID));
    }
    let is_aces = matches!(attribute(header, ACES_FLAG), Some(AttributeValue::I32(1)));
    is_aces.then_some((Chromaticities::ACES_AP0, Transfer::Linear, ACES_FLAG))
}

fn attribute<'a>(header: &'a Header, name: &str) -> Option<&'a AttributeValue> {
    let name = Text::from(name);
    header.own_attributes.other.get(&name).or_else(|| header.shared_attributes.other.get(&name))
}

/// Names the primaries of scene-linear color: `colorInteropID`, and `acesImageContainerFlag` for ACES2065-1 in a file
/// that `is_plain`.
pub(super) fn name_primaries(layer: &mut LayerAttributes, primaries: &Chromaticities, is_plain: bool) {
    let mut linear = SPACES.iter().take_while(|(.., transfer)| *transfer == Transfer::Linear);
    if let Some((id, ..)) = linear.find(|(_, known, _)| known == primaries) {
        layer.other.insert(Text::from(INTEROP_ID), AttributeValue::Text(Text::from(*id)));
    }
    if *primaries == Chromaticities::ACES_AP0 && is_plain {
        layer.other.insert(Text::from(ACES_FLAG), AttributeValue::I32(1));
    }
}

/// True if an attribute is of Cryptomatte: it belongs to channels with the numbers of objects.
pub(super) fn is_cryptomatte(name: &str) -> bool {
    name.starts_with("cryptomatte/")
}

/// The names of the Cryptomatte layers of a part.
pub(super) fn cryptomattes(header: &Header) -> Vec<String> {
    let named = header.own_attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(layer) => Some((text(name), text(layer))),
        _ => None,
    });
    let named = named.filter(|(name, _)| is_cryptomatte(name) && name.ends_with("/name"));
    named.map(|(_, layer)| layer).collect()
}

/// True if an attribute describes the pixels or the channels of the file that it was read from. A rendered picture has
/// other ones, so the attribute must not be copied.
pub(super) fn describes_old_pixels(name: &Text) -> bool {
    let name = text(name);
    name == ACES_FLAG || name == INTEROP_ID || is_cryptomatte(&name)
}
