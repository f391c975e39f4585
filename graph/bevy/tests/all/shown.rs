//! Apps without a window, and what their cameras show.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};

use afterimage::wgpu::PollType;
use bevy::app::Plugins;
use bevy::camera::RenderTarget;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{Extent3d, TextureFormat, TextureUsages};
use bevy::render::renderer::RenderDevice;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, trigger_screenshots};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_afterimage::{Afterimage, AfterimagePlugin, AfterimageStatus};

/// When a test would never end.
const PATIENCE: Duration = Duration::from_secs(600);

pub(crate) const SIZE: UVec2 = UVec2::new(160, 90);

/// What is behind everything.
pub(crate) const BACKGROUND: LinearRgba = LinearRgba::rgb(0.02, 0.05, 0.1);

/// An app whose cameras render to an image.
pub(crate) struct Shown {
    pub(crate) app: App,
    pub(crate) target: RenderTarget,
    image: Handle<Image>,
    /// How many pictures have been asked for.
    asked: usize,
}

/// Pictures that have arrived, by their numbers.
#[derive(Resource, Default)]
struct Captured(BTreeMap<usize, Vec<u8>>);

impl Shown {
    /// An app without cameras, on a row of bright spheres that do not move.
    pub(crate) fn new(folder: &Path, format: TextureFormat) -> Self {
        Self::with_plugin(folder, format, AfterimagePlugin::default())
    }

    pub(crate) fn with_plugin<M>(folder: &Path, format: TextureFormat, ours: impl Plugins<M>) -> Self {
        let file_path = folder.to_string_lossy().into_owned();
        let assets = AssetPlugin { file_path, watch_for_changes_override: Some(true), ..default() };
        let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
        let plugins = DefaultPlugins.set(assets).set(window).disable::<WinitPlugin>().disable::<LogPlugin>();
        let mut app = App::new();
        app.add_plugins(plugins.disable::<PipelinedRenderingPlugin>())
            .add_plugins(ours)
            .insert_resource(ClearColor(BACKGROUND.into()))
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
        Self { app, target: RenderTarget::Image(image.clone().into()), image, asked: 0 }
    }

    /// The same with a camera in front of the spheres.
    pub(crate) fn with_camera(
        folder: &Path,
        pipeline: &str,
        format: TextureFormat,
        change: impl FnOnce(Afterimage) -> Afterimage,
    ) -> Self {
        let mut shown = Self::new(folder, format);
        let look = change(shown.look(pipeline));
        shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
        shown
    }

    pub(crate) fn look(&self, pipeline: &str) -> Afterimage {
        Afterimage::new(self.app.world().resource::<AssetServer>().load(pipeline.to_owned()))
    }

    /// A camera that looks at the middle of the spheres.
    pub(crate) fn spawn(&mut self, place: Vec3, parts: impl Bundle) -> Entity {
        let place = Transform::from_translation(place).looking_at(Vec3::new(place.x, 0.0, 0.0), Vec3::Y);
        let target = self.target.clone();
        let camera = self.app.world_mut().spawn((Camera3d::default(), Msaa::Off, place, target)).id();
        self.app.world_mut().entity_mut(camera).insert(parts);
        camera
    }

    /// The pipeline of the only camera that has one.
    pub(crate) fn change(&mut self, change: impl FnOnce(&mut Afterimage)) {
        let world = self.app.world_mut();
        change(&mut world.query::<&mut Afterimage>().single_mut(world).expect("there is one camera"));
    }

    pub(crate) fn status(&mut self) -> AfterimageStatus {
        let world = self.app.world_mut();
        world.query::<&AfterimageStatus>().single(world).expect("there is one camera").clone()
    }

