//! DPX in. `tests/oracles.sh` lets ffmpeg and OpenImageIO write others.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};
use afterimage_media::{Budget, ErrorKind, Picture, ReadOptions, Source, read_description, read_within};

use super::{Folder, ODD_SIZES, message_and_hint};

const LINEAR: u8 = 2;

/// The header of a file.
#[derive(Clone, Copy)]
struct Layout {
    is_little: bool,
    bits: u8,
    descriptor: u8,
    packing: u16,
    transfer: u8,
    orientation: u16,
    size: (u32, u32),
}

const RGB10: Layout =
    Layout { is_little: false, bits: 10, descriptor: 50, packing: 1, transfer: LINEAR, orientation: 0, size: (3, 2) };

impl Layout {
    fn channels(self) -> usize {
        match self.descriptor {
            6 => 1,
            50 => 3,
            _ => 4,
        }
    }

    fn word(self, bytes: &mut [u8], at: usize, number: u64, length: usize) {
        let big = number.to_be_bytes();
        let word = &mut bytes[at..at + length];
        word.copy_from_slice(&big[8 - length..]);
        if self.is_little {
            word.reverse();
        }
    }

    /// The file of bytes that follow its header of 2048 bytes.
    fn file(self, picture: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0; 2048];
        bytes[..4].copy_from_slice(if self.is_little { b"XPDS" } else { b"SDPX" });
        let (width, height) = self.size;
        for (at, number, length) in [
            (4, 2048, 4),
            (768, u64::from(self.orientation), 2),
            (770, 1, 2),
            (772, width.into(), 4),
            (776, height.into(), 4),
            (804, u64::from(self.packing), 2),
            (812, u32::MAX.into(), 4),
        ] {
            self.word(&mut bytes, at, number, length);
        }
        (bytes[800], bytes[801], bytes[803]) = (self.descriptor, self.transfer, self.bits);
        bytes.extend_from_slice(picture);
        bytes
    }

    /// The file of codes, whose rows start at words of four bytes.
    fn of_codes(self, codes: &[u16]) -> Vec<u8> {
        let mut picture = Vec::new();
        for row in codes.chunks(self.size.0 as usize * self.channels()) {
            match self.bits {
                8 => picture.extend(row.iter().map(|code| *code as u8)),
                10 => {
                    for three in row.chunks(3) {
                        let shifts = [22, 12, 2].map(|shift| if self.packing == 2 { shift - 2 } else { shift });
                        let sum: u64 = three.iter().zip(shifts).map(|(code, shift)| u64::from(*code) << shift).sum();
                        let at = picture.len();
                        picture.resize(at + 4, 0);
                        self.word(&mut picture, at, sum, 4);
                    }
                }
                bits => {
                    let shift = if bits == 12 && self.packing == 1 { 4 } else { 0 };
                    for code in row {
                        let at = picture.len();
                        picture.resize(at + 2, 0);
                        self.word(&mut picture, at, u64::from(*code) << shift, 2);
                    }
                }
            }
            picture.resize(picture.len().next_multiple_of(4), 0);
        }
        self.file(&picture)
    }
}

/// The picture with alpha apart from the color.
fn read_apart(folder: &Folder, bytes: &[u8]) -> Picture {
    let options = ReadOptions { premultiplied: false, ..Budget(1 << 30).into() };
    read_within(&Source::file(folder.with("a.dpx", bytes)), options).unwrap_or_else(|error| panic!("{error}"))
}

