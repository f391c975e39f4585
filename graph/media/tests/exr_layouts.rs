//! Which samples of an EXR file become which pixels: channels, windows, tiles, packings; and the written bytes.

use ::exr::image::{Blocks, Encoding as Layout, Image};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Chromaticities as Stated, Compression, IntegerBounds, LineOrder, Text};
use ::exr::meta::header::ImageAttributes;
use ::exr::prelude::{SmallVec, WritableImage};
use afterimage_base::color::{Chromaticities, Colorimetry, Decimal};
use half::f16;

use super::exr_read::{FLOAT, HALF, Part, UINT, part, plain, write};
use super::exr_write::{attribute, header_length};
use super::{Folder, message_and_hint, picture, read_layer};
use afterimage_media::*;

/// The first pixel of a file whose channels have the numbers 1, 2, 3 and so on, in the order in which they are listed.
fn first_pixel(folder: &Folder, names: &[&str], layer: Option<&str>) -> Result<[f32; 4], String> {
    let channels: Vec<_> = names.iter().zip(1_u8..).map(|(name, base)| (*name, f32::from(base), HALF)).collect();
    let path = write(folder, plain(), vec![part("", (0, 0), &channels)]);
    let source = Source { path, layer: layer.map(str::to_owned) };
    read(&source).map(|picture| picture.pixel(0, 0)).map_err(|error| message_and_hint(&error))
}

#[test]
fn channels_make_a_color_a_vector_or_a_gray() {
    let folder = Folder::new("layouts-channels");
    let table: [(&[&str], Option<&str>, [f32; 4]); 23] = [
        (&["R", "G", "B"], None, [1.0, 2.0, 3.0, 1.0]),
        (&["B", "A", "R", "G"], None, [3.0, 4.0, 1.0, 2.0]),
        (&["R", "B"], None, [1.0, 0.0, 2.0, 1.0]),
        (&["G"], None, [1.0, 1.0, 1.0, 1.0]),
        (&["R"], None, [1.0, 1.0, 1.0, 1.0]),
        (&["A"], None, [1.0, 1.0, 1.0, 1.0]),
        (&["R", "A"], None, [1.0, 1.0, 1.0, 2.0]),
        (&["A", "U"], None, [2.0, 2.0, 2.0, 1.0]),
        (&["l.B"], None, [1.0, 1.0, 1.0, 1.0]),
        (&["U", "V", "W"], None, [1.0, 2.0, 3.0, 1.0]),
        (&["w", "v", "u", "A"], None, [3.0, 2.0, 1.0, 4.0]),
        (&["X", "Y", "Z"], None, [1.0, 2.0, 3.0, 1.0]),
        (&["X", "Y"], None, [1.0, 2.0, 0.0, 1.0]),
        (&["Y", "X", "A"], None, [2.0, 1.0, 0.0, 3.0]),
        (&["V", "U"], None, [2.0, 1.0, 0.0, 1.0]),
        (&["U", "V", "A"], None, [1.0, 2.0, 0.0, 3.0]),
        (&["Y", "A"], None, [1.0, 1.0, 1.0, 2.0]),
        (&["mask"], None, [1.0, 1.0, 1.0, 1.0]),
        (&["Z", "spec.R", "spec.G", "spec.B"], None, [2.0, 3.0, 4.0, 1.0]),
        (&["a.R", "a.G", "a.B", "R", "G", "B"], None, [4.0, 5.0, 6.0, 1.0]),
        (&["N.X", "N.Y", "b.R", "b.G", "b.B"], None, [3.0, 4.0, 5.0, 1.0]),
        (&["R", "G", "B", "A"], Some("A"), [4.0, 4.0, 4.0, 1.0]),
        (&["a.b.R", "a.b.G", "a.b.B", "a.R"], Some("a.b.R"), [1.0, 1.0, 1.0, 1.0]),
    ];
    for (names, layer, expected) in table {
        assert_eq!(first_pixel(&folder, names, layer), Ok(expected), "{names:?} {layer:?}");
    }
    for names in [&["U", "W"][..], &["p", "q"], &["p", "q", "A"]] {
        assert!(
            first_pixel(&folder, names, None).unwrap_err().starts_with("no layer of this EXR is a color"),
            "{names:?}"
        );
    }
    for names in [&["RY", "BY", "Y"][..], &["BY", "Y"], &["Y", "ry"]] {
        assert!(first_pixel(&folder, names, None).unwrap_err().starts_with("chroma-subsampled EXR"), "{names:?}");
    }
}

