//! The viewer as a page in a browser, on WebGPU.
//!
//! The address carries what is shown: `#pipeline=lynx` is a built-in pipeline, `#text=...` a whole text,
//! `#size=640x360` the size of the scene, `#image=...` the address of an image that is shown in its place, `#bare`
//! shows the picture alone, and `#still` stops time at the first frame, without dither, for comparisons.

mod address;
mod files;

use std::cell::RefCell;
use std::rc::Rc;

use afterimage_gpu::{ErrorLog, Gpu, caps, wanted_features, wgpu};
use afterimage_graph::image::Size;
use afterimage_media::{Budget, codec};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use wasm_bindgen::JsCast as _;

use crate::model::{Files, Images, Model, Project, Scene, TextProject};
use crate::{Problem, Rendered, Viewer};
use address::Address;

/// The size of the scene.
const SIZE: Size = Size { width: 960, height: 540, depth: 1 };
/// The scene as an image, for adapters that run on the processor: their compilers fail at the shader of the scene. Made
/// by `afterimage demo --size 320x180`.
const SCENE: &[u8] = include_bytes!("../../web/scene.exr");
/// The most bytes that a dropped image may take.
const BUDGET: u64 = 1 << 30;

/// Starts the page on its canvas.
///
/// # Panics
/// If the page has no canvas called `viewer`.
pub fn start() {
    let document = web_sys::window().and_then(|window| window.document()).expect("a page has a document");
    let canvas = document.get_element_by_id("viewer").expect("the page has a canvas");
    let canvas: web_sys::HtmlCanvasElement = canvas.dyn_into().expect("it is a canvas");
    wasm_bindgen_futures::spawn_local(async move {
        let said = match run(canvas).await {
            Ok(()) => String::new(),
            Err(error) => error,
        };
        say(&said);
    });
}

async fn run(canvas: web_sys::HtmlCanvasElement) -> Result<(), String> {
    let address = Address::read();
    let image = match &address.image {
        Some(image) => Some(files::fetched(image).await?),
        None => None,
    };
    let options = eframe::WebOptions { wgpu_options: configuration(), ..Default::default() };
    let make = Box::new(|context: &eframe::CreationContext<'_>| Page::make(context, address, image));
    eframe::WebRunner::new().start(canvas, options, make).await.map_err(|error| format!("{error:?}"))
}

/// Writes a sentence into the page, or takes the one before away.
fn say(text: &str) {
    let document = web_sys::window().and_then(|window| window.document());
    if let Some(element) = document.and_then(|document| document.get_element_by_id("said")) {
        element.set_text_content(Some(text));
    }
}

/// A device with the features that plans can use.
fn configuration() -> WgpuConfiguration {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
    setup.device_descriptor = std::sync::Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("afterimage"),
        required_features: wanted_features(adapter),
        required_limits: adapter.limits(),
        ..Default::default()
    });
    WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..Default::default() }
}

struct Page {
    viewer: Viewer,
    last: f64,
    address: Address,
    errors: ErrorLog,
    /// Files that were dropped and have been read, by name.
    arrived: Rc<RefCell<Vec<Dropped>>>,
}

/// A dropped file: its name and its bytes.
type Dropped = (String, Result<Vec<u8>, String>);

type Made = Result<Box<dyn eframe::App>, Box<dyn std::error::Error + Send + Sync>>;

impl Page {
    fn make(context: &eframe::CreationContext<'_>, address: Address, image: Option<Vec<u8>>) -> Made {
        let state = context.wgpu_render_state.as_ref().ok_or("this browser has no WebGPU")?;
        let (adapter, device, queue) = (state.adapter.clone(), state.device.clone(), state.queue.clone());
        let caps = caps(&adapter, &device);
        let gpu = Gpu { adapter, device, queue, caps };
        let (errors, is_processor) = (gpu.log_errors(), gpu.is_processor());
        gpu.device.set_device_lost_callback(|_, _| say("The graphics device was lost. Reload the page to go on."));
        Viewer::style(&context.egui_ctx);
        let size = address.size.map_or(SIZE, |(width, height)| Size::new(width, height));
        let scene = Scene::new(&gpu, size).map_err(|problem| problem.to_string())?;
        let mut model = Model::new(&gpu, project(&address), Images::Scene(Box::new(scene)));
        model.clock().is_playing = !address.is_still;
        if address.is_still {
            still(&mut model);
        }
        let mut viewer = Viewer::new(model, state.target_format);
        if address.is_bare {
            (viewer.is_bare, viewer.picture.zoom) = (true, Some(1.0));
        }
        let mut page = Self { viewer, last: 0.0, address, errors, arrived: Rc::default() };
        if image.is_none() && is_processor {
            page.open("scene.exr", SCENE).map_err(|problem| problem.to_string())?;
            page.viewer.tell(&context.egui_ctx, "WebGPU runs on the processor here: the scene is an image.");
        }
        if let Some(bytes) = image {
            page.open("image", &bytes).map_err(|problem| problem.to_string())?;
        }
        Ok(Box::new(page))
    }

