//! DPX (SMPTE 268M): one picture of codes, as film scanners and grading systems write them.

use std::io::{BufRead, Read as _, Seek, SeekFrom};

use afterimage_base::color::{Chromaticities, Decimal, Transfer};

use crate::codec::codes::{Alpha, Codes, Colors};
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, ColorSpace, Description, ErrorKind, Picture, ReadOptions};

/// Bytes of the header up to the end of the first image element.
const HEADER: usize = 820;
/// A number that the header does not state.
const UNSTATED: u32 = u32::MAX;
/// The codes of EXIF of the orientations, by their numbers here.
const ORIENTATIONS: [u16; 8] = [1, 2, 4, 3, 5, 6, 8, 7];

/// Decodes a DPX to linear Rec.709. The header states the transfer characteristic, unless `options` name a space:
/// printing density is that of film in Cineon files, video is for a display of BT.1886, and codes of which nothing is
/// stated are sRGB. Alpha is straight.
pub(crate) fn decode(mut reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let header = Header::read(&mut reader)?;
    let colors = header.colors(options.space)?;
    let Header { width, height, channels, bits, .. } = header;
    let pixels = width as usize * height as usize;
    let [whole, unpadded] = header.data_bytes();
    let turned = if header.orientation.is_some() { 16 * pixels as u64 } else { 0 };
    let extra = whole.max(unpadded) as u64 + (2 * pixels * channels) as u64 + turned;
    options.budget.check((width.into(), height.into()), colors.bytes_of_sample(bits), extra)?;
    reader.seek(SeekFrom::Start(header.data.into())).map_err(|error| CodecError::reading(&error))?;
    let mut data = Vec::new();
    reader.take(whole as u64).read_to_end(&mut data).map_err(|error| CodecError::reading(&error))?;
    let bytes = header.codes(&data)?;
    let alpha = match (channels == 4, options.premultiplied) {
        (false, _) => Alpha::None,
        (true, true) => Alpha::Premultiply,
        (true, false) => Alpha::Apart,
    };
    Codes { bytes, bits, channels, alpha, pixels }.into_picture([width, height], colors, header.orientation)
}

