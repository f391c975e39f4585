//! ICC profiles of RGB spaces: written where a file has no other exact label, and read where they are matrices with
//! a known curve.

use afterimage_base::color::{Chromaticities, Colorimetry, Cones, Transfer, Xy};
use glam::{DMat3, DVec3};
use moxcms::{ColorProfile, DataColorSpace, LocalizableString, Matrix3d, ProfileText, ToneReprCurve, Xyzd};

/// The white of the profile connection space: D50 as ICC.1 rounds it.
const PCS_WHITE: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);

/// Year, month, day, hour, minute and second of all profiles, so that equal colorimetry gives equal bytes.
const DATE: [u16; 6] = [2026, 1, 1, 0, 0, 0];

/// Largest difference between a curve and a transfer function that counts as equal, in linear light. Tables of 8-bit
/// profiles differ by less.
const SAME_CURVE: f64 = 1e-3;

/// A display profile with a matrix and a curve (ICC.1:2022, 8.4.3); `None` for `Pq` and `Hlg`, which have no such form.
/// Equal colorimetry gives equal bytes.
pub(crate) fn write(color: &Colorimetry) -> Option<Vec<u8>> {
    let curve = match color.transfer {
        Transfer::Linear => ToneReprCurve::Lut(Vec::new()),
        Transfer::Srgb => ToneReprCurve::Parametric(vec![2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045]),
        Transfer::Gamma(exponent) => ToneReprCurve::Parametric(vec![exponent.get() as f32]),
        Transfer::Pq | Transfer::Hlg => return None,
    };
    let adapt = Cones::Bradford.adaptation(color.primaries.white.to_xyz(), PCS_WHITE);
    let colorants = adapt * color.primaries.to_xyz();
    let mut profile = ColorProfile::new_srgb();
    profile.cicp = None;
    profile.red_colorant = xyz(colorants.x_axis);
    profile.green_colorant = xyz(colorants.y_axis);
    profile.blue_colorant = xyz(colorants.z_axis);
    profile.white_point = xyz(PCS_WHITE);
    profile.media_white_point = Some(xyz(PCS_WHITE));
    profile.chromatic_adaptation = Some(Matrix3d { v: [0, 1, 2].map(|row| adapt.row(row).to_array()) });
    profile.red_trc = Some(curve.clone());
    profile.green_trc = Some(curve.clone());
    profile.blue_trc = Some(curve);
    let mut description = description(color);
    // The encoder puts tags one behind the other. Readers such as libpng warn of one that does not begin at a multiple
    // of 4 (ICC.1:2022, 7.3.1), and a letter has two bytes.
    if !description.len().is_multiple_of(2) {
        description.push(' ');
    }
    profile.description = Some(text(&description));
    profile.copyright = Some(text("No copyright, use freely"));
    Some(with_fixed_date(profile.encode().expect("a matrix profile can be encoded")))
}

/// Replaces the date of the header, where the encoder puts the time of the clock, and pads the profile: readers such as
/// libpng refuse a length that is not a multiple of 4 (ICC.1:2022, 7.2.1).
fn with_fixed_date(mut profile: Vec<u8>) -> Vec<u8> {
    profile.resize(profile.len().next_multiple_of(4), 0);
    let length = u32::try_from(profile.len()).expect("a profile with a matrix has less than a kilobyte");
    profile[..4].copy_from_slice(&length.to_be_bytes());
    for (at, number) in DATE.iter().enumerate() {
        profile[24 + 2 * at..26 + 2 * at].copy_from_slice(&number.to_be_bytes());
    }
    profile
}

fn description(color: &Colorimetry) -> String {
    let transfer = match color.transfer {
        Transfer::Gamma(exponent) => format!("gamma {exponent}"),
        other => format!("{other:?}"),
    };
    format!("{}, {transfer}", color.primaries.name().unwrap_or("RGB"))
}

fn text(text: &str) -> ProfileText {
    ProfileText::Localizable(vec![LocalizableString::new("en".into(), "US".into(), text.into())])
}

