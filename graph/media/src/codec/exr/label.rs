//! What an EXR file states about its colors, besides `chromaticities`.

use afterimage_base::color::Chromaticities;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::{Header, LayerAttributes};

use crate::codec::ColorSpace;

/// Set by ACES containers (SMPTE ST 2065-4), whose pixels are ACES2065-1.
const ACES_FLAG: &str = "acesImageContainerFlag";

/// The name of a color space, from the Color Interop Forum's list.
const INTEROP_ID: &str = "colorInteropID";

/// The primaries that the file states by name, for files without `chromaticities`.
pub(super) fn named_primaries(header: &Header) -> Option<Chromaticities> {
    let is_aces = matches!(attribute(header, ACES_FLAG), Some(AttributeValue::I32(1)));
    interop_space(header).or(is_aces.then_some(Chromaticities::ACES_AP0))
}

/// The attribute that names them.
pub(super) fn naming_attribute(header: &Header) -> Option<&'static str> {
    named_primaries(header)?;
    Some(if interop_space(header).is_some() { INTEROP_ID } else { ACES_FLAG })
}

fn interop_space(header: &Header) -> Option<Chromaticities> {
    match attribute(header, INTEROP_ID) {
        // Files with other names are read as if they had none.
        Some(AttributeValue::Text(id)) => ColorSpace::of_interop_id(&id.to_string()).map(|space| space.primaries),
        _ => None,
    }
}

fn attribute<'a>(header: &'a Header, name: &str) -> Option<&'a AttributeValue> {
    let name = Text::from(name);
    header.own_attributes.other.get(&name).or_else(|| header.shared_attributes.other.get(&name))
}

/// Names the primaries of scene light: `colorInteropID`, and `acesImageContainerFlag` for ACES2065-1 in a file that
/// `is_plain`.
pub(super) fn name_primaries(layer: &mut LayerAttributes, primaries: &Chromaticities, is_plain: bool) {
    if let Some(id) = ColorSpace::interop_id_of(primaries) {
        layer.other.insert(Text::from(INTEROP_ID), AttributeValue::Text(Text::from(id)));
    }
    if *primaries == Chromaticities::ACES_AP0 && is_plain {
        layer.other.insert(Text::from(ACES_FLAG), AttributeValue::I32(1));
    }
}

/// Whether an attribute is of Cryptomatte: it belongs to channels with the numbers of objects.
pub(super) fn is_cryptomatte(name: &str) -> bool {
    name.starts_with("cryptomatte/")
}

/// The names of the Cryptomatte layers of a part.
pub(super) fn cryptomattes(header: &Header) -> Vec<String> {
    let named = header.own_attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(layer) => Some((name.to_string(), layer.to_string())),
        _ => None,
    });
    let named = named.filter(|(name, _)| is_cryptomatte(name) && name.ends_with("/name"));
    named.map(|(_, layer)| layer).collect()
}

/// Whether an attribute describes the pixels or the channels of the file that it was read from. A rendered picture has
/// other ones, so the attribute must not be copied.
pub(super) fn describes_old_pixels(name: &Text) -> bool {
    let name = name.to_string();
    name == ACES_FLAG || name == INTEROP_ID || is_cryptomatte(&name)
}
