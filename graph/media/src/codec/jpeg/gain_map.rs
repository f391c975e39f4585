//! A JPEG for SDR displays, followed by another one of the gains that lead to the HDR image (ISO 21496-1).
//!
//! The parameters of the map are in the file twice, in the form of ISO 21496-1 and in the XMP of Ultra HDR. So is the
//! place of the second JPEG, in the XMP and in the multi-picture format (CIPA DC-007).

use afterimage_base::color::{Colorimetry, Decimal, GRAPHICS_WHITE, Transfer};
use glam::DVec3;
use rayon::prelude::*;

use crate::codec::encoding::{Buffer, RowWriter as _};
use crate::codec::jpeg::write::JpegRows;
use crate::codec::limits::zeroed;
use crate::codec::{CodecError, Encoding, ErrorKind, Image, Samples};

/// Added to both images, in units of SDR white, before they are divided: it keeps the gains of dark pixels small.
const OFFSET: f64 = 1.0 / 64.0;
/// The first bytes of a segment of ISO 21496-1.
const ISO: &[u8] = b"urn:iso:std:iso:ts:21496:-1\0";
/// Parameters are multiples of a millionth, which the offset is, too.
const DENOMINATOR: i32 = 1_000_000;
/// The flag of ISO 21496-1 for gains in the primaries of the base, as XMP implies.
const IN_BASE_PRIMARIES: u8 = 0x40;
/// HDR colors are outside of the primaries of the base if a channel is below this, in units of SDR white.
const OUTSIDE: f64 = -0.01;

/// The parameters of a map for all channels, as log2.
struct Parameters {
    least: f64,
    most: f64,
    headroom: f64,
}

