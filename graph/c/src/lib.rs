//! Afterimage for C: pipelines on images in the memory of the processor, as `include/afterimage.h` declares them.
//!
//! No panic leaves a function: it becomes an error, and the pipeline refuses further calls. A null pointer is an error
//! wherever the header does not allow it.

#![allow(unsafe_code, reason = "the functions are called from C, and read its memory")]

mod error;
pub mod governor;

use std::ffi::{CStr, CString, c_char, c_void};
use std::slice;

use afterimage::FrameKind;
use afterimage::host::{Camera, FrameStep, ImageDesc, Matrix, Size};
use afterimage::offline::{ComponentType, Encoding, Offline, OfflineFrame, OfflineImage, RenderedImage, format_of};

use error::{Fault, guarded};

/// Codes of 8 bits.
pub const AFTERIMAGE_U8: u32 = 1;
/// Codes of 16 bits.
pub const AFTERIMAGE_U16: u32 = 2;
/// 16-bit floats.
pub const AFTERIMAGE_F16: u32 = 3;
/// 32-bit floats.
pub const AFTERIMAGE_F32: u32 = 4;

/// A pipeline. One thread at a time may use it.
pub struct AfterimagePipeline {
    look: Offline,
    /// The outputs of the last frame, with their names as C has them.
    outputs: Vec<(CString, RenderedImage)>,
    /// The texts that C has of the tier and of the shortfall.
    tier: Option<CString>,
    shortfall: Option<CString>,
    /// True after a call that has ended in a panic: the state is unknown.
    is_broken: bool,
}

/// An image in memory: rows from the top without gaps, the channels of a pixel side by side, the slices of a volume one
/// after another.
#[repr(C)]
pub struct AfterimageImage {
    /// The name of the input or output.
    pub name: *const c_char,
    /// The numbers. They have the byte order and the alignment of the processor.
    pub numbers: *const c_void,
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Numbers of a pixel: 4; for inputs of data also 1 (or 2 of 16 bits); for outputs 1 to 4.
    pub channels: u32,
    /// `AFTERIMAGE_F16` or `AFTERIMAGE_F32`; for outputs also `AFTERIMAGE_U8` or `AFTERIMAGE_U16`.
    pub number_type: u32,
    /// Slices of a volume; 0 for an image that is none.
    pub slices: u32,
}

/// A camera. A matrix has its columns one after another.
#[repr(C)]
pub struct AfterimageCamera {
    /// The name of the input.
    pub name: *const c_char,
    /// From the world to the camera, which looks along -z with y upwards.
    pub view: [f32; 16],
    /// From the camera to clip space, without jitter; depth is from 0 to 1, with the near plane at either end.
    pub projection: [f32; 16],
    /// `view` of the frame before; the same as `view` in a first frame.
    pub previous_view: [f32; 16],
    /// `projection` of the frame before.
    pub previous_projection: [f32; 16],
    /// Offset of the samples from the centers of pixels, in pixels, y downwards.
    pub jitter: [f32; 2],
    /// `jitter` of the frame before.
    pub previous_jitter: [f32; 2],
}

/// A frame to render.
#[repr(C)]
pub struct AfterimageFrame {
    /// Images of the inputs: light as linear Rec.709.
    pub images: *const AfterimageImage,
    /// Number of images.
    pub image_count: usize,
    /// Cameras of the inputs.
    pub cameras: *const AfterimageCamera,
    /// Number of cameras.
    pub camera_count: usize,
    /// Pixels of a row, for a pipeline without images.
    pub width: u32,
    /// Rows, for a pipeline without images.
    pub height: u32,
    /// The number of the frame, from which noise is made.
    pub number: u32,
    /// Seconds since the start.
    pub time: f64,
    /// Seconds since the frame before.
    pub dt: f32,
    /// 0 for a first frame. Otherwise histories and adaptation go on from the frame before.
    pub continues: u32,
}

/// The text of the last error on this thread; it is valid until the next one. Empty if there was none.
#[unsafe(no_mangle)]
pub extern "C" fn afterimage_error() -> *const c_char {
    error::last()
}

