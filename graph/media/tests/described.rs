//! What headers state, of every format: parts, windows, channels, packing, colors and what states them.

use ::exr::image::{Blocks, Encoding as Layout};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Compression, IntegerBounds, LineOrder, Text};
use ::png::{BitDepth, ColorType, Encoder};
use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer, Xy};

use super::exr_read::{FLOAT, HALF, UINT, part, plain, write};
use super::exr_write::with_attribute;
use super::labels::without;
use super::{Folder, message_and_hint};
use afterimage_media::*;

/// A kind of PNG, the bytes of its image, whether it has a chunk `tRNS`, and the reported channels and type.
type Described = (ColorType, BitDepth, usize, bool, &'static [&'static str], &'static str);

fn described(folder: &Folder, bytes: &[u8]) -> Description {
    read_description(&Source::file(folder.with("described", bytes))).unwrap()
}

fn channels(part: &PartDescription) -> Vec<(&str, &str)> {
    part.channels.iter().map(|channel| (channel.name.as_str(), channel.samples)).collect()
}

#[test]
fn an_exr_is_described_part_by_part() {
    let folder = Folder::new("described-exr");
    let display = IntegerBounds::new((-2, 3), (6, 3));
    let mut depth = part("depth", (1, 5), &[("Z", 5.0, FLOAT), ("id", 1.0, UINT)]);
    depth.encoding = Layout {
        compression: Compression::ZIP1,
        blocks: Blocks::Tiles(Vec2(16, 8)),
        line_order: LineOrder::Increasing,
    };
    let mut beauty = part("beauty", (-4, 4), &[("R", 1.0, HALF), ("G", 2.0, HALF), ("B", 3.0, HALF), ("A", 0.0, HALF)]);
    beauty.encoding =
        Layout { compression: Compression::PIZ, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let path = write(&folder, display, vec![depth, beauty]);
    let layer = |layer: &str| read_description(&Source { path: path.clone(), layer: Some(layer.to_owned()) });
    let found = read_description(&Source::file(&path)).unwrap();
    let window = |x, y, width, height| Window { x, y, width, height };
    assert_eq!((found.format, found.parts.len()), ("EXR", 2));
    let [depth, beauty] = [&found.parts[0], &found.parts[1]];
    assert_eq!([depth, beauty].map(|part| part.name.as_deref()), [Some("depth"), Some("beauty")]);
    assert_eq!([depth, beauty].map(|part| part.display), [window(-2, 3, 6, 3); 2]);
    assert_eq!([depth, beauty].map(|part| part.data), [window(1, 5, 5, 4), window(-4, 4, 5, 4)]);
    assert_eq!(channels(depth), [("Z", "float"), ("id", "uint")]);
    assert_eq!(channels(beauty), [("A", "half"), ("B", "half"), ("G", "half"), ("R", "half")]);
    assert_eq!([depth, beauty].map(|part| part.compression.as_str()), ["zips", "piz"]);
    assert_eq!([depth, beauty].map(|part| part.tiles), [Some([16, 8]), None]);
    let names = |channels: &[&str]| channels.iter().map(|name| (*name).to_owned()).collect();
    let picture = PictureChannels { part: 1, channels: names(&["R", "G", "B", "A"]) };
    assert_eq!((found.picture, found.stated_by), (Some(picture), None));
    assert_eq!(found.layers, ["beauty", "depth.Z", "depth.id"]);
    assert!(found.layers.iter().all(|name| layer(name).is_ok()), "each can be read by its name");
    assert_eq!(found.color, Some(Colorimetry::linear(Chromaticities::REC709)), "assumed");
    assert_eq!(found.notes, ["pixels outside the display window are left out"]);
    let id = layer("depth.id").unwrap();
    assert_eq!(id.picture, Some(PictureChannels { part: 0, channels: names(&["id"]) }), "gray is one channel");
    assert_eq!((id.color, id.stated_by), (None, None), "numbers are no color");
    assert_eq!(id.notes[1], "integers beyond 16777216 lose their last digits as 32-bit floats");
    assert_eq!(layer("nothing").unwrap_err().kind, ErrorKind::Missing);
}

/// Each side of a data window by itself.
#[test]
fn pixels_are_left_out_on_each_side_of_the_display_window() {
    let folder = Folder::new("described-windows");
    let cases = [((0, 0), false), ((-1, 0), true), ((0, -1), true), ((2, 0), true), ((0, 2), true), ((1, 1), false)];
    for (at, left_out) in cases {
        let path = write(&folder, IntegerBounds::new((0, 0), (6, 5)), vec![part("", at, &[("Y", 3.0, HALF)])]);
        let notes = read_description(&Source::file(&path)).unwrap().notes;
        assert_eq!(notes.iter().any(|note| note.contains("outside the display window")), left_out, "{at:?}");
    }
}

#[test]
fn an_exr_without_a_picture_is_described_too() {
    let folder = Folder::new("described-none");
    let path = write(&folder, plain(), vec![part("", (0, 0), &[("m", 1.0, HALF), ("n", 2.0, FLOAT)])]);
    let found = read_description(&Source::file(path)).unwrap();
    assert_eq!((found.picture, found.color, found.parts[0].name.as_deref()), (None, None, None));
    assert_eq!(channels(&found.parts[0]), [("m", "half"), ("n", "float")]);
}

/// The codes and the names of OpenEXR. One row is one block, whatever packs it.
#[test]
fn packings_have_the_names_of_openexr() {
    let folder = Folder::new("described-packings");
    let names = ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"];
    let file = encode(&super::picture(4, 1), &Encoding::EXR).unwrap();
    let head = b"compression\0compression\0\x01\0\0\0";
    let at = file.windows(head.len()).position(|bytes| bytes == head).unwrap() + head.len();
    for (code, name) in (0..).zip(names) {
        let mut file = file.clone();
        file[at] = code;
        assert_eq!(described(&folder, &file).parts[0].compression, name);
    }
}

#[test]
fn what_states_the_colors_of_an_exr_is_named() {
    let folder = Folder::new("described-colors");
    let white = Xy::new(0.34, 0.35);
    let color = Colorimetry { adopted_white: Some(white), ..Colorimetry::linear(Chromaticities::REC2020) };
    let color = Colorimetry { white_nits: Some(Decimal::new(100.0)), ..color };
    let file = encode(&super::picture(2, 1), &Encoding { color: Some(color), ..Encoding::EXR }).unwrap();
    let found = described(&folder, &file);
    assert_eq!((found.color, found.stated_by), (Some(color), Some("chromaticities")));
    let mut bare = super::picture(1, 1);
    bare.meta.layer.other.insert(Text::from("unused"), AttributeValue::I32(0));
    let bare = encode(&bare, &Encoding { color: None, ..Encoding::EXR }).unwrap();
    let id = |id: &str| AttributeValue::Text(id.into());
    let table = [
        ("colorInteropID", id("lin_ap1_scene"), Some("colorInteropID"), Chromaticities::ACES_CG),
        ("colorInteropID", id("srgb_p3d65_scene"), Some("colorInteropID"), Chromaticities::DISPLAY_P3),
        ("colorInteropID", id("unknown"), None, Chromaticities::REC709),
        ("acesImageContainerFlag", AttributeValue::I32(1), Some("acesImageContainerFlag"), Chromaticities::ACES_AP0),
        ("acesImageContainerFlag", AttributeValue::I32(0), None, Chromaticities::REC709),
    ];
    for (name, value, stated_by, primaries) in table {
        let found = described(&folder, &with_attribute(&bare, name, &value));
        let color = found.color.map(|color| color.primaries);
        assert_eq!((found.stated_by, color), (stated_by, Some(primaries)), "{name} {value:?}");
    }
}

#[test]
fn a_radiance_file_is_described() {
    let folder = Folder::new("described-hdr");
    let file = |signature: &str, primaries: &str| {
        let head = format!("#?{signature}\nFORMAT=32-bit_rle_rgbe\n{primaries}\n-Y 2 +X 3\n");
        [head.into_bytes(), vec![128; 24]].concat()
    };
    let found = described(&folder, &file("RADIANCE", ""));
    let window = Window { x: 0, y: 0, width: 3, height: 2 };
    assert_eq!((found.format, found.parts.len()), ("Radiance HDR", 1));
    assert_eq!((found.parts[0].display, found.parts[0].data), (window, window));
    assert_eq!(channels(&found.parts[0]), [("R", "RGBE"), ("G", "RGBE"), ("B", "RGBE")]);
    assert_eq!(found.picture.unwrap().channels, ["R", "G", "B"]);
    assert_eq!((found.color, found.stated_by), (Some(Colorimetry::linear(Chromaticities::REC709)), None));
    let found = described(&folder, &file("RADIANCE", "PRIMARIES=.708 .292 .170 .797 .131 .046 .3127 .3290\n"));
    let rec2020 = Colorimetry::linear(Chromaticities::REC2020);
    assert_eq!((found.color, found.stated_by), (Some(rec2020), Some("PRIMARIES")));
    assert_eq!(
        described(&folder, &file("RADIANCE", "PRIMARIES=.708 .292\n")).stated_by,
        None,
        "six numbers are missing"
    );
    // Both signatures are in use.
    assert_eq!(described(&folder, &file("RGBE", "")).parts[0].data, window);
}

#[test]
fn the_channels_of_every_kind_of_png_are_described() {
    let folder = Folder::new("described-png");
    let table: [Described; 8] = [
        (ColorType::Grayscale, BitDepth::Eight, 3, false, &["Y"], "8 bits"),
        (ColorType::Grayscale, BitDepth::Sixteen, 6, false, &["Y"], "16 bits"),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, 6, false, &["Y", "A"], "8 bits"),
        (ColorType::Rgb, BitDepth::Eight, 9, false, &["R", "G", "B"], "8 bits"),
        (ColorType::Rgb, BitDepth::Sixteen, 18, false, &["R", "G", "B"], "16 bits"),
        (ColorType::Rgba, BitDepth::Eight, 12, false, &["R", "G", "B", "A"], "8 bits"),
        (ColorType::Indexed, BitDepth::Eight, 3, false, &["R", "G", "B"], "8 bits"),
        (ColorType::Indexed, BitDepth::Eight, 3, true, &["R", "G", "B", "A"], "8 bits"),
    ];
    for (color, depth, bytes, has_trns, names, samples) in table {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 3, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ColorType::Indexed {
            encoder.set_palette(vec![10, 20, 30]);
        }
        if has_trns {
            encoder.set_trns(vec![128]);
        }
        encoder.write_header().unwrap().write_image_data(&vec![0; bytes]).unwrap();
        let found = described(&folder, &file);
        assert_eq!((found.format, found.parts[0].display.width, found.parts[0].display.height), ("PNG", 3, 1));
        let expected: Vec<(&str, &str)> = names.iter().map(|name| (*name, samples)).collect();
        assert_eq!(channels(&found.parts[0]), expected, "{color:?} {depth:?}");
        assert_eq!(found.picture.unwrap().channels, names, "{color:?}");
        assert_eq!((found.color, found.stated_by), (Some(Colorimetry::SRGB), None), "{color:?}");
    }
}

