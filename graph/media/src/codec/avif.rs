//! Encoded pixels to AVIF: ten bits, SDR and HDR, no alpha. AV1 by rav1e, the container by avif-serialize.

use afterimage_base::color::{Chromaticities, Colorimetry, Xy};
use avif_serialize::Aviffy;
use avif_serialize::constants as container;
use rav1e::prelude::{
    ChromaSampling, ColorDescription, ColorPrimaries, Config, Context, EncoderConfig, EncoderStatus,
    MatrixCoefficients, PixelRange, SpeedSettings, TransferCharacteristics,
};

use crate::codec::cicp::Cicp;
use crate::codec::light_level::LightLevel;
use crate::codec::limits::check_size;
use crate::codec::quantize::Quantizer;
use crate::codec::{CodecError, EncodedPixels, ErrorKind};

const BITS: u32 = 10;
const LAST: f32 = 1023.0;

/// How an AVIF is written. The color channels have full resolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AvifOptions {
    /// 1 to 100; 100 is nearly lossless.
    pub quality: u8,
    /// 0 to 10: how fast AV1 is encoded, at the cost of a larger file.
    pub speed: u8,
    /// Seed of the dither to ten bits, or `None` to round.
    pub dither: Option<u32>,
    /// What the numbers mean, which the file states.
    pub color: Colorimetry,
}

impl Default for AvifOptions {
    /// Quality 85, speed 8, sRGB, rounded: ten bits show no banding, and noise costs space.
    fn default() -> Self {
        Self { quality: 85, speed: 8, dither: None, color: Colorimetry::SRGB }
    }
}

/// Encodes an AVIF of `size` (width, height). Alpha is not written.
///
/// The file states its colors by code points of H.273; HDR files also have the mastering display (`mdcv`) and the
/// light level (`clli`).
///
/// # Errors
/// Colors without code points, an image that is too large, and what rav1e reports.
pub fn encode_avif(size: (u32, u32), pixels: EncodedPixels<'_>, options: &AvifOptions) -> Result<Vec<u8>, CodecError> {
    check_size((size.0.into(), size.1.into()), 2)?;
    let color = &options.color;
    let codes = Codes::of(color)?;
    let rgb = Quantizer { bits: BITS, dither: options.dither, channels: 3, first_row: 0 }.codes(size, pixels)?;
    let level = LightLevel::of(&rgb, 3, BITS, color);
    let payload = encode(size, &rgb, &codes, options)?;
    let mut file = Aviffy::new();
    file.set_width(size.0).set_height(size.1).set_bit_depth(BITS as u8);
    file.set_full_color_range(true)
        .set_color_primaries(codes.container.0)
        .set_transfer_characteristics(codes.container.1)
        .set_matrix_coefficients(codes.container.2);
    if let Some(level) = level {
        let whole = |nits: f64| nits.round().clamp(0.0, 65535.0) as u16;
        file.set_content_light_level(whole(level.max), whole(level.mean));
    }
    if let Some(peak) = color.peak_nits.filter(|_| color.is_hdr()) {
        let point = |xy: Xy| [xy.x, xy.y].map(|number| (number.get() * 50000.0).round() as u16).into();
        let Chromaticities { red, green, blue, white } = color.primaries;
        file.set_mastering_display([green, blue, red].map(point), point(white), (peak.get() * 1e4).round() as u32, 1);
    }
    let mut bytes = Vec::new();
    file.write_slice(&mut bytes, &payload, None).map_err(|error| failed(&error))?;
    Ok(bytes)
}

fn failed(error: &dyn std::fmt::Display) -> CodecError {
    CodecError::new(ErrorKind::Machine, format!("packing the AVIF failed: {error}"))
}

/// The code points in the terms of both crates, and the luma weights that belong to them.
struct Codes {
    description: ColorDescription,
    container: (container::ColorPrimaries, container::TransferCharacteristics, container::MatrixCoefficients),
    /// Of red and blue.
    luma: [f32; 2],
}

