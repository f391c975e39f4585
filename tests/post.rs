//! A pipeline as a host keeps it: parameters by handle, facts, tiers and sizes.

mod captured;
mod fade;
#[cfg(target_os = "linux")]
mod foreign;
mod governed;
mod images;
mod incoming;
mod names;
mod offline;
mod opened;
mod prepared;
mod rectangles;
mod redraw;
mod tools;
mod unsubmitted;

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::{ExpectedFrame, HostImage, PostError};
use afterimage::offline::Session;
use afterimage_gpu::{Frame, FrameKind, FrameStep, Gpu, InputImage, LoadedPlan, Texels, download, upload, wgpu};
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::value::Value;
use afterimage_nodes::{CompositeBlend, Curve};
use afterimage_plan::{Options, Plan};

use crate::support::gpu::{Picture, Shared, changed, gpu, registry};

/// A host with one scene.
struct Host {
    gpu: Shared,
    scene: wgpu::TextureView,
    post: Post,
    time: f64,
}

impl Host {
    fn new(graph: Graph) -> Self {
        let gpu = gpu();
        let post = Post::new(&gpu, graph);
        let scene = scene(&gpu, Size::new(96, 54));
        Self { gpu, scene, post, time: 0.0 }
    }

    fn frame(&mut self) -> Result<(), PostError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let (inputs, time) = (&[("scene", &self.scene)], self.time);
        let recorded = self.post.encode(
            &mut encoder,
            &Frame { inputs, time, dt: 0.1, kind: FrameKind::cut_if(time == 0.0), ..Frame::default() },
        );
        self.gpu.queue.submit([encoder.finish()]);
        self.time += 0.1;
        recorded
    }

    /// The display after a first frame.
    fn shown(&mut self) -> Vec<u8> {
        self.post.executor().count_from(0);
        self.time = 0.0;
        self.frame().unwrap_or_else(|error| panic!("{error}"));
        let texels = download(&self.gpu.device, &self.gpu.queue, self.post.output("display").unwrap());
        texels.unwrap_or_else(|error| panic!("{error}")).bytes
    }

    fn plan(&self) -> Arc<Plan> {
        self.post.plan().expect("a frame was rendered").clone()
    }
}

/// Light up to twenty times white, all of it different from pixel to pixel.
fn scene_texels(size: Size) -> Texels {
    let light = |x: u32, y: u32| {
        let (u, v) = (x as f32 / size.width as f32, y as f32 / size.height as f32);
        [0.1 + 20.0 * u * v, 0.2 + v, 0.3 + (u * 40.0).sin().abs(), 1.0]
    };
    let picture = Picture::new(size.width, size.height, light);
    Texels::from_floats_as_half(size.width, size.height, &picture.pixels)
}

/// The same on the device.
fn scene(gpu: &Gpu, size: Size) -> wgpu::TextureView {
    upload(&gpu.device, &gpu.queue, &scene_texels(size))
        .unwrap_or_else(|error| panic!("{error}"))
        .create_view(&Default::default())
}

#[track_caller]
fn assert_same(left: &[u8], right: &[u8]) {
    assert_eq!(left.len(), right.len());
    let differing = left.iter().zip(right).filter(|(left, right)| left != right).count();
    let worst = left.iter().zip(right).map(|(left, right)| left.abs_diff(*right)).max();
    assert_eq!(differing, 0, "bytes of {} differ, by at most {worst:?}", left.len());
}

