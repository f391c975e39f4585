//! The first stage of `render`: images are read.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use afterimage_graph::image::{ImageDesc, Signedness, Size};
use afterimage_graph::node::{BlockData, CameraFile};
use afterimage_media::film::{Film, FilmReader};
use afterimage_media::{
    ErrorKind, FileError, Picture, Pixels, ReadOptions, Repairs, Source, is_opaque, read_standard_input, read_within,
};

use super::jobs::Job;
use super::request::Request;
use super::target::STANDARD;
use crate::args::files::{MissingFrames, OtherSize};
use crate::cameras::read_camera_file;
use crate::failure::Failure;

/// The image of an input, and what its file is worth.
pub(super) struct InputPicture {
    pub(super) name: String,
    pub(super) file: PathBuf,
    pub(super) picture: Picture,
    /// The shape of its texels: an image, or a volume.
    pub(super) desc: ImageDesc,
    /// The pixels that the graph repairs.
    pub(super) repairs: Repairs,
    /// The file and how it is read, if it does not fit into memory and is read in bands: then `picture` is its first
    /// row.
    pub(super) streamed: Option<(Source, ReadOptions)>,
    pub(super) signedness: Signedness,
    /// True if the input needs an alpha that the image does not have.
    pub(super) lacks_alpha: bool,
}

impl InputPicture {
    /// Bytes of a row of texels.
    pub(super) fn row(&self) -> usize {
        self.desc.size.width as usize * self.desc.format.bytes() as usize
    }
}

/// The content of the files of a job.
pub(super) struct Inputs {
    pub(super) pictures: Vec<InputPicture>,
    /// The cameras, by the names of inputs.
    pub(super) blocks: Vec<(String, BlockData)>,
}

/// The inputs of a job.
pub(super) type Read = Result<Inputs, Failure>;

/// The cameras of a frame, by the names of inputs.
type Cameras = BTreeMap<String, CameraFile>;

/// The size of the first image of each input.
type Sizes = BTreeMap<String, (u32, u32)>;

/// The decoders of films, by the names of inputs.
type Decoders = BTreeMap<String, FilmReader>;

/// Reads the images of all jobs; returns the time that it takes.
pub(super) fn read_all(request: &Request<'_>, to: &SyncSender<Read>) -> Duration {
    let mut busy = Duration::ZERO;
    let mut cameras = Cameras::new();
    let (mut sizes, mut decoders) = (Sizes::new(), Decoders::new());
    for (index, job) in request.jobs.iter().enumerate() {
        let start = Instant::now();
        let begun = if index == 0 { read_cameras_before(request, &mut cameras) } else { Ok(()) };
        let inputs = begun.and_then(|()| read_job(request, job, &mut cameras, &mut sizes, &mut decoders));
        busy += start.elapsed();
        let failed = inputs.is_err() && !request.args.keep_going;
        // A receiver that is gone has failed and reports the error.
        if to.send(inputs).is_err() || failed {
            break;
        }
    }
    busy
}

/// The cameras of the frame before the first one, if the first one follows it.
fn read_cameras_before(request: &Request<'_>, cameras: &mut Cameras) -> Result<(), Failure> {
    for (name, source) in request.job_before().iter().flat_map(|job| &job.sources) {
        if request.has_camera(name) {
            read_camera(name, source, cameras)?;
        }
    }
    Ok(())
}

fn read_job(
    request: &Request<'_>,
    job: &Job,
    before: &mut Cameras,
    sizes: &mut Sizes,
    decoders: &mut Decoders,
) -> Read {
    if request.is_cut(job) {
        before.clear();
    }
    let mut inputs = Inputs { pictures: Vec::new(), blocks: Vec::new() };
    for (name, source) in &job.sources {
        if request.has_camera(name) {
            inputs.blocks.push((name.clone(), read_camera(name, source, before)?));
        } else {
            let is_missing = job.missing.contains(name);
            let (read, streamed) = match request.films.get(name) {
                Some(film) => (read_frame(request, name, film, job, decoders), None),
                None => read_file(request, name, source),
            };
            inputs.pictures.push(input_picture(request, (name, source), read, streamed, is_missing, sizes)?);
        }
    }
    Ok(inputs)
}

/// The camera of a frame. What its file does not state of the frame before is what the last file states.
fn read_camera(name: &str, source: &Source, before: &mut Cameras) -> Result<BlockData, Failure> {
    let file = read_camera_file(source)?;
    let data = file.data(before.get(name));
    before.insert(name.to_owned(), file);
    Ok(data.expect("both files have finite matrices with inverses"))
}

/// The frame of a film.
fn read_frame(
    request: &Request<'_>,
    name: &str,
    film: &Film,
    job: &Job,
    decoders: &mut Decoders,
) -> Result<Picture, FileError> {
    if !decoders.contains_key(name) {
        decoders.insert(name.to_owned(), FilmReader::new(film, &read_options(request, name))?);
    }
    let decoder = decoders.get_mut(name).expect("it is there");
    decoder.frame(job.frame.unwrap_or(1).saturating_sub(1) as usize)
}

/// A file, or its first row if it does not fit into memory and is read in bands.
fn read_file(
    request: &Request<'_>,
    name: &str,
    source: &Source,
) -> (Result<Picture, FileError>, Option<(Source, ReadOptions)>) {
    let options = read_options(request, name);
    if source.path.as_path() == Path::new(STANDARD) {
        return (read_standard_input(options), None);
    }
    match read_within(source, options) {
        Err(error) if error.kind == ErrorKind::TooLarge && can_stream(request, name) => {
            // Of other formats, and of an EXR file that is refused for another reason, the error is the same again.
            let read = read_within(source, ReadOptions { rows: Some([0, 1]), ..options });
            (read, Some((source.clone(), options)))
        }
        read => (read, None),
    }
}