/// Opens a pipeline: the path of a file, the name of a built-in pipeline, or a text with `Pipeline(`. Returns null
/// after an error.
///
/// # Safety
/// `source` is null or a text with a zero at its end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_open(source: *const c_char) -> *mut AfterimagePipeline {
    guarded(std::ptr::null_mut(), || {
        // SAFETY: what the caller promises.
        let source = unsafe { text(source, "source") }?;
        let look = if source.contains("Pipeline(") {
            Offline::open(afterimage::Source::text("<text>", source))
        } else {
            Offline::open(source)
        };
        let (look, outputs, is_broken) = (look?, Vec::new(), false);
        Ok(Box::into_raw(Box::new(AfterimagePipeline { look, outputs, tier: None, shortfall: None, is_broken })))
    })
}

/// Frees a pipeline and its outputs. Null is allowed.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_free(pipeline: *mut AfterimagePipeline) {
    guarded((), || {
        if !pipeline.is_null() {
            // SAFETY: what the caller promises.
            drop(unsafe { Box::from_raw(pipeline) });
        }
        Ok(())
    });
}

/// Sets a parameter, `node.parameter`, to a value as a pipeline file writes it, or switches a node: `On` or `Off`.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`; the others are null or texts with a zero at their ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_set(
    pipeline: *mut AfterimagePipeline,
    name: *const c_char,
    value: *const c_char,
) -> bool {
    // SAFETY: what the caller promises.
    let (name, value) = unsafe { (text(name, "name"), text(value, "value")) };
    // SAFETY: the same.
    unsafe { with(pipeline, |pipeline| Ok(pipeline.look.set(name?, value?)?)) }
}

/// Changes to a tier; null is the pipeline without one.
///
/// # Safety
/// As for `afterimage_set`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_set_tier(pipeline: *mut AfterimagePipeline, tier: *const c_char) -> bool {
    // SAFETY: what the caller promises.
    let tier = if tier.is_null() { Ok(None) } else { unsafe { text(tier, "tier") }.map(Some) };
    // SAFETY: the same.
    unsafe { with(pipeline, |pipeline| Ok(pipeline.look.set_tier(tier?)?)) }
}

/// States a fact that is true or false.
///
/// # Safety
/// As for `afterimage_set`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_set_flag(
    pipeline: *mut AfterimagePipeline,
    name: *const c_char,
    flag: bool,
) -> bool {
    // SAFETY: what the caller promises.
    let name = unsafe { text(name, "name") };
    // SAFETY: the same.
    unsafe { with(pipeline, |pipeline| Ok(pipeline.look.set_fact(name?, flag)?)) }
}

/// States a fact that is a number.
///
/// # Safety
/// As for `afterimage_set`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_set_number(
    pipeline: *mut AfterimagePipeline,
    name: *const c_char,
    number: f64,
) -> bool {
    // SAFETY: what the caller promises.
    let name = unsafe { text(name, "name") };
    // SAFETY: the same.
    unsafe { with(pipeline, |pipeline| Ok(pipeline.look.set_fact(name?, number)?)) }
}

/// The type of the numbers of outputs for a display; 0 for the codes of the program's PNG files: `AFTERIMAGE_U8`, and
/// `AFTERIMAGE_U16` for PQ and HLG. Floats are from 0 to 1 and not rounded. Light has the type that the pipeline
/// stores.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_set_type(pipeline: *mut AfterimagePipeline, number_type: u32) -> bool {
    let set = |pipeline: &mut AfterimagePipeline| {
        pipeline.look.set_encoding(match number_type {
            0 => Encoding::Codes,
            AFTERIMAGE_U8 => Encoding::Codes8,
            AFTERIMAGE_U16 => Encoding::Codes16,
            AFTERIMAGE_F16 => Encoding::Half,
            AFTERIMAGE_F32 => Encoding::Float,
            other => return Err(Fault(format!("no type of numbers is {other}"))),
        });
        Ok(())
    };
    // SAFETY: what the caller promises.
    unsafe { with(pipeline, set) }
}

