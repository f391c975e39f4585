//! A viewer without a window.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::OnceLock;

use afterimage_gpu::{Gpu, Opening, Texels, download, wgpu};
use afterimage_graph::image::Size;
use afterimage_media::{Picture, Pixels};
use afterimage_view::{
    FrameTarget, Images, InputData, InputFile, Model, NewFiles, Opened, Problem, Project, Rendered, Scene, Target,
    TextProject, UiRenderer,
};

/// The size of the scene: small, and no multiple of anything.
pub(crate) const SIZE: Size = Size { width: 150, height: 86, depth: 1 };
/// The size of the window.
pub(crate) const WINDOW: [u32; 2] = [1280, 720];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The device, which all tests of a program share.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(&Opening::default()).expect("the tests need a Vulkan driver, such as lavapipe"))
}

/// A built-in pipeline on the scene, which stands still.
pub(crate) fn model(name: &str) -> Model {
    of(Box::new(stored(name)))
}

/// A built-in pipeline with a place to be written to.
fn stored(name: &str) -> TextProject {
    let project = TextProject::built_in(name).expect("it is built in");
    project.stored_by(Box::new(|name, _| Ok(name.to_owned())))
}

/// A pipeline on the scene, which stands still.
pub(crate) fn of(project: Box<dyn Project>) -> Model {
    let scene = Scene::new(gpu(), SIZE).expect("the scene is made");
    let mut model = Model::new(gpu(), project, Images::Scene(Box::new(scene)));
    model.clock().is_playing = false;
    model
}

pub(crate) fn render(model: &mut Model) -> Rendered {
    let mut encoder = gpu().encoder();
    let rendered = model.render(&mut encoder, 1.0 / 60.0);
    gpu().queue.submit([encoder.finish()]);
    rendered
}

