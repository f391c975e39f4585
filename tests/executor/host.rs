//! The host's own textures, and the errors that report those that do not fit.

use afterimage_gpu::{Frame, Gpu, GpuError, Opening, Readback, download};
use afterimage_graph::check::Graph;
use afterimage_graph::node::{ImageId, Pass, Resource};
use wgpu::{TextureFormat, TextureUsages};

use super::{at_tier, bits, flat, lively};
use crate::support::gpu::{Picture, Run, built_in, changed, texture_bytes};
use crate::support::player::Player;

const LYNX: &str = "lynx.ron";

/// A texture of the host, and its view.
fn texture(player: &Player, size: (u32, u32), format: TextureFormat, usage: TextureUsages) -> wgpu::TextureView {
    let plain = described(size, format, usage);
    player.gpu.device.create_texture(&plain).create_view(&Default::default())
}

fn described(
    (width, height): (u32, u32),
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | TextureUsages::COPY_SRC,
        view_formats: &[],
    }
}

/// A player with the pipeline loaded, its input, and what it shows in a texture of its own.
fn reference(scene: &Picture) -> (Player, wgpu::TextureView, Picture) {
    reference_of(&built_in(LYNX, None), scene)
}

fn reference_of(graph: &Graph, scene: &Picture) -> (Player, wgpu::TextureView, Picture) {
    let mut player = Player::new();
    player.load(&Run::new(graph), &[("scene", scene)]);
    let input = player.upload(scene);
    player.run(&Frame { inputs: &[("scene", &input)], ..Frame::default() }).expect("the scene renders");
    let picture = player.output("display");
    (player, input, picture)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_output_goes_to_the_host_s_own_texture() {
    let (mut player, input, wanted) = reference(&lively(64, 36));
    let planned = player.executor.output("display").expect("it is an output").format();
    for usage in [TextureUsages::STORAGE_BINDING, TextureUsages::RENDER_ATTACHMENT] {
        let view = texture(&player, (64, 36), planned, usage);
        let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", &view)], ..Frame::default() };
        player.run(&frame).expect("the host's texture fits");
        let found = player.read(view.texture());
        let off = found.pixels.as_flattened().iter().zip(wanted.pixels.as_flattened());
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // Drawn and dispatched kernels may round differently, by a code where the dither tips over.
        assert!(off <= 1.01 / 255.0, "{usage:?}: {off}");
        if usage == TextureUsages::STORAGE_BINDING {
            assert_eq!(bits(&found), bits(&wanted));
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_surface_s_format_is_drawn_to() {
    let (mut player, input, wanted) = reference(&lively(64, 36));
    let view = texture(&player, (64, 36), TextureFormat::Bgra8Unorm, TextureUsages::RENDER_ATTACHMENT);
    let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", &view)], ..Frame::default() };
    player.run(&frame).expect("the host's texture can be drawn to");
    let texels = texture_bytes(&player.gpu, view.texture(), 4);
    for (texel, pixel) in texels.chunks_exact(4).zip(&wanted.pixels) {
        let swapped = [texel[2], texel[1], texel[0]];
        for (code, value) in swapped.into_iter().zip(pixel) {
            assert!((f32::from(code) - 255.0 * value).abs() <= 1.01, "{texel:?} {pixel:?}");
        }
    }
}

/// The value of a number in a texture that encodes by itself.
fn encoded(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_image_is_not_encoded_twice() {
    let (mut player, input, _) = reference(&lively(64, 36));
    let view = texture(&player, (64, 36), TextureFormat::Bgra8UnormSrgb, TextureUsages::RENDER_ATTACHMENT);
    let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", &view)], ..Frame::default() };
    let error = error_of(player.run(&frame));
    assert!(error.contains("encoded the image already") && error.contains("`display`"), "{error}");
}

/// Renderers keep a swap chain in one format and draw to it in another.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_view_with_another_encoding_than_its_texture_is_drawn_to() {
    let (plain, encodes) = (TextureFormat::Bgra8Unorm, TextureFormat::Bgra8UnormSrgb);
    for (of_texture, of_view) in [(plain, encodes), (encodes, plain)] {
        let transfer = if of_view == encodes { "Linear" } else { "Srgb" };
        let linear = changed(LYNX, None, &[("encoded.transfer", transfer)]);
        let (mut player, input, wanted) = reference_of(&linear, &lively(64, 36));
        let described = described((64, 36), of_texture, TextureUsages::RENDER_ATTACHMENT);
        let view_formats = &[of_view];
        let texture = player.gpu.device.create_texture(&wgpu::TextureDescriptor { view_formats, ..described });
        let view = texture.create_view(&wgpu::TextureViewDescriptor { format: Some(of_view), ..Default::default() });
        let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", &view)], ..Frame::default() };
        player.run(&frame).expect("the host's view can be drawn to");
        for (texel, pixel) in texture_bytes(&player.gpu, &texture, 4).chunks_exact(4).zip(&wanted.pixels) {
            let value = if of_view == encodes { encoded(pixel[0]) } else { pixel[0] };
            // The encoding is steep in the dark, where a code more in its argument is many in its value.
            let off = if of_view == encodes { 13.0 } else { 1.01 };
            assert!((f32::from(texel[2]) - 255.0 * value).abs() <= off, "{of_view:?}: {texel:?} {pixel:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_a_device_would_refuse_is_an_error() {
    let (mut player, input, wanted) = reference(&lively(64, 36));
    let (drawn, read) = (TextureUsages::RENDER_ATTACHMENT, TextureUsages::TEXTURE_BINDING);
    let screen = |usage| described((64, 36), TextureFormat::Bgra8Unorm, usage);
    let make = |described: &wgpu::TextureDescriptor<'_>| {
        player.gpu.device.create_texture(described).create_view(&Default::default())
    };
    let layers = wgpu::Extent3d { depth_or_array_layers: 2, ..screen(drawn).size };
    let many_samples = wgpu::TextureDescriptor { sample_count: 4, usage: drawn, ..screen(drawn) };
    let outputs = [
        (make(&screen(read)), "lacks the usage `RENDER_ATTACHMENT`"),
        (make(&many_samples), "it has 4 samples in each pixel, and outputs have one"),
        (make(&wgpu::TextureDescriptor { mip_level_count: 3, ..screen(drawn) }), "its texture has 3 levels"),
        (make(&described((64, 36), TextureFormat::R32Uint, drawn)), "the device refused"),
        (make(&described((64, 36), TextureFormat::Depth32Float, drawn)), "is Depth32Float, but"),
    ];
    let floats = |usage| described((64, 36), TextureFormat::Rgba32Float, usage);
    let inputs = [
        (make(&floats(drawn)), "`scene` cannot be used: its texture lacks the usage `TEXTURE_BINDING`"),
        (make(&wgpu::TextureDescriptor { size: layers, ..floats(read) }), "the device refused the images of the host"),
    ];
    let both = make(&floats(drawn | read));
    for (view, words) in &outputs {
        let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", view)], ..Frame::default() };
        let message = error_of(player.run(&frame));
        assert!(message.contains(words), "{message}");
    }
    for (view, words) in &inputs {
        let message = error_of(player.run(&Frame { inputs: &[("scene", view)], ..Frame::default() }));
        assert!(message.contains(words), "{message}");
    }
    let message = error_of(player.run(&Frame {
        inputs: &[("scene", &both)],
        outputs: &[("display", &both)],
        ..Frame::default()
    }));
    assert!(message.contains("`display` cannot be used: it is the image of input `scene`, which `"), "{message}");
    let misspelt = Frame { inputs: &[("scene", &input)], outputs: &[("dispaly", &outputs[0].0)], ..Frame::default() };
    assert_eq!(error_of(player.run(&misspelt)), "the plan has no output `dispaly`; it has `display`");
    player.run(&Frame { inputs: &[("scene", &input)], ..Frame::default() }).expect("the right images still work");
    assert_eq!(bits(&player.output("display")), bits(&wanted));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn any_number_of_host_textures_may_alternate() {
    let (mut player, input, wanted) = reference(&lively(64, 36));
    let format = player.executor.output("display").expect("it is an output").format();
    let textures =
        |player: &Player, usage| (0..20).map(|_| texture(player, (64, 36), format, usage)).collect::<Vec<_>>();
    let show = |player: &mut Player, view: &wgpu::TextureView| {
        let frame = Frame { inputs: &[("scene", &input)], outputs: &[("display", view)], ..Frame::default() };
        player.run(&frame).expect("the host's texture fits");
        bits(&player.read(view.texture()))
    };
    let drawn = textures(&player, TextureUsages::RENDER_ATTACHMENT);
    let first = show(&mut player, &drawn[0]);
    for view in drawn.iter().chain(&drawn) {
        assert_eq!(show(&mut player, view), first);
    }
    let views = textures(&player, TextureUsages::STORAGE_BINDING);
    for view in views.iter().chain(&views) {
        assert_eq!(show(&mut player, view), bits(&wanted));
    }
    // Another input, after many frames with the first.
    let dark = player.upload(&flat(64, 36, 0.0));
    let frame = Frame { inputs: &[("scene", &dark)], outputs: &[("display", &views[0])], ..Frame::default() };
    player.run(&frame).expect("the host's texture fits");
    assert!(player.read(views[0].texture()).pixels.iter().all(|pixel| pixel[..3] == [0.0; 3]));
}

/// A swap chain has new views in every frame: only the passes that name them get new bind groups.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn new_views_renew_only_the_passes_that_name_them() {
    let (scene, graph) = (lively(64, 36), built_in("tsushima.ron", None));
    let mut player = Player::new();
    let plan = player.load(&Run::new(&graph), &[("scene", &scene)]);
    let input = player.upload(&scene).texture().clone();
    player.run(&Frame { inputs: &[("scene", &input.create_view(&Default::default()))], ..Frame::default() }).unwrap();
    let format = player.executor.output("display").expect("it is an output").format();
    let naming = |ids: &[ImageId]| {
        let names = |pass: &&Pass| pass.resources().filter_map(Resource::image).any(|image| ids.contains(&image));
        plan.work().filter(names).count()
    };
    let (of_input, of_output) = (plan.inputs[0].1, plan.outputs[0].image);
    let (shown, all) = (naming(&[of_output]), naming(&[of_input, of_output]));
    assert!(shown == 1 && all > shown && all <= plan.passes.len() / 2, "{shown}, {all} of {}", plan.passes.len());
    let stored = (TextureUsages::STORAGE_BINDING, [0, shown, all]);
    // An attachment is in no bind group.
    let drawn = (TextureUsages::RENDER_ATTACHMENT, [0, 0, naming(&[of_input])]);
    for (usage, wanted) in [stored, drawn] {
        let output = texture(&player, (64, 36), format, usage).texture().clone();
        let mut views = [&input, &output].map(|texture| texture.create_view(&Default::default()));
        let mut bound = |renewed: [bool; 2]| {
            for (view, _) in views.iter_mut().zip(renewed).filter(|(_, renewed)| *renewed) {
                *view = view.texture().create_view(&Default::default());
            }
            let (inputs, outputs) = (&[("scene", &views[0])], &[("display", &views[1])]);
            player.run(&Frame { inputs, outputs, dt: 0.1, ..Frame::default() }).expect("the images fit");
            player.executor.passes_bound()
        };
        bound([true, true]);
        for _ in 0..20 {
            assert_eq!([[false, false], [false, true], [true, true]].map(&mut bound), wanted, "{usage:?}");
        }
    }
}

fn error_of(result: Result<(), GpuError>) -> String {
    result.expect_err("it does not fit").to_string()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_that_do_not_fit_are_errors_and_change_nothing() {
    let (mut player, input, wanted) = reference(&lively(64, 36));
    let small = player.upload(&flat(32, 36, 1.0));
    let halves = texture(&player, (64, 36), TextureFormat::Rgba16Float, TextureUsages::TEXTURE_BINDING);
    let narrow = texture(&player, (64, 35), TextureFormat::Rgba16Float, TextureUsages::STORAGE_BINDING);
    let none = Frame::default();
    assert_eq!(error_of(player.run(&none)), "no image was given for input `scene`");
    let wrong = error_of(player.run(&Frame { inputs: &[("scene", &small)], ..none }));
    assert_eq!(wrong, "the image given for `scene` is 32x36, but the plan was made for 64x36");
    let wrong = error_of(player.run(&Frame { inputs: &[("scene", &halves)], ..none }));
    assert_eq!(wrong, "the image given for `scene` is Rgba16Float, but the plan was made for Rgba32Float");
    let wrong = error_of(player.run(&Frame { inputs: &[("scene", &input)], outputs: &[("display", &narrow)], ..none }));
    assert!(wrong.starts_with("the image given for `display` is 64x35, but"), "{wrong}");
    player.run(&Frame { inputs: &[("scene", &input)], ..none }).expect("the right input still works");
    assert_eq!(bits(&player.output("display")), bits(&wanted));
    player.renew();
    assert_eq!(error_of(player.run(&none)), "no plan is loaded");
}

/// A whole kernel stores its result and cannot draw it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_texture_that_no_pass_can_write_is_an_error() {
    let text = r#"Pipeline(
        inputs: { "scene": Exposed },
        nodes: { "around": LogGaussian(source: "scene", width: 64, height: 32) },
        outputs: { "around": "around" },
    )"#;
    let graph = at_tier(text, None);
    let mut player = Player::new();
    let scene = lively(64, 36);
    player.load(&Run::new(&graph), &[("scene", &scene)]);
    let input = player.upload(&scene);
    let view = texture(&player, (64, 32), TextureFormat::Bgra8Unorm, TextureUsages::RENDER_ATTACHMENT);
    let frame = Frame { inputs: &[("scene", &input)], outputs: &[("around", &view)], ..Frame::default() };
    let wrong = error_of(player.run(&frame));
    assert!(
        wrong.starts_with("the image given for `around` is Bgra8Unorm, but the plan was made for Rgba16Float"),
        "{wrong}"
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_adapter_that_is_not_there_is_reported_with_those_that_are() {
    let opening = Opening { adapter: Some("voodoo 2".into()), ..Opening::default() };
    let Err(error) = Gpu::open(&opening) else { panic!("there is no such adapter") };
    let name = crate::support::gpu::gpu().name();
    let text = error.to_string();
    assert!(text.starts_with("no graphics adapter called `voodoo 2`: there are "), "{text}");
    assert!(text.contains(&name), "{text} does not name {name}");
}

/// As outputs are that are larger than a buffer of the device may be.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_texture_is_read_back_in_pieces() {
    let player = Player::new();
    let (device, queue) = (&player.gpu.device, &player.gpu.queue);
    let view = player.upload(&lively(37, 23));
    let whole = download(device, queue, view.texture()).expect("a texture can be read");
    // A row is padded to 768 bytes.
    for piece in [1, 768, 2 * 768, 5 * 768 - 1, 22 * 768, 23 * 768] {
        let mut readback = Readback::new(device, queue).in_pieces_of(piece);
        for _ in 0..2 {
            let read = readback.download(view.texture()).expect("a texture can be read");
            assert!(read == whole, "pieces of {piece} bytes");
        }
    }
}
