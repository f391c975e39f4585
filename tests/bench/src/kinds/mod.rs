//! The time of each kind on its own, compared with the bandwidth of the device, and with a baseline where there is one.

mod figures;
mod images;
mod subjects;

use std::sync::Arc;
use std::time::Instant;

use afterimage::offline::{Session, timing};
use afterimage_gpu::{Clock, Gpu, InputImage, download};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_graph::node::{CAMERA, NodeKind, Registry};
use afterimage_lab::LabError;
use afterimage_lab::bench::bandwidth;
use afterimage_lab::stress::NODE;
use afterimage_media::catch_panic;
use afterimage_plan::{Options, Plan};

use crate::baselines::{self, Chain};
pub(crate) use figures::KindsReport;
use figures::{BaselineFigures, KindFigures, SizeFigures, SkippedKind, difference};
use images::SceneImages;
use subjects::{KindAlone, alone, is_own, least_bytes, moved_bytes};

/// Measures each kind of these tables on its own, at each of the sizes: with its optional images, without optional
/// values, at its default parameters, and only its main output is read. Images come from the built-in scene and are
/// promised to be finite, as those are that a node before it has made.
///
/// # Errors
/// The device cannot be measured, or the built-in scene not be rendered. A kind that does not run is in the report.
pub(crate) fn kinds(
    gpu: &Gpu,
    registry: &Arc<Registry>,
    tables: &[&[NodeKind]],
    sizes: &[Size],
    samples: u32,
) -> Result<KindsReport, LabError> {
    let clock = Clock::new(gpu)?;
    let (subjects, mut skipped) = alone(registry, tables);
    let copy_gbps = bandwidth(gpu, &clock)?.gbps;
    let mut rows: Vec<KindFigures> = subjects.iter().map(|subject| KindFigures::new(&subject.kind)).collect();
    for size in sizes {
        let images = SceneImages::new(gpu, registry, *size)?;
        let bench = KindBench { gpu, clock: &clock, images: &images, copy_gbps, samples, size: *size };
        for (subject, row) in subjects.iter().zip(&mut rows) {
            let measured = catch_panic(|| bench.measure(subject, row)).map_err(|panic| format!("it panics: {panic}"));
            if let Err(why) = measured.and_then(|measured| measured.map_err(|error| error.to_string())) {
                skipped.push(SkippedKind { kind: subject.kind.clone(), why: format!("at {size}: {why}") });
            }
        }
    }
    rows.retain(|row| !row.sizes.is_empty());
    let info = gpu.adapter.get_info();
    Ok(KindsReport {
        adapter: info.name,
        driver: format!("{} {}", info.driver, info.driver_info),
        clock: clock.source().name(),
        frames: samples,
        copy_gbps,
        kinds: rows,
        skipped,
    })
}

/// The seconds that a driver compiles each kind of these tables, as comma-separated values: what the first frame takes
/// longer than the second. Values that change nothing are replaced.
pub(crate) fn compile(
    gpu: &Gpu,
    registry: &Arc<Registry>,
    tables: &[&[NodeKind]],
    size: Size,
) -> Result<String, LabError> {
    let clock = Clock::new(gpu)?;
    let images = SceneImages::new(gpu, registry, size)?;
    let bench = KindBench { gpu, clock: &clock, images: &images, copy_gbps: 0.0, samples: 1, size };
    let mut text = String::new();
    for subject in alone(registry, tables).0 {
        let line = bench.compile(&subject);
        text += &line.unwrap_or_else(|error| format!("{}: {error}\n", subject.kind));
    }
    Ok(text)
}

/// The same of a session that was loaded since `start`, as a line.
pub(crate) fn compiled(
    session: &mut Session,
    images: &[InputImage],
    name: &str,
    mut start: Instant,
) -> Result<String, LabError> {
    let mut seconds = [0.0; 2];
    for (frame, seconds) in seconds.iter_mut().enumerate() {
        let mut encoder = session.gpu().encoder();
        session.encode(&mut encoder, images, timing::timed_step(frame as u32))?;
        session.gpu().queue.submit([encoder.finish()]);
        session.gpu().wait()?;
        *seconds = start.elapsed().as_secs_f64();
        start = Instant::now();
    }
    let operations = session.plan().passes.iter().map(|planned| planned.pass.compile_cost().operations());
    let (most, all) = (operations.clone().max().unwrap_or(0), operations.sum::<usize>());
    Ok(format!("{name},{most},{all},{:.2}\n", seconds[0] - seconds[1]))
}