/// What a pipeline shows if its file has these values.
fn fresh(name: &str, tier: Option<&str>, sets: &[(&str, &str)]) -> Vec<u8> {
    Host::new(changed(name, tier, sets)).shown()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_parameter_with_a_handle_follows_without_a_plan() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    let stops = host.post.parameter::<f32>("exposed.stops").unwrap();
    let before = host.shown();
    assert_same(&before, &fresh("lynx.ron", None, &[]));
    let plan = host.plan();
    for (value, text) in [(0.5_f32, "0.5"), (0.0, "0.0"), (0.15, "0.15")] {
        host.post.set(strength, value).unwrap();
        host.post.set(stops, 2.0 * value).unwrap();
        assert!(!host.post.is_changing(), "no plan is made");
        let shown = host.shown();
        let wanted = [("lit.strength", text), ("exposed.stops", &format!("{:?}", 2.0 * value))];
        // At a strength of 0 the plan without handles has no bloom, and another rounding.
        let mut wanted = Host::new(changed("lynx.ron", None, &wanted));
        wanted.post.control("lit.strength").unwrap();
        wanted.post.control("exposed.stops").unwrap();
        assert!(Arc::ptr_eq(&plan, &host.plan()));
        assert_same(&shown, &wanted.shown());
        assert!(shown != before, "the picture changes at {value}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_parameter_that_needs_a_plan_says_so_and_gets_it_in_the_background() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let curve = host.post.parameter::<Curve>("mapped.curve").unwrap();
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    assert!(host.post.needs_plan(curve.control()) && !host.post.needs_plan(strength.control()));
    let before = host.shown();
    let plan = host.plan();
    host.post.set(curve, Curve::Reinhard).unwrap();
    host.post.set(strength, 0.4).unwrap();
    assert!(host.post.is_changing());
    host.frame().unwrap();
    host.post.finish_changes().unwrap();
    assert!(!Arc::ptr_eq(&plan, &host.plan()));
    let shown = host.shown();
    assert!(shown != before);
    assert_same(&shown, &fresh("lynx.ron", None, &[("mapped.curve", "Reinhard"), ("lit.strength", "0.4")]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn wrong_names_types_and_values_are_errors_and_change_nothing() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let error = host.post.parameter::<f32>("lit.strenght").map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("`strength`"), "{error}");
    let error = host.post.parameter::<CompositeBlend>("lit.strength").map(|_| ()).unwrap_err().to_string();
    assert_eq!(error, "`lit.strength` is a number");
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    let before = host.shown();
    for wrong in [1e30, -1.0, f32::NAN, f32::INFINITY] {
        let error = host.post.set(strength, wrong).unwrap_err().to_string();
        assert!(error.starts_with("`lit.strength`: `strength` must be"), "{error}");
    }
    assert!(host.post.set_value(strength.control(), Value::Bool(true)).is_err());
    assert_eq!(host.post.value(strength.control()), Some(&Value::Float(0.15)));
    assert_same(&host.shown(), &before);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_tier_keeps_what_the_host_has_set() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    host.post.set(strength, 0.25).unwrap();
    host.frame().unwrap();
    for tier in [Some("low"), Some("high"), None] {
        host.post.change(changed("lynx.ron", tier, &[]));
        host.frame().unwrap();
        host.post.finish_changes().unwrap();
        assert_same(&host.shown(), &fresh("lynx.ron", tier, &[("lit.strength", "0.25")]));
    }
    host.post.unset(strength.control()).unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[]));
    host.post.set(strength, 0.25).unwrap();
    host.post.change(changed("grade.ron", None, &[]));
    assert_eq!(host.post.value(strength.control()), Some(&Value::Float(0.25)), "it has no such parameter");
    host.post.set(strength, 0.5).unwrap();
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("grade.ron", None, &[]));
    host.post.change(changed("lynx.ron", None, &[]));
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[("lit.strength", "0.5")]));
}

