//! The images that a pipeline is measured on: stills, sequences, a walk through the built-in scene.

use std::path::Path;

use afterimage_gpu::{FrameKind, FrameStep, Gpu, InputImage, Texels, input_image};
use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::diagnostic::{shown, shown_path};
use afterimage_graph::image::{ColorState, Size};
use afterimage_graph::node::{PortType, Registry};
use afterimage_media::{Budget, FileError, Source, images_in, read_within, sequence};

use super::charts;
use crate::files::file_name;
use crate::{LabError, scene};

/// The images on which a pipeline is measured.
#[derive(Clone, Debug)]
pub struct SequenceOptions {
    /// Files for the pipeline's first input; `shot.####.exr` is a sequence. A still image, and each image of a
    /// folder, is a sequence of one frame.
    pub images: Vec<String>,
    /// Files for other inputs, by the names of the inputs.
    pub inputs: Vec<(String, String)>,
    /// Adds a walk through the built-in scene, as is done if there are no other sequences.
    pub scene: bool,
    /// Adds the charts that break meters, halvings and what is kept from frame to frame.
    pub charts: bool,
    /// Sizes of the built-in scene: each is a sequence of its own.
    pub sizes: Vec<Size>,
    /// Frames of the walk, and of a still image in a pipeline that reads earlier images.
    pub walk: u32,
    /// Frames of sequences, as `--frames` takes them.
    pub frames: Option<String>,
    pub fps: f32,
    /// Memory that decoding a file may take.
    pub budget: Budget,
}

impl SequenceOptions {
    /// True if a pipeline can take the charts: its first input is scene-linear color, and it needs no other image.
    pub fn charts_fit(&self, graph: &Graph) -> bool {
        let Some((first, others)) = graph.inputs.split_first() else { return false };
        first.port_type() == PortType::Image
            && matches!(first.state, ColorState::Scene | ColorState::Exposed)
            && self.inputs.iter().all(|(name, _)| *name != first.name)
            && others.iter().all(|input| input.optional)
    }

    /// True for the file names that images of errors may have: they begin with the name of a sequence.
    pub fn may_name_error_image(&self, name: &str) -> bool {
        let scene = self.scene || self.images.is_empty();
        let files = self.images.iter().flat_map(|image| files(image).unwrap_or_default());
        let sequences = files.map(|file| short_name(&file)).chain(scene.then(|| SCENE.to_owned()));
        let sequences = sequences.chain(charts::names().filter(|_| self.charts).map(str::to_owned));
        name.ends_with(".png")
            && sequences.map(|sequence| file_name(&sequence)).any(|sequence| name.starts_with(&format!("{sequence}-")))
    }
}

/// The name of the sequence of the built-in scene.
const SCENE: &str = "built-in scene";

/// The frames of a sequence, or a still image.
pub(crate) struct TestSequence {
    pub(crate) name: String,
    pub(crate) size: Size,
    /// The images of each frame.
    images: Vec<Vec<InputImage>>,
    steps: Vec<FrameStep>,
}

impl TestSequence {
    /// The number of frames; at least one.
    pub(crate) fn len(&self) -> usize {
        self.steps.len()
    }

    /// The images of a frame; a still image is that of all frames.
    pub(crate) fn images(&self, frame: usize) -> &[InputImage] {
        &self.images[frame.min(self.images.len() - 1)]
    }

    /// True if all frames have the same image.
    pub(crate) fn is_still(&self) -> bool {
        self.images.len() == 1
    }

    /// The sequence with its image repeated for so many frames.
    pub(crate) fn repeated(mut self, frames: u32, fps: f32) -> Self {
        self.steps = steps(frames as usize, fps);
        self
    }

    /// True if plans for the other sequence are plans for this one.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let given = |image: &InputImage| (image.input.clone(), image.desc, image.finite);
        self.size == other.size && self.images(0).iter().map(given).eq(other.images(0).iter().map(given))
    }

    /// The position of a frame in time.
    pub(crate) fn step(&self, frame: usize) -> FrameStep {
        self.steps[frame]
    }
}

