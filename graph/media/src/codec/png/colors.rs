//! Colors of a PNG by its chunks.

use afterimage_base::color::{Chromaticities, Decimal, Transfer};

use super::chunks::Chunks;
use crate::codec::cicp::Cicp;
use crate::codec::codes::Colors;
use crate::codec::{ColorSpace, icc};

/// The colors of `space`, or else what the chunks state. `channels` is 1 for gray and 3 for RGB.
pub(super) fn colors(chunks: &Chunks, channels: usize, space: Option<ColorSpace>) -> Colors {
    let mut notes = Vec::new();
    if chunks.is_animated {
        notes.push("it is animated; only its first picture is read".to_owned());
    }
    if chunks.has_gain_map {
        notes.push("its gain map is not applied: the picture is the one for SDR displays".to_owned());
    }
    let peak = chunks.mastering_peak.filter(|peak| (100.0..=10000.0).contains(peak));
    if let Some(space) = space {
        let mut colors = Colors::new(Some((space.primaries, space.transfer)), peak);
        colors.notes = notes;
        return colors;
    }
    let before = notes.len();
    let stated = stated(chunks, channels, peak, &mut notes);
    if stated.is_none() && notes.len() > before {
        notes.push("its colors are taken as sRGB".to_owned());
    }
    let mut colors = stated.unwrap_or_else(|| Colors::new(None, peak));
    colors.notes = notes;
    colors
}

/// The colors of the first chunk that is understood, in the order of PNG, third edition, 4.3. Chunks that are skipped
/// are noted.
fn stated(chunks: &Chunks, channels: usize, peak: Option<f64>, notes: &mut Vec<String>) -> Option<Colors> {
    match chunks.cicp.map(|cicp| cicp.map_err(str::to_owned).and_then(coding)) {
        Some(Ok((code, (primaries, transfer), is_full))) => {
            if code.is_video() {
                notes.push("its transfer function of video is read as that of sRGB, as browsers do".to_owned());
            }
            let mut colors = Colors::new(Some((primaries, transfer)), peak).stated_by("cICP");
            colors.is_narrow = !is_full;
            return Some(colors);
        }
        Some(Err(why)) => pass_over("cICP", &why, notes),
        None => {}
    }
    if let Some(profile) = &chunks.profile {
        match profile.as_ref().map_err(|why| *why).and_then(|profile| icc::read(profile, channels)) {
            Ok(profile) => return Some(Colors::of_profile(profile).stated_by("iCCP")),
            Err(why) => pass_over("iCCP", why, notes),
        }
    }
    let srgb = (Chromaticities::REC709, Transfer::Srgb);
    match chunks.srgb {
        Some(Ok(())) => return Some(Colors::new(Some(srgb), peak).stated_by("sRGB")),
        Some(Err(why)) => pass_over("sRGB", why, notes),
        None => {}
    }
    let primaries = understood("cHRM", chunks.chromaticities.map(|numbers| numbers.and_then(primaries)), notes);
    let gamma = understood("gAMA", chunks.gamma.map(|gamma| gamma.and_then(usable)), notes);
    let stated_by = if gamma.is_some() { "gAMA" } else { "cHRM" };
    (primaries.is_some() || gamma.is_some()).then(|| {
        let primaries = primaries.unwrap_or(Chromaticities::REC709);
        Colors::new(Some((primaries, transfer(gamma, &primaries))), peak).stated_by(stated_by)
    })
}

fn pass_over(name: &str, why: &str, notes: &mut Vec<String>) {
    notes.push(format!("its `{name}` chunk is passed over: {why}"));
}

fn understood<T>(name: &str, stated: Option<Result<T, &'static str>>, notes: &mut Vec<String>) -> Option<T> {
    stated.and_then(|stated| stated.map_err(|why| pass_over(name, why, notes)).ok())
}

/// The code points of `cICP`, what they mean, and whether codes have the full range.
fn coding([primaries, transfer, matrix, range]: [u8; 4]) -> Result<(Cicp, (Chromaticities, Transfer), bool), String> {
    let code = Cicp { primaries, transfer };
    let meaning = code.meaning().filter(|_| matrix == 0 && range <= 1);
    let unknown = || format!("its coding {primaries}, {transfer}, {matrix}, {range} is not known");
    meaning.map(|meaning| (code, meaning, range == 1)).ok_or_else(unknown)
}

fn usable(gamma: f64) -> Result<f64, &'static str> {
    if (0.01..=10.0).contains(&gamma) { Ok(gamma) } else { Err("it is no usable exponent") }
}

/// With the primaries of sRGB, or none, 0.45455 stands for sRGB, whose curve it approximates.
fn transfer(gamma: Option<f64>, primaries: &Chromaticities) -> Transfer {
    const SRGB_LIKE: f64 = 0.45455;
    let is_srgb = primaries.close_to(&Chromaticities::REC709, 1e-3);
    match gamma.filter(|gamma| !(is_srgb && (gamma - SRGB_LIKE).abs() <= 0.001)) {
        Some(1.0) => Transfer::Linear,
        Some(gamma) => Transfer::Gamma(Decimal::new(1.0 / gamma)),
        None => Transfer::Srgb,
    }
}

/// The chunk has white first, then red, green and blue.
fn primaries([white_x, white_y, colors @ ..]: [f64; 8]) -> Result<Chromaticities, &'static str> {
    let [rx, ry, gx, gy, bx, by] = colors;
    Chromaticities::from_numbers([rx, ry, gx, gy, bx, by, white_x, white_y]).ok_or("it describes no color space")
}
