//! A pipeline on a device of our own, for the program, for measurements and for tests: [`Session`] adds the [`Gpu`],
//! uploads and read-back to [`Post`].

mod bands;
mod faults;
mod metering;
mod passes;

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_gpu::internal::{ReadbackBatch, submit};
use afterimage_gpu::wgpu::{CommandEncoder, TextureView};
use afterimage_gpu::{
    Clock, Executor, Feed, Frame, FrameKind, FrameStep, FrameTime, Gpu, GpuError, InputImage, Readback, Texels,
    TimedCommands, input_image,
};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::BlockData;
use afterimage_plan::{GivenImage, HostInputs, Options, Plan};

pub use faults::TableErrors;

use crate::error::PostError;
use crate::post::Post;

/// A frame of [`Session::render_all`]: its images and its position in time.
pub type FrameInputs = (Vec<InputImage>, FrameStep);

/// A graph on a [`Gpu`]. Plans follow the sizes of the images.
pub struct Session {
    gpu: Gpu,
    post: Post,
    /// The textures that [`feed`](Self::feed) fills, by the names of the inputs.
    feeds: BTreeMap<String, Feed>,
    /// The host blocks, by the names of the inputs.
    blocks: BTreeMap<String, BlockData>,
    readback: Readback,
}

impl Session {
    /// A session with the capabilities of `gpu.caps`.
    pub fn new(gpu: &Gpu, graph: Graph, facts: Facts, options: Options) -> Self {
        Self::with_pipeline_cache(gpu, graph, facts, options, &[])
    }

    /// A session whose executor starts with the driver's pipelines of an earlier run, as
    /// [`pipeline_cache_data`](Executor::pipeline_cache_data) returned them.
    pub fn with_pipeline_cache(gpu: &Gpu, graph: Graph, facts: Facts, options: Options, data: &[u8]) -> Self {
        let mut post = Post::with_executor(gpu.executor().with_pipeline_cache(data), graph);
        post.set_facts(facts);
        post.set_options(options);
        Self {
            gpu: gpu.clone(),
            post,
            feeds: BTreeMap::new(),
            blocks: BTreeMap::new(),
            readback: Readback::new(&gpu.device, &gpu.queue),
        }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The graph, its plans and the executor.
    pub fn post(&mut self) -> &mut Post {
        &mut self.post
    }

    /// Replaces the graph and the options; plans are made again. Compiled pipelines are kept.
    pub fn change(&mut self, graph: Graph, options: Options) {
        self.post.change(graph);
        self.post.set_options(options);
    }

    /// Becomes as a new session on the same device; compiled pipelines are kept.
    pub fn reset(&mut self, graph: Graph, facts: Facts, options: Options) {
        self.change(graph, options);
        self.post.set_facts(facts);
        self.blocks.clear();
        self.restart();
    }

    /// The executor.
    pub fn executor(&mut self) -> &mut Executor {
        self.post.executor()
    }

    /// The plan that is loaded, as the planner made it.
    ///
    /// # Panics
    /// If nothing was loaded or rendered yet.
    pub fn plan(&self) -> &Arc<Plan> {
        self.post.plan().expect("a plan is loaded")
    }

    /// Fills the texture of an input with the next image, row by row without gaps. Images of one size and format use
    /// the same texture.
    ///
    /// # Errors
    /// The device is lost.
    pub fn feed(&mut self, input: &str, desc: ImageDesc, bytes: &[u8]) -> Result<InputImage, GpuError> {
        if desc.samples > 1 {
            // A draw fills it, and no command of a transfer does.
            return input_image(&self.gpu, input, desc, bytes);
        }
        let mut feed = match self.feeds.remove(input) {
            Some(feed) if feed.desc() == desc => feed,
            _ => Feed::new(&self.gpu.device, &self.gpu.queue, desc)?,
        };
        feed.fill(bytes)?;
        let image = InputImage { input: input.to_owned(), view: feed.view().clone(), desc, finite: false };
        self.feeds.insert(input.to_owned(), feed);
        Ok(image)
    }

    /// The image that was fed to an input last.
    pub fn fed(&self, input: &str) -> Option<InputImage> {
        let feed = self.feeds.get(input)?;
        Some(InputImage { input: input.to_owned(), view: feed.view().clone(), desc: feed.desc(), finite: false })
    }

    /// Sets the host block of an input, such as a camera, for all frames from now on.
    pub fn set_block(&mut self, input: &str, data: BlockData) {
        self.blocks.insert(input.to_owned(), data);
    }

    /// Sets the number of the next frame, from which noise is made; further ones count on. Histories go on.
    pub fn number_next(&mut self, number: u32) {
        self.post.executor().number_next(number);
    }

    /// The inputs of a plan for these images and the present blocks.
    fn given(&self, size: Size, images: &[InputImage]) -> HostInputs {
        let image = |image: &InputImage| (image.input.clone(), GivenImage { desc: image.desc, finite: image.finite });
        let (inputs, blocks) = (images.iter().map(image).collect(), self.blocks.keys().cloned().collect());
        HostInputs { inputs, blocks, ..HostInputs::nothing(size) }
    }

    /// Makes the plan for these images and loads it if it is not the loaded one.
    ///
    /// # Errors
    /// The graph cannot be planned at this size, or the device refuses the plan.
    pub fn load(&mut self, size: Size, images: &[InputImage]) -> Result<&Arc<Plan>, PostError> {
        self.post.load_for(self.given(size, images))
    }

    /// Starts at the first frame: histories start again, and noise is that of the first frame.
    pub fn restart(&mut self) {
        self.executor().count_from(0);
    }

    /// The plan for these images, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned at this size.
    pub fn plan_for(&mut self, size: Size, images: &[InputImage]) -> Result<Arc<Plan>, PostError> {
        Ok(self.post.plan_for(self.given(size, images))?)
    }

    /// Records a frame of the loaded plan.
    ///
    /// # Errors
    /// See [`Executor::encode`].
    pub fn encode(
        &mut self,
        encoder: &mut CommandEncoder,
        images: &[InputImage],
        step: FrameStep,
    ) -> Result<(), GpuError> {
        let blocks: Vec<(&str, &BlockData)> = self.blocks.iter().map(|(name, data)| (name.as_str(), data)).collect();
        with_frame(images, step, |frame| self.post.record(encoder, &Frame { blocks: &blocks, ..*frame }, &mut []))
    }

    /// Renders a frame; the outputs stay on the GPU.
    ///
    /// # Errors
    /// See [`load`](Self::load) and [`encode`](Self::encode).
    pub fn render(&mut self, size: Size, images: &[InputImage], step: FrameStep) -> Result<(), PostError> {
        self.load(size, images)?;
        Ok(self.submit(images, step)?)
    }

    /// Submits a frame of the plan that is loaded.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn submit(&mut self, images: &[InputImage], step: FrameStep) -> Result<(), GpuError> {
        self.submit_recorded(|session, encoder| session.encode(encoder, images, step))
    }