/// A sequence that is not loaded yet.
pub(crate) enum SequenceSource {
    Files {
        name: String,
        inputs: Vec<(String, sequence::Input)>,
    },
    /// A walk through the built-in scene, with these pixels.
    Scene {
        name: String,
        size: Size,
    },
    /// A chart for the pipeline's first input, by its name.
    Chart {
        name: &'static str,
        input: String,
    },
}

/// The sequences that the options name.
pub(crate) fn sources(options: &SequenceOptions, graph: &Graph) -> Result<Vec<SequenceSource>, LabError> {
    let mut others = Vec::new();
    for (name, file) in &options.inputs {
        if !graph.inputs.iter().any(|known| known.name == *name) {
            return Err(no_such_input(name, &graph.inputs));
        }
        others.push((name.clone(), find(options, file)?));
    }
    let mut sequences = Vec::new();
    for image in &options.images {
        for file in files(image)? {
            sequences.push(file_sequence(options, graph, &file, &others)?);
        }
    }
    for name in charts::names().filter(|_| options.charts) {
        sequences.push(SequenceSource::Chart { name, input: first_input(graph, name, &others)? });
    }
    if options.scene || sequences.is_empty() {
        for size in &options.sizes {
            let name = if options.sizes.len() == 1 { SCENE.to_owned() } else { format!("{SCENE} {size}") };
            sequences.push(SequenceSource::Scene { name, size: *size });
        }
    }
    Ok(sequences)
}

/// The sequences that a search sees: every other image, and some charts. The others confirm its result.
pub(crate) fn searched(sources: &[SequenceSource]) -> Vec<bool> {
    let mut is_next = false;
    let mut all = Vec::with_capacity(sources.len());
    for source in sources {
        all.push(match source {
            SequenceSource::Chart { name, .. } => charts::is_searched(name),
            SequenceSource::Scene { .. } => true,
            SequenceSource::Files { .. } => {
                is_next = !is_next;
                is_next
            }
        });
    }
    all
}

fn no_such_input(name: &str, inputs: &[GraphInput]) -> LabError {
    let known: Vec<String> = inputs.iter().map(|input| format!("`{}`", input.name)).collect();
    let hint = if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
    LabError::request(format!("the pipeline has no input `{name}`")).hint(hint)
}

fn file_sequence(
    options: &SequenceOptions,
    graph: &Graph,
    image: &str,
    others: &[(String, sequence::Input)],
) -> Result<SequenceSource, LabError> {
    let first = first_input(graph, image, others)?;
    let mut inputs = vec![(first, find(options, image)?)];
    inputs.extend(others.iter().cloned());
    Ok(SequenceSource::Files { name: short_name(image), inputs })
}

/// The name of the input that an image is for: the first that has no other one.
fn first_input(graph: &Graph, image: &str, others: &[(String, sequence::Input)]) -> Result<String, LabError> {
    let is_free = |input: &&GraphInput| others.iter().all(|(name, _)| *name != input.name);
    let mut free = graph.inputs.iter().filter(is_free);
    let Some(first) = free.next() else {
        return Err(LabError::request(format!("the pipeline has no input for `{image}`")).hint("leave the images out"));
    };
    if let Some(input) = free.find(|input| !input.optional) {
        return Err(LabError::request(format!("the pipeline needs an image for its input `{}`", input.name))
            .hint(format!("name it with `--input {}=FILE`", input.name)));
    }
    Ok(first.name.clone())
}

/// The files of an image argument: those in it, if it is a folder.
///
/// # Errors
/// The folder cannot be listed, or has no image.
pub fn files(image: &str) -> Result<Vec<String>, FileError> {
    let path = Path::new(image);
    if !path.is_dir() {
        return Ok(vec![image.to_owned()]);
    }
    Ok(images_in(path)?.iter().map(|file| file.to_string_lossy().into_owned()).collect())
}

