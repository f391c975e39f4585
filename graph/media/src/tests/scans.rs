//! Arrangements of scans in JPEG files, by an encoder of flat blocks.

use std::io::Cursor;

use crate::codec::decode;
use crate::*;

/// The data of a scan: each difference has a code of four bits, and each block ends at once.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    waiting: u32,
    count: u32,
}

impl Data {
    fn put(&mut self, bits: u32, count: u32) {
        for at in (0..count).rev() {
            self.waiting = self.waiting << 1 | bits >> at & 1;
            self.count += 1;
            if self.count == 8 {
                self.bytes.push(self.waiting as u8);
                if self.waiting == 0xff {
                    self.bytes.push(0);
                }
                (self.waiting, self.count) = (0, 0);
            }
        }
    }

    fn block(&mut self, difference: i32) {
        let size = 32 - difference.unsigned_abs().leading_zeros();
        self.put(size, 4);
        self.put((if difference < 0 { difference - 1 } else { difference }) as u32, size);
        self.put(0, 1);
    }

    fn restart(&mut self, number: usize) {
        while self.count > 0 {
            self.put(1, 1);
        }
        self.bytes.extend([0xff, 0xd0 + (number % 8) as u8]);
    }
}

fn segment(marker: u8, body: &[u8]) -> Vec<u8> {
    [&[0xff, marker], &((body.len() + 2) as u16).to_be_bytes()[..], body].concat()
}

/// A baseline file of flat blocks with these sampling factors and components of each scan.
fn file(size: [usize; 2], sampling: &[[usize; 2]], scans: &[&[usize]], restart: usize) -> Vec<u8> {
    let most = [0, 1].map(|axis| sampling.iter().map(|factors| factors[axis]).max().unwrap());
    let [width, height] = size.map(|side| side as u16).map(u16::to_be_bytes);
    let mut frame = vec![8, height[0], height[1], width[0], width[1], sampling.len() as u8];
    frame.extend((1..).zip(sampling).flat_map(|(id, [across, down])| [id, (across << 4 | down) as u8, 0]));
    // Twelve codes of four bits for the sizes of differences; one bit ends a block.
    let codes = [&[0, 0, 0, 0, 12], &[0; 12][..], &(0..12).collect::<Vec<u8>>()].concat();
    let mut file = vec![0xff, 0xd8];
    file.extend(segment(0xdb, &[&[0][..], &[8; 64]].concat()));
    file.extend(segment(0xc4, &codes));
    file.extend(segment(0xc4, &[&[0x10, 1][..], &[0; 15], &[0]].concat()));
    file.extend(segment(0xdd, &(restart as u16).to_be_bytes()));
    file.extend(segment(0xc0, &frame));
    for members in scans {
        let mut header = vec![members.len() as u8];
        header.extend(members.iter().flat_map(|member| [*member as u8 + 1, 0]));
        header.extend([0, 63, 0]);
        file.extend(segment(0xda, &header));
        let mcus = [0, 1].map(|axis| match **members {
            [one] => (size[axis] * sampling[one][axis]).div_ceil(most[axis]).div_ceil(8),
            _ => size[axis].div_ceil(8 * most[axis]),
        });
        let (mut data, mut last) = (Data::default(), [0; 4]);
        for mcu in 0..mcus[0] * mcus[1] {
            if restart > 0 && mcu > 0 && mcu % restart == 0 {
                data.restart(mcu / restart - 1);
                last = [0; 4];
            }
            for member in *members {
                let [across, down] = if members.len() == 1 { [1, 1] } else { sampling[*member] };
                for block in 0..across * down {
                    let [x, y] = [mcu % mcus[0] * across + block % across, mcu / mcus[0] * down + block / across];
                    let level = ((37 * x + 101 * y + 53 * member) % 180) as i32 - 90;
                    data.block(level - last[*member]);
                    last[*member] = level;
                }
            }
        }
        data.restart(0);
        file.extend(&data.bytes[..data.bytes.len() - 2]);
    }
    file.extend([0xff, 0xd9]);
    file
}

