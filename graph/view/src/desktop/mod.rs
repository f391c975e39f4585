//! The window: events of the desktop, the swap chain, and files that are dropped.

mod file_dialog;
mod surface;
mod wake;

use std::sync::Arc;
use std::time::{Duration, Instant};

use afterimage_gpu::ErrorLog;
use afterimage_graph::check::Facts;
use afterimage_graph::diagnostic::shown_path;
use afterimage_graph::image::Size;
use afterimage_media::write_atomic;
use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

use crate::Problem;
use crate::model::{Images, InputFile, Model, Project, Scene};
use crate::ui::new_file::free_name;
use crate::ui::{FileRequest, MakeProject, MeasureDifference, NewFiles, RecentFiles};
use crate::ui_renderer::{FrameTarget, OpenFile, UiRenderer};
use file_dialog::FileDialogs;
use surface::Surface;
pub use wake::Wake;

pub struct Desktop {
    /// Part of the name of the graphics adapter; `None` for the fastest.
    pub adapter: Option<String>,
    /// The size of the window in points.
    pub size: [f64; 2],
    pub project: Box<dyn Project>,
    /// The size of the built-in scene, which is shown without files.
    pub scene: Size,
    /// The files of inputs; `None` is the first image that the pipeline needs.
    pub inputs: Vec<(Option<String>, InputFile)>,
    /// Opens a file that is dropped or named.
    pub open: OpenFile,
    /// Makes the file of a pipeline that has none.
    pub new_file: MakeProject,
    /// Measures the difference of two pictures.
    pub measure: MeasureDifference,
    /// Lists the pipelines that were opened last.
    pub recent: RecentFiles,
    /// The tier to begin with.
    pub tier: Option<String>,
    pub facts: Facts,
    /// Draws a frame at once when a file has changed.
    pub wake: Wake,
}

impl Desktop {
    /// Shows the window until it is closed.
    ///
    /// # Errors
    /// There is no display or no graphics adapter, or the images cannot be made.
    pub fn run(self) -> Result<(), Problem> {
        let events = EventLoop::with_user_event().build().map_err(|error| {
            Problem::message(format!("no window can be opened: {}", without_place(&error.to_string())))
                .hint("the viewer needs a desktop; `afterimage render` works without one")
        })?;
        let waker = events.create_proxy();
        self.wake.set(move || drop(waker.send_event(FilesChanged)));
        let mut shell = Shell { desktop: Some(self), shown: None, failure: None };
        let ran = events.run_app(&mut shell).map_err(|error| Problem::message(error.to_string()));
        shell.failure.map_or(ran, Err)
    }
}

/// The message of an error of the system without the place in the source that it begins with.
fn without_place(message: &str) -> &str {
    let after = message.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
    after.map_or(message, |(_, what)| what)
}

struct Shell {
    desktop: Option<Desktop>,
    shown: Option<Shown>,
    failure: Option<Problem>,
}

/// The window and everything in it.
struct Shown {
    window: Arc<Window>,
    surface: Surface,
    ui: UiRenderer,
    input: egui_winit::State,
    adapter: Option<String>,
    errors: ErrorLog,
    dialogs: FileDialogs,
    last: Instant,
    /// The title of the window.
    title: String,
    /// The time of the next redraw if no event comes before.
    redraw_at: Option<Instant>,
}

/// Longest time between two polls of the files.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A watched file has changed.
struct FilesChanged;