fn input_picture(
    request: &Request<'_>,
    (name, source): (&str, &Source),
    read: Result<Picture, FileError>,
    streamed: Option<(Source, ReadOptions)>,
    is_missing: bool,
    sizes: &mut Sizes,
) -> Result<InputPicture, Failure> {
    let input = request.inputs.iter().find(|input| input.name == name);
    let mut picture = read.map_err(|error| {
        let is_pipeline = source.path.is_file() && source.path.extension().is_some_and(|ending| ending == "ron");
        match is_pipeline {
            true => Failure::user(format!("`{}` is a pipeline, not an image", source.path.display()))
                .hint("a run has one pipeline, the first file; `extends` and `Pipeline(file: ...)` combine several"),
            false => error.into(),
        }
    })?;
    #[cfg(feature = "ocio")]
    if let Some(space) = input.and_then(|input| request.args.reading.config_space_of(input)) {
        picture = crate::ocio::to_linear(picture, space)?;
    }
    if is_missing && request.args.reading.missing == MissingFrames::Black {
        picture = black(&picture);
    }
    let is_volume = input.is_some_and(|input| input.volume);
    if let Some(share) = request.args.reading.scale.filter(|_| !is_volume) {
        picture = picture.scaled_by(share);
    }
    let own = (picture.width, streamed.as_ref().map_or(picture.height, |_| picture.whole_height()));
    let size = *sizes.entry(name.to_owned()).or_insert(own);
    if size != own {
        picture = in_size(source, &picture, size, request.args.reading.resize)?;
    }
    let signedness = input.map_or(Signedness::Unsigned, |input| input.state.signedness());
    let lacks_alpha = input.is_some_and(|input| input.needs_alpha) && streamed.is_none() && is_opaque(&picture);
    let repairs = if streamed.is_none() { Repairs::of(&picture, signedness) } else { Repairs::default() };
    let desc = match is_volume {
        true => volume(name, picture.desc(), request.args.slices)?,
        false if streamed.is_some() => picture.desc().sized(Size::new(own.0, own.1)),
        false => picture.desc(),
    };
    let (name, file) = (name.to_owned(), source.path.clone());
    Ok(InputPicture { name, file, picture, desc, repairs, streamed, signedness, lacks_alpha })
}

/// True if the image of an input may be read in bands: it stays as the file has it.
fn can_stream(request: &Request<'_>, name: &str) -> bool {
    let input = request.inputs.iter().find(|input| input.name == name);
    #[cfg(feature = "ocio")]
    if input.is_some_and(|input| request.args.reading.config_space_of(input).is_some()) {
        return false;
    }
    request.args.reading.scale.is_none()
        && request.jobs.len() == 1
        && input.is_some_and(|input| !input.volume)
        && !request.is_measuring()
}

/// A black picture of the same size.
fn black(picture: &Picture) -> Picture {
    let count = picture.pixels.len();
    let pixels = match picture.pixels {
        Pixels::Half(_) => Pixels::Half(vec![half::f16::ZERO; count]),
        Pixels::Float(_) => Pixels::Float(vec![0.0; count]),
    };
    Picture { meta: picture.meta.clone(), ..Picture::new(picture.width, picture.height, pixels) }
}

/// A frame of another size than the first one, in that size.
fn in_size(
    source: &Source,
    picture: &Picture,
    (width, height): (u32, u32),
    how: OtherSize,
) -> Result<Picture, Failure> {
    let (file, own) = (source.path.display(), format!("{}x{}", picture.width, picture.height));
    match how {
        OtherSize::Error => {
            Err(Failure::user(format!("{file}: this frame has {own} pixels, and the first one has {width}x{height}"))
                .hint("`--resize fit` scales it"))
        }
        OtherSize::Fit => {
            let mut fitted = picture.fitted(width, height);
            fitted.notes.push(format!("{file}: {own} pixels are scaled into {width}x{height}"));
            Ok(fitted)
        }
    }
}

/// Options of reading the files of an input.
pub(super) fn read_options(request: &Request<'_>, name: &str) -> ReadOptions {
    let input = request.inputs.iter().find(|input| input.name == name);
    request.args.reading.options_for(request.args.images.budget(), input)
}

/// Refuses the color space of an input that the pipeline does not have.
pub(super) fn check_spaces(request: &Request<'_>) -> Result<(), Failure> {
    #[cfg(feature = "ocio")]
    request.args.reading.config_spaces().try_for_each(crate::ocio::check_space)?;
    let names: Vec<&str> = request.inputs.iter().map(|input| input.name.as_str()).collect();
    let mut given = request.args.reading.input_space.iter().filter_map(|space| space.input.as_deref());
    match given.find(|name| !names.contains(name)) {
        None => Ok(()),
        Some(name) => Err(Failure::user(format!("`--input-space`: the pipeline has no input `{name}`"))
            .hint(format!("it has `{}`", names.join("`, `")))),
    }
}

/// The volume whose slices an image has one below the other.
pub(crate) fn volume(name: &str, desc: ImageDesc, slices: Option<u32>) -> Result<ImageDesc, Failure> {
    let Some(slices) = slices else {
        return Err(Failure::user(format!("input `{name}` is a volume, and the image does not say how deep"))
            .hint("state the number of slices, which lie one below the other: `--slices 64`"));
    };
    let Size { width, height, .. } = desc.size;
    if !height.is_multiple_of(slices) {
        return Err(Failure::user(format!(
            "input `{name}`: the image has {height} rows, which {slices} slices do not divide"
        ))
        .hint("all slices have the same number of rows"));
    }
    Ok(ImageDesc::volume(Size::volume(width, height / slices, slices)).format(desc.format))
}
