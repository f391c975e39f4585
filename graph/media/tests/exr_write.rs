//! What is written is what is read back.

use std::io::Cursor;

use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use afterimage_base::color::Chromaticities;
use half::f16;

use super::{Folder, ODD_SIZES, numbers, picture};
use afterimage_media::*;

const ALL: [ExrCompression; 5] =
    [ExrCompression::None, ExrCompression::Rle, ExrCompression::Zip, ExrCompression::Zips, ExrCompression::Piz];

fn encoded(picture: &Picture, options: &Encoding) -> Vec<u8> {
    encode(picture, options).unwrap()
}

/// The bytes of an attribute of the header.
pub(super) fn attribute<'f>(file: &'f [u8], name: &str, ty: &str) -> &'f [u8] {
    let start = format!("{name}\0{ty}\0");
    let at = file.windows(start.len()).position(|bytes| bytes == start.as_bytes()).expect("the header has it");
    let (length, value) = file[at + start.len()..].split_at(4);
    &value[..u32::from_le_bytes(length.try_into().expect("four bytes")) as usize]
}

/// The codes of OpenEXR.
#[test]
fn the_header_names_the_compression_and_the_window() {
    let picture = Picture::new(3, 2, Pixels::Float(vec![0.5; 24]));
    for (compression, code) in ExrCompression::ALL.into_iter().zip(0..) {
        let file = encoded(&picture, &Encoding { compression, ..Encoding::EXR });
        assert_eq!(attribute(&file, "compression", "compression"), [code], "{compression:?}");
        for window in ["dataWindow", "displayWindow"] {
            let sides = [0_i32, 0, 2, 1].map(i32::to_le_bytes);
            assert_eq!(attribute(&file, window, "box2i"), sides.as_flattened(), "{window}");
        }
    }
}

/// The header says `increasing`, and rows are written as they come: a reader from a pipe needs both.
#[test]
fn blocks_lie_in_the_file_from_the_first_row_to_the_last() {
    for compression in [ExrCompression::None, ExrCompression::Zip, ExrCompression::Piz] {
        let file = encoded(&picture(33, 70), &Encoding { compression, ..Encoding::EXR });
        assert_eq!(attribute(&file, "lineOrder", "lineOrder"), [0]);
        let reader = ::exr::block::read(Cursor::new(file.as_slice()), true).expect("the header is valid");
        let chunks = reader.all_chunks(true).expect("the table is valid");
        let first_row = |chunk: ::exr::error::Result<Chunk>| match chunk.expect("it is whole").compressed_block {
            CompressedBlock::ScanLine(block) => block.y_coordinate,
            _ => panic!("tiles and deep pixels are not written"),
        };
        let rows: Vec<i32> = chunks.map(first_row).collect();
        assert!(rows.len() > 2 && rows.is_sorted(), "{compression:?}: {rows:?}");
    }
}

/// B44 keeps six bits of 4x4 pixels, PXR24 16 bits of a float, DWA what eyes see. Flat alpha stays 1 in all of them.
#[test]
fn compressions_with_losses_keep_the_picture() {
    use ExrCompression::{B44, B44a, Dwaa, Dwab, Pxr24};
    let folder = Folder::new("losses");
    let light = |i: usize| 0.2 + 0.1 * ((i / 4 % 61) as f32 / 20.0).sin();
    let values = (0..61 * 37 * 4).map(|i| if i % 4 == 3 { 1.0 } else { light(i) }).collect();
    let smooth = Picture::new(61, 37, Pixels::Float(values));
    for (compression, most) in [(Pxr24, 1e-5), (B44, 5e-3), (B44a, 5e-3), (Dwaa, 5e-2), (Dwab, 5e-2)] {
        let bits = if compression == Pxr24 { 32 } else { 16 };
        let back = folder.read(&encoded(&smooth, &Encoding { compression, bits, ..Encoding::EXR })).unwrap();
        let (back, there) = (back.pixels.to_f32(), smooth.pixels.to_f32());
        let off = back.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < most && off > 0.0, "{compression:?}: {off}");
        assert!(back.iter().skip(3).step_by(4).all(|alpha| *alpha == 1.0), "{compression:?}");
    }
}

fn bits(pixels: &Pixels) -> Vec<u32> {
    match pixels {
        Pixels::Half(values) => values.iter().map(|v| v.to_bits().into()).collect(),
        Pixels::Float(values) => values.iter().map(|v| v.to_bits()).collect(),
    }
}

