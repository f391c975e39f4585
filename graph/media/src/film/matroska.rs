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

#[cfg(test)]
mod tests {
    use super::*;

    /// The elements in some bytes, by RFC 9559 and RFC 8794: identifier and content. One of unknown length has what
    /// follows.
    fn elements(mut bytes: &[u8]) -> Vec<(u32, &[u8])> {
        let mut found = Vec::new();
        while !bytes.is_empty() {
            let (id, rest) = bytes.split_at(bytes[0].leading_zeros() as usize + 1);
            let id = id.iter().fold(0, |id, byte| id << 8 | u32::from(*byte));
            let (length, rest) = rest.split_at(rest[0].leading_zeros() as usize + 1);
            let bits = 7 * length.len();
            let length = length.iter().fold(0_u64, |all, byte| all << 8 | u64::from(*byte)) & ((1 << bits) - 1);
            let length = if length == (1 << bits) - 1 { rest.len() } else { length as usize };
            found.push((id, &rest[..length]));
            bytes = &rest[length..];
        }
        found
    }

    /// The content of the only element of each of these identifiers, each within the one before.
    fn inside<'a>(bytes: &'a [u8], path: &[u32]) -> &'a [u8] {
        path.iter().fold(bytes, |bytes, id| {
            let mut all = elements(bytes).into_iter().filter(|(found, _)| found == id);
            let content = all.next().unwrap_or_else(|| panic!("there is no {id:x}")).1;
            assert!(all.next().is_none(), "{id:x} is there once");
            content
        })
    }

    fn number(bytes: &[u8]) -> u64 {
        bytes.iter().fold(0, |all, byte| all << 8 | u64::from(*byte))
    }

    #[test]
    fn a_stream_states_its_frames_and_holds_them() {
        let frames = [(0, vec![1, 2, 3]), (41_708_333, vec![4; 300]), (5_000_000_000, vec![])];
        let mut stream = Vec::new();
        begin(&mut stream, (640, 360), *b"Y3\0\x0a", 41_708_333).expect("memory takes all");
        for (time, pixels) in &frames {
            frame(&mut stream, *time, pixels).expect("memory takes all");
        }

        assert_eq!(elements(&stream).len(), 2);
        let header = inside(&stream, &[0x1a45_dfa3]);
        assert_eq!(inside(header, &[0x4282]), b"matroska");
        let lengths = [0x42f2, 0x42f3].map(|most| number(inside(header, &[most])));
        assert_eq!(lengths, [4, 8], "identifiers have four bytes and lengths eight");
        let segment = inside(&stream, &[0x1853_8067]);
        assert_eq!(number(inside(segment, &[0x1549_a966, 0x2a_d7b1])), 1, "times are in nanoseconds");
        let track = inside(segment, &[0x1654_ae6b, 0xae]);
        assert_eq!([0xd7, 0x83, 0x23_e383].map(|id| number(inside(track, &[id]))), [1, 1, 41_708_333]);
        assert_eq!(inside(track, &[0x86]), b"V_UNCOMPRESSED");
        let video = inside(track, &[0xe0]);
        assert_eq!([0xb0, 0xba].map(|side| number(inside(video, &[side]))), [640, 360]);
        assert_eq!(inside(video, &[0x2e_b524]), b"Y3\0\x0a");

        let clusters = elements(segment).into_iter().filter(|(id, _)| *id == 0x1f43_b675);
        let read: Vec<(u64, Vec<u8>)> = clusters
            .map(|(_, cluster)| {
                let (block, pixels) = inside(cluster, &[0xa3]).split_at(4);
                assert_eq!(block, [0x81, 0, 0, 0x80], "a key frame of track 1, at the time of its cluster");
                (number(inside(cluster, &[0xe7])), pixels.to_vec())
            })
            .collect();
        assert_eq!(read, frames);
    }
}