/// Renders until no new plan is on its way.
pub(crate) fn settle(model: &mut Model) {
    for _ in 0..2000 {
        render(model);
        if !model.shown().is_some_and(|shown| shown.is_changing()) {
            render(model);
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("the plan never comes: {:?}", model.problem());
}

/// The texels of a texture.
pub(crate) fn texels(texture: &wgpu::Texture) -> Texels {
    download(&gpu().device, &gpu().queue, texture).expect("the device is there")
}

/// The texels of the picture that is shown.
pub(crate) fn picture(model: &Model) -> Texels {
    texels(model.shown().and_then(|shown| shown.picture()).expect("there is a picture"))
}

/// An image of one color.
pub(crate) fn image(texel: [f32; 4]) -> InputData {
    let texels = (0..SIZE.width * SIZE.height).flat_map(|_| texel).collect();
    let picture = Picture::new(SIZE.width, SIZE.height, Pixels::Float(texels));
    let desc = picture.desc();
    InputData::Image(Box::new(picture), desc)
}

/// A file with an image of one color.
pub(crate) fn flat(name: &str, read: impl Fn() -> Result<[f32; 4], Problem> + 'static) -> InputFile {
    InputFile::still(name, Box::new(move |_, _| Ok(image(read()?))))
}

/// The whole viewer on a texture, and its events.
pub(crate) struct Window {
    pub(crate) ui: UiRenderer,
    target: wgpu::Texture,
    size: [u32; 2],
    time: f64,
    /// The files that the user has made.
    pub(crate) disk: Disk,
}

/// Texts of files by their paths.
type Disk = Rc<RefCell<BTreeMap<String, String>>>;

/// Makes files on a disk.
fn new_files(disk: &Disk) -> NewFiles {
    let disk = disk.clone();
    NewFiles::Asked(Box::new(move |path, named| {
        let path = path.to_string_lossy();
        if disk.borrow().contains_key(&*path) {
            return Err(Problem::message("a file of this name is there"));
        }
        for (name, bytes) in named {
            disk.borrow_mut().insert(name, String::from_utf8_lossy(&bytes).into_owned());
        }
        let disk = disk.clone();
        let store = move |name: &str, text: &str| {
            disk.borrow_mut().insert(name.to_owned(), text.to_owned());
            Ok(name.to_owned())
        };
        Ok(Box::new(TextProject::new(&path, "").stored_by(Box::new(store))))
    }))
}

/// The texture that a window draws into.
fn window_target(gpu: &Gpu, size: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("window"),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Opens what is dropped: the built-in pipelines by their names, and images of one gray.
fn open(path: &std::path::Path) -> Result<Opened, Problem> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if path.extension().is_some_and(|ending| ending == "exr") {
        return Ok(Opened::Input(flat(&path.to_string_lossy(), || Ok([0.5, 0.5, 0.5, 1.0]))));
    }
    let project = TextProject::built_in(&name);
    project.map(|project| Opened::Pipeline(Box::new(project))).ok_or_else(|| Problem::message(format!("no `{name}`")))
}

/// A file that is dropped.
#[derive(Debug)]
struct Dropped(std::path::PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &std::path::Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// A text and its area.
pub(crate) type Said = (String, egui::Rect);

/// Adds the texts of a shape that are within an area.
fn collect_texts(shape: &egui::Shape, clip: egui::Rect, texts: &mut Vec<Said>) {
    match shape {
        egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect_texts(shape, clip, texts)),
        egui::Shape::Text(text) => {
            let area = text.visual_bounding_rect().intersect(clip);
            if area.is_positive() {
                texts.push((text.galley.text().to_owned(), area));
            }
        }
        _ => {}
    }
}

impl Window {
    /// A viewer of a model.
    pub(crate) fn new(model: Model) -> Self {
        Self::of_size(model, WINDOW)
    }

    /// The same in a window of another size.
    pub(crate) fn of_size(model: Model, size: [u32; 2]) -> Self {
        let disk = Disk::default();
        let new_files = new_files(&disk);
        Self { disk, ..Self::made(model, size, new_files) }
    }

    /// A viewer that stores pipelines without a file in another way.
    pub(crate) fn with_new_files(model: Model, new_files: NewFiles) -> Self {
        Self::made(model, WINDOW, new_files)
    }

    fn made(model: Model, size: [u32; 2], new_files: NewFiles) -> Self {
        let target = window_target(model.gpu(), size);
        let ui = UiRenderer::new(model, FORMAT, Box::new(open), new_files);
        Self { ui, target, size, time: 0.0, disk: Disk::default() }
    }

    /// Goes on on another device, as the window does after a loss.
    pub(crate) fn replace_device(&mut self, gpu: &Gpu) {
        self.ui.viewer.model.rebuild(gpu).expect("the scene can be made again");
        self.ui.set_target(FORMAT);
        self.target = window_target(gpu, self.size);
    }

    /// A file is dropped on the window, at a place that no row of an input has.
    pub(crate) fn drop_file(&mut self, path: &str) {
        self.drop_files(&[path], egui::pos2(660.0, 230.0));
    }

    /// Files are dropped at a place, of which the window learns after the drop.
    pub(crate) fn drop_files(&mut self, paths: &[&str], at: egui::Pos2) {
        let mut dropped_files: Vec<std::sync::Arc<dyn egui::DroppedFile + Send + Sync>> = Vec::new();
        paths.iter().for_each(|path| dropped_files.push(std::sync::Arc::new(Dropped(path.into()))));
        self.input(egui::RawInput { dropped_files, ..Default::default() });
        self.frame(vec![egui::Event::PointerMoved(at)]);
        (0..8).for_each(|_| self.frame(Vec::new()));
    }

    /// Draws a frame after these events.
    pub(crate) fn frame(&mut self, events: Vec<egui::Event>) {
        self.input(egui::RawInput { events, ..Default::default() });
    }

    fn input(&mut self, input: egui::RawInput) {
        if !self.ui.viewer.model.has_device() {
            return;
        }
        self.time += 1.0 / 60.0;
        let [width, height] = self.size.map(|side| side as f32);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height))),
            time: Some(self.time),
            focused: true,
            ..input
        };
        let view = self.target.create_view(&Default::default());
        self.ui.frame(input, FrameTarget { view: &view, size: self.size }, 1.0 / 60.0);
    }

    /// The texts that the window shows, with their areas.
    pub(crate) fn texts(&mut self) -> Vec<Said> {
        let [width, height] = self.size.map(|side| side as f32);
        let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height)));
        let input = egui::RawInput { screen_rect, time: Some(self.time), focused: true, ..Default::default() };
        let ctx = self.ui.ctx().clone();
        let mut output = ctx.run_ui(input, |ui| self.ui.viewer.show(ui));
        output.textures_delta.clear();
        let mut texts = Vec::new();
        for clipped in output.shapes {
            collect_texts(&clipped.shape, clipped.clip_rect, &mut texts);
        }
        texts
    }

    /// True if one of the texts contains this.
    pub(crate) fn says(&mut self, text: &str) -> bool {
        self.texts().iter().any(|(shown, _)| shown.contains(text))
    }

    /// The middle of the first text that is this.
    pub(crate) fn place_of(&mut self, text: &str) -> egui::Pos2 {
        let texts = self.texts();
        let found = texts.iter().find(|(shown, _)| shown == text);
        found.unwrap_or_else(|| panic!("no `{text}` among {texts:?}")).1.center()
    }

    /// Presses and releases a key.
    pub(crate) fn key(&mut self, key: egui::Key, modifiers: egui::Modifiers) {
        for pressed in [true, false] {
            self.frame(vec![egui::Event::Key { key, physical_key: None, pressed, repeat: false, modifiers }]);
        }
    }

    /// Drags the pointer from one place to another.
    pub(crate) fn drag(&mut self, from: egui::Pos2, to: egui::Pos2) {
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Default::default(),
        };
        self.frame(vec![egui::Event::PointerMoved(from)]);
        self.frame(vec![button(from, true)]);
        for step in 1..=4 {
            self.frame(vec![egui::Event::PointerMoved(from.lerp(to, step as f32 / 4.0))]);
        }
        self.frame(vec![button(to, false)]);
    }

    pub(crate) fn click(&mut self, at: egui::Pos2) {
        self.drag(at, at);
    }

    /// The texels of the window.
    pub(crate) fn texels(&self) -> Texels {
        let gpu = self.ui.viewer.model.gpu();
        download(&gpu.device, &gpu.queue, &self.target).expect("the device is there")
    }
}

/// The largest difference between two pictures in codes. A dither depends on the number of the frame, so equal pictures
/// differ by 1.
pub(crate) fn apart(a: &Texels, b: &Texels) -> u8 {
    assert_eq!(a.desc, b.desc);
    a.bytes.iter().zip(&b.bytes).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

/// A parameter by its name.
pub(crate) fn parameter(name: &str) -> Target {
    Target::Parameter(name.into())
}
