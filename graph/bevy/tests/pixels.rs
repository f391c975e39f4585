//! What a camera shows is what the program makes of the same image, also after files have changed.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use afterimage_gpu::{FrameStep, Gpu, InputImage, Opening, Session, Texels, upload};
use afterimage_graph::check::{CheckOptions, Facts, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use bevy::camera::RenderTarget;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_afterimage::{Afterimage, AfterimagePlugin, Target};

const SIZE: UVec2 = UVec2::new(160, 90);
const PASS: &str = r#"Pipeline(inputs: { "scene": Color }, nodes: { "out": Exposure(source: "scene", stops: 0.0) },
    outputs: { "out": "out" })"#;

/// An app with one camera on a scene that does not move.
struct Shown {
    app: App,
    image: Handle<Image>,
}

#[derive(Resource, Default)]
struct Captured(Option<Vec<u8>>);

impl Shown {
    fn new(
        folder: &Path,
        pipeline: &str,
        format: TextureFormat,
        change: impl FnOnce(Afterimage) -> Afterimage,
    ) -> Self {
        let file_path = folder.to_string_lossy().into_owned();
        let assets = AssetPlugin { file_path, watch_for_changes_override: Some(true), ..default() };
        let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
        let plugins = DefaultPlugins.set(assets).set(window).disable::<WinitPlugin>().disable::<LogPlugin>();
        let mut app = App::new();
        app.add_plugins((plugins.disable::<PipelinedRenderingPlugin>(), AfterimagePlugin::default()))
            .insert_resource(ClearColor(Color::linear_rgb(0.02, 0.05, 0.1)))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(16)))
            .init_resource::<Captured>();
        app.finish();
        app.cleanup();
        let mut image = Image::new_target_texture(SIZE.x, SIZE.y, format, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let world = app.world_mut();
        let image = world.resource_mut::<Assets<Image>>().add(image);
        let sphere = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.8).mesh().uv(32, 16));
        for index in 0..5 {
            let light = LinearRgba::rgb(0.3 + index as f32, 0.9, 2.0 - 0.4 * index as f32) * 3.0_f32.powi(index - 1);
            let material = StandardMaterial { emissive: light, unlit: false, ..default() };
            let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
            let place = Transform::from_xyz(1.9 * index as f32 - 3.8, 0.0, 0.0);
            world.spawn((Mesh3d(sphere.clone()), MeshMaterial3d(material), place));
        }
        let look = change(Afterimage::new(world.resource::<AssetServer>().load(pipeline.to_owned())));
        let target = RenderTarget::Image(image.clone().into());
        let place = Transform::from_xyz(0.0, 1.0, 7.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((Camera3d::default(), Msaa::Off, place, target, look));
        Self { app, image }
    }

    fn run(&mut self, frames: usize) {
        for _ in 0..frames {
            self.app.update();
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// The bytes of the camera's image.
    fn shown(&mut self) -> Vec<u8> {
        self.app.world_mut().resource_mut::<Captured>().0 = None;
        let capture = |shot: On<ScreenshotCaptured>, mut captured: ResMut<Captured>| {
            captured.0 = shot.image.data.clone();
        };
        self.app.world_mut().spawn(Screenshot::image(self.image.clone())).observe(capture);
        for _ in 0..200 {
            self.run(1);
            if let Some(bytes) = self.app.world_mut().resource_mut::<Captured>().0.take() {
                return bytes;
            }
        }
        panic!("no screenshot arrives");
    }

    /// The image once it is as wanted: files and shaders of the scene arrive after some frames.
    fn once(&mut self, what: &str, is_wanted: impl Fn(&[u8]) -> bool) -> Vec<u8> {
        for _ in 0..100 {
            self.run(5);
            let shown = self.shown();
            if is_wanted(&shown) {
                return shown;
            }
        }
        panic!("{what}: not after 100 pictures");
    }

    /// The image once it stays as it is and has many codes.
    fn settled(&mut self) -> Vec<u8> {
        let codes = |bytes: &[u8]| bytes.iter().collect::<BTreeSet<_>>().len();
        let mut before = self.once("a picture", |bytes| codes(bytes) > 15);
        let mut same = 0;
        while same < 5 {
            let now = self.once("a picture", |bytes| codes(bytes) > 15);
            same = if now == before { same + 1 } else { 0 };
            before = now;
        }
        before
    }
}

fn pipelines() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines")
}