/// The conditions of all measurements at one size.
struct KindBench<'a> {
    gpu: &'a Gpu,
    clock: &'a Clock,
    images: &'a SceneImages<'a>,
    copy_gbps: f64,
    samples: u32,
    size: Size,
}

impl KindBench<'_> {
    fn compile(&self, subject: &KindAlone) -> Result<String, LabError> {
        let graph = subject.graph(&subject.changed)?;
        let images = self.images.of(&subject.kind, &graph.inputs)?;
        let start = Instant::now();
        let mut session = self.session(&graph, &images)?;
        compiled(&mut session, &images, &subject.kind, start)
    }

    fn measure(&self, subject: &KindAlone, row: &mut KindFigures) -> Result<(), LabError> {
        let mut graph = subject.graph(&[])?;
        let images = self.images.of(&subject.kind, &graph.inputs)?;
        let mut session = self.session(&graph, &images)?;
        if skips(session.plan()) {
            // Its defaults change nothing.
            graph = subject.graph(&subject.changed)?;
            session = self.session(&graph, &images)?;
            row.set = subject.changed.iter().map(|(name, value)| format!("{name}={value}")).collect();
        }
        if let Some(skipped) = session.plan().savings.skipped.iter().find(|skipped| skipped.node == NODE) {
            return Err(LabError::request(format!("the plan skips it: {}", skipped.why)));
        }
        let node = graph.nodes.iter().find(|node| node.name == NODE).expect("the graph was made for this node");
        let chain = baselines::chain(self.gpu, node, &images, &self.images.camera);
        let recordings = chain.iter().map(Chain::recording).collect();
        let (frame, baseline_time) = timing::frame_time(&mut session, self.clock, self.samples, &images, recordings)?;
        let picture = chain.map(|chain| self.compare(&mut session, &chain, &images)).transpose()?;
        let baseline = picture.map(|picture| BaselineFigures { ms: baseline_time[0].ms(), ..picture });
        let plan = session.plan().clone();
        row.passes = plan.passes.iter().filter(|planned| is_own(planned)).count();
        row.with_others = row.passes < plan.passes.len();
        let ms = if row.with_others { self.own_passes(&mut session, &images)? } else { frame.ms() };
        let (least_bytes, moved_bytes) = (least_bytes(&plan), moved_bytes(&plan));
        row.sizes.push(SizeFigures {
            size: [self.size.width, self.size.height],
            ms,
            least_bytes,
            share: least_bytes as f64 * 1e-6 / ms / self.copy_gbps,
            moved_bytes,
            moved_share: moved_bytes as f64 * 1e-6 / ms / self.copy_gbps,
            baseline,
        });
        Ok(())
    }

    /// The differences of the last frame from the baseline's and from its source, without a time.
    fn compare(
        &self,
        session: &mut Session,
        chain: &Chain,
        images: &[InputImage],
    ) -> Result<BaselineFigures, LabError> {
        let output = session.plan().outputs[0].name.clone();
        let picture = session.output(&output)?.to_floats();
        let source = images.iter().find(|image| image.input == "source").expect("kinds with baselines change a source");
        let source = download(&self.gpu.device, &self.gpu.queue, source.view.texture())?.to_floats();
        let (mean_difference, max_difference) = difference(&picture, &chain.picture(self.gpu)?);
        let (effect, _) = difference(&picture, &source);
        Ok(BaselineFigures { ms: 0.0, mean_difference, max_difference, effect })
    }

    /// A session with a plan for these images.
    fn session(&self, graph: &Graph, images: &[InputImage]) -> Result<Session, LabError> {
        let mut session = Session::new(self.gpu, graph.clone(), Facts::default(), Options::default());
        for input in &graph.inputs {
            let Some(block) = input.block else { continue };
            session.set_block(&input.name, self.images.block(&input.name, block, *block == CAMERA)?);
        }
        session.load(self.size, images)?;
        Ok(session)
    }

    /// The time of the kind's own passes, where others make its inputs or show its result.
    fn own_passes(&self, session: &mut Session, images: &[InputImage]) -> Result<f64, LabError> {
        let times = timing::pass_times(session, self.clock, self.samples, images)?;
        let passes = session.plan().passes.iter();
        Ok(passes.zip(times).filter(|(planned, _)| is_own(planned)).map(|(_, ms)| ms).sum())
    }
}

fn skips(plan: &Plan) -> bool {
    plan.savings.skipped.iter().any(|skipped| skipped.node == NODE)
}
