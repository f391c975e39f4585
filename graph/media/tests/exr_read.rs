//! EXR files as other programs write them: parts, layers, windows, tiles, levels, types.

use std::path::PathBuf;

use ::exr::block::samples::IntoNativeSample;
use ::exr::image::{AnyChannel, AnyChannels, Blocks, Encoding as Layout, FlatSamples, Image, Layer, Levels};
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::attribute::{Chromaticities, Compression, IntegerBounds, LineOrder, SampleType, Text};
use ::exr::meta::header::{ImageAttributes, LayerAttributes};
use ::exr::prelude::{SmallVec, WritableImage};
use half::f16;

use super::{Folder, message_and_hint, read_layer};
use afterimage_media::*;

const SIZE: (usize, usize) = (5, 4);

/// Samples that are `base` in the first pixel and 1 more in each that follows.
fn samples(base: f32, sample_type: SampleType) -> FlatSamples {
    counted(base, sample_type, SIZE.0 * SIZE.1)
}

fn counted(base: f32, sample_type: SampleType, count: usize) -> FlatSamples {
    let values = (0..count).map(|i| base + i as f32);
    match sample_type {
        SampleType::F16 => FlatSamples::F16(values.map(f16::from_f32).collect()),
        SampleType::F32 => FlatSamples::F32(values.collect()),
        SampleType::U32 => FlatSamples::U32(values.map(|v| v.to_u32()).collect()),
    }
}

pub(super) type Part = Layer<AnyChannels<FlatSamples>>;

pub(super) fn part(name: &str, at: (i32, i32), channels: &[(&str, f32, SampleType)]) -> Part {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        channels.iter().map(|&(name, base, kind)| AnyChannel::new(name, samples(base, kind))).collect();
    let attributes = match name {
        "" => LayerAttributes::default(),
        _ => LayerAttributes::named(name),
    };
    let attributes = attributes.with_position(Vec2(at.0, at.1));
    Layer::new(SIZE, attributes, Layout::FAST_LOSSLESS, AnyChannels::sort(list))
}

pub(super) fn write(folder: &Folder, display: IntegerBounds, parts: Vec<Part>) -> PathBuf {
    let path = folder.file("parts.exr");
    let layers: SmallVec<[Part; 2]> = parts.into_iter().collect();
    Image::from_layers(ImageAttributes::new(display), layers).write().to_file(&path).unwrap();
    path
}

pub(super) fn plain() -> IntegerBounds {
    IntegerBounds::from_dimensions(SIZE)
}

pub(super) const HALF: SampleType = SampleType::F16;
pub(super) const FLOAT: SampleType = SampleType::F32;
pub(super) const UINT: SampleType = SampleType::U32;

/// One part with everything in it.
const CROWDED: [(&str, f32, SampleType); 13] = [
    ("R", 100.0, HALF),
    ("G", 200.0, HALF),
    ("B", 300.0, HALF),
    ("Z", 7.0, FLOAT),
    ("id", 5.0, UINT),
    ("diffuse.R", 10.0, HALF),
    ("diffuse.G", 20.0, HALF),
    ("diffuse.B", 30.0, HALF),
    ("diffuse.A", 0.0, HALF),
    ("N.X", 1.0, HALF),
    ("N.Y", 2.0, HALF),
    ("N.Z", 3.0, HALF),
    ("light.key.Y", 50.0, FLOAT),
];

#[test]
fn a_suffix_picks_a_layer_or_a_channel() {
    let folder = Folder::new("layers");
    let path = write(&folder, plain(), vec![part("", (0, 0), &CROWDED)]);
    let table: [(Option<&str>, [f32; 4], usize); 8] = [
        (None, [101.0, 201.0, 301.0, 1.0], 2),
        (Some("diffuse"), [11.0, 21.0, 31.0, 1.0], 2),
        (Some("diffuse.G"), [21.0, 21.0, 21.0, 1.0], 2),
        (Some("Z"), [8.0, 8.0, 8.0, 1.0], 4),
        (Some("id"), [6.0, 6.0, 6.0, 1.0], 4),
        (Some("N"), [2.0, 3.0, 4.0, 1.0], 2),
        (Some("light.key"), [51.0, 51.0, 51.0, 1.0], 4),
        (Some("light.key.Y"), [51.0, 51.0, 51.0, 1.0], 4),
    ];
    for (layer, expected, bytes) in table {
        let source = Source { path: path.clone(), layer: layer.map(str::to_owned) };
        let picture = read(&source).unwrap();
        assert_eq!(picture.pixel(1, 0), expected, "{layer:?}");
        assert_eq!(picture.pixels.bytes_per_channel(), bytes, "{layer:?}");
    }
    // The alpha of a layer is its own: here it starts at 0 and the main picture has none.
    assert_eq!(read_layer(&path, "diffuse").unwrap().pixel(0, 0)[3], 0.0);
}

