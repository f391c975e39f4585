//! From the codes of a PNG or a JPEG to light.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, GRAPHICS_WHITE, Transfer, hlg_gamma};
use glam::{DMat3, Vec3};
use half::f16;

use crate::codec::chromaticities::{convert, to_rec709};
use crate::codec::limits::filled;
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, Picture, Pixels};

/// The peak of the display that HLG is graded on, unless the file states one (ITU-R BT.2100).
const HLG_PEAK: f64 = 1000.0;

/// How the codes of a file become linear Rec.709. Light of 1 is SDR white, which in HDR is 203 cd/m2 (ITU-R BT.2408),
/// so that SDR and HDR versions of an image agree.
pub(crate) struct Colors {
    transfer: Transfer,
    matrix: Option<DMat3>,
    /// HLG: the luminance weights, and the peak of the display.
    display: Option<(Vec3, f64)>,
    /// What the file states; `None` if it states nothing.
    pub(crate) stated: Option<Colorimetry>,
    pub(crate) notes: Vec<String>,
}

impl Colors {
    /// The colors that a file states. `peak` is that of the mastering display in cd/m2, if it is stated.
    pub(crate) fn new(stated: Option<(Chromaticities, Transfer)>, peak: Option<f64>, notes: Vec<String>) -> Self {
        let (primaries, transfer) = stated.unwrap_or((Chromaticities::REC709, Transfer::Srgb));
        let luminance = || primaries.to_xyz().row(1).as_vec3();
        let color = |(primaries, transfer)| {
            let color = Colorimetry::new(primaries, transfer);
            if color.is_hdr() { hdr(color, peak) } else { color }
        };
        Self {
            transfer,
            matrix: to_rec709(&primaries),
            display: (transfer == Transfer::Hlg).then(|| (luminance(), peak.unwrap_or(HLG_PEAK))),
            stated: stated.map(color),
            notes,
        }
    }

    /// Whether there is light above SDR white.
    fn is_hdr(&self) -> bool {
        matches!(self.transfer, Transfer::Pq | Transfer::Hlg)
    }

    /// The bytes of a number of [`Codes::into_picture`].
    pub(crate) fn bytes_of_sample(&self, is_wide: bool) -> u64 {
        if is_wide || self.is_hdr() { 4 } else { 2 }
    }

    /// The light of a signal of 1; for HLG that of the scene.
    fn unit(&self) -> f64 {
        if self.transfer == Transfer::Pq { 10000.0 / GRAPHICS_WHITE.get() } else { 1.0 }
    }

    /// Linear light for each code; scene light for HLG.
    fn table(&self, last: u32) -> Vec<f32> {
        let scale = self.unit();
        let light = |code: u32| self.transfer.to_light(f64::from(code) / f64::from(last)) * scale;
        (0..=last).map(|code| light(code) as f32).collect()
    }

    fn convert(&self, values: &mut [f32]) {
        self.to_display_light(values);
        let Some(matrix) = self.matrix.map(|matrix| matrix.as_mat3()) else { return };
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
        }
    }

    /// True if the numbers of the file are linear Rec.709 as they are.
    pub(crate) fn is_rec709_light(&self) -> bool {
        self.transfer == Transfer::Linear && self.matrix.is_none()
    }

    /// Turns the signals of pixels into light; the curves of sRGB and of powers go on beyond 0 to 1. Alpha stays.
    pub(crate) fn to_light(&self, values: &mut [f32]) {
        if self.transfer != Transfer::Linear {
            let scale = self.unit();
            for value in values.as_chunks_mut::<4>().0.iter_mut().flat_map(|pixel| &mut pixel[..3]) {
                *value = (self.transfer.extended_to_light(f64::from(*value)) * scale) as f32;
            }
        }
        self.convert(values);
    }

    fn convert_halves(&self, values: &mut [f16]) {
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

/// The codes of all pixels.
pub(crate) struct Codes {
    /// A byte for each code, or two, the higher one first.
    pub(crate) bytes: Vec<u8>,
    /// Whether codes have 16 bits; otherwise they have 8.
    pub(crate) is_wide: bool,
    /// Gray, gray and alpha, RGB or RGBA.
    pub(crate) channels: usize,
    pub(crate) pixels: usize,
}

impl Codes {
    /// The upright picture of this size.
    ///
    /// # Errors
    /// There is no memory for it.
    pub(super) fn into_picture(
        self,
        [width, height]: [u32; 2],
        colors: Colors,
        orientation: Option<Orientation>,
    ) -> Result<Picture, CodecError> {
        let pixels = self.to_light(&colors)?;
        let Colors { stated, notes, .. } = colors;
        let picture = Picture { stated, notes, ..Picture::new(width, height, pixels) };
        Ok(match orientation {
            Some(orientation) => orientation.upright(picture),
            None => picture,
        })
    }

    /// Linear light of Rec.709: halves for 8 bits, which hold every code apart, floats for 16 and for HDR. Without
    /// alpha it is 1.
    fn to_light(&self, colors: &Colors) -> Result<Pixels, CodecError> {
        if !self.is_wide && !colors.is_hdr() {
            let mut values = filled(self.pixels * 4, f16::ONE)?;
            self.linearize(colors, f16::from_f32, &mut values);
            colors.convert_halves(&mut values);
            return Ok(Pixels::Half(values));
        }
        let mut values = filled(self.pixels * 4, 1.0_f32)?;
        self.linearize(colors, |value| value, &mut values);
        colors.convert(&mut values);
        Ok(Pixels::Float(values))
    }

    fn linearize<T: Copy>(&self, colors: &Colors, to_sample: impl Fn(f32) -> T, out: &mut [T]) {
        if self.is_wide {
            let (codes, _) = self.bytes.as_chunks::<2>();
            let codes = codes.iter().map(|code| usize::from(u16::from_be_bytes(*code)));
            spread(codes, self.channels, &colors.table(65535), to_sample, out);
        } else {
            let codes = self.bytes.iter().map(|code| usize::from(*code));
            spread(codes, self.channels, &colors.table(255), to_sample, out);
        }
    }
}

/// Spreads gray, gray and alpha, RGB or RGBA codes over RGBA.
fn spread<T: Copy>(
    mut codes: impl Iterator<Item = usize>,
    channels: usize,
    table: &[f32],
    to_sample: impl Fn(f32) -> T,
    out: &mut [T],
) {
    let alpha_scale = 1.0 / (table.len() - 1) as f32;
    let light: Vec<T> = table.iter().map(|value| to_sample(*value)).collect();
    let has_alpha = channels.is_multiple_of(2);
    for pixel in out.as_chunks_mut::<4>().0 {
        let mut next = || codes.next().unwrap_or(0);
        if channels < 3 {
            let gray = light[next()];
            pixel[..3].fill(gray);
        } else {
            pixel[..3].fill_with(|| light[next()]);
        }
        if has_alpha {
            pixel[3] = to_sample(next() as f32 * alpha_scale);
        }
    }
}