fn read(file: &[u8]) -> Result<Picture, CodecError> {
    decode(Cursor::new(file), None, Budget(1 << 30))
}

const SAMPLINGS: [[[usize; 2]; 3]; 9] = [
    [[1, 1], [1, 1], [1, 1]],
    [[2, 1], [1, 1], [1, 1]],
    [[1, 2], [1, 1], [1, 1]],
    [[2, 2], [1, 1], [1, 1]],
    [[4, 1], [1, 1], [1, 1]],
    [[4, 1], [2, 1], [1, 1]],
    [[1, 4], [1, 2], [1, 1]],
    [[1, 1], [2, 2], [1, 1]],
    [[3, 1], [1, 1], [1, 1]],
];

/// Libjpeg's decoder finds no difference, either.
#[test]
fn the_arrangement_of_scans_changes_no_pixel() {
    for sampling in SAMPLINGS {
        for size in [[1, 1], [9, 17], [33, 16], [41, 35]] {
            let whole = read(&file(size, &sampling, &[&[0, 1, 2]], 0)).unwrap();
            let arrangements: [&[&[usize]]; 5] =
                [&[&[0], &[1], &[2]], &[&[2], &[0], &[1]], &[&[0], &[1, 2]], &[&[0, 1], &[2]], &[&[1, 2], &[0]]];
            for scans in arrangements {
                for restart in [0, 1, 3] {
                    let found = read(&file(size, &sampling, scans, restart)).unwrap();
                    assert!(found == whole, "{size:?}, {sampling:?}, {scans:?}, {restart}");
                }
            }
        }
    }
    let gray = read(&file([20, 9], &[[3, 2]], &[&[0]], 2)).unwrap();
    // The third block: 8 * -16 / 8 below 128, whatever the sampling of a single component.
    let code = 255.0 * afterimage_base::color::Transfer::Srgb.to_signal(gray.pixel(17, 3)[0].into());
    assert!((code - 112.0).abs() < 0.5, "{code}");
}

/// A progressive gray file of a row of blocks, each with one coefficient of -1, 0 or 1 besides its level. Blocks that
/// end are counted together or one by one.
fn progressive(blocks: &[i32], in_runs: bool) -> Vec<u8> {
    let width = (8 * blocks.len() as u16).to_be_bytes();
    // Codes of four bits: the ends of one block, of up to 3 and of up to 7, and a coefficient of one bit.
    let ends = [&[0x10, 0, 0, 0, 4][..], &[0; 12], &[0x00, 0x10, 0x20, 0x01]].concat();
    let mut file = vec![0xff, 0xd8];
    file.extend(segment(0xdb, &[&[0][..], &[8; 64]].concat()));
    file.extend(segment(0xc4, &[&[0, 1][..], &[0; 15], &[0]].concat()));
    file.extend(segment(0xc4, &ends));
    file.extend(segment(0xc2, &[8, 0, 8, width[0], width[1], 1, 1, 0x11, 0]));
    let mut scan = |band: [u8; 2], mut data: Data| {
        file.extend(segment(0xda, &[1, 1, 0, band[0], band[1], 0]));
        data.restart(0);
        file.extend(&data.bytes[..data.bytes.len() - 2]);
    };
    let (mut levels, mut others) = (Data::default(), Data::default());
    blocks.iter().for_each(|_| levels.put(0, 1));
    scan([0, 0], levels);
    let mut at = 0;
    while at < blocks.len() {
        if blocks[at] != 0 {
            others.put(3, 4);
            others.put(u32::from(blocks[at] > 0), 1);
        }
        let empty = blocks[at + 1..].iter().take_while(|coefficient| **coefficient == 0).count();
        let ended = if in_runs { 1 + empty.min(6) as u32 } else { 1 };
        let size = ended.ilog2();
        others.put(size, 4);
        others.put(ended - (1 << size), size);
        at += ended as usize;
    }
    scan([1, 63], others);
    file.extend([0xff, 0xd9]);
    file
}

