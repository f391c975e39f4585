//! A renderer with a window: its own pass and the pipeline in one encoder, both halves of a split screen, and a device
//! that is lost.
//!
//! `cargo run -p afterimage --example window` opens the window. `L` loses the device, `S` splits the screen, `T`
//! changes the tier. `-- --still` stops the time; `-- --still FILE.ppm 640x360` writes that picture without a window.
//! `tests/window.sh` drives it.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example shows its result")]

mod renderer;

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use afterimage::host::PostError;
use afterimage_gpu::{Gpu, GpuError, wanted_features, wgpu};
use renderer::Renderer;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_still = arguments.iter().any(|argument| argument == "--still");
    if let [.., file, size] = arguments.as_slice()
        && let Some((width, height)) = size.split_once('x')
    {
        return renderer::write_picture(file, (width.parse()?, height.parse()?));
    }
    let mut app = App { is_still, started: Instant::now(), shown: None };
    EventLoop::new()?.run_app(&mut app)?;
    Ok(())
}

struct App {
    is_still: bool,
    started: Instant,
    /// The window and what renders into it, from the first event on.
    shown: Option<Shown>,
}

/// A window, its swap chain, and the renderer on the present device.
struct Shown {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    renderer: Renderer,
    is_lost: Arc<AtomicBool>,
    /// Whether the swap chain does not suit the window or the device any more.
    is_stale: bool,
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let attributes = Window::default_attributes().with_title("Afterimage in a window");
        let attributes = attributes.with_inner_size(winit::dpi::PhysicalSize::new(640, 360));
        let opened =
            events.create_window(attributes).map_err(Failure::from).and_then(|window| Shown::open(window.into()));
        match opened {
            Ok(shown) => self.shown = Some(shown),
            Err(error) => end(events, &error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => shown.resize(size.width, size.height),
            WindowEvent::KeyboardInput {
                event: KeyEvent { logical_key, state: ElementState::Pressed, .. }, ..
            } => {
                if let Err(error) = shown.press(events, &logical_key) {
                    end(events, &error);
                }
            }
            WindowEvent::RedrawRequested => {
                let time = if self.is_still { 1.0 } else { self.started.elapsed().as_secs_f32() };
                if let Err(error) = shown.frame(time) {
                    end(events, &error);
                }
                shown.window.request_redraw();
            }
            _ => {}
        }
    }
}

fn end(events: &ActiveEventLoop, error: &Failure) {
    eprintln!("{error}");
    events.exit();
}

impl Shown {
    fn open(window: Arc<Window>) -> Result<Self, Failure> {
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle(Box::new(window.clone()));
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(window.clone())?;
        let (adapter, device, queue, is_lost) = pollster::block_on(open_device(&instance, &surface))?;
        let size = window.inner_size();
        let config = surface.get_default_config(&adapter, size.width.max(1), size.height.max(1));
        let config = config.ok_or("the adapter cannot draw into this window")?;
        let renderer = Renderer::new(&Gpu::new(&adapter, &device, &queue))?;
        window.request_redraw();
        Ok(Self { window, instance, surface, config, renderer, is_lost, is_stale: true })
    }

    fn resize(&mut self, width: u32, height: u32) {
        (self.config.width, self.config.height) = (width, height);
        self.is_stale = true;
    }

    fn press(&mut self, events: &ActiveEventLoop, key: &Key) -> Result<(), Failure> {
        match key.as_ref() {
            Key::Named(NamedKey::Escape) => events.exit(),
            Key::Character("l") => self.renderer.device.destroy(),
            Key::Character("s") => self.renderer.split(),
            Key::Character("t") => self.renderer.change_tier()?,
            _ => {}
        }
        Ok(())
    }

    /// Renders a frame, if there is something to see. A lost device is replaced, and the next frame goes on.
    fn frame(&mut self, time: f32) -> Result<(), Failure> {
        // A device tells of its loss when it is polled. One that is lost cannot be.
        let _ = self.renderer.device.poll(wgpu::PollType::Poll);
        if self.is_lost.load(Ordering::Relaxed) {
            return self.recover();
        }
        let Some(texture) = self.next_texture() else { return Ok(()) };
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        match self.renderer.frame(&view, time) {
            Err(PostError::Gpu(GpuError::DeviceLost { .. })) => self.is_lost.store(true, Ordering::Relaxed),
            other => other?,
        }
        self.window.pre_present_notify();
        self.renderer.queue.present(texture);
        Ok(())
    }

    /// The texture of the swap chain; `None` while the window is minimized or changes its size.
    fn next_texture(&mut self) -> Option<wgpu::SurfaceTexture> {
        if self.config.width == 0 || self.config.height == 0 {
            return None;
        }
        if std::mem::take(&mut self.is_stale) {
            self.surface.configure(&self.renderer.device, &self.config);
        }
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) => Some(texture),
            wgpu::CurrentSurfaceTexture::Suboptimal(texture) => {
                self.is_stale = true;
                Some(texture)
            }
            wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Lost => {
                self.is_stale = true;
                None
            }
            _ => None,
        }
    }

    /// Goes on on another device, with all values.
    fn recover(&mut self) -> Result<(), Failure> {
        let (adapter, device, queue, is_lost) = pollster::block_on(open_device(&self.instance, &self.surface))?;
        self.renderer.rebuild(&Gpu::new(&adapter, &device, &queue));
        (self.is_lost, self.is_stale) = (is_lost, true);
        println!("the device was lost; the picture goes on on another one");
        Ok(())
    }
}

/// A device as a renderer opens it, and whether it is lost.
async fn open_device(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface<'_>,
) -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue, Arc<AtomicBool>), Failure> {
    let options = wgpu::RequestAdapterOptions { compatible_surface: Some(surface), ..Default::default() };
    let adapter = instance.request_adapter(&options).await?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: wanted_features(&adapter),
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let (device, queue) = adapter.request_device(&descriptor).await?;
    let is_lost = Arc::new(AtomicBool::new(false));
    let flag = is_lost.clone();
    device.set_device_lost_callback(move |_, _| flag.store(true, Ordering::Relaxed));
    Ok((adapter, device, queue, is_lost))
}
