//! The middle stage of `render`: frames are rendered in order.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use afterimage::offline::{Session, faults, frame_size, metering, timing};
use afterimage_gpu::{FrameKind, FrameStep, Gpu, GpuError, InputImage, Texels};
use afterimage_graph::image::{ColorState, ImageDesc, Size};
use afterimage_media::{Alpha, Encoding, ImageFormat, Repairs, is_opaque};
use afterimage_plan::{Plan, PlanOutput};

use super::bands;
use super::metered::{MeasuringPlan, has_meter, names, unmetered};
use super::read::{InputPicture, Inputs, Read};
use super::readings::{FrameReport, Outcome, Reading, Report, read_meters, value_of};
use super::request::Request;
use super::target::Target;
use super::times::Times;
use super::watch_cache::{CachedPictures, Repetition};
use super::write::Rendered;
use crate::args::AlphaChoice;
use crate::device::keep_pipelines;
use crate::failure::Failure;
use crate::pipeline::assignments;
use crate::terminal::note;

/// Renders the frames that are read.
pub(super) fn render_all(
    request: &Request<'_>,
    session: &mut Session,
    meters: Vec<String>,
    repetition: &mut Repetition,
    from: Receiver<Read>,
    to: SyncSender<Rendered>,
    report: &mut Report,
) -> Result<Times, Failure> {
    let info = session.gpu().adapter.get_info();
    report.adapter = Some([info.name, format!("{} {}", info.driver, info.driver_info).trim().to_owned()]);
    let mut frames = Frames {
        request,
        session,
        meters,
        repetition,
        printed: Vec::new(),
        times: Times::default(),
        has_begun: false,
        begins_shot: true,
        last: None,
        report,
    };
    for (index, inputs) in from.iter().enumerate() {
        let rendered = match inputs.and_then(|inputs| frames.render(index, inputs)) {
            Ok(rendered) => rendered,
            Err(failure) => {
                frames.note_failure(index, &failure);
                if !request.args.keep_going || failure.status() != 1 {
                    return Err(failure);
                }
                failure.print();
                continue;
            }
        };
        // A writer that is gone has failed and reports the error.
        if rendered.into_iter().any(|image| to.send(image).is_err()) {
            break;
        }
    }
    // All frames are rendered: the writers may end.
    drop(to);
    Ok(frames.times)
}

/// The frames that are rendered one after another.
struct Frames<'a> {
    request: &'a Request<'a>,
    session: &'a mut Session,
    /// The nodes whose exposure is reported.
    meters: Vec<String>,
    repetition: &'a mut Repetition,
    /// The notes of images that are printed already.
    printed: Vec<String>,
    times: Times,
    /// True if a frame was rendered.
    has_begun: bool,
    /// True if the next frame follows none: it is the first, or a cut that could not be rendered was before it.
    begins_shot: bool,
    /// The number of the frame that was rendered last, or measured.
    last: Option<u32>,
    report: &'a mut Report,
}

