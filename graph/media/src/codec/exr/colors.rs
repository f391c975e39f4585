//! The attributes that state the meaning of the numbers, read and written.

use afterimage_base::color::{Chromaticities, Colorimetry, Cones, Decimal, Transfer, Xy};
use exr::math::Vec2;
use exr::meta::attribute::Chromaticities as ExrChromaticities;
use exr::meta::header::Header;

use super::label::{Interop, interop, is_data, named_colors};
use super::select::Choice;
use super::unsupported;
use crate::codec::CodecError;

/// Primaries that differ by less count as equal.
const TOLERANCE: f64 = 1e-3;

/// The meaning of the numbers of the picture, if the file states it; `None` for gray and data, too, which need nothing.
pub(super) fn stated_colors(
    header: &Header,
    choice: &Choice,
) -> Result<Option<(Chromaticities, Transfer)>, CodecError> {
    if !choice.is_rgb() || is_data(header) {
        return Ok(None);
    }
    file_colors(header)
}

/// The primaries and the transfer function that the file states for all its color layers.
pub(super) fn file_colors(header: &Header) -> Result<Option<(Chromaticities, Transfer)>, CodecError> {
    let named = named_colors(header).map(|(primaries, transfer, _)| (primaries, transfer));
    let Some(attribute) = header.shared_attributes.chromaticities else { return Ok(named) };
    let primaries = from_attribute(&attribute).ok_or_else(|| {
        unsupported("its `chromaticities` attribute describes no color space")
            .hint("correct or remove that attribute; without it, Rec.709 is assumed")
    })?;
    Ok(Some((primaries, named.map_or(Transfer::Linear, |(_, transfer)| transfer))))
}

/// The sentence about a color space that is not known, or stated in two ways.
pub(super) fn color_note(header: &Header, choice: &Choice) -> Option<String> {
    let stated = header.shared_attributes.chromaticities.as_ref().and_then(from_attribute);
    let read = if stated.is_some() { "`chromaticities`" } else { "Rec.709" };
    match interop(header).filter(|_| choice.is_rgb())? {
        Interop::Data => Some("its `colorInteropID` is `data`: the numbers are read as they are".to_owned()),
        Interop::Unknown(id) => Some(format!(
            "its `colorInteropID` is `{id}`, which is not known: the colors are read as linear light of {read}"
        )),
        Interop::Space(named, _) => stated.filter(|stated| !stated.close_to(&named, TOLERANCE)).map(|_| {
            "its `chromaticities` and its `colorInteropID` contradict each other: the former are believed".to_owned()
        }),
    }
}

fn from_attribute(attribute: &ExrChromaticities) -> Option<Chromaticities> {
    let points = [attribute.red, attribute.green, attribute.blue, attribute.white];
    let numbers: Vec<f64> = points.iter().flat_map(|xy| [xy.0.into(), xy.1.into()]).collect();
    Chromaticities::from_numbers(numbers.try_into().expect("four points have eight numbers"))
}

pub(super) fn to_attribute(primaries: &Chromaticities) -> ExrChromaticities {
    let [red, green, blue, white] = primaries.points().map(point);
    ExrChromaticities { red, green, blue, white }
}

pub(super) fn point(xy: Xy) -> Vec2<f32> {
    Vec2(xy.x.get() as f32, xy.y.get() as f32)
}

/// `whiteLuminance` and `adoptedNeutral` are stated only with the primaries that they belong to.
pub(super) fn stated_color(header: &Header, color: Colorimetry) -> Colorimetry {
    let own = &header.own_attributes;
    let white_nits = own.white_luminance.filter(|nits| (1e-6..=1e9).contains(nits)).map(Decimal::from);
    let adopted_white = own.adopted_neutral.map(|xy| Xy::from([xy.0, xy.1]));
    Colorimetry { white_nits: white_nits.or(color.white_nits), adopted_white, ..color }
}

/// A chromaticity after the adaptation from one white to another, which the pixels undergo, too.
pub(super) fn adapted(xy: Vec2<f32>, from: Xy, to: Xy) -> Option<Vec2<f32>> {
    if from == to {
        return Some(xy);
    }
    let adapt = Cones::Bradford.adaptation(from.to_xyz(), to.to_xyz());
    let at = adapt * Xy::from([xy.0, xy.1]).to_xyz();
    let sum = at.element_sum();
    at.is_finite().then(|| point(Xy::new(at.x / sum, at.y / sum)))
}