impl ApplicationHandler<FilesChanged> for Shell {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        let Some(desktop) = self.desktop.take() else { return };
        match Shown::new(events, desktop) {
            Ok(shown) => self.shown = Some(shown),
            Err(problem) => {
                self.failure = Some(problem);
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        let response = shown.input.on_window_event(&shown.window, &event);
        if response.repaint {
            shown.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => shown.ask_to_close(),
            WindowEvent::Resized(size) => shown.surface.resize(size.into()),
            WindowEvent::RedrawRequested => {
                if let Err(problem) = shown.draw() {
                    self.failure = Some(problem);
                    events.exit();
                }
            }
            _ => {}
        }
        if shown.ui.viewer.is_closing() {
            events.exit();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: FilesChanged) {
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(shown)) = (cause, &self.shown) {
            shown.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(shown) = &self.shown else { return };
        let next = Instant::now() + POLL_INTERVAL;
        events.set_control_flow(ControlFlow::WaitUntil(shown.redraw_at.map_or(next, |time| time.min(next))));
    }
}

impl Shown {
    fn new(events: &ActiveEventLoop, desktop: Desktop) -> Result<Self, Problem> {
        let attributes = Window::default_attributes()
            .with_title("Afterimage")
            .with_inner_size(winit::dpi::LogicalSize::new(desktop.size[0], desktop.size[1]))
            .with_min_inner_size(winit::dpi::LogicalSize::new(640.0, 400.0));
        let window = events.create_window(attributes).map_err(|error| Problem::message(error.to_string()))?;
        let window = Arc::new(window);
        let (gpu, surface) = Surface::open(&window, desktop.adapter.as_deref())?;
        let errors = gpu.log_errors();
        let scene = Scene::new(&gpu, desktop.scene)?;
        let mut model = Model::new(&gpu, desktop.project, Images::Scene(Box::new(scene)));
        model.set_tier(desktop.tier);
        for (input, file) in desktop.inputs {
            model.set_input(input.as_deref(), Some(file))?;
        }
        // A processor renders for long. While time stands, it renders what a change reaches alone.
        model.clock().is_playing = !gpu.is_processor();
        desktop.facts.iter().for_each(|(name, fact)| model.set_fact(name, Some(fact)));
        let mut ui = UiRenderer::new(model, surface.format(), desktop.open, NewFiles::Asked(desktop.new_file));
        ui.viewer.measure_by(desktop.measure);
        ui.viewer.list_recent_by(desktop.recent);
        let input = egui_winit::State::new(
            ui.ctx().clone(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        window.request_redraw();
        let adapter = desktop.adapter;
        Ok(Self {
            window,
            surface,
            ui,
            input,
            adapter,
            errors,
            dialogs: FileDialogs::new(desktop.wake),
            last: Instant::now(),
            title: String::new(),
            redraw_at: None,
        })
    }

    /// Draws a frame, if the window can be seen.
    fn draw(&mut self) -> Result<(), Problem> {
        self.update_title();
        // A lost device has no next image to draw into.
        if !self.ui.viewer.model.has_device() {
            return self.replace_lost_device();
        }
        let elapsed = std::mem::replace(&mut self.last, Instant::now()).elapsed().as_secs_f64();
        let Some(frame) = self.surface.next(self.ui.viewer.model.gpu()) else {
            self.redraw_at = Some(Instant::now() + POLL_INTERVAL);
            return Ok(());
        };
        let input = self.input.take_egui_input(&self.window);
        if input.events.iter().any(is_close) {
            self.ui.viewer.close();
        }
        let size = [frame.texture.width(), frame.texture.height()];
        let gpu = self.ui.viewer.model.gpu().clone();
        self.ui.viewer.picture.headroom = self.surface.headroom();
        let ui = &mut self.ui;
        let output =
            self.surface.draw(&frame.texture, |view| ui.frame(input, FrameTarget { view, size }, elapsed), &gpu);
        self.window.pre_present_notify();
        self.ui.viewer.model.gpu().queue.present(frame);
        self.input.handle_platform_output(&self.window, output.platform_output);
        self.store_export();
        self.choose_files();
        self.schedule_redraw(output.viewport_output.values().map(|viewport| viewport.repaint_delay).min());
        self.replace_lost_device()
    }

    /// Closes the window unless changes would be lost; then the question must be seen.
    fn ask_to_close(&mut self) {
        self.ui.viewer.close();
        self.window.set_minimized(false);
        self.window.request_redraw();
    }

    fn schedule_redraw(&mut self, delay: Option<Duration>) {
        let is_playing = self.ui.viewer.model.clock().is_playing;
        let delay = if is_playing { Duration::ZERO } else { delay.unwrap_or(POLL_INTERVAL).min(POLL_INTERVAL) };
        self.redraw_at = Some(Instant::now() + delay);
    }

    /// Opens a new device if the present one was lost.
    fn replace_lost_device(&mut self) -> Result<(), Problem> {
        if let Some(error) = self.errors.take_first() {
            self.ui.viewer.tell(&self.ui.ctx().clone(), error);
        }
        if !matches!(self.ui.viewer.model.problem(), Some(Problem::DeviceLost)) {
            return Ok(());
        }
        let (gpu, surface) = Surface::open(&self.window, self.adapter.as_deref())?;
        (self.errors, self.surface) = (gpu.log_errors(), surface);
        self.ui.viewer.model.rebuild(&gpu)?;
        self.ui.set_target(self.surface.format());
        Ok(())
    }

    fn update_title(&mut self) {
        let title = self.ui.viewer.title();
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
    }

    /// Opens the dialog that the user asks for, and the file that was chosen in one.
    fn choose_files(&mut self) {
        if let Some(request) = self.ui.viewer.take_file_request()
            && let Err(error) = self.dialogs.open(&self.window, request)
        {
            self.ui.viewer.tell(&self.ui.ctx().clone(), format!("No dialog is opened: {error}"));
        }
        match self.dialogs.take() {
            Some((FileRequest::Input { name, .. }, Some(path))) => self.ui.open_file(&path, Some(&name)),
            Some((FileRequest::Pipeline, Some(path))) => self.ui.open_file(&path, None),
            Some((_, None)) => {
                self.ui.viewer.tell(&self.ui.ctx().clone(), "No file was chosen. Files can be dropped, too.")
            }
            None => {}
        }
    }

    /// Stores what was exported in the folder that the program was started in.
    fn store_export(&mut self) {
        let Some(exported) = self.ui.viewer.take_export() else { return };
        let path = free_name(&exported.name);
        let message = match write_atomic(&path, &exported.bytes) {
            Ok(()) => format!("Exported: {}", shown_path(&std::path::absolute(&path).unwrap_or(path))),
            Err(error) => format!("Nothing is exported: {error}"),
        };
        self.ui.viewer.tell(&self.ui.ctx().clone(), message);
    }
}

/// True for the keys that close windows.
fn is_close(event: &egui::Event) -> bool {
    let egui::Event::Key { key: egui::Key::Q, pressed: true, modifiers, .. } = event else { return false };
    modifiers.command
}

#[cfg(test)]
mod tests {
    use super::without_place;

    #[test]
    fn a_message_names_no_source_file() {
        let message = "os error at /home/someone/winit/src/linux/mod.rs:788: Failed to open: no display";
        assert_eq!(without_place(message), "Failed to open: no display");
        assert_eq!(
            without_place("Neither WAYLAND_DISPLAY nor DISPLAY is set."),
            "Neither WAYLAND_DISPLAY nor DISPLAY is set."
        );
    }
}