/// Encodes an SDR image with the gains that lead to an HDR image of the same size. Returns the file, and sentences
/// about what is left out.
pub(crate) fn encode(
    image: Image<'_>,
    hdr: (Samples<'_>, Colorimetry),
    encoding: &Encoding,
) -> Result<(Vec<u8>, Vec<String>), CodecError> {
    let mut notes = Vec::new();
    let (gains, outside) = gains(image, hdr, encoding)?;
    let pixels = gains.len() / 3;
    if outside * 1000 > pixels {
        let share = (100 * outside).div_ceil(pixels);
        notes.push(format!(
            "{share} % of the pixels of the HDR image are outside of the primaries of the JPEG, which a gain map \
             cannot leave; encode the SDR image for wider ones, such as `DisplayP3`"
        ));
    }
    let bounds = |of: fn(f32, f32) -> f32, first| f64::from(gains.par_iter().copied().reduce(|| first, of));
    let [least, most] = [bounds(f32::min, f32::INFINITY), bounds(f32::max, f32::NEG_INFINITY)].map(rounded);
    let [white, peak] = luminances(&hdr.1);
    let parameters = Parameters { least, most, headroom: rounded((peak / white).log2()) };
    let mut codes = zeroed::<u8>(4 * pixels)?;
    codes.par_chunks_exact_mut(4).zip(gains.par_chunks_exact(3)).for_each(|(codes, gains)| {
        let code = |gain: f32| ((f64::from(gain) - least) / (most - least).max(1e-6) * 255.0).round() as u8;
        codes.copy_from_slice(&[code(gains[0]), code(gains[1]), code(gains[2]), 255]);
    });
    drop(gains);
    let map = jpeg(image.size, Samples::Byte(&codes), &Encoding { color: None, ..*encoding })?;
    let base = jpeg(image.size, image.samples, encoding)?;
    let map = with_segments(map, &[parameters.xmp(), parameters.iso()].concat());
    let before = [directory(map.len()), segment(2, &[ISO, &[0; 4]])].concat();
    let pictures = pictures(&base, before.len(), map.len())?;
    Ok(([with_segments(base, &[before, pictures].concat()), map].concat(), notes))
}

fn jpeg(size: (u32, u32), samples: Samples<'_>, encoding: &Encoding) -> Result<Vec<u8>, CodecError> {
    let file = Buffer::default();
    let mut rows = JpegRows::new(Box::new(file.clone()), size, encoding)?;
    rows.write(samples)?;
    Box::new(rows).finish()?;
    Ok(file.into_bytes())
}

/// SDR white and the peak of an HDR image, in cd/m2.
fn luminances(color: &Colorimetry) -> [f64; 2] {
    let white = color.white_nits.unwrap_or(GRAPHICS_WHITE).get();
    [white, color.peak_nits.map_or(10_000.0, Decimal::get).max(white)]
}

/// The gains of each channel of each pixel as log2, and the number of pixels that they cannot lead to.
fn gains(
    Image { size, samples, .. }: Image<'_>,
    (light, color): (Samples<'_>, Colorimetry),
    encoding: &Encoding,
) -> Result<(Vec<f32>, usize), CodecError> {
    let sdr = encoding.color.filter(|sdr| !sdr.is_hdr());
    let (Some(sdr), Transfer::Pq) = (sdr, color.transfer) else {
        return Err(CodecError::new(ErrorKind::Unsupported, "a gain map leads from an SDR image to one of PQ"));
    };
    if samples.len() != light.len() {
        return Err(CodecError::new(ErrorKind::Unsupported, "a gain map leads to an HDR image of the same size"));
    }
    let scale = 10_000.0 / luminances(&color)[0];
    let matrix = color.primaries.conversion(&sdr.primaries);
    let width = size.0 as usize;
    let mut gains = zeroed::<f32>(3 * width * size.1 as usize)?;
    let rows = gains.par_chunks_exact_mut(3 * width).enumerate();
    let outside = rows.map_init(
        || [vec![0.0; 4 * width], vec![0.0; 4 * width]],
        |[of_base, of_hdr], (y, gains)| {
            let row = 4 * width * y..4 * width * (y + 1);
            let (base, hdr) = (samples.row(row.clone(), of_base), light.row(row, of_hdr));
            let mut outside = 0;
            let pixels = base.as_chunks::<4>().0.iter().zip(hdr.as_chunks::<4>().0);
            for ((base, hdr), gains) in pixels.zip(gains.as_chunks_mut::<3>().0) {
                let [r, g, b, _] = hdr.map(|signal| scale * Transfer::Pq.to_light(signal.into()));
                let hdr = matrix * DVec3::new(r, g, b);
                outside += usize::from(hdr.min_element() < OUTSIDE);
                *gains = std::array::from_fn(|channel| {
                    let base = sdr.transfer.to_light(base[channel].into());
                    ((hdr[channel].max(0.0) + OFFSET) / (base + OFFSET)).log2() as f32
                });
            }
            outside
        },
    );
    let outside = outside.sum();
    Ok((gains, outside))
}

fn rounded(value: f64) -> f64 {
    (value * f64::from(DENOMINATOR)).round() / f64::from(DENOMINATOR)
}

impl Parameters {
    /// The segment of ISO 21496-1: two versions, flags, the headrooms of the base and of the HDR image, and of all
    /// channels the bounds of the gains, their gamma, and the offsets.
    fn iso(&self) -> Vec<u8> {
        let mut body = [ISO, &[0; 4], &[IN_BASE_PRIMARIES]].concat();
        for value in [0.0, self.headroom, self.least, self.most, 1.0, OFFSET, OFFSET] {
            let numerator = (value * f64::from(DENOMINATOR)).round() as i32;
            body.extend([numerator, DENOMINATOR].into_iter().flat_map(i32::to_be_bytes));
        }
        segment(2, &[&body])
    }

    /// The XMP of the map.
    fn xmp(&self) -> Vec<u8> {
        let Self { least, most, headroom } = self;
        xmp(&format!(
            "hdrgm:GainMapMin=\"{least}\" hdrgm:GainMapMax=\"{most}\" hdrgm:Gamma=\"1\" hdrgm:OffsetSDR=\"{OFFSET}\" \
             hdrgm:OffsetHDR=\"{OFFSET}\" hdrgm:HDRCapacityMin=\"0\" hdrgm:HDRCapacityMax=\"{headroom}\" \
             hdrgm:BaseRenditionIsHDR=\"False\"/>"
        ))
    }
}

/// The XMP of the base, which names a map of so many bytes.
fn directory(bytes: usize) -> Vec<u8> {
    xmp(&format!(
        "xmlns:Container=\"http://ns.google.com/photos/1.0/container/\" \
         xmlns:Item=\"http://ns.google.com/photos/1.0/container/item/\"><Container:Directory><rdf:Seq>\
         <rdf:li rdf:parseType=\"Resource\"><Container:Item Item:Semantic=\"Primary\" Item:Mime=\"image/jpeg\"/>\
         </rdf:li><rdf:li rdf:parseType=\"Resource\"><Container:Item Item:Semantic=\"GainMap\" \
         Item:Mime=\"image/jpeg\" Item:Length=\"{bytes}\"/></rdf:li></rdf:Seq></Container:Directory></rdf:Description>"
    ))
}

/// A segment of XMP with the rest of a description.
fn xmp(rest: &str) -> Vec<u8> {
    let text = format!(
        "http://ns.adobe.com/xap/1.0/\0<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\
         <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description rdf:about=\"\" \
         xmlns:hdrgm=\"http://ns.adobe.com/hdr-gain-map/1.0/\" hdrgm:Version=\"1.0\" {rest}</rdf:RDF></x:xmpmeta>"
    );
    segment(1, &[text.as_bytes()])
}

/// The segment of the multi-picture format, which comes after `before` bytes of other segments: a directory with a
/// version, the number of pictures, and for each its kind, its size and its place, counted from the directory on.
fn pictures(base: &[u8], before: usize, map: usize) -> Result<Vec<u8>, CodecError> {
    const MARK: &[u8] = b"MPF\0";
    const ENTRIES: u32 = 50;
    const LENGTH: usize = 4 + MARK.len() + ENTRIES as usize + 32;
    let size = base.len() + before + LENGTH;
    let place = size - (end_of_first(base) + before + 4 + MARK.len());
    let [size, map, place] = [size, map, place].map(u32::try_from);
    let (Ok(size), Ok(map), Ok(place)) = (size, map, place) else {
        return Err(CodecError::new(ErrorKind::TooLarge, "a JPEG with a gain map has at most 4 GiB"));
    };
    let mut body = [MARK, b"MM\0*\0\0\0\x08\0\x03"].concat();
    for (tag, kind, count, value) in
        [(0xb000_u16, 7_u16, 4, u32::from_be_bytes(*b"0100")), (0xb001, 4, 1, 2), (0xb002, 7, 32, ENTRIES)]
    {
        body.extend([tag, kind].into_iter().flat_map(u16::to_be_bytes));
        body.extend([count, value].into_iter().flat_map(u32::to_be_bytes));
    }
    // No further directory; then the base, which is the primary picture, and the map.
    let numbers = [0, 0x0003_0000, size, 0, 0, 0, map, place, 0];
    body.extend(numbers.into_iter().flat_map(u32::to_be_bytes));
    let segment = segment(2, &[&body]);
    debug_assert_eq!(segment.len(), LENGTH);
    Ok(segment)
}

/// An application segment of that number.
fn segment(number: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    let length = u16::try_from(body.len() + 2).expect("all of it is short");
    [&[0xff, 0xe0 + number], &length.to_be_bytes()[..], &body].concat()
}

/// The end of the first segment of a file, which is that of JFIF.
fn end_of_first(jpeg: &[u8]) -> usize {
    4 + usize::from(u16::from_be_bytes([jpeg[4], jpeg[5]]))
}

/// A file with further segments after the first.
fn with_segments(jpeg: Vec<u8>, segments: &[u8]) -> Vec<u8> {
    let (first, rest) = jpeg.split_at(end_of_first(&jpeg));
    [first, segments, rest].concat()
}
