//! Other channels and parts of a file beside a new picture.

use std::path::{Path, PathBuf};

use ::exr::image::{AnyChannel, AnyChannels, Blocks, Encoding as Layout, FlatImage, FlatSamples, Image, Layer};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Chromaticities as Stated, IntegerBounds, LineOrder, Text};
use ::exr::meta::header::{ImageAttributes, LayerAttributes};
use ::exr::prelude::{Compression, SmallVec, WritableImage, read_all_flat_layers_from_file};
use afterimage_base::color::Chromaticities;
use half::f16;

use super::{Folder, picture};
use afterimage_media::*;

const SIZE: (usize, usize) = (21, 19);

type Part = Layer<AnyChannels<FlatSamples>>;

/// Numbers with NaN of several bits, infinities, and integers that no float holds.
fn odd(kind: char) -> FlatSamples {
    let count = SIZE.0 * SIZE.1;
    let bits = |i: usize| (i as u32).wrapping_mul(2_654_435_761) ^ 0x7fc0_1234;
    match kind {
        'h' => FlatSamples::F16((0..count).map(|i| f16::from_bits(bits(i) as u16)).collect()),
        'f' => FlatSamples::F32((0..count).map(|i| f32::from_bits(bits(i))).collect()),
        _ => FlatSamples::U32((0..count).map(bits).collect()),
    }
}

/// A part whose channels are named with the kind of their samples: `Z:f`.
fn part(name: &str, channels: &str, encoding: Layout) -> Part {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels
        .split(' ')
        .map(|word| {
            let (name, kind) = word.split_once(':').unwrap();
            AnyChannel::new(name, odd(kind.chars().next().unwrap()))
        })
        .collect();
    let mut attributes = if name.is_empty() { LayerAttributes::default() } else { LayerAttributes::named(name) };
    for (name, value) in [("cryptomatte/1a2b3c4/name", "object"), ("cryptomatte/1a2b3c4/manifest", "{\"a\":\"3f\"}")] {
        attributes.other.insert(name.into(), AttributeValue::Text(value.into()));
    }
    Layer::new(SIZE, attributes, encoding, AnyChannels::sort(list))
}

fn tiles() -> Layout {
    Layout { compression: Compression::PIZ, blocks: Blocks::Tiles(Vec2(8, 4)), line_order: LineOrder::Unspecified }
}

fn wide() -> ImageAttributes {
    let mut image = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
    let [red, green, blue, white] = Chromaticities::ACES_CG.points().map(|xy| {
        let at = xy.to_vec().as_vec2();
        Vec2(at.x, at.y)
    });
    image.chromaticities = Some(Stated { red, green, blue, white });
    image
}

fn write(folder: &Folder, image: ImageAttributes, parts: Vec<Part>) -> PathBuf {
    let path = folder.file("original.exr");
    let parts: SmallVec<[Part; 2]> = parts.into_iter().collect();
    Image::from_layers(image, parts).write().to_file(&path).unwrap();
    path
}

fn new_picture() -> Picture {
    picture(SIZE.0 as u32, SIZE.1 as u32)
}

/// The written file, and what was left out.
fn beside(folder: &Folder, path: &Path, layer: Option<&str>, options: &Encoding) -> (FlatImage, Vec<String>) {
    let source = Source { path: path.into(), layer: layer.map(str::to_owned) };
    let out = folder.file("out.exr");
    let notes = write_beside(&out, &new_picture(), options, &source, &Budget(1 << 30).into()).unwrap();
    (read_all_flat_layers_from_file(&out).unwrap(), notes)
}

fn bits(samples: &FlatSamples) -> Vec<u32> {
    match samples {
        FlatSamples::F16(values) => values.iter().map(|value| value.to_bits().into()).collect(),
        FlatSamples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        FlatSamples::U32(values) => values.to_vec(),
    }
}