/// The layers of a file, each a color; the first pixel is the number of the layer. Returns which of them is read, and
/// what is said about that.
fn chosen(folder: &Folder, parts: &[(&str, &[&str])]) -> (f32, Vec<String>) {
    let mut number = 0.0;
    let parts = parts.iter().map(|(name, layers)| {
        let mut channels = Vec::new();
        for layer in *layers {
            number += 1.0;
            let dot = if layer.is_empty() { "" } else { "." };
            channels.extend(["R", "G", "B"].map(|letter| (format!("{layer}{dot}{letter}"), number)));
        }
        let channels: Vec<_> = channels.iter().map(|(name, number)| (name.as_str(), *number, HALF)).collect();
        part(name, (0, 0), &channels)
    });
    let path = write(folder, plain(), parts.collect());
    let picture = read(&Source::file(path)).unwrap();
    (picture.pixel(0, 0)[0], picture.notes)
}

#[test]
fn the_picture_is_what_renderers_call_so() {
    let folder = Folder::new("layouts-pictures");
    type Parts = &'static [(&'static str, &'static [&'static str])];
    let table: [(Parts, f32, bool); 14] = [
        (&[("", &["ViewLayer.AO", "ViewLayer.Combined", "ViewLayer.DiffCol"])], 2.0, true),
        (&[("", &["ViewLayer.AO.left", "ViewLayer.Combined.right", "ViewLayer.Combined.left"])], 3.0, true),
        (&[("", &["albedo", "RGBA", "beauty"])], 2.0, true),
        (&[("", &["GI", "Beauty", "Lighting"])], 2.0, true),
        (&[("", &["A_first", "C", "direct"])], 2.0, true),
        (&[("", &["albedo", "Ci"])], 2.0, true),
        (&[("", &["albedo", ""])], 2.0, false),
        (&[("", &["right", ""])], 2.0, false),
        (&[("", &["right", "left"])], 2.0, true),
        (&[("", &["only"])], 1.0, false),
        (&[("", &["second", "first"])], 2.0, true),
        (&[("albedo", &[""]), ("beauty", &[""])], 2.0, true),
        (&[("rgba.right", &[""]), ("rgba.left", &[""])], 2.0, true),
        (&[("depth", &["depth"]), ("combined", &["combined"])], 2.0, true),
    ];
    for (parts, expected, is_told) in table {
        let (found, notes) = chosen(&folder, parts);
        assert_eq!((found, notes.len()), (expected, usize::from(is_told)), "{parts:?}: {notes:?}");
    }
    let (_, notes) = chosen(&folder, &[("", &["ViewLayer.AO", "ViewLayer.Combined"])]);
    let note = "the layer `ViewLayer.Combined` is read, and not `ViewLayer.AO`; `FILE.exr#LAYER` chooses another";
    assert_eq!(notes, [note]);
    // Numbers of objects are no picture, and a gray is one if there is no color.
    let mut objects = part("", (0, 0), &[("Crypto00.R", 9.0, HALF), ("Crypto00.G", 9.0, HALF), ("mask.Y", 4.0, HALF)]);
    let name = Text::from("cryptomatte/1a2b3c4/name");
    objects.attributes.other.insert(name, AttributeValue::Text("Crypto".into()));
    let path = write(&folder, plain(), vec![objects]);
    assert_eq!(read(&Source::file(path)).unwrap().pixel(0, 0)[0], 4.0);
}