impl Frames<'_> {
    /// Makes the parameters of `--set` dynamic, as those of a host with handles are: their nodes also run where they
    /// change nothing.
    fn make_dynamic(&mut self) -> Result<(), Failure> {
        for (name, _) in assignments(&self.request.args.options.sets, "--set")? {
            // A switched node is no parameter.
            _ = self.session.post().control(&name);
        }
        Ok(())
    }

    /// An image for each target; none for a frame that is not written.
    fn render(&mut self, index: usize, inputs: Inputs) -> Result<Vec<Rendered>, Failure> {
        let Inputs { pictures, blocks } = inputs;
        let job = &self.request.jobs[index];
        self.print_notes(&pictures);
        check_rows(self.session.gpu(), &pictures)?;
        let start = Instant::now();
        let size = size(self.request, pictures.iter().map(|input| input.desc));
        let has_camera = !blocks.is_empty();
        let blocks = blocks.into_iter().chain(self.request.scene_cameras(size));
        blocks.for_each(|(name, data)| self.session.set_block(&name, data));
        let given: Vec<_> = pictures.iter().map(|input| (input.name.as_str(), input.desc)).collect();
        if let Some(plan) = self.plan_of_bands(size, &given, &pictures)? {
            return self.render_in_bands(index, &plan, &pictures, start);
        }
        let uploaded = self.repetition.uploaded.take();
        let is_repeated = uploaded.is_some();
        let images = uploaded.map_or_else(|| feed(self.session, &pictures), Ok)?;
        if !self.has_begun {
            if self.request.args.captured.is_some() {
                self.make_dynamic()?;
            }
            self.begin(size, &images)?;
        }
        let mut step = self.request.step(job.frame.unwrap_or(0), self.last, self.begins_shot);
        let can_be_repeated = self.can_be_repeated(has_camera);
        let session = &mut *self.session;
        if is_repeated {
            step.kind = FrameKind::Redraw;
        } else {
            session.number_next(self.request.number(job));
        }
        session.render(size, &images, step)?;
        (self.begins_shot, self.last) = (false, job.frame);
        let repaired = pictures.iter().map(|input| (input.name.clone(), input.repairs)).collect();
        let meta = pictures.first().map(|input| input.picture.meta.clone());
        // The images are uploaded: their memory is freed while the GPU works.
        let inputs = &self.request.inputs;
        self.repetition.pictures =
            can_be_repeated.then(|| CachedPictures { inputs: inputs.clone(), pictures, images: images.clone() });
        let rendered = self.request.targets.iter().enumerate().filter(|_| job.is_written);
        let rendered = rendered.map(|(target, file)| {
            let (output, texels) = read_output(session, &file.output)?;
            let hdr = file.gain_map.as_ref().map(|name| read_output(session, name)).transpose()?;
            let texels = match self.request.args.crop {
                Some(_) => bands::part(self.request, texels)?,
                None => texels,
            };
            Ok(Rendered { texels: Some(texels), hdr, output, meta: meta.clone(), index, target })
        });
        let rendered = rendered.collect::<Result<Vec<_>, Failure>>()?;
        let taken = start.elapsed();
        self.times.render += taken;
        if job.is_written {
            let exposure = read_meters(self.session, &self.meters)?;
            self.report(index, exposure, repaired, taken);
        }
        if !self.has_begun {
            self.has_begun = true;
            self.after_first(size, &images)?;
        }
        if index + 1 == self.request.jobs.len() && self.request.args.timings {
            self.times.passes = self.time_passes(&images)?;
        }
        Ok(rendered)
    }

    /// The plan of a frame that is larger than the device, or of a part of one that leaves no state for the next: then
    /// only the rows of that part are computed. `None` for a frame that is rendered whole.
    fn plan_of_bands(
        &mut self,
        size: Size,
        given: &[(&str, ImageDesc)],
        pictures: &[InputPicture],
    ) -> Result<Option<Plan>, Failure> {
        let session = &mut *self.session;
        let is_large = pictures.iter().any(|input| input.streamed.is_some()) || session.needs_bands(size, given)?;
        if !is_large && self.request.args.crop.is_none() {
            return Ok(None);
        }
        let plan = session.plan_in_bands(size, given)?;
        Ok((is_large || bands::is_free(self.request, &plan)).then_some(plan))
    }

    /// True if the next run can redraw this frame: it is the only one, and its images are cached.
    fn can_be_repeated(&self, has_camera: bool) -> bool {
        let args = self.request.args;
        let is_alone = self.request.jobs.len() == 1 && self.request.measured.is_empty();
        self.repetition.keeps && is_alone && !has_camera && !args.timings
    }

    /// Renders a frame that is larger than the device.
    fn render_in_bands(
        &mut self,
        index: usize,
        plan: &Plan,
        pictures: &[InputPicture],
        start: Instant,
    ) -> Result<Vec<Rendered>, Failure> {
        let job = &self.request.jobs[index];
        if self.request.targets.iter().any(|target| target.gain_map.is_some()) {
            return Err(Failure::machine("a picture that is larger than the device has no gain map")
                .hint("leave `--gain-map` out, or allow more memory: `--memory`"));
        }
        self.report.plan = Some(plan.hash().to_string());
        let bands::RenderedBands { outputs, repairs, exposure, read, write } =
            bands::render(self.request, self.session, plan, job, pictures, &self.meters)?;
        let taken = start.elapsed();
        self.times.read += read;
        self.times.write += write;
        self.times.render += taken;
        let names = pictures.iter().map(|input| input.name.clone());
        self.report(index, exposure, names.zip(repairs).collect(), taken);
        let meta = pictures.first().map(|input| input.picture.meta.clone());
        let rendered = outputs.into_iter().enumerate();
        let rendered = rendered.map(|(target, (output, texels))| {
            let meta = meta.clone();
            Rendered { texels, hdr: None, output, meta, index, target }
        });
        Ok(rendered.collect())
    }

    /// Before the first frame: it continues from what was measured, and the user learns which state begins with it.
    fn begin(&mut self, size: Size, images: &[InputImage]) -> Result<(), Failure> {
        let plan = self.session.load(size, images)?.clone();
        self.report.plan = Some(plan.hash().to_string());
        self.integrate(&plan, images)?;
        let rolled = self.request.jobs.iter().take_while(|job| job.out.is_empty()).count() as u32;
        let items: Vec<_> = if self.request.measured.is_empty() { plan.state() } else { unmetered(&plan).collect() };
        let lost: Vec<_> = items.iter().filter(|item| item.reach.is_none_or(|reach| reach > rolled)).collect();
        let Some(earlier) = self.request.earlier.filter(|_| !lost.is_empty()) else { return Ok(()) };
        let names = names(lost);
        match rolled {
            0 => {
                note(&format!(
                    "warning: the sequence has frame {earlier} before the first one here, and this state begins anew: \
                     {names}"
                ));
                note(&format!(
                    "  hint: {}`--preroll COUNT` renders some of them",
                    if has_meter(&plan) { "`--meter FILE` has what `afterimage meter` measured in them; " } else { "" }
                ));
            }
            _ => note(&format!(
                "note: {rolled} frames before the range are rendered; the sequence has more, to which this state \
                 reaches back: {names}"
            )),
        }
        Ok(())
    }

    /// Integrates the measurements of earlier frames into the state.
    fn integrate(&mut self, plan: &Plan, images: &[InputImage]) -> Result<(), Failure> {
        let meters = &plan.metering();
        let measuring = MeasuringPlan::new(plan, meters);
        for measured in &self.request.measured {
            let bytes = measured.for_plan(&measuring)?;
            let step = self.request.step(measured.frame, self.last, self.begins_shot);
            self.session.number_next(measured.frame);
            metering::integrate(self.session, meters, images, step, &bytes)?;
            (self.begins_shot, self.last) = (false, Some(measured.frame));
        }
        // A number that is not finite would stay in the state.
        for meter in self.meters.iter().filter(|_| !self.request.measured.is_empty()) {
            let value = self.session.value(&value_of(meter))?;
            if value.is_some_and(|value| value.iter().any(|number| !number.is_finite())) {
                return Err(Failure::user(format!("`--meter`: `{meter}` makes no exposure of what its files state"))
                    .hint("measure the frames again"));
            }
        }
        Ok(())
    }

    fn note_failure(&mut self, index: usize, failure: &Failure) {
        let job = &self.request.jobs[index];
        self.begins_shot |= self.request.is_cut(job);
        if job.is_written {
            let report = FrameReport::without_picture(job, Outcome::Failed, Some(failure.message()));
            self.report.frames.insert(index, report);
        }
    }

    fn print_notes(&mut self, pictures: &[InputPicture]) {
        let lacking = pictures.iter().filter(|input| input.lacks_alpha).map(lacking_alpha);
        let notes = pictures.iter().flat_map(|input| &input.picture.notes).map(|text| format!("note: {text}"));
        let dropped = if self.has_begun { None } else { dropped_alpha(self.request, pictures) };
        for text in lacking.chain(notes).chain(dropped) {
            if !self.printed.contains(&text) {
                note(&text);
                self.printed.push(text);
            }
        }
    }

    fn report(&mut self, index: usize, exposure: Vec<Reading>, repaired: BTreeMap<String, Repairs>, taken: Duration) {
        let seconds = taken.as_secs_f64();
        let report = FrameReport::without_picture(&self.request.jobs[index], Outcome::Unwritten, None);
        self.report.frames.insert(index, FrameReport { seconds, exposure, repaired, ..report });
    }

    fn after_first(&mut self, size: Size, images: &[InputImage]) -> Result<(), Failure> {
        match faults::kernel_faults(self.session, size, images) {
            Ok(faults) => faults.iter().for_each(|faults| note(&format!("warning: {faults}"))),
            // A device without memory for both plans renders, and nothing is counted.
            Err(error) => note(&format!("note: the kinds of `--nodes` are not searched for NaN: {error}")),
        }
        keep_pipelines(self.session);
        Ok(())
    }

    /// GPU milliseconds of each pass, from a second rendering of the last frame.
    fn time_passes(&mut self, images: &[InputImage]) -> Result<Vec<(String, Option<f64>)>, Failure> {
        let times = timing::pass_times_once(self.session, images, FrameStep::FIRST)?;
        let ms = |pass: usize| times.as_ref().map(|times| times[pass]);
        Ok(self.session.plan().work().enumerate().map(|(number, pass)| (pass.label.clone(), ms(number))).collect())
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
    let is_dropped = |target: &&Target| {
        let Encoding { format, alpha, .. } = target.saving.encoding;
        format == ImageFormat::Png && alpha == Alpha::Drop && target.film.is_none()
    };
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

/// Refuses images of which the device cannot even hold a row, which bands do not help.
fn check_rows(gpu: &Gpu, pictures: &[InputPicture]) -> Result<(), Failure> {
    for InputPicture { file, desc, .. } in pictures {
        let row = desc.sized(Size { height: 1, ..desc.size });
        if gpu.check_fits(row).is_err() {
            gpu.check_fits(*desc).map_err(|error| Failure::from(error).at(file))?;
        }
    }
    Ok(())
}

/// Uploads the images of a frame.
pub(super) fn feed(session: &mut Session, pictures: &[InputPicture]) -> Result<Vec<InputImage>, Failure> {
    let mut images = Vec::new();
    for InputPicture { name, file, picture, desc, .. } in pictures {
        images.push(session.feed(name, *desc, picture.bytes()).map_err(|error| match error {
            GpuError::TooLarge { .. } => Failure::from(error).at(file),
            error => error.into(),
        })?);
    }
    Ok(images)
}

/// The size of the first image that is no volume; that of the command line without images.
pub(super) fn size(request: &Request<'_>, images: impl Iterator<Item = ImageDesc>) -> Size {
    let (width, height) = request.args.size.unwrap_or((1920, 1080));
    frame_size(images).unwrap_or(Size::new(width, height))
}

/// The output of that name, and its texels.
fn read_output(session: &mut Session, name: &str) -> Result<(PlanOutput, Texels), Failure> {
    let output = session.plan().output(Some(name)).expect("the graph has this output").clone();
    let texels = session.output(&output.name)?;
    Ok((output, texels))
}
