//! Conversion of the codes of a file to linear color.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, GRAPHICS_WHITE, Transfer, hlg_gamma};
use glam::{DMat3, Vec3};
use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::codec::chromaticities::{convert, to_rec709};
use crate::codec::icc::{Curve, Profile, Tables};
use crate::codec::limits::filled;
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, Description, Picture, Pixels};

/// The peak of the display that HLG is graded on, unless the file states one (ITU-R BT.2100).
const HLG_PEAK: f64 = 1000.0;

/// Conversion of the codes of a file to linear Rec.709. A value of 1 is SDR white, which in HDR is 203 cd/m2 (ITU-R
/// BT.2408), so that SDR and HDR versions of an image agree.
pub(crate) struct Colors {
    decoding: Decoding,
    matrix: Option<DMat3>,
    /// HLG: the luminance weights, and the peak of the display.
    display: Option<(Vec3, f64)>,
    /// True for the narrow range of video: of 8-bit codes, 16 is black and 235 is white.
    pub(crate) is_narrow: bool,
    /// The colorimetry that the file states; `None` if there is none, or if it is not one of primaries and a transfer
    /// function.
    pub(crate) stated: Option<Colorimetry>,
    /// The chunk or profile that states it.
    pub(crate) stated_by: Option<&'static str>,
    pub(crate) notes: Vec<String>,
}

/// Conversion of codes to linear color in the primaries of the file.
enum Decoding {
    Transfer(Transfer),
    /// The curves of a profile, by channel.
    Curves(Box<[Curve; 3]>),
    /// The tables of a profile.
    Tables(Tables),
    /// Printing density of film, as Cineon files have it.
    Film,
}

/// Light of a signal of printing density, by Kodak's conversion for 10 bits: 0.002 of density for a code, a film of
/// gamma 0.6, white at 685 and black at 95. It goes on above white, to 13.5, and a little below black.
fn film_to_light(signal: f64) -> f64 {
    let exposure = |code: f64| 10_f64.powf((code - 685.0) * 0.002 / 0.6);
    let black = exposure(95.0);
    (exposure(1023.0 * signal) - black) / (1.0 - black)
}

impl Colors {
    /// The colors that a file states. `peak` is that of the mastering display in cd/m2, if it is stated.
    pub(crate) fn new(stated: Option<(Chromaticities, Transfer)>, peak: Option<f64>) -> Self {
        let (primaries, transfer) = stated.unwrap_or((Chromaticities::REC709, Transfer::Srgb));
        let stated = stated.map(|(primaries, transfer)| {
            let color = Colorimetry::new(primaries, transfer);
            if color.is_hdr() { hdr(color, peak) } else { color }
        });
        let display =
            (transfer == Transfer::Hlg).then(|| (primaries.to_xyz().row(1).as_vec3(), peak.unwrap_or(HLG_PEAK)));
        Self { display, stated, ..Self::with_decoding(Decoding::Transfer(transfer), &primaries) }
    }

    /// The colors of an ICC profile.
    pub(crate) fn of_profile(profile: Profile) -> Self {
        match profile {
            Profile::Space(primaries, transfer) => Self::new(Some((primaries, transfer)), None),
            Profile::Curves(primaries, curves) => Self::with_decoding(Decoding::Curves(curves), &primaries),
            Profile::Tables(tables) => Self::with_decoding(Decoding::Tables(tables), &Tables::PRIMARIES),
        }
    }

    /// Printing density of film. Its primaries are taken for those of Rec.709: each film has others.
    pub(crate) fn of_film() -> Self {
        Self::with_decoding(Decoding::Film, &Chromaticities::REC709)
    }

    /// Sets the chunk or profile that states the colors.
    pub(crate) fn stated_by(self, name: &'static str) -> Self {
        Self { stated_by: Some(name), ..self }
    }

    fn with_decoding(decoding: Decoding, primaries: &Chromaticities) -> Self {
        let matrix = to_rec709(primaries);
        Self { decoding, matrix, display: None, is_narrow: false, stated: None, stated_by: None, notes: Vec::new() }
    }

    /// Adds the colorimetry of the codes to a description: none where only the profile states it.
    pub(crate) fn describe(self, file: Description) -> Description {
        let default = matches!(self.decoding, Decoding::Transfer(_)).then_some(Colorimetry::SRGB);
        Description { color: self.stated.or(default), stated_by: self.stated_by, notes: self.notes, ..file }
    }

    /// True if colors can exceed SDR white.
    fn is_hdr(&self) -> bool {
        matches!(self.decoding, Decoding::Transfer(Transfer::Pq | Transfer::Hlg) | Decoding::Film)
    }

