//! What the chunks of a PNG state about its colors.

use afterimage_base::color::{Chromaticities, Decimal, Transfer};
use png::Info;

use crate::codec::cicp::Cicp;
use crate::codec::codes::Colors;
use crate::codec::{CodecError, ColorSpace, ErrorKind, icc};

/// The colors of `space`, or else what the chunks state.
pub(super) fn colors(info: &Info<'_>, space: Option<ColorSpace>) -> Result<Colors, CodecError> {
    let mut notes = Vec::new();
    let stated = match space {
        Some(space) => Some((space.primaries, space.transfer)),
        None => stated(info, &mut notes)?,
    };
    Ok(Colors::new(stated, mastering_peak(info), notes))
}

/// The stated peak of the mastering display, in cd/m2.
fn mastering_peak(info: &Info<'_>) -> Option<f64> {
    let peak = info.mastering_display_color_volume.map(|volume| f64::from(volume.max_luminance) / 1e4);
    peak.filter(|peak| (100.0..=10000.0).contains(peak))
}

/// What the chunk with the highest priority states (PNG, third edition, 4.3).
fn stated(info: &Info<'_>, notes: &mut Vec<String>) -> Result<Option<(Chromaticities, Transfer)>, CodecError> {
    if let Some(cicp) = info.coding_independent_code_points {
        let code = Cicp { primaries: cicp.color_primaries, transfer: cicp.transfer_function };
        let is_full = cicp.matrix_coefficients == 0 && cicp.is_video_full_range_image;
        return code.meaning().filter(|_| is_full).map(Some).ok_or_else(unknown_coding);
    }
    let srgb = (Chromaticities::REC709, Transfer::Srgb);
    if let Some(profile) = &info.icc_profile {
        return Ok(icc::read_or_note(profile, notes));
    }
    if info.srgb.is_some() {
        return Ok(Some(srgb));
    }
    if info.gama_chunk.is_none() && info.chrm_chunk.is_none() {
        return Ok(None);
    }
    let primaries = primaries(info)?;
    Ok(Some((primaries, gamma(info, &primaries))))
}

fn unknown_coding() -> CodecError {
    let what = "the `cICP` chunk of this PNG names a color coding that is not read";
    CodecError::new(ErrorKind::Unsupported, what).hint("save it again as sRGB, or as linear EXR")
}

/// With the primaries of sRGB, or none, 0.45455 stands for sRGB, whose curve it approximates.
fn gamma(info: &Info<'_>, primaries: &Chromaticities) -> Transfer {
    const SRGB_LIKE: f64 = 0.45455;
    let is_srgb = primaries.close_to(&Chromaticities::REC709, 1e-3);
    let gamma = info.gama_chunk.map(|gamma| f64::from(gamma.into_scaled()) / 1e5);
    match gamma.filter(|g| (0.01..=10.0).contains(g) && !(is_srgb && (g - SRGB_LIKE).abs() <= 0.001)) {
        Some(1.0) => Transfer::Linear,
        Some(gamma) => Transfer::Gamma(Decimal::new(1.0 / gamma)),
        None => Transfer::Srgb,
    }
}

fn primaries(info: &Info<'_>) -> Result<Chromaticities, CodecError> {
    let Some(stated) = info.chrm_chunk else { return Ok(Chromaticities::REC709) };
    let points = [stated.red, stated.green, stated.blue, stated.white];
    let numbers = points.map(|(x, y)| [x, y].map(|number| f64::from(number.into_scaled()) / 1e5));
    let space =
        Chromaticities::from_numbers(numbers.as_flattened().try_into().expect("four points have eight numbers"));
    space.ok_or_else(|| CodecError::broken("its `cHRM` chunk describes no color space"))
}
