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

fn scene_light(space: &str) -> Encoding {
    let primaries = ColorSpace::named(space).map(|space| space.primaries);
    Encoding { bits: 32, scene: true, primaries, ..Encoding::EXR }
}

/// What another reader finds in a file: red and white as B, G, R, and the attributes that name a space.
fn stored(folder: &Folder, options: &Encoding) -> ([[f32; 2]; 3], [Option<String>; 2]) {
    let path = folder.with("stored.exr", &encode(&lights(), options).unwrap());
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
    let plain = Encoding { bits: 16, compression: ExrCompression::None, ..scene_light("ACES2065-1") };
    let table = [
        (plain, Some("lin_ap0_scene"), Some("1")),
        (Encoding { bits: 32, ..plain }, Some("lin_ap0_scene"), None),
        (Encoding { compression: ExrCompression::Zip, ..plain }, Some("lin_ap0_scene"), None),
        (Encoding { primaries: Some(Chromaticities::ACES_CG), ..plain }, Some("lin_ap1_scene"), None),
        (Encoding { scene: false, ..plain }, None, None),
        (Encoding { color: None, ..plain }, None, None),
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
        let path = folder.with("neutral.exr", &encode(&picture, &scene_light(space)).unwrap());
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
    let lies = encode(&lights(), &scene_light("Rec709")).unwrap();
    let picture = as_space(&lies, "acescg").unwrap();
    for (value, expected) in picture.pixel(0, 0).into_iter().zip([1.705051, -0.130256, -0.024003, 1.0]) {
        assert!((value - expected).abs() < 2e-6, "{value} is not {expected}");
    }
    assert_eq!(picture.stated, Some(Colorimetry::linear(Chromaticities::ACES_CG)));
    let error = as_space(&lies, "sRGB").unwrap_err();
    assert_eq!(error.message, "this file holds linear light, and not sRGB");
    // Code 128 of a PNG that says sRGB.
    let codes = [0.501_960_8; 4];
    let png = encode(((1, 1), Samples::Float(&codes)), &Encoding { dither: None, ..Encoding::PNG });
    let png = png.unwrap();
    for (space, light) in [("sRGB", 0.215_861), ("Rec709", 0.501_961), ("Rec2100-PQ", 0.463_42)] {
        let [r, g, b, _] = as_space(&png, space).unwrap().pixel(0, 0);
        assert!([r, g, b].iter().all(|value| (value - light).abs() < 3e-4), "{space}: {r} {g} {b}");
    }
}

/// A file of the color 0.25, 0.5, 0.75 whose `colorInteropID` is this.
fn named(folder: &Folder, id: &str, primaries: Option<Chromaticities>) -> std::path::PathBuf {
    let mut source = Picture::new(1, 1, Pixels::Float(vec![0.25, 0.5, 0.75, 1.0]));
    source.meta.set_text("other", id);
    let color = Some(Colorimetry::linear(primaries.unwrap_or(Chromaticities::REC709)));
    let bytes = encode(&source, &Encoding { bits: 32, color, ..Encoding::EXR }).unwrap();
    // The name of the attribute has as many letters as that of another one, to stay in its place.
    let renamed = |bytes: &[u8], from: &str, to: &str| {
        let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
        [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
    };
    let bytes = renamed(&bytes, "other\0string", "colorInteropID\0string");
    let bytes = if primaries.is_none() { renamed(&bytes, "chromaticities\0chr", "notaspaceatall\0chr") } else { bytes };
    // The table of offsets moved by nine letters.
    let table = bytes.len() - 8 - 8 - 16;
    let offset = (table as u64 + 8).to_le_bytes();
    folder.with("named.exr", &[&bytes[..table], &offset, &bytes[table + 8..]].concat())
}

#[test]
fn every_name_of_the_color_interop_forum_is_read() {
    let folder = Folder::new("spaces-names");
    let adobe = [0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329];
    let adobe = Chromaticities::from_numbers(adobe).unwrap();
    let (srgb, g) = (|v: f64| ((v + 0.055) / 1.055).powf(2.4), |power: f64| move |v: f64| v.powf(power));
    let same = |v: f64| v;
    let of = |primaries: &Chromaticities, curve: &dyn Fn(f64) -> f64| {
        let light = glam::DVec3::new(curve(0.25), curve(0.5), curve(0.75));
        primaries.conversion(&Chromaticities::REC709) * light
    };
    use Chromaticities as C;
    let table = [
        ("lin_rec709_scene", of(&C::REC709, &same)),
        ("lin_ap1_scene", of(&C::ACES_CG, &same)),
        ("lin_ap0_scene", of(&C::ACES_AP0, &same)),
        ("lin_rec2020_scene", of(&C::REC2020, &same)),
        ("lin_p3d65_scene", of(&C::DISPLAY_P3, &same)),
        ("lin_adobergb_scene", of(&adobe, &same)),
        ("lin_ciexyzd65_scene", C::REC709.to_xyz().inverse() * glam::DVec3::new(0.25, 0.5, 0.75)),
        ("srgb_rec709_scene", of(&C::REC709, &srgb)),
        ("g22_rec709_scene", of(&C::REC709, &g(2.2))),
        ("g18_rec709_scene", of(&C::REC709, &g(1.8))),
        ("srgb_ap1_scene", of(&C::ACES_CG, &srgb)),
        ("g22_ap1_scene", of(&C::ACES_CG, &g(2.2))),
        ("srgb_p3d65_scene", of(&C::DISPLAY_P3, &srgb)),
        ("g22_adobergb_scene", of(&adobe, &g(2.2))),
        ("srgb_rec709_display", of(&C::REC709, &srgb)),
        ("g24_rec709_display", of(&C::REC709, &g(2.4))),
        ("g26_p3d65_display", of(&C::DISPLAY_P3, &g(2.6))),
        ("data", glam::DVec3::new(0.25, 0.5, 0.75)),
    ];
    for (id, expected) in table {
        let back = read(&Source::file(named(&folder, id, None))).unwrap();
        let [r, g, b, _] = back.pixel(0, 0).map(f64::from);
        assert!((glam::DVec3::new(r, g, b) - expected).abs().max_element() < 1e-5, "{id}: {r} {g} {b}, {expected}");
        assert_eq!((back.notes.len(), back.meta.has_unknown_colors), if id == "data" { (1, true) } else { (0, false) });
    }
    // PQ of 0.5 is 92.2 cd/m2; 1 is 203.
    let pq = read(&Source::file(named(&folder, "pq_rec2020_display", Some(Chromaticities::REC709)))).unwrap();
    assert!((pq.pixel(0, 0)[1] - 92.2 / 203.0).abs() < 1e-3, "{:?}", pq.pixel(0, 0));
}

#[test]
fn a_name_that_is_not_known_is_told_and_nothing_else_is_claimed() {
    let folder = Folder::new("spaces-unknown");
    for (primaries, has_chromaticities) in [(None, false), (Some(Chromaticities::REC2020), true)] {
        for id in ["unknown", "studio:log_scene", "lin_rec709", "g26_xyzd65_display"] {
            let back = read(&Source::file(named(&folder, id, primaries))).unwrap();
            assert!(matches!(&back.notes[..], [note] if note.contains(&format!("`{id}`"))), "{:?}", back.notes);
            let options = Encoding { scene: true, ..Encoding::EXR };
            let written = encode(&back, &options).unwrap();
            let states = |name: &str| written.windows(name.len()).any(|window| window == name.as_bytes());
            let found = [states("colorInteropID"), states("\0chromaticities\0chromaticities\0")];
            assert_eq!(found, [false, has_chromaticities], "{id}");
        }
    }
    let told = read(&Source::file(named(&folder, "lin_ap1_scene", Some(Chromaticities::REC2020)))).unwrap().notes;
    assert!(matches!(&told[..], [note] if note.contains("contradict")), "{told:?}");
    let stated = ReadOptions { space: ColorSpace::named("ACEScg"), ..Budget(1 << 30).into() };
    let back = read_within(&Source::file(named(&folder, "unknown", None)), stated).unwrap();
    assert_eq!((back.notes.len(), back.meta.has_unknown_colors), (0, false), "the command line states the space");
}

#[test]
fn tristimulus_values_come_back_as_they_were() {
    let third = 1.0 / 3.0;
    let xyz = Chromaticities::from_numbers([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, third, third]).unwrap();
    let folder = Folder::new("spaces-xyz");
    let options = Encoding { bits: 32, scene: true, primaries: Some(xyz), ..Encoding::EXR };
    let back = folder.read(&encode(&lights(), &options).unwrap()).unwrap();
    for (value, expected) in back.pixels.to_f32().iter().zip(LIGHTS) {
        assert!((value - expected).abs() < 1e-5, "{value} is not {expected}");
    }
    // Red has the luminance of Rec.709, whatever the white of the numbers.
    let (stored, [named, _]) = stored(&folder, &options);
    assert!((stored[1][0] - 0.2126).abs() < 1e-4, "{stored:?}");
    assert_eq!(named.as_deref(), Some("lin_ciexyzd65_scene"));
}