#[test]
fn half_and_float_come_back_bit_for_bit() {
    let folder = Folder::new("round");
    for (width, height) in ODD_SIZES {
        let mut values = numbers(width, height);
        values[0] = f32::NAN;
        values[1] = f32::NEG_INFINITY;
        values[2] = 65504.0;
        let half = values.iter().map(|v| f16::from_f32(*v)).collect();
        for pixels in [Pixels::Half(half), Pixels::Float(values)] {
            let picture = Picture::new(width, height, pixels);
            let depth = 8 * picture.pixels.bytes_per_channel() as u32;
            for compression in ALL {
                let options = Encoding { bits: depth, compression, ..Encoding::EXR };
                let back = folder.read(&encoded(&picture, &options)).unwrap();
                assert_eq!((back.width, back.height), (width, height));
                assert_eq!(bits(&back.pixels), bits(&picture.pixels), "{compression:?}");
            }
        }
    }
}

#[test]
fn floats_beyond_half_stay_finite_and_alpha_can_be_left_out() {
    let values = vec![1e9, -1e9, f32::INFINITY, 0.25];
    let picture = Picture::new(1, 1, Pixels::Float(values));
    let options = Encoding { alpha: Alpha::Drop, ..Encoding::EXR };
    let back = Folder::new("beyond").read(&encoded(&picture, &options)).unwrap();
    assert_eq!(back.pixel(0, 0), [65504.0, -65504.0, f32::INFINITY, 1.0]);
    assert_eq!(back.pixels.bytes_per_channel(), 2);
}

#[test]
fn equal_pictures_give_equal_bytes() {
    // Each map has its own random order, so the second map would be written in another one.
    let make = || {
        let mut picture = picture(40, 40);
        (0..12).for_each(|i| picture.meta.set_number(&format!("number{i}"), i as f32));
        encoded(&picture, &Encoding::EXR)
    };
    let first = make();
    assert!((0..4).all(|_| make() == first));
}

#[test]
fn attributes_and_windows_survive() {
    let mut picture = picture(6, 4);
    picture.meta.set_text("lens", "50 mm ☂");
    picture.meta.set_number("gain", 2.5);
    picture.meta.layer.owner = Text::new_or_none("somebody");
    picture.meta.layer.multi_view_names = Some(vec!["left".into(), "right".into()]);
    picture.meta.image.pixel_aspect = 2.0;
    picture.meta.image.display_window = IntegerBounds::new((-7, 9), (6, 4));
    let back = Folder::new("attributes").read(&encoded(&picture, &Encoding::EXR)).unwrap();
    let custom = |name: &str| back.meta.layer.other.get(&Text::new_or_none(name).unwrap()).cloned();
    assert_eq!(custom("lens"), Some(AttributeValue::Text("50 mm ?".into())));
    assert_eq!(custom("gain"), Some(AttributeValue::F32(2.5)));
    assert_eq!(back.meta.layer.owner, picture.meta.layer.owner);
    assert_eq!(back.meta.layer.multi_view_names, None, "there is one view now");
    assert_eq!(back.meta.image.pixel_aspect, 2.0);
    assert_eq!(back.meta.image.display_window, IntegerBounds::new((-7, 9), (6, 4)));
    assert_eq!(back.meta.layer.layer_position, (-7, 9).into());
    assert_eq!(back.meta.image.chromaticities.unwrap().green, (0.3, 0.6).into());
}

#[test]
fn a_picture_of_another_size_gets_a_window_of_its_own() {
    let mut small = picture(3, 2);
    small.meta.image.display_window = IntegerBounds::new((5, 5), (100, 100));
    let back = Folder::new("resized").read(&encoded(&small, &Encoding::EXR)).unwrap();
    assert_eq!(back.meta.image.display_window, IntegerBounds::new((0, 0), (3, 2)));
}

/// A file may state a type that is empty, which is read as one of a zero.
#[test]
fn attributes_without_an_end_are_left_out() {
    let mut odd = picture(2, 2);
    let text = |text: &str| Text::new_or_none(text).expect("each letter is a byte");
    let custom = |kind: &str| AttributeValue::Custom { kind: text(kind), bytes: [1, 2].into_iter().collect() };
    let attributes =
        [("empty", ""), ("zero", "\0"), ("inside", "a\0b"), ("", "kind"), ("a\0b", "kind"), ("kept", "kind")];
    odd.meta.layer.other.extend(attributes.map(|(name, kind)| (text(name), custom(kind))));
    odd.meta.image.other.extend([(text("sc"), custom("\0")), (text("shared"), custom("kind"))]);
    let back = Folder::new("endless-attributes").read(&encoded(&odd, &Encoding::EXR)).unwrap();
    let names =
        |name: &str| back.meta.layer.other.contains_key(&text(name)) || back.meta.image.other.contains_key(&text(name));
    assert_eq!(["empty", "zero", "inside", "a", "sc"].map(names), [false; 5]);
    assert_eq!(["kept", "shared"].map(names), [true; 2]);
    assert_eq!(back.pixel(1, 1)[0], f16::from_f32(odd.pixel(1, 1)[0]).to_f32());
}

