//! The middle stage of `render`: frames are rendered in order.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::Instant;

use afterimage_gpu::{FrameStep, InputImage, Session, Texels};
use afterimage_graph::image::{ColorState, Size};
use afterimage_media::Alpha;
use afterimage_plan::PlanOutput;

use super::read::{InputPicture, Inputs, Read};
use super::readings::{FrameReport, read_meters};
use super::repairs::{Repairs, is_opaque};
use super::request::Request;
use super::target::Target;
use super::times::Times;
use super::write::Rendered;
use crate::args::AlphaChoice;
use crate::device::CachedSession;
use crate::failure::Failure;
use crate::save::FileFormat;
use crate::terminal::note;

/// Renders what is read. The device is freed while the last image is written.
pub(super) fn render_all(
    request: &Request<'_>,
    session: CachedSession,
    meters: Vec<String>,
    from: Receiver<Read>,
    to: SyncSender<Rendered>,
) -> Result<(Times, Vec<FrameReport>), Failure> {
    let mut frames =
        Frames { request, session, meters, said: Vec::new(), times: Times::default(), reports: Vec::new() };
    for (index, inputs) in from.iter().enumerate() {
        let rendered = frames.render(index, inputs?)?;
        // A writer that is gone has failed and reports the error.
        if rendered.into_iter().any(|image| to.send(image).is_err()) {
            break;
        }
    }
    // Everything is rendered: the writers may end before the device is freed.
    drop(to);
    Ok((frames.times, frames.reports))
}

/// The frames that are rendered one after another.
struct Frames<'a> {
    request: &'a Request<'a>,
    session: CachedSession,
    /// The nodes whose exposure is reported.
    meters: Vec<String>,
    /// The notes of images that are printed already.
    said: Vec<String>,
    times: Times,
    reports: Vec<FrameReport>,
}

impl Frames<'_> {
    /// An image for each target.
    fn render(&mut self, index: usize, Inputs { pictures, blocks }: Inputs) -> Result<Vec<Rendered>, Failure> {
        self.say_notes(index, &pictures);
        let start = Instant::now();
        let step = step(self.request, index);
        let session = &mut self.session.session;
        let images = feed(session, &pictures)?;
        let size = size(self.request, &images);
        let blocks = blocks.into_iter().chain(self.request.scene_cameras(size));
        blocks.for_each(|(name, data)| session.set_block(&name, data));
        session.render(size, &images, step)?;
        let repaired = pictures.iter().map(|input| (input.name.clone(), input.repairs)).collect();
        // The images are uploaded: their memory is freed while the GPU works.
        let meta = pictures.into_iter().next().map(|input| input.picture.meta);
        let rendered = self.request.targets.iter().enumerate();
        let rendered = rendered.map(|(target, file)| {
            let (output, texels) = picture(session, file)?;
            Ok(Rendered { texels, output, meta: meta.clone(), index, target })
        });
        let rendered = rendered.collect::<Result<Vec<_>, Failure>>()?;
        self.times.render += start.elapsed();
        self.report(index, repaired)?;
        if index == 0 {
            self.after_first(size, &images)?;
        }
        Ok(rendered)
    }

    fn say_notes(&mut self, index: usize, pictures: &[InputPicture]) {
        let lacking = pictures.iter().filter(|input| input.lacks_alpha).map(lacking_alpha);
        let notes = pictures.iter().flat_map(|input| &input.picture.notes).map(|text| format!("note: {text}"));
        let dropped = if index == 0 { dropped_alpha(self.request, pictures) } else { None };
        for text in lacking.chain(notes).chain(dropped) {
            if !self.said.contains(&text) {
                note(&text);
                self.said.push(text);
            }
        }
    }

    fn report(&mut self, index: usize, repaired: BTreeMap<String, Repairs>) -> Result<(), Failure> {
        let exposure = read_meters(&self.session.session, &self.meters)?;
        let job = &self.request.jobs[index];
        self.reports.push(FrameReport { frame: job.frame, files: job.out.clone(), exposure, repaired });
        Ok(())
    }

    fn after_first(&mut self, size: Size, images: &[InputImage]) -> Result<(), Failure> {
        match self.session.session.kernel_faults(size, images) {
            Ok(faults) => faults.iter().for_each(|faults| note(&format!("warning: {faults}"))),
            // A device without memory for both plans renders, and nothing is counted.
            Err(error) => note(&format!("note: the kinds of `--nodes` are not searched for NaN: {error}")),
        }
        if self.request.args.timings {
            self.times.passes = time_passes(&mut self.session.session, images)?;
        }
        self.session.keep_pipelines();
        Ok(())
    }
}

