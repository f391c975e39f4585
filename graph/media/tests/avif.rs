//! AVIF in. The files are of avifenc 0.11, without loss, and the codes those that avifdec gives back in 16 bits.

use afterimage_base::color::{Chromaticities, Colorimetry, GRAPHICS_WHITE, Transfer};
use afterimage_media::{Budget, ErrorKind, Picture, ReadOptions, Source, read_description, read_within};

use super::decoders::{check_alpha, check_cut_and_changed, read_apart};
use super::{Folder, bytes};

/// Twelve bits in Display P3: `-l -d 12 --cicp 12/13/0`.
const RGB: &str = "\
    0000001c667479706176696600000000617669666d6966316d696166000000f26d657461000000000000002868646c72\
    0000000000000000706963740000000000000000000000006c696261766966000000000e7069746d0000000000010000\
    001e696c6f63000000004400000100010000000100000116000000a10000002869696e660000000000010000001a696e\
    6665020000000001000061763031436f6c6f72000000006a697072700000004b6970636f000000146973706500000000\
    0000000300000002000000107069786900000000030c0c0c0000000c617631438140600000000013636f6c726e636c78\
    000c000d0000800000001769706d61000000000000000100010401028304000000a96d64617412000a0858042b1a181a\
    01103292011000008c81a7fffffefe1a11b43ffcf8b272fcad3b62eb7fda4dfda51b7c7d878ecad3b62ebbb7c8edf23b\
    7c8edf23bb5ccffffffffffffffe5a5ffcbf6a835a648b8c64a676645cc20ad6082b82eeea645ca64a676645f6d42cd4\
    2cd42cd42d0982567ffffffffab1623ecc438d1b99faee694437944c93c94893c952f2f0ddfb366944379456f2f13cbc\
    4f2f13cbc4f820";
/// Ten bits in the narrow range: `-d 10 -r limited --cicp 9/16/9`.
const PQ: &str = "\
    00000020667479706176696600000000617669666d6966316d6961664d413141000000f26d6574610000000000000028\
    68646c720000000000000000706963740000000000000000000000006c696261766966000000000e7069746d00000000\
    00010000001e696c6f6300000000440000010001000000010000011a000000720000002869696e660000000000010000\
    001a696e6665020000000001000061763031436f6c6f72000000006a697072700000004b6970636f0000001469737065\
    000000000000000300000002000000107069786900000000030a0a0a0000000c617631438120400000000013636f6c72\
    6e636c78000900100009000000001769706d610000000000000001000104010283040000007a6d64617412000a083804\
    2b184880488032641000008c7e82b7b66903de97ca027424ab54ab3e607e3fa072d02559fb469c3fffffffffffffe672\
    08b1b0193291026eaf40c54f41d47dbf1026f72197597597597652d337ffffffffbca059d1900ddec48f584745ef5c29\
    d35099fe5bf96fe5bf970298";
/// Eight bits with alpha: `-l -d 8 --cicp 1/13/0`.
const ALPHA: &str = "\
    00000020667479706176696600000000617669666d6966316d6961664d4131410000018d6d6574610000000000000028\
    68646c720000000000000000706963740000000000000000000000006c696261766966000000000e7069746d00000000\
    00010000002c696c6f630000000044000002000100000001000001dc00000083000200000001000001b5000000270000\
    004269696e660000000000020000001a696e6665020000000001000061763031436f6c6f72000000001a696e66650200\
    00000002000061763031416c706861000000001a69726566000000000000000e6175786c000200010001000000c36970\
    72700000009d6970636f0000001469737065000000000000000300000002000000107069786900000000030808080000\
    000c617631438120000000000013636f6c726e636c780001000d0000800000000e706978690000000001080000000c61\
    76314381001c0000000038617578430000000075726e3a6d7065673a6d706567423a636963703a73797374656d733a61\
    7578696c696172793a616c706861000000001e69706d6100000000000000020001040102830400020401058607000000\
    b26d64617412000a0518042b0a80321c1000886a0ffff54335ca6667dfc80c2ca3cee26563264a551515184012000a07\
    38042b08086801327610000047c692ffffffd6a9d408eeaaa30ae38b8e695bfcc3ad294a52949d8c640b87126e33e33f\
    427ffffffffff57e917d528f37813c0bb19706813c0bc4444444444443ef41e123391fb8808080809f60c8ffffffffc8\
    ea8265ab5e8413aae1dc6903a102a783e0f83e1cec8f753d516da812a04c50";
