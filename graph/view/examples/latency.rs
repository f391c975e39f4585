//! Latency from a change to the submitted commands, CPU time of the viewer, and growth of its memory.
//!
//! `cargo run --release -p afterimage-view --example latency [CHANGES]`

#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use afterimage_gpu::{Gpu, Opening, wgpu};
use afterimage_graph::check::{Loader as _, Saver};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::image::Size;
use afterimage_graph::node::{Registry, folder_kind_sharing};
use afterimage_graph::value::Value;
use afterimage_media::FileWatch;
use afterimage_pipelines::BuiltIn;
use afterimage_view::{
    Checked, FrameTarget, Images, Model, NewFiles, Problem, Project, Scene, Target, TextProject, UiRenderer,
};

const WINDOW: [u32; 2] = [1280, 720];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A pipeline in files of a folder that is removed in the end: its text, and a node kind.
struct Written {
    folder: PathBuf,
    watch: FileWatch,
    registry: Option<Registry>,
    /// Milliseconds that the last check has taken.
    checked: Rc<Cell<f64>>,
}

const TEXT: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 0.5),
        "tinted": Tinted(source: "exposed"),
        "mapped": ToneMap(source: "tinted", curve: AcesNarkowicz),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display" },
)"#;
const KIND: &str = r#"Kind(
    name: "Tinted",
    doc: "A tint.",
    inputs: { "source": Image(doc: "The image.") },
    outputs: { "result": Image(doc: "The tinted image.", state: Same("source")) },
    parameters: {},
)"#;

/// The shader of the kind, with a number.
fn shader(number: f64) -> String {
    format!("fn tinted(source: vec4f) -> vec4f {{ return source * vec4f(1.0, {number:?}, 1.0, 1.0); }}")
}