#[test]
fn attributes_that_would_contradict_the_file_are_left_out() {
    let mut odd = picture(2, 2);
    odd.meta.set_number("compression", 1.0);
    odd.meta.image.pixel_aspect = f32::NAN;
    let back = Folder::new("odd-attributes").read(&encoded(&odd, &Encoding::EXR)).unwrap();
    assert_eq!(back.meta.image.pixel_aspect, 1.0);
    assert_eq!(back.pixel(1, 1)[0], f16::from_f32(odd.pixel(1, 1)[0]).to_f32());
}

/// OpenEXR refuses a file with a negative one.
#[test]
fn no_screen_window_has_a_negative_width() {
    for (width, written) in [(-2.0, 0.0), (f32::NAN, 0.0), (0.0, 0.0), (1.5, 1.5)] {
        let mut picture = picture(2, 2);
        picture.meta.layer.screen_window_width = width;
        let back = Folder::new("screen-window").read(&encoded(&picture, &Encoding::EXR)).unwrap();
        assert_eq!(back.meta.layer.screen_window_width, written, "{width}");
    }
}

/// `acesImageContainerFlag` and `colorInteropID` name the primaries of the input, and `cryptomatte/*` its channels. The
/// written file has other ones.
#[test]
fn what_describes_the_pixels_of_the_input_is_not_copied() {
    let mut aces = picture(2, 2);
    aces.meta.set_number("gain", 2.5);
    for name in ["acesImageContainerFlag", "colorInteropID", "cryptomatte/8a3c/name"] {
        aces.meta.set_text(name, "lin_ap0_scene");
        aces.meta.image.other.insert(Text::new_or_none(name).unwrap(), AttributeValue::I32(1));
    }
    let back = Folder::new("old-pixels").read(&encoded(&aces, &Encoding::EXR)).unwrap();
    let names: Vec<String> =
        back.meta.layer.other.keys().chain(back.meta.image.other.keys()).map(Text::to_string).collect();
    assert_eq!(names, ["gain"]);
}

#[test]
fn primaries_that_only_a_name_states_are_converted() {
    let unlabeled = Encoding { color: None, bits: 32, ..Encoding::EXR };
    let flag = ("acesImageContainerFlag", AttributeValue::I32(1), Chromaticities::ACES_AP0);
    let id = |id: &str| AttributeValue::Text(id.into());
    let named = [
        flag,
        ("colorInteropID", id("lin_ap0_scene"), Chromaticities::ACES_AP0),
        ("colorInteropID", id("lin_ap1_scene"), Chromaticities::ACES_CG),
        ("colorInteropID", id("lin_rec2020_scene"), Chromaticities::REC2020),
        ("colorInteropID", id("lin_p3d65_scene"), Chromaticities::DISPLAY_P3),
        ("colorInteropID", id("lin_rec709_scene"), Chromaticities::REC709),
        ("colorInteropID", id("data"), Chromaticities::REC709),
        ("acesImageContainerFlag", AttributeValue::I32(0), Chromaticities::REC709),
    ];
    for (name, value, primaries) in named {
        let mut picture = Picture::new(1, 1, Pixels::Float(vec![0.25, 0.5, 0.125, 1.0]));
        picture.meta.image.chromaticities = None;
        picture.meta.layer.other.insert(Text::new_or_none("unused").unwrap(), AttributeValue::I32(0));
        let file = with_attribute(&encoded(&picture, &unlabeled), name, &value);
        let back = Folder::new("named-primaries").read(&file).unwrap();
        let expected = primaries.conversion(&Chromaticities::REC709) * glam::DVec3::new(0.25, 0.5, 0.125);
        let [r, g, b, _] = back.pixel(0, 0).map(f64::from);
        assert!(expected.abs_diff_eq(glam::DVec3::new(r, g, b), 1e-6), "{name}, {value:?}: {r} {g} {b}, {expected}");
    }
}