impl Codes {
    fn of(color: &Colorimetry) -> Result<Self, CodecError> {
        let cicp = Cicp::of(&color.primaries, color.transfer).ok_or_else(unstated)?;
        let (primaries, color_primaries) = match cicp.primaries {
            9 => (container::ColorPrimaries::Bt2020, ColorPrimaries::BT2020),
            12 => (container::ColorPrimaries::DisplayP3, ColorPrimaries::SMPTE432),
            _ => (container::ColorPrimaries::Bt709, ColorPrimaries::BT709),
        };
        let (transfer, transfer_characteristics) = transfer(cicp.transfer).ok_or_else(unstated)?;
        // ITU-R BT.2020 non-constant luminance for Rec.2020, BT.709 for the others.
        let (matrix, matrix_coefficients, luma) = match cicp.primaries {
            9 => (container::MatrixCoefficients::Bt2020Ncl, MatrixCoefficients::BT2020NCL, [0.2627, 0.0593]),
            _ => (container::MatrixCoefficients::Bt709, MatrixCoefficients::BT709, [0.2126, 0.0722]),
        };
        let description = ColorDescription { color_primaries, transfer_characteristics, matrix_coefficients };
        Ok(Self { description, container: (primaries, transfer, matrix), luma })
    }

    /// Full-range Y, Cb and Cr of RGB codes (ITU-T H.273, 8.3).
    fn planes(&self, rgb: [u16; 3]) -> [u16; 3] {
        let [red, blue] = self.luma;
        let [r, g, b] = rgb.map(f32::from);
        let y = red * r + (1.0 - red - blue) * g + blue * b;
        let center = (LAST + 1.0) / 2.0;
        let chroma = |difference: f32, weight: f32| difference / (2.0 * (1.0 - weight)) + center;
        [y, chroma(b - y, blue), chroma(r - y, red)].map(|value| (value + 0.5).floor().clamp(0.0, LAST) as u16)
    }
}

fn unstated() -> CodecError {
    CodecError::new(ErrorKind::Unsupported, "an AVIF states only colors that have code points")
        .hint("encode for `Rec709`, `DisplayP3` or `Rec2020` with `Srgb`, `Linear`, `Pq` or `Hlg`")
}

fn transfer(code: u8) -> Option<(container::TransferCharacteristics, TransferCharacteristics)> {
    match code {
        8 => Some((container::TransferCharacteristics::Linear, TransferCharacteristics::Linear)),
        13 => Some((container::TransferCharacteristics::Srgb, TransferCharacteristics::SRGB)),
        16 => Some((container::TransferCharacteristics::Smpte2084, TransferCharacteristics::SMPTE2084)),
        18 => Some((container::TransferCharacteristics::Hlg, TransferCharacteristics::HLG)),
        _ => None,
    }
}

/// One key frame of AV1.
fn encode(size: (u32, u32), rgb: &[u16], codes: &Codes, options: &AvifOptions) -> Result<Vec<u8>, CodecError> {
    let config = Config::new().with_encoder_config(config(size, codes, options));
    let mut context: Context<u16> = config.new_context().map_err(|error| failed(&error))?;
    let mut frame = context.new_frame();
    let mut pixels = rgb.as_chunks::<3>().0.iter();
    let [mut luma, mut blue, mut red] = frame.planes.each_mut().map(|plane| plane.mut_slice(Default::default()));
    let width = size.0 as usize;
    let rows = luma.rows_iter_mut().zip(blue.rows_iter_mut()).zip(red.rows_iter_mut()).take(size.1 as usize);
    for ((luma, blue), red) in rows {
        for (x, pixel) in pixels.by_ref().take(width).enumerate() {
            [luma[x], blue[x], red[x]] = codes.planes(*pixel);
        }
    }
    context.send_frame(frame).map_err(|error| failed(&error))?;
    context.flush();
    packets(&mut context)
}

fn packets(context: &mut Context<u16>) -> Result<Vec<u8>, CodecError> {
    let mut payload = Vec::new();
    loop {
        match context.receive_packet() {
            Ok(packet) => payload.extend(packet.data),
            Err(EncoderStatus::Encoded) => {}
            Err(EncoderStatus::LimitReached) => return Ok(payload),
            Err(error) => return Err(failed(&error)),
        }
    }
}

fn config((width, height): (u32, u32), codes: &Codes, options: &AvifOptions) -> EncoderConfig {
    let quantizer = (255.0 * (1.0 - f32::from(options.quality.clamp(1, 100)) / 100.0)).round() as usize;
    EncoderConfig {
        width: width as usize,
        height: height as usize,
        bit_depth: BITS as usize,
        chroma_sampling: ChromaSampling::Cs444,
        pixel_range: PixelRange::Full,
        color_description: Some(codes.description),
        still_picture: true,
        quantizer,
        speed_settings: SpeedSettings::from_preset(options.speed.min(10)),
        ..EncoderConfig::default()
    }
}