/// Chunks in the order of their priority (PNG, third edition, 4.3): without one, the next is named, and means the same.
#[test]
fn the_chunk_of_the_highest_priority_is_named() {
    let folder = Folder::new("described-chunks");
    let linear = Colorimetry::linear(Chromaticities::DISPLAY_P3);
    let p3 = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);
    let table: [(Colorimetry, &[&str]); 3] = [
        (Colorimetry::SRGB, &["cICP", "sRGB", "gAMA", "cHRM"]),
        (linear, &["cICP", "gAMA", "cHRM"]),
        (p3, &["cICP", "iCCP"]),
    ];
    for (color, chunks) in table {
        let options = Encoding { color: Some(color), ..Encoding::PNG };
        let mut file = encode(((1, 1), Samples::Byte(&[9, 9, 9, 255])), &options).unwrap();
        for chunk in chunks {
            let found = described(&folder, &file);
            assert_eq!(found.stated_by, Some(*chunk), "{color:?}");
            let read = folder.read(&file).unwrap().stated;
            assert_eq!(found.color, read, "{chunk}");
            // Without a gamma the curve of sRGB is assumed.
            let same = *chunk == "cHRM" || found.color.unwrap().transfer == color.transfer;
            assert!(same && found.color.unwrap().primaries.close_to(&color.primaries, 1e-3), "{chunk}: {found:?}");
            file = without(&file, chunk);
        }
        assert_eq!(described(&folder, &file).stated_by, None);
    }
}