/// The names of all channels, of which all but the picture's have the bits of the original.
fn names(image: &FlatImage, part: usize, replaced: &[&str]) -> Vec<String> {
    let channels = &image.layer_data[part].channel_data.list;
    for channel in channels.iter().filter(|channel| !replaced.contains(&channel.name.to_string().as_str())) {
        let kind = match channel.sample_data {
            FlatSamples::F16(_) => 'h',
            FlatSamples::F32(_) => 'f',
            FlatSamples::U32(_) => 'u',
        };
        assert!(bits(&channel.sample_data) == bits(&odd(kind)), "{} has other bits", channel.name);
    }
    channels.iter().map(|channel| channel.name.to_string()).collect()
}

const CROWDED: &str = "R:h G:h B:h Z:f id:u albedo.R:h albedo.G:h albedo.B:h object00.R:f object00.G:f object00.B:f";

const PICTURE: [&str; 4] = ["R", "G", "B", "A"];

#[test]
fn channels_are_kept_bit_for_bit_whatever_the_blocks() {
    use ExrCompression::{None as Unpacked, Piz, Rle, Zip, Zips};
    let folder = Folder::new("layers-channels");
    for encoding in [Layout::FAST_LOSSLESS, Layout::SMALL_LOSSLESS, tiles()] {
        let path = write(&folder, wide(), vec![part("", CROWDED, encoding)]);
        for compression in [Unpacked, Rle, Zip, Zips, Piz] {
            let options = Encoding { compression, ..Encoding::EXR };
            let (image, notes) = beside(&folder, &path, None, &options);
            let mut expected: Vec<&str> = CROWDED.split(' ').filter_map(|word| Some(word.split_once(':')?.0)).collect();
            expected.push("A");
            expected.sort_unstable();
            assert_eq!(names(&image, 0, &PICTURE), expected);
            assert_eq!(notes, Vec::<String>::new());
            // Layers of light keep their numbers, so the file keeps its primaries, and the picture is converted.
            assert_eq!(image.attributes.chromaticities, wide().chromaticities);
            let manifest = Text::from("cryptomatte/1a2b3c4/manifest");
            assert!(image.layer_data[0].attributes.other.contains_key(&manifest));
        }
    }
    let back = read(&Source::file(folder.file("out.exr"))).unwrap();
    let (there, back) = (new_picture().pixels.to_f32(), back.pixels.to_f32());
    let off = there.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // Halves of numbers up to 256 are off by 1/16, and the matrix adds three of them.
    assert!(off < 0.25, "{off}");
}

#[test]
fn parts_are_kept_as_they_are_stored() {
    let folder = Folder::new("layers-parts");
    let parts = || {
        vec![
            part("depth", "Z:f", tiles()),
            part("beauty", "R:h G:h B:h A:h near:f", Layout::FAST_LOSSLESS),
            part("ids", "id:u object00.R:f object00.G:f object00.B:f", Layout::SMALL_LOSSLESS),
        ]
    };
    let path = write(&folder, ImageAttributes::new(IntegerBounds::from_dimensions(SIZE)), parts());
    let (image, notes) = beside(&folder, &path, None, &Encoding::EXR);
    assert_eq!(notes, Vec::<String>::new());
    let titles: Vec<_> = image.layer_data.iter().map(|part| part.attributes.layer_name.clone().unwrap()).collect();
    assert_eq!(titles, ["depth", "beauty", "ids"].map(Text::from));
    assert_eq!(names(&image, 0, &[]), ["Z"]);
    assert_eq!(names(&image, 1, &PICTURE), ["A", "B", "G", "R", "near"]);
    assert_eq!(names(&image, 2, &[]), ["id", "object00.B", "object00.G", "object00.R"]);
    assert_eq!(image.layer_data[0].encoding, tiles());
    let bytes = || std::fs::read(folder.file("out.exr")).unwrap();
    let first = bytes();
    beside(&folder, &path, None, &Encoding::EXR);
    assert!(first == bytes(), "equal files give equal bytes");
}

