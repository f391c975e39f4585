//! Raw frames with their times as a stream in Matroska (RFC 9559), which `ffmpeg` reads from a pipe.

use std::io::{self, Write};

const EBML: u32 = 0x1a45_dfa3;
const SEGMENT: u32 = 0x1853_8067;
const INFO: u32 = 0x1549_a966;
const TRACKS: u32 = 0x1654_ae6b;
const CLUSTER: u32 = 0x1f43_b675;

/// Writes the headers of a stream of frames in nanoseconds; `code` names the layout of a frame, and `usual` is the
/// usual distance of two, without which few frames have no time code.
pub(super) fn begin(to: &mut impl Write, (width, height): (u32, u32), code: [u8; 4], usual: u64) -> io::Result<()> {
    let mut video = Vec::new();
    element(&mut video, 0xb0, &width.to_be_bytes());
    element(&mut video, 0xba, &height.to_be_bytes());
    element(&mut video, 0x2e_b524, &code);
    let mut entry = Vec::new();
    element(&mut entry, 0xd7, &[1]);
    element(&mut entry, 0x73c5, &[1]);
    element(&mut entry, 0x83, &[1]);
    element(&mut entry, 0x86, b"V_UNCOMPRESSED");
    element(&mut entry, 0x23_e383, &usual.to_be_bytes());
    element(&mut entry, 0xe0, &video);
    let mut tracks = Vec::new();
    element(&mut tracks, 0xae, &entry);
    let mut info = Vec::new();
    element(&mut info, 0x2a_d7b1, &[1]);
    let mut header = Vec::new();
    for (id, value) in [
        (0x4286, &[1][..]),
        (0x42f7, &[1]),
        (0x42f2, &[4]),
        (0x42f3, &[8]),
        (0x4282, b"matroska"),
        (0x4287, &[4]),
        (0x4285, &[2]),
    ] {
        element(&mut header, id, value);
    }
    let mut start = Vec::new();
    element(&mut start, EBML, &header);
    start.extend(SEGMENT.to_be_bytes());
    // Of unknown length.
    start.extend([0x01, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]);
    element(&mut start, INFO, &info);
    element(&mut start, TRACKS, &tracks);
    to.write_all(&start)
}

/// Writes a frame: a cluster of one block.
pub(super) fn frame(to: &mut impl Write, nanoseconds: u64, frame: &[u8]) -> io::Result<()> {
    // Track 1, at the time of the cluster, a key frame.
    const BLOCK: [u8; 4] = [0x81, 0, 0, 0x80];
    let mut time = Vec::new();
    element(&mut time, 0xe7, &nanoseconds.to_be_bytes());
    let block = BLOCK.len() + frame.len();
    let mut start = CLUSTER.to_be_bytes().to_vec();
    length(&mut start, time.len() + 9 + block);
    start.extend(time);
    start.push(0xa3);
    length(&mut start, block);
    start.extend(BLOCK);
    to.write_all(&start)?;
    to.write_all(frame)
}

fn element(to: &mut Vec<u8>, id: u32, value: &[u8]) {
    let bytes = id.to_be_bytes();
    let unused = bytes.iter().take_while(|byte| **byte == 0).count();
    to.extend(&bytes[unused..]);
    length(to, value.len());
    to.extend(value);
}

/// A length in eight bytes.
fn length(to: &mut Vec<u8>, length: usize) {
    to.extend((length as u64 | 1 << 56).to_be_bytes());
}