/// Section G.1.2.2 of ITU-T T.81.
#[test]
fn empty_blocks_may_be_counted_together() {
    for blocks in [&[1, 0, -1, 0, 0, 1, 1, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0, 0, 1][..], &[0, 0, 1], &[0, 1, 0]] {
        let [together, alone] = [true, false].map(|in_runs| read(&progressive(blocks, in_runs)).unwrap());
        assert!(together == alone, "{blocks:?}");
        let rises = |block: u32| alone.pixel(8 * block, 0)[0] - alone.pixel(8 * block + 7, 0)[0];
        for (block, coefficient) in (0..).zip(blocks) {
            let found = rises(block);
            assert!(found * *coefficient as f32 > 0.0 || (found == 0.0 && *coefficient == 0), "{block}: {found}");
        }
    }
}

#[test]
fn a_jpeg_of_another_process_is_not_supported_and_one_with_less_data_is_damaged() {
    let good = file([20, 9], &SAMPLINGS[3], &[&[0, 1, 2]], 0);
    let frame = good.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    let with = |at: usize, byte: u8| {
        let mut file = good.clone();
        file[at] = byte;
        read(&file).unwrap_err()
    };
    for (marker, what) in [
        (0xc3, "the lossless process"),
        (0xc5, "the hierarchical process"),
        (0xc9, "arithmetic coding"),
        (0xca, "arithmetic coding"),
        (0xde, "the hierarchical process"),
        (0xf7, "JPEG-LS"),
        (0xdc, "a height after the first scan (DNL)"),
    ] {
        let error = with(frame + 1, marker);
        assert_eq!(error.message, format!("a JPEG with {what} is not supported"));
        assert_eq!(error.kind, ErrorKind::Unsupported);
    }
    assert_eq!(with(frame + 4, 12).message, "a JPEG with 12 bits for each number is not supported");
    assert_eq!(with(frame + 6, 0).message, "a JPEG with a height after the first scan (DNL) is not supported");
    let uneven = read(&file([20, 9], &[[3, 1], [2, 1], [1, 1]], &[&[0, 1, 2]], 0)).unwrap_err();
    assert_eq!(uneven.message, "a JPEG with samples of one and a half pixels is not supported");
    // Data that end before the last block, with and without an end of the file.
    let short = [&good[..good.len() - 6], &[0xff, 0xd9]].concat();
    assert_eq!(read(&short).unwrap_err().message, "the file is damaged: the data of a scan end early");
    let missing = read(&file([20, 9], &SAMPLINGS[3], &[&[0], &[1]], 0)).unwrap_err();
    assert_eq!(missing.message, "the file is damaged: no scan has its component 3");
    for length in 3..good.len() {
        assert_eq!(read(&good[..length]).unwrap_err().kind, ErrorKind::Broken, "{length}");
    }
}

#[test]
fn a_gain_map_that_is_left_out_is_noted() {
    let good = file([8, 8], &SAMPLINGS[0], &[&[0, 1, 2]], 0);
    let note = "its gain map is not applied: the picture is the one for SDR displays";
    let table: [(u8, &[u8], &str); 3] = [
        (0xe1, b"http://ns.adobe.com/xap/1.0/\0<x xmlns:hdrgm=\"http://ns.adobe.com/hdr-gain-map/1.0/\"/>", note),
        (0xe2, b"urn:iso:std:iso:ts:21496:-1\0\0\0\0\0", note),
        (0xe2, b"MPF\0II*\0", "it has more than one image; only the first is read"),
    ];
    assert!(read(&good).unwrap().notes.is_empty());
    for (marker, body, note) in table {
        let file = [&good[..2], &segment(marker, body), &good[2..]].concat();
        assert_eq!(read(&file).unwrap().notes, [note]);
    }
}