#[test]
fn a_list_of_very_many_channels_is_shortened() {
    let folder = Folder::new("layouts-many");
    let names: Vec<String> = (0..30).map(|number| format!("c{number:02}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let error = first_pixel(&folder, &names, None).unwrap_err();
    assert!(error.ends_with("`c22`, `c23`, and 6 more"), "{error}");
    let error = first_pixel(&folder, &names[..24], Some("no")).unwrap_err();
    assert!(error.ends_with("`c22`, `c23`"), "{error}");
}

#[test]
fn one_channel_that_is_no_half_makes_floats() {
    let folder = Folder::new("layouts-types");
    for (green, bytes) in [(HALF, 2), (FLOAT, 4), (UINT, 4)] {
        let path =
            write(&folder, plain(), vec![part("", (0, 0), &[("R", 1.0, HALF), ("G", 2.0, green), ("B", 3.0, HALF)])]);
        let picture = read(&Source::file(path)).unwrap();
        assert_eq!(
            (picture.pixels.bytes_per_channel(), picture.pixel(1, 0)),
            (bytes, [2.0, 3.0, 4.0, 1.0]),
            "{green:?}"
        );
    }
}

/// Parts whose names begin alike are not mixed up, and a channel of one part is found behind its name.
#[test]
fn a_part_is_named_up_to_a_dot() {
    let folder = Folder::new("layouts-parts");
    let parts = vec![part("key", (0, 0), &[("Y", 1.0, HALF)]), part("keys", (0, 0), &[("Y", 9.0, HALF)])];
    let path = write(&folder, plain(), parts);
    for (layer, value) in [("key", 1.0), ("keys", 9.0), ("keys.Y", 9.0), ("key.Y", 1.0)] {
        assert_eq!(read_layer(&path, layer).unwrap().pixel(0, 0)[0], value, "{layer}");
    }
    assert!(read_layer(&path, "keysY").is_err());
}

/// Every pixel of every arrangement is the sample that lies there, or nothing.
#[test]
fn every_arrangement_of_windows_and_blocks_puts_samples_in_their_places() {
    let folder = Folder::new("layouts-windows");
    let (data_size, display_size) = ((5, 4), (6, 3));
    let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(2, 3)), Blocks::Tiles(Vec2(64, 64))];
    for blocks in blocks {
        for compression in [Compression::Uncompressed, Compression::ZIP1, Compression::ZIP16] {
            for at in [(0, 0), (-3, 1), (4, -2), (1, 2), (-20, 0)] {
                let mut layer = part("", at, &[("R", 1.0, HALF), ("G", 101.0, FLOAT), ("B", 201.0, HALF)]);
                layer.encoding = Layout { compression, blocks, line_order: LineOrder::Increasing };
                let display = IntegerBounds::new((-1, -1), display_size);
                let found = read(&Source::file(write(&folder, display, vec![layer]))).unwrap();
                assert_eq!((found.width, found.height), (6, 3));
                for (x, y) in (0..3_u32).flat_map(|y| (0..6_u32).map(move |x| (x, y))) {
                    let (column, row) = (x as i32 - 1 - at.0, y as i32 - 1 - at.1);
                    let is_inside = (0..data_size.0).contains(&column) && (0..data_size.1).contains(&row);
                    let number = 1.0 + (row * data_size.0 + column) as f32;
                    let expected = if is_inside { [number, 100.0 + number, 200.0 + number, 1.0] } else { [0.0; 4] };
                    assert_eq!(found.pixel(x, y), expected, "{blocks:?} {compression:?} {at:?}: {x}, {y}");
                }
            }
        }
    }
}

fn with_image(folder: &Folder, part: Part, set: impl FnOnce(&mut ImageAttributes)) -> Result<Picture, FileError> {
    let mut image = ImageAttributes::new(plain());
    set(&mut image);
    let path = folder.file("image.exr");
    let parts: SmallVec<[Part; 2]> = [part].into_iter().collect();
    Image::from_layers(image, parts).write().to_file(&path).unwrap();
    read(&Source::file(path))
}

fn stated(primaries: &Chromaticities) -> Stated {
    let [red, green, blue, white] = primaries.points().map(|xy| Vec2(xy.x.get() as f32, xy.y.get() as f32));
    Stated { red, green, blue, white }
}