/// Renders a frame, and waits for it.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`. `frame` is null or a frame with as many images, cameras and numbers as
/// it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_render(pipeline: *mut AfterimagePipeline, frame: *const AfterimageFrame) -> bool {
    let render = |pipeline: &mut AfterimagePipeline| {
        // SAFETY: what the caller promises.
        let frame = unsafe { frame.as_ref() }.ok_or_else(|| null("frame"))?;
        // SAFETY: the same.
        let images = unsafe { images(frame) }?;
        // SAFETY: the same.
        let cameras = unsafe { cameras(frame) }?;
        let first = FrameStep { time: frame.time, ..FrameStep::FIRST };
        let rendered = pipeline.look.render(&OfflineFrame {
            images: &images,
            cameras: &cameras,
            size: Size::new(frame.width.max(1), frame.height.max(1)),
            number: frame.number,
            step: if frame.continues == 0 { first } else { FrameStep { dt: frame.dt, kind: FrameKind::Next, ..first } },
            ..OfflineFrame::default()
        })?;
        let named = |image: RenderedImage| Ok((CString::new(image.name.as_str())?, image));
        pipeline.outputs = rendered.outputs.into_iter().map(named).collect::<Result<_, Fault>>()?;
        Ok(())
    };
    // SAFETY: the same.
    unsafe { with(pipeline, render) }
}

/// An output of the last frame; a null name is the first one. Its memory is valid until the next frame, or until the
/// pipeline is freed.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`, `name` is null or a text with a zero at its end, `image` is null or may
/// be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_output(
    pipeline: *mut AfterimagePipeline,
    name: *const c_char,
    image: *mut AfterimageImage,
) -> bool {
    let find = |pipeline: &mut AfterimagePipeline| {
        // SAFETY: what the caller promises.
        let image = unsafe { image.as_mut() }.ok_or_else(|| null("image"))?;
        // SAFETY: the same.
        let name = if name.is_null() { None } else { Some(unsafe { text(name, "name") }?) };
        let mut outputs = pipeline.outputs.iter();
        let found = outputs.find(|(_, output)| name.is_none_or(|name| output.name == name));
        let (name, output) = found.ok_or_else(|| Fault("no frame with such an output was rendered".to_owned()))?;
        *image = AfterimageImage {
            name: name.as_ptr(),
            numbers: output.data.bytes().as_ptr().cast(),
            width: output.desc.size.width,
            height: output.desc.size.height,
            channels: output.channels as u32,
            number_type: match output.data.ty() {
                ComponentType::U8 => AFTERIMAGE_U8,
                ComponentType::U16 => AFTERIMAGE_U16,
                ComponentType::F16 => AFTERIMAGE_F16,
                ComponentType::F32 => AFTERIMAGE_F32,
            },
            slices: if output.desc.volume { output.desc.size.depth } else { 0 },
        };
        Ok(())
    };
    // SAFETY: the same.
    unsafe { with(pipeline, find) }
}

/// Four numbers of a value of the last frame, `node.port` or `node`, such as the exposure of a meter: stops, log2 of
/// the metered luminance, lux, and 1 once it is valid.
///
/// # Safety
/// As for `afterimage_output`; `numbers` is null or has room for four.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_value(
    pipeline: *mut AfterimagePipeline,
    name: *const c_char,
    numbers: *mut f32,
) -> bool {
    let read = |pipeline: &mut AfterimagePipeline| {
        // SAFETY: what the caller promises.
        let name = unsafe { text(name, "name") }?;
        // SAFETY: the same.
        let numbers = unsafe { numbers.cast::<[f32; 4]>().as_mut() }.ok_or_else(|| null("numbers"))?;
        let value = pipeline.look.value(name)?;
        *numbers = value.ok_or_else(|| Fault(format!("the last frame has no value `{name}`")))?;
        Ok(())
    };
    // SAFETY: the same.
    unsafe { with(pipeline, read) }
}

/// Calls `call` with a pipeline; returns whether there was no error.
///
/// # Safety
/// `pipeline` is null or of [`afterimage_open`], and nobody else uses it.
unsafe fn with(
    pipeline: *mut AfterimagePipeline,
    call: impl FnOnce(&mut AfterimagePipeline) -> Result<(), Fault>,
) -> bool {
    guarded(false, || {
        // SAFETY: what the caller promises.
        let pipeline = unsafe { pipeline.as_mut() }.ok_or_else(|| null("pipeline"))?;
        if pipeline.is_broken {
            return Err(Fault("an earlier call has failed inside of Afterimage: open the pipeline again".to_owned()));
        }
        pipeline.is_broken = true;
        let result = call(pipeline);
        pipeline.is_broken = false;
        result.map(|()| true)
    })
}

