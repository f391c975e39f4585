//! Images from files.

use afterimage_gpu::wgpu::TextureView;
use afterimage_gpu::{Gpu, upload_bytes};
use afterimage_graph::check::GraphInput;
use afterimage_graph::image::Size;
use afterimage_media::Picture;

use super::FrameImages;
use crate::Problem;

/// Reads a frame of a sequence, by its index.
pub type ReadFrame = Box<dyn FnMut(usize) -> Result<Picture, String>>;

/// Returns true if the files of a sequence have changed since the last call.
pub type HaveChanged = Box<dyn FnMut() -> bool>;

/// Images from files: a picture or a sequence for the first input, and one picture for each other input.
pub struct Files {
    gpu: Gpu,
    frames: Vec<Option<TextureView>>,
    read: ReadFrame,
    have_changed: HaveChanged,
    /// The frame that is shown.
    present: usize,
    secondary: Vec<SecondaryInput>,
    size: Size,
    /// Frames in a second.
    fps: f64,
}

impl Files {
    /// Frames for the first input. Each is read when it is shown for the first time.
    ///
    /// # Errors
    /// The first frame cannot be read, or the device cannot hold it.
    pub fn new(gpu: &Gpu, count: usize, fps: f64, mut read: ReadFrame) -> Result<Self, Problem> {
        let first = read(0).map_err(Problem::message)?;
        let size = Size::new(first.width, first.height);
        let mut frames = vec![None; count.max(1)];
        frames[0] = Some(uploaded(gpu, &first)?);
        let (gpu, have_changed) = (gpu.clone(), Box::new(|| false));
        Ok(Self { gpu, frames, read, have_changed, present: 0, secondary: Vec::new(), size, fps })
    }

    /// Reads the frames again when this says so; it is asked in every frame of the viewer.
    pub fn follow_by(&mut self, have_changed: HaveChanged) {
        self.have_changed = have_changed;
    }

    pub(super) fn follow(&mut self) -> Result<bool, Problem> {
        if !(self.have_changed)() {
            return Ok(false);
        }
        let picture = (self.read)(self.present).map_err(Problem::message)?;
        let view = uploaded(&self.gpu, &picture)?;
        self.size = Size::new(picture.width, picture.height);
        self.frames.fill(None);
        self.frames[self.present] = Some(view);
        Ok(true)
    }

    /// Gives one more input an image, in every frame.
    ///
    /// # Errors
    /// The device cannot hold it.
    pub fn add(&mut self, input: &str, picture: Picture) -> Result<(), Problem> {
        let view = uploaded(&self.gpu, &picture)?;
        self.secondary.retain(|secondary| secondary.input != input);
        self.secondary.push(SecondaryInput { input: input.to_owned(), picture, view });
        Ok(())
    }

    /// The size of the images.
    pub(super) fn size(&self) -> Size {
        self.size
    }

    /// The number of frames and how many there are in a second, if there is more than one.
    pub(super) fn length(&self) -> Option<(usize, f64)> {
        (self.frames.len() > 1).then_some((self.frames.len(), self.fps))
    }

    pub(super) fn rebuild(&mut self, gpu: &Gpu) -> Result<(), Problem> {
        self.gpu = gpu.clone();
        self.frames.fill(None);
        for secondary in &mut self.secondary {
            secondary.view = uploaded(gpu, &secondary.picture)?;
        }
        Ok(())
    }

    pub(super) fn at(&mut self, time: f64, inputs: &[GraphInput]) -> Result<FrameImages, Problem> {
        self.present = (time * self.fps).round() as usize % self.frames.len();
        self.again(inputs)
    }

    pub(super) fn again(&mut self, inputs: &[GraphInput]) -> Result<FrameImages, Problem> {
        let mut main = Some(self.frame(self.present)?);
        let mut images = Vec::new();
        for input in inputs.iter().filter(|input| input.block.is_none()) {
            let named = self.secondary.iter().find(|secondary| secondary.input == input.name);
            let named = named.map(|secondary| secondary.view.clone());
            match named.or_else(|| if input.optional { None } else { main.take() }) {
                Some(view) => images.push((input.name.clone(), view)),
                None if input.optional => {}
                None => return Err(Problem::no_image(&input.name)),
            }
        }
        Ok(FrameImages { images, blocks: Vec::new() })
    }

    fn frame(&mut self, index: usize) -> Result<TextureView, Problem> {
        if let Some(view) = &self.frames[index] {
            return Ok(view.clone());
        }
        let view = uploaded(&self.gpu, &(self.read)(index).map_err(Problem::message)?)?;
        let bytes = u64::from(self.size.width) * u64::from(self.size.height) * 8;
        if self.frames.iter().flatten().count() as u64 * bytes > MAX_BYTES {
            self.frames.fill(None);
        }
        self.frames[index] = Some(view.clone());
        Ok(view)
    }
}

/// An image for an input after the first.
struct SecondaryInput {
    input: String,
    /// Kept for a device that replaces a lost one.
    picture: Picture,
    view: TextureView,
}

/// The most bytes of frames that are kept on the device.
const MAX_BYTES: u64 = 2 << 30;

fn uploaded(gpu: &Gpu, picture: &Picture) -> Result<TextureView, Problem> {
    gpu.check_fits(picture.desc())?;
    let texture = upload_bytes(&gpu.device, &gpu.queue, picture.desc(), picture.bytes())?;
    Ok(texture.create_view(&Default::default()))
}
