//! A pipeline on a GPU, ready to take pictures.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_gpu::{Executor, Feed, Frame, Gpu, Opening, Readback, Texels, upload_bytes};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ColorState, Format, ImageDesc, Size};
use afterimage_plan::{GivenImage, Options, Plan, PlanCache, PlanOutput, PlanRequest};

use crate::args::{ArithmeticOptions, DeviceOptions};
use crate::cache::{self, Gain};
use crate::failure::Failure;
use crate::terminal::note;
use afterimage_media::{Picture, Pixels};

/// Opens the GPU that the command line asks for.
pub(crate) fn open(options: &DeviceOptions) -> Result<Gpu, Failure> {
    let mut gpu = Gpu::open(&Opening { adapter: options.adapter.clone(), validation: false })?;
    // Without a calibration: on lavapipe whole pipelines are a third faster drawn, which single passes do not show.
    let drawn = cache::calibration(&gpu).map_or(gpu.is_processor(), |calibration| calibration.prefers_fragment());
    gpu.caps.prefer_fragment = options.fragment || drawn;
    Ok(gpu)
}

/// The planner's switches on this device: what the command line leaves open is on where a calibration has found it to be faster. Says which of
/// those that are asked for have no effect.
pub(crate) fn options_on(gpu: &Gpu, asked: Options, arithmetic: &ArithmeticOptions) -> Options {
    let calibration = cache::calibration(gpu).unwrap_or_default();
    let pays = |gain: Option<Gain>| gain.is_some_and(Gain::pays);
    let found =
        Options { half: pays(calibration.half) && !asked.exact, subgroups: pays(calibration.subgroups), ..asked };
    let (options, ignored) = arithmetic.over(found).granted(&gpu.caps);
    ignored.iter().for_each(|ignored| note(&format!("note: `--{}` has no effect: {}", ignored.switch, ignored.why)));
    options
}

/// A graph and what runs it; the plan follows the sizes of the pictures.
pub(crate) struct Session<'g> {
    pub(crate) gpu: &'g Gpu,
    plans: PlanCache,
    facts: Facts,
    options: Options,
    executor: Executor,
    /// Where the pictures of the inputs go, by the names of these.
    feeds: BTreeMap<String, Feed>,
    readback: Readback,
    /// The driver's pipelines that were there already.
    known_pipelines: Vec<u8>,
    planned: Option<Arc<Plan>>,
}

/// An image on the GPU for an input of a pipeline.
pub(crate) struct Given {
    pub(crate) input: String,
    pub(crate) view: wgpu::TextureView,
    pub(crate) desc: ImageDesc,
}

/// The time of a frame.
#[derive(Clone, Copy, Default)]
pub(crate) struct Clock {
    pub(crate) time: f32,
    pub(crate) dt: f32,
    pub(crate) reset: bool,
}

impl<'g> Session<'g> {
    pub(crate) fn new(gpu: &'g Gpu, graph: Graph, facts: Facts, options: Options) -> Self {
        let known_pipelines = cache::pipelines(gpu);
        let executor =
            Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone()).with_pipeline_cache(&known_pipelines);
        let readback = Readback::new(&gpu.device, &gpu.queue);
        let feeds = BTreeMap::new();
        let plans = PlanCache::new(graph);
        Self { gpu, plans, facts, options, executor, feeds, readback, known_pipelines, planned: None }
    }

    /// Brings an input's next picture to the GPU. Pictures of one size go to one texture.
    pub(crate) fn feed(&mut self, input: &str, picture: &Picture) -> Result<Given, Failure> {
        check_fits(self.gpu, picture)?;
        let (desc, bytes) = texels(picture);
        let mut feed = match self.feeds.remove(input) {
            Some(feed) if feed.desc() == desc => feed,
            _ => Feed::new(&self.gpu.device, &self.gpu.queue, desc),
        };
        feed.fill(bytes)?;
        let given = Given { input: input.to_owned(), view: feed.view().clone(), desc };
        self.feeds.insert(input.to_owned(), feed);
        Ok(given)
    }

    /// Renders one frame; the results stay on the GPU.
    pub(crate) fn render(&mut self, size: Size, inputs: &[Given], clock: Clock) -> Result<(), Failure> {
        let image = |given: &Given| (given.input.clone(), GivenImage { desc: given.desc, finite: false });
        self.plan_for(size, inputs.iter().map(image).collect())?;
        let named: Vec<(&str, &wgpu::TextureView)> =
            inputs.iter().map(|given| (given.input.as_str(), &given.view)).collect();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let frame = Frame { inputs: &named, outputs: &[], time: clock.time, dt: clock.dt, reset: clock.reset };
        self.executor.encode(&mut encoder, &frame)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn plan_for(&mut self, size: Size, inputs: BTreeMap<String, GivenImage>) -> Result<(), Failure> {
        let executor = &self.executor;
        let requirement = |desc: &ImageDesc| executor.requirement(desc);
        let setting = PlanRequest {
            size,
            inputs,
            facts: self.facts.clone(),
            caps: self.gpu.caps.clone(),
            options: self.options,
            requirement: &requirement,
        };
        let plan = self.plans.plan(&setting)?;
        if self.planned.as_ref().is_none_or(|planned| !Arc::ptr_eq(planned, &plan)) {
            self.executor.load(plan.clone())?;
            cache::keep_pipelines(self.gpu, &self.executor, &self.known_pipelines);
            self.planned = Some(plan);
        }
        Ok(())
    }

    /// The plan in use.
    pub(crate) fn plan(&self) -> &Arc<Plan> {
        self.executor.plan().expect("a frame was rendered")
    }

    /// The executor.
    pub(crate) fn executor(&mut self) -> &mut Executor {
        &mut self.executor
    }

    /// The texels of an output of the last frame.
    pub(crate) fn output(&mut self, name: &str) -> Result<Texels, Failure> {
        let texture = self.executor.output(name).expect("the executor keeps a texture for each output");
        Ok(self.readback.download(texture)?)
    }

    /// The texture of an output of the last frame.
    pub(crate) fn output_texture(&self, name: &str) -> &wgpu::Texture {
        self.executor.output(name).expect("the executor keeps a texture for each output")
    }
}