    pub(crate) fn run(&mut self, frames: usize) {
        for _ in 0..frames {
            self.app.update();
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Gives the cameras' image another size.
    pub(crate) fn resize(&mut self, size: UVec2) {
        let size = Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
        let mut images = self.app.world_mut().resource_mut::<Assets<Image>>();
        images.get_mut(&self.image).expect("it is there").resize(size);
    }

    /// Asks for the cameras' image of the next frame. Returns the picture's number.
    fn ask(&mut self) -> usize {
        let number = self.asked;
        self.asked += 1;
        let capture = move |shot: On<ScreenshotCaptured>, mut captured: ResMut<Captured>| {
            captured.0.extend(shot.image.data.clone().map(|bytes| (number, bytes)));
        };
        let shot = match &self.target {
            RenderTarget::TextureView(view) => Screenshot::texture_view(*view),
            _ => Screenshot::image(self.image.clone()),
        };
        self.app.world_mut().spawn(shot).observe(capture);
        number
    }

    fn take(&mut self, number: usize) -> Option<Vec<u8>> {
        self.app.world_mut().resource_mut::<Captured>().0.remove(&number)
    }

    /// The bytes of the cameras' image after one more frame. No other frame runs until they are here: Bevy reads them in
    /// the pool in which it compiles the pipelines of all apps of this process, and that can take any time.
    pub(crate) fn shown(&mut self) -> Vec<u8> {
        let number = self.ask();
        self.run(1);
        self.wait("no screenshot arrives", |shown| {
            let world = shown.app.world_mut();
            world.resource::<RenderDevice>().wgpu_device().poll(PollType::Poll).expect("the device is there");
            world.run_system_cached(trigger_screenshots).expect("Bevy has it");
            std::thread::sleep(Duration::from_millis(1));
            shown.take(number)
        })
    }

    /// Goes on until there is a result. A time limit ends tests that would hang, and no others.
    pub(crate) fn wait<T>(&mut self, what: &str, mut next: impl FnMut(&mut Self) -> Option<T>) -> T {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(result) = next(self) {
                return result;
            }
        }
        let world = self.app.world_mut();
        let statuses: Vec<_> = world.query::<&AfterimageStatus>().iter(world).collect();
        panic!("{what}: not in {PATIENCE:?}, but {statuses:?}");
    }

    /// The images of all frames from now on until they are as wanted. `before` runs before each frame.
    pub(crate) fn frames(
        &mut self,
        what: &str,
        mut before: impl FnMut(&mut Self),
        are_wanted: impl Fn(&[Vec<u8>]) -> bool,
    ) -> Vec<Vec<u8>> {
        let mut frames = Vec::new();
        self.wait(what, |shown| {
            before(shown);
            frames.push(shown.shown());
            are_wanted(&frames).then_some(())
        });
        frames
    }

    /// The image once it is as wanted: files and shaders of the scene arrive after some frames.
    pub(crate) fn once(&mut self, what: &str, is_wanted: impl Fn(&[u8]) -> bool) -> Vec<u8> {
        self.wait(what, |shown| {
            shown.run(5);
            Some(shown.shown()).filter(|bytes| is_wanted(bytes))
        })
    }

    /// Runs until the status is as wanted.
    pub(crate) fn until(&mut self, what: &str, is_wanted: impl Fn(&AfterimageStatus) -> bool) -> AfterimageStatus {
        self.wait(what, |shown| {
            shown.run(1);
            Some(shown.status()).filter(&is_wanted)
        })
    }

    /// The image once it stays as it is and has many codes.
    pub(crate) fn settled(&mut self) -> Vec<u8> {
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

pub(crate) fn pipelines() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines")
}

/// A folder for the files of a test, which is removed at its end.
pub(crate) struct Folder(pub(crate) std::path::PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("bevy-afterimage-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder can be made");
        Self(folder)
    }

    pub(crate) fn write(&self, file: &str, text: &str) {
        let path = self.0.join(file);
        std::fs::create_dir_all(path.parent().expect("it is in the folder")).expect("a folder can be made");
        std::fs::write(path, text).expect("it can be written");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is in the folder of temporary files.
        drop(std::fs::remove_dir_all(&self.0));
    }
}
