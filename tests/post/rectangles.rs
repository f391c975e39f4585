//! Rectangles of the host's images and factors of its inputs: viewports, split screen and dynamic resolution.

use std::sync::Arc;

use afterimage_gpu::{Frame, FrameKind, Rectangle, Texels, download, upload, wgpu};
use afterimage_graph::image::Size;
use afterimage_plan::Plan;

use super::{Host, assert_same};
use crate::support::gpu::{Picture, changed, graph, texture_bytes};
use crate::support::sweep;

const SIZE: Size = Size { width: 96, height: 54, depth: 1 };

/// The light at a texel of the scene.
fn light(x: u32, y: u32) -> [f32; 4] {
    let (u, v) = (x as f32 / SIZE.width as f32, y as f32 / SIZE.height as f32);
    [0.1 + 20.0 * u * v, 0.2 + v, 0.3 + (u * 40.0).sin().abs(), 1.0]
}

/// A texture of NaN with that picture from each of these texels on.
fn surrounded(host: &Host, size: Size, part: &Picture, places: &[(u32, u32)]) -> wgpu::TextureView {
    let mut whole = Picture::new(size.width, size.height, |_, _| [f32::NAN; 4]);
    for (left, top) in places {
        for y in 0..part.height {
            for x in 0..part.width {
                whole.pixels[((top + y) * size.width + left + x) as usize] = part.at(x, y);
            }
        }
    }
    view(host, &whole)
}

fn view(host: &Host, picture: &Picture) -> wgpu::TextureView {
    let texels = Texels::from_floats_as_half(picture.width, picture.height, &picture.pixels);
    upload(&host.gpu.device, &host.gpu.queue, &texels).unwrap().create_view(&Default::default())
}

/// A target of 200x120 texels with codes that no picture has, stored to or drawn to.
fn target(host: &Host, usage: wgpu::TextureUsages) -> wgpu::Texture {
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 200, height: 120, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: usage | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let texture = host.gpu.device.create_texture(&descriptor);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(800), rows_per_image: None };
    host.gpu.queue.write_texture(texture.as_image_copy(), &[7; 200 * 120 * 4], layout, texture.size());
    texture
}

/// The rectangle of a target, and whether the rest of it is as it was.
fn taken(host: &Host, texture: &wgpu::Texture, rectangles: &[Rectangle]) -> (Vec<Vec<u8>>, bool) {
    let bytes = texture_bytes(&host.gpu, texture, 4);
    let mut inside = vec![Vec::new(); rectangles.len()];
    let mut is_kept = true;
    for (index, texel) in bytes.as_chunks::<4>().0.iter().enumerate() {
        let (x, y) = (index as u32 % 200, index as u32 / 200);
        let holds = |r: &Rectangle| (r.x..r.x + r.width).contains(&x) && (r.y..r.y + r.height).contains(&y);
        match rectangles.iter().position(holds) {
            Some(rectangle) => inside[rectangle].extend_from_slice(texel),
            None => is_kept &= *texel == [7; 4],
        }
    }
    (inside, is_kept)
}

fn at(x: u32, y: u32) -> Rectangle {
    Rectangle { x, y, width: SIZE.width, height: SIZE.height }
}

