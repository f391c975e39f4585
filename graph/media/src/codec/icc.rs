//! ICC profiles: those of RGB spaces are written where a file has no other exact label; those of gray, RGB and CMYK
//! are read.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use afterimage_base::color::{Chromaticities, Colorimetry, Cones, Decimal, Transfer, Xy};
use glam::{DMat3, DVec3};
use moxcms::{
    ColorProfile, DataColorSpace, Layout, RenderingIntent, ToneReprCurve, TransformF32Executor, TransformOptions,
};

use crate::codec::cicp::Cicp;
use crate::codec::{CodecError, catch_panic};

/// The white of the profile connection space: D50 as ICC.1 rounds it.
const PCS_WHITE: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);

/// Year, month, day, hour, minute and second of all profiles, so that equal colorimetry gives equal bytes.
const DATE: [u16; 6] = [2026, 1, 1, 0, 0, 0];
const HEADER: usize = 128;
/// Of ICC.1:2022.
const VERSION: [u8; 4] = [4, 0x40, 0, 0];

/// Largest difference between a curve and a transfer function that counts as equal, in linear values. Tables of 8-bit
/// profiles differ by less.
const SAME_CURVE: f64 = 1e-3;

/// The primaries that a profile is recognized to have.
const NAMED: [Chromaticities; 5] = [
    Chromaticities::REC709,
    Chromaticities::DISPLAY_P3,
    Chromaticities::REC2020,
    Chromaticities::ACES_CG,
    Chromaticities::ACES_AP0,
];

/// Largest difference of coordinates between primaries that count as equal.
const SAME_PRIMARIES: f64 = 1e-3;

/// A display profile with a matrix and a curve (ICC.1:2022, 8.4.3); `None` for `Pq` and `Hlg`, which have no such form.
/// Equal colorimetry gives equal bytes, whatever the clock says.
pub(crate) fn write(color: &Colorimetry) -> Option<Vec<u8>> {
    let curve = match color.transfer {
        Transfer::Linear => [&b"curv"[..], &[0; 8]].concat(),
        Transfer::Srgb => parametric(3, &[2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045]),
        Transfer::Gamma(exponent) => parametric(0, &[exponent.get() as f32]),
        Transfer::Pq | Transfer::Hlg => return None,
    };
    let adapt = adaptation(&color.primaries);
    let colorants = adapt * color.primaries.to_xyz();
    let [red, green, blue] = [0, 1, 2].map(|column| fixed(b"XYZ ", &colorants.col(column).to_array()));
    let chad = fixed(b"sf32", adapt.transpose().to_cols_array().as_slice());
    Some(encoded(&[
        (b"rXYZ", red),
        (b"gXYZ", green),
        (b"bXYZ", blue),
        (b"chad", chad),
        (b"rTRC", curve.clone()),
        (b"gTRC", curve.clone()),
        (b"bTRC", curve),
        (b"wtpt", fixed(b"XYZ ", &PCS_WHITE.to_array())),
        (b"desc", text(&description(color))),
        (b"cprt", text("No copyright, use freely")),
    ]))
}

/// From the white of these primaries to that of profiles.
fn adaptation(primaries: &Chromaticities) -> DMat3 {
    Cones::Bradford.adaptation(primaries.white.to_xyz(), PCS_WHITE)
}

/// A header (ICC.1:2022, 7.2), the table of the tags, and the tags. Readers such as libpng warn of a tag that does not
/// begin at a multiple of 4 (7.3.1), and refuse a profile of another length (7.2.1).
fn encoded(tags: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut table = Vec::from(word(tags.len()));
    let mut data = Vec::new();
    for (name, tag) in tags {
        let at = HEADER + 4 + 12 * tags.len() + data.len();
        table.extend([**name, word(at), word(tag.len())].concat());
        data.extend(tag);
        data.resize(data.len().next_multiple_of(4), 0);
    }
    let mut profile = vec![0; HEADER];
    profile[..4].copy_from_slice(&word(HEADER + table.len() + data.len()));
    profile[8..12].copy_from_slice(&VERSION);
    profile[12..24].copy_from_slice(b"mntrRGB XYZ ");
    for (at, number) in DATE.iter().enumerate() {
        profile[24 + 2 * at..26 + 2 * at].copy_from_slice(&number.to_be_bytes());
    }
    profile[36..40].copy_from_slice(b"acsp");
    profile[68..80].copy_from_slice(&numbers(&PCS_WHITE.to_array()));
    [profile, table, data].concat()
}

