//! Gain maps: the HDR image follows from the bytes of a JPEG by the formula of ISO 21496-1, written here again.

use std::io::Cursor;

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};
use afterimage_media::codec::decode;
use afterimage_media::{Budget, Encoding, ErrorKind, Image, Samples, encode, write_image};
use glam::DVec3;

use super::Folder;

const SIZE: (u32, u32) = (96, 64);
const WHITE: f64 = 203.0;
const PEAK: f64 = 1000.0;

fn pq() -> Colorimetry {
    Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(WHITE, PEAK)
}

/// Light in linear Rec.709, in units of SDR white: from 2^-7 to the peak, with a hue that turns.
fn light(index: u32) -> [f64; 3] {
    let (x, y) = (f64::from(index % SIZE.0) / 95.0, f64::from(index / SIZE.0) / 63.0);
    let level = (x * (PEAK / WHITE).log2() - (1.0 - x) * 7.0).exp2();
    [0.0, 2.1, 4.2].map(|phase| level * (0.65 + 0.35 * (y * 6.3 + phase).cos()))
}

/// The light, its SDR image by a curve, and its HDR image.
fn images() -> (Vec<[f64; 3]>, Vec<f32>, Vec<f32>) {
    let lights: Vec<[f64; 3]> = (0..SIZE.0 * SIZE.1).map(light).collect();
    let curve = |light: f64| Transfer::Srgb.to_signal(1.2 * light / (1.0 + light));
    let sdr = lights.iter().flat_map(|light| light.map(curve).into_iter().chain([1.0]));
    let matrix = Chromaticities::REC709.conversion(&Chromaticities::REC2020);
    let signals = |light: &[f64; 3]| {
        let light = matrix * DVec3::from_array(*light) * WHITE / 10_000.0;
        light.to_array().map(|light| Transfer::Pq.to_signal(light)).into_iter().chain([1.0])
    };
    let (sdr, hdr) = (sdr.map(|signal| signal as f32).collect(), lights.iter().flat_map(signals));
    let hdr = hdr.map(|signal| signal as f32).collect();
    (lights, sdr, hdr)
}

fn image<'a>(sdr: &'a [f32], hdr: &'a [f32], color: Colorimetry) -> Image<'a> {
    Image { size: SIZE, samples: Samples::Float(sdr), meta: None, hdr: Some((Samples::Float(hdr), color)) }
}

/// The bodies of the segments before the first scan, with their places.
fn segments(file: &[u8]) -> Vec<(usize, &[u8])> {
    let (mut at, mut found) = (2, Vec::new());
    while file[at + 1] != 0xda {
        let length = usize::from(u16::from_be_bytes([file[at + 2], file[at + 3]]));
        found.push((at + 4, &file[at + 4..at + 2 + length]));
        at += 2 + length;
    }
    found
}

/// The bytes after the mark in the segment that begins with it, and their place.
fn body<'a>(file: &'a [u8], mark: &[u8]) -> (usize, &'a [u8]) {
    let found = segments(file).into_iter().find_map(|(at, body)| Some((at + mark.len(), body.strip_prefix(mark)?)));
    found.unwrap_or_else(|| panic!("no segment begins with {}", String::from_utf8_lossy(mark)))
}

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes(*bytes[at..].first_chunk().expect("a number"))
}

/// The base and the map, by the multi-picture format.
fn both(file: &[u8]) -> [&[u8]; 2] {
    let (at, directory) = body(file, b"MPF\0");
    let entries = number(directory, 42) as usize;
    let [size, map, place] = [4, 20, 24].map(|more| number(directory, entries + more) as usize);
    assert_eq!((at + place, size + map), (size, file.len()), "the map follows the base, and nothing follows the map");
    [&file[..size], &file[size..]]
}

fn attribute(xmp: &str, name: &str) -> f64 {
    let (_, rest) = xmp.split_once(&format!("{name}=\"")).unwrap_or_else(|| panic!("{xmp} has {name}"));
    rest.split('"').next().expect("an end").parse().expect("a number")
}

/// Red, green and blue of a JPEG in linear light.
fn decoded(file: &[u8]) -> Vec<[f64; 3]> {
    let picture = decode(Cursor::new(file), None, Budget(1 << 30)).expect("each part is a JPEG");
    assert_eq!((picture.width, picture.height), SIZE);
    let values = picture.pixels.to_f32();
    values.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [r, g, b].map(|value| f64::from(*value))).collect()
}