    /// Opens what is dropped on the page: the browser reads it in the background.
    fn open_dropped(&mut self, ui: &egui::Ui) {
        for file in ui.input(|input| input.raw.dropped_files.clone()) {
            let (arrived, ctx) = (self.arrived.clone(), ui.ctx().clone());
            wasm_bindgen_futures::spawn_local(async move {
                let name = file.path().to_string_lossy().into_owned();
                let read = file.bytes_async().await;
                arrived.borrow_mut().push((name, read));
                ctx.request_repaint();
            });
        }
        let arrived = std::mem::take(&mut *self.arrived.borrow_mut());
        for (name, read) in arrived {
            let opened = read.map_err(Problem::message).and_then(|bytes| self.open(&name, &bytes));
            if let Err(problem) = opened {
                self.viewer.tell(ui.ctx(), problem.to_string());
            }
        }
    }

    fn open(&mut self, name: &str, bytes: &[u8]) -> Result<(), Problem> {
        if name.ends_with(".ron") {
            self.viewer.open(Box::new(TextProject::new(name, &String::from_utf8_lossy(bytes))));
            return Ok(());
        }
        let model = &mut self.viewer.model;
        let picture = codec::decode(std::io::Cursor::new(bytes), None, Budget(BUDGET))
            .map_err(|error| Problem::message(error.to_string()))?;
        let gpu = model.gpu().clone();
        let read = move |_| Ok(picture.clone());
        model.set_images(Images::Files(Box::new(Files::new(&gpu, 1, 24.0, Box::new(read))?)));
        Ok(())
    }
}

/// The pipeline that the address names.
fn project(address: &Address) -> Box<dyn Project> {
    if let Some(text) = &address.text {
        return Box::new(TextProject::new("shared.ron", text));
    }
    let named = TextProject::built_in(address.pipeline.as_deref().unwrap_or("tsushima"));
    Box::new(named.or_else(|| TextProject::built_in("tsushima")).expect("it is built in"))
}

/// Switches off what differs from frame to frame.
fn still(model: &mut Model) {
    let dithers: Vec<String> = model.graph().map_or(Vec::new(), |graph| {
        graph.nodes.iter().filter(|node| node.kind().name() == "Dither").map(|node| node.name.clone()).collect()
    });
    for node in dithers {
        model.set(&crate::Target::Node(node), Some(afterimage_graph::value::Value::Bool(false)));
    }
}

impl eframe::App for Page {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.open_dropped(ui);
        let now = ui.input(|input| input.time);
        let elapsed = now - std::mem::replace(&mut self.last, now);
        let gpu = self.viewer.model.gpu().clone();
        let mut encoder = gpu.encoder();
        let rendered = self.viewer.render(&mut encoder, elapsed);
        gpu.queue.submit([encoder.finish()]);
        if rendered != Rendered::Same {
            // The next frame is requested once this one is finished, so that frames never queue up.
            let ctx = ui.ctx().clone();
            gpu.queue.on_submitted_work_done(move || ctx.request_repaint());
        }
        self.viewer.show(ui);
        self.viewer.after_submit(ui.ctx(), 0.0);
        if let Some(Err(error)) = self.viewer.take_export().map(|exported| files::download(&exported)) {
            self.viewer.tell(ui.ctx(), format!("Nothing is exported: {error:?}"));
        }
        if let Some(error) = self.errors.take_first() {
            self.viewer.tell(ui.ctx(), error);
        }
        self.address.follow(&self.viewer.model);
    }
}