#[test]
fn a_layer_is_replaced_under_its_own_names() {
    let folder = Folder::new("layers-named");
    let path = write(&folder, wide(), vec![part("", CROWDED, Layout::FAST_LOSSLESS)]);
    let (image, notes) = beside(&folder, &path, Some("albedo"), &Encoding::EXR);
    let replaced = ["albedo.R", "albedo.G", "albedo.B", "albedo.A"];
    let found = names(&image, 0, &replaced);
    assert!(["R", "G", "B", "Z", "albedo.A"].iter().all(|name| found.contains(&(*name).to_owned())), "{found:?}");
    assert_eq!(notes, Vec::<String>::new());
    // Depth is read and not replaced; the picture takes the names of another.
    let (image, notes) = beside(&folder, &path, Some("Z"), &Encoding::EXR);
    assert!(names(&image, 0, &PICTURE).contains(&"Z".to_owned()));
    assert_eq!(notes, ["left out: `B`, `G`, `R`; the picture has channels of that name"]);
}

#[test]
fn what_cannot_be_kept_is_said() {
    let folder = Folder::new("layers-left");
    let path = write(&folder, wide(), vec![part("", CROWDED, Layout::FAST_LOSSLESS)]);
    let rec2020 = Encoding { primaries: Some(Chromaticities::REC2020), ..Encoding::EXR };
    let (image, notes) = beside(&folder, &path, None, &rec2020);
    let why = "they are light in the primaries of the input, and the output has others";
    assert_eq!(notes, [format!("left out: `albedo.B`, `albedo.G`, `albedo.R`; {why}")]);
    let left = ["A", "B", "G", "R", "Z", "id", "object00.B", "object00.G", "object00.R"];
    assert_eq!(names(&image, 0, &PICTURE), left);
    let lossy = Encoding { compression: ExrCompression::Pxr24, ..Encoding::EXR };
    let (_, notes) = beside(&folder, &path, None, &lossy);
    assert_eq!(notes, ["the compression pxr24 changes channels that are kept"]);
    let mut overscan = part("", "R:h G:h B:h Z:f", Layout::FAST_LOSSLESS);
    overscan.attributes.layer_position = Vec2(-1, 0);
    let (image, notes) = beside(&folder, &write(&folder, wide(), vec![overscan]), None, &Encoding::EXR);
    assert_eq!(notes, ["left out: `Z`; the file has pixels of a part of its window only, or beside it"]);
    assert_eq!(names(&image, 0, &PICTURE), ["A", "B", "G", "R"]);
    // A container of ACES has no other channels.
    let container = Encoding {
        primaries: Some(Chromaticities::ACES_AP0),
        scene: true,
        compression: ExrCompression::None,
        ..Encoding::EXR
    };
    let path = write(&folder, wide(), vec![part("", "R:h G:h B:h Z:f", Layout::FAST_LOSSLESS)]);
    let (image, _) = beside(&folder, &path, None, &container);
    assert!(!image.layer_data[0].attributes.other.contains_key(&Text::from("acesImageContainerFlag")));
    // A file without layers, and one of another format.
    let path = write(&folder, wide(), vec![part("", "R:h G:h B:h", Layout::FAST_LOSSLESS)]);
    assert_eq!(beside(&folder, &path, None, &Encoding::EXR).1, Vec::<String>::new());
    let codes = Samples::Byte(&[0; 4]);
    write_image(&folder.file("a.png"), ((1, 1), codes), &Encoding::PNG).unwrap();
    assert_eq!(beside(&folder, &folder.file("a.png"), None, &Encoding::EXR).1, Vec::<String>::new());
}

#[test]
fn a_damaged_original_is_an_error_and_too_much_is_not_read() {
    let folder = Folder::new("layers-damaged");
    let path = write(&folder, wide(), vec![part("", CROWDED, Layout::FAST_LOSSLESS)]);
    let bytes = std::fs::read(&path).unwrap();
    let write = |bytes: &[u8], budget: u64| {
        let source = Source::file(folder.with("damaged.exr", bytes));
        write_beside(&folder.file("o.exr"), &new_picture(), &Encoding::EXR, &source, &Budget(budget).into())
    };
    assert!(write(&bytes, 1 << 20).is_ok());
    assert_eq!(write(&bytes, 1 << 12).unwrap_err().kind, ErrorKind::TooLarge);
    std::fs::remove_file(folder.file("o.exr")).unwrap();
    for kept in (0..bytes.len()).step_by(97) {
        assert!(write(&bytes[..kept], 1 << 30).is_err(), "{kept} bytes");
    }
    assert!(!folder.file("o.exr").exists());
}