    fn submit_recorded(
        &mut self,
        record: impl FnOnce(&mut Self, &mut CommandEncoder) -> Result<(), GpuError>,
    ) -> Result<(), GpuError> {
        let (device, queue) = (self.gpu.device.clone(), self.gpu.queue.clone());
        let mut is_recorded = false;
        let submitted = submit(&device, &queue, "the commands of a frame", |encoder| {
            record(self, encoder)?;
            is_recorded = true;
            Ok(())
        });
        if submitted.is_err() && is_recorded {
            // Histories may lack this frame.
            self.executor().reset();
        }
        submitted
    }

    /// Renders frames of the loaded plan and reads back all outputs of each, in the order of the plan. `together`
    /// records all frames in one submission, which is fast for small images.
    ///
    /// # Errors
    /// See [`encode`](Self::encode) and [`Readback::download`].
    pub fn render_all(&mut self, frames: &[FrameInputs], together: bool) -> Result<Vec<Vec<Texels>>, GpuError> {
        let plan = self.plan().clone();
        let outputs = plan.outputs.iter().map(|output| plan.image(output.image).desc);
        let descs = outputs.collect::<Vec<ImageDesc>>().repeat(frames.len());
        if !ReadbackBatch::fits(&self.gpu.device, &descs) {
            return frames.iter().map(|frame| self.render_alone(frame, &plan)).collect();
        }
        let mut batch = ReadbackBatch::new(&self.gpu.device, descs)?;
        let per_submission = if together { frames.len().max(1) } else { 1 };
        for frames in frames.chunks(per_submission) {
            self.submit_recorded(|session, encoder| {
                frames.iter().try_for_each(|frame| session.encode_copied(encoder, frame, &mut batch))
            })?;
        }
        let mut texels = batch.read()?.into_iter();
        Ok(frames.iter().map(|_| texels.by_ref().take(plan.outputs.len()).collect()).collect())
    }

