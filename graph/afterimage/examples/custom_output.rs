//! An output in a texture of the host, in a format that the pipeline does not mention.
//!
//! `cargo run -p afterimage --example custom_output` renders into a `Bgra8Unorm` texture, as windows have them,
//! reads it back and prints a row of codes.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;

use afterimage::host::{Size, Texels, upload};
use afterimage::{Frame, FrameKind, Gpu, Opening, Post, Source, wgpu};

const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 0.0),
        "mapped": ToneMap(source: "exposed", curve: AcesNarkowicz),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display" },
)"#;

/// A row of 64 pixels of four bytes has the 256 bytes that copies to buffers require.
const SIZE: Size = Size { width: 64, height: 4, depth: 1 };

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::open(&Opening::default())?;
    let (device, queue) = (&gpu.device, &gpu.queue);

    let ramp: Vec<[f32; 4]> = (0..SIZE.width * SIZE.height).map(|index| [(index % 64) as f32 / 16.0; 4]).collect();
    let texels = Texels::from_floats_as_half(SIZE.width, SIZE.height, &ramp);
    let scene = upload(device, queue, &texels)?.create_view(&Default::default());

    // The last pass draws into the texture, because no shader can store to this format.
    let screen = screen(device);
    let screen_view = screen.create_view(&Default::default());
    let mut post = Post::open(&gpu, Source::text("custom_output.ron", PIPELINE))?;
    let mut encoder = device.create_command_encoder(&Default::default());
    let (inputs, outputs) = (&[("scene", &scene)], &[("display", &screen_view)]);
    post.encode(&mut encoder, &Frame { inputs, outputs, kind: FrameKind::Cut, ..Frame::default() })?;

    let bytes = read(device, queue, encoder, &screen)?;
    let red: Vec<u8> = bytes[..4 * SIZE.width as usize].chunks(4).map(|pixel| pixel[2]).collect();
    println!("red from black to four times white: {red:?}");
    Ok(())
}

fn screen(device: &wgpu::Device) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("screen"),
        size: wgpu::Extent3d { width: SIZE.width, height: SIZE.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Bgra8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Submits the encoder and reads the bytes of the texture.
fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut encoder: wgpu::CommandEncoder,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: u64::from(4 * SIZE.width * SIZE.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE.width), rows_per_image: None };
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(buffer.slice(..).get_mapped_range()?.to_vec())
}
