//! Attributes of EXR files: kept byte for byte, or left out with a sentence that names them.

use std::collections::BTreeMap;

use half::f16;

use super::{Folder, message_and_hint, picture};
use afterimage_media::*;

/// A name, a type and the bytes of the value.
type Raw = (&'static str, &'static str, Vec<u8>);

/// A file of 3x2 halves without packing, as its bytes. `channels` are names with the steps of their samples.
pub(super) fn raw(version: u32, channels: &[(&str, i32)], extra: &[Raw]) -> Vec<u8> {
    let word = |number: i32| number.to_le_bytes().to_vec();
    let list: Vec<u8> = channels
        .iter()
        .flat_map(|(name, step)| [name.as_bytes(), &[0], &[1, 0, 0, 0], &[0; 4], &word(*step), &word(*step)].concat())
        .chain([0])
        .collect();
    let window = [0, 0, 2, 1].map(i32::to_le_bytes).concat();
    let one = 1_f32.to_le_bytes().to_vec();
    let mut attributes: Vec<Raw> = vec![
        ("channels", "chlist", list),
        ("compression", "compression", vec![0]),
        ("dataWindow", "box2i", window.clone()),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", vec![0]),
        ("pixelAspectRatio", "float", one.clone()),
        ("screenWindowCenter", "v2f", vec![0; 8]),
        ("screenWindowWidth", "float", one),
    ];
    for attribute in extra {
        attributes.retain(|known| known.0 != attribute.0);
        attributes.push(attribute.clone());
    }
    let mut file = [&[0x76, 0x2f, 0x31, 0x01], &version.to_le_bytes()[..]].concat();
    for (name, kind, value) in attributes {
        file.extend([name.as_bytes(), &[0], kind.as_bytes(), &[0], &word(value.len() as i32), &value].concat());
    }
    file.push(0);
    let row: Vec<u8> = channels.iter().flat_map(|_| [f16::ONE; 3]).flat_map(f16::to_le_bytes).collect();
    let chunk = |y: i32| [word(y), word(row.len() as i32), row.clone()].concat();
    let start = file.len() as u64 + 16;
    file.extend([start, start + 8 + row.len() as u64].map(u64::to_le_bytes).as_flattened());
    [file, chunk(0), chunk(1)].concat()
}

const RGB: [(&str, i32); 3] = [("B", 1), ("G", 1), ("R", 1)];

/// The attributes of the first part of a file, by a parser of our own.
fn attributes(file: &[u8]) -> BTreeMap<String, (String, Vec<u8>)> {
    let mut found = BTreeMap::new();
    let mut at = 8;
    let text = |at: usize| file[at..].split(|byte| *byte == 0).next().unwrap().to_vec();
    while file[at] != 0 {
        let (name, kind) = (text(at), text(at + text(at).len() + 1));
        let value = at + name.len() + kind.len() + 6;
        let length = u32::from_le_bytes(file[value - 4..value].try_into().unwrap()) as usize;
        at = value + length;
        let [name, kind] = [name, kind].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(found.insert(name, (kind, file[value..at].to_vec())).is_none(), "an attribute is there twice");
    }
    found
}

