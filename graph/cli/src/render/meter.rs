//! `afterimage meter`: frames are measured, in any order and on any machine.

use std::path::PathBuf;
use std::sync::mpsc::sync_channel;

use afterimage::offline::{Session, metering};
use afterimage_gpu::FrameStep;
use afterimage_graph::node::NodeKind;
use afterimage_media::run_files;
use afterimage_media::sequence::Pattern;

use super::frames::{feed, size};
use super::jobs::Job;
use super::metered::{MeteredFrame, no_meter, write_frames};
use super::prepared::{Prepared, prepare};
use super::read::{Inputs, read_all};
use super::readings::{meters, read_meters};
use super::request::Request;
use super::stages::AHEAD;
use crate::args::files::ExrArgs;
use crate::args::meter::MeterArgs;
use crate::args::{AlphaChoice, RenderArgs};
use crate::device::{keep_pipelines, open_for, session};
use crate::failure::Failure;
use crate::process::spawn;
use crate::progress::Bar;
use crate::terminal::note;

pub(crate) fn run(args: &MeterArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let render = render_args(args);
    let Prepared { request, graph, facts, options } = prepare(&render, tables, |_, _| Ok(Vec::new()))?;
    let frames: Vec<u32> = request.jobs.iter().filter_map(|job| job.frame).collect();
    if frames.is_empty() {
        return Err(Failure::user("frames of a sequence are measured, and this is one image")
            .hint("name a sequence: `shot.####.exr`, or frames: `--frames 1-48`"));
    }
    let pattern = Pattern::parse(&args.out)?;
    let path = |frame: u32| pattern.as_ref().map_or_else(|| PathBuf::from(&args.out), |pattern| pattern.at(frame));
    match pattern {
        Some(_) => frames.iter().try_for_each(|frame| run_files::writes(&path(*frame)))?,
        None => run_files::writes(&path(0))?,
    }
    let request = &request;
    let mut measured = Vec::new();
    std::thread::scope(|scope| {
        let (to, from) = sync_channel(AHEAD);
        spawn(scope, "read", move || read_all(request, &to))?;
        let meters = meters(&graph);
        let session = session(&open_for(&args.device, &args.plan)?, graph, facts, options);
        let bar = Bar::of_frames(request.jobs.len() as u64).for_farm(args.openjd);
        let mut measuring = Measuring { request, session, meters, last: request.earlier };
        for (job, inputs) in request.jobs.iter().zip(from) {
            let frame = measuring.measure(job, inputs?)?;
            bar.advance(&format!("frame {}", frame.frame));
            match pattern {
                Some(_) => write_frames(&path(frame.frame), &[frame])?,
                None => measured.push(frame),
            }
        }
        keep_pipelines(&mut measuring.session);
        Ok::<_, Failure>(())
    })?;
    if pattern.is_none() {
        write_frames(&path(0), &measured)?;
    }
    note(&format!("frames: {} measured", frames.len()));
    Ok(())
}

/// A render of these frames, without files.
fn render_args(given: &MeterArgs) -> RenderArgs {
    let mut args = RenderArgs {
        pipeline: given.pipeline.clone(),
        input: given.input.clone(),
        out: None,
        inputs: given.inputs.clone(),
        slices: given.slices,
        outputs: Vec::new(),
        frames: given.frames.clone(),
        cut: given.cut.clone(),
        meter: None,
        preroll: 0,
        keep_going: false,
        skip_existing: false,
        json: None,
        video: None,
        fps: given.fps,
        size: given.size,
        crop: None,
        depth: None,
        no_dither: false,
        captured: None,
        alpha: AlphaChoice::Auto,
        gain_map: None,
        quality: None,
        timings: false,
        watch: false,
        openjd: given.openjd,
        exr: ExrArgs::default(),
        reading: given.reading.clone(),
        images: given.images.clone(),
        options: given.options.clone(),
        plan: given.plan.clone(),
        device: given.device.clone(),
    };
    args.put_in_order();
    args
}

/// The frames that are measured one after another.
struct Measuring<'a> {
    request: &'a Request<'a>,
    session: Session,
    /// The nodes whose exposure is stated.
    meters: Vec<String>,
    /// The number of the frame before, which another run may have measured.
    last: Option<u32>,
}

impl Measuring<'_> {
    fn measure(&mut self, job: &Job, inputs: Inputs) -> Result<MeteredFrame, Failure> {
        let Inputs { pictures, blocks, .. } = inputs;
        let session = &mut self.session;
        let images = feed(session, &pictures)?;
        let size = size(self.request, images.iter().map(|image| image.desc));
        let blocks = blocks.into_iter().chain(self.request.scene_cameras(size));
        blocks.for_each(|(name, data)| session.set_block(&name, data));
        let plan = session.load(size, &images)?.clone();
        let meters = plan.metering();
        if meters.state.is_empty() {
            return Err(no_meter(&plan));
        }
        let frame = job.frame.expect("a sequence is measured");
        let step = self.request.step(frame, self.last, self.last.is_none());
        session.number_next(frame);
        let measured = metering::measure(session, &meters, &images, step)?;
        metering::integrate(session, &meters, &images, FrameStep::FIRST, &measured)?;
        let exposure = serde_json::json!(read_meters(session, &self.meters)?);
        self.last = job.frame;
        Ok(MeteredFrame::new(&plan, &meters, frame, exposure, &measured))
    }
}