#[test]
fn channels_are_known_in_any_case_and_by_their_whole_names() {
    let folder = Folder::new("names");
    for names in [["r", "g", "b", "a"], ["red", "green", "blue", "alpha"], ["Red", "GREEN", "B", "Alpha"]] {
        let channels: Vec<_> = names.into_iter().zip([10.0, 20.0, 30.0, 0.0]).map(|(n, v)| (n, v, HALF)).collect();
        let path = write(&folder, plain(), vec![part("", (0, 0), &channels)]);
        assert_eq!(read(&Source::file(path)).unwrap().pixel(0, 0), [10.0, 20.0, 30.0, 0.0], "{names:?}");
    }
}

#[test]
fn parts_count_as_layers() {
    let folder = Folder::new("parts");
    let rgb = [("R", 10.0, HALF), ("G", 20.0, HALF), ("B", 30.0, HALF)];
    let parts = vec![
        part("depth", (0, 0), &[("Z", 5.0, FLOAT)]),
        part("beauty", (0, 0), &rgb),
        part("extra", (0, 0), &[("spec.R", 1.0, HALF), ("spec.G", 2.0, HALF)]),
    ];
    let path = write(&folder, plain(), parts);
    assert_eq!(read(&Source::file(&path)).unwrap().pixel(0, 0), [10.0, 20.0, 30.0, 1.0]);
    let first = |layer: &str| read_layer(&path, layer).unwrap().pixel(0, 0)[..3].to_vec();
    assert_eq!(first("depth"), [5.0, 5.0, 5.0]);
    assert_eq!(first("depth.Z"), [5.0, 5.0, 5.0]);
    assert_eq!(first("beauty.G"), [20.0, 20.0, 20.0]);
    assert_eq!(first("spec"), [1.0, 2.0, 0.0]);
    assert_eq!(first("extra"), [1.0, 2.0, 0.0]);
    assert_eq!(first("extra.spec.G"), [2.0, 2.0, 2.0]);
    let error = read_layer(&path, "beuty").unwrap_err();
    assert_eq!(error.kind, ErrorKind::Missing);
    assert_eq!(
        message_and_hint(&error),
        "it has no layer or channel `beuty`; it has part `depth` (`Z`), \
         part `beauty` (`B`, `G`, `R`), part `extra` (`spec.G`, `spec.R`)"
    );
}

#[test]
fn a_file_without_a_picture_says_what_it_has() {
    let folder = Folder::new("no-picture");
    let channels = [("m", 1.0, FLOAT), ("n", 2.0, FLOAT), ("s.p", 3.0, FLOAT), ("s.q", 4.0, HALF)];
    let path = write(&folder, plain(), vec![part("", (0, 0), &channels)]);
    assert_eq!(
        message_and_hint(&read(&Source::file(&path)).unwrap_err()),
        "no layer of this EXR is a color picture; name a channel after `#`, for example \
         `file.exr#Z`; it has `m`, `n`, `s.p`, `s.q`"
    );
    assert_eq!(
        message_and_hint(&read_layer(&path, "s").unwrap_err()),
        "layer `s` is neither a color nor a vector; name one of its channels: `s.p`, `s.q`"
    );
}

#[test]
fn luminance_is_gray_and_keeps_its_alpha() {
    let folder = Folder::new("gray");
    let channels = [("Y", 3.0, HALF), ("A", 0.0, HALF)];
    let path = write(&folder, plain(), vec![part("", (0, 0), &channels)]);
    let picture = read(&Source::file(path)).unwrap();
    assert_eq!(picture.pixel(2, 0), [5.0, 5.0, 5.0, 2.0]);
}

#[test]
fn the_picture_is_the_display_window() {
    let folder = Folder::new("windows");
    let rgb = [("R", 10.0, HALF), ("G", 40.0, HALF), ("B", 70.0, HALF)];
    let display = IntegerBounds::new((-2, 3), (6, 3));
    // Columns -4..1 and rows 4..8 of data over columns -2..4 and rows 3..6 of display.
    let path = write(&folder, display, vec![part("", (-4, 4), &rgb)]);
    let picture = read(&Source::file(path)).unwrap();
    assert_eq!((picture.width, picture.height), (6, 3));
    let red = |x, y| picture.pixel(x, y)[0];
    assert_eq!(picture.pixel(0, 0), [0.0; 4], "above the data");
    assert_eq!(picture.pixel(0, 1), [12.0, 42.0, 72.0, 1.0]);
    assert_eq!([red(2, 1), red(0, 2), red(2, 2)], [14.0, 17.0, 19.0]);
    assert_eq!(picture.pixel(3, 1), [0.0; 4], "right of the data");
    assert_eq!(picture.notes, ["pixels outside the display window are left out"]);
    assert_eq!(picture.meta.layer.layer_position, Vec2(-4, 4));
}