/// The next frame evaluates the LUT again, with the same plan; a parameter outside of the LUT, and a cut, do not.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_parameter_of_a_baked_lut_needs_no_plan() {
    let mut host = Host::new(changed("lynx.ron", Some("high"), &[]));
    let [hue, strength] = ["mapped.keep_hue", "lit.strength"].map(|name| host.post.parameter::<f32>(name).unwrap());
    host.shown();
    let plan = host.plan();
    assert_eq!(plan.savings.baked.len(), 1, "{}", plan.to_text());
    assert!(host.post.executor().loaded().is_some_and(LoadedPlan::has_run_on_change));
    host.shown();
    assert!(!host.post.executor().loaded().is_some_and(LoadedPlan::has_run_on_change));
    host.post.set(strength, 0.3).unwrap();
    host.shown();
    assert!(!host.post.executor().loaded().is_some_and(LoadedPlan::has_run_on_change));
    host.post.set(hue, 0.5).unwrap();
    let shown = host.shown();
    assert!(host.post.executor().loaded().is_some_and(LoadedPlan::has_run_on_change));
    assert!(Arc::ptr_eq(&plan, &host.plan()));
    assert_same(&shown, &fresh("lynx.ron", Some("high"), &[("lit.strength", "0.3"), ("mapped.keep_hue", "0.5")]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_graph_with_other_values_of_parameters_with_handles_needs_no_plan() {
    let with = |strength, knee| changed("lynx.ron", None, &[("lit.strength", strength), ("bright.knee", knee)]);
    let mut host = Host::new(with("0.15", "0.1"));
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    host.shown();
    let plan = host.plan();
    host.post.change(with("0.6", "0.1"));
    assert!(!host.post.is_changing());
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[("lit.strength", "0.6")]));
    assert!(Arc::ptr_eq(&plan, &host.plan()));
    host.post.set(strength, 0.3).unwrap();
    host.post.change(with("0.7", "0.1"));
    assert_eq!(host.post.value(strength.control()), Some(&Value::Float(0.3)), "what the host has set holds");
    host.post.unset(strength.control()).unwrap();
    assert_eq!(host.post.value(strength.control()), Some(&Value::Float(0.7)));
    // A parameter without a handle needs a plan.
    host.post.change(with("0.7", "0.4"));
    assert!(host.post.is_changing());
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[("lit.strength", "0.7"), ("bright.knee", "0.4")]));
    // So does another structure.
    host.post.change(changed("lynx.ron", None, &[("mapped.curve", "Hable")]));
    assert!(host.post.is_changing());
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[("mapped.curve", "Hable")]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fact_changes_the_plan_in_the_background_and_another_size_at_once() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    host.frame().unwrap();
    let lit = host.plan();
    host.post.set_fact("emissive", false);
    host.frame().unwrap();
    host.post.finish_changes().unwrap();
    let dark = host.plan();
    assert!(dark.passes.len() < lit.passes.len());
    host.post.set_fact("emissive", true);
    host.post.finish_changes().unwrap();
    assert!(Arc::ptr_eq(&lit, &host.plan()), "the plan was kept");
    host.scene = scene(&host.gpu, Size::new(33, 17));
    host.frame().unwrap();
    assert_eq!(host.plan().size, Size::new(33, 17));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn expected_sizes_are_planned_in_the_background_also_after_a_fact() {
    let sizes = [Size::new(64, 36), Size::new(80, 45)];
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    let images = sizes.map(|size| HostImage::new(size.width, size.height, wgpu::TextureFormat::Rgba16Float));
    let inputs = images.map(|image| [("scene", image)]);
    let frames = inputs.each_ref().map(|inputs| ExpectedFrame { inputs, ..ExpectedFrame::default() });
    let tasks = Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let counted = tasks.clone();
    host.post.set_task_pool(Arc::new(move |task| {
        counted.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        task();
    }));
    host.post.prepare(&frames).unwrap_or_else(|error| panic!("{error}"));
    let first = host.scene.clone();
    for emissive in [true, false] {
        host.post.set_fact("emissive", emissive);
        host.scene = first.clone();
        for _ in 0..8 {
            host.frame().unwrap();
        }
        assert!(host.post.is_prepared().unwrap());
        let made = tasks.load(std::sync::atomic::Ordering::Relaxed);
        for size in sizes {
            host.scene = scene(&host.gpu, size);
            let shown = host.shown();
            let mut alone = Host::new(changed("caracal.ron", None, &[]));
            alone.post.set_fact("emissive", emissive);
            alone.scene = host.scene.clone();
            assert_same(&shown, &alone.shown());
        }
        assert_eq!(tasks.load(std::sync::atomic::Ordering::Relaxed), made, "nothing is left to do");
    }
}