#[test]
fn gray_needs_no_primaries_and_wrong_ones_are_told() {
    let folder = Folder::new("layouts-gray");
    let rec2020 = |image: &mut ImageAttributes| image.chromaticities = Some(stated(&Chromaticities::REC2020));
    let gray = with_image(&folder, part("", (0, 0), &[("Y", 3.0, FLOAT)]), rec2020).unwrap();
    assert_eq!((gray.pixel(0, 0), gray.stated), ([3.0, 3.0, 3.0, 1.0], None));
    let rgb = [("R", 1.0, FLOAT), ("G", 2.0, FLOAT), ("B", 3.0, FLOAT)];
    let point = |image: &mut ImageAttributes| {
        let mut wrong = stated(&Chromaticities::REC2020);
        (wrong.green, wrong.blue) = (wrong.red, wrong.red);
        image.chromaticities = Some(wrong);
    };
    let error = with_image(&folder, part("", (0, 0), &rgb), point).unwrap_err();
    assert_eq!(
        message_and_hint(&error),
        "its `chromaticities` attribute describes no color space; \
         correct or remove that attribute; without it, Rec.709 is assumed"
    );
    for (nits, expected) in [(100.0, Some(100.0)), (0.0, None), (-5.0, None), (f32::NAN, None)] {
        let mut layer = part("", (0, 0), &rgb);
        layer.attributes.white_luminance = Some(nits);
        let color = with_image(&folder, layer, rec2020).unwrap().stated.unwrap();
        assert_eq!(color.white_nits, expected.map(Decimal::new), "{nits}");
    }
}