fn word(number: usize) -> [u8; 4] {
    u32::try_from(number).expect("a profile with a matrix has less than a kilobyte").to_be_bytes()
}

/// A tag of numbers with 16 bits behind the point.
fn fixed(ty: &[u8; 4], values: &[f64]) -> Vec<u8> {
    [&ty[..], &[0; 4], &numbers(values)].concat()
}

fn numbers(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| ((value * 65536.0 + 0.5).floor() as i32).to_be_bytes()).collect()
}

/// A curve (ICC.1:2022, 10.18) of this form.
fn parametric(form: u8, values: &[f32]) -> Vec<u8> {
    let values: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
    [&b"para\0\0\0\0\0"[..], &[form, 0, 0], &numbers(&values)].concat()
}

fn description(color: &Colorimetry) -> String {
    let transfer = match color.transfer {
        Transfer::Gamma(exponent) => format!("gamma {exponent}"),
        other => format!("{other:?}"),
    };
    format!("{}, {transfer}", color.primaries.name().unwrap_or("RGB"))
}

/// A text in one language (ICC.1:2022, 10.15).
fn text(text: &str) -> Vec<u8> {
    let letters: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    [&b"mluc\0\0\0\0\0\0\0\x01\0\0\0\x0cenUS"[..], &word(letters.len()), &word(28), &letters].concat()
}

/// The time. Browsers have no such clock, and moxcms asks none there.
fn now() -> SystemTime {
    if cfg!(target_family = "wasm") { UNIX_EPOCH } else { SystemTime::now() }
}

/// The parsed profile; `None` if it is not valid, or if the clock is before 1970, as on a board without a battery:
/// there `ColorDateTime::now` of moxcms 0.8 calls itself without end, and every profile is made with it.
fn parsed(bytes: &[u8], now: SystemTime) -> Option<ColorProfile> {
    if now < UNIX_EPOCH { None } else { ColorProfile::new_from_slice(bytes).ok() }
}

/// The error of a profile that cannot be parsed.
pub(crate) const UNREADABLE: &str = "it is damaged, or of a kind that is not known";

/// The meaning of a profile. The white of its space is D65, to which the profile's colors are adapted.
pub(crate) enum Profile {
    /// A matrix, or gray, with one known curve for all channels.
    Space(Chromaticities, Transfer),
    /// A matrix, or gray, with other curves.
    Curves(Chromaticities, Box<[Curve; 3]>),
    Tables(Tables),
}

/// The curve of a channel.
#[derive(Debug, Clone)]
pub(crate) struct Curve {
    curve: ToneReprCurve,
    /// True if it gives the lightness of CIELAB, as a gray profile with that connection space does.
    is_lightness: bool,
}

impl Curve {
    /// Light of a signal from 0 to 1.
    pub(crate) fn linear(&self, signal: f64) -> f64 {
        let value = value(&self.curve, signal.clamp(0.0, 1.0));
        if !self.is_lightness {
            return value;
        }
        // CIE 15:2018, 8.2.1.1.
        let root = (100.0 * value + 16.0) / 116.0;
        if root > 6.0 / 29.0 { root.powi(3) } else { (root - 4.0 / 29.0) * 108.0 / 841.0 }
    }

    /// True if it is that function.
    fn is(&self, transfer: Transfer) -> bool {
        let mut signals = (0..=256).map(|step| f64::from(step) / 256.0);
        signals.all(|signal| (self.linear(signal) - transfer.to_light(signal)).abs() <= SAME_CURVE)
    }

    /// True if it gives a number for each signal.
    fn is_defined(&self) -> bool {
        (0..=256).all(|step| self.linear(f64::from(step) / 256.0).is_finite())
    }
}

/// The tables of a profile, evaluated by moxcms.
pub(crate) struct Tables {
    transform: Arc<TransformF32Executor>,
    channels: usize,
}

impl Tables {
    /// The primaries of the result; no color has a negative component in them.
    pub(crate) const PRIMARIES: Chromaticities = Chromaticities::ACES_AP0;

    /// The curve of the numbers that moxcms makes. It rounds them to 16 bits, which would be coarse for linear color.
    const CURVE: Transfer = Transfer::Gamma(Decimal::new(2.2));