/// Ten bits with halved planes of color, to be turned: `-d 10 -y 420 --cicp 1/13/1 --irot 1`.
const HALVED: &str = "\
    00000020667479706176696600000000617669666d6966316d6961664d413142000000fc6d6574610000000000000028\
    68646c720000000000000000706963740000000000000000000000006c696261766966000000000e7069746d00000000\
    00010000001e696c6f63000000004400000100010000000100000124000000520000002869696e660000000000010000\
    001a696e6665020000000001000061763031436f6c6f72000000007469707270000000546970636f0000001469737065\
    000000000000000600000004000000107069786900000000030a0a0a0000000c6176314381004c0000000013636f6c72\
    6e636c780001000d0001800000000969726f74010000001869706d61000000000000000100010501028304850000005a\
    6d64617412000a0818086ec5010d018432441000008ff2c9567c868857ff67f2d59a398291e4ff4d7c79b73f8bb36ae6\
    3c3f671fa7d4bfee82c60ea7b2ced36e29a727d9e5a69f7bf4c70eb1ba3479e65caf5516d970";
/// Eight bits of luma: `-d 8 -y 400 --cicp 1/13/1`.
const GRAY: &str = "\
    0000001c667479706176696600000000617669666d6966316d696166000000f06d657461000000000000002868646c72\
    0000000000000000706963740000000000000000000000006c696261766966000000000e7069746d0000000000010000\
    001e696c6f630000000044000001000100000001000001140000002a0000002869696e660000000000010000001a696e\
    6665020000000001000061763031436f6c6f72000000006869707270000000496970636f000000146973706500000000\
    00000003000000020000000e706978690000000001080000000c6176314381001c0000000013636f6c726e636c780001\
    000d0001800000001769706d61000000000000000100010401028304000000326d64617412000a0818042b0c04340680\
    321c1000886a0ffffffdeff7558bad0958249131a38530456098254514a8";
const RGB_CODES: [[u16; 3]; 6] = [
    [0, 16, 65535],
    [52956, 30727, 33768],
    [41305, 18724, 64207],
    [3521, 18212, 25126],
    [37433, 26774, 8578],
    [2961, 64, 3185],
];
const PQ_CODES: [[u16; 3]; 6] = [
    [61965, 41033, 44831],
    [58882, 37941, 50957],
    [54630, 14708, 3622],
    [19662, 18603, 57225],
    [59836, 324, 32742],
    [53781, 8580, 52215],
];
const HALVED_CODES: [[u16; 3]; 24] = [
    [45845, 9016, 25015],
    [50416, 20004, 29599],
    [50396, 32818, 29607],
    [54967, 43805, 34191],
    [40234, 8205, 27395],
    [44804, 19192, 31980],
    [44849, 32070, 32051],
    [49419, 43057, 36636],
    [30676, 8248, 33822],
    [35246, 19235, 38407],
    [35227, 32049, 38414],
    [39797, 43036, 42999],
    [21054, 8223, 40215],
    [25625, 19210, 44799],
    [25605, 32024, 44807],
    [30176, 43011, 49391],
    [11432, 8196, 46637],
    [16003, 19183, 51222],
    [16047, 32061, 51293],
    [20618, 43048, 55878],
    [5885, 7445, 49112],
    [10455, 18432, 53696],
    [10436, 31246, 53704],
    [15006, 42234, 58288],
];
const GRAY_CODES: [[u16; 3]; 6] = [
    [7710, 7710, 7710],
    [30583, 30583, 30583],
    [53713, 53713, 53713],
    [19789, 19789, 19789],
    [22359, 22359, 22359],
    [18247, 18247, 18247],
];
const ALPHA_CODES: [[u8; 4]; 6] = [
    [207, 21, 45, 60],
    [46, 205, 222, 149],
    [10, 24, 85, 110],
    [159, 122, 67, 40],
    [177, 188, 8, 29],
    [115, 100, 227, 132],
];

