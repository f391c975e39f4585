//! The one place that knows how tests reach a GPU. No adapter is a failure, unless `AFTERIMAGE_NO_GPU=1`.

use std::sync::{Arc, OnceLock};

use afterimage::offline::Session;
use afterimage_gpu::{Gpu, Opening, Texels, wgpu};
use afterimage_graph::check::{CheckOptions, Checker, Facts, Graph, Loader, NoFiles, check};
use afterimage_graph::document::{Document, parse};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::{BlockData, Camera, NodeKind, Registry};
use afterimage_plan::{HostImageDesc, HostInputs, Options, Plan};

use super::sequence::Sequence;

/// An image of four floats a pixel, as tests have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[f32; 4]>,
}

impl Picture {
    pub fn new(width: u32, height: u32, mut pixel: impl FnMut(u32, u32) -> [f32; 4]) -> Self {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Self { width, height, pixels }
    }

    /// The texels of an image, as floats.
    pub fn of(texels: &Texels) -> Self {
        Self { width: texels.desc.size.width, height: texels.desc.size.height, pixels: texels.to_floats() }
    }

    pub fn at(&self, x: u32, y: u32) -> [f32; 4] {
        self.pixels[(y * self.width + x) as usize]
    }
}

/// Another device of the adapter, with these features and limits. Plans for it have the capabilities of the first.
pub fn another_device(gpu: &Gpu, required_features: wgpu::Features, required_limits: wgpu::Limits) -> Gpu {
    let descriptor = wgpu::DeviceDescriptor { required_features, required_limits, ..Default::default() };
    let opened = pollster::block_on(gpu.adapter.request_device(&descriptor));
    let (device, queue) = opened.unwrap_or_else(|error| panic!("{error}"));
    Gpu::with_caps(&gpu.adapter, &device, &queue, gpu.caps.clone())
}

/// The shared device, which finishes its work when this is dropped. Nobody drops the device itself, which would wait: a
/// process that ends while llvmpipe still compiles a shader crashes, because the compiler is taken down under it.
#[derive(Clone)]
pub struct Shared(Gpu);

impl Shared {
    /// A device of one test, which likewise finishes its work.
    pub fn of(gpu: Gpu) -> Self {
        Self(gpu)
    }
}

impl std::ops::Deref for Shared {
    type Target = Gpu;

    fn deref(&self) -> &Gpu {
        &self.0
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // A device that was lost has no work.
        drop(self.0.wait());
    }
}

/// The shared device, which tests use at the same time.
pub fn gpu() -> Shared {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    super::layer::listen();
    let open = || match Gpu::open(&Opening {
        adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(),
        validation: true,
        ..Opening::default()
    }) {
        Ok(gpu) => gpu,
        Err(error) => panic!("GPU tests need an adapter: {error}; AFTERIMAGE_NO_GPU=1 reports them as ignored"),
    };
    Shared(GPU.get_or_init(open).clone())
}

/// The built-in kinds and the plug-in's.
pub fn registry() -> Registry {
    Registry::new(&[afterimage_nodes::ALL, halftone::ALL]).expect("no two kinds share a name")
}

/// Reads files of the repository, for pipelines that name some.
pub struct Repository;

impl Loader for Repository {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(path).map(Into::into).map_err(|error| error.to_string())
    }
}

/// The folder of built-in pipelines.
pub fn pipelines() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../pipelines")
}

/// The graph of a built-in pipeline.
pub fn built_in(name: &str, tier: Option<&str>) -> Graph {
    changed(name, tier, &[])
}

