//! What the program makes of an image.

use afterimage::host::{ImageDesc, Size, Texels, download, upload};
use afterimage::{Frame, FrameKind, Gpu, Opening, Post};
use bevy::math::URect;
use bevy::prelude::*;

use crate::shown::{Folder, SIZE, pipelines};

/// Shows the light that a camera has.
pub(crate) const PASS: &str = r#"Pipeline(inputs: { "scene": Color },
    nodes: { "out": Exposure(source: "scene", stops: 0.0) }, outputs: { "out": "out" })"#;

/// A folder with a pipeline that shows the light as it is.
pub(crate) fn pass(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("pass.ron", PASS);
    folder
}

/// A part of an image of half floats.
pub(crate) fn texels(bytes: &[u8], part: URect) -> Texels {
    let desc = ImageDesc::new(Size::new(part.width(), part.height()));
    Texels { desc, bytes: cut(bytes, 8, part) }
}

/// The bytes of a part of an image of [`SIZE`].
pub(crate) fn cut(bytes: &[u8], texel: usize, part: URect) -> Vec<u8> {
    let [left, right] = [part.min.x, part.max.x].map(|x| x as usize * texel);
    let rows = bytes.chunks_exact(SIZE.x as usize * texel).take(part.max.y as usize).skip(part.min.y as usize);
    rows.flat_map(|row| &row[left..right]).copied().collect()
}

/// What a pipeline of the repository makes of an image, in its first frame.
pub(crate) fn rendered(pipeline: &str, scene: &Texels) -> Vec<u8> {
    let gpu = Gpu::open(&Opening::default()).unwrap_or_else(|error| panic!("{error}"));
    let image = upload(&gpu.device, &gpu.queue, scene).unwrap_or_else(|error| panic!("{error}"));
    let view = image.create_view(&default());
    let mut post = Post::open(&gpu, &pipelines().join(pipeline)).unwrap_or_else(|error| panic!("{error}"));
    let mut encoder = gpu.device.create_command_encoder(&default());
    let frame = Frame { inputs: &[("scene", &view)], kind: FrameKind::Cut, ..default() };
    post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
    gpu.queue.submit([encoder.finish()]);
    download(&gpu.device, &gpu.queue, post.output("display").unwrap()).unwrap_or_else(|error| panic!("{error}")).bytes
}

/// How many bytes differ, and by how much at most.
pub(crate) fn differing(left: &[u8], right: &[u8]) -> (usize, u8) {
    assert_eq!(left.len(), right.len());
    let pairs = || left.iter().zip(right).map(|(left, right)| left.abs_diff(*right));
    (pairs().filter(|off| *off > 0).count(), pairs().max().unwrap_or(0))
}

/// A half float. Numbers below 2^-14 count as 0.
pub(crate) fn half(bits: u16) -> f32 {
    let (sign, rest) = (u32::from(bits >> 15), u32::from(bits & 0x7fff));
    let number = if rest < 0x400 { 0.0 } else { f32::from_bits((rest << 13) + (112 << 23)) };
    f32::from_bits(number.to_bits() | sign << 31)
}
