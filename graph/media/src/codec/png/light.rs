//! What the chunks of a PNG state about its colors, and from its codes to light.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, GRAPHICS_WHITE, Transfer, hlg_gamma};
use glam::{DMat3, Vec3};
use half::f16;
use png::Info;

use crate::codec::chromaticities::{convert, to_rec709};
use crate::codec::cicp::Cicp;
use crate::codec::{CodecError, ColorSpace, ErrorKind, icc};

/// The peak of the display that HLG is graded on, unless the file states one (ITU-R BT.2100).
const HLG_PEAK: f64 = 1000.0;

/// How the codes of a file become linear Rec.709. Light of 1 is SDR white, which in HDR is 203 cd/m2 (ITU-R BT.2408),
/// so that SDR and HDR versions of an image agree.
pub(super) struct Colors {
    transfer: Transfer,
    matrix: Option<DMat3>,
    /// HLG: the luminance weights, and the peak of the display.
    display: Option<(Vec3, f64)>,
    /// What the chunks state; `None` if there are none.
    pub(super) stated: Option<Colorimetry>,
    pub(super) notes: Vec<String>,
}

impl Colors {
    /// The colors of `space`, or else what the chunks state.
    pub(super) fn of(info: &Info<'_>, space: Option<ColorSpace>) -> Result<Self, CodecError> {
        let mut notes = Vec::new();
        let stated = match space {
            Some(space) => Some((space.primaries, space.transfer)),
            None => stated(info, &mut notes)?,
        };
        let (primaries, transfer) = stated.unwrap_or((Chromaticities::REC709, Transfer::Srgb));
        let peak = mastering_peak(info).unwrap_or(HLG_PEAK);
        let luminance = || primaries.to_xyz().row(1).as_vec3();
        let color = |(primaries, transfer)| {
            let color = Colorimetry::new(primaries, transfer);
            if color.is_hdr() { hdr(color, mastering_peak(info)) } else { color }
        };
        Ok(Self {
            transfer,
            matrix: to_rec709(&primaries),
            display: (transfer == Transfer::Hlg).then(|| (luminance(), peak)),
            stated: stated.map(color),
            notes,
        })
    }

    /// Whether there is light above SDR white.
    pub(super) fn is_hdr(&self) -> bool {
        matches!(self.transfer, Transfer::Pq | Transfer::Hlg)
    }

    /// Linear light for each code; scene light for HLG.
    pub(super) fn table(&self, last: u32) -> Vec<f32> {
        let scale = if self.transfer == Transfer::Pq { 10000.0 / GRAPHICS_WHITE.get() } else { 1.0 };
        let light = |code: u32| self.transfer.to_light(f64::from(code) / f64::from(last)) * scale;
        (0..=last).map(|code| light(code) as f32).collect()
    }

    pub(super) fn convert(&self, values: &mut [f32]) {
        self.to_display_light(values);
        let Some(matrix) = self.matrix.map(|matrix| matrix.as_mat3()) else { return };
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
        }
    }

    pub(super) fn convert_halves(&self, values: &mut [f16]) {
        let Some(matrix) = self.matrix.map(|matrix| matrix.as_mat3()) else { return };
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            let rgb = [r.to_f32(), g.to_f32(), b.to_f32()];
            [*r, *g, *b] = convert(&matrix, rgb).map(f16::from_f32);
        }
    }

    /// The opto-optical transfer function of HLG: the light of the display that the file is graded on.
    fn to_display_light(&self, values: &mut [f32]) {
        let Some((weights, peak)) = self.display else { return };
        let (scale, power) = ((peak / GRAPHICS_WHITE.get()) as f32, (hlg_gamma(peak) - 1.0) as f32);
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            let scene = Vec3::new(*r, *g, *b);
            // Black has no luminance to the power of a negative number.
            let luminance = weights.dot(scene);
            let gain = if luminance > 0.0 { scale * luminance.powf(power) } else { 0.0 };
            [*r, *g, *b] = (scene * gain).to_array();
        }
    }
}

fn hdr(color: Colorimetry, peak: Option<f64>) -> Colorimetry {
    let default = (color.transfer == Transfer::Hlg).then_some(HLG_PEAK);
    Colorimetry { white_nits: Some(GRAPHICS_WHITE), peak_nits: peak.or(default).map(Decimal::new), ..color }
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
        let read = icc::read(profile);
        if read.is_none() {
            notes.push("its ICC profile is not applied; the colors are taken as sRGB".to_owned());
        }
        return Ok(read);
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
