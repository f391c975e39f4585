//! The images and frames that `render` makes, and the files that they are made from.

use std::collections::BTreeSet;

use afterimage::offline::quantize::{EncodedFile, unquantized, with_codes};
use afterimage_gpu::{FrameKind, FrameStep};
use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::image::Size;
use afterimage_graph::node::BlockData;
use afterimage_media::film::{Sound, Timeline};
use afterimage_media::sequence;
use afterimage_nodes::DemoScene;

use super::jobs::{Films, Job, NumberedFiles, films, with_inputs, without_inputs};
use super::metered::{Metered, MeteredFrame};
use super::target::Target;
use crate::args::RenderArgs;
use crate::cameras::{is_camera, is_eye, scene, scene_camera};
use crate::failure::Failure;
use crate::terminal::note;

/// A run of `render`, from the command line and the pipeline's graph.
pub(super) struct Request<'a> {
    /// The command line.
    pub(super) args: &'a RenderArgs,
    /// The files, and the output that each of them takes.
    pub(super) targets: Vec<Target>,
    /// The frames in order.
    pub(super) jobs: Vec<Job>,
    /// The frames that begin a new shot.
    pub(super) cuts: BTreeSet<u32>,
    /// The pipeline's inputs.
    pub(super) inputs: Vec<GraphInput>,
    /// The frame of the sequence before the first one that is rendered, if there is one.
    pub(super) earlier: Option<u32>,
    /// The measurements of the frames before the first one that is rendered.
    pub(super) measured: Vec<MeteredFrame>,
    /// The films among the images of inputs.
    pub(super) films: Films,
    /// The files of all frames.
    files: NumberedFiles,
    /// The frames that are left out because their files exist.
    pub(super) skipped: Vec<Job>,
    /// The built-in scene, if the pipeline has it: its camera is that of inputs without a file.
    scene: Option<DemoScene>,
}

/// The most frames from which a frame may follow: as many as `--frames` may name. The numbers in the files of `--meter`
/// come from anywhere.
const MOST_MEASURED: usize = 1_000_000;

impl<'a> Request<'a> {
    /// `named_inputs` are the files of `--input`, by the name of the input.
    pub(super) fn new(
        args: &'a RenderArgs,
        targets: Vec<Target>,
        graph: &Graph,
        named_inputs: Vec<(String, String)>,
    ) -> Result<Self, Failure> {
        let files = input_files(args, graph, named_inputs)?;
        let is_volume =
            |(name, _): &(String, String)| graph.inputs.iter().any(|input| input.name == *name && input.volume);
        if args.slices.is_some() && !files.iter().any(is_volume) {
            return Err(Failure::user("`--slices` is for images of volumes, and none is given").hint("leave it out"));
        }
        let gives_size = |(name, _): &(String, String)| graph.inputs.iter().any(|i| i.name == *name && is_picture(i));
        if args.size.is_some() && files.iter().any(gives_size) {
            return Err(idle_size());
        }
        let films = films(&files)?;
        note_bits(&films, &targets);
        let numbered = NumberedFiles::new(&files, args.reading.missing, &films)?;
        let mut jobs = match files.is_empty() {
            true => without_inputs(args, &targets),
            false => with_inputs(args, files, &films, &targets),
        }?;
        let cuts = cuts(args, &jobs, &numbered)?;
        check_is_sequence(args, &jobs)?;
        let step = frame_step(&jobs);
        let earlier = numbered.roll_back(&mut jobs, args.preroll, step, &cuts);
        let (inputs, scene) = (graph.inputs.clone(), scene(graph));
        let (measured, skipped, files) = (Vec::new(), Vec::new(), numbered);
        Ok(Self { args, targets, jobs, cuts, inputs, earlier, measured, films, files, skipped, scene })
    }

