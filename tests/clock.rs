//! `measure` and `bench` report the same quantity: the time of a frame, by the one clock.

use afterimage::offline::Session;
use afterimage_gpu::{Clock, FrameTime, Gpu, input_image};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_lab::LabError;
use afterimage_lab::bench::{BenchOptions, bench};
use afterimage_lab::measure::{MeasureOptions, Pipeline, SequenceOptions, VariantKind, json, measure};
use afterimage_plan::{Options, PlacedPlan};

use crate::support::gpu::{built_in, gpu, registry};

const SIZE: Size = Size { width: 64, height: 36, depth: 1 };

/// The frame of the pipeline as written, and the report as JSON.
fn measured(gpu: &Gpu, graph: &Graph, samples: u32) -> (FrameTime, serde_json::Value) {
    let clips = SequenceOptions {
        images: Vec::new(),
        inputs: Vec::new(),
        charts: false,
        scene: true,
        sizes: vec![SIZE],
        walk: 1,
        frames: None,
        fps: 24.0,
        budget: afterimage_media::default_budget(),
    };
    let options = MeasureOptions {
        sequences: clips,
        facts: Facts::default(),
        options: Options::default(),
        samples: Some(samples),
        output: None,
        display: None,
        tiers_only: true,
        error_images: None,
    };
    let pipeline = Pipeline { name: "lynx".into(), written: graph.clone(), tier: None, tiers: Vec::new() };
    let report = measure(gpu, &registry(), &pipeline, &options, &()).unwrap_or_else(|error| panic!("{error}"));
    let at = report.rows.iter().position(|row| row.kind == VariantKind::Written).expect("the pipeline as written");
    (report.rows[at].worst().cost.time, json(&report)["rows"][at].clone())
}

/// The frame of the same pipeline, and the report as JSON.
fn benched(gpu: &Gpu, graph: &Graph, samples: u32) -> (FrameTime, serde_json::Value) {
    let options =
        BenchOptions { size: SIZE, samples, finite: false, facts: Facts::default(), options: Options::default() };
    let load = || Ok::<_, LabError>(graph.clone());
    let report = bench(gpu, &registry(), "lynx", &load, &options).unwrap_or_else(|error| panic!("{error}"));
    (report.frame.time(), serde_json::to_value(&report).expect("names and numbers are JSON"))
}

/// Only the clock makes a `FrameTime`, and only `timing::frame_time` gives the clock a frame.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn measure_and_bench_time_a_frame_by_the_same_function() {
    let gpu = gpu();
    let graph = built_in("lynx.ron", None);
    let source = Clock::new(&gpu).expect("the device is not lost").source();
    for (time, json) in [measured(&gpu, &graph, 3), benched(&gpu, &graph, 3)] {
        assert_eq!((time.source(), time.samples()), (source, 3));
        assert!(time.ms() > 0.0);
        assert_eq!(json["gpu_ms"].as_f64(), Some(time.ms()));
        assert_eq!(json["clock"], source.name());
    }
}

/// `measure` runs the reference first, whose images are twice as large; `bench` runs nothing else.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_is_timed_in_the_memory_of_its_own_plan_whatever_ran_before() {
    let (gpu, graph) = (gpu(), built_in("lynx.ron", None));
    let desc = ImageDesc::new(Size::new(320, 180));
    let texels = vec![0; desc.bytes() as usize];
    let images = [input_image(&gpu, "scene", desc, &texels).expect("the device has room")];
    let exact = Options { exact: true, ..Options::default() };
    let mut session = Session::new(&gpu, graph.clone(), Facts::default(), exact);
    session.load(desc.size, &images).expect("the plan is loaded");
    session.change(graph, Options::default());
    let plan = session.load(desc.size, &images).expect("the plan is loaded").clone();
    let own = PlacedPlan::new(plan);
    let kept = session.post().executor().loaded().expect("a plan is loaded").placed_plan();
    assert_ne!(kept.placement, own.placement, "the session keeps the larger heap of the reference");
    let mut timed = session.clone_with_fresh_allocations(&images).expect("the device has room");
    assert_eq!(timed.post().executor().loaded().expect("a plan is loaded").placed_plan(), own);
}
