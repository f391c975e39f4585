//! Images that a session takes from the processor's memory and reads back into it.

use afterimage::offline::Session;
use afterimage_gpu::{FrameKind, FrameStep, Gpu, GpuError, InputImage, Opening, Texels};
use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_plan::Options;

use super::at_tier;

/// Numbers that stay exact when they are doubled twice.
const TWO: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "one": Exposure(source: "scene", stops: 1.0), "two": Exposure(source: "scene", stops: 2.0) },
    outputs: { "one": "one", "two": "two" },
)"#;

fn open() -> Gpu {
    let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
    Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}"))
}

fn session(gpu: &Gpu) -> Session {
    Session::new(gpu, at_tier(TWO, None), Facts::default(), Options { exact: true, ..Options::default() })
}

/// Pixels of which no two are equal, other ones in each frame.
fn pixels(size: Size, frame: u32) -> Vec<[f32; 4]> {
    let number = |at: u32| (1 + at + 4096 * frame) as f32 / 4096.0;
    (0..size.width * size.height).map(|at| [number(at), 0.5, number(at) / 2.0, 1.0]).collect()
}

fn feed(session: &mut Session, size: Size, frame: u32) -> InputImage {
    let texels = Texels::from_floats(size.width, size.height, &pixels(size, frame));
    session.feed("scene", texels.desc, &texels.bytes).unwrap_or_else(|error| panic!("{error}"))
}

fn scaled(size: Size, frame: u32, factor: f32) -> Vec<[f32; 4]> {
    pixels(size, frame).into_iter().map(|[r, g, b, a]| [factor * r, factor * g, factor * b, a]).collect()
}

/// Rows of most widths are padded in the buffers between the processor and the device.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_of_any_width_arrive_whole_in_every_frame() {
    let gpu = open();
    let mut session = session(&gpu);
    for size in [Size::new(1, 7), Size::new(5, 3), Size::new(16, 4), Size::new(33, 9), Size::new(70, 2)] {
        for frame in 0..4 {
            let images = [feed(&mut session, size, frame)];
            let step = FrameStep { time: 0.0, dt: 0.1, kind: FrameKind::cut_if(frame == 0) };
            session.render(size, &images, step).unwrap_or_else(|error| panic!("{error}"));
            for (output, factor) in [("one", 2.0), ("two", 4.0)] {
                let texels = session.output(output).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(texels.to_floats(), scaled(size, frame, factor), "`{output}` of frame {frame}, {size}");
            }
        }
        let images = vec![feed(&mut session, size, 9)];
        let frames = [true, false]
            .map(|reset| (images.clone(), FrameStep { time: 0.0, dt: 0.1, kind: FrameKind::cut_if(reset) }));
        for together in [false, true] {
            for outputs in session.render_all(&frames, together).unwrap_or_else(|error| panic!("{error}")) {
                let read: Vec<Vec<[f32; 4]>> = outputs.iter().map(Texels::to_floats).collect();
                assert_eq!(read, [2.0, 4.0].map(|factor| scaled(size, 9, factor)), "{size}, together: {together}");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_image_fits_if_no_side_is_longer_than_the_device_allows() {
    let gpu = open();
    let side = gpu.caps.max_side;
    let check = |width, height| gpu.check_fits(ImageDesc::new(Size::new(width, height)).format(Format::Rgba8Unorm));
    assert!(check(side, side).is_ok() && check(1, side).is_ok() && check(side, 1).is_ok());
    for (width, height) in [(side + 1, 1), (1, side + 1)] {
        let error = check(width, height).expect_err("it is too long");
        assert!(matches!(error, GpuError::TooLarge { limit, .. } if limit == side), "{error}");
    }
}