/// The warning about an image that is opaque where the pipeline needs a mask.
fn lacking_alpha(input: &InputPicture) -> String {
    let name = &input.name;
    format!(
        "warning: the alpha of the image for input `{name}` is 1 everywhere, but the pipeline uses it as a mask: it \
         selects the whole image"
    )
}

/// The note about an alpha that no file has: it may be a mask, or coverage that the pipeline does not declare.
fn dropped_alpha(request: &Request<'_>, pictures: &[InputPicture]) -> Option<String> {
    let is_dropped = |target: &&Target| target.saving.format == FileFormat::Png && target.saving.alpha == Alpha::Drop;
    let target = request.targets.iter().filter(|_| request.args.alpha == AlphaChoice::Auto).find(is_dropped)?;
    let may_be_coverage = |picture: &&InputPicture| {
        let input = request.inputs.iter().find(|input| input.name == picture.name);
        input.is_some_and(|input| input.state != ColorState::Data && !input.needs_alpha)
    };
    let input = pictures.iter().filter(may_be_coverage).find(|input| !is_opaque(&input.picture))?;
    let (input, output) = (input.file.display(), &target.file);
    Some(format!(
        "note: `{output}` is opaque: the alpha of `{input}` may be a mask. `--alpha keep` writes alpha, and so does \
         `alpha: Coverage` of an output"
    ))
}

/// The position of a frame of a sequence in time, by its number.
fn step(request: &Request<'_>, index: usize) -> FrameStep {
    let (jobs, fps) = (&request.jobs, request.args.fps);
    let frames = jobs[index].frame.zip(index.checked_sub(1).and_then(|i| jobs[i].frame));
    let dt = frames.map_or(0.0, |(now, before)| now.saturating_sub(before) as f32 / fps);
    let time = jobs[index].frame.map_or(0.0, |frame| frame as f32 / fps);
    let is_cut = jobs[index].frame.is_some_and(|frame| request.cuts.contains(&frame));
    FrameStep { time, dt, reset: index == 0 || is_cut }
}

/// Uploads the images of a frame.
fn feed(session: &mut Session, pictures: &[InputPicture]) -> Result<Vec<InputImage>, Failure> {
    let mut images = Vec::new();
    for InputPicture { name, file, picture, desc, .. } in pictures {
        let fits = session.gpu().check_fits(*desc);
        fits.map_err(|error| Failure::from(error).at(file))?;
        images.push(session.feed(name, *desc, picture.bytes())?);
    }
    Ok(images)
}

/// The size of the first image that is no volume; that of the command line without images.
fn size(request: &Request<'_>, images: &[InputImage]) -> Size {
    let (width, height) = request.args.size.unwrap_or((1920, 1080));
    let first = images.iter().find(|image| !image.desc.volume);
    first.map_or(Size::new(width, height), |image| image.desc.size)
}

/// The output for the file, and its texels.
fn picture(session: &mut Session, target: &Target) -> Result<(PlanOutput, Texels), Failure> {
    let output = session.plan().output(Some(&target.output)).expect("the graph has this output").clone();
    let texels = session.output(&output.name)?;
    Ok((output, texels))
}

/// GPU milliseconds of each pass, from a second rendering of the first frame.
fn time_passes(session: &mut Session, images: &[InputImage]) -> Result<Vec<(String, f64)>, Failure> {
    let times = session.pass_times_once(images, FrameStep::FIRST)?;
    let passes = session.plan().work();
    Ok(passes.map(|pass| pass.label.clone()).zip(times).collect())
}
