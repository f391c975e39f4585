//! `Pipeline.measure`: time against error.

use afterimage_gpu::Gpu;
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_lab::measure::{self, ClipOptions, MeasureOptions};
use afterimage_media::default_budget;
use afterimage_plan::Options;

use crate::error::Failure;

/// The pipeline that is measured.
pub(crate) struct Measured {
    pub(crate) name: String,
    pub(crate) graph: Graph,
    pub(crate) tier: Option<String>,
    pub(crate) tiers: Vec<(String, Graph)>,
    pub(crate) facts: Facts,
}

/// The report of the program's `measure --json`. Without images it is that of the built-in scene.
pub(crate) fn report(
    gpu: &Gpu,
    registry: &Registry,
    measured: Measured,
    images: Vec<String>,
    tiers_only: bool,
    frames: u32,
) -> Result<String, Failure> {
    let options = MeasureOptions {
        clips: ClipOptions {
            images,
            inputs: Vec::new(),
            scene: false,
            charts: false,
            size: Size::new(1280, 720),
            walk: frames,
            frames: None,
            fps: 24.0,
            budget: default_budget(),
        },
        facts: measured.facts,
        options: Options::default(),
        samples: None,
        output: None,
        tiers_only,
        error_images: None,
    };
    let Measured { name, graph, tier, tiers, .. } = measured;
    let pipeline = measure::Pipeline { name, written: graph, tier, tiers };
    let report = measure::measure(gpu, registry, &pipeline, &options, &())?;
    Ok(measure::json(&report).to_string())
}