    /// Begins with the state that follows from what was measured in the frames before, and renders so many of them at
    /// least.
    pub(super) fn continue_measured(&mut self, measured: Metered, least: u32) -> Result<(), Failure> {
        let step = frame_step(&self.jobs).or(measured.step());
        self.files.start = measured.first();
        let rolled = self.jobs.iter().take_while(|job| !job.is_written).count() as u32;
        let earlier = self.files.roll_back(&mut self.jobs, least.saturating_sub(rolled), step, &self.cuts);
        self.earlier = earlier;
        let before = earlier.map(|earlier| self.files.jobs_before(earlier, step, &self.cuts));
        let before = before.into_iter().flatten().filter_map(|job| job.frame);
        let mut needed: Vec<u32> = earlier.into_iter().chain(before).take(MOST_MEASURED + 1).collect();
        if needed.len() > MOST_MEASURED {
            let first = self.jobs.first().and_then(|job| job.frame).unwrap_or(0);
            return Err(Failure::user(format!("frame {first} follows from more than {MOST_MEASURED} frames"))
                .hint("`--cut` names frames that begin anew"));
        }
        needed.reverse();
        let first = self.jobs.first().and_then(|job| job.frame).unwrap_or(0);
        self.measured = measured.take(&needed, first)?;
        Ok(())
    }

    /// The position of a frame in time after the frame `last`. It begins anew if it is a cut, or if `begins_shot`.
    pub(super) fn step(&self, frame: u32, last: Option<u32>, begins_shot: bool) -> FrameStep {
        let fps = self.args.fps;
        let (time, dt) = match self.films.values().next() {
            Some(film) => {
                let seconds = |frame: u32| film.times.seconds(frame.saturating_sub(1) as usize);
                (seconds(frame), last.map_or(0.0, |before| (seconds(frame) - seconds(before)).max(0.0) as f32))
            }
            None => {
                let dt = last.map_or(0.0, |before| frame.saturating_sub(before) as f32 / fps);
                (f64::from(frame) / f64::from(fps), dt)
            }
        };
        FrameStep { time, dt, kind: FrameKind::cut_if(begins_shot || self.cuts.contains(&frame)) }
    }

    /// The numbers of the frames that are written.
    fn written(&self) -> impl Iterator<Item = u32> {
        self.jobs.iter().filter(|job| job.is_written).filter_map(|job| job.frame)
    }

    /// The times of the frames of a film that is written, and the film whose sound it has.
    pub(super) fn timeline(&self) -> (Timeline, Option<Sound>) {
        let index = |frame: u32| frame.saturating_sub(1) as usize;
        let (first, last) = (self.written().next().unwrap_or(1), self.written().last().unwrap_or(1));
        match self.films.values().next() {
            Some(film) => {
                let sound = Sound::of(film, index(first), index(last));
                (film.times.of_frames(self.written().map(index)), Some(sound))
            }
            None => {
                let all = Timeline::of_rate(self.args.fps.into(), (last - first) as usize + 1);
                (all.of_frames(self.written().map(|frame| (frame - first) as usize)), None)
            }
        }
    }

    /// The index of a job among those that are written.
    pub(super) fn index_in_film(&self, index: usize) -> usize {
        self.jobs[..index].iter().filter(|job| job.is_written).count()
    }

    /// The number of the frame of a job, from which noise is made.
    pub(super) fn number(&self, job: &Job) -> u32 {
        self.args.captured.or(job.frame).unwrap_or(0)
    }

    /// The files of the frame before the first one, if its state is known.
    pub(super) fn job_before(&self) -> Option<Job> {
        let is_known = self.is_measuring() || !self.measured.is_empty();
        self.files.job(self.earlier.filter(|_| is_known)?)
    }

    /// True if an input is a camera.
    pub(super) fn has_camera(&self, name: &str) -> bool {
        self.inputs.iter().any(|input| input.name == name && is_camera(input))
    }

    /// True if frames are measured, and nothing is rendered.
    pub(super) fn is_measuring(&self) -> bool {
        self.targets.is_empty()
    }

    /// True if a frame begins a new shot.
    pub(super) fn is_cut(&self, job: &Job) -> bool {
        job.frame.is_some_and(|frame| self.cuts.contains(&frame))
    }

