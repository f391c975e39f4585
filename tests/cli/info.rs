//! The output of the program about files.

use afterimage_graph::color::{Chromaticities, Colorimetry};
use afterimage_media::{Encoding, write_image};
use serde_json::Value;

use super::{Folder, room, save};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_file_says_what_it_holds_and_what_states_its_colors() {
    let folder = Folder::new("info");
    save(&folder.file("room.exr"), &room(12, 8));
    folder.run("render exposure room.exr -o room.png").good();
    folder.run("render hdr room.exr --output hdr=hdr.png").good();
    let json: Vec<Value> = serde_json::from_str(&folder.run("info hdr.png --json").good()).expect("it is JSON");
    // SDR white and the peak that the pipeline states.
    let color = ["transfer", "primaries", "peak_nits"].map(|key| json[0]["color"][key].clone());
    assert_eq!(color, [Value::from("Pq"), "Rec2020".into(), 1000.0.into()]);
    let text = folder.run("info room.exr").good();
    assert!(text.contains("room.exr: EXR\n  12x8, ") && text.contains("(half), zip, rows"), "{text}");
    let text = folder.run("info room.png").good();
    assert!(text.contains("room.png: PNG\n  12x8, R G B (8 bits), deflate, rows"), "{text}");
    let text = folder.run("info hdr.png").good();
    assert!(
        text.contains("R G B (16 bits)") && text.contains("color: Pq, Rec2020") && text.contains("`cICP`"),
        "{text}"
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg_attr(no_ffmpeg, ignore = "ffmpeg is not on the PATH")]
fn a_film_says_what_it_holds() {
    let folder = Folder::new("info-film");
    (1..=4).for_each(|frame| save(&folder.file(&format!("shot.{frame}.exr")), &room(64, 36)));
    folder.run("render exposure shot.#.exr -o in.mov --fps 25").good();
    let text = folder.run("info in.mov").good();
    let expected = "in.mov: film\n  64x36, R G B (10 bits), prores, 4 frames in 0.160 s\n  read: R, G, B\n  \
                    color: Srgb, Rec709, by `color_primaries`\n";
    assert_eq!(text, expected);
    let text = folder.run("info in.mov shot.1.exr --json").good();
    let list: Vec<Value> = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!((&list[0]["frames"], &list[0]["seconds"]), (&4.into(), &0.16.into()));
    assert!(list[1]["frames"].is_null());
}

#[test]
fn the_range_of_each_channel_is_told_on_request() {
    let folder = Folder::new("info-pixels");
    let mut picture = room(6, 4);
    let mut values = vec![0.5; 96];
    (values[0], values[4], values[8], values[9]) = (f32::NAN, f32::INFINITY, -3.5, f32::NAN);
    picture.pixels = afterimage_media::Pixels::Float(values);
    save(&folder.file("odd.exr"), &picture);
    let text = folder.run("info odd.exr --pixels").good();
    assert!(text.contains("    R: -3.5 to 0.5, 1 NaN, 1 infinite\n"), "{text}");
    assert!(text.contains("    G: 0.5 to 0.5, 1 NaN\n") && text.contains("    A: 0.5 to 0.5\n"), "{text}");
    let list: Vec<Value> =
        serde_json::from_str(&folder.run("info odd.exr --pixels --json").good()).expect("it is JSON");
    let red = &list[0]["parts"][0]["channels"][3];
    assert_eq!((&red["name"], &red["nan"], &red["infinite"]), (&"R".into(), &1.into(), &1.into()));
    assert_eq!(red["range"], serde_json::json!([-3.5, 0.5]));
    assert!(!folder.run("info odd.exr").good().contains("NaN"));
    let codes = afterimage_media::Samples::Byte(&[0, 51, 255, 255]);
    let png = afterimage_media::encode(((1, 1), codes), &Encoding::PNG);
    folder.with("codes.png", &png.expect("it can be written"));
    let text = folder.run("info codes.png --pixels").good();
    assert!(text.contains("    R: 0 to 0\n") && text.contains("    B: 1 to 1\n"), "{text}");
}

#[test]
fn a_list_of_files_is_json_and_a_bad_one_is_reported() {
    let folder = Folder::new("info-json");
    let wide = Encoding { bits: 32, color: Some(Colorimetry::linear(Chromaticities::ACES_CG)), ..Encoding::EXR };
    write_image(&folder.file("wide.1.exr"), &room(6, 4), &wide).expect("it can be written");
    write_image(&folder.file("wide.2.exr"), &room(6, 4), &wide).expect("it can be written");
    let list: Vec<Value> = serde_json::from_str(&folder.run("info wide.#.exr --json").good()).expect("it is JSON");
    assert_eq!(list.len(), 2);
    let (color, part) = (&list[1]["color"], &list[1]["parts"][0]);
    assert_eq!((&color["primaries"], &list[1]["stated_by"]), (&"AcesCg".into(), &"chromaticities".into()));
    assert_eq!(
        (&part["display"], &part["channels"][0]["samples"]),
        (&serde_json::json!([0, 0, 6, 4]), &"float".into())
    );
    // Headers alone: what follows may be damaged.
    let bytes = std::fs::read(folder.file("wide.1.exr")).expect("it was written");
    folder.with("damaged.exr", &[&bytes[..bytes.len() - 40], &[7; 40]].concat());
    folder.run("info damaged.exr").good();
    folder.with("words.exr", b"a text");
    let bad = folder.run("info words.exr wide.1.exr");
    assert!(bad.out.contains("wide.1.exr: EXR"), "{}", bad.out);
    bad.fails_saying(1, &["words.exr: this is not an image that this program knows"]);
}

/// Two parts in files of another program: light in tiles beyond the picture, and depth in rows.
#[test]
fn the_text_about_a_file_has_what_its_json_has() {
    use exr::prelude::{
        AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
        LayerAttributes, Layers, LineOrder, Vec2, WritableImage,
    };
    let folder = Folder::new("info-parts");
    let channel = |name: &str| AnyChannel::new(name, FlatSamples::F32((0..24_u8).map(f32::from).collect()));
    let part = |name: &str, channels: &[&str], blocks, compression| {
        let channels = AnyChannels::sort(channels.iter().map(|name| channel(name)).collect());
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let mut attributes = LayerAttributes::named(name);
        attributes.layer_position = Vec2(8, -4);
        Layer::new((6, 4), attributes, encoding, channels)
    };
    let tiles = exr::image::Blocks::Tiles(Vec2(4, 2));
    let light = part("light", &["B", "G", "R"], tiles, Compression::ZIP1);
    let depth = part("depth", &["Z"], exr::image::Blocks::ScanLines, Compression::Uncompressed);
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(16, 9)));
    let image = Image::from_layers(attributes, Layers::from_vec(vec![light, depth]));
    image.write().to_file(folder.file("parts.exr")).expect("it can be written");
    let text = folder.run("info parts.exr --pixels").good();
    let lines = [
        "parts.exr: EXR",
        "  part 0 `light`: 16x9, data 6x4+8-4, display 16x9+0+0, B G R (float), zips, tiles of 4x2",
        "    B: 0 to 23",
        "  part 1 `depth`: 16x9, data 6x4+8-4, display 16x9+0+0, Z (float), none, rows",
        "    Z: 0 to 23",
        "  read: R, G, B of part 0",
        "  color: Linear, Rec709, assumed, because nothing states it",
    ];
    assert!(lines.iter().all(|line| text.lines().any(|told| told == *line)), "{text}");
    let json: Vec<Value> = serde_json::from_str(&folder.run("info parts.exr --json").good()).expect("it is JSON");
    let (parts, color) = (&json[0]["parts"], &json[0]["color"]);
    for (index, [name, compression]) in [["light", "zips"], ["depth", "none"]].into_iter().enumerate() {
        let part = &parts[index];
        assert_eq!((&part["name"], &part["compression"]), (&name.into(), &compression.into()));
        let windows = ["data", "display"].map(|window| part[window].clone());
        assert_eq!(windows, [serde_json::json!([8, -4, 6, 4]), serde_json::json!([0, 0, 16, 9])]);
    }
    assert_eq!((&parts[0]["tiles"], &parts[1]["tiles"]), (&serde_json::json!([4, 2]), &Value::Null));
    assert_eq!(json[0]["picture"], serde_json::json!({ "channels": ["R", "G", "B"], "part": 0 }));
    assert_eq!((&json[0]["stated_by"], &json[0]["format"]), (&Value::Null, &"EXR".into()));
    // ITU-R BT.709, table 1: red, green, blue and white.
    let points: [[f64; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];
    for (found, wanted) in color["chromaticities"].as_array().expect("four points").iter().zip(points) {
        assert!((0..2).all(|at| (found[at].as_f64().expect("a number") - wanted[at]).abs() < 1e-6), "{color}");
    }
    assert_eq!((&color["transfer"], &color["white_nits"]), (&"Linear".into(), &Value::Null));
    let alone = folder.run("info parts.exr#depth.Z").good();
    assert!(alone.contains("  read: Z") && alone.contains("  color: none, plain numbers"), "{alone}");
    folder.run("info none.exr").fails_saying(1, &["none.exr: there is no such file"]);
}