/// The files of an image argument; the frames of the options apply to sequences only.
fn find(options: &SequenceOptions, image: &str) -> Result<sequence::Input, LabError> {
    let frames = options.frames.as_deref().filter(|_| sequence::is_numbered(image));
    Ok(sequence::Input::find(image, frames)?)
}

/// The file's name without its folder and ending.
fn short_name(image: &str) -> String {
    let file = Path::new(image).file_name().map_or(image.into(), |name| name.to_string_lossy());
    let stem = file.rsplit_once('.').map_or(file.as_ref(), |(stem, _)| stem);
    // The name is printed in tables with styles.
    shown(stem.trim_end_matches(['#', '.', '_', '-'])).into_owned()
}

impl SequenceSource {
    /// A name for progress and messages.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Files { name, .. } | Self::Scene { name, .. } => name,
            Self::Chart { name, .. } => name,
        }
    }

    fn size(&self) -> Option<Size> {
        match self {
            Self::Scene { size, .. } => Some(*size),
            _ => None,
        }
    }

    pub(crate) fn load(
        &self,
        gpu: &Gpu,
        registry: &Registry,
        graph: &Graph,
        options: &SequenceOptions,
    ) -> Result<TestSequence, LabError> {
        let images = match self {
            Self::Files { inputs, .. } => file_images(gpu, inputs, options.budget)?,
            Self::Chart { name, input } => {
                let image = |picture: &Texels| input_image(gpu, input, picture.desc, &picture.bytes);
                charts::frames(name).iter().map(|picture| Ok(vec![image(picture)?])).collect::<Result<_, LabError>>()?
            }
            Self::Scene { size, .. } => scene::walk(gpu, registry, &graph.inputs, *size, options.walk, options.fps)?,
        };
        let given = images[0].first().map(|image| image.desc.size);
        // A pipeline without inputs has the size of the scene.
        let size = given.or(self.size()).expect("a file gives an image");
        let steps = steps(images.len(), options.fps);
        Ok(TestSequence { name: self.name().to_owned(), size, images, steps })
    }
}

fn steps(frames: usize, fps: f32) -> Vec<FrameStep> {
    let mut steps = Vec::new();
    for frame in 0..frames {
        let reset = frame == 0;
        steps.push(FrameStep {
            time: frame as f64 / f64::from(fps),
            dt: if reset { 0.0 } else { 1.0 / fps },
            kind: FrameKind::cut_if(reset),
        });
    }
    steps
}

fn file_images(
    gpu: &Gpu,
    inputs: &[(String, sequence::Input)],
    budget: Budget,
) -> Result<Vec<Vec<InputImage>>, LabError> {
    let frames = inputs.iter().map(|(_, input)| input.sources().len()).max().unwrap_or(1);
    let image = |(name, input): &(String, _), frame| {
        let source = file_of(name, input, frame)?;
        let picture = read_within(&source, budget)?;
        let fits = gpu.check_fits(picture.desc());
        fits.map_err(|error| LabError::request(format!("{}: {error}", shown_path(&source.path))))?;
        Ok(input_image(gpu, name, picture.desc(), picture.bytes())?)
    };
    (0..frames).map(|frame| inputs.iter().map(|input| image(input, frame)).collect()).collect()
}

/// The file of an input in a frame; a still image is that of all frames.
fn file_of(name: &str, input: &sequence::Input, frame: usize) -> Result<Source, LabError> {
    let mut sources = input.sources();
    let last = sources.len() - 1;
    if last > 0 && frame > last {
        return Err(LabError::request(format!("input `{name}` has only {} frames", last + 1))
            .hint("shorten the others with `--frames`"));
    }
    Ok(sources.swap_remove(frame.min(last)).1)
}
