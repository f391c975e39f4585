//! Files that are broken or lie, made from whole ones.

use afterimage_media::{Encoding, Samples, encode};

use super::room;

/// An EXR of two blocks.
pub(super) fn exr() -> Vec<u8> {
    let options = Encoding::EXR;
    encode(&room(33, 17), &options).expect("a picture of a test can be encoded")
}

pub(super) fn png() -> Vec<u8> {
    let codes: Vec<u8> = (0..16 * 9 * 4).map(|i| (i * 37 % 251) as u8).collect();
    let options = Encoding::PNG;
    encode(((16, 9), Samples::Byte(&codes)), &options).expect("a picture can be encoded")
}

pub(super) fn hdr(width: u32, height: u32, bytes: usize) -> Vec<u8> {
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    [header.into_bytes(), vec![77; bytes]].concat()
}

/// The first N of a thousand parts.
pub(super) fn cut(file: &[u8], thousandths: usize) -> Vec<u8> {
    file[..file.len() * thousandths / 1000].to_vec()
}

fn place_of(file: &[u8], text: &[u8]) -> usize {
    file.windows(text.len()).position(|window| window == text).expect("the text is in the file")
}

/// Where the value of an EXR attribute begins: after its name, its type and its length.
fn value_of(file: &[u8], name: &str) -> usize {
    let kind = place_of(file, format!("{name}\0").as_bytes()) + name.len() + 1;
    kind + place_of(&file[kind..], b"\0") + 1 + 4
}

fn put(file: &mut [u8], at: usize, numbers: &[i32]) {
    for (to, number) in file[at..].chunks_exact_mut(4).zip(numbers) {
        to.copy_from_slice(&number.to_le_bytes());
    }
}

/// With another window, given by its corners.
pub(super) fn window(name: &str, corners: [i32; 4]) -> Vec<u8> {
    let mut file = exr();
    let at = value_of(&file, name);
    put(&mut file, at, &corners);
    // The number of blocks would contradict the window; old files do not state it.
    let count = place_of(&file, b"chunkCount");
    file[count] = b'C';
    file
}

/// Says that its pixels hold many samples.
pub(super) fn deep() -> Vec<u8> {
    let mut file = exr();
    let at = value_of(&file, "type");
    put(&mut file, at - 4, &[12]);
    file.splice(at..at + 13, *b"deepscanline");
    file
}

/// Says that one channel has a third of the columns.
pub(super) fn subsampled() -> Vec<u8> {
    let mut file = exr();
    // A channel is its name, its type, linearity with three spare bytes, and two rates.
    let at = value_of(&file, "channels") + 2 + 4 + 4;
    put(&mut file, at, &[3, 1]);
    file
}

/// Says that its channels have a type that does not exist.
pub(super) fn unknown_type() -> Vec<u8> {
    let mut file = exr();
    let at = value_of(&file, "channels") + 2;
    put(&mut file, at, &[77]);
    file
}

/// Says that it is compressed in a way that does not exist.
pub(super) fn unknown_compression() -> Vec<u8> {
    let mut file = exr();
    let at = value_of(&file, "compression");
    file[at] = 99;
    file
}

/// An attribute that claims two thousand million bytes.
pub(super) fn endless_attribute() -> Vec<u8> {
    let mut file = exr();
    let at = value_of(&file, "channels");
    put(&mut file, at - 4, &[i32::MAX]);
    file
}

/// Its table of blocks names the first block twice.
pub(super) fn block_twice() -> Vec<u8> {
    let mut file = exr();
    let table = header_end(&file);
    file.copy_within(table..table + 8, table + 8);
    file
}

/// Noise in place of compressed pixels.
pub(super) fn noise() -> Vec<u8> {
    let mut file = exr();
    let pixels = header_end(&file) + 16 + 8;
    for (index, byte) in file[pixels..].iter_mut().enumerate() {
        *byte = (index * 151 % 256) as u8;
    }
    file
}

fn header_end(file: &[u8]) -> usize {
    let skip = |from: usize| from + place_of(&file[from..], b"\0") + 1;
    let mut at = 8;
    while file[at] != 0 {
        let length = skip(skip(at));
        let bytes = file[length..length + 4].try_into().expect("four bytes");
        at = length + 4 + u32::from_le_bytes(bytes) as usize;
    }
    at + 1
}

/// A header of other sizes, with the checksum that fits.
pub(super) fn png_of(width: u32, height: u32) -> Vec<u8> {
    let mut file = png();
    file[16..20].copy_from_slice(&width.to_be_bytes());
    file[20..24].copy_from_slice(&height.to_be_bytes());
    let sum = crc32(&file[12..29]);
    file[29..33].copy_from_slice(&sum.to_be_bytes());
    file
}

/// One bit of the pixels is wrong.
pub(super) fn png_with_a_flipped_bit() -> Vec<u8> {
    let mut file = png();
    let at = place_of(&file, b"IDAT") + 20;
    file[at] ^= 4;
    file
}

/// CRC-32 as PNG has it.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| bit(crc)))
}