impl Written {
    /// Writes the files. `wake` hears of their changes.
    fn new(text: &str, wake: Sender<()>) -> io::Result<Self> {
        let folder = std::env::temp_dir().join(format!("afterimage-latency-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("look.ron"), text)?;
        std::fs::write(folder.join("tinted.wgsl"), shader(0.5))?;
        let mut watch = FileWatch::new(move || wake.send(()).unwrap_or_default());
        watch.extend([folder.join("look.ron"), folder.join("tinted.wgsl")]);
        Ok(Self { folder, watch, registry: None, checked: Rc::default() })
    }

    fn registry(&self) -> Result<Registry, Diagnostics> {
        let wgsl = std::fs::read_to_string(self.folder.join("tinted.wgsl")).expect("it was written");
        let kind = folder_kind_sharing(("node.ron", KIND), &[("tinted.wgsl", &wgsl)], &[])?;
        Ok(Registry::new(&[afterimage_nodes::ALL, &[kind]]).expect("the names differ"))
    }

    fn forget(&mut self, changed: &BTreeSet<PathBuf>) {
        if changed.iter().any(|path| path.ends_with("tinted.wgsl")) {
            self.registry = None;
        }
    }

    fn checked(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        let registry = self.registry.take().map_or_else(|| self.registry(), Ok)?;
        let checked = Checked::of("look.ron", text, tier, &registry, &BuiltIn);
        self.registry = Some(registry);
        checked
    }
}

impl Drop for Written {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Project for Written {
    fn name(&self) -> String {
        "look.ron".into()
    }
    fn read(&mut self) -> Result<Option<String>, Diagnostics> {
        Ok(Some(std::fs::read_to_string(self.folder.join("look.ron")).expect("it was written")))
    }
    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        let begin = Instant::now();
        let checked = self.checked(text, tier);
        self.checked.set(milliseconds(begin));
        checked
    }
    fn has_changed(&mut self) -> bool {
        let changed = self.watch.changed();
        self.forget(&changed);
        !changed.is_empty()
    }
    fn with_saver(&self, text: &str, ask: &mut dyn FnMut(&Saver<'_>)) -> Result<(), Diagnostics> {
        ask(&Saver::new("look.ron", text, &self.registry()?, &BuiltIn)?);
        Ok(())
    }
    fn file(&self, path: &str) -> Result<Arc<[u8]>, String> {
        BuiltIn.load(path)
    }
    fn has_place(&self) -> bool {
        false
    }
    fn write(&mut self, _: &str) -> Result<String, String> {
        Err("nothing is saved".into())
    }
}

/// A viewer on a texture.
struct Bench {
    ui: UiRenderer,
    view: wgpu::TextureView,
    gpu: Gpu,
}

impl Bench {
    fn new(gpu: &Gpu, project: Box<dyn Project>, size: Size) -> Result<Self, Problem> {
        let scene = Scene::new(gpu, size)?;
        let model = Model::new(gpu, project, Images::Scene(Box::new(scene)));
        let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: WINDOW[0], height: WINDOW[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let nothing = Problem::message("nothing is dropped or saved");
        let refused = nothing.clone();
        let new_files = NewFiles::Asked(Box::new(move |_, _| Err(refused.clone())));
        let mut bench = Self {
            ui: UiRenderer::new(model, FORMAT, Box::new(move |_| Err(nothing.clone())), new_files),
            view: target.create_view(&Default::default()),
            gpu: gpu.clone(),
        };
        (0..8).for_each(|_| bench.frame());
        Ok(bench)
    }

    fn model(&mut self) -> &mut Model {
        &mut self.ui.viewer.model
    }

    fn frame(&mut self) {
        let size = egui::vec2(WINDOW[0] as f32, WINDOW[1] as f32);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            ..Default::default()
        };
        self.ui.frame(input, FrameTarget { view: &self.view, size: WINDOW }, 1.0 / 60.0);
    }

    /// Milliseconds of the processor for the pipeline's part of a frame alone.
    fn pipeline(&mut self) -> f64 {
        let gpu = self.gpu.clone();
        let begin = Instant::now();
        let mut encoder = gpu.encoder();
        self.ui.viewer.render(&mut encoder, 1.0 / 60.0);
        gpu.queue.submit([encoder.finish()]);
        let passed = milliseconds(begin);
        let _ = gpu.wait();
        passed
    }

    /// Milliseconds from a change to the submission of the first frame that has it, and to the end of that frame.
    fn after(&mut self, change: impl FnOnce(&mut Model)) -> [f64; 2] {
        let begin = Instant::now();
        change(self.model());
        self.until_in(begin)
    }

    /// The same from the event of a file, and what the check took of that.
    fn after_file(&mut self, (path, text): (&Path, &str), files: &Heard) -> io::Result<[f64; 3]> {
        files.reports.try_iter().for_each(drop);
        let mut file = File::create(path)?;
        file.write_all(text.as_bytes())?;
        let begin = Instant::now();
        // The event: the system reports the change now.
        drop(file);
        while !self.model().follow_files(None) {
            let _ = files.reports.recv_timeout(Duration::from_millis(100));
        }
        let [submitted, finished] = self.until_in(begin);
        Ok([submitted, finished, files.checked.get()])
    }

    fn until_in(&mut self, begin: Instant) -> [f64; 2] {
        loop {
            let gpu = self.gpu.clone();
            let mut encoder = gpu.encoder();
            self.ui.viewer.render(&mut encoder, 1.0 / 60.0);
            let is_in = !self.model().shown().is_some_and(|shown| shown.is_changing());
            gpu.queue.submit([encoder.finish()]);
            if is_in {
                let submitted = milliseconds(begin);
                let _ = gpu.wait();
                return [submitted, milliseconds(begin)];
            }
            // Longer than the host needs for a frame, and shorter than a screen does.
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Reports of a written pipeline.
struct Heard {
    folder: PathBuf,
    reports: Receiver<()>,
    checked: Rc<Cell<f64>>,
}

/// A viewer on a pipeline in files.
fn written(gpu: &Gpu, text: &str, size: Size) -> Result<(Bench, Heard), Box<dyn std::error::Error>> {
    let (wake, reports) = channel();
    let project = Written::new(text, wake)?;
    let heard = Heard { folder: project.folder.clone(), reports, checked: project.checked.clone() };
    let bench = Bench::new(gpu, Box::new(project), size).map_err(|problem| problem.to_string())?;
    Ok((bench, heard))
}

/// Changes of a number in a file, and of a shader.
fn files(gpu: &Gpu, [large, small]: [Size; 2]) -> Result<(), Box<dyn std::error::Error>> {
    let (_, tsushima) =
        afterimage_pipelines::PIPELINES.iter().find(|(name, _)| *name == "tsushima").expect("it is there");
    let (before, after) = tsushima.split_once("strength: 0.015").ok_or("the pipeline has another strength")?;
    let (mut bench, heard) = written(gpu, tsushima, large)?;
    let path = heard.folder.join("look.ron");
    let mut number =
        |index: usize| bench.after_file((&path, &format!("{before}strength: 0.01{index:03}{after}")), &heard);
    // The first change of a number makes a plan in which it may change.
    number(999)?;
    file_rows("a number in the file", (0..200).map(number).collect::<io::Result<_>>()?);
    drop(bench);
    let (mut bench, heard) = written(gpu, TEXT, small)?;
    let path = heard.folder.join("tinted.wgsl");
    let change = |index: usize| bench.after_file((&path, &shader(0.501 + index as f64 * 1e-3)), &heard);
    file_rows("a shader of one node in its file", (0..60).map(change).collect::<io::Result<_>>()?);
    Ok(())
}

/// Milliseconds of the driver to compile a new pass of one line: a lower bound for a changed shader.
fn driver(gpu: &Gpu) -> f64 {
    static NUMBER: AtomicU32 = AtomicU32::new(1);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let code = format!(
        "@group(0) @binding(0) var<storage, read_write> out: array<f32>;\n\
         @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{ out[id.x] *= {number}.5; }}"
    );
    let begin = Instant::now();
    let source = wgpu::ShaderSource::Wgsl(code.into());
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let _pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    milliseconds(begin)
}

fn file_rows(what: &str, times: Vec<[f64; 3]>) {
    row(&format!("{what}: reading and checking"), times.iter().map(|[_, _, checked]| *checked).collect());
    rows(what, times.into_iter().map(|[submitted, finished, _]| [submitted, finished]));
}

fn milliseconds(begin: Instant) -> f64 {
    begin.elapsed().as_secs_f64() * 1e3
}

fn row(what: &str, mut times: Vec<f64>) {
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times[((times.len() - 1) as f64 * part) as usize];
    println!("{what:<58} median {:8.3} ms, 95 % {:8.3} ms, of {}", at(0.5), at(0.95), times.len());
}

/// The rows of a change: to the submission, and to the end of the frame.
fn rows(what: &str, times: impl Iterator<Item = [f64; 2]>) {
    let (submitted, finished) = times.map(|[submitted, finished]| (submitted, finished)).unzip();
    row(&format!("{what}, to submit"), submitted);
    row(&format!("{what}, to the end of the frame"), finished);
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let changes: usize = std::env::args().nth(1).map_or(Ok(2000), |text| text.parse())?;
    let gpu = Gpu::open(&Opening::default())?;
    println!("{}", gpu.name());
    let small = Size::new(320, 180);
    let opened = |name: &str, size| {
        let project = TextProject::built_in(name).ok_or("no such pipeline")?;
        Bench::new(&gpu, Box::new(project), size).map_err(|problem| problem.to_string())
    };
    let size = if gpu.is_processor() { small } else { Size::new(1280, 720) };
    println!("tsushima at {size}, a window of {}x{}", WINDOW[0], WINDOW[1]);
    let mut bench = opened("tsushima", size)?;
    let strength = Target::Parameter("lit.strength".into());
    bench.after(|model| model.set(&strength, Some(Value::Float(0.1))));
    let number = |index: usize| Some(Value::Float(0.1 + index as f64 * 1e-4));
    rows("a number", (0..200).map(|i| bench.after(|model| model.set(&strength, number(i)))));
    row("the pipeline's commands for a frame", (0..200).map(|_| bench.pipeline()).collect());
    let whole = (0..200).map(|_| {
        let begin = Instant::now();
        bench.frame();
        let passed = milliseconds(begin);
        let _ = gpu.wait();
        passed
    });
    row("a frame with the user interface", whole.collect());
    let curve = Target::Parameter("mapped.curve".into());
    let names = ["AcesNarkowicz", "Uchimura", "Hable"];
    let choose = |index: usize| Some(Value::Choice(names[index % names.len()]));
    rows("a choice that needs a plan", (0..60).map(|i| bench.after(|model| model.set(&curve, choose(i)))));
    files(&gpu, [size, small])?;
    row("a new pass of one line, by the driver alone", (0..30).map(|_| driver(&gpu)).collect());
    let mut bench = opened("lynx", Size::new(64, 36))?;
    println!("{changes} reloads and moves of a slider at 64x36: memory and open files");
    for index in 0..changes {
        let value = Some(Value::Float(0.05 + (index % 100) as f64 * 0.01));
        bench.after(|model| model.set(&Target::Parameter("lit.strength".into()), value));
        bench.model().release();
        bench.after(Model::reload);
        bench.frame();
        if index % (changes / 8).max(1) == 0 || index + 1 == changes {
            println!("  {:>6}  {:8.1} MiB  {:>4}", index, held(), open_files());
        }
    }
    Ok(())
}

/// MiB of memory that the process holds.
fn held() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok()).unwrap_or(f64::NAN);
    pages * 4096.0 / f64::from(1 << 20)
}

fn open_files() -> usize {
    std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count)
}