/// The file with the attribute `unused` replaced, since the writer does not write these names. The table of offsets is
/// moved by what the header grows.
pub(super) fn with_attribute(file: &[u8], name: &str, value: &AttributeValue) -> Vec<u8> {
    let (kind, bytes) = match value {
        AttributeValue::I32(number) => ("int", number.to_le_bytes().to_vec()),
        AttributeValue::Text(text) => ("string", text.to_string().into_bytes()),
        other => panic!("not used here: {other:?}"),
    };
    let old = b"unused\0int\0\x04\0\0\0\0\0\0\0";
    let at = file.windows(old.len()).position(|part| part == old).unwrap();
    let length = (bytes.len() as u32).to_le_bytes();
    let new = [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, &bytes].concat();
    let mut moved = [&file[..at], &new, &file[at + old.len()..]].concat();
    // One row: the table has one offset, right before the block, which begins with its row.
    let end_of_header = moved.len() - (file.len() - header_length(file));
    let offset = end_of_header as u64 + 8;
    moved[end_of_header..end_of_header + 8].copy_from_slice(&offset.to_le_bytes());
    moved
}

/// Up to the zero that ends the attributes.
pub(super) fn header_length(file: &[u8]) -> usize {
    let mut at = 8;
    while file[at] != 0 {
        for _ in 0..2 {
            at += file[at..].iter().position(|byte| *byte == 0).unwrap() + 1;
        }
        at += 4 + u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    }
    at + 1
}

#[test]
fn rows_give_the_bytes_of_the_whole() {
    let folder = Folder::new("exr-rows");
    let (width, height) = (37, 301);
    let mut values = numbers(width, height);
    (values[0], values[5]) = (f32::NAN, f32::INFINITY);
    let half = values.iter().map(|v| f16::from_f32(*v)).collect();
    let row = 4 * width as usize;
    for (pixels, steps) in [(Pixels::Half(half), [1, 5, 300]), (Pixels::Float(values), [16, 77, 301])] {
        let mut picture = Picture::new(width, height, pixels);
        picture.meta.image.other.insert(Text::from("zebra"), AttributeValue::I32(7));
        picture.meta.layer.other.insert(Text::from("ape"), AttributeValue::F32(0.5));
        let part = |first: usize, end: usize| match &picture.pixels {
            Pixels::Half(values) => Samples::Half(&values[first * row..end * row]),
            Pixels::Float(values) => Samples::Float(&values[first * row..end * row]),
        };
        for (compression, step) in ExrCompression::ALL.into_iter().zip(steps.into_iter().cycle()) {
            for (bits, alpha, primaries) in [(16, Alpha::Keep, None), (32, Alpha::Drop, Some(Chromaticities::REC2020))]
            {
                let options = Encoding { compression, bits, alpha, primaries, scene: true, ..Encoding::EXR };
                let path = folder.file("rows.exr");
                let mut rows = ImageFile::begin(&path, (width, height), &options, Some(&picture.meta)).unwrap();
                for first in (0..height as usize).step_by(step) {
                    rows.write(part(first, (first + step).min(height as usize))).unwrap();
                }
                rows.finish().unwrap();
                assert!(
                    std::fs::read(path).unwrap() == encoded(&picture, &options),
                    "{options:?}, {step} rows at a time"
                );
            }
        }
    }
}

#[test]
fn rows_of_a_jpeg_give_the_bytes_of_the_whole() {
    let folder = Folder::new("jpeg-rows");
    let (width, height) = (37, 301);
    let values = numbers(width, height);
    for (quality, dither, step) in [(92, Some(3), 1), (60, None, 100), (100, Some(0), 301)] {
        let options = Encoding { quality, dither, ..Encoding::JPEG };
        let path = folder.file("rows.jpg");
        let mut rows = ImageFile::begin(&path, (width, height), &options, None).unwrap();
        for part in values.chunks(4 * width as usize * step) {
            rows.write(Samples::Float(part)).unwrap();
        }
        rows.finish().unwrap();
        let whole = encode(((width, height), Samples::Float(&values)), &options).unwrap();
        assert!(std::fs::read(path).unwrap() == whole, "{step} rows at a time");
    }
}

/// A disk with room for so many bytes.
struct Full(u64);

impl std::io::Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len() as u64).ok_or(std::io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::io::Seek for Full {
    fn seek(&mut self, _: std::io::SeekFrom) -> std::io::Result<u64> {
        Ok(0)
    }
}

#[test]
fn rows_of_a_full_disk_are_an_error() {
    let size = (9, 40);
    let samples = [0.25; 9 * 40 * 4];
    let stored = Encoding { compression: ExrCompression::None, ..Encoding::EXR };
    for (room, encoding) in [(0, stored), (200, stored), (700, stored), (10, Encoding::JPEG), (10, Encoding::PNG)] {
        let written = row_writer(Box::new(Full(room)), size, &encoding, None).and_then(|(mut rows, _)| {
            rows.write(Samples::Float(&samples))?;
            rows.finish()
        });
        assert!(written.is_err_and(|error| error.message == "the disk is full"), "{room}");
    }
}
