//! Parses the segments of a JPEG (ITU-T T.81, annex B), and finds the data of its scans.

use crate::codec::limits::MAX_SCANS;
use crate::codec::{CodecError, ErrorKind};

/// The marker codes with a meaning here.
mod marker {
    pub(super) const FRAMES: std::ops::RangeInclusive<u8> = 0xc0..=0xcf;
    pub(super) const HUFFMAN_TABLES: u8 = 0xc4;
    pub(super) const RESERVED: u8 = 0xc8;
    pub(super) const ARITHMETIC_CONDITIONS: u8 = 0xcc;
    pub(super) const RESTARTS: std::ops::RangeInclusive<u8> = 0xd0..=0xd7;
    pub(super) const END: u8 = 0xd9;
    pub(super) const SCAN: u8 = 0xda;
    pub(super) const QUANTIZATION_TABLES: u8 = 0xdb;
    pub(super) const NUMBER_OF_LINES: u8 = 0xdc;
    pub(super) const RESTART_INTERVAL: u8 = 0xdd;
    pub(super) const HIERARCHY: u8 = 0xde;
    pub(super) const APP0: u8 = 0xe0;
    pub(super) const APP1: u8 = 0xe1;
    pub(super) const APP2: u8 = 0xe2;
    pub(super) const APP14: u8 = 0xee;
    pub(super) const JPEG_LS: u8 = 0xf7;
}

/// A part of a file that decoding needs, in the order of the file.
pub(super) enum Segment<'a> {
    Quantization(&'a [u8]),
    Huffman(&'a [u8]),
    /// MCUs between two restart markers; 0 for none.
    RestartInterval(usize),
    /// The header of a scan, and all that follows it in the file.
    Scan(&'a [u8], &'a [u8]),
}

/// The header of the frame.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub(super) is_progressive: bool,
    pub(super) width: u16,
    pub(super) height: u16,
    pub(super) components: Vec<ComponentHeader>,
}

/// A component as the frame states it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ComponentHeader {
    pub(super) id: u8,
    /// Sampling factors, 1 to 4.
    pub(super) horizontal: usize,
    pub(super) vertical: usize,
    /// The quantization table, 0 to 3.
    pub(super) table: usize,
}

/// The color model of the components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorModel {
    Gray,
    Rgb,
    YCbCr,
    Cmyk,
    /// CMY as YCbCr, with black.
    Ycck,
}

/// A file without the data of its scans.
pub(super) struct Segments<'a> {
    pub(super) frame: Frame,
    pub(super) coding: Vec<Segment<'a>>,
    /// The ICC profile; an error if its pieces do not belong together.
    pub(super) profile: Option<Result<Vec<u8>, ()>>,
    /// The EXIF data, from its TIFF header on.
    pub(super) exif: Option<&'a [u8]>,
    /// The `transform` of an Adobe segment. Its numbers of CMYK are inverted.
    pub(super) adobe: Option<u8>,
    is_jfif: bool,
    has_gain_map: bool,
    more_images: bool,
}

impl<'a> Segments<'a> {
    /// # Errors
    /// A file that is cut short or contradicts itself, and processes that are not supported.
    pub(super) fn of(file: &'a [u8]) -> Result<Self, CodecError> {
        let mut found = Found::default();
        // The signature is known.
        let mut at = 2;
        loop {
            let (marker, after) = next_marker(file, at)?;
            at = after;
            match marker {
                marker::END => break,
                // Restarts stand between the data of a scan, and 1 is a code without a segment.
                code if marker::RESTARTS.contains(&code) || code <= 1 || code == 0xd8 => {}
                code => {
                    let body = segment(file, at)?;
                    at += 2 + body.len();
                    found.take(code, body, &file[at..])?;
                }
            }
        }
        found.into_segments()
    }

