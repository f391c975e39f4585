//! Renders the viewer into any target: a window, or a texture in a test.

use std::path::Path;
use std::time::Instant;

use afterimage_gpu::wgpu;
use egui::epaint::{ImageDelta, TextureAtlas};
use egui_wgpu::{RendererOptions, ScreenDescriptor};

use crate::render::device::onto;
use crate::{InputFile, Model, NewFiles, Problem, Project, Viewer};

/// The viewer with the renderer of its user interface.
pub struct UiRenderer {
    pub viewer: Viewer,
    ctx: egui::Context,
    renderer: egui_wgpu::Renderer,
    open: OpenFile,
    /// Milliseconds that the last frame took of the processor.
    own_ms: f64,
}

/// A file that was dropped or named.
pub enum Opened {
    Pipeline(Box<dyn Project>),
    Input(InputFile),
}

pub type OpenFile = Box<dyn Fn(&Path) -> Result<Opened, Problem>>;

/// The target of a frame.
#[derive(Clone, Copy)]
pub struct FrameTarget<'t> {
    pub view: &'t wgpu::TextureView,
    /// Its size in physical pixels.
    pub size: [u32; 2],
}

impl UiRenderer {
    /// A renderer for targets of that format, which hold encoded numbers: not one of the sRGB formats. `open` opens
    /// files that are dropped, `new_files` makes those of pipelines that have none.
    pub fn new(model: Model, format: wgpu::TextureFormat, open: OpenFile, new_files: NewFiles) -> Self {
        let ctx = egui::Context::default();
        Viewer::style(&ctx);
        let renderer = renderer(&model, format);
        Self { viewer: Viewer::new(model, format, new_files), ctx, renderer, open, own_ms: 0.0 }
    }

    /// The context of the user interface.
    pub fn ctx(&self) -> &egui::Context {
        &self.ctx
    }

    /// Draws into targets of another format, or on another device, from now on.
    pub fn set_target(&mut self, format: wgpu::TextureFormat) {
        self.viewer.set_target(format);
        self.renderer = renderer(&self.viewer.model, format);
        // The letters were on the device that is gone, and the context sends only what is new of them.
        if self.ctx.cumulative_pass_nr() > 0 {
            let letters = self.ctx.fonts(|fonts| fonts.image());
            let whole = ImageDelta::full(letters, TextureAtlas::texture_options());
            let gpu = self.viewer.model.gpu();
            self.renderer.update_texture(&gpu.device, &gpu.queue, egui::TextureId::default(), &whole);
        }
    }

    /// Renders and draws a frame, `elapsed` seconds after the last one, and submits it.
    ///
    /// The renderer of egui panics on a lost device: check [`Model::has_device`] before.
    pub fn frame(&mut self, input: egui::RawInput, target: FrameTarget<'_>, elapsed: f64) -> egui::FullOutput {
        let begin = Instant::now();
        for dropped in &input.dropped_files {
            if let Some(file) = self.input_file(dropped.path()) {
                self.viewer.drop_input(&self.ctx, file);
            }
        }
        if let Some((input, path)) = self.viewer.take_named_file() {
            self.open_file(&path, input.as_deref());
        }
        let gpu = self.viewer.model.gpu().clone();
        let mut encoder = gpu.encoder();
        self.viewer.render(&mut encoder, elapsed);
        let mut output = self.ctx.run_ui(input, |ui| self.viewer.show(ui));
        let jobs = self.ctx.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let screen = ScreenDescriptor { size_in_pixels: target.size, pixels_per_point: output.pixels_per_point };
        let mut textures: Vec<_> = std::mem::take(&mut output.textures_delta.set).into_iter().collect();
        textures.sort_by_key(|(id, _)| *id);
        for (id, deltas) in textures {
            deltas.iter().for_each(|delta| self.renderer.update_texture(&gpu.device, &gpu.queue, id, delta));
        }
        self.renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &jobs, &screen);
        let pass = onto(&mut encoder, "viewer", target.view);
        self.renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
        gpu.queue.submit([encoder.finish()]);
        let free = std::mem::take(&mut output.textures_delta.free);
        free.iter().for_each(|id| self.renderer.free_texture(id));
        self.viewer.after_submit(&self.ctx, self.own_ms);
        self.own_ms = begin.elapsed().as_secs_f64() * 1e3;
        output
    }

    /// Opens a file that is chosen, or that is named for an input.
    pub(crate) fn open_file(&mut self, path: &Path, input: Option<&str>) {
        if let Some(file) = self.input_file(path) {
            self.viewer.open_input(&self.ctx, file, input);
        }
    }

    /// Opens a file. Returns it if it is no pipeline.
    fn input_file(&mut self, path: &Path) -> Option<InputFile> {
        match (self.open)(path) {
            Ok(Opened::Input(file)) => return Some(file),
            Ok(Opened::Pipeline(project)) => self.viewer.open(project),
            Err(problem) => self.viewer.tell(&self.ctx, problem.to_string()),
        }
        None
    }
}

fn renderer(model: &Model, format: wgpu::TextureFormat) -> egui_wgpu::Renderer {
    egui_wgpu::Renderer::new(&model.gpu().device, format, RendererOptions { dithering: false, ..Default::default() })
}