    /// Leaves frames out that are done. Where later frames need their state, they are rendered and not written.
    pub(super) fn skip(&mut self, done: &[bool], has_state: bool) {
        let jobs = std::mem::take(&mut self.jobs).into_iter().zip(done);
        if !has_state {
            let (skipped, jobs): (Vec<_>, Vec<_>) = jobs.partition(|(_, is_done)| **is_done);
            self.skipped = skipped.into_iter().map(|(job, _)| job).collect();
            self.jobs = jobs.into_iter().map(|(job, _)| job).collect();
            return;
        }
        let mut kept = Vec::new();
        for (mut job, is_done) in jobs {
            if *is_done {
                job.is_written = false;
                let (frame, out) = (job.frame, job.out.clone());
                self.skipped.push(Job { sources: Vec::new(), frame, out, is_written: false, missing: Vec::new() });
            }
            kept.push(job);
        }
        let mut jobs = kept;
        let needed = jobs.iter().rposition(|job| job.is_written).map_or(0, |last| last.saturating_add(1));
        jobs.truncate(needed);
        self.jobs = jobs;
    }

    /// The camera of the built-in scene for the input `camera`, if no file gives another, for an image of this size.
    pub(super) fn scene_cameras(&self, size: Size) -> impl Iterator<Item = (String, BlockData)> {
        let free = self.inputs.iter().filter(|input| is_eye(input) && !self.files.has(&input.name));
        let cameras = self.scene.as_ref().map(|scene| free.map(move |input| (scene, input)));
        cameras.into_iter().flatten().map(move |(scene, input)| (input.name.clone(), scene_camera(scene, size)))
    }

    /// The graph as it is rendered for the files: with their outputs only, and without the quantization that the writer
    /// does.
    pub(super) fn prepare(&mut self, mut graph: Graph) -> Graph {
        let takes = |target: &Target, name: &str| target.output == name || target.gain_map.as_deref() == Some(name);
        graph.outputs.retain(|output| self.targets.iter().any(|target| takes(target, &output.name)));
        let mut files = Vec::new();
        for target in self.targets.iter().filter(|target| target.saving.encoding.has_codes()) {
            let of_map = target.gain_map.iter().map(|name| (name, 16));
            for (output, bits) in [(&target.output, target.saving.encoding.bits)].into_iter().chain(of_map) {
                let source = graph.outputs.iter().find(|known| known.name == *output).map(|output| output.source);
                files.extend(source.map(|source| EncodedFile { source, bits }));
            }
        }
        if self.args.captured.is_some() {
            return with_codes(graph, &files);
        }
        let unquantized = unquantized(graph, &files, self.args.depth.is_some());
        self.targets.iter_mut().for_each(|target| target.saving.noise = unquantized.noise);
        unquantized.notes.iter().for_each(|text| note(&format!("note: {text}")));
        unquantized.graph
    }
}

/// Tells that a film has more bits than the one that is made of it.
fn note_bits(films: &Films, targets: &[Target]) {
    let made = targets.iter().filter_map(|target| Some((&target.file, target.film.as_ref()?.preset)));
    for (file, preset) in made {
        if let Some((name, film)) = films.iter().find(|(_, film)| film.bits > preset.bits) {
            let (bits, from) = (preset.bits, film.bits);
            note(&format!(
                "note: the film of input `{name}` has {from} bits, and `{file}` has the {bits} of {}",
                preset.name
            ));
        }
    }
}

/// The frames of `--cut`. Each must be a frame of the sequence, which may be longer than the range that is rendered.
fn cuts(args: &RenderArgs, jobs: &[Job], files: &NumberedFiles) -> Result<BTreeSet<u32>, Failure> {
    let Some(text) = &args.cut else { return Ok(BTreeSet::new()) };
    let cuts = sequence::parse_frames("--cut", text)?;
    let frames: BTreeSet<u32> = jobs.iter().filter_map(|job| job.frame).collect();
    let is_known = |cut: u32| frames.contains(&cut) || files.job(cut).is_some();
    let is_missing = |cut: &&u32| frames.is_empty() || !is_known(**cut);
    match cuts.iter().find(is_missing) {
        None => Ok(cuts.into_iter().collect()),
        Some(cut) => Err(Failure::user(format!("`--cut`: the sequence has no frame {cut}"))
            .hint("a cut is a frame that is rendered, as `--frames` or the files name it")),
    }
}