/// The document of a built-in pipeline.
pub fn document(name: &str) -> Document {
    let path = pipelines().join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    parse(&path.to_string_lossy(), &text).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// The names of the tiers of a built-in pipeline.
pub fn tiers(name: &str) -> Vec<String> {
    Checker::new(&document(name), &registry(), &Repository).tiers()
}

/// The graph of a built-in pipeline with other values, as `--set` gives them.
pub fn changed(name: &str, tier: Option<&str>, sets: &[(&str, &str)]) -> Graph {
    let sets = sets.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect();
    let options = CheckOptions { tier: tier.map(str::to_owned), sets, loader: &Repository };
    check(&document(name), &registry(), &options).unwrap_or_else(|errors| panic!("{name}: {errors:?}")).0
}

/// The graph of a text, or its diagnostics as a panic.
pub fn graph(text: &str) -> Graph {
    graph_of(text, &registry())
}

/// The same with the built-in kinds and these.
pub fn graph_with(text: &str, kinds: &[NodeKind]) -> Graph {
    graph_of(text, &Registry::new(&[afterimage_nodes::ALL, kinds]).expect("no two kinds share a name"))
}

fn graph_of(text: &str, registry: &Registry) -> Graph {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// The slices of a volume whose picture has more rows than that; a picture of fewer rows has no other.
pub const SLICES: u32 = 4;

/// The settings of a run of a test pipeline.
pub struct Run<'a> {
    pub graph: &'a Graph,
    pub size: Size,
    pub options: Options,
    pub facts: Facts,
    pub prefer_fragment: bool,
    /// True if inputs are stored as half floats; otherwise in 32 bits.
    pub half_inputs: bool,
    /// The host's blocks, by the names of the inputs.
    pub blocks: Vec<(String, BlockData)>,
    /// The time of all frames, in seconds.
    pub time: f64,
    pub slices: u32,
}

impl<'a> Run<'a> {
    pub fn new(graph: &'a Graph) -> Self {
        let size = Size::new(1, 1);
        Self {
            graph,
            size,
            options: Options::default(),
            facts: Facts::default(),
            prefer_fragment: false,
            half_inputs: false,
            blocks: Vec::new(),
            time: 0.0,
            slices: SLICES,
        }
    }

    /// With a camera for the input `camera`.
    pub fn camera(mut self, camera: Option<&Camera>) -> Self {
        let data = camera.map(|camera| camera.data().expect("its matrices have inverses"));
        self.blocks.extend(data.map(|data| ("camera".to_owned(), data)));
        self
    }

    /// With a block of a camera for another input.
    pub fn block(mut self, input: &str, camera: &Camera) -> Self {
        self.blocks.push((input.to_owned(), camera.data().expect("its matrices have inverses")));
        self
    }

    /// Everything exact: 32-bit intermediates.
    pub fn exact(mut self) -> Self {
        self.options.exact = true;
        self
    }

    /// A session that renders it, on the shared device.
    pub fn session(&self, gpu: &Gpu) -> Session {
        let mut gpu = gpu.clone();
        gpu.caps.prefer_fragment = self.prefer_fragment;
        self.with_blocks(Session::new(&gpu, self.graph.clone(), self.facts.clone(), self.options))
    }

    /// A session of another run on the same device, as a new one; what it has compiled is kept.
    pub(super) fn reset(&self, mut session: Session) -> Session {
        session.reset(self.graph.clone(), self.facts.clone(), self.options);
        self.with_blocks(session)
    }

    fn with_blocks(&self, mut session: Session) -> Session {
        self.blocks.iter().for_each(|(name, data)| session.set_block(name, data.clone()));
        session
    }

    /// The plan for these pictures.
    pub fn plan(&self, gpu: &Gpu, inputs: &[(&str, &Picture)]) -> Plan {
        let given = |name: &str, picture: &Picture| {
            (name.to_owned(), HostImageDesc { desc: self.texels(name, picture).desc, finite: false })
        };
        let given = inputs.iter().map(|(name, picture)| given(name, picture)).collect();
        let blocks = self.blocks.iter().map(|(name, _)| name.clone()).collect();
        let given = HostInputs { inputs: given, blocks, ..HostInputs::none(self.size_for(inputs)) };
        let plan = self.session(gpu).post().plan_for(given);
        Arc::unwrap_or_clone(plan.unwrap_or_else(|error| panic!("{error}")))
    }

    /// The size of a frame with these pictures. Volumes say nothing of it.
    pub(super) fn size_for(&self, inputs: &[(&str, &Picture)]) -> Size {
        inputs
            .iter()
            .find(|(name, _)| !self.is_volume(name))
            .map_or(self.size, |(name, picture)| self.texels(name, picture).desc.size)
    }

    fn is_volume(&self, name: &str) -> bool {
        self.graph.inputs.iter().any(|input| input.name == name && input.volume)
    }

    /// The texels of an input. The picture of a multisampled one is four pictures, one for each sample, one below the
    /// other; that of a volume is `slices` pictures.
    pub(super) fn texels(&self, name: &str, picture: &Picture) -> Texels {
        let has_samples = self.graph.inputs.iter().any(|input| input.name == name && input.multisampled);
        let make = if self.half_inputs || has_samples { Texels::from_floats_as_half } else { Texels::from_floats };
        let mut texels = make(picture.width, picture.height, &picture.pixels);
        if has_samples {
            texels.desc = texels.desc.sized(Size::new(picture.width, picture.height / 4)).multisampled(4);
        }
        if self.is_volume(name) {
            let size = Size::volume(picture.width, picture.height / self.slices, self.slices);
            texels.desc = ImageDesc::volume(size).format(texels.desc.format);
        }
        texels
    }

    /// The outputs of one first frame, in the order of the file.
    pub fn frame(&self, inputs: &[(&str, &Picture)]) -> Vec<Picture> {
        self.frames(inputs, &[(0.0, true)]).pop().expect("one frame")
    }

    /// The outputs of the first frame with each of these inputs. One session makes all, so that pipelines are compiled
    /// once.
    pub fn first_frames(&self, all: &[&[(&str, &Picture)]]) -> Vec<Vec<Picture>> {
        let mut sequence = Sequence::new(self);
        let mut outputs = Vec::new();
        for inputs in all {
            sequence.restart();
            sequence.frame(inputs, 0.0, true);
            outputs.push(sequence.outputs());
        }
        outputs
    }

    /// The first output of the first frame with each of these pictures, for a pipeline with one input.
    pub fn shown(&self, pictures: &[&Picture]) -> Vec<Picture> {
        let name = &*self.graph.inputs[0].name;
        let inputs: Vec<[(&str, &Picture); 1]> = pictures.iter().map(|picture| [(name, *picture)]).collect();
        let inputs: Vec<&[(&str, &Picture)]> = inputs.iter().map(<[_; 1]>::as_slice).collect();
        self.first_frames(&inputs).into_iter().map(|mut outputs| outputs.swap_remove(0)).collect()
    }

    /// The outputs of several frames with the same inputs; each frame has a dt and a reset flag.
    pub fn frames(&self, inputs: &[(&str, &Picture)], frames: &[(f32, bool)]) -> Vec<Vec<Picture>> {
        let mut sequence = Sequence::new(self);
        let mut outputs = |(dt, reset): &(f32, bool)| {
            sequence.frame(inputs, *dt, *reset);
            sequence.outputs()
        };
        frames.iter().map(&mut outputs).collect()
    }
}

/// The outputs of one frame with 32-bit inputs and intermediates.
pub fn run_exact(text: &str, inputs: &[(&str, &Picture)]) -> Vec<Picture> {
    let graph = graph(text);
    Run::new(&graph).exact().frame(inputs)
}

/// The bytes of a texture whose texels have this many bytes, row by row without gaps.
pub fn texture_bytes(gpu: &Gpu, texture: &wgpu::Texture, texel: u32) -> Vec<u8> {
    let size = texture.size();
    let row = (texel * size.width).next_multiple_of(256);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * size.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, size);
    gpu.queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("it can be read"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
    let mapped = buffer.slice(..).get_mapped_range().expect("it is mapped");
    mapped.chunks_exact(row as usize).flat_map(|line| line[..(texel * size.width) as usize].to_vec()).collect()
}