/// Compares light with that of codes, within three of 65535.
fn check(picture: &Picture, color: Colorimetry, codes: &[[u16; 3]]) {
    let unit = if color.transfer == Transfer::Pq { 10000.0 / 203.0 } else { 1.0 };
    let light = |code: f64| color.transfer.to_light((code / 65535.0).clamp(0.0, 1.0)) * unit;
    let matrix = color.primaries.conversion(&Chromaticities::REC709);
    let pixels = picture.pixels.to_f32();
    assert_eq!(pixels.len(), 4 * codes.len());
    for (pixel, codes) in pixels.as_chunks::<4>().0.iter().zip(codes) {
        let codes = codes.map(f64::from);
        let expected = matrix * glam::DVec3::from(codes.map(light));
        let steps = codes.map(|code| light(code + 3.0) - light(code - 3.0));
        let slack = steps.into_iter().fold(1e-6 * unit, f64::max);
        for (found, expected) in pixel.iter().zip(expected.to_array().into_iter().chain([1.0])) {
            assert!((f64::from(*found) - expected).abs() < slack, "{color:?}: {found} is not {expected}");
        }
    }
}

#[test]
fn codes_of_every_depth_and_layout_are_those_of_avifdec() {
    let folder = Folder::new("avif");
    let p3 = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);
    let hdr = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq);
    let stated = Colorimetry { white_nits: Some(GRAPHICS_WHITE), ..hdr };
    for (file, size, color, stated, codes, samples) in [
        (RGB, (3, 2), p3, p3, &RGB_CODES[..], "12 bits"),
        (PQ, (3, 2), hdr, stated, &PQ_CODES, "10 bits"),
        (HALVED, (4, 6), Colorimetry::SRGB, Colorimetry::SRGB, &HALVED_CODES, "10 bits"),
        (GRAY, (3, 2), Colorimetry::SRGB, Colorimetry::SRGB, &GRAY_CODES, "8 bits"),
    ] {
        let picture = read_apart(&folder, "a.avif", &bytes(file));
        assert_eq!((picture.width, picture.height, picture.stated), (size.0, size.1, Some(stated)));
        check(&picture, color, codes);
        let described = read_description(&Source::file(folder.file("a.avif"))).unwrap();
        assert_eq!((described.format, described.color, described.stated_by), ("AVIF", Some(stated), Some("nclx")));
        let part = &described.parts[0];
        assert_eq!((part.data.width, part.data.height), (u64::from(size.0), u64::from(size.1)));
        assert_eq!(part.channels[0].samples, samples);
    }
}

#[test]
fn colors_are_those_of_the_frame_where_the_file_states_none() {
    let folder = Folder::new("avif-frame");
    // The box of colors becomes one that is skipped.
    let mut file = bytes(RGB);
    let at = file.windows(4).position(|name| name == b"colr").expect("a box");
    file[at..at + 4].copy_from_slice(b"free");
    let picture = read_apart(&folder, "a.avif", &file);
    let p3 = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);
    assert_eq!(picture.stated, Some(p3));
    check(&picture, p3, &RGB_CODES);
    // Code points that state nothing are those of sRGB.
    let mut file = bytes(RGB);
    file[at + 8..at + 12].copy_from_slice(&[0, 2, 0, 2]);
    let picture = read_apart(&folder, "a.avif", &file);
    assert_eq!(picture.stated, None);
    check(&picture, Colorimetry::SRGB, &RGB_CODES);
}

#[test]
fn alpha_is_straight_and_multiplied_where_it_is_asked_for() {
    check_alpha(&Folder::new("avif-alpha"), "a.avif", &bytes(ALPHA), &ALPHA_CODES);
}

#[test]
fn a_file_that_is_cut_or_changed_is_read_or_refused() {
    let folder = Folder::new("avif-hostile");
    check_cut_and_changed(&folder, [RGB, PQ, ALPHA, HALVED, GRAY].map(bytes));
    let options = ReadOptions { ..Budget(64).into() };
    let error = read_within(&Source::file(folder.with("b.avif", &bytes(RGB))), options).unwrap_err();
    assert_eq!(error.kind, ErrorKind::TooLarge);
}