    /// Bytes of a channel in the picture of [`Codes::into_picture`].
    pub(crate) fn bytes_of_sample(&self, bits: u32) -> u64 {
        if bits > 8 || self.is_hdr() { 4 } else { 2 }
    }

    /// The signal of a code.
    fn signal(&self, code: u32, last: u32) -> f64 {
        let (code, last) = (f64::from(code), f64::from(last));
        if self.is_narrow {
            // 16 and 219 of 256, whatever the number of bits.
            let unit = (last + 1.0) / 256.0;
            (code - 16.0 * unit) / (219.0 * unit)
        } else {
            code / last
        }
    }

    /// The linear value of each code of each channel, scene-linear for HLG; signals for tables.
    fn tables(&self, last: u32) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|channel| (0..=last).map(|code| self.decoded(channel, self.signal(code, last)) as f32).collect())
    }

    fn decoded(&self, channel: usize, signal: f64) -> f64 {
        match &self.decoding {
            Decoding::Transfer(transfer) => transfer.to_light(signal) * unit(*transfer),
            Decoding::Curves(curves) => curves[channel].linear(signal),
            Decoding::Tables(_) => signal,
            Decoding::Film => film_to_light(signal),
        }
    }

    fn convert(&self, values: &mut [f32]) {
        self.apply_ootf(values);
        let Some(matrix) = self.matrix.map(|matrix| matrix.as_mat3()) else { return };
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
        }
    }

    /// True if the numbers of the file are linear Rec.709 as they are.
    pub(crate) fn is_linear_rec709(&self) -> bool {
        matches!(self.decoding, Decoding::Transfer(Transfer::Linear)) && self.matrix.is_none()
    }

    /// Decodes the signals of pixels to linear Rec.709; the curves of sRGB and of powers are extended beyond 0 to 1.
    /// Alpha stays. Only EXR files have such pixels, and they have no profiles.
    pub(crate) fn decode(&self, values: &mut [f32]) {
        if let Decoding::Transfer(transfer) = self.decoding
            && transfer != Transfer::Linear
        {
            let scale = unit(transfer);
            for value in values.as_chunks_mut::<4>().0.iter_mut().flat_map(|pixel| &mut pixel[..3]) {
                *value = (transfer.extended_to_light(f64::from(*value)) * scale) as f32;
            }
        }
        self.convert(values);
    }

    /// The upright picture of signals: red, green, blue and straight alpha of each pixel. Profiles with curves and tables
    /// take codes of 16 bits, in which signals are limited to 0 to 1.
    ///
    /// # Errors
    /// There is no memory for it, or a profile cannot be evaluated.
    #[cfg(any(feature = "avif", feature = "jxl"))]
    pub(super) fn into_picture(
        self,
        mut values: Vec<f32>,
        [width, height]: [u32; 2],
        alpha: Alpha,
        orientation: Option<Orientation>,
    ) -> Result<Picture, CodecError> {
        if !matches!(self.decoding, Decoding::Transfer(_)) {
            let code = |signal: &f32| ((signal.clamp(0.0, 1.0) * 65535.0).round() as u16).to_be_bytes();
            let channels = if alpha == Alpha::None { 3 } else { 4 };
            let pixels = values.as_chunks::<4>().0;
            let bytes = pixels.iter().flat_map(|pixel| &pixel[..channels]).flat_map(code).collect();
            let codes = Codes { bytes, bits: 16, channels, alpha, pixels: pixels.len() };
            return codes.into_picture([width, height], self, orientation);
        }
        self.decode(&mut values);
        if alpha == Alpha::Premultiply {
            for [r, g, b, alpha] in values.as_chunks_mut::<4>().0 {
                [r, g, b].into_iter().for_each(|channel| *channel *= *alpha);
            }
        }
        let picture = Picture::new(width, height, Pixels::Float(values));
        let mut picture = Picture { stated: self.stated, notes: self.notes, ..picture };
        if let Some(orientation) = orientation {
            picture = orientation.upright(picture);
            picture.notes.push("it is turned upright, as it states".to_owned());
        }
        Ok(picture)
    }

    /// Applies the opto-optical transfer function of HLG for the display that the file is graded on.
    fn apply_ootf(&self, values: &mut [f32]) {
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

/// The linear value of a signal of 1; for HLG that of the scene.
fn unit(transfer: Transfer) -> f64 {
    if transfer == Transfer::Pq { 10000.0 / GRAPHICS_WHITE.get() } else { 1.0 }
}

fn hdr(color: Colorimetry, peak: Option<f64>) -> Colorimetry {
    let default = (color.transfer == Transfer::Hlg).then_some(HLG_PEAK);
    Colorimetry { white_nits: Some(GRAPHICS_WHITE), peak_nits: peak.or(default).map(Decimal::new), ..color }
}

/// The codes of all pixels.
pub(crate) struct Codes {
    /// A byte for each code, or two, the higher one first.
    pub(crate) bytes: Vec<u8>,
    /// The bits of a code: 8, which are a byte, or up to 16.
    pub(crate) bits: u32,
    /// Gray, RGB or CMYK, and alpha.
    pub(crate) channels: usize,
    /// The kind of the last channel.
    pub(crate) alpha: Alpha,
    pub(crate) pixels: usize,
}

/// The straight alpha of a file: coverage that is not multiplied into the color.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Alpha {
    /// There is none: it is 1.
    None,
    /// It is kept, and the color is multiplied by it.
    Premultiply,
    Apart,
}