/// The codes of ffmpeg 5.1: three pixels in two rows, as `gbrp10` and `rgb48`.
#[test]
fn codes_are_those_that_ffmpeg_has_written() {
    let folder = Folder::new("dpx-ffmpeg");
    let codes = [0_u16, 1, 1023, 685, 95, 512, 341, 682, 1022, 4, 8, 16, 32, 64, 128, 256, 1000, 3];
    let ten = [0x00001ffc, 0xab45f800, 0x556aaff8, 0x01008040, 0x08040200, 0x403e800c_u32];
    let sixteen: [[u16; 10]; 2] = [
        [0x0005, 0x0045, 0xffc5, 0xab45, 0x17c5, 0x8005, 0x5545, 0xaa85, 0xff85, 0],
        [0x0105, 0x0205, 0x0405, 0x0805, 0x1005, 0x2005, 0x4005, 0xfa05, 0x00c5, 0],
    ];
    for is_little in [false, true] {
        let layout = Layout { is_little, ..RGB10 };
        let of_ten = |word: &u32| if is_little { word.to_le_bytes() } else { word.to_be_bytes() };
        let of_sixteen = |word: &u16| if is_little { word.to_le_bytes() } else { word.to_be_bytes() };
        let ten: Vec<u8> = ten.iter().flat_map(of_ten).collect();
        let sixteen: Vec<u8> = sixteen.iter().flatten().flat_map(of_sixteen).collect();
        for (layout, picture, last) in [(layout, &ten, 1023.0), (Layout { bits: 16, ..layout }, &sixteen, 65535.0)] {
            let found = read_apart(&folder, &layout.file(picture)).pixels.to_f32();
            for (pixel, codes) in found.as_chunks::<4>().0.iter().zip(codes.as_chunks::<3>().0) {
                let code = |code: u16| if last > 1023.0 { f32::from(code * 64 + 5) } else { f32::from(code) };
                let expected = codes.map(|number| code(number) / last);
                assert!(pixel[..3].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{pixel:?} {expected:?}");
            }
        }
    }
}

#[test]
fn codes_of_every_layout_come_back_in_every_size() {
    let folder = Folder::new("dpx-layouts");
    for size in ODD_SIZES {
        for (bits, packing) in [(8, 0), (10, 1), (10, 2), (12, 1), (12, 2), (16, 0)] {
            for (descriptor, is_little) in [6, 50, 51, 52].into_iter().flat_map(|one| [(one, false), (one, true)]) {
                if (bits, descriptor) == (10, 6) {
                    continue;
                }
                let layout = Layout { is_little, bits, descriptor, packing, size, ..RGB10 };
                let last = (1_u32 << bits) - 1;
                let count = size.0 as usize * size.1 as usize * layout.channels();
                let codes: Vec<u16> =
                    (0..count as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 9 & last) as u16).collect();
                let file = layout.of_codes(&codes);
                let found = read_apart(&folder, &file).pixels.to_f32();
                let signal = |code: u16| f32::from(code) / last as f32;
                for (pixel, codes) in found.as_chunks::<4>().0.iter().zip(codes.chunks(layout.channels())) {
                    let expected = match *codes {
                        [gray] => [signal(gray), signal(gray), signal(gray), 1.0],
                        [r, g, b] => [signal(r), signal(g), signal(b), 1.0],
                        [a, b, g, r] if descriptor == 52 => [r, g, b, a].map(signal),
                        [r, g, b, a] => [r, g, b, a].map(signal),
                        _ => unreachable!(),
                    };
                    let tolerance = if bits == 8 { 5e-4 } else { 1e-6 };
                    let is_near = pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() < tolerance);
                    assert!(is_near, "{bits} {descriptor} {size:?}: {pixel:?} is not {expected:?}");
                }
            }
        }
    }
}

/// Rows that do not start at words, as some programs write them, and bytes that follow each row.
#[test]
fn rows_may_have_more_or_less_behind_them() {
    let folder = Folder::new("dpx-rows");
    let layout = Layout { bits: 8, packing: 0, size: (3, 2), ..RGB10 };
    let codes: Vec<u16> = (0..18).map(|code| code * 14).collect();
    let whole = layout.of_codes(&codes);
    let expected = read_apart(&folder, &whole);
    let rows: Vec<u8> = codes.iter().map(|code| *code as u8).collect();
    assert!(read_apart(&folder, &layout.file(&rows)) == expected);
    let padded: Vec<u8> = whole[2048..].chunks(12).flat_map(|row| [row, &[7; 8]].concat()).collect();
    let mut file = layout.file(&padded);
    layout.word(&mut file, 812, 8, 4);
    assert!(read_apart(&folder, &file) == expected);
}

/// Kodak's conversion, with numbers of `colour.models.log_decoding_Cineon` of colour-science 0.4.7.
#[test]
fn the_header_states_the_curve_and_a_name_overrules_it() {
    let folder = Folder::new("dpx-curves");
    let codes = [0_u16, 95, 180, 445, 685, 1023];
    let layout = |transfer| Layout { transfer, size: (2, 1), ..RGB10 };
    let light = |transfer: u8| -> Vec<f32> {
        let pixels = read_apart(&folder, &layout(transfer).of_codes(&codes)).pixels.to_f32();
        pixels.as_chunks::<4>().0.iter().flat_map(|pixel| pixel[..3].to_vec()).collect()
    };
    let film = [-0.005_650_82, 0.0, 0.010_043_92, 0.149_303_7, 1.0, 13.521_695];
    for transfer in [1, 3] {
        for (found, expected) in light(transfer).iter().zip(film) {
            assert!((found - expected).abs() < 1e-6 * expected.abs().max(1.0), "{found} is not {expected}");
        }
    }
    let curve = |transfer: Transfer| codes.map(|code| transfer.to_light(f64::from(code) / 1023.0) as f32).to_vec();
    for (number, transfer) in [
        (2, Transfer::Linear),
        (4, Transfer::Gamma(Decimal::new(2.4))),
        (6, Transfer::Gamma(Decimal::new(2.4))),
        (0, Transfer::Srgb),
        (255, Transfer::Srgb),
    ] {
        assert_eq!(light(number), curve(transfer), "{number}");
    }
    let path = folder.with("b.dpx", &layout(1).of_codes(&codes));
    let space = afterimage_media::ColorSpace::named("sRGB");
    let options = ReadOptions { space, ..Budget(1 << 30).into() };
    let picture = read_within(&Source::file(path.clone()), options).unwrap();
    assert_eq!(picture.pixel(0, 0)[1], curve(Transfer::Srgb)[1]);
    let described = read_description(&Source::file(path)).unwrap();
    assert_eq!((described.format, described.color, described.stated_by), ("DPX", None, Some("transfer")));
    let path = folder.with("c.dpx", &layout(0).of_codes(&codes));
    let described = read_description(&Source::file(path)).unwrap();
    assert_eq!((described.color, described.stated_by), (Some(Colorimetry::SRGB), None));
    assert_eq!(described.parts[0].channels[0].samples, "10 bits");
    let path = folder.with("d.dpx", &layout(6).of_codes(&codes));
    let video = Colorimetry::new(Chromaticities::REC709, Transfer::Gamma(Decimal::new(2.4)));
    assert_eq!(read_description(&Source::file(path)).unwrap().color, Some(video));
}

