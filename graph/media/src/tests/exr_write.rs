//! What is written is what is read back.

use ::exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use half::f16;

use super::{Folder, ODD_SIZES, numbers, picture};
use crate::*;

const ALL: [ExrCompression; 5] =
    [ExrCompression::None, ExrCompression::Rle, ExrCompression::Zip, ExrCompression::Zips, ExrCompression::Piz];

fn encoded(picture: &Picture, options: &ExrOptions) -> Vec<u8> {
    encode_exr(picture, options).unwrap()
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
            let float = picture.pixels.bytes_per_channel() == 4;
            for compression in ALL {
                let options = ExrOptions { float, compression, ..ExrOptions::default() };
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
    let options = ExrOptions { alpha: false, ..ExrOptions::default() };
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
        encoded(&picture, &ExrOptions::default())
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
    let back = Folder::new("attributes").read(&encoded(&picture, &ExrOptions::default())).unwrap();
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
    let back = Folder::new("resized").read(&encoded(&small, &ExrOptions::default())).unwrap();
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
    let back = Folder::new("endless-attributes").read(&encoded(&odd, &ExrOptions::default())).unwrap();
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
    let back = Folder::new("odd-attributes").read(&encoded(&odd, &ExrOptions::default())).unwrap();
    assert_eq!(back.meta.image.pixel_aspect, 1.0);
    assert_eq!(back.pixel(1, 1)[0], f16::from_f32(odd.pixel(1, 1)[0]).to_f32());
}
