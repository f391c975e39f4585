//! The chunks before the pixels of a PNG. Color chunks are taken out of the stream, so that a broken or unknown one
//! does not prevent decoding.

use std::io::{self, BufRead, Chain, Cursor, Read, Seek, SeekFrom};

use fdeflate::decompress_to_vec_bounded;

use crate::codec::limits::{MAX_PNG_EXTRAS, too_large};
use crate::codec::{CodecError, icc};

/// A chunk that may be broken, with the reason.
pub(super) type Stated<T> = Option<Result<T, &'static str>>;

/// Content of the chunks before the pixels that the decoder does not read.
#[derive(Default)]
pub(super) struct Chunks {
    /// `cICP`: primaries, transfer function, matrix and range.
    pub(super) cicp: Stated<[u8; 4]>,
    pub(super) profile: Stated<Vec<u8>>,
    pub(super) srgb: Stated<()>,
    pub(super) gamma: Stated<f64>,
    /// `cHRM`: x and y of white, red, green and blue.
    pub(super) chromaticities: Stated<[f64; 8]>,
    /// `mDCV`: the peak of the mastering display in cd/m2.
    pub(super) mastering_peak: Option<f64>,
    pub(super) exif: Option<Vec<u8>>,
    pub(super) is_animated: bool,
    pub(super) has_gain_map: bool,
}

/// The names of chunks that are taken out; others are passed over, unless decoding needs them.
const READ: [&[u8; 4]; 8] = [b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM", b"mDCV", b"eXIf", b"acTL"];

/// The file for the decoder: what it needs of the chunks, and all from the first pixel on.
pub(super) type Rest<R> = Forward<Chain<Cursor<Vec<u8>>, R>>;

/// Reads up to the first pixel.
///
/// # Errors
/// A file that is cut short, and more than [`MAX_PNG_EXTRAS`] bytes of chunks.
pub(super) fn read<R: BufRead>(mut reader: R) -> Result<(Chunks, Rest<R>), CodecError> {
    let mut chunks = Chunks::default();
    let mut kept = vec![0; 8];
    reader.read_exact(&mut kept).map_err(|error| CodecError::reading(&error))?;
    loop {
        let mut head = [0; 8];
        reader.read_exact(&mut head).map_err(|error| CodecError::reading(&error))?;
        let [l0, l1, l2, l3, name @ ..] = head;
        let length = u64::from(u32::from_be_bytes([l0, l1, l2, l3]));
        if name == *b"IDAT" || name == *b"IEND" {
            kept.extend(head);
            return Ok((chunks, Forward(Cursor::new(kept).chain(reader))));
        }
        // The name, the data and the checksum.
        let mut body = name.to_vec();
        let is_kept = name[0].is_ascii_uppercase() || name == *b"tRNS";
        if !is_kept && !READ.contains(&&name) {
            chunks.has_gain_map |= name == *b"gmAP";
            let passed = io::copy(&mut reader.by_ref().take(length + 4), &mut io::sink());
            passed.map_err(|error| CodecError::reading(&error))?;
            continue;
        }
        if length + kept.len() as u64 > MAX_PNG_EXTRAS as u64 {
            return Err(too_large("decoding it needs too much memory"));
        }
        let read = reader.by_ref().take(length + 4).read_to_end(&mut body);
        if read.map_err(|error| CodecError::reading(&error))? as u64 != length + 4 {
            return Err(CodecError::cut_short());
        }
        if is_kept {
            kept.extend(&head[..4]);
            kept.extend(&body);
            continue;
        }
        let (data, checksum) = body.split_at(body.len() - 4);
        chunks.take(name, &data[4..], crc32(data).to_be_bytes() == checksum);
    }
}

impl Chunks {
    fn take(&mut self, name: [u8; 4], data: &[u8], is_whole: bool) {
        match &name {
            b"cICP" => set(&mut self.cicp, is_whole, data.try_into().map_err(|_| LENGTH)),
            b"iCCP" => set(&mut self.profile, is_whole, unpacked(data)),
            b"sRGB" => set(&mut self.srgb, is_whole, if data.len() == 1 { Ok(()) } else { Err(LENGTH) }),
            b"gAMA" => set(&mut self.gamma, is_whole, words(data).map(|[gamma]| f64::from(gamma) / 1e5)),
            b"cHRM" => {
                let numbers = words(data).map(|numbers| numbers.map(|number| f64::from(number as i32) / 1e5));
                set(&mut self.chromaticities, is_whole, numbers);
            }
            b"mDCV" if is_whole => {
                let peak = data.get(16..20).and_then(|peak| words(peak).ok());
                self.mastering_peak = peak.map(|[peak]| f64::from(peak) / 1e4);
            }
            b"eXIf" if is_whole => self.exif = Some(data.to_owned()),
            b"acTL" => self.is_animated = words(data.get(..4).unwrap_or_default()).is_ok_and(|[frames]| frames > 1),
            _ => {}
        }
    }
}

const LENGTH: &str = "its length is wrong";

/// The first of several chunks of a name counts.
fn set<T>(slot: &mut Stated<T>, is_whole: bool, value: Result<T, &'static str>) {
    slot.get_or_insert(if is_whole { value } else { Err("its checksum is wrong") });
}

fn words<const N: usize>(data: &[u8]) -> Result<[u32; N], &'static str> {
    let (words, rest) = data.as_chunks::<4>();
    let words: [[u8; 4]; N] = words.try_into().map_err(|_| LENGTH)?;
    if rest.is_empty() { Ok(words.map(u32::from_be_bytes)) } else { Err(LENGTH) }
}

/// The profile after its name and the method of compression.
fn unpacked(data: &[u8]) -> Result<Vec<u8>, &'static str> {
    let name = data.iter().take(80).position(|byte| *byte == 0).filter(|length| *length > 0);
    match name.map(|length| &data[length + 1..]) {
        Some([0, packed @ ..]) => {
            decompress_to_vec_bounded(packed, MAX_PNG_EXTRAS).map_err(|_| "its compressed data is damaged")
        }
        _ => Err(icc::UNREADABLE),
    }
}

/// CRC-32 as PNG defines it (annex D).
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc));
    !bytes.iter().fold(!0, byte)
}

/// A reader that only goes forward. The decoder asks for one that could seek, and never does.
pub(super) struct Forward<R>(R);

impl<R: Read> Read for Forward<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl<R: BufRead> BufRead for Forward<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.0.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.0.consume(amount);
    }
}

impl<R> Seek for Forward<R> {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }
}