    /// Records a frame of a sequence, and copies of its outputs.
    fn encode_copied(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &FrameInputs,
        batch: &mut ReadbackBatch,
    ) -> Result<(), GpuError> {
        let (images, step) = frame;
        if step.kind == FrameKind::Cut {
            // A sequence that starts again has the noise of a first frame, so that it can be compared with others.
            self.restart();
        }
        self.encode(encoder, images, *step)?;
        for output in &self.plan().clone().outputs {
            batch.copy(encoder, self.post.output(&output.name)?);
        }
        Ok(())
    }

    /// Renders a frame and reads back its outputs, one after another.
    fn render_alone(&mut self, frame: &FrameInputs, plan: &Plan) -> Result<Vec<Texels>, GpuError> {
        let (images, step) = frame;
        if step.kind == FrameKind::Cut {
            self.restart();
        }
        self.submit(images, *step)?;
        plan.outputs.iter().map(|output| self.output(&output.name)).collect()
    }

    /// The texels of an output of the last frame. Waits for the GPU.
    ///
    /// # Errors
    /// The device is lost.
    pub fn output(&mut self, name: &str) -> Result<Texels, GpuError> {
        let texture = self.post.output(name);
        self.readback.download(texture?)
    }

    /// The value of a node's output port after the last frame, by `node.port`. Waits for the GPU. `None` if the plan
    /// has no such value, for example because the node is skipped.
    ///
    /// # Errors
    /// The device is lost.
    pub fn value(&self, label: &str) -> Result<Option<[f32; 4]>, GpuError> {
        let buffer = self.post.buffer(label);
        buffer.map(|buffer| self.readback.value(buffer)).transpose()
    }

    /// An output of the last frame as the image of an input of another session. The next frame overwrites it.
    pub fn output_image(&self, name: &str, input: &str) -> InputImage {
        let output = self.plan().output(Some(name)).expect("the plan has an output of this name");
        let desc = self.plan().image(output.image).desc;
        let texture = self.post.output(name).expect("the plan has an output of this name");
        let view = texture.create_view(&Default::default());
        InputImage { input: input.to_owned(), view, desc, finite: false }
    }

    /// The same pipeline in memory of its own, with the plan for these images loaded; compiled pipelines are shared.
    ///
    /// A session keeps the places of images in memory from one plan to the next, and the time of a frame depends on
    /// them. Here the places are those of a program that has run nothing else.
    ///
    /// # Errors
    /// See [`load`](Self::load).
    ///
    /// # Panics
    /// If nothing was loaded or rendered yet.
    pub fn clone_with_fresh_allocations(&self, images: &[InputImage]) -> Result<Self, PostError> {
        let (post, blocks) = (self.post.clone_for_view(), self.blocks.clone());
        let readback = Readback::new(&self.gpu.device, &self.gpu.queue);
        let mut session = Self { gpu: self.gpu.clone(), post, feeds: BTreeMap::new(), blocks, readback };
        session.load(self.plan().size, images)?;
        Ok(session)
    }

    /// The time of a frame of the loaded plan: timestamps around the whole frame, as [`Clock`] defines it. `steps`
    /// gives the position in time of each frame. Where passes do not run in every frame, it is the mean of a
    /// [cycle](afterimage_plan::Plan::refresh_cycle). `baselines` are other work that is timed under the same
    /// conditions.
    ///
    /// This is the only function that times a frame, so that all tools report the same quantity.
    ///
    /// # Errors
    /// See [`Clock::medians`].
    pub fn frame_time<'r>(
        &'r mut self,
        clock: &Clock,
        samples: u32,
        images: &'r [InputImage],
        steps: &'r mut dyn FnMut() -> FrameStep,
        baselines: Vec<TimedCommands<'r>>,
    ) -> Result<(FrameTime, Vec<FrameTime>), GpuError> {
        let cycle = self.plan().refresh_cycle();
        let frame: TimedCommands<'r> =
            Box::new(move |encoder| (0..cycle).try_for_each(|_| self.encode(encoder, images, steps())));
        let mut work: Vec<TimedCommands<'r>> = [frame].into_iter().chain(baselines).collect();
        let mut times = clock.medians(samples, &mut work)?.into_iter();
        let frame = times.next().expect("one time for each recording").divided(cycle);
        Ok((frame, times.collect()))
    }
}

/// Calls `use_frame` with the executor's description of a frame without blocks.
fn with_frame<T>(images: &[InputImage], step: FrameStep, use_frame: impl FnOnce(&Frame<'_>) -> T) -> T {
    let inputs: Vec<(&str, &TextureView)> = images.iter().map(|image| (image.input.as_str(), &image.view)).collect();
    use_frame(&Frame { inputs: &inputs, time: step.time, dt: step.dt, kind: step.kind, ..Frame::default() })
}