pub(crate) fn describe(mut reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let header = Header::read(&mut reader)?;
    let mut colors = header.colors(None).unwrap_or_else(|_| Colors::of_film());
    let size = header.orientation.unwrap_or(Orientation::UPRIGHT).size(header.width, header.height);
    colors.notes.extend(header.orientation.map(Orientation::note));
    let names: &[&str] = match header.channels {
        1 => &["Y"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let samples = match header.bits {
        8 => "8 bits",
        10 => "10 bits",
        12 => "12 bits",
        _ => "16 bits",
    };
    Ok(colors.describe(Description::of_picture("DPX", size, names, samples, "none")))
}

struct Header {
    is_little: bool,
    /// The byte where the picture starts.
    data: u32,
    width: u32,
    height: u32,
    /// Gray, RGB or RGBA.
    channels: usize,
    /// True if alpha comes first, and red last.
    is_reversed: bool,
    bits: u32,
    /// True if codes fill the lower bits of their words, and not the upper ones.
    is_low: bool,
    /// Bytes after each row.
    padding: usize,
    transfer: u8,
    orientation: Option<Orientation>,
}

impl Header {
    fn read(reader: &mut impl BufRead) -> Result<Self, CodecError> {
        let mut bytes = [0; HEADER];
        reader.read_exact(&mut bytes).map_err(|error| CodecError::reading(&error))?;
        let is_little = bytes.starts_with(b"XPDS");
        let long = |at: usize| {
            let number = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
            if is_little { u32::from_le_bytes(number) } else { u32::from_be_bytes(number) }
        };
        let short = |at: usize| {
            let number = [bytes[at], bytes[at + 1]];
            if is_little { u16::from_le_bytes(number) } else { u16::from_be_bytes(number) }
        };
        if !matches!(short(770), 0 | 1 | u16::MAX) {
            return Err(unsupported("its channels are pictures of their own"));
        }
        if long(780) == 1 {
            return Err(unsupported("its codes are signed"));
        }
        if short(806) == 1 {
            return Err(unsupported("it is compressed"));
        }
        let (channels, is_reversed) = match bytes[800] {
            6 => (1, false),
            50 => (3, false),
            51 => (4, false),
            52 => (4, true),
            other => return Err(unsupported(&format!("its channels are those of descriptor {other}"))),
        };
        let bits = u32::from(bytes[803]);
        let is_low = match (bits, short(804)) {
            (8 | 16, _) | (10 | 12, 1) => false,
            (10 | 12, 2) => true,
            (10 | 12, _) => return Err(unsupported(&format!("its codes of {bits} bits are packed without gaps"))),
            _ => return Err(unsupported(&format!("its codes have {bits} bits"))),
        };
        if (bits, channels) == (10, 1) {
            return Err(unsupported("gray of 10 bits, which programs pack in several orders"));
        }
        let data = long(4);
        if (data as usize) < HEADER {
            return Err(CodecError::broken("its picture starts inside of its header"));
        }
        let padding = if long(812) == UNSTATED { 0 } else { long(812) as usize };
        let orientation =
            ORIENTATIONS.get(usize::from(short(768))).and_then(|orientation| Orientation::of_code(*orientation));
        let (width, height, transfer) = (long(772), long(776), bytes[801]);
        crate::codec::limits::check_sides((width.into(), height.into()))?;
        Ok(Self { is_little, data, width, height, channels, is_reversed, bits, is_low, padding, transfer, orientation })
    }

    fn colors(&self, space: Option<ColorSpace>) -> Result<Colors, CodecError> {
        let stated = |transfer| Colors::new(Some((Chromaticities::REC709, transfer)), None).stated_by("transfer");
        Ok(match (space, self.transfer) {
            (Some(space), _) => Colors::new(Some((space.primaries, space.transfer)), None),
            (None, 1 | 3) => Colors::of_film().stated_by("transfer"),
            (None, 2) => stated(Transfer::Linear),
            // The display of ITU-R BT.1886, as for films.
            (None, 4..=8) => stated(Transfer::Gamma(Decimal::new(2.4))),
            (None, other @ 9..=13) => {
                return Err(unsupported(&format!("its transfer characteristic is {other}"))
                    .hint("name the space of its codes with `--input-space`"));
            }
            (None, _) => Colors::new(None, None),
        })
    }

    /// Bytes of a row of codes.
    fn row_bytes(&self) -> usize {
        let codes = self.width as usize * self.channels;
        match self.bits {
            8 => codes,
            10 => codes.div_ceil(3) * 4,
            _ => 2 * codes,
        }
    }

    /// Bytes of the picture: with rows that start at words of four bytes, and as some programs write it, without.
    fn data_bytes(&self) -> [usize; 2] {
        let row = self.row_bytes();
        [row.next_multiple_of(4), row].map(|row| row.saturating_add(self.padding).saturating_mul(self.height as usize))
    }

    /// The codes in their order, as [`Codes`] has them.
    fn codes(&self, data: &[u8]) -> Result<Vec<u8>, CodecError> {
        let [whole, unpadded] = self.data_bytes();
        let row = if data.len() == unpadded { unpadded } else { whole } / self.height as usize;
        let count = self.width as usize * self.channels;
        let mut codes = Vec::with_capacity(count * self.height as usize * if self.bits == 8 { 1 } else { 2 });
        for start in (0..self.height as usize).map(|index| index * row) {
            let row = data.get(start..start + self.row_bytes()).ok_or_else(CodecError::cut_short)?;
            if self.bits == 8 {
                codes.extend_from_slice(row);
            } else {
                codes.extend((0..count).flat_map(|index| self.code(row, index).to_be_bytes()));
            }
        }
        if self.is_reversed {
            codes.chunks_mut(if self.bits == 8 { 4 } else { 8 }).for_each(|pixel| {
                pixel.reverse();
                if self.bits != 8 {
                    pixel.chunks_mut(2).for_each(<[u8]>::reverse);
                }
            });
        }
        Ok(codes)
    }

    /// A code of more than 8 bits.
    fn code(&self, row: &[u8], index: usize) -> u16 {
        let word = |bytes: &[u8]| {
            let shifted = |sum: u32, byte: &u8| sum << 8 | u32::from(*byte);
            if self.is_little { bytes.iter().rev().fold(0, shifted) } else { bytes.iter().fold(0, shifted) }
        };
        match self.bits {
            // Three of them in a word, the first one in its upper bits.
            10 => {
                let low = if self.is_low { 0 } else { 2 };
                (word(&row[index / 3 * 4..][..4]) >> (low + 20 - 10 * (index % 3)) & 0x3ff) as u16
            }
            12 if !self.is_low => (word(&row[2 * index..][..2]) >> 4) as u16,
            12 => (word(&row[2 * index..][..2]) & 0xfff) as u16,
            _ => word(&row[2 * index..][..2]) as u16,
        }
    }
}

fn unsupported(what: &str) -> CodecError {
    CodecError::new(ErrorKind::Unsupported, format!("this DPX cannot be read: {what}"))
        .hint("write it again in RGB of 10 bits, as `oiiotool IN.dpx -d uint10 -o OUT.dpx` does")
}