/// The first row is at the top unless the header says otherwise, and so on.
#[test]
fn pictures_are_upright() {
    let folder = Folder::new("dpx-orientation");
    let codes = [1, 2, 3, 4, 5, 6].map(|code: u16| code * 100);
    let expected: [[u16; 6]; 8] = [
        [1, 2, 3, 4, 5, 6],
        [3, 2, 1, 6, 5, 4],
        [4, 5, 6, 1, 2, 3],
        [6, 5, 4, 3, 2, 1],
        [1, 4, 2, 5, 3, 6],
        [4, 1, 5, 2, 6, 3],
        [3, 6, 2, 5, 1, 4],
        [6, 3, 5, 2, 4, 1],
    ];
    for (orientation, expected) in (0..).zip(expected) {
        let layout = Layout { bits: 16, descriptor: 6, orientation, ..RGB10 };
        let picture = read_apart(&folder, &layout.of_codes(&codes));
        assert_eq!((picture.width, picture.height), if orientation < 4 { (3, 2) } else { (2, 3) });
        let found: Vec<u16> =
            picture.pixels.to_f32().chunks(4).map(|pixel| (pixel[0] * 655.35).round() as u16).collect();
        assert_eq!(found, expected, "{orientation}");
    }
}

#[test]
fn what_is_not_read_says_so_and_lies_are_errors() {
    let folder = Folder::new("dpx-refused");
    let codes = [512_u16; 18];
    let file = RGB10.of_codes(&codes);
    let with = |at: usize, number: u64, length: usize| {
        let mut file = file.clone();
        RGB10.word(&mut file, at, number, length);
        file
    };
    for (file, kind, message) in [
        (with(770, 3, 2), ErrorKind::Unsupported, "its channels are pictures of their own"),
        (with(780, 1, 4), ErrorKind::Unsupported, "its codes are signed"),
        (with(806, 1, 2), ErrorKind::Unsupported, "it is compressed"),
        (with(800, 100, 1), ErrorKind::Unsupported, "descriptor 100"),
        (with(800, 6, 1), ErrorKind::Unsupported, "gray of 10 bits"),
        (with(803, 32, 1), ErrorKind::Unsupported, "its codes have 32 bits"),
        (with(804, 0, 2), ErrorKind::Unsupported, "packed without gaps"),
        (with(801, 13, 1), ErrorKind::Unsupported, "its transfer characteristic is 13; name the space"),
        (with(4, 12, 4), ErrorKind::Broken, "starts inside of its header"),
        (with(4, 1 << 31, 4), ErrorKind::Broken, "ends too early"),
        (with(772, 0, 4), ErrorKind::Broken, "0×2 pixels"),
        (with(772, 70_000, 4), ErrorKind::TooLarge, "at most 65536"),
        (with(812, 0x7fff_ffff, 4), ErrorKind::TooLarge, "decoding may take"),
    ] {
        let error = folder.read(&file).unwrap_err();
        assert!(error.kind == kind && message_and_hint(&error).contains(message), "{message}: {error}");
    }
    let mut large = with(772, 60_000, 4);
    RGB10.word(&mut large, 776, 60_000, 4);
    assert_eq!(folder.read(&large).unwrap_err().kind, ErrorKind::TooLarge);
    for length in (4..file.len()).step_by(97).chain([file.len() - 1]) {
        assert_eq!(folder.read(&file[..length]).unwrap_err().kind, ErrorKind::Broken, "{length}");
    }
    for at in 4..840 {
        for value in [0, 0x7f, 0xff] {
            let mut changed = file.clone();
            changed[at] = value;
            if let Ok(picture) = folder.read(&changed) {
                assert!(picture.pixels.to_f32().iter().all(|number| number.is_finite()));
            }
        }
    }
}
