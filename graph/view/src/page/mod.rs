//! The viewer as a page in a browser, on WebGPU.
//!
//! The address carries what is shown: `#pipeline=lynx` is a built-in pipeline, `#text=...` a whole text, `#tier=low` a
//! tier of it, `#size=640x360` the size of the scene, `#image=...` the address of an image that is shown in its place,
//! `#bare` shows the picture alone, and `#still` stops time at the first frame, without dither, for comparisons.

mod address;
mod files;

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::rc::Rc;

use afterimage_gpu::{ErrorLog, Gpu, wanted_features, wgpu};
use afterimage_graph::check::GraphInput;
use afterimage_graph::diagnostic::did_you_mean;
use afterimage_graph::image::Size;
use afterimage_graph::node::CameraFile;
use afterimage_media::sequence::split_layer;
use afterimage_media::{Budget, codec};
use afterimage_pipelines::PIPELINES;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use wasm_bindgen::JsCast as _;

use crate::address::Address;
use crate::model::{Images, InputData, InputFile, Model, NamedFile, Project, Scene, TextProject};
use crate::{Exported, NewFiles, Problem, Rendered, Viewer};
use address::Stated;

/// The size of the scene.
const SIZE: Size = Size { width: 960, height: 540, depth: 1 };
/// The scene as an image, next to the page, for adapters that run on the processor: their compilers fail at the shader
/// of the scene. Made by `afterimage demo`.
const STILL: &str = "still.exr";
/// The pipeline that is shown if none is named.
const FIRST: &str = "tsushima";
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
        let report = match run(canvas).await {
            Ok(()) => String::new(),
            Err(error) => format!("The viewer cannot start: {error}."),
        };
        write("said", &report);
    });
}