fn xyz(at: DVec3) -> Xyzd {
    Xyzd { x: at.x, y: at.y, z: at.z }
}

/// The space of an RGB profile with a matrix and one curve for all channels, if the curve is linear, sRGB's or a power;
/// `None` for all other profiles. The white of the space is D65, to which the profile's colors are adapted.
pub(crate) fn read(bytes: &[u8]) -> Option<(Chromaticities, Transfer)> {
    let profile = ColorProfile::new_from_slice(bytes).ok()?;
    let is_matrix = profile.color_space == DataColorSpace::Rgb
        && profile.pcs == DataColorSpace::Xyz
        && profile.lut_a_to_b_perceptual.is_none()
        && profile.lut_a_to_b_colorimetric.is_none();
    let curves = [profile.red_trc.as_ref()?, profile.green_trc.as_ref()?, profile.blue_trc.as_ref()?];
    let transfer = transfer(curves[0])?;
    let is_one = curves.iter().all(|curve| is_curve(curve, transfer));
    let colorants = [profile.red_colorant, profile.green_colorant, profile.blue_colorant];
    let primaries = primaries(colorants.map(|at| DVec3::new(at.x, at.y, at.z)))?;
    (is_matrix && is_one).then_some((primaries, transfer))
}

/// As [`read`]; notes that a profile is none of these.
pub(crate) fn read_or_note(bytes: &[u8], notes: &mut Vec<String>) -> Option<(Chromaticities, Transfer)> {
    let read = read(bytes);
    if read.is_none() {
        notes.push("its ICC profile is not applied; the colors are taken as sRGB".to_owned());
    }
    read
}

fn primaries(colorants: [DVec3; 3]) -> Option<Chromaticities> {
    let d65 = Xy::D65.to_xyz();
    let adapted =
        Cones::Bradford.adaptation(PCS_WHITE, d65) * DMat3::from_cols_array_2d(&colorants.map(|c| c.to_array()));
    let mut numbers = [Xy::D65.to_vec(); 4].map(|xy| xy.to_array());
    for (column, xy) in numbers.iter_mut().take(3).enumerate() {
        let at = adapted.col(column);
        *xy = [at.x / at.element_sum(), at.y / at.element_sum()];
    }
    Chromaticities::from_numbers(numbers.as_flattened().try_into().expect("four points have eight numbers"))
}

fn transfer(curve: &ToneReprCurve) -> Option<Transfer> {
    let power = match curve {
        ToneReprCurve::Lut(table) if table.len() == 1 => Some(f64::from(table[0]) / 256.0),
        ToneReprCurve::Parametric(numbers) => numbers.first().map(|power| f64::from(*power)),
        ToneReprCurve::Lut(_) => None,
    };
    let gamma = power.filter(|power| (0.1..=10.0).contains(power)).map(|power| Transfer::Gamma(power.into()));
    let known = [Some(Transfer::Linear), Some(Transfer::Srgb), gamma];
    known.into_iter().flatten().find(|known| is_curve(curve, *known))
}

fn is_curve(curve: &ToneReprCurve, transfer: Transfer) -> bool {
    let mut signals = (0..=256).map(|step| f64::from(step) / 256.0);
    signals.all(|signal| (light(curve, signal) - transfer.to_light(signal)).abs() <= SAME_CURVE)
}

/// The curve's value (ICC.1:2022, 10.6 and 10.18). NaN for a form that is not defined.
fn light(curve: &ToneReprCurve, signal: f64) -> f64 {
    match curve {
        ToneReprCurve::Lut(table) => table_light(table, signal),
        ToneReprCurve::Parametric(numbers) => {
            let numbers: Vec<f64> = numbers.iter().map(|number| f64::from(*number)).collect();
            parametric_light(&numbers, signal)
        }
    }
}

fn table_light(table: &[u16], signal: f64) -> f64 {
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

fn parametric_light(numbers: &[f64], x: f64) -> f64 {
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