struct OfRepository;

impl Loader for OfRepository {
    fn load(&self, path: &str) -> Result<std::sync::Arc<[u8]>, String> {
        std::fs::read(pipelines().join(path)).map(Into::into).map_err(|error| error.to_string())
    }
}

/// A folder for the files of a test.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("bevy-afterimage-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    folder
}

/// What the program makes of an image.
fn rendered(pipeline: &str, scene: &Texels) -> Vec<u8> {
    let text = std::fs::read_to_string(pipelines().join(pipeline)).expect("it is in the repository");
    let kinds = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let document = parse(pipeline, &text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &OfRepository };
    let (graph, _) = check(&document, &kinds, &options).unwrap_or_else(|errors| panic!("{errors}"));
    let gpu = Gpu::open(&Opening::default()).unwrap_or_else(|error| panic!("{error}"));
    let view = upload(&gpu.device, &gpu.queue, scene).unwrap_or_else(|error| panic!("{error}"));
    let input =
        InputImage { input: "scene".into(), view: view.create_view(&default()), desc: scene.desc, finite: false };
    let mut session = Session::new(&gpu, graph, Facts::default(), default());
    session.render(Size::new(SIZE.x, SIZE.y), &[input], FrameStep::FIRST).unwrap_or_else(|error| panic!("{error}"));
    session.output("display").unwrap_or_else(|error| panic!("{error}")).bytes
}

fn differing(left: &[u8], right: &[u8]) -> (usize, u8) {
    assert_eq!(left.len(), right.len());
    let pairs = || left.iter().zip(right).map(|(left, right)| left.abs_diff(*right));
    (pairs().filter(|off| *off > 0).count(), pairs().max().unwrap_or(0))
}

#[test]
fn a_camera_shows_what_the_program_makes_of_its_image() {
    let own = folder("pass");
    std::fs::write(own.join("pass.ron"), PASS).expect("it can be written");
    let light = Shown::new(&own, "pass.ron", TextureFormat::Rgba16Float, |look| look).settled();
    let scene = Texels { desc: afterimage_graph::image::ImageDesc::new(Size::new(SIZE.x, SIZE.y)), bytes: light };
    for pipeline in ["lynx.ron", "caracal.ron", "glare.ron"] {
        let wanted = rendered(pipeline, &scene);
        for target in [Target::MainTexture, Target::Output] {
            let with_target = |mut look: Afterimage| {
                look.target = target;
                look
            };
            let mut shown = Shown::new(&pipelines(), pipeline, TextureFormat::Rgba8UnormSrgb, with_target);
            assert_eq!(differing(&shown.settled(), &wanted), (0, 0), "{pipeline}, {target:?}");
        }
    }
    std::fs::remove_dir_all(own).expect("it is there");
}

#[test]
fn changes_come_in_while_the_program_runs() {
    let own = folder("changes");
    let text = std::fs::read_to_string(pipelines().join("lynx.ron")).expect("it is in the repository");
    let file = own.join("look.ron");
    let write = |text: &str| std::fs::write(&file, text).expect("it can be written");
    write(&text);
    let mut shown = Shown::new(&own, "look.ron", TextureFormat::Rgba8UnormSrgb, |look| look);
    let first = shown.settled();
    let set = |shown: &mut Shown, strength: Option<f32>| {
        let world = shown.app.world_mut();
        let mut look = world.query::<&mut Afterimage>().single_mut(world).expect("there is one camera");
        look.parameters.clear();
        look.parameters.extend(strength.map(|strength| ("lit.strength".to_owned(), strength.into())));
    };
    set(&mut shown, Some(0.9));
    shown.once("more of the bloom is seen", |now| differing(&first, now).1 > 20);
    set(&mut shown, None);
    shown.once("the value of the file is back", |now| differing(&first, now) == (0, 0));
    // A file that is wrong changes nothing.
    write(&text.replace("Composite(", "Compsite("));
    for _ in 0..20 {
        shown.run(5);
        assert_eq!(differing(&first, &shown.shown()), (0, 0));
    }
    write(&text.replace("strength: 0.15", "strength: 0.9"));
    shown.once("the file is read again", |now| differing(&first, now).1 > 20);
    std::fs::remove_dir_all(own).expect("it is there");
}