/// The host sets values while a tier, another pipeline or one that cannot be planned is on its way.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn values_reach_the_plan_that_renders_while_another_graph_is_on_its_way() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    host.shown();
    let plan = host.plan();
    let tasks: Arc<std::sync::Mutex<Vec<afterimage_gpu::Task>>> = Arc::default();
    let given = tasks.clone();
    host.post.set_task_pool(Arc::new(move |task| given.lock().unwrap().push(task)));
    let mut unplannable = changed("lynx.ron", None, &[]);
    unplannable.inputs[0].name = "other".into();
    let next = [changed("lynx.ron", Some("low"), &[]), changed("grade.ron", None, &[]), unplannable];
    for (graph, value) in next.into_iter().zip([0.25_f32, 0.5, 0.75]) {
        host.post.change(graph);
        host.post.set(strength, value).unwrap();
        assert_same(&host.shown(), &fresh("lynx.ron", None, &[("lit.strength", &format!("{value:?}"))]));
        assert!(host.post.is_changing() && Arc::ptr_eq(&plan, &host.plan()), "the old plan renders");
    }
    // What cannot be planned leaves the old plan, and the host's values are still its own.
    host.post.set_task_pool(Arc::new(|task| task()));
    tasks.lock().unwrap().drain(..).for_each(|task| task());
    let errors = (0..3).filter_map(|_| host.frame().err()).count();
    assert_eq!(errors, 1);
    host.post.unset(strength.control()).unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[]));
    host.post.change(changed("lynx.ron", Some("low"), &[]));
    host.post.set(strength, 0.5).unwrap();
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", Some("low"), &[("lit.strength", "0.5")]));
}

/// A plan of another size evaluates its LUTs, with the values that the host has set.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn another_size_evaluates_the_luts() {
    let mut host = Host::new(changed("lynx.ron", Some("high"), &[]));
    let hue = host.post.parameter::<f32>("mapped.keep_hue").unwrap();
    host.shown();
    host.post.set(hue, 0.5).unwrap();
    host.scene = scene(&host.gpu, Size::new(48, 27));
    let shown = host.shown();
    assert!(host.post.executor().loaded().is_some_and(LoadedPlan::has_run_on_change));
    let mut alone = Host::new(changed("lynx.ron", Some("high"), &[("mapped.keep_hue", "0.5")]));
    alone.scene = host.scene.clone();
    assert_same(&shown, &alone.shown());
}

/// Without an input the frame has the size of the output, also if the host gives an image that nothing needs.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_without_inputs_follows_the_size_of_its_output() {
    let text = r#"Pipeline(nodes: { "scene": DemoScene() }, outputs: { "scene": "scene" })"#;
    let document = parse("scene.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let (graph, _) =
        check(&document, &registry(), &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
    let mut host = Host::new(graph);
    for size in [Size::new(32, 18), Size::new(48, 27)] {
        let output = scene(&host.gpu, size);
        let mut encoder = host.gpu.device.create_command_encoder(&Default::default());
        let (inputs, outputs) = (&[("scene", &host.scene)], &[("scene", &output)]);
        // The output is no render target: only the size of the plan matters here.
        let _ = host.post.encode(&mut encoder, &Frame { inputs, outputs, ..Frame::default() });
        assert_eq!(host.plan().size, size);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_that_cannot_be_made_is_reported_once_and_the_old_one_renders_on() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let before = host.shown();
    let graph = changed("lynx.ron", None, &[]);
    let mut without = graph.clone();
    without.inputs[0].name = "other".into();
    without.inputs[0].optional = false;
    host.post.change(without);
    let errors: Vec<String> = (0..200)
        .filter_map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(5));
            host.frame().err().map(|error| error.to_string())
        })
        .collect();
    assert_eq!(errors, ["output `display` comes from a node that is off and has no fallback"]);
    assert_same(&host.shown(), &before);
    host.post.change(graph);
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &before);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn parameters_can_be_listed_for_a_panel() {
    let host = Host::new(changed("lynx.ron", None, &[]));
    let all: Vec<_> = host.post.parameters().collect();
    let strength = all.iter().find(|parameter| parameter.name == "lit.strength").expect("it is there");
    assert_eq!((strength.value, strength.declaration.replan), (&Value::Float(0.15), false));
    assert!(all.iter().all(|parameter| !parameter.declaration.doc.is_empty()));
    let names: std::collections::BTreeSet<&String> = all.iter().map(|parameter| &parameter.name).collect();
    assert_eq!(names.len(), all.len());
}