#[test]
fn what_a_file_has_besides_its_picture_is_named() {
    let folder = Folder::new("layers-besides");
    let named = |path: PathBuf, layer: Option<&str>| {
        left_out(&Source { path, layer: layer.map(str::to_owned) }, "rows come and go").unwrap()
    };
    let path = write(&folder, wide(), vec![part("", "R:h G:h B:h Z:f id:u", Layout::FAST_LOSSLESS)]);
    assert_eq!(named(path.clone(), None), ["left out: `Z`, `id`; rows come and go"]);
    // Depth is read and not replaced.
    assert_eq!(named(path, Some("Z")), ["left out: `B`, `G`, `R`, `Z`, `id`; rows come and go"]);
    let parts = vec![part("beauty", "R:h G:h B:h", tiles()), part("depth", "Z:f", tiles())];
    assert_eq!(named(write(&folder, wide(), parts), None), ["left out: part `depth`; rows come and go"]);
    write_image(&folder.file("plain.exr"), &new_picture(), &Encoding::EXR).unwrap();
    assert_eq!(named(folder.file("plain.exr"), None), Vec::<String>::new());
    let png = (SIZE.0 as u32, SIZE.1 as u32);
    let values = new_picture().pixels.to_f32();
    write_image(&folder.file("plain.png"), (png, Samples::Float(&values)), &Encoding::PNG).unwrap();
    assert_eq!(named(folder.file("plain.png"), None), Vec::<String>::new());
}

/// Parts with fewer channels than that of the picture, or with names of its channels.
#[test]
fn a_part_with_one_channel_stays_beside_its_picture() {
    let folder = Folder::new("layers-few");
    for other in ["Z:f", "Y:f", "R:h", "id:u", "X:f Y:f"] {
        let (full, few) = (part("beauty", "R:h G:h B:h", tiles()), part("few", other, tiles()));
        for (parts, picture) in [([full.clone(), few.clone()], 1), ([few, full], 0)] {
            let path = write(&folder, wide(), parts.into());
            let (image, _) = beside(&folder, &path, Some("few"), &Encoding::EXR);
            assert!(names(&image, picture, &PICTURE).contains(&"R".to_owned()), "{other}");
            assert_eq!(names(&image, 1 - picture, &[]), ["B", "G", "R"], "{other}");
        }
    }
}

#[test]
fn names_are_utf_8_and_other_bytes_are_kept() {
    let folder = Folder::new("layers-utf8");
    for (bytes, shown) in [("\u{fc}".as_bytes(), "\u{fc}"), ("\u{6f22}".as_bytes(), "\u{6f22}"), (b"\xfc", "\u{fc}")] {
        let text = |end: &str| Text::from_slice_unchecked(&[bytes, end.as_bytes()].concat());
        let mut named = part("beauty", "R:h G:h B:h", tiles());
        for (letter, kind) in [("R", 'h'), ("G", 'h'), ("B", 'h'), ("Z", 'f')] {
            named.channel_data.list.push(AnyChannel::new(text(&format!(".{letter}")), odd(kind)));
        }
        named.channel_data.list.sort_by(|a, b| a.name.as_slice().cmp(b.name.as_slice()));
        let mut other = part("", "R:h G:h B:h", tiles());
        other.attributes.layer_name = Some(text(""));
        let path = write(&folder, wide(), vec![named, other]);
        let described = read_description(&Source::file(&path)).unwrap();
        assert!(described.layers.contains(&shown.to_owned()), "{:?}", described.layers);
        assert_eq!(described.parts[1].name.as_deref(), Some(shown));
        let (image, _) = beside(&folder, &path, Some(shown), &Encoding::EXR);
        let written: Vec<_> = image.layer_data[0].channel_data.list.iter().map(|channel| &channel.name).collect();
        for name in [".R", ".G", ".B", ".A", ".Z"] {
            assert!(written.contains(&&text(name)), "{shown}: {written:?}");
        }
        assert_eq!(image.layer_data[1].attributes.layer_name, Some(text("")));
    }
}
