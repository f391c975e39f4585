//! Color spaces of files: what is written is what is stated, and what is stated can be overruled.

use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use afterimage_base::color::{Chromaticities, Colorimetry};

use super::Folder;
use afterimage_media::*;

/// A light in linear Rec.709 with a pure red, and white.
const LIGHTS: [f32; 8] = [1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0];

fn lights() -> Picture {
    Picture::new(2, 1, Pixels::Float(LIGHTS.to_vec()))
}

fn scene_light(space: &str) -> ExrOptions {
    let primaries = ColorSpace::named(space).map(|space| space.primaries);
    ExrOptions { float: true, scene: true, primaries, ..ExrOptions::default() }
}

/// What another reader finds in a file: red and white as B, G, R, and the attributes that name a space.
fn stored(folder: &Folder, options: &ExrOptions) -> ([[f32; 2]; 3], [Option<String>; 2]) {
    let path = folder.with("stored.exr", &encode_exr(&lights(), options).unwrap());
    let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
    let channels: Vec<[f32; 2]> = layer.channel_data.list[1..]
        .iter()
        .map(|channel| match &channel.sample_data {
            FlatSamples::F32(values) => values.as_slice().try_into().unwrap(),
            FlatSamples::F16(values) => [values[0].to_f32(), values[1].to_f32()],
            FlatSamples::U32(_) => panic!("these are no floats"),
        })
        .collect();
    let named = |name: &str| match layer.attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        Some(AttributeValue::I32(number)) => Some(number.to_string()),
        None => None,
        other => panic!("{name} is {other:?}"),
    };
    (channels.try_into().unwrap(), ["colorInteropID", "acesImageContainerFlag"].map(named))
}

/// The first columns of published matrices from linear Rec.709: ITU-R BT.2087 for Rec.2020, and for the ACES spaces
/// those of the OpenColorIO configurations of ACES.
#[test]
fn pixels_are_converted_to_the_space_that_is_named() {
    let red = [
        ("Rec709", [1.0, 0.0, 0.0], "lin_rec709_scene"),
        ("P3", [0.822462, 0.033194, 0.017083], "lin_p3d65_scene"),
        ("Rec2020", [0.627404, 0.069097, 0.016391], "lin_rec2020_scene"),
        ("ACEScg", [0.613097, 0.070194, 0.020616], "lin_ap1_scene"),
        ("ACES2065-1", [0.439633, 0.089776, 0.017541], "lin_ap0_scene"),
    ];
    let folder = Folder::new("spaces-out");
    for (space, expected, id) in red {
        let ([blue, green, red], [named, flag]) = stored(&folder, &scene_light(space));
        for (value, expected) in [red[0], green[0], blue[0]].iter().zip(expected) {
            assert!((value - expected).abs() < 2e-6, "{space}: {value} is not {expected}");
        }
        for white in [red[1], green[1], blue[1]] {
            assert!((white - 1.0).abs() < 1e-6, "{space}: white is {white}");
        }
        assert_eq!((named.as_deref(), flag), (Some(id), None), "{space}");
        let back = read(&Source::file(folder.file("stored.exr"))).unwrap();
        assert_eq!(back.stated.unwrap().primaries, ColorSpace::named(space).unwrap().primaries);
        let off = back.pixels.to_f32().iter().zip(LIGHTS).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 2e-6, "{space}: {off}");
    }
}

/// SMPTE ST 2065-4: uncompressed halves of ACES2065-1. Light of a display is no light of the scene.
#[test]
fn only_an_aces_container_is_called_one() {
    let folder = Folder::new("spaces-container");
    let plain = ExrOptions { float: false, compression: ExrCompression::None, ..scene_light("ACES2065-1") };
    let table = [
        (plain, Some("lin_ap0_scene"), Some("1")),
        (ExrOptions { float: true, ..plain }, Some("lin_ap0_scene"), None),
        (ExrOptions { compression: ExrCompression::Zip, ..plain }, Some("lin_ap0_scene"), None),
        (ExrOptions { primaries: Some(Chromaticities::ACES_CG), ..plain }, Some("lin_ap1_scene"), None),
        (ExrOptions { scene: false, ..plain }, None, None),
        (ExrOptions { color: None, ..plain }, None, None),
    ];
    for (options, id, flag) in table {
        let (_, [named, flagged]) = stored(&folder, &options);
        assert_eq!((named.as_deref(), flagged.as_deref()), (id, flag), "{options:?}");
    }
}

#[test]
fn the_adopted_neutral_is_carried_to_the_white_of_the_file() {
    let folder = Folder::new("spaces-neutral");
    for (space, white) in [("ACES2065-1", (0.32168, 0.33767)), ("Rec2020", (0.3127, 0.3290))] {
        let mut picture = lights();
        // The white of Rec.709, in which the picture is.
        picture.meta.layer.adopted_neutral = Some((0.3127, 0.3290).into());
        let path = folder.with("neutral.exr", &encode_exr(&picture, &scene_light(space)).unwrap());
        let stated = read_first_flat_layer_from_file(path).unwrap().layer_data.attributes.adopted_neutral.unwrap();
        assert!((stated.0 - white.0).abs() < 1e-5 && (stated.1 - white.1).abs() < 1e-5, "{space}: {stated:?}");
    }
}

#[test]
fn what_a_file_states_can_be_overruled() {
    let folder = Folder::new("spaces-in");
    let as_space = |bytes: &[u8], space: &str| {
        let options = ReadOptions { space: ColorSpace::named(space), ..Budget(1 << 30).into() };
        read_within(&Source::file(folder.with("lies", bytes)), options)
    };
    // Numbers of ACEScg in a file that says Rec.709.
    let lies = encode_exr(&lights(), &scene_light("Rec709")).unwrap();
    let picture = as_space(&lies, "acescg").unwrap();
    for (value, expected) in picture.pixel(0, 0).into_iter().zip([1.705051, -0.130256, -0.024003, 1.0]) {
        assert!((value - expected).abs() < 2e-6, "{value} is not {expected}");
    }
    assert_eq!(picture.stated, Some(Colorimetry::linear(Chromaticities::ACES_CG)));
    let error = as_space(&lies, "sRGB").unwrap_err();
    assert_eq!(error.message, "this file holds linear light, and not sRGB");
    // Code 128 of a PNG that says sRGB.
    let codes = [0.501_960_8; 4];
    let png = encode_png((1, 1), EncodedPixels::Float(&codes), &PngOptions { dither: None, ..PngOptions::default() });
    let png = png.unwrap();
    for (space, light) in [("sRGB", 0.215_861), ("Rec709", 0.501_961), ("Rec2100-PQ", 0.463_42)] {
        let [r, g, b, _] = as_space(&png, space).unwrap().pixel(0, 0);
        assert!([r, g, b].iter().all(|value| (value - light).abs() < 3e-4), "{space}: {r} {g} {b}");
    }
}