/// Refuses options about earlier frames where there is one image.
fn check_is_sequence(args: &RenderArgs, jobs: &[Job]) -> Result<(), Failure> {
    let is_used = args.preroll > 0 || args.meter.is_some();
    if is_used && jobs.first().is_none_or(|job| job.frame.is_none()) {
        return Err(Failure::user("`--meter` and `--preroll` are for sequences, and this is one image")
            .hint("name a sequence: `shot.####.exr`, or frames: `--frames 1-48`"));
    }
    Ok(())
}

/// The distance of the first two frames; `None` for one frame.
fn frame_step(jobs: &[Job]) -> Option<u32> {
    let numbers: Vec<u32> = jobs.iter().take(2).filter_map(|job| job.frame).collect();
    if let [first, second] = numbers[..] { Some(second.saturating_sub(first).max(1)) } else { None }
}

fn idle_size() -> Failure {
    Failure::user("`--size` is for pipelines without an input image; here the output has the size of the input")
        .hint("leave it out, or scale the input")
}

/// True if an input is an image of the size of the output, and neither a volume nor a block.
pub(super) fn is_picture(input: &GraphInput) -> bool {
    input.block.is_none() && !input.volume
}

/// The files that the command line gives to the pipeline's inputs; `files` are those with a name.
fn input_files(
    args: &RenderArgs,
    graph: &Graph,
    mut files: Vec<(String, String)>,
) -> Result<Vec<(String, String)>, Failure> {
    check_input_names(graph, &files)?;
    let given = |name: &str, files: &[(String, String)]| files.iter().any(|(known, _)| known == name);
    if let Some(file) = &args.input {
        let is_free = |input: &&GraphInput| is_picture(input) && !given(&input.name, &files);
        let free = graph.inputs.iter().find(is_free).ok_or_else(no_further_input)?;
        files.insert(0, (free.name.clone(), file.clone()));
    }
    let has_scene = scene(graph).is_some();
    let is_given = |input: &GraphInput| given(&input.name, &files) || is_eye(input) && has_scene;
    match graph.inputs.iter().find(|input| !input.optional && !is_given(input)) {
        None => Ok(files),
        Some(input) if is_camera(input) => Err(missing_camera(&input.name)),
        Some(input) => Err(missing_input(&input.name)),
    }
}

/// Refuses files for inputs that the pipeline does not have.
pub(crate) fn check_input_names(graph: &Graph, files: &[(String, String)]) -> Result<(), Failure> {
    let known: Vec<&str> = graph.inputs.iter().map(|input| input.name.as_str()).collect();
    match files.iter().find(|(name, _)| !known.contains(&name.as_str())) {
        Some((name, _)) => Err(unknown_input(name, &known)),
        None => Ok(()),
    }
}

fn unknown_input(name: &str, known: &[&str]) -> Failure {
    let hint = if known.is_empty() { "it has none".into() } else { format!("it has `{}`", known.join("`, `")) };
    Failure::user(format!("the pipeline has no input `{name}`")).hint(hint)
}

fn no_further_input() -> Failure {
    Failure::user("the pipeline takes no further image").hint("leave the input file out")
}

fn missing_camera(name: &str) -> Failure {
    Failure::user(format!("the pipeline needs a camera for its input `{name}`"))
        .hint(format!("name a JSON file with its matrices, or an EXR file that states them: `--input {name}=FILE`"))
}

fn missing_input(name: &str) -> Failure {
    Failure::user(format!("the pipeline needs an image for its input `{name}`"))
        .hint(format!("name a file after the pipeline, or `--input {name}=FILE`"))
}