/// The texels of a picture as its file had them.
fn texels(picture: &Picture) -> (ImageDesc, &[u8]) {
    let desc = ImageDesc::new(Size::new(picture.width, picture.height));
    match &picture.pixels {
        Pixels::Half(halves) => (desc, bytemuck::cast_slice(halves)),
        Pixels::Float(floats) => (desc.format(Format::Rgba32Float), bytemuck::cast_slice(floats)),
    }
}

fn check_fits(gpu: &Gpu, picture: &Picture) -> Result<(), Failure> {
    let limit = gpu.caps.max_side;
    if picture.width.max(picture.height) <= limit {
        return Ok(());
    }
    let message = format!(
        "the image is {}x{}, but `{}` takes at most {limit} pixels a side",
        picture.width,
        picture.height,
        gpu.name()
    );
    Err(Failure::user(message).hint("scale it down, or choose another device with `--adapter`"))
}

/// A picture on the GPU, refused if the device cannot hold it.
pub(crate) fn upload_picture(gpu: &Gpu, picture: &Picture) -> Result<(wgpu::Texture, ImageDesc), Failure> {
    check_fits(gpu, picture)?;
    let (desc, bytes) = texels(picture);
    Ok((upload_bytes(&gpu.device, &gpu.queue, desc, bytes), desc))
}

/// The output that goes to a file: the named one, or the first whose state suits the file's ending.
pub(crate) fn choose_output(plan: &Plan, wanted: Option<&str>, png: bool) -> Result<PlanOutput, Failure> {
    let names: Vec<String> = plan.outputs.iter().map(|o| format!("`{}` ({})", o.name, o.state.name())).collect();
    let names = names.join(", ");
    let suits = |output: &&PlanOutput| (output.state == ColorState::Encoded) == png;
    if let Some(wanted) = wanted {
        let output = plan.output(Some(wanted)).ok_or_else(|| {
            Failure::user(format!("the pipeline has no output `{wanted}`")).hint(format!("it has {names}"))
        })?;
        return match suits(&output) {
            true => Ok(output.clone()),
            false if png => Err(Failure::user(format!(
                "output `{wanted}` is {}, and a PNG holds encoded pictures",
                output.state.name()
            ))
            .hint("write it to an `.exr` file, or add an `Encode` node")),
            false => Err(Failure::user(format!("output `{wanted}` is Encoded, and an EXR holds linear light"))
                .hint("write it to a `.png` file")),
        };
    }
    plan.outputs.iter().find(suits).cloned().ok_or_else(|| {
        let (kind, hint) = if png {
            ("encoded", "write to an `.exr` file, or add an `Encode` node and an output for it")
        } else {
            ("linear", "write to a `.png` file, or add an output before the `Encode` node")
        };
        Failure::user(format!("the pipeline has no {kind} output for this file; it has {names}")).hint(hint)
    })
}
