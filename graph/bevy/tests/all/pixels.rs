//! What a camera shows is what the program makes of the same image.

use afterimage::wgpu;
use bevy::camera::{ManualTextureViewHandle, RenderTarget};
use bevy::core_pipeline::prepass::DepthPrepass;
use bevy::math::URect;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::{ManualTextureView, ManualTextureViews};
use bevy_afterimage::{Afterimage, Target};

use crate::program::{differing, half, pass, rendered, texels};
use crate::shown::{Folder, SIZE, Shown, pipelines};

const WHOLE: URect = URect { min: UVec2::ZERO, max: SIZE };

#[test]
fn a_camera_shows_what_the_program_makes_of_its_image() {
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let own = pass("pass");
        let mut shown = Shown::with_camera(&own.0, "pass.ron", TextureFormat::Rgba16Float, |look| look);
        set_samples(&mut shown, msaa);
        let scene = texels(&shown.settled(), WHOLE);
        for pipeline in ["lynx.ron", "caracal.ron", "glare.ron"] {
            let wanted = rendered(pipeline, &scene);
            for target in [Target::MainTexture, Target::Output] {
                let to_target = |look: bevy_afterimage::Afterimage| look.target(target);
                let mut shown = Shown::with_camera(&pipelines(), pipeline, TextureFormat::Rgba8UnormSrgb, to_target);
                set_samples(&mut shown, msaa);
                assert_eq!(differing(&shown.settled(), &wanted), (0, 0), "{pipeline}, {target:?}, {msaa:?}");
            }
        }
    }
}

fn set_samples(shown: &mut Shown, samples: Msaa) {
    let world = shown.app.world_mut();
    *world.query::<&mut Msaa>().single_mut(world).expect("there is one camera") = samples;
}

/// A window's texture is of the format without sRGB, and Bevy's view of it of that with it.
#[test]
fn the_view_of_a_swap_chain_is_encoded_once() {
    let own = pass("swap-chain");
    let light = Shown::with_camera(&own.0, "pass.ron", TextureFormat::Rgba16Float, |look| look).settled();
    let wanted = rendered("lynx.ron", &texels(&light, WHOLE));
    for target in [Target::MainTexture, Target::Output] {
        let mut shown = Shown::new(&pipelines(), TextureFormat::Rgba8UnormSrgb);
        let device = shown.app.world().resource::<RenderDevice>().wgpu_device().clone();
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("as of a window"),
            size: Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::Bgra8Unorm,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[TextureFormat::Bgra8UnormSrgb],
        });
        let view_format = TextureFormat::Bgra8UnormSrgb;
        let view = wgpu::TextureViewDescriptor { format: Some(view_format), ..default() };
        let view = ManualTextureView { texture_view: texture.create_view(&view).into(), size: SIZE, view_format };
        let handle = ManualTextureViewHandle(7);
        shown.app.world_mut().resource_mut::<ManualTextureViews>().insert(handle, view);
        shown.target = RenderTarget::TextureView(handle);
        let look = shown.look("lynx.ron").target(target);
        shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
        let mut pictures = std::iter::repeat_with(|| {
            shown.run(5);
            let mut bytes = read(&shown, &texture);
            bytes.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| texel.swap(0, 2));
            differing(&bytes, &wanted)
        });
        let last = pictures.by_ref().take(100).fold((usize::MAX, 0), |best, now| best.min(now));
        assert_eq!(last, (0, 0), "{target:?}");
    }
}

/// The bytes of a texture of [`SIZE`].
fn read(shown: &Shown, texture: &wgpu::Texture) -> Vec<u8> {
    let device = shown.app.world().resource::<RenderDevice>().wgpu_device();
    let queue = shown.app.world().resource::<RenderQueue>();
    let pitch = (SIZE.x * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(pitch * SIZE.y),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(pitch), ..default() };
    let mut encoder = device.create_command_encoder(&default());
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("the device is there"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
    let mapped = buffer.get_mapped_range(..).expect("it is mapped");
    mapped.chunks_exact(pitch as usize).flat_map(|row| &row[..SIZE.x as usize * 4]).copied().collect()
}

/// Depth in Bevy is reversed, with the far plane at an infinite distance.
#[test]
fn prepasses_and_the_camera_arrive() {
    const DISTANCE: &str = r#"Pipeline(inputs: { "scene": Color, "depth": Depth, "camera": Camera },
        nodes: { "far": LinearDepth(depth: "depth", camera: "camera") }, outputs: { "far": "far" })"#;
    let own = Folder::new("depth");
    own.write("depth.ron", DISTANCE);
    let mut shown = Shown::with_camera(&own.0, "depth.ron", TextureFormat::Rgba16Float, |look| look);
    // Without its image the pipeline has an error, which is no panic.
    let status = shown.until("an error", |status| status.frame.is_some());
    assert!(status.frame.as_ref().is_some_and(|error| error.contains("`depth`")), "{status:?}");
    let world = shown.app.world_mut();
    let camera = world.query_filtered::<Entity, With<Afterimage>>().single(world).expect("there is one camera");
    world.entity_mut(camera).insert(DepthPrepass);
    let wall = world.resource_mut::<Assets<Mesh>>().add(Cuboid::new(40.0, 40.0, 1.0));
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    // The front of the wall is 4 m before a camera that looks straight ahead.
    world.spawn((Mesh3d(wall), MeshMaterial3d(material), Transform::from_xyz(0.0, 0.0, 2.5)));
    *world.get_mut::<Transform>(camera).expect("it has a place") = Transform::from_xyz(0.0, 0.0, 7.0);
    shown.once("the distance of the wall", |bytes| {
        let red = |texel: &[u8]| half(u16::from_le_bytes([texel[0], texel[1]]));
        bytes.chunks_exact(8).all(|texel| (red(texel) - 4.0).abs() < 0.01)
    });
    assert_eq!(shown.status().frame, None);
}
