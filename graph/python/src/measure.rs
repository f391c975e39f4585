//! `Pipeline.measure`: time against error.

use afterimage::offline::Offline;
use afterimage_graph::image::Size;
use afterimage_lab::measure::{self, MeasureOptions, SequenceOptions};
use afterimage_media::default_budget;
use afterimage_plan::Options;

use crate::error::Failure;

/// The report of the program's `measure --json`. Without images it is that of the built-in scene.
pub(crate) fn report(look: &Offline, images: Vec<String>, tiers_only: bool, frames: u32) -> Result<String, Failure> {
    let options = MeasureOptions {
        sequences: SequenceOptions {
            images,
            inputs: Vec::new(),
            scene: false,
            charts: false,
            sizes: vec![Size::new(1280, 720)],
            walk: frames,
            frames: None,
            fps: 24.0,
            budget: default_budget(),
        },
        facts: look.facts().clone(),
        options: Options::default(),
        samples: None,
        output: None,
        display: None,
        tiers_only,
        error_images: None,
    };
    let mut tiers = Vec::new();
    for tier in look.tiers() {
        let graph = look.graph_at(Some(&tier))?;
        tiers.push((tier, graph));
    }
    let (written, tier) = (look.graph().clone(), look.tier().map(str::to_owned));
    let pipeline = measure::Pipeline { name: look.name().to_owned(), written, tier, tiers };
    let report = measure::measure(&look.gpu()?, look.registry(), &pipeline, &options, &())?;
    Ok(measure::json(&report).to_string())
}