    /// The color model of the components, by the rules of libjpeg: JFIF, then Adobe's segment, then identifiers.
    ///
    /// # Errors
    /// Two or more than four components.
    pub(super) fn color_model(&self) -> Result<ColorModel, CodecError> {
        let ids: Vec<u8> = self.frame.components.iter().map(|component| component.id).collect();
        match (ids.len(), self.adobe) {
            (1, _) => Ok(ColorModel::Gray),
            (3, _) if self.is_jfif => Ok(ColorModel::YCbCr),
            (3, Some(0)) => Ok(ColorModel::Rgb),
            (3, None) if ids == *b"RGB" => Ok(ColorModel::Rgb),
            (3, _) => Ok(ColorModel::YCbCr),
            (4, Some(2)) => Ok(ColorModel::Ycck),
            (4, _) => Ok(ColorModel::Cmyk),
            (number, _) => Err(not_supported(&format!("{number} components"))),
        }
    }

    /// Notes about what reading leaves out.
    pub(super) fn notes(&self) -> Vec<String> {
        if self.has_gain_map {
            vec!["its gain map is not applied: the picture is the one for SDR displays".to_owned()]
        } else if self.more_images {
            vec!["it has more than one image; only the first is read".to_owned()]
        } else {
            Vec::new()
        }
    }
}

/// Content of the segments so far.
#[derive(Default)]
struct Found<'a> {
    frame: Option<Frame>,
    coding: Vec<Segment<'a>>,
    scans: usize,
    profile: Vec<(u8, u8, &'a [u8])>,
    exif: Option<&'a [u8]>,
    adobe: Option<u8>,
    is_jfif: bool,
    has_gain_map: bool,
    more_images: bool,
}

impl<'a> Found<'a> {
    fn take(&mut self, code: u8, body: &'a [u8], rest: &'a [u8]) -> Result<(), CodecError> {
        match code {
            marker::HUFFMAN_TABLES => self.coding.push(Segment::Huffman(body)),
            marker::QUANTIZATION_TABLES => self.coding.push(Segment::Quantization(body)),
            marker::RESTART_INTERVAL => {
                let interval = body.first_chunk().ok_or_else(|| damaged("a restart interval has no number"))?;
                self.coding.push(Segment::RestartInterval(u16::from_be_bytes(*interval).into()));
            }
            marker::SCAN => {
                self.scans += 1;
                if self.scans > MAX_SCANS {
                    return Err(not_supported(&format!("more than {MAX_SCANS} scans")));
                }
                self.coding.push(Segment::Scan(body, rest));
            }
            marker::ARITHMETIC_CONDITIONS => return Err(not_supported("arithmetic coding")),
            marker::NUMBER_OF_LINES => return Err(not_supported("a height after the first scan (DNL)")),
            marker::HIERARCHY => return Err(not_supported("the hierarchical process")),
            marker::JPEG_LS => return Err(not_supported("JPEG-LS")),
            marker::RESERVED => return Err(not_supported("a process of a JPEG extension")),
            code if marker::FRAMES.contains(&code) => {
                if self.frame.is_some() {
                    return Err(damaged("it has two frames"));
                }
                self.frame = Some(frame(code, body)?);
            }
            marker::APP0 => self.is_jfif |= body.starts_with(b"JFIF\0"),
            marker::APP1 => match body.strip_prefix(b"Exif\0\0") {
                Some(exif) => self.exif = self.exif.or(Some(exif)),
                None => self.has_gain_map |= is_xmp_of_gain_map(body),
            },
            marker::APP2 => {
                if let Some([number, count, data @ ..]) = body.strip_prefix(b"ICC_PROFILE\0") {
                    self.profile.push((*number, *count, data));
                }
                self.has_gain_map |= body.starts_with(b"urn:iso:std:iso:ts:21496:-1\0");
                self.more_images |= body.starts_with(b"MPF\0");
            }
            marker::APP14 if body.starts_with(b"Adobe") => self.adobe = body.get(11).copied(),
            _ => {}
        }
        Ok(())
    }

    fn into_segments(self) -> Result<Segments<'a>, CodecError> {
        let frame = self.frame.ok_or_else(|| damaged("it has no frame"))?;
        let profile = (!self.profile.is_empty()).then(|| joined(self.profile));
        let Self { coding, exif, adobe, is_jfif, has_gain_map, more_images, .. } = self;
        Ok(Segments { frame, coding, profile, exif, adobe, is_jfif, has_gain_map, more_images })
    }
}

