//! Files of a pipeline's inputs: images, volumes, cameras, and sequences of them.

use afterimage_gpu::wgpu::TextureView;
use afterimage_gpu::{Gpu, upload_bytes};
use afterimage_graph::check::GraphInput;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::BlockData;
use afterimage_media::{Picture, Repairs};

use super::FrameImages;
use crate::Problem;

/// Content of a file, as an input takes it.
pub enum InputData {
    /// An image, or the slices of a volume one below the other.
    Image(Box<Picture>, ImageDesc),
    Block(BlockData),
}

/// Reads a frame of a sequence for an input, by its index.
pub type ReadFrame = Box<dyn FnMut(&GraphInput, usize) -> Result<InputData, Problem>>;

/// Returns true if the files of a sequence have changed since the last call.
pub type HaveChanged = Box<dyn FnMut() -> bool>;

/// A file or a sequence for an input.
pub struct InputFile {
    /// The name, as the user has given it.
    pub name: String,
    /// The numbers of the frames of a sequence, in order; none for a single file.
    pub numbers: Vec<u32>,
    /// Frames in a second.
    pub fps: f64,
    /// The names of the layers that can be chosen after `#`.
    pub layers: Vec<String>,
    pub read: ReadFrame,
    pub have_changed: HaveChanged,
}

impl InputFile {
    /// A file that does not change.
    pub fn still(name: &str, read: ReadFrame) -> Self {
        Self {
            name: name.to_owned(),
            numbers: Vec::new(),
            fps: 24.0,
            layers: Vec::new(),
            read,
            have_changed: Box::new(|| false),
        }
    }

    /// Reads a frame, and copies it to the device.
    fn frame(&mut self, gpu: &Gpu, input: &GraphInput, index: usize) -> Result<Frame, Problem> {
        let (picture, desc) = match (self.read)(input, index)? {
            InputData::Image(picture, desc) => (picture, desc),
            InputData::Block(data) => {
                return Ok(Frame { content: Content::Block(data), repairs: Repairs::default(), size: Size::new(0, 0) });
            }
        };
        gpu.check_fits(desc)?;
        let texture = upload_bytes(&gpu.device, &gpu.queue, desc, picture.bytes())?;
        let content = Content::Image(texture.create_view(&Default::default()));
        Ok(Frame { content, repairs: Repairs::of(&picture, input.state.signedness()), size: desc.size })
    }

    /// The index of the last frame that is not after a number.
    fn index(&self, number: u32) -> usize {
        self.numbers.partition_point(|known| *known <= number).saturating_sub(1)
    }
}

/// Files for the inputs of a pipeline.
pub struct Files {
    gpu: Gpu,
    files: Vec<LoadedFile>,
    /// The index of the shown frame in the longest sequence.
    present: usize,
    size: Size,
}

/// A file with the frames that are on the device.
struct LoadedFile {
    /// The name of the input; `None` for the first image that a pipeline needs.
    input: Option<String>,
    file: InputFile,
    /// The input that the frames were read for.
    read_for: Option<GraphInput>,
    frames: Vec<Option<Frame>>,
}

/// A frame on the device.
#[derive(Clone)]
struct Frame {
    content: Content,
    repairs: Repairs,
    size: Size,
}

#[derive(Clone)]
enum Content {
    Image(TextureView),
    Block(BlockData),
}

/// The most bytes of frames of a sequence that are kept on the device.
const MAX_BYTES: u64 = 2 << 30;

/// The images that a pipeline needs.
fn needed_images(inputs: &[GraphInput]) -> impl Iterator<Item = &GraphInput> {
    inputs.iter().filter(|input| input.block.is_none() && !input.optional)
}

impl Files {
    /// No files, and the size of images that do not come from one.
    pub fn new(gpu: &Gpu, size: Size) -> Self {
        Self { gpu: gpu.clone(), files: Vec::new(), present: 0, size }
    }

    /// Gives an input a file; `None` is the first image that a pipeline needs: one without a named file, if there is
    /// one. `inputs` are those of the pipeline: what is read for one of them must be readable.
    ///
    /// # Errors
    /// It cannot be read, or the device cannot hold it. Nothing has changed then.
    pub(super) fn set(&mut self, input: Option<&str>, file: InputFile, inputs: &[GraphInput]) -> Result<(), Problem> {
        let frames = vec![None; file.numbers.len().max(1)];
        let mut loaded = LoadedFile { input: input.map(str::to_owned), file, read_for: None, frames };
        let target = match input {
            Some(name) => inputs.iter().find(|known| known.name == name),
            None => self.first_needed(inputs).or_else(|| needed_images(inputs).next()),
        };
        if let Some(target) = target {
            let number = self.number().unwrap_or(0);
            self.size = loaded.frame(&self.gpu, target, number)?.size_of_image().unwrap_or(self.size);
        }
        // A file has the place of the one before: the first one names what is shown.
        let before = target.and_then(|target| self.file_of(target, inputs));
        self.remove(input, inputs);
        self.files.retain(|loaded| target.is_none_or(|target| loaded.input.as_ref() != Some(&target.name)));
        let place = before.map_or(self.files.len(), |place| place.min(self.files.len()));
        self.files.insert(place, loaded);
        Ok(())
    }

