//! Color files of any kind.

use std::borrow::Cow;

use crate::clf::parse_clf;
use crate::lut::text::lines;
use crate::lut::{Lut, LutError, PngLayout, parse_cube, parse_png};
use crate::process::Process;

/// The content of a color file.
#[derive(Clone, Debug, PartialEq)]
pub enum LutFile {
    Table(Lut),
    /// Steps in a row.
    Process(Process),
}

const PNG_SIGNATURE: &[u8] = b"\x89PNG";

/// Parses a color file of any kind, which is recognized by its content. `layout` is that of a PNG.
///
/// # Errors
/// The first error of the parser of its kind, or that it is of no known kind.
pub fn parse_lut_file(bytes: &[u8], layout: PngLayout) -> Result<LutFile, LutError> {
    if bytes.starts_with(PNG_SIGNATURE) {
        return parse_png(bytes, layout).map(LutFile::Table);
    }
    if let Some(what) = foreign(bytes) {
        let message = format!(
            "the file is {what}: `OcioTransform` of a program with the feature `ocio` reads it, or convert it to \
             .cube, as `ociobakelut` does"
        );
        return Err(LutError::new(0, message));
    }
    let known = "the file is neither a table (.cube, .clf) nor a PNG of tiles, into which other pictures are converted";
    let text = &*text_of(bytes).ok_or_else(|| LutError::new(0, known))?;
    match lines(text).next().map(|(_, line)| line.split_whitespace().next().unwrap_or(line)) {
        Some(word) if word.starts_with('<') => parse_clf(text).map(LutFile::Process),
        _ => parse_cube(text).map(LutFile::Table),
    }
}

/// The name of a format that is not read, by the first words of a file.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    if bytes.get(36..40) == Some(b"acsp") {
        return Some("an ICC profile");
    }
    let text = &*text_of(bytes)?;
    if text.starts_with("#Inventor V") {
        return Some("a table of Nuke (.vf)");
    }
    let (_, first) = lines(text).next()?;
    let mut words = first.split_whitespace();
    match words.next()? {
        "CSPLUTV100" => Some("a table of cineSpace (.csp)"),
        "3DMESH" => Some("a table of Lustre or Flame (.3dl)"),
        "SPILUT" => Some("a table of Imageworks (.spi3d)"),
        "Version" if words.next() == Some("3") => Some("a table of Houdini (.lut)"),
        "Version" | "From" | "Length" | "Components" => Some("a table of Imageworks (.spi1d)"),
        // The first line of a mesh has the inputs of all its entries.
        word if is_whole(word) && words.clone().count() > 2 && words.all(is_whole) => {
            Some("a table of Lustre or Flame (.3dl)")
        }
        _ => None,
    }
}

/// The text of a file in UTF-8, in UTF-16 with a byte order mark, or else in Latin-1, as old programs write titles and
/// comments. `None` for other bytes than text.
fn text_of(bytes: &[u8]) -> Option<Cow<'_, str>> {
    if let Ok(text) = std::str::from_utf8(bytes) {
        return (!text.contains('\0')).then_some(Cow::Borrowed(text));
    }
    let from_pair: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => {
            let is_text = bytes.iter().all(|byte| *byte >= b' ' || byte.is_ascii_whitespace());
            return is_text.then(|| bytes.iter().map(|byte| char::from(*byte)).collect());
        }
    };
    let (pairs, rest) = bytes.as_chunks::<2>();
    let text = String::from_utf16(&pairs.iter().map(|pair| from_pair(*pair)).collect::<Vec<_>>()).ok();
    text.filter(|_| rest.is_empty()).map(Cow::Owned)
}

fn is_whole(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_another_program_is_named() {
        for (text, name) in [
            ("# comment\n0 64 128 192 256\n0 0 0\n0 0 64\n", ".3dl"),
            ("3DMESH\nMesh 4 12\n0 64 128\n", ".3dl"),
            ("CSPLUTV100\n3D\n", ".csp"),
            ("#Inventor V2.1 ascii\n", ".vf"),
            ("Version\t\t3\nType\t\tRGB\n", ".lut"),
            ("Version 1\nFrom 0 1\nLength 2\n", ".spi1d"),
            ("SPILUT 1.0\n3 3\n2 2 2\n", ".spi3d"),
        ] {
            let error = parse_lut_file(text.as_bytes(), PngLayout::Tiles).expect_err("it is not read");
            assert!(error.message.contains(name), "{}", error.message);
        }
        let entries = "LUT_3D_SIZE 2\n".to_owned() + &"0 1 0\n".repeat(8);
        assert!(parse_lut_file(entries.as_bytes(), PngLayout::Tiles).is_ok());
    }

    #[test]
    fn the_letters_of_a_title_are_no_reason_to_refuse_a_table() {
        let table = "TITLE \"M\u{fc}nchen\"\r\n# \u{a9}\r\nLUT_3D_SIZE\t2\r\n".to_owned() + &"0\t1 0\r\n".repeat(8);
        let latin: Vec<u8> = table.chars().map(|letter| letter as u8).collect();
        let wide =
            |order: fn(u16) -> [u8; 2]| "\u{feff}".encode_utf16().chain(table.encode_utf16()).flat_map(order).collect();
        let marked = format!("\u{feff}{table}").into_bytes();
        let returns = table.replace('\n', "").into_bytes();
        let expected = parse_lut_file(table.as_bytes(), PngLayout::Tiles).expect("a table");
        for bytes in [latin, wide(u16::to_le_bytes), wide(u16::to_be_bytes), marked, returns] {
            assert_eq!(parse_lut_file(&bytes, PngLayout::Tiles).as_ref(), Ok(&expected), "{bytes:?}");
        }
        for binary in [&b"\0\x01\x02\xff"[..], b"\xff\xfe\0", b"PK\x03\x04\xff"] {
            let message = parse_lut_file(binary, PngLayout::Tiles).expect_err("no text").message;
            assert!(message.contains("neither a table"), "{message}");
        }
    }
}
