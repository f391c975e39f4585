//! A pipeline on a device of our own, for the program, for measurements and for tests: [`Session`] adds the [`Gpu`],
//! uploads and read-back to [`Post`].

mod bands;
#[doc(hidden)] // For the program and measurements.
pub mod faults;
#[doc(hidden)] // For the program.
pub mod metering;
#[doc(hidden)] // For the program and measurements.
pub mod timing;
mod uploads;

use std::sync::Arc;

use afterimage_gpu::internal::{ReadbackBatch, submit};
use afterimage_gpu::wgpu::CommandEncoder;
use afterimage_gpu::{Executor, FrameKind, FrameStep, Gpu, GpuError, InputImage, Readback, Texels};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::BlockData;
use afterimage_plan::{HostInputs, Options, Plan};

use crate::error::PostError;
use crate::post::Post;
use uploads::Uploads;

/// A frame of [`Session::render_all`]: its images and its position in time.
pub type FrameInputs = (Vec<InputImage>, FrameStep);

/// Renders the frames of a graph on a [`Gpu`], one after another: uploads, the frame number, the plan for the images,
/// the commands, read-back.
pub struct Session {
    gpu: Gpu,
    post: Post,
    uploads: Uploads,
    readback: Readback,
}

impl Session {
    /// A session with the capabilities of `gpu.caps`.
    pub fn new(gpu: &Gpu, graph: Graph, facts: Facts, options: Options) -> Self {
        Self::with_executor(gpu, gpu.executor(), graph, facts, options)
    }

    /// A session whose executor starts with the driver's pipelines of an earlier run, as
    /// [`pipeline_cache_data`](afterimage_gpu::Executor::pipeline_cache_data) returned them.
    pub fn with_pipeline_cache(gpu: &Gpu, graph: Graph, facts: Facts, options: Options, data: &[u8]) -> Self {
        Self::with_executor(gpu, gpu.executor().with_pipeline_cache(data), graph, facts, options)
    }

    fn with_executor(gpu: &Gpu, executor: Executor, graph: Graph, facts: Facts, options: Options) -> Self {
        let mut post = Post::with_executor(executor, graph);
        post.set_facts(facts);
        post.set_options(options);
        Self::of(gpu, post)
    }

    fn of(gpu: &Gpu, post: Post) -> Self {
        let readback = Readback::new(&gpu.device, &gpu.queue);
        Self { gpu: gpu.clone(), post, uploads: Uploads::default(), readback }
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
        self.uploads.blocks.clear();
        self.restart();
    }

    /// The plan that is loaded, as the planner made it.
    ///
    /// # Panics
    /// If nothing was loaded or rendered yet.
    pub fn plan(&self) -> &Arc<Plan> {
        self.post.plan().expect("a plan is loaded")
    }

    /// Uploads the next image of an input, row by row without gaps. Images of one size and format use the same texture.
    ///
    /// # Errors
    /// The image is larger than the device supports, or the device is lost or has no memory for it.
    pub fn feed(&mut self, input: &str, desc: ImageDesc, bytes: &[u8]) -> Result<InputImage, GpuError> {
        self.uploads.image(&self.gpu, input, desc, bytes)
    }

    /// Sets the host block of an input, such as a camera, for all frames from now on.
    pub fn set_block(&mut self, input: &str, data: BlockData) {
        self.uploads.blocks.insert(input.to_owned(), data);
    }

    /// Sets the number of the next frame, from which noise is made; further ones count on. Histories go on.
    pub fn number_next(&mut self, number: u32) {
        self.post.executor().number_next(number);
    }

    fn host_inputs(&self, size: Size, images: &[InputImage]) -> HostInputs {
        self.uploads.host_inputs(size, images.iter().map(|image| (&*image.input, image.desc, image.finite)))
    }

    /// Makes the plan for these images and loads it if it is not the loaded one.
    ///
    /// # Errors
    /// The graph cannot be planned at this size, or the device refuses the plan.
    pub fn load(&mut self, size: Size, images: &[InputImage]) -> Result<&Arc<Plan>, PostError> {
        self.post.load_for(self.host_inputs(size, images))
    }

    /// Starts at the first frame: histories start again, and noise is that of the first frame.
    pub fn restart(&mut self) {
        self.post.executor().count_from(0);
    }

    /// The plan for these images, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned at this size.
    pub fn plan_for(&mut self, size: Size, images: &[InputImage]) -> Result<Arc<Plan>, PostError> {
        Ok(self.post.plan_for(self.host_inputs(size, images))?)
    }

    /// Records a frame of the loaded plan.
    ///
    /// # Errors
    /// See [`Executor::encode`](afterimage_gpu::Executor::encode).
    pub fn encode(
        &mut self,
        encoder: &mut CommandEncoder,
        images: &[InputImage],
        step: FrameStep,
    ) -> Result<(), GpuError> {
        self.uploads.with_frame(images, step, |frame| self.post.record(encoder, frame, &mut []))
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
            self.post.executor().reset();
        }
        submitted
    }

    /// Renders frames of the loaded plan and reads back all outputs of each, in the order of the plan. A cut has the
    /// noise of a first frame. `together` records all frames in one submission, which is fast for small images.
    ///
    /// # Errors
    /// See [`encode`](Self::encode) and [`Readback::download`].
    pub fn render_all(&mut self, frames: &[FrameInputs], together: bool) -> Result<Vec<Vec<Texels>>, GpuError> {
        let plan = self.plan().clone();
        let outputs = plan.outputs.iter().map(|output| plan.image(output.image).desc);
        let descs = outputs.collect::<Vec<ImageDesc>>().repeat(frames.len());
        if !ReadbackBatch::fits(&self.gpu.device, &descs) {
            let render = |(images, step): &FrameInputs| {
                self.restart_at_cut(*step);
                self.submit(images, *step)?;
                self.outputs()
            };
            return frames.iter().map(render).collect();
        }
        let mut batch = ReadbackBatch::new(&self.gpu.device, descs)?;
        let per_submission = if together { frames.len().max(1) } else { 1 };
        for frames in frames.chunks(per_submission) {
            self.submit_recorded(|session, encoder| {
                for (images, step) in frames {
                    session.restart_at_cut(*step);
                    session.encode(encoder, images, *step)?;
                    for output in &plan.outputs {
                        batch.copy(encoder, session.post.output(&output.name)?);
                    }
                }
                Ok(())
            })?;
        }
        let mut texels = batch.read()?.into_iter();
        Ok(frames.iter().map(|_| texels.by_ref().take(plan.outputs.len()).collect()).collect())
    }

    fn restart_at_cut(&mut self, step: FrameStep) {
        if step.kind == FrameKind::Cut {
            self.restart();
        }
    }

    /// The texels of all outputs of the last frame, in the order of the plan. Waits for the GPU.
    ///
    /// # Errors
    /// The device is lost.
    pub fn outputs(&mut self) -> Result<Vec<Texels>, GpuError> {
        let plan = self.plan().clone();
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
        let mut session = Self::of(&self.gpu, self.post.clone_for_view());
        session.uploads.blocks.clone_from(&self.uploads.blocks);
        session.load(self.plan().size, images)?;
        Ok(session)
    }
}