/// Pixels that are converted at a time.
const GROUP: usize = 4096;

impl Codes {
    /// The upright picture of this size.
    ///
    /// # Errors
    /// There is no memory for it, or a profile cannot be evaluated.
    pub(super) fn into_picture(
        self,
        [width, height]: [u32; 2],
        colors: Colors,
        orientation: Option<Orientation>,
    ) -> Result<Picture, CodecError> {
        let pixels = self.decoded(&colors)?;
        let Colors { stated, notes, .. } = colors;
        let mut picture = Picture { stated, notes, ..Picture::new(width, height, pixels) };
        if let Some(orientation) = orientation {
            picture = orientation.upright(picture);
            picture.notes.push(orientation.note());
        }
        Ok(picture)
    }

    /// Linear Rec.709: half floats for 8 bits, which keep all codes distinct, floats for more and for HDR. Alpha is
    /// 1 where the file has none.
    fn decoded(&self, colors: &Colors) -> Result<Pixels, CodecError> {
        let tables = colors.tables((1 << self.bits) - 1);
        if self.bits > 8 || colors.is_hdr() {
            let mut values = filled(self.pixels * 4, 1.0_f32)?;
            for (group, out) in values.chunks_mut(4 * GROUP).enumerate() {
                self.group(group * GROUP, colors, &tables, out)?;
            }
            return Ok(Pixels::Float(values));
        }
        let mut values = filled(self.pixels * 4, f16::ONE)?;
        let mut floats = vec![1.0; 4 * GROUP];
        for (group, out) in values.chunks_mut(4 * GROUP).enumerate() {
            let floats = &mut floats[..out.len()];
            self.group(group * GROUP, colors, &tables, floats)?;
            out.convert_from_f32_slice(floats);
        }
        Ok(Pixels::Half(values))
    }

    fn code(&self, pixel: usize, channel: usize) -> usize {
        let at = pixel * self.channels + channel;
        if self.bits > 8 {
            u16::from_be_bytes([self.bytes[2 * at], self.bytes[2 * at + 1]]).into()
        } else {
            self.bytes[at].into()
        }
    }

    /// Writes the linear color of the pixels from `first` on.
    fn group(&self, first: usize, colors: &Colors, tables: &[Vec<f32>; 3], out: &mut [f32]) -> Result<(), CodecError> {
        let inks = self.channels - usize::from(self.alpha != Alpha::None);
        if let Decoding::Tables(profile) = &colors.decoding {
            let channels = profile.channels();
            let pixels = first..first + out.len() / 4;
            let signals = pixels.flat_map(|pixel| (0..channels).map(move |channel| (pixel, channel.min(inks - 1))));
            let signals: Vec<f32> = signals.map(|(pixel, channel)| tables[0][self.code(pixel, channel)]).collect();
            profile.linear(&signals, out)?;
        } else {
            for (pixel, out) in (first..).zip(out.as_chunks_mut::<4>().0) {
                for (channel, value) in out[..3].iter_mut().enumerate() {
                    *value = tables[channel][self.code(pixel, channel.min(inks - 1))];
                }
            }
        }
        colors.convert(out);
        if self.alpha != Alpha::None {
            let scale = 1.0 / (tables[0].len() - 1) as f32;
            for (pixel, out) in (first..).zip(out.as_chunks_mut::<4>().0) {
                out[3] = self.code(pixel, inks) as f32 * scale;
                let alpha = if self.alpha == Alpha::Premultiply { out[3] } else { 1.0 };
                out[..3].iter_mut().for_each(|value| *value *= alpha);
            }
        }
        Ok(())
    }
}