#[test]
fn data_beside_the_display_window_leaves_it_empty() {
    let folder = Folder::new("beside");
    let path = write(&folder, plain(), vec![part("", (900, 900), &[("Y", 3.0, HALF)])]);
    let picture = read(&Source::file(path)).unwrap();
    assert!(picture.pixels.to_f32().iter().all(|v| *v == 0.0));
    assert_eq!((picture.width, picture.height), (5, 4));
}

#[test]
fn tiles_and_levels_give_the_largest_level() {
    let folder = Folder::new("levels");
    let (width, height) = (37, 21);
    let level = |factor: usize| (width >> factor).max(1) * (height >> factor).max(1);
    let maps = (0..6).map(|i| counted(1000.0 * i as f32, FLOAT, level(i))).collect();
    let channel = AnyChannel::new("Y", Levels::Mip { rounding_mode: RoundingMode::Down, level_data: maps });
    let encoding = Layout {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(16, 8)),
        line_order: LineOrder::Unspecified,
    };
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new((width, height), LayerAttributes::default(), encoding, channels);
    let path = folder.file("mip.exr");
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let picture = read(&Source::file(&path)).unwrap();
    assert_eq!((picture.width, picture.height), (37, 21));
    for [first, count] in [[0, 1], [7, 9], [20, 1], [5, 16]] {
        let rows = ReadOptions { rows: Some([first, count]), ..Budget(1 << 30).into() };
        let part = read_within(&Source::file(&path), rows).unwrap();
        assert_eq!((part.width, part.height, part.whole_height()), (37, count, 21));
        let is_same = |y| (0..37).all(|x| part.pixel(x, y) == picture.pixel(x, first + y));
        assert!((0..count).all(is_same), "{first}, {count}");
    }
    for (x, y) in [(0, 0), (36, 0), (17, 9), (36, 20)] {
        assert_eq!(picture.pixel(x, y)[0], (y * 37 + x) as f32);
    }
}

#[test]
fn every_packing_of_the_decoder_is_read() {
    use Compression::*;
    let folder = Folder::new("packings");
    let packings = [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, DWAA(None), DWAB(Some(1.0))];
    for compression in packings {
        let rgb = [("R", 10.0, HALF), ("G", 20.0, HALF), ("B", 30.0, HALF)];
        let mut layer = part("", (0, 0), &rgb);
        layer.encoding = Layout { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let path = write(&folder, plain(), vec![layer]);
        let [r, g, b, a] = read(&Source::file(path)).unwrap().pixel(4, 3);
        let off = (r - 29.0).abs().max((g - 39.0).abs()).max((b - 49.0).abs());
        assert!(off <= 0.25 && a == 1.0, "{compression:?}: {r} {g} {b} {a}");
    }
}

#[test]
fn stated_primaries_are_converted_and_data_is_not() {
    let folder = Folder::new("primaries");
    let channels = [
        ("R", 1.0, FLOAT),
        ("G", 0.0, FLOAT),
        ("B", 0.0, FLOAT),
        ("N.X", 1.0, FLOAT),
        ("N.Y", 0.0, FLOAT),
        ("N.Z", 0.0, FLOAT),
    ];
    let mut image = ImageAttributes::new(plain());
    image.chromaticities = Some(Chromaticities {
        red: Vec2(0.708, 0.292),
        green: Vec2(0.170, 0.797),
        blue: Vec2(0.131, 0.046),
        white: Vec2(0.3127, 0.3290),
    });
    let layers: SmallVec<[Part; 2]> = [part("", (0, 0), &channels)].into_iter().collect();
    let path = folder.file("rec2020.exr");
    Image::from_layers(image, layers).write().to_file(&path).unwrap();
    let [r, g, b, _] = read(&Source::file(&path)).unwrap().pixel(0, 0);
    // The first column of the published matrix, ITU-R BT.2087.
    for (value, expected) in [(r, 1.660491), (g, -0.124550), (b, -0.018151)] {
        assert!((value - expected).abs() < 1e-5, "{value} is not {expected}");
    }
    let stated = read(&Source::file(&path)).unwrap().meta.image.chromaticities.unwrap();
    assert_eq!(stated.red, Vec2(0.64, 0.33));
    assert_eq!(read_layer(&path, "N").unwrap().pixel(0, 0), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(read_layer(&path, "R").unwrap().pixel(0, 0), [1.0, 1.0, 1.0, 1.0]);
}

#[test]
fn custom_text_of_a_part_is_kept() {
    let folder = Folder::new("custom");
    let mut layer = part("", (0, 0), &[("Y", 1.0, HALF)]);
    layer.attributes.comments = Text::new_or_none("a note");
    let path = write(&folder, plain(), vec![layer]);
    assert_eq!(read(&Source::file(path)).unwrap().meta.layer.comments, Text::new_or_none("a note"));
}