#[test]
fn the_hdr_image_follows_from_the_file() {
    let (lights, sdr, hdr) = images();
    let encoding = Encoding { quality: 98, ..Encoding::JPEG };
    let file = encode(image(&sdr, &hdr, pq()), &encoding).expect("it is encoded");
    let [base, map] = both(&file);
    const ISO: &[u8] = b"urn:iso:std:iso:ts:21496:-1\0";
    assert_eq!(body(base, ISO).1, [0; 4], "the versions");
    let (_, stated) = body(map, ISO);
    assert_eq!((stated.len(), &stated[..5]), (5 + 7 * 8, &[0, 0, 0, 0, 0x40][..]), "primaries of the base");
    let numbers: Vec<f64> = (0..7)
        .map(|index| f64::from(number(stated, 5 + 8 * index) as i32) / f64::from(number(stated, 9 + 8 * index)))
        .collect();
    let [base_headroom, headroom, least, most, gamma, base_offset, offset] = *numbers.first_chunk().expect("numbers");
    assert_eq!((base_headroom, gamma), (0.0, 1.0));
    assert!((headroom - (PEAK / WHITE).log2()).abs() < 1e-6);
    // The XMP states the same.
    const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
    let xmp = String::from_utf8_lossy(body(map, XMP).1);
    for (name, number) in [
        ("GainMapMin", least),
        ("GainMapMax", most),
        ("Gamma", gamma),
        ("OffsetSDR", base_offset),
        ("OffsetHDR", offset),
        ("HDRCapacityMin", base_headroom),
        ("HDRCapacityMax", headroom),
    ] {
        assert_eq!(attribute(&xmp, &format!("hdrgm:{name}")), number, "{name}");
    }
    assert_eq!(attribute(&String::from_utf8_lossy(body(base, XMP).1), "Item:Length") as usize, map.len());

    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for ((base, gain), light) in decoded(base).iter().zip(decoded(map)).zip(&lights) {
        for channel in 0..3 {
            // The codes of the map are no colors of sRGB, which its reader takes them for.
            let code = (Transfer::Srgb.to_signal(gain[channel]) * 255.0).round() / 255.0;
            let gain = (least + code * (most - least)).exp2();
            let hdr = (base[channel] + base_offset) * gain - offset;
            let error = ((hdr + offset) / (light[channel] + offset)).log2().abs();
            (worst, sum) = (worst.max(error), sum + error);
        }
    }
    let mean = sum / (3.0 * lights.len() as f64);
    assert!(worst < 0.15 && mean < 0.025, "stops between the HDR image and the light: {worst}, {mean} on average");
}

#[test]
fn colors_outside_of_the_base_are_noted() {
    let folder = Folder::new("gain-map-notes");
    let (_, sdr, hdr) = images();
    let green = [0.0, 0.5, 0.0, 1.0].repeat(sdr.len() / 4);
    let notes = |hdr: &[f32], primaries| {
        let encoding = Encoding { color: Some(Colorimetry::new(primaries, Transfer::Srgb)), ..Encoding::JPEG };
        write_image(&folder.file("a.jpg"), image(&sdr, hdr, pq()), &encoding).expect("it is written")
    };
    assert_eq!(notes(&hdr, Chromaticities::REC709), Vec::<String>::new());
    let said = notes(&green, Chromaticities::REC709);
    assert!(said.len() == 1 && said[0].starts_with("100 % of the pixels"), "{said:?}");
    assert_eq!(notes(&green, Chromaticities::REC2020), Vec::<String>::new());
}

#[test]
fn other_files_and_images_have_no_gain_map() {
    let (_, sdr, hdr) = images();
    let hlg = Colorimetry { transfer: Transfer::Hlg, ..pq() };
    let small = &hdr[..hdr.len() / 2];
    for (hdr, color, encoding) in [
        (&hdr[..], pq(), Encoding::PNG),
        (&hdr, pq(), Encoding::EXR),
        (&hdr, hlg, Encoding::JPEG),
        (small, pq(), Encoding::JPEG),
    ] {
        let error = encode(image(&sdr, hdr, color), &encoding).expect_err("it is refused");
        assert_eq!(error.kind, ErrorKind::Unsupported);
    }
}