async fn run(canvas: web_sys::HtmlCanvasElement) -> Result<(), String> {
    let address = address::read();
    let image = match address.get("image") {
        Some(image) => Some(Arrived { name: image.to_owned(), read: files::fetched(image).await, is_dropped: false }),
        None => None,
    };
    let options = eframe::WebOptions { wgpu_options: configuration(), ..Default::default() };
    let make = Box::new(|context: &eframe::CreationContext<'_>| Page::make(context, address, image));
    eframe::WebRunner::new().start(canvas, options, make).await.map_err(|error| files::text_of(&error))
}

/// Writes a text into an element of the page.
fn write(element: &str, text: &str) {
    let document = web_sys::window().and_then(|window| window.document());
    if let Some(element) = document.and_then(|document| document.get_element_by_id(element)) {
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
    ctx: egui::Context,
    last: f64,
    address: Address,
    /// The user has changed the address.
    has_new_address: Rc<Cell<bool>>,
    /// The state of the model in the address; `None` before the first frame with it.
    stated: Option<Stated>,
    errors: ErrorLog,
    /// The still is being fetched. Until it has arrived, no frame is rendered: it would be one of the scene.
    awaits_still: bool,
    title: String,
    /// The bytes of the images that were opened, by name: another layer can be chosen.
    files: BTreeMap<String, Rc<[u8]>>,
    /// Files that were dropped or fetched and have been read.
    arrived: Rc<RefCell<Vec<Arrived>>>,
}

/// A file that has been read, or why it cannot be.
struct Arrived {
    name: String,
    read: Result<Vec<u8>, String>,
    is_dropped: bool,
}

type Made = Result<Box<dyn eframe::App>, Box<dyn std::error::Error + Send + Sync>>;

impl Page {
    fn make(context: &eframe::CreationContext<'_>, address: Address, image: Option<Arrived>) -> Made {
        let state = context.wgpu_render_state.as_ref().ok_or("this browser has no WebGPU")?;
        let gpu = Gpu::new(&state.adapter, &state.device, &state.queue);
        let errors = gpu.log_errors();
        let lost = "The graphics device was lost. Reload the page to go on.";
        gpu.device.set_device_lost_callback(|_, _| write("said", lost));
        Viewer::style(&context.egui_ctx);
        let (project, message) = project(&address);
        let scene = scene(&gpu, &address).map_err(|problem| problem.to_string())?;
        let model = Model::new(&gpu, project, scene);
        let ctx = context.egui_ctx.clone();
        let wake = ctx.clone();
        let mut page = Self {
            viewer: Viewer::new(model, state.target_format, NewFiles::Downloaded(Box::new(downloaded))),
            ctx,
            last: 0.0,
            address,
            has_new_address: address::watch(move || wake.request_repaint()),
            stated: None,
            errors,
            awaits_still: false,
            title: String::new(),
            files: BTreeMap::new(),
            arrived: Rc::default(),
        };
        page.viewer.model.set_tier(page.address.get("tier").map(str::to_owned));
        page.set_time();
        page.set_panels();
        match image {
            Some(image) => page.arrived.borrow_mut().push(image),
            None => page.show_still_on_a_processor(),
        }
        if let Some(message) = message {
            page.tell(&message);
        }
        Ok(Box::new(page))
    }

    /// Shows a message in the viewer, and writes it into the page for those who do not see it.
    fn tell(&mut self, text: &str) {
        self.viewer.tell(&self.ctx, text);
        write("note", text);
    }

    /// An adapter that runs on the processor is too slow to render the moving scene.
    fn show_still_on_a_processor(&mut self) {
        if self.viewer.model.gpu().is_processor() {
            self.awaits_still = true;
            self.fetch(STILL);
            self.tell("WebGPU runs on the processor here: a still image is shown in the place of the moving scene.");
        }
    }

    /// Applies the address to the clock. Adapters that run on the processor are too slow to play.
    fn set_time(&mut self) {
        let is_still = self.address.has("still");
        self.viewer.model.clock().is_playing = !is_still && !self.viewer.model.gpu().is_processor();
        if is_still {
            still(&mut self.viewer.model);
        }
    }

    /// Applies the address to the panels.
    fn set_panels(&mut self) {
        self.viewer.is_bare = self.address.has("bare");
        self.viewer.picture.zoom = self.viewer.is_bare.then_some(1.0);
    }

    /// Shows what a new address states.
    fn follow_address(&mut self) {
        let new = address::read();
        if !self.has_new_address.take() || new == self.address {
            return;
        }
        let old = std::mem::replace(&mut self.address, new);
        let differs = |name: &str| old.get(name) != self.address.get(name) || old.has(name) != self.address.has(name);
        let is_other_pipeline = differs("pipeline") || differs("text") || differs("tier");
        let (is_other_image, is_other_size) = (differs("image"), differs("size"));
        let (is_other_time, has_other_panels) = (differs("still"), differs("bare"));
        let mut message = None;
        if is_other_pipeline {
            let (project, wrong) = project(&self.address);
            message = wrong;
            self.viewer.model.open(project);
            self.viewer.model.set_tier(self.address.get("tier").map(str::to_owned));
        }
        match self.address.get("image").map(str::to_owned) {
            Some(image) if is_other_image => self.fetch(&image),
            None if is_other_image || is_other_size => self.show_scene(),
            _ => {}
        }
        // The dithers of another pipeline are on.
        if is_other_time || is_other_pipeline && self.address.has("still") {
            self.set_time();
        }
        if has_other_panels {
            self.set_panels();
        }
        if let Some(message) = message {
            self.tell(&message);
        }
        self.stated = None;
    }

    fn show_scene(&mut self) {
        match scene(self.viewer.model.gpu(), &self.address) {
            Ok(scene) => self.viewer.model.set_images(scene),
            Err(problem) => self.tell(&problem.to_string()),
        }
        self.show_still_on_a_processor();
    }

    /// Opens a file of the web once it has arrived.
    fn fetch(&self, file: &str) {
        let (arrived, ctx, file) = (self.arrived.clone(), self.ctx.clone(), file.to_owned());
        wasm_bindgen_futures::spawn_local(async move {
            let read = files::fetched(&file).await;
            arrived.borrow_mut().push(Arrived { name: file, read, is_dropped: false });
            ctx.request_repaint();
        });
    }

    /// Opens what is dropped on the page, which the browser reads in the background, and what was fetched.
    fn open_arrived(&mut self, ui: &egui::Ui) {
        for file in ui.input(|input| input.raw.dropped_files.clone()) {
            let (arrived, ctx) = (self.arrived.clone(), ui.ctx().clone());
            wasm_bindgen_futures::spawn_local(async move {
                let name = file.path().to_string_lossy().into_owned();
                let read = file.bytes_async().await;
                arrived.borrow_mut().push(Arrived { name, read, is_dropped: true });
                ctx.request_repaint();
            });
        }
        let arrived = std::mem::take(&mut *self.arrived.borrow_mut());
        for Arrived { name, read, is_dropped } in arrived {
            self.awaits_still = false;
            let opened = read.map_err(Problem::message).and_then(|bytes| self.open(&name, &bytes, is_dropped));
            if let Err(problem) = opened {
                // Without this file there is the scene again.
                if !is_dropped && name != STILL {
                    self.show_still_on_a_processor();
                }
                self.tell(&format!("The image is not shown: {problem}."));
            }
        }
    }

    fn open(&mut self, name: &str, bytes: &[u8], is_dropped: bool) -> Result<(), Problem> {
        if name.to_lowercase().ends_with(".ron") {
            self.viewer.open(Box::new(TextProject::new(name, &String::from_utf8_lossy(bytes))));
            return Ok(());
        }
        self.files.insert(name.to_owned(), bytes.into());
        let file = self.input_file(name)?;
        match is_dropped {
            true => self.viewer.drop_input(&self.ctx, file),
            false => self.viewer.open_input(&self.ctx, file, None),
        }
        Ok(())
    }

    /// A camera or an image that has been read, or a layer of it: `name.exr#layer`.
    fn input_file(&self, name: &str) -> Result<InputFile, Problem> {
        let (file, layer) = split_layer(name);
        let bytes = self.files.get(file).ok_or_else(|| Problem::message(format!("`{file}` has not been opened")))?;
        if name.ends_with(".json") {
            let camera = CameraFile::from_json(bytes).and_then(|camera| camera.data(None));
            let camera = camera.map_err(|why| Problem::message(format!("`{name}` is no camera: {why}")))?;
            let read = move |_: &GraphInput, _: usize| Ok(InputData::Block(camera.clone()));
            return Ok(InputFile::still(name, Box::new(read)));
        }
        let wrong = |error| Problem::message(format!("`{name}`: {error}"));
        let picture = codec::decode(Cursor::new(&**bytes), layer.as_deref(), Budget(BUDGET)).map_err(wrong)?;
        let layers = codec::describe(Cursor::new(&**bytes), None).map_or(Vec::new(), |described| described.layers);
        let read = move |_: &GraphInput, _: usize| Ok(InputData::Image(Box::new(picture.clone()), picture.desc()));
        Ok(InputFile { layers, ..InputFile::still(name, Box::new(read)) })
    }

    /// Opens the layer that was chosen below the row of an input.
    fn open_chosen_layer(&mut self) {
        let Some((Some(input), name)) = self.viewer.take_named_file() else { return };
        match self.input_file(&name.to_string_lossy()) {
            Ok(file) => self.viewer.open_input(&self.ctx, file, Some(&input)),
            Err(problem) => self.tell(&format!("The image is not shown: {problem}.")),
        }
    }

    /// Sets the title of the page, if it is another one.
    fn update_title(&mut self) {
        let title = self.viewer.title();
        if title != self.title {
            address::set_title(&title);
            self.title = title;
        }
    }

    /// Writes what the user has changed into the address, once a control is let go.
    fn state_in_address(&mut self) {
        let model = &self.viewer.model;
        if model.editor().changes().is_dragging() {
            return;
        }
        let stated = Stated::of(model);
        if self.stated.as_ref() == Some(&stated) {
            return;
        }
        if self.stated.is_some() {
            address::write(&mut self.address, model);
        }
        self.stated = Some(stated);
    }
}

/// A pipeline that is saved by the downloads of the browser. Pages know the built-in files that it names.
fn downloaded(path: &std::path::Path, _: Vec<NamedFile>) -> Result<Box<dyn Project>, Problem> {
    let store = |name: &str, text: &str| {
        let exported = Exported { name: name.to_owned(), bytes: text.into() };
        files::download(&exported).map_err(|error| files::text_of(&error))?;
        Ok(format!("{name}, among the downloads of the browser"))
    };
    Ok(Box::new(TextProject::new(&path.to_string_lossy(), "").stored_by(Box::new(store))))
}

/// The pipeline that an address names, and what is wrong with the name.
fn project(address: &Address) -> (Box<dyn Project>, Option<String>) {
    if let Some(text) = address.get("text") {
        return (Box::new(TextProject::new("shared.ron", text)), None);
    }
    let named = address.get("pipeline").unwrap_or(FIRST);
    if let Some(project) = TextProject::built_in(named.trim_end_matches(".ron")) {
        return (Box::new(project), None);
    }
    let names: Vec<&str> = PIPELINES.iter().map(|(name, _)| *name).collect();
    let hint = did_you_mean(named, names.iter().copied());
    let hint = hint.unwrap_or_else(|| format!("there are {}.", names.join(", ")));
    let message = format!("No built-in pipeline is called `{named}`; {hint} `{FIRST}` is shown.");
    (Box::new(TextProject::built_in(FIRST).expect("it is built in")), Some(message))
}

/// The scene at the size that an address states.
fn scene(gpu: &Gpu, address: &Address) -> Result<Images, Problem> {
    let side = |length: u32| length.min(gpu.caps.max_side);
    let size = address.size().map_or(SIZE, |(width, height)| Size::new(side(width), side(height)));
    Ok(Images::Scene(Box::new(Scene::new(gpu, size)?)))
}

/// Switches off what differs from frame to frame.
fn still(model: &mut Model) {
    let dithers: Vec<String> = model.editor().graph().map_or(Vec::new(), |graph| {
        graph.nodes.iter().filter(|node| node.kind().name() == "Dither").map(|node| node.name.clone()).collect()
    });
    for node in dithers {
        model.set(&crate::Target::Node(node), Some(afterimage_graph::value::Value::Bool(false)));
    }
    model.release();
}

impl eframe::App for Page {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.follow_address();
        self.open_arrived(ui);
        if self.awaits_still {
            return;
        }
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
            self.tell(&format!("Nothing is exported: {}.", files::text_of(&error)));
        }
        if let Some(error) = self.errors.take_first() {
            self.tell(&error);
        }
        self.open_chosen_layer();
        self.state_in_address();
        self.update_title();
    }
}
