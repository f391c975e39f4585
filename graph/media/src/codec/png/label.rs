//! The color chunks of a PNG (third edition, 4.3 and 11.3.2). Chunks that are written together never contradict each
//! other.

use std::borrow::Cow;

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer, Xy};
use png::{Info, ScaledFloat, SourceChromaticities, SrgbRenderingIntent};

use crate::codec::cicp::Cicp;
use crate::codec::light_level::LightLevel;
use crate::codec::{CodecError, ErrorKind, icc};

/// A chunk that the encoder does not write by itself.
pub(super) type Chunk = ([u8; 4], Vec<u8>);

/// `gAMA` next to `sRGB` (PNG, third edition, 11.3.2.5).
const SRGB_GAMMA: u32 = 45455;

/// The color chunks of a file.
pub(super) struct Label {
    /// `sRGB`, `gAMA`, `cHRM` and `iCCP`, which the encoder writes.
    older: Older,
    /// `cICP`, `mDCV` and `cLLI`.
    pub(super) newer: Vec<Chunk>,
}

/// The chunks of the first two editions.
enum Older {
    /// `sRGB`, with the `gAMA` and `cHRM` for readers that do not know it.
    Srgb,
    /// `gAMA` and `cHRM`: exact for linear values and powers.
    Gamma(u32, Chromaticities),
    Profile(Vec<u8>),
    /// Nothing: PQ and HLG have no older form.
    None,
}

impl Label {
    /// # Errors
    /// `Pq` and `Hlg` with primaries that have no code: no chunk states them.
    pub(super) fn new(color: &Colorimetry, level: Option<LightLevel>) -> Result<Self, CodecError> {
        let cicp = Cicp::of(&color.primaries, color.transfer);
        let older = match color.transfer {
            Transfer::Srgb if color.primaries == Chromaticities::REC709 => Older::Srgb,
            Transfer::Linear if fits(&color.primaries) => Older::Gamma(100_000, color.primaries),
            Transfer::Gamma(exponent) if fits(&color.primaries) => {
                Older::Gamma((1e5 / exponent.get()).round() as u32, color.primaries)
            }
            _ => icc::write(color).map_or(Older::None, Older::Profile),
        };
        if matches!(older, Older::None) && cicp.is_none() {
            return Err(unstated());
        }
        // Matrix 0 is RGB and range 1 is full, the only ones that PNG knows.
        let code = |cicp: Cicp| (*b"cICP", vec![cicp.primaries, cicp.transfer, 0, 1]);
        let mut newer: Vec<Chunk> = cicp.map(code).into_iter().collect();
        newer.extend(mastering_display(color).filter(|_| color.is_hdr()));
        newer.extend(level.map(light_level));
        Ok(Self { older, newer })
    }

    /// Fills in what the encoder writes by itself.
    pub(super) fn state(&self, info: &mut Info<'_>) {
        match &self.older {
            Older::Srgb => {
                info.srgb = Some(SrgbRenderingIntent::Perceptual);
                info.source_gamma = Some(ScaledFloat::from_scaled(SRGB_GAMMA));
                info.source_chromaticities = Some(chromaticities(&Chromaticities::REC709));
            }
            Older::Gamma(gamma, primaries) => {
                info.source_gamma = Some(ScaledFloat::from_scaled(*gamma));
                info.source_chromaticities = Some(chromaticities(primaries));
            }
            Older::Profile(profile) => info.icc_profile = Some(Cow::Owned(profile.clone())),
            Older::None => {}
        }
    }
}

fn unstated() -> CodecError {
    let what = "no chunk of a PNG states these primaries with this transfer function";
    CodecError::new(ErrorKind::Unsupported, what).hint("encode for `Rec709`, `DisplayP3` or `Rec2020`")
}

/// True if `cHRM` can state the primaries. It has no negative numbers, so primaries such as those of ACES 2065-1 do not
/// fit.
fn fits(primaries: &Chromaticities) -> bool {
    primaries.points().iter().all(|xy| xy.to_vec().min_element() >= 0.0)
}

fn chromaticities(primaries: &Chromaticities) -> SourceChromaticities {
    let point = |xy: Xy| [xy.x, xy.y].map(|number| ScaledFloat::from_scaled((number.get() * 1e5).round() as u32));
    let [red, green, blue, white] = primaries.points().map(|xy| point(xy).into());
    SourceChromaticities { white, red, green, blue }
}

/// `mDCV` (SMPTE ST 2086): the display has the primaries of the file and the stated peak. No darkest luminance is
/// known, so it is the least one of the chunk above 0.
fn mastering_display(color: &Colorimetry) -> Option<Chunk> {
    let peak = color.peak_nits?.get();
    let coordinate = |number: f64| ((number * 50000.0).round() as u16).to_be_bytes();
    let points = color.primaries.points().map(|xy| [coordinate(xy.x.get()), coordinate(xy.y.get())]);
    let mut data = points.as_flattened().as_flattened().to_vec();
    data.extend([luminance(peak), 1].map(u32::to_be_bytes).as_flattened());
    Some((*b"mDCV", data))
}

fn light_level(level: LightLevel) -> Chunk {
    let numbers = [luminance(level.max), luminance(level.mean)];
    (*b"cLLI", numbers.map(u32::to_be_bytes).as_flattened().to_vec())
}

/// In steps of 0.0001 cd/m2.
fn luminance(nits: f64) -> u32 {
    (nits * 1e4).round() as u32
}