/// Adobe's and Apple's names of gain maps in XMP.
fn is_xmp_of_gain_map(body: &[u8]) -> bool {
    let names: [&[u8]; 2] = [b"http://ns.adobe.com/hdr-gain-map/1.0/", b"http://ns.apple.com/HDRGainMap/1.0/"];
    names.iter().any(|name| body.windows(name.len()).any(|window| window == *name))
}

/// The pieces of a profile in their order (ICC.1:2022, B.4).
fn joined(mut pieces: Vec<(u8, u8, &[u8])>) -> Result<Vec<u8>, ()> {
    pieces.sort_by_key(|(number, ..)| *number);
    let count = pieces.len();
    let is_whole =
        |(at, (number, of, _)): (usize, &(u8, u8, &[u8]))| usize::from(*number) == at + 1 && usize::from(*of) == count;
    if pieces.iter().enumerate().all(is_whole) {
        Ok(pieces.iter().flat_map(|(.., data)| data.iter().copied()).collect())
    } else {
        Err(())
    }
}

/// The next marker from `at` on and where its segment begins. Bytes that are no marker are passed over: the data of a
/// scan, and what some cameras put between segments.
fn next_marker(file: &[u8], at: usize) -> Result<(u8, usize), CodecError> {
    let rest = file.get(at..).unwrap_or_default();
    let pairs = rest.windows(2).position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff));
    let found = pairs.ok_or_else(CodecError::cut_short)?;
    Ok((rest[found + 1], at + found + 2))
}

fn segment(file: &[u8], at: usize) -> Result<&[u8], CodecError> {
    let rest = &file[at..];
    let length = usize::from(u16::from_be_bytes(*rest.first_chunk().ok_or_else(CodecError::cut_short)?));
    if length < 2 {
        return Err(damaged("a segment has no length"));
    }
    rest.get(2..length).ok_or_else(CodecError::cut_short)
}

fn frame(code: u8, body: &[u8]) -> Result<Frame, CodecError> {
    match code {
        0xc0..=0xc2 => {}
        0xc3 => return Err(not_supported("the lossless process")),
        0xc5..=0xc7 => return Err(not_supported("the hierarchical process")),
        _ => return Err(not_supported("arithmetic coding")),
    }
    let [precision, height @ .., w1, w0, count] =
        *body.first_chunk::<6>().ok_or_else(|| damaged("its frame is short"))?;
    if precision != 8 {
        return Err(not_supported(&format!("{precision} bits for each number")));
    }
    let (height, width) = (u16::from_be_bytes(height), u16::from_be_bytes([w1, w0]));
    if height == 0 {
        return Err(not_supported("a height after the first scan (DNL)"));
    }
    let (components, left) = body[6..].as_chunks::<3>();
    if components.len() != usize::from(count) || !left.is_empty() {
        return Err(damaged("its frame has another number of components than it states"));
    }
    let components = components.iter().map(component).collect::<Result<Vec<_>, _>>()?;
    let has_twins =
        |(at, component): (usize, &ComponentHeader)| components[..at].iter().any(|before| before.id == component.id);
    if components.is_empty() || components.iter().enumerate().any(has_twins) {
        return Err(damaged("its frame names no component, or one twice"));
    }
    Ok(Frame { is_progressive: code == 0xc2, width, height, components })
}

fn component(&[id, sampling, table]: &[u8; 3]) -> Result<ComponentHeader, CodecError> {
    let (horizontal, vertical) = (usize::from(sampling >> 4), usize::from(sampling & 15));
    if !(1..=4).contains(&horizontal) || !(1..=4).contains(&vertical) || table > 3 {
        return Err(damaged("a component has a sampling factor or a table that cannot be"));
    }
    Ok(ComponentHeader { id, horizontal, vertical, table: table.into() })
}

/// A JPEG of a kind that is not read.
pub(super) fn not_supported(what: &str) -> CodecError {
    CodecError::new(ErrorKind::Unsupported, format!("a JPEG with {what} is not supported"))
        .hint("save it again as a usual JPEG of 8 bits, or as PNG")
}

pub(super) fn damaged(what: &str) -> CodecError {
    CodecError::broken(what)
}
