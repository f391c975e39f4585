//! An executor on the shared device, frame by frame, as a host runs it. For tests of the executor; others use a
//! [`Sequence`](super::sequence::Sequence).

use std::ops::Deref;
use std::sync::Arc;

use afterimage_gpu::{Executor, Frame, FrameKind, Gpu, GpuError, Texels, download, upload};
use afterimage_plan::Plan;

use super::gpu::{Picture, Run, gpu};

/// The device, and an executor on it.
pub struct Player {
    pub gpu: Box<dyn Deref<Target = Gpu>>,
    pub executor: Executor,
}

impl Player {
    pub fn new() -> Self {
        let gpu = gpu();
        let executor = executor(&gpu);
        Self { gpu: Box::new(gpu), executor }
    }

    /// On a device of its own.
    pub fn on(gpu: Gpu) -> Self {
        let executor = executor(&gpu);
        Self { gpu: Box::new(Box::new(gpu)), executor }
    }

    /// Starts again with a new executor on the same device.
    pub fn renew(&mut self) {
        self.executor = executor(&self.gpu);
    }

    /// Another executor on the same device, with this plan.
    pub fn spare(&self, plan: Arc<Plan>) -> Executor {
        let mut executor = executor(&self.gpu);
        executor.load(plan).unwrap_or_else(|error| panic!("{error}"));
        executor
    }

    /// Plans for these inputs and loads the plan.
    pub fn load(&mut self, run: &Run<'_>, inputs: &[(&str, &Picture)]) -> Arc<Plan> {
        let plan = Arc::new(run.plan(&self.gpu, inputs));
        self.executor.load(plan.clone()).unwrap_or_else(|error| panic!("{error}"));
        plan
    }

    /// The picture as a texture of 32-bit floats.
    pub fn upload(&self, picture: &Picture) -> wgpu::TextureView {
        let texels = Texels::from_floats(picture.width, picture.height, &picture.pixels);
        let texture = upload(&self.gpu.device, &self.gpu.queue, &texels).unwrap_or_else(|error| panic!("{error}"));
        texture.create_view(&Default::default())
    }

    /// One frame with these pictures.
    pub fn frame(&mut self, inputs: &[(&str, &Picture)], dt: f32, reset: bool) {
        let views: Vec<wgpu::TextureView> = inputs.iter().map(|(_, picture)| self.upload(picture)).collect();
        let named: Vec<(&str, &wgpu::TextureView)> = inputs.iter().map(|(name, _)| *name).zip(&views).collect();
        self.run(&Frame { inputs: &named, dt, kind: FrameKind::cut_if(reset), ..Frame::default() })
            .unwrap_or_else(|error| panic!("{error}"));
    }

    /// One frame with the host's own textures.
    pub fn run(&mut self, frame: &Frame<'_>) -> Result<(), GpuError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.executor.encode(&mut encoder, frame)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// An output of the last frame.
    pub fn output(&self, name: &str) -> Picture {
        self.read(self.executor.output(name).expect("the executor keeps a texture for each output"))
    }

    pub fn read(&self, texture: &wgpu::Texture) -> Picture {
        let texels = download(&self.gpu.device, &self.gpu.queue, texture).unwrap_or_else(|error| panic!("{error}"));
        Picture::of(&texels)
    }
}

fn executor(gpu: &Gpu) -> Executor {
    Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone())
}