    /// Takes the file of an input away.
    pub(super) fn remove(&mut self, input: Option<&str>, inputs: &[GraphInput]) {
        let first = self.first_needed(inputs).map(|first| first.name.clone());
        let is_first = |loaded: &LoadedFile| loaded.input.is_none() && (input.is_none() || input == first.as_deref());
        self.files.retain(|loaded| !is_first(loaded) && (input.is_none() || loaded.input.as_deref() != input));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// The name of the file that was given first.
    pub(super) fn first_name(&self) -> Option<&str> {
        Some(&self.files.first()?.file.name)
    }

    /// The file of an input.
    pub(super) fn file(&self, input: &GraphInput, inputs: &[GraphInput]) -> Option<&InputFile> {
        Some(&self.files[self.file_of(input, inputs)?].file)
    }

    /// The pixels of the shown frame that no image can show, for each input with a file.
    pub(super) fn repairs(&self) -> impl Iterator<Item = (&str, Repairs)> {
        let number = self.number().unwrap_or(0);
        self.files.iter().filter_map(move |loaded| {
            let frame = loaded.frames[loaded.file.index(number)].as_ref()?;
            Some((&*loaded.read_for.as_ref()?.name, frame.repairs))
        })
    }

    /// The first image that a pipeline needs and that no file is named for.
    fn first_needed<'i>(&self, inputs: &'i [GraphInput]) -> Option<&'i GraphInput> {
        let is_named = |input: &GraphInput| self.files.iter().any(|loaded| loaded.input.as_ref() == Some(&input.name));
        needed_images(inputs).find(|input| !is_named(input))
    }

    fn file_of(&self, input: &GraphInput, inputs: &[GraphInput]) -> Option<usize> {
        let named = self.files.iter().position(|loaded| loaded.input.as_ref() == Some(&input.name));
        let is_first = || self.first_needed(inputs).is_some_and(|first| first.name == input.name);
        named.or_else(|| self.files.iter().position(|loaded| loaded.input.is_none()).filter(|_| is_first()))
    }

    /// The longest sequence.
    fn longest(&self) -> Option<&InputFile> {
        let sequences = self.files.iter().map(|loaded| &loaded.file).filter(|file| file.numbers.len() > 1);
        // The first of several.
        sequences.rev().max_by_key(|file| file.numbers.len())
    }

    /// The number of the shown frame, as its file states it; `None` without a sequence.
    pub(super) fn number(&self) -> Option<u32> {
        self.longest()?.numbers.get(self.present).copied()
    }

    /// Reads files again that have changed. Returns whether one has.
    pub(super) fn follow(&mut self) -> Result<bool, Problem> {
        let number = self.number().unwrap_or(0);
        let mut has_changed = false;
        for loaded in &mut self.files {
            if !(loaded.file.have_changed)() {
                continue;
            }
            let index = loaded.file.index(number);
            let frame = match &loaded.read_for {
                Some(input) => Some(loaded.file.frame(&self.gpu, input, index)?),
                None => None,
            };
            loaded.frames.fill(None);
            loaded.frames[index] = frame;
            has_changed = true;
        }
        Ok(has_changed)
    }

    /// The size of the images.
    pub(super) fn size(&self) -> Size {
        self.size
    }

    /// The number of frames and how many there are in a second, if there is more than one.
    pub(super) fn length(&self) -> Option<(usize, f64)> {
        self.longest().map(|file| (file.numbers.len(), file.fps))
    }

    pub(super) fn rebuild(&mut self, gpu: &Gpu) {
        self.gpu = gpu.clone();
        self.files.iter_mut().for_each(|loaded| loaded.frames.fill(None));
    }

    pub(super) fn at(&mut self, time: f64, inputs: &[GraphInput]) -> Result<FrameImages, Problem> {
        self.present = self.length().map_or(0, |(count, fps)| (time * fps).round() as usize % count);
        self.again(inputs)
    }

    pub(super) fn again(&mut self, inputs: &[GraphInput]) -> Result<FrameImages, Problem> {
        let number = self.number().unwrap_or(0);
        let mut given = FrameImages::default();
        let mut size = None;
        for input in inputs {
            let Some(file) = self.file_of(input, inputs) else {
                if input.optional {
                    continue;
                }
                return Err(Problem::no_file(input));
            };
            let frame = self.files[file].frame(&self.gpu, input, number)?;
            size = size.or(frame.size_of_image());
            match frame.content {
                Content::Image(view) => given.images.push((input.name.clone(), view)),
                Content::Block(data) => given.blocks.push((input.name.clone(), data)),
            }
        }
        self.size = size.unwrap_or(self.size);
        Ok(given)
    }
}

impl LoadedFile {
    /// The frame of a number, for an input.
    fn frame(&mut self, gpu: &Gpu, input: &GraphInput, number: u32) -> Result<Frame, Problem> {
        if self.read_for.as_ref() != Some(input) {
            // Another kind of input is read in another way.
            self.frames.fill(None);
            self.read_for = Some(input.clone());
        }
        let index = self.file.index(number);
        if let Some(frame) = &self.frames[index] {
            return Ok(frame.clone());
        }
        let frame = self.file.frame(gpu, input, index)?;
        let bytes = u64::from(frame.size.width) * u64::from(frame.size.height) * 8;
        if self.frames.iter().flatten().count() as u64 * bytes > MAX_BYTES {
            self.frames.fill(None);
        }
        self.frames[index] = Some(frame.clone());
        Ok(frame)
    }
}

impl Frame {
    fn size_of_image(&self) -> Option<Size> {
        (matches!(self.content, Content::Image(_)) && self.size.depth == 1).then_some(self.size)
    }
}