/// The value after each frame, read back at once from a plan of its own.
fn exposures(lights: &[f32]) -> Vec<[f32; 4]> {
    let graph = changed("exposure.ron", None, &[]);
    let gpu = gpu();
    let mut session = Session::new(&gpu, graph, Facts::default(), Options::default());
    let mut values = Vec::new();
    for (number, light) in lights.iter().enumerate() {
        let image = flat(&gpu, *light);
        let desc = ImageDesc::new(Size::new(64, 36));
        let image = InputImage { input: "scene".into(), view: image, desc, finite: false };
        let step = FrameStep { time: 0.1 * number as f64, dt: 0.1, kind: FrameKind::cut_if(number == 0) };
        session.render(desc.size, &[image], step).unwrap();
        values.push(session.value("meter.result").unwrap().expect("the meter runs"));
    }
    values
}

fn flat(gpu: &Gpu, light: f32) -> wgpu::TextureView {
    let texels = Texels::from_floats_as_half(64, 36, &vec![[light, light, light, 1.0]; 64 * 36]);
    upload(&gpu.device, &gpu.queue, &texels).unwrap().create_view(&Default::default())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_meter_is_read_back_without_a_wait_with_the_frame_that_it_belongs_to() {
    let lights: Vec<f32> = (0..24).map(|frame| 0.05 + 0.3 * (frame % 7) as f32).collect();
    let wanted = exposures(&lights);
    let mut host = Host::new(changed("exposure.ron", None, &[]));
    let meter = host.post.watch("meter.result");
    let nothing = host.post.watch("nothing.result");
    let mut seen = std::collections::BTreeSet::new();
    for light in lights {
        host.scene = flat(&host.gpu, light);
        host.frame().unwrap();
        host.gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let Some(reading) = host.post.reading(meter).unwrap() else { continue };
        assert!(reading.frame < host.post.frame() && host.post.frame() - reading.frame <= 3, "it is not old");
        assert_eq!(reading.value(), Some(wanted[reading.frame as usize - 1]), "frame {}", reading.frame);
        seen.insert(reading.frame);
    }
    assert!(seen.len() > 18, "nearly every frame was read: {seen:?}");
    assert_eq!(host.post.reading(nothing).unwrap(), None);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn two_views_of_one_pipeline_are_two_pipelines() {
    let sizes = [Size::new(96, 54), Size::new(64, 48)];
    let views = sizes.map(|size| scene(&gpu(), size));
    let frames = |host: &mut Host, number: usize, view: usize| {
        host.scene = views[view].clone();
        host.time = 0.1 * number as f64;
        host.frame().unwrap_or_else(|error| panic!("{error}"));
        let texels = download(&host.gpu.device, &host.gpu.queue, host.post.output("display").unwrap());
        texels.unwrap_or_else(|error| panic!("{error}")).bytes
    };
    let alone: Vec<Vec<Vec<u8>>> = (0..2)
        .map(|view| {
            let mut host = Host::new(changed("tsushima.ron", None, &[]));
            (0..4).map(|number| frames(&mut host, number, view)).collect()
        })
        .collect();
    let mut first = Host::new(changed("tsushima.ron", None, &[]));
    let mut shown = [vec![frames(&mut first, 0, 0)], Vec::new()];
    let mut second =
        Host { post: first.post.clone_for_view(), gpu: first.gpu.clone(), scene: views[1].clone(), time: 0.0 };
    shown[1].push(frames(&mut second, 0, 1));
    for number in 1..4 {
        shown[1].push(frames(&mut second, number, 1));
        shown[0].push(frames(&mut first, number, 0));
    }
    for (view, (shown, alone)) in shown.iter().zip(&alone).enumerate() {
        for (number, (shown, alone)) in shown.iter().zip(alone).enumerate() {
            assert!(shown == alone, "view {view}, frame {number}");
        }
    }
    // A value of one view is not the other's.
    let strength = first.post.parameter::<f32>("lit.strength").unwrap();
    let other = second.post.parameter::<f32>("lit.strength").unwrap();
    first.post.set(strength, 0.5).unwrap();
    assert_eq!(second.post.value(other.control()), Some(&Value::Float(0.015)));
}