    fn new(profile: &ColorProfile, channels: usize) -> Option<Self> {
        let to = parsed(&write(&Colorimetry::new(Self::PRIMARIES, Self::CURVE))?, now())?;
        let layout = match channels {
            1 => Layout::Gray,
            3 => Layout::Rgb,
            _ => Layout::Rgba,
        };
        let rendering_intent = match profile.rendering_intent {
            RenderingIntent::AbsoluteColorimetric => RenderingIntent::RelativeColorimetric,
            intent => intent,
        };
        let options = TransformOptions {
            rendering_intent,
            allow_use_cicp_transfer: false,
            prefer_fixed_point: false,
            ..TransformOptions::default()
        };
        let transform = profile.create_transform_f32(layout, &to, Layout::Rgb, options).ok()?;
        Some(Self { transform, channels })
    }

    /// Signals of a pixel: 1, 3 or, for CMYK, 4.
    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// Writes the linear color of pixels, by their signals, to the first three of four channels.
    ///
    /// # Errors
    /// moxcms cannot evaluate the profile.
    pub(crate) fn linear(&self, signals: &[f32], out: &mut [f32]) -> Result<(), CodecError> {
        let mut rgb = vec![0.0; signals.len() / self.channels * 3];
        let failed = |_| CodecError::broken("its ICC profile cannot be evaluated");
        self.transform.transform(signals, &mut rgb).map_err(failed)?;
        for (pixel, rgb) in out.as_chunks_mut::<4>().0.iter_mut().zip(rgb.as_chunks::<3>().0) {
            pixel
                .iter_mut()
                .zip(rgb)
                .for_each(|(value, signal)| *value = Self::CURVE.to_light((*signal).into()) as f32);
        }
        Ok(())
    }
}

/// The meaning of a profile for a picture of that many color channels: 1, 3 or, for CMYK, 4.
///
/// # Errors
/// The reason why it cannot be applied.
pub(crate) fn read(bytes: &[u8], channels: usize) -> Result<Profile, &'static str> {
    // moxcms is not ours: a panic of it makes a profile unreadable, and not the picture.
    catch_panic(|| parse(bytes, channels)).unwrap_or(Err(UNREADABLE))
}

fn parse(bytes: &[u8], channels: usize) -> Result<Profile, &'static str> {
    let profile = parsed(bytes, now()).ok_or(UNREADABLE)?;
    let of_profile = match profile.color_space {
        DataColorSpace::Gray => 1,
        DataColorSpace::Rgb => 3,
        DataColorSpace::Cmyk => 4,
        _ => return Err("it is neither of gray, RGB nor CMYK"),
    };
    // Gray is a color of RGB, too.
    if of_profile != channels && (of_profile, channels) != (3, 1) {
        return Err("it is for another number of channels than the picture has");
    }
    let has_tables = profile.lut_a_to_b_perceptual.is_some()
        || profile.lut_a_to_b_colorimetric.is_some()
        || profile.lut_a_to_b_saturation.is_some();
    if let Some(space) = coded(&profile) {
        return Ok(space);
    }
    let curves = if of_profile == 1 {
        [&profile.gray_trc; 3]
    } else {
        [&profile.red_trc, &profile.green_trc, &profile.blue_trc]
    };
    if let (false, [Some(red), Some(green), Some(blue)], Some(primaries)) = (has_tables, curves, primaries(&profile)) {
        let is_lightness = profile.pcs == DataColorSpace::Lab;
        let curves = [red, green, blue].map(|curve| Curve { curve: curve.clone(), is_lightness });
        if let Some(transfer) = transfer(&curves[0]).filter(|known| curves.iter().all(|curve| curve.is(*known))) {
            return Ok(Profile::Space(primaries, transfer));
        }
        if curves.iter().all(Curve::is_defined) {
            return Ok(Profile::Curves(primaries, Box::new(curves)));
        }
        return Err("its curves are not defined for all codes");
    }
    let tables = Tables::new(&profile, of_profile).ok_or(UNREADABLE)?;
    // What fails for one pixel fails for all.
    tables.linear(&[0.5; 4][..of_profile], &mut [0.0; 4]).map_err(|_| UNREADABLE)?;
    Ok(Profile::Tables(tables))
}

/// The space that the code points of a profile state, if it is of HDR: its matrix and curves are for readers that do
/// not know them.
fn coded(profile: &ColorProfile) -> Option<Profile> {
    let cicp = profile.cicp.as_ref()?;
    let code = Cicp { primaries: cicp.color_primaries as u8, transfer: cicp.transfer_characteristics as u8 };
    let (primaries, transfer) = code.meaning().filter(|_| cicp.full_range)?;
    matches!(transfer, Transfer::Pq | Transfer::Hlg).then_some(Profile::Space(primaries, transfer))
}

