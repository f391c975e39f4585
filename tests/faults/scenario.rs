//! The steps of a program with a device: open, load, render, resize, reload, read back.

use std::time::Duration;

use afterimage::host::PostError;
use afterimage::offline::{Session, timing};
use afterimage_gpu::{FrameKind, FrameStep, Gpu, InputImage, Texels};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_plan::Options;

use crate::support::gpu::graph;

/// A pipeline with reductions, memory of two kinds, a shared heap and, where draws are preferred, draws.
fn pipeline(stops: f32, sigma: f32, more: &str) -> Graph {
    graph(&format!(
        r#"Pipeline(
            inputs: {{ "scene": Color }},
            nodes: {{
                "bins": Histogram(source: "scene"),
                "meter": AutoExposure(histogram: "bins"),
                "exposed": Exposure(source: "scene", meter: "meter", stops: {stops:?}),
                "soft": Gaussian(source: "exposed", sigma: {sigma:?}),
                "lit": Composite(base: "exposed", bloom: "soft@previous"),
                {more}
                "mapped": ToneMap(source: "lit"),
                "encoded": Encode(source: "mapped", transfer: Srgb),
            }},
            outputs: {{ "display": "encoded" }},
        )"#
    ))
}

/// The pipelines of a scenario: the first one, one with other kernels, and that one with other numbers.
pub struct Pipelines {
    first: Graph,
    edited: Graph,
    brighter: Graph,
}

impl Pipelines {
    pub fn new() -> Self {
        let wide = r#""wide": Gaussian(source: "lit", sigma: 2.0), "glow": Composite(base: "lit", bloom: "wide"),"#;
        let [edited, brighter] = [0.5, 1.0].map(|stops| pipeline(stops, 5.0, wide));
        Self { first: pipeline(0.5, 3.0, ""), edited, brighter }
    }
}

/// The results of a run of the scenario.
#[derive(Default)]
pub struct Seen {
    /// The images that were read back, with the names of the steps.
    pub shown: Vec<(&'static str, Vec<Texels>)>,
    /// After an error of a session that had rendered: what the old plan renders, or why not.
    pub after: Option<Result<Vec<Texels>, PostError>>,
    /// The device: it is closed with this.
    pub gpu: Option<Gpu>,
}

/// The whole scenario on a device of its own, with dispatches and again with draws.
///
/// # Errors
/// The first error.
pub fn run(instance: &wgpu::Instance, pipelines: &Pipelines, seen: &mut Seen) -> Result<(), PostError> {
    let gpu = seen.gpu.insert(pollster::block_on(Gpu::open_on(instance, None))?).clone();
    for prefer_fragment in [false, true] {
        let mut gpu = gpu.clone();
        gpu.caps.prefer_fragment = prefer_fragment;
        let graph = pipelines.first.clone();
        let session = Session::with_pipeline_cache(&gpu, graph, Facts::default(), Options::default(), &[]);
        let mut program = Program { session, images: Vec::new() };
        if let Err(error) = program.run(pipelines, seen) {
            seen.after = program.after();
            return Err(error);
        }
    }
    gpu.wait()?;
    Ok(())
}

struct Program {
    session: Session,
    /// The images of the last frame that was rendered.
    images: Vec<InputImage>,
}

impl Program {
    fn run(&mut self, pipelines: &Pipelines, seen: &mut Seen) -> Result<(), PostError> {
        self.frames("load", Size::new(16, 9), seen)?;
        self.frames("resize", Size::new(24, 16), seen)?;
        self.session.value("meter.result")?.expect("the plan has this value");
        self.session.change(pipelines.edited.clone(), Options::default());
        self.frames("reload", Size::new(24, 16), seen)?;
        self.session.change(pipelines.brighter.clone(), Options::default());
        self.frames("numbers", Size::new(24, 16), seen)?;
        self.session.change(pipelines.first.clone(), Options::default());
        self.swap(seen)?;
        let frames = [true, false]
            .map(|reset| (self.images.clone(), FrameStep { time: 0.0, dt: 0.1, kind: FrameKind::cut_if(reset) }));
        for texels in self.session.render_all(&frames, false)? {
            seen.shown.push(("read", texels));
        }
        let images = self.images.clone();
        timing::pass_times_once(&mut self.session, &images, FrameStep::FIRST)?;
        self.session.post().executor().pipeline_cache_data();
        Ok(())
    }

    /// A first frame and another one.
    fn frames(&mut self, step: &'static str, size: Size, seen: &mut Seen) -> Result<(), PostError> {
        for frame in [FrameStep::FIRST, FrameStep { time: 0.1, dt: 0.1, kind: FrameKind::Next }] {
            let images = vec![self.scene(size)?];
            self.session.render(size, &images, frame)?;
            self.images = images;
            seen.shown.push((step, self.outputs()?));
        }
        Ok(())
    }

    /// Another plan is compiled while the old one renders.
    fn swap(&mut self, seen: &mut Seen) -> Result<(), PostError> {
        let plan = self.session.plan_for(Size::new(24, 16), &self.images.clone())?;
        let preparation = self.session.post().executor().prepare(plan);
        while !preparation.is_ready() {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.session.submit(&self.images.clone(), FrameStep::FIRST)?;
        seen.shown.push(("prepared", self.outputs()?));
        self.session.post().executor().swap(preparation)?;
        self.frames("swapped", Size::new(24, 16), seen)
    }

    fn scene(&mut self, size: Size) -> Result<InputImage, PostError> {
        let light = |index: u32| [0.01 * index as f32, 0.5, 2.0 / (1 + index % 7) as f32, 1.0];
        let pixels: Vec<[f32; 4]> = (0..size.width * size.height).map(light).collect();
        let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
        Ok(self.session.feed("scene", texels.desc, &texels.bytes)?)
    }

    fn outputs(&mut self) -> Result<Vec<Texels>, PostError> {
        let names: Vec<String> = self.session.plan().outputs.iter().map(|output| output.name.clone()).collect();
        names.iter().map(|name| Ok(self.session.output(name)?)).collect()
    }

    /// A first frame of the plan that is loaded, if one is.
    fn after(mut self) -> Option<Result<Vec<Texels>, PostError>> {
        self.session.post().plan()?;
        let images = self.images.clone();
        (!images.is_empty()).then(|| {
            self.session.submit(&images, FrameStep::FIRST)?;
            self.outputs()
        })
    }
}