/// OpenEXR's file layout: after the header a table of offsets, then the row, its length, and channel by channel in the
/// order of their names.
#[test]
fn rows_are_written_channel_after_channel() {
    let values = [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let planes = [[4.0, 8.0], [3.0, 7.0], [2.0, 6.0], [1.0, 5.0]];
    let halves = |values: &[f32]| values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect::<Vec<u8>>();
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let of_halves = Pixels::Half(values.iter().map(|v| f16::from_f32(*v)).collect());
    for pixels in [Pixels::Float(values.to_vec()), of_halves] {
        for (float, alpha) in [(false, true), (false, false), (true, true), (true, false)] {
            let options = Encoding {
                bits: if float { 32 } else { 16 },
                alpha: if alpha { Alpha::Keep } else { Alpha::Drop },
                compression: ExrCompression::None,
                ..Encoding::EXR
            };
            let file = encode(&Picture::new(2, 1, pixels.clone()), &options).unwrap();
            let written = planes[usize::from(!alpha)..].concat();
            let data = if float { floats(&written) } else { halves(&written) };
            let start = header_length(&file);
            let head =
                [&(start as u64 + 8).to_le_bytes()[..], &0_u32.to_le_bytes(), &(data.len() as u32).to_le_bytes()];
            assert_eq!(file[start..], [head.concat(), data].concat(), "{float} {alpha}");
            let list = attribute(&file, "channels", "chlist");
            let (names, kind) = (if alpha { &b"ABGR"[..] } else { b"BGR" }, if float { 2 } else { 1 });
            // Alpha is said to be linear to the eye.
            let channel =
                |name: &u8| [*name, 0, kind, 0, 0, 0, u8::from(*name == b'A'), 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];
            assert_eq!(list, names.iter().flat_map(channel).chain([0]).collect::<Vec<u8>>());
        }
    }
}

#[test]
fn attributes_are_sorted_and_state_what_the_options_say() {
    let floats =
        |bytes: &[u8]| -> Vec<f32> { bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect() };
    let mut source = picture(3, 2);
    source.meta.image.chromaticities = Some(stated(&Chromaticities::ACES_CG));
    source.meta.image.pixel_aspect = 1.5;
    source.meta.layer.white_luminance = Some(80.0);
    source.meta.layer.adopted_neutral = Some(Vec2(0.25, 0.5));
    source.meta.layer.layer_name = Text::new_or_none("beauty");
    source.meta.layer.view_name = Text::new_or_none("left");
    source.meta.image.other.insert(Text::from("both"), AttributeValue::I32(1));
    source.meta.layer.other.insert(Text::from("both"), AttributeValue::I32(2));
    let with = |color| encode(&source, &Encoding { color, ..Encoding::EXR }).unwrap();
    let data = with(None);
    let of = |file: &[u8]| floats(attribute(file, "chromaticities", "chromaticities"));
    let numbers = |primaries: &Chromaticities| {
        primaries.points().iter().flat_map(|xy| [xy.x.get() as f32, xy.y.get() as f32]).collect::<Vec<f32>>()
    };
    assert!(!data.windows(14).any(|window| window == b"chromaticities"), "data has no primaries");
    assert_eq!(floats(attribute(&data, "whiteLuminance", "float")), [80.0]);
    assert_eq!(floats(attribute(&data, "adoptedNeutral", "v2f")), [0.25, 0.5]);
    assert_eq!(floats(attribute(&data, "pixelAspectRatio", "float")), [1.5]);
    assert_eq!(attribute(&data, "lineOrder", "lineOrder"), [0], "rows from the top");
    let plain = Colorimetry::linear(Chromaticities::DISPLAY_P3);
    let stated = with(Some(plain));
    assert_eq!(of(&stated), numbers(&Chromaticities::DISPLAY_P3));
    assert_eq!(floats(attribute(&stated, "whiteLuminance", "float")), [80.0], "nothing else is known");
    let bright = with(Some(Colorimetry { white_nits: Some(Decimal::new(203.0)), ..plain }));
    assert_eq!(floats(attribute(&bright, "whiteLuminance", "float")), [203.0]);
    for file in [&data, &stated, &bright] {
        let mut names = Vec::new();
        let mut at = 8;
        while file[at] != 0 {
            let word = |at: usize| file[at..].split(|byte| *byte == 0).next().unwrap().to_vec();
            let (name, kind) = (word(at), word(at + word(at).len() + 1));
            let length_at = at + name.len() + kind.len() + 2;
            at = length_at + 4 + u32::from_le_bytes(file[length_at..length_at + 4].try_into().unwrap()) as usize;
            names.push(String::from_utf8(name).unwrap());
        }
        let mut sorted = names.clone();
        sorted.sort();
        sorted.dedup();
        assert_eq!(names, sorted, "sorted, and each once");
        assert!(!names.iter().any(|name| matches!(name.as_str(), "view" | "preview" | "multiView")), "{names:?}");
    }
    for aspect in [0.0, -1.0, 1e-7, 1e7, f32::INFINITY] {
        source.meta.image.pixel_aspect = aspect;
        let file = encode(&source, &Encoding::EXR).unwrap();
        assert_eq!(floats(attribute(&file, "pixelAspectRatio", "float")), [1.0], "{aspect}");
    }
}

#[test]
fn a_radiance_file_has_its_rows_its_divisors_and_its_aspect() {
    let folder = Folder::new("layouts-hdr");
    let file = |lines: &str| {
        let pixels: Vec<u8> = (1..=6_u8).flat_map(|at| [at * 8, at * 4, at * 2, 136]).collect();
        [format!("#?RGBE\nFORMAT=32-bit_rle_rgbe\n{lines}\n-Y 2 +X 3\n").into_bytes(), pixels].concat()
    };
    let plain = folder.read(&file("")).unwrap();
    assert_eq!((plain.width, plain.height, plain.stated), (3, 2, None));
    let divided = folder.read(&file("COLORCORR=2 4 8\nEXPOSURE=2\nCOLORCORR=1 1 0.5\n")).unwrap();
    for (x, y, at) in [(0, 0, 1.0), (2, 0, 3.0), (0, 1, 4.0), (2, 1, 6.0)] {
        assert_eq!(plain.pixel(x, y), [at * 8.0, at * 4.0, at * 2.0, 1.0], "{x}, {y}");
        assert_eq!(divided.pixel(x, y), [at * 2.0, at * 0.5, at * 0.25, 1.0], "{x}, {y}");
    }
    for (stated, expected) in [("4", 0.25), ("0.5", 2.0), ("0", 1.0), ("-1", 1.0), ("1e9", 1.0)] {
        let aspect = folder.read(&file(&format!("PIXASPECT={stated}\n"))).unwrap().meta.image.pixel_aspect;
        assert_eq!(aspect, expected, "{stated}");
    }
    for lines in ["EXPOSURE=1e-13\n", "EXPOSURE=1e13\n", "COLORCORR=1 0 1\n", "COLORCORR=1 1 -2\n"] {
        let ignored = folder.read(&file(lines)).unwrap();
        assert_eq!((ignored.pixel(1, 1)[0], ignored.notes.len()), (40.0, 1), "{lines}");
    }
    assert_eq!(folder.read(&file("PRIMARIES=a b\n")).unwrap().stated, None);
}