#[test]
fn only_files_with_layers_have_layers_and_cameras() {
    let folder = Folder::new("described-layers");
    let png = encode(((1, 1), Samples::Byte(&[9, 9, 9, 255])), &Encoding::PNG).unwrap();
    let hdr = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\0\0\0\0".to_vec();
    for file in [png, hdr] {
        let source = Source { path: folder.with("flat", &file), layer: Some("Z".to_owned()) };
        let naming = "only EXR files have layers, so `#Z` means nothing here; leave out what follows the file's name";
        assert_eq!(message_and_hint(&read_description(&source).unwrap_err()), naming);
        assert_eq!(message_and_hint(&read(&source).unwrap_err()), naming);
        let camera = read_camera(&source).unwrap_err();
        assert_eq!(camera.kind, ErrorKind::Unsupported);
        assert!(
            message_and_hint(&camera).starts_with("only EXR files state a camera; write the camera into a JSON file")
        );
    }
    let path = folder.0.clone();
    let source = Source::file(path);
    assert_eq!(read_description(&source).unwrap_err().message, "this is a folder, not an image");
    assert_eq!(read_camera(&source).unwrap_err().message, "this is a folder, not an image");
}

/// The camera is that of the part which the layer names.
#[test]
fn a_camera_is_that_of_its_part() {
    let folder = Folder::new("described-camera");
    let mut right = part("right", (0, 0), &[("right.Y", 1.0, HALF)]);
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    right.attributes.world_to_camera = Some(identity);
    right.attributes.world_to_normalized_device = Some(identity);
    let path = write(&folder, plain(), vec![part("left", (0, 0), &[("left.Y", 1.0, HALF)]), right]);
    let camera = |layer: &str| read_camera(&Source { path: path.clone(), layer: Some(layer.to_owned()) });
    // x and y from 0 to 1, and from the top, become -1 to 1.
    let camera_of_right = camera("right").unwrap();
    assert_eq!(camera_of_right.projection[0], [2.0, 0.0, 0.0, -1.0]);
    assert_eq!(camera_of_right.projection[1], [0.0, -2.0, 0.0, 1.0]);
    let missing = camera("left").unwrap_err();
    assert!(missing.message.contains("`worldToCamera` or `worldToNDC` is missing"), "{missing}");
}