/// The primaries of a matrix: those with a name whose profile has it, otherwise for D65; those of Rec.709 for gray.
fn primaries(profile: &ColorProfile) -> Option<Chromaticities> {
    match profile.color_space {
        DataColorSpace::Gray => return Some(Chromaticities::REC709),
        DataColorSpace::Rgb if profile.pcs == DataColorSpace::Xyz => {}
        _ => return None,
    }
    let colorants = [profile.red_colorant, profile.green_colorant, profile.blue_colorant].map(|at| [at.x, at.y, at.z]);
    let found = of_colorants(DMat3::from_cols_array_2d(&colorants))?;
    let named = NAMED.into_iter().find(|named| {
        // Profiles round their numbers.
        let own = of_colorants(adaptation(named) * named.to_xyz());
        own.is_some_and(|own| own.close_to(&found, SAME_PRIMARIES))
    });
    Some(named.unwrap_or(found))
}

/// The primaries for D65 that have these colorants.
fn of_colorants(colorants: DMat3) -> Option<Chromaticities> {
    let adapted = Cones::Bradford.adaptation(PCS_WHITE, Xy::D65.to_xyz()) * colorants;
    let mut numbers = [Xy::D65.to_vec(); 4].map(|xy| xy.to_array());
    for (column, xy) in numbers.iter_mut().take(3).enumerate() {
        let at = adapted.col(column);
        *xy = [at.x / at.element_sum(), at.y / at.element_sum()];
    }
    Chromaticities::from_numbers(numbers.as_flattened().try_into().expect("four points have eight numbers"))
}

fn transfer(curve: &Curve) -> Option<Transfer> {
    let power = match &curve.curve {
        ToneReprCurve::Lut(table) if table.len() == 1 => Some(f64::from(table[0]) / 256.0),
        // The nearest number of a parametric curve is 1/131072 away at most.
        ToneReprCurve::Parametric(numbers) => numbers.first().map(|power| {
            let (power, short) = (f64::from(*power), (f64::from(*power) * 100.0).round() / 100.0);
            if (power - short).abs() < 1e-5 { short } else { power }
        }),
        ToneReprCurve::Lut(_) => None,
    };
    let gamma = power.filter(|power| (0.1..=10.0).contains(power)).map(|power| Transfer::Gamma(power.into()));
    let known = [Some(Transfer::Linear), Some(Transfer::Srgb), gamma];
    known.into_iter().flatten().find(|known| curve.is(*known))
}

/// The curve's value (ICC.1:2022, 10.6 and 10.18). NaN for a form that is not defined.
fn value(curve: &ToneReprCurve, signal: f64) -> f64 {
    match curve {
        ToneReprCurve::Lut(table) => table_value(table, signal),
        ToneReprCurve::Parametric(numbers) => {
            let numbers: Vec<f64> = numbers.iter().map(|number| f64::from(*number)).collect();
            parametric_value(&numbers, signal)
        }
    }
}

fn table_value(table: &[u16], signal: f64) -> f64 {
    match table {
        [] => signal,
        [gamma] => signal.powf(f64::from(*gamma) / 256.0),
        table => {
            let at = signal * (table.len() - 1) as f64;
            let low = (at as usize).min(table.len() - 2);
            let [a, b] = [table[low], table[low + 1]].map(|value| f64::from(value) / 65535.0);
            a + (b - a) * (at - low as f64)
        }
    }
}

fn parametric_value(numbers: &[f64], x: f64) -> f64 {
    match *numbers {
        [g] => x.powf(g),
        [g, a, b] if x >= -b / a => (a * x + b).powf(g),
        [_, _, _] => 0.0,
        [g, a, b, c] if x >= -b / a => (a * x + b).powf(g) + c,
        [_, _, _, c] => c,
        [g, a, b, _, d] if x >= d => (a * x + b).powf(g),
        [_, _, _, c, _] => c * x,
        [g, a, b, _, d, e, _] if x >= d => (a * x + b).powf(g) + e,
        [_, _, _, c, _, _, f] => c * x + f,
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_before_1970_ends_no_program() {
        let profile = write(&Colorimetry::SRGB).expect("it has a matrix");
        assert!(parsed(&profile, UNIX_EPOCH).is_some());
        assert!(parsed(&profile, UNIX_EPOCH - std::time::Duration::from_secs(1)).is_none());
    }
}