fn submit(host: &mut Host, frame: &Frame<'_>) {
    let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
    host.post.executor().count_from(0);
    host.post.encode(&mut encoder, frame).unwrap_or_else(|error| panic!("{error}"));
    host.gpu.queue.submit([encoder.finish()]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn rectangles_move_without_a_plan_and_leave_what_is_around_them() {
    for pipeline in sweep::some(["lynx.ron", "tsushima.ron", "caracal.ron"], 2) {
        let mut host = Host::new(changed(pipeline, None, &[]));
        let picture = Picture::new(SIZE.width, SIZE.height, light);
        host.scene = view(&host, &picture);
        let wanted = host.shown();
        let scene = surrounded(&host, Size::new(240, 150), &picture, &[(17, 9), (120, 80)]);
        for usage in [wgpu::TextureUsages::RENDER_ATTACHMENT, wgpu::TextureUsages::STORAGE_BINDING] {
            let mut plan: Option<Arc<Plan>> = None;
            for (number, (from, to)) in
                [(at(17, 9), at(40, 30)), (at(120, 80), at(40, 30)), (at(120, 80), at(104, 66)), (at(17, 9), at(0, 0))]
                    .into_iter()
                    .enumerate()
            {
                let texture = target(&host, usage);
                let shown = texture.create_view(&Default::default());
                let frame = Frame {
                    inputs: &[("scene", &scene)],
                    outputs: &[("display", &shown)],
                    rectangles: &[("scene", from), ("display", to)],
                    kind: FrameKind::Cut,
                    ..Frame::default()
                };
                submit(&mut host, &frame);
                assert!(plan.is_none_or(|plan| Arc::ptr_eq(&plan, &host.plan())), "no plan is made for frame {number}");
                plan = Some(host.plan());
                let (inside, is_kept) = taken(&host, &texture, &[to]);
                assert!(is_kept, "{pipeline}, {usage:?}, frame {number}: texels around the rectangle have changed");
                assert_same(&inside[0], &wanted);
            }
        }
    }
}

/// New parameters are written in one range, in which rectangles lie too.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn rectangles_stay_where_they_are_while_parameters_change() {
    let picture = Picture::new(SIZE.width, SIZE.height, light);
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let parameters = ["exposed.stops", "lit.strength"].map(|name| host.post.parameter::<f32>(name).unwrap());
    let scene = surrounded(&host, Size::new(240, 150), &picture, &[(17, 9)]);
    let texture = target(&host, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let shown = texture.create_view(&Default::default());
    let rectangles = &[("scene", at(17, 9)), ("display", at(40, 30))];
    for (changes, values) in [("neither", [0.0, 0.15]), ("one", [0.0, 0.4]), ("both", [1.0, 0.2]), ("one", [0.5, 0.2])]
    {
        for (parameter, value) in parameters.iter().zip(values) {
            host.post.set(*parameter, value).unwrap();
        }
        let (inputs, outputs) = (&[("scene", &scene)], &[("display", &shown)]);
        submit(&mut host, &Frame { inputs, outputs, rectangles, kind: FrameKind::Cut, ..Frame::default() });
        let [stops, strength] = values.map(|value| format!("{value:?}"));
        let mut set = Host::new(changed("lynx.ron", None, &[("exposed.stops", &stops), ("lit.strength", &strength)]));
        set.scene = view(&set, &picture);
        let (inside, is_kept) = taken(&host, &texture, &[at(40, 30)]);
        assert!(is_kept, "{changes} of the parameters changes: texels around the rectangle have changed");
        assert_same(&inside[0], &set.shown());
    }
}

/// Rectangles alone need no bind groups, and two views have uniforms of their own.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn two_halves_of_a_screen_are_recorded_into_one_encoder() {
    let mut left = Host::new(changed("lynx.ron", None, &[]));
    let picture = Picture::new(SIZE.width, SIZE.height, light);
    left.scene = view(&left, &picture);
    let wanted = left.shown();
    let mut right =
        Host { post: left.post.clone_for_view(), gpu: left.gpu.clone(), scene: left.scene.clone(), time: 0.0 };
    let scene = surrounded(&left, Size::new(240, 150), &picture, &[(17, 9)]);
    let texture = target(&left, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let shown = texture.create_view(&Default::default());
    for (number, offset) in [0, 5].into_iter().enumerate() {
        let halves = [at(0, offset), at(100, offset)];
        let mut encoder = left.gpu.device.create_command_encoder(&Default::default());
        for (host, half) in [&mut left, &mut right].into_iter().zip(halves) {
            let rectangles: &[_] = &[("scene", at(17, 9)), ("display", half)];
            let (inputs, outputs) = (&[("scene", &scene)], &[("display", &shown)]);
            host.post.executor().count_from(0);
            let frame = Frame { inputs, outputs, rectangles, kind: FrameKind::Cut, ..Frame::default() };
            host.post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
            assert!(number == 0 || host.post.executor().passes_bound() == 0);
        }
        left.gpu.queue.submit([encoder.finish()]);
        let (inside, _) = taken(&left, &texture, &halves);
        assert_same(&inside[0], &wanted);
        assert_same(&inside[1], &wanted);
    }
}

/// A pipeline whose output is its input.
const SAME: &str = r#"Pipeline(inputs: { "scene": Color }, nodes: {}, outputs: { "display": "scene" })"#;

fn pixels(host: &Host) -> Picture {
    Picture::of(&download(&host.gpu.device, &host.gpu.queue, host.post.output("display").unwrap()).unwrap())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_rectangle_of_another_size_is_filtered_to_the_stated_one() {
    let mut host = Host::new(graph(SAME));
    host.post.set_size(Some(SIZE));
    let mut plan = None;
    for (width, height) in [(96, 54), (64, 36), (31, 50), (1, 1), (200, 100)] {
        let part = Picture::new(width, height, light);
        let scene = surrounded(&host, Size::new(240, 150), &part, &[(17, 9)]);
        let rectangle = Rectangle { x: 17, y: 9, width, height };
        submit(
            &mut host,
            &Frame { inputs: &[("scene", &scene)], rectangles: &[("scene", rectangle)], ..Frame::default() },
        );
        assert!(plan.is_none_or(|plan| Arc::ptr_eq(&plan, &host.plan())), "no plan is made for {width}x{height}");
        plan = Some(host.plan());
        let shown = pixels(&host);
        assert_eq!((shown.width, shown.height), (SIZE.width, SIZE.height));
        for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
            let wanted = bilinear(&part, (f64::from(x) + 0.5) / 96.0, (f64::from(y) + 0.5) / 54.0);
            for (shown, wanted) in shown.at(x, y).into_iter().zip(wanted) {
                let error = (f64::from(shown) - wanted).abs();
                assert!(error <= 2e-3 * wanted.abs().max(0.1), "{width}x{height} at {x},{y}: {shown} {wanted}");
            }
        }
    }
}

/// The bilinear filter, clamped to the border, in f64.
fn bilinear(picture: &Picture, u: f64, v: f64) -> [f64; 4] {
    let (x, y) = (u * f64::from(picture.width) - 0.5, v * f64::from(picture.height) - 0.5);
    let texel = |x: f64, y: f64| {
        let inside = |at: f64, length: u32| at.clamp(0.0, f64::from(length - 1)) as u32;
        picture.at(inside(x, picture.width), inside(y, picture.height)).map(f64::from)
    };
    let (left, top) = (x.floor(), y.floor());
    let between = |a: [f64; 4], b: [f64; 4], t: f64| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
    let upper = between(texel(left, top), texel(left + 1.0, top), x - left);
    let lower = between(texel(left, top + 1.0), texel(left + 1.0, top + 1.0), x - left);
    between(upper, lower, y - top)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_factor_changes_nothing_but_a_uniform_and_comes_before_the_limit() {
    let mut host = Host::new(graph(SAME));
    let texels = Texels::from_floats(4, 1, &[[1e6, 2.0, 0.0, 0.5], [3.0; 4], [65504.0; 4], [f32::INFINITY; 4]]);
    let texture = upload(&host.gpu.device, &host.gpu.queue, &texels).unwrap();
    let scene = texture.create_view(&Default::default());
    let mut plan = None;
    for factor in [1.0_f32, 0.5, 1e-3, 0.0, 8.0, 1.0] {
        let frame = Frame { inputs: &[("scene", &scene)], factors: &[("scene", factor)], ..Frame::default() };
        submit(&mut host, &frame);
        assert!(plan.is_none_or(|plan| Arc::ptr_eq(&plan, &host.plan())), "no plan is made");
        plan = Some(host.plan());
        let shown = pixels(&host);
        let bright = |light: f32| (light * factor).min(65504.0);
        let wanted = [
            [bright(1e6), 2.0 * factor, 0.0, 0.5],
            [3.0 * factor, 3.0 * factor, 3.0 * factor, 3.0],
            [bright(65504.0), bright(65504.0), bright(65504.0), 65504.0],
        ];
        for (shown, wanted) in shown.pixels.iter().zip(wanted) {
            for (shown, wanted) in shown.iter().zip(wanted) {
                assert!((shown - wanted).abs() <= 1e-3 * wanted.abs(), "{factor}: {shown} {wanted}");
            }
        }
        assert!(shown.pixels[3].iter().all(|number| number.is_finite()), "{factor}: {:?}", shown.pixels[3]);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn rectangles_and_factors_that_cannot_be_are_errors_and_the_next_frame_is_right() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let wanted = host.shown();
    let texture = target(&host, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let (scene, shown) = (host.scene.clone(), texture.create_view(&Default::default()));
    let (inputs, outputs) = (&[("scene", &scene)], &[("display", &shown)]);
    let rectangle = |x, y, width, height| Rectangle { x, y, width, height };
    let mut refused = |rectangles: &[(&str, Rectangle)], factor: f32| {
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        let factors = &[("scene", factor)];
        let frame = Frame { inputs, outputs, rectangles, factors, ..Frame::default() };
        let error = host.post.encode(&mut encoder, &frame).expect_err("it cannot be").to_string();
        host.gpu.queue.submit([encoder.finish()]);
        error
    };
    let display = ("display", at(0, 0));
    let outside =
        "the image given for `scene` cannot be used: its rectangle, 96x54 from 1,0, is no part of its 96x54 texels";
    assert_eq!(refused(&[("scene", at(1, 0)), display], 1.0), outside);
    let far = refused(&[("scene", rectangle(u32::MAX, 0, 96, 54)), display], 1.0);
    assert!(far.contains("is no part of its 96x54 texels"), "{far}");
    let empty = refused(&[("scene", at(0, 0)), ("display", rectangle(5, 5, 0, 54))], 1.0);
    assert!(empty.contains("`display`") && empty.contains("0x54 from 5,5"), "{empty}");
    let smaller = refused(&[("scene", at(0, 0)), ("display", rectangle(5, 5, 50, 54))], 1.0);
    assert_eq!(smaller, "the image given for `display` is a rectangle of 50x54, but the plan was made for 96x54");
    for factor in [f32::NAN, f32::INFINITY, -1.0] {
        let error = refused(&[("scene", at(0, 0)), display], factor);
        assert!(error.contains("must be a number of at least 0"), "{error}");
    }
    assert_same(&host.shown(), &wanted);
    // The executor alone has no plan for it.
    let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
    let frame = Frame { inputs, factors: &[("scene", 2.0)], ..Frame::default() };
    let error = host.post.executor().encode(&mut encoder, &frame).unwrap_err().to_string();
    assert!(error.ends_with("the plan was made for the whole image and no factor"), "{error}");
}

/// Data is not filtered: a texel between two depths would be none of the scene.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn data_takes_the_nearest_texel() {
    let text = r#"Pipeline(inputs: { "depth": Data }, nodes: {}, outputs: { "display": "depth" })"#;
    let mut host = Host::new(graph(text));
    host.post.set_size(Some(Size::new(8, 4)));
    let part = Picture::new(3, 2, |x, y| [(10 * y + x) as f32, -1.0, 0.5, 1.0]);
    let scene = surrounded(&host, Size::new(9, 9), &part, &[(2, 5)]);
    let rectangles = &[("depth", Rectangle { x: 2, y: 5, width: 3, height: 2 })];
    submit(&mut host, &Frame { inputs: &[("depth", &scene)], rectangles, ..Frame::default() });
    let shown = pixels(&host);
    for (x, y) in (0..4).flat_map(|y| (0..8).map(move |x| (x, y))) {
        assert_eq!(shown.at(x, y), part.at((2 * x + 1) * 3 / 16, (2 * y + 1) * 2 / 8), "{x},{y}");
    }
}
