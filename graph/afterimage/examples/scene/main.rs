//! Geometry that a plan draws: a scene with a shadow map, four samples, colored glass and bloom of what emits light,
//! and solids with an image whose mip levels are drawn one by one.
//!
//! `cargo run --release -p afterimage --example scene` writes `scene.png` and `solids.png` into the folder where it
//! is run, or into the one that is named, and prints the plans.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

mod geometry;
mod kinds;

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use afterimage::Post;
use afterimage_gpu::{Frame, Gpu, Opening, download, wgpu};
use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{BlockData, Camera, Registry};

use geometry::{look_at, perspective};

/// Recipes of a renderer: a shadow map, samples, selective bloom by the emission of vertices, a curve.
const SCENE: &str = r#"Pipeline(
    inputs: { "camera": Camera, "light": Camera },
    nodes: {
        "shadows": SceneDepth(light: "light"),
        "samples": SceneLight(camera: "camera", light: "light", shadows: "shadows"),
        "scene": Resolve(source: "samples", gain: 1.0),
        "exposed": Exposure(source: "scene", stops: 0.0),
        "glowing": Extract(source: "exposed", method: Emissive, threshold: 0.0),
        "mips": Downsample(source: "glowing", levels: 5, filter: Tap13),
        "bloom": Upsample(source: "mips", blend: Add, filter: Tent),
        "lit": Composite(base: "exposed", bloom: "bloom", blend: Add, strength: 0.06),
        "mapped": ToneMap(source: "lit", curve: KhronosNeutral),
        "encoded": Encode(source: "mapped", transfer: Srgb),
        "display": Dither(source: "encoded", bits: 8, format: Rgba8Unorm),
    },
    outputs: { "display": "display" },
)"#;

const SOLIDS: &str = r#"Pipeline(
    inputs: {},
    nodes: {
        "samples": MipSolids(),
        "scene": Resolve(source: "samples", gain: 0.0),
        "exposed": Exposure(source: "scene", stops: 0.0),
        "mapped": ToneMap(source: "exposed", curve: KhronosNeutral),
        "encoded": Encode(source: "mapped", transfer: Srgb),
        "display": Dither(source: "encoded", bits: 8, format: Rgba8Unorm),
    },
    outputs: { "display": "display" },
)"#;

const SIZE: Size = Size { width: 1280, height: 720, depth: 1 };

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let gpu = Gpu::open(&Opening::default())?;
    let aspect = SIZE.width as f32 / SIZE.height as f32;
    let camera = Camera::still(look_at([4.6, 3.6, 7.0], [0.1, 0.9, -0.4]), perspective(40.0, aspect, 0.1, 100.0));
    let light = Camera::still(look_at([-6.0, 8.5, 5.0], [0.0, 0.3, 0.0]), perspective(60.0, 1.0, 4.0, 30.0));
    let (camera, light) = (camera.data()?, light.data()?);
    let folder = Path::new(&folder);
    draw(&gpu, ("scene.ron", SCENE), &[("camera", &camera), ("light", &light)], &folder.join("scene.png"))?;
    draw(&gpu, ("solids.ron", SOLIDS), &[], &folder.join("solids.png"))
}

/// Draws a frame of a pipeline into a file.
fn draw(
    gpu: &Gpu,
    (name, text): (&str, &str),
    blocks: &[(&str, &BlockData)],
    file: &Path,
) -> Result<(), Box<dyn Error>> {
    let kinds = Registry::new(&[afterimage_nodes::ALL, kinds::ALL])?;
    let (graph, _warnings) = check(&parse(name, text)?, &kinds, &CheckOptions::default())?;
    let mut post = Post::with_executor(gpu.executor(), graph);
    post.set_size(Some(SIZE));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    post.encode(&mut encoder, &Frame { blocks, ..Frame::default() })?;
    gpu.queue.submit([encoder.finish()]);
    if let Some(plan) = post.plan() {
        println!("{}", plan.to_text());
    }
    save(gpu, post.output("display")?, file)
}

fn save(gpu: &Gpu, texture: &wgpu::Texture, file: &Path) -> Result<(), Box<dyn Error>> {
    let texels = download(&gpu.device, &gpu.queue, texture)?;
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(file)?), SIZE.width, SIZE.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&texels.bytes)?;
    Ok(())
}