/// Every type of OpenEXR, and some values that the `exr` crate does not write as they are.
fn every_type() -> Vec<Raw> {
    let words = |numbers: &[i32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let bytes = |count: u8| (1..=count).collect::<Vec<u8>>();
    let preview = [words(&[1, 1]), bytes(4)].concat();
    vec![
        ("keyCode", "keycode", words(&[1, 2, 3, 4, 5, 4, 64])),
        ("aKeyCode", "keycode", words(&[9, 8, 7, 6, 5, 4, 3])),
        // Frame 59 of a second.
        ("timeCode", "timecode", words(&[0x59, 0x1234])),
        ("aTimeCode", "timecode", words(&[-1, -1])),
        ("aBox", "box2i", words(&[5, 6, -7, -8])),
        ("originalDataWindow", "box2i", words(&[9, 9, 0, 0])),
        ("aFloatBox", "box2f", bytes(16)),
        ("aList", "chlist", [&b"X\0"[..], &words(&[1, 0, 1, 1]), &[0]].concat()),
        ("aSpace", "chromaticities", bytes(32)),
        ("aPacking", "compression", vec![3]),
        ("aDouble", "double", bytes(8)),
        ("aMap", "envmap", vec![1]),
        ("envmap", "envmap", vec![0]),
        ("aFloat", "float", bytes(4)),
        ("anInt", "int", bytes(4)),
        ("anOrder", "lineOrder", vec![2]),
        ("a33f", "m33f", bytes(36)),
        ("a33d", "m33d", bytes(72)),
        ("a44f", "m44f", bytes(64)),
        ("a44d", "m44d", bytes(128)),
        ("aPreview", "preview", preview),
        ("aRational", "rational", words(&[24000, 1001])),
        ("aText", "string", b"text \xe9 \xff".to_vec()),
        ("anEmptyText", "string", Vec::new()),
        ("owner", "int", bytes(4)),
        ("texts", "stringvector", [words(&[2]), b"ab".to_vec(), words(&[0])].concat()),
        ("noTexts", "stringvector", Vec::new()),
        ("aTile", "tiledesc", [words(&[32, 16]), vec![0x12]].concat()),
        ("a2i", "v2i", bytes(8)),
        ("a2f", "v2f", bytes(8)),
        ("a2d", "v2d", bytes(16)),
        ("a3i", "v3i", bytes(12)),
        ("a3f", "v3f", bytes(12)),
        ("a3d", "v3d", bytes(24)),
        ("floats", "floatvector", bytes(12)),
        ("someBytes", "bytes", [words(&[4]), b"hint".to_vec(), bytes(5)].concat()),
        ("unknown", "ofAnotherProgram", bytes(7)),
        ("a name of more than thirty-one letters", "int", bytes(4)),
        ("aLongType", "a type of more than thirty-one letters", bytes(3)),
    ]
}

/// A file that is read and written: the new file, and the sentences about it.
fn rewritten(folder: &Folder, file: &[u8], way: usize) -> (Vec<u8>, Vec<String>) {
    let source = Source::file(folder.with("original.exr", file));
    let (read, out, options) = (read(&source).unwrap(), folder.file("out.exr"), Encoding::EXR);
    let picture = Picture { meta: read.meta, ..picture(3, 2) };
    let notes = match way {
        0 => write_image(&out, &picture, &options).unwrap(),
        1 => write_beside(&out, &picture, &options, &source, &Budget(1 << 30).into()).unwrap(),
        _ => {
            let mut rows = ImageFile::begin(&out, (3, 2), &options, Some(&picture.meta)).unwrap();
            let notes = rows.notes().to_vec();
            rows.write(Samples::from(&picture.pixels)).unwrap();
            rows.finish().unwrap();
            notes
        }
    };
    (std::fs::read(out).unwrap(), notes)
}

#[test]
fn attributes_of_every_type_are_kept_byte_for_byte() {
    let folder = Folder::new("attributes-types");
    let mut with_layer = RGB.to_vec();
    with_layer.push(("Z", 1));
    for (way, channels) in [(0, &RGB[..]), (1, &RGB), (1, &with_layer), (2, &RGB)] {
        let (file, notes) = rewritten(&folder, &raw(0x402, channels, &every_type()), way);
        let found = attributes(&file);
        for (name, kind, value) in every_type() {
            assert_eq!(found.get(name), Some(&(kind.to_owned(), value)), "{name}, written in way {way}");
        }
        assert_eq!(notes, Vec::<String>::new());
        assert_eq!(file[4..8], [2, 4, 0, 0], "the flag of long names");
        assert!(read(&Source::file(folder.file("out.exr"))).is_ok());
    }
}

/// OpenEXR refuses files with a value that does not fit its type.
#[test]
fn an_attribute_that_no_reader_takes_is_refused_or_left_out_and_named() {
    let folder = Folder::new("attributes-broken");
    let short = |kind: &'static str, value: &[u8]| ("short", kind, value.to_vec());
    let refused = [
        short("keycode", &[0; 24]),
        short("preview", &[1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3]),
        short("stringvector", &[9, 0, 0, 0, 65]),
        short("envmap", &[2]),
        short("tiledesc", &[1, 0, 0, 0, 1, 0, 0, 0, 3]),
        short("chlist", b"X\0"),
        short("timecode", &[0; 7]),
        short("chromaticities", &[0; 31]),
    ];
    for attribute in refused {
        let error = folder.read(&raw(2, &RGB, std::slice::from_ref(&attribute))).unwrap_err();
        let what = "the file is damaged: the value of attribute `short` does not fit its type";
        assert_eq!(error.message, what, "{attribute:?}");
    }
    let left_out = [
        short("v2f", &[0; 12]),
        short("m44d", &[0; 64]),
        short("v3d", &[0; 23]),
        short("floatvector", &[0; 5]),
        short("deepImageState", &[4]),
    ];
    for attribute in left_out {
        for way in 0..3 {
            let (file, notes) = rewritten(&folder, &raw(2, &RGB, std::slice::from_ref(&attribute)), way);
            assert!(!attributes(&file).contains_key("short"), "{attribute:?}");
            let why = "a value that is none of its type, or a name that is too long";
            assert_eq!(notes, [format!("left out: attribute `short`; {why}")], "{attribute:?}");
        }
    }
}

#[test]
fn attributes_of_the_old_picture_are_left_out_and_named() {
    let folder = Folder::new("attributes-old");
    let preview = [1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 4].to_vec();
    let old = [
        ("preview", "preview", preview),
        ("acesImageContainerFlag", "int", vec![1, 0, 0, 0]),
        ("deepImageState", "deepImageState", vec![1]),
    ];
    for way in 0..3 {
        let (file, notes) = rewritten(&folder, &raw(2, &RGB, &old), way);
        let found = attributes(&file);
        assert!(old.iter().all(|(name, ..)| !found.contains_key(*name)), "{found:?}");
        let what = "left out: attributes `acesImageContainerFlag`, `deepImageState`, `preview`; not true of the output";
        assert_eq!(notes, [what]);
    }
}

/// It says how the samples of a deep pixel lie.
#[test]
fn a_picture_of_a_host_has_no_state_of_deep_samples() {
    let mut source = picture(3, 2);
    source.meta.layer.deep_image_state = Some((1, 1));
    assert!(!attributes(&encode(&source, &Encoding::EXR).unwrap()).contains_key("deepImageState"));
}

#[test]
fn a_key_code_of_a_host_has_all_of_its_numbers() {
    let mut source = picture(3, 2);
    source.meta.layer.film_key_code = Some(::exr::meta::attribute::KeyCode {
        film_manufacturer_code: 1,
        film_type: 2,
        film_roll_prefix: 3,
        count: 4,
        perforation_offset: 5,
        perforations_per_frame: 6,
        perforations_per_count: 7,
    });
    let file = encode(&source, &Encoding::EXR).unwrap();
    let (kind, value) = &attributes(&file)["keyCode"];
    let numbers: Vec<i32> = value.as_chunks::<4>().0.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect();
    assert_eq!((kind.as_str(), numbers), ("keycode", vec![1, 2, 3, 4, 5, 6, 7]));
}

#[test]
fn long_names_of_channels_and_layers_are_announced() {
    let folder = Folder::new("attributes-long");
    let layer = "a.layer.with.a.name.of.more.than.thirty-one.letters.Z";
    let longest = format!("{}.R", "l".repeat(253));
    for name in [layer, &longest] {
        let channels = [("B", 1), ("G", 1), ("R", 1), (name, 1)];
        let (file, notes) = rewritten(&folder, &raw(0x402, &channels, &[]), 1);
        assert_eq!((file[5], notes), (4, Vec::new()), "{name}");
        assert!(attributes(&file)["channels"].1.windows(name.len()).any(|window| window == name.as_bytes()));
    }
    let (file, _) = rewritten(&folder, &raw(2, &RGB, &[]), 1);
    assert_eq!(file[5], 0);
}

#[test]
fn a_channel_of_some_pixels_is_refused_by_its_name() {
    let folder = Folder::new("attributes-sampling");
    let refused = |channels: &[(&str, i32)]| message_and_hint(&folder.read(&raw(2, channels, &[])).unwrap_err());
    let mask = refused(&[("B", 1), ("G", 1), ("R", 1), ("mask", 2)]);
    assert_eq!(
        mask,
        "its channel `mask` has one number for 2x2 pixels, which is not supported; \
         save it again with that channel in full size, or without it"
    );
    assert!(refused(&[("BY", 2), ("RY", 2), ("Y", 1)]).starts_with("chroma-subsampled EXR"));
    assert!(refused(&[("p.BY", 2), ("p.RY", 2), ("p.Y", 1)]).starts_with("chroma-subsampled EXR"));
}

#[test]
fn a_window_without_pixels_is_refused() {
    let folder = Folder::new("attributes-windows");
    for corners in [[0, 0, -1, -1], [2, 0, 0, 1], [0, 1, 2, 0], [0, 0, -1, 1]] {
        for (name, what) in [("displayWindow", "display"), ("dataWindow", "data")] {
            let window = (name, "box2i", corners.map(i32::to_le_bytes).concat());
            let error = folder.read(&raw(2, &RGB, &[window])).unwrap_err();
            let expected = format!("the file is damaged: its {what} window is empty or inverted");
            assert_eq!(error.message, expected, "{corners:?}");
        }
    }
}

#[test]
fn a_file_whose_writer_was_stopped_is_unfinished() {
    let folder = Folder::new("attributes-unfinished");
    let whole = raw(2, &RGB, &[]);
    let table = whole.len() - 2 * (8 + 18) - 16;
    for entries in [0..8, 8..16, 0..16] {
        let mut file = whole.clone();
        file[table..][entries].fill(0);
        let error = folder.read(&file).unwrap_err();
        assert_eq!(error.message, "the file is unfinished: blocks of the image are missing");
        let source = Source::file(folder.file("bytes"));
        assert!(read_description(&source).is_ok());
        assert!(read_whole(&source, Budget(1 << 30)).is_err());
    }
}

/// B44 needs 14 bytes for 4x4 halves, also where a block has one row or one column.
#[test]
fn every_size_can_be_written_with_every_compression() {
    use ExrCompression::{B44, B44a};
    let folder = Folder::new("attributes-sizes");
    let sizes = [(512, 33), (300, 65), (1, 64), (1, 301), (5, 1), (700, 1), (401, 2), (77, 35)];
    for compression in ExrCompression::ALL {
        let is_b44 = matches!(compression, B44 | B44a);
        for (width, height) in sizes.into_iter().take(if is_b44 { 8 } else { 2 }) {
            for bits in [16, 32] {
                let source = picture(width, height);
                let options = Encoding { compression, bits, ..Encoding::EXR };
                let whole = encode(&source, &options).unwrap();
                let back = folder.read(&whole).unwrap();
                assert_eq!((back.width, back.height), (width, height), "{compression:?}");
            }
        }
    }
}
