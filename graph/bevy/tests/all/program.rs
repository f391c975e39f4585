//! What the program makes of an image.

use afterimage_gpu::{FrameStep, Gpu, InputImage, Opening, Session, Texels, upload};
use afterimage_graph::check::{CheckOptions, Facts, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use bevy::math::URect;
use bevy::prelude::*;

use crate::shown::{Folder, SIZE, pipelines};

/// Shows the light that a camera has.
pub(crate) const PASS: &str = r#"Pipeline(inputs: { "scene": Color },
    nodes: { "out": Exposure(source: "scene", stops: 0.0) }, outputs: { "out": "out" })"#;

struct OfRepository;

impl Loader for OfRepository {
    fn load(&self, path: &str) -> Result<std::sync::Arc<[u8]>, String> {
        std::fs::read(pipelines().join(path)).map(Into::into).map_err(|error| error.to_string())
    }
}

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
    let text = std::fs::read_to_string(pipelines().join(pipeline)).expect("it is in the repository");
    let kinds = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let document = parse(pipeline, &text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &OfRepository };
    let (graph, _) = check(&document, &kinds, &options).unwrap_or_else(|errors| panic!("{errors}"));
    let gpu = Gpu::open(&Opening::default()).unwrap_or_else(|error| panic!("{error}"));
    let view = upload(&gpu.device, &gpu.queue, scene).unwrap_or_else(|error| panic!("{error}"));
    let input =
        InputImage { input: "scene".into(), view: view.create_view(&default()), desc: scene.desc, finite: false };
    let mut session = Session::new(&gpu, graph, Facts::default(), default());
    session.render(scene.desc.size, &[input], FrameStep::FIRST).unwrap_or_else(|error| panic!("{error}"));
    session.output("display").unwrap_or_else(|error| panic!("{error}")).bytes
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