/// The images of a frame.
///
/// # Safety
/// Pointers are null or valid, and images have as many numbers as they say.
unsafe fn images(frame: &AfterimageFrame) -> Result<Vec<OfflineImage<'_>>, Fault> {
    // SAFETY: what the caller promises.
    let images = unsafe { array(frame.images, frame.image_count, "images") }?;
    let given = |image: &AfterimageImage| {
        // SAFETY: the same. The text lives as long as the frame.
        let input = unsafe { text(image.name, "name") }?;
        let ty = match image.number_type {
            AFTERIMAGE_F16 => Some(ComponentType::F16),
            AFTERIMAGE_F32 => Some(ComponentType::F32),
            _ => None,
        };
        let format = ty.and_then(|ty| format_of(ty, image.channels));
        let format = format.ok_or_else(|| {
            Fault(format!("`{input}`: no image has {} channels of the type {}", image.channels, image.number_type))
        })?;
        if image.numbers.is_null() {
            return Err(null("numbers"));
        }
        if image.width == 0 || image.height == 0 {
            return Err(Fault(format!("`{input}` has no pixels")));
        }
        let pixels = (u64::from(image.width) * u64::from(image.height)).checked_mul(image.slices.max(1).into());
        let length = pixels.and_then(|pixels| pixels.checked_mul(format.bytes()));
        let length = length.and_then(|length| isize::try_from(length).ok());
        let length = length.ok_or_else(|| Fault(format!("`{input}` is larger than the memory")))?;
        let desc = match image.slices {
            0 => ImageDesc::new(Size::new(image.width, image.height)),
            slices => ImageDesc::volume(Size::volume(image.width, image.height, slices)),
        };
        // SAFETY: the same.
        let bytes = unsafe { slice::from_raw_parts(image.numbers.cast::<u8>(), length.unsigned_abs()) };
        Ok(OfflineImage { input, desc: desc.format(format), bytes })
    };
    images.iter().map(given).collect()
}

/// The cameras of a frame.
///
/// # Safety
/// Pointers are null or valid.
unsafe fn cameras(frame: &AfterimageFrame) -> Result<Vec<(&str, Camera)>, Fault> {
    // SAFETY: what the caller promises.
    let cameras = unsafe { array(frame.cameras, frame.camera_count, "cameras") }?;
    let given = |camera: &AfterimageCamera| {
        // SAFETY: the same. The text lives as long as the frame.
        let input = unsafe { text(camera.name, "name") }?;
        let camera = Camera {
            view: columns(&camera.view),
            projection: columns(&camera.projection),
            previous_view: columns(&camera.previous_view),
            previous_projection: columns(&camera.previous_projection),
            jitter: camera.jitter,
            previous_jitter: camera.previous_jitter,
        };
        Ok((input, camera))
    };
    cameras.iter().map(given).collect()
}

fn columns(numbers: &[f32; 16]) -> Matrix {
    std::array::from_fn(|column| std::array::from_fn(|row| numbers[4 * column + row]))
}

/// An array of C; null is allowed for an empty one.
///
/// # Safety
/// `pointer` is null, or has `count` elements, which live as long as the result.
unsafe fn array<'t, T>(pointer: *const T, count: usize, name: &str) -> Result<&'t [T], Fault> {
    match (count, pointer.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(null(name)),
        // SAFETY: what the caller promises.
        _ => Ok(unsafe { slice::from_raw_parts(pointer, count) }),
    }
}

/// A text of C.
///
/// # Safety
/// `pointer` is null or a text with a zero at its end, which lives as long as the result.
unsafe fn text<'t>(pointer: *const c_char, name: &str) -> Result<&'t str, Fault> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: what the caller promises.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Fault(format!("`{name}` is not text in UTF-8")))
}

fn null(name: &str) -> Fault {
    Fault(format!("`{name}` is a null pointer"))
}
