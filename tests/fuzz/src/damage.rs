//! Damage to files of bytes.

use afterimage_generators::Rng;

/// Numbers that stand for sizes, counts and offsets in headers.
const NUMBERS: [u32; 12] =
    [0, 1, 2, 255, 256, 0x7fff, 0xffff, 0x1_0000, 0x7fff_ffff, 0x8000_0000, 0xffff_fff0, 0xffff_ffff];
/// The end of the header in most files.
const HEADER: usize = 400;

/// The file with one to four changes; of a PNG, mostly with checksums that fit.
pub(crate) fn damaged(file: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=rng.below(4) {
        change(&mut bytes, rng);
    }
    if rng.below(4) > 0 {
        fix_checksums(&mut bytes);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, rng: &mut Rng) {
    // Headers decide most.
    let end = if rng.below(2) == 0 { bytes.len().min(HEADER) } else { bytes.len() };
    let at = rng.below(end);
    match rng.below(10) {
        0 => bytes.truncate(at),
        1 => bytes.extend((0..rng.below(40)).map(|i| i as u8).collect::<Vec<_>>()),
        2 => drop(bytes.drain(at..(at + 1 + rng.below(8)).min(end.max(at)))),
        3 => {
            let again: Vec<u8> = bytes[at..(at + rng.below(64)).min(end.max(at))].to_vec();
            bytes.splice(at..at, again).for_each(drop);
        }
        4..=6 => put_number(bytes, at, rng),
        _ => bytes.get_mut(at).into_iter().for_each(|byte| *byte ^= 1 << rng.below(8)),
    }
}

/// A number of two, four or eight bytes, in either order.
fn put_number(bytes: &mut [u8], at: usize, rng: &mut Rng) {
    let number = u64::from(NUMBERS[rng.below(NUMBERS.len())]);
    let wide = if rng.below(4) == 0 { number << 32 | number } else { number };
    let width = [1, 2, 4, 4, 8][rng.below(5)];
    let mut written = wide.to_le_bytes()[..width].to_vec();
    if rng.below(2) == 0 {
        written.reverse();
    }
    bytes.iter_mut().skip(at).zip(written).for_each(|(to, from)| *to = from);
}

/// Gives the chunks of a PNG checksums that fit, as far as their lengths lead.
fn fix_checksums(file: &mut [u8]) {
    let mut at = 8;
    if !file.starts_with(b"\x89PNG") {
        return;
    }
    while let Some(length) = file.get(at..at + 4) {
        let length = u32::from_be_bytes(length.try_into().expect("four bytes")) as usize;
        let end = at.saturating_add(8).saturating_add(length);
        let Some(body) = file.get(at + 4..end) else { return };
        let sum = crc32(body).to_be_bytes();
        if let Some(to) = file.get_mut(end..end + 4) {
            to.copy_from_slice(&sum);
        }
        at = end + 4;
    }
}

/// CRC-32 as PNG has it.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| bit(crc)))
}
