//! Pipelines that the crate `afterimage` opens: by name, as text and from files, with tiers and reloads.

use std::path::{Path, PathBuf};

use afterimage::host::{Executor, Size, Snapshot, caps, download, wanted_features};
use afterimage::{Error, Frame, FrameKind, Gpu, Post, Source, wgpu};

use super::{Host, assert_same, fresh, scene};
use crate::support::gpu::{another_device, gpu, graph, pipelines};

/// What the pipeline shows in its first frame, after all changes.
fn shown(gpu: &Gpu, post: &mut Post) -> Vec<u8> {
    shown_at(Size::new(96, 54), gpu, post)
}

fn shown_at(size: Size, gpu: &Gpu, post: &mut Post) -> Vec<u8> {
    let scene = scene(gpu, size);
    post.executor().count_from(0);
    // The first frame asks for a plan of what has changed.
    for _ in 0..2 {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = Frame { inputs: &[("scene", &scene)], dt: 0.1, kind: FrameKind::Cut, ..Frame::default() };
        post.encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        post.finish_changes().unwrap_or_else(|error| panic!("{error}"));
        post.executor().count_from(0);
    }
    download(&gpu.device, &gpu.queue, post.output("display").unwrap()).unwrap().bytes
}

fn open(gpu: &Gpu, source: impl Into<Source>) -> Post {
    Post::open(gpu, source).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refused(opened: Result<Post, Error>) -> String {
    match opened {
        Ok(_) => panic!("it is opened"),
        Err(error) => error.to_string(),
    }
}

/// A folder that is removed at the end of a test.
pub(super) struct Folder(pub(super) PathBuf);

impl Folder {
    pub(super) fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("afterimage-{name}-{}", std::process::id()));
        drop(std::fs::remove_dir_all(&folder));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    pub(super) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(std::fs::remove_dir_all(&self.0));
    }
}

/// A pipeline whose exposure has two tiers.
fn exposure(stops: &str) -> String {
    format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, outputs: {{ \"display\": \"display\" }}, nodes: {{\n\
         \"exposed\": Exposure(source: \"scene\", stops: {stops}),\n\
         \"mapped\": ToneMap(source: \"exposed\", curve: Reinhard),\n\
         \"display\": Encode(source: \"mapped\", transfer: Srgb),\n}},\n\
         tiers: {{ \"low\": {{ \"exposed.stops\": -4.0 }}, \"high\": {{ \"exposed.stops\": -5.0 }} }})"
    )
}

/// What it shows, checked and planned without the crate.
fn exposed(stops: &str) -> Vec<u8> {
    Host::new(graph(&exposure(stops))).shown()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_name_a_file_and_a_text_are_the_same_pipeline() {
    let gpu = gpu();
    let expected = fresh("caracal.ron", None, &[]);
    let file = pipelines().join("caracal.ron");
    let text = std::fs::read_to_string(&file).unwrap();
    for mut post in [
        open(&gpu, "caracal"),
        open(&gpu, "caracal.ron"),
        open(&gpu, &file),
        open(&gpu, Source::text("caracal", text)),
        open(&gpu, Source::text("own", "Pipeline(extends: \"caracal.ron\")")),
    ] {
        assert_same(&shown(&gpu, &mut post), &expected);
        assert!(!post.reload_if_changed().unwrap());
    }
    let unknown = refused(Post::open(&gpu, "caracall"));
    assert!(unknown.contains("`caracall`") && unknown.contains("caracal, cookbook"), "{unknown}");
    let missing = refused(Post::open(&gpu, "no/such/look.ron"));
    assert!(missing.contains("`no/such/look.ron` cannot be read") && !missing.contains("caracal"), "{missing}");
    let wrong = refused(Post::open(&gpu, Source::text("own.ron", exposure("\"much\""))));
    assert!(wrong.contains("own.ron:2:") && wrong.contains("^"), "{wrong}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_tier_is_set_by_its_name_and_an_unknown_one_lists_those_that_there_are() {
    let gpu = gpu();
    let mut post = open(&gpu, Source::from("lynx").tier("high"));
    assert_eq!(post.tiers(), ["ultra", "high", "low"]);
    let [ultra, low] = ["ultra", "low"].map(|tier| post.claim(tier).expect("built-in pipelines claim figures").clone());
    assert!(ultra.ms > low.ms && ultra.p999 < low.p999 && low.on.contains("NVIDIA"), "{ultra}, {low}");
    assert!(post.claim("lo").is_none());
    let high = shown(&gpu, &mut post);
    assert_same(&high, &fresh("lynx.ron", Some("high"), &[]));
    let error = post.set_tier("lo").unwrap_err().to_string();
    for name in ["`lo`", "`ultra`", "`high`", "`low`"] {
        assert!(error.contains(name), "{error}");
    }
    assert_eq!(post.tier(), Some("high"));
    assert_same(&shown(&gpu, &mut post), &high);
    // A value of the host holds in every tier.
    let strength = post.parameter::<f32>("lit.strength").unwrap();
    post.set(strength, 0.5).unwrap();
    post.set_tier("low").unwrap();
    assert_eq!(post.tier(), Some("low"));
    assert_same(&shown(&gpu, &mut post), &fresh("lynx.ron", Some("low"), &[("lit.strength", "0.5")]));
    post.unset(strength.control()).unwrap();
    post.set_tier(None).unwrap();
    assert_same(&shown(&gpu, &mut post), &fresh("lynx.ron", None, &[]));
    // A budget begins with what the file claims.
    post.govern(4.0, &["low", "ultra"]).unwrap();
    let costs = post.governor().map(|governor| [governor.cost(0), governor.cost(1)].map(Some));
    assert_eq!(costs, Some([low.ms, ultra.ms]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_edited_file_is_taken_and_a_broken_one_is_reported_once_while_the_old_one_renders() {
    let gpu = gpu();
    let folder = Folder::new("reload");
    let base = folder.write("shared/base.ron", &exposure("-1.0"));
    let file = folder.write("look.ron", "Pipeline(extends: \"shared/base.ron\")");
    let mut post = open(&gpu, &file);
    let stops = post.parameter::<f32>("exposed.stops").unwrap();
    assert_same(&shown(&gpu, &mut post), &exposed("-1.0"));
    assert!(!post.reload_if_changed().unwrap());
    folder.write("shared/base.ron", &exposure("-2.25"));
    assert!(post.reload_if_changed().unwrap());
    assert!(!post.reload_if_changed().unwrap());
    assert_same(&shown(&gpu, &mut post), &exposed("-2.25"));
    // Broken, gone, and broken in another way: each once.
    folder.write("shared/base.ron", &exposure("-2.25, stopps: 1"));
    let error = post.reload_if_changed().unwrap_err().to_string();
    assert!(error.contains("base.ron:2:") && error.contains("`stops`"), "{error}");
    assert!(!post.reload_if_changed().unwrap());
    std::fs::remove_file(&base).unwrap();
    let error = post.reload_if_changed().unwrap_err().to_string();
    assert!(error.contains("base.ron"), "{error}");
    assert!(!post.reload_if_changed().unwrap());
    folder.write("look.ron", "no pipeline");
    assert!(post.reload_if_changed().is_err());
    assert_same(&shown(&gpu, &mut post), &exposed("-2.25"));
    // The tiers of the old one hold, too.
    post.set_tier("low").unwrap();
    assert_same(&shown(&gpu, &mut post), &exposed("-4.0"));
    post.set_tier(None).unwrap();
    // The file that the broken one no longer names is still waited for.
    folder.write("look.ron", "Pipeline(extends: \"shared/base.ron\", set: {})");
    assert!(post.reload_if_changed().is_err());
    folder.write("shared/base.ron", &exposure("-0.125"));
    assert!(post.reload_if_changed().unwrap());
    assert_same(&shown(&gpu, &mut post), &exposed("-0.125"));
    // A handle from before holds.
    post.set(stops, -6.0).unwrap();
    assert_same(&shown(&gpu, &mut post), &exposed("-6.0"));
}

/// A kind in a folder, and its shader.
pub(super) const DARKER: &str = "Kind(name: \"Darker\", doc: \"Takes light away.\", \
    inputs: { \"source\": Image(doc: \"The image.\") }, \
    outputs: { \"result\": Image(doc: \"The image.\", state: Same(\"source\")) }, parameters: {})";
pub(super) const DARKER_SHADER: &str = "fn darker(source: vec4f) -> vec4f { return vec4f(source.rgb * FACTOR, 1.0); }";

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn kinds_beside_a_file_are_known_and_files_elsewhere_are_not_read() {
    let gpu = gpu();
    let folder = Folder::new("kinds");
    let shader = |factor: &str| DARKER_SHADER.replace("FACTOR", factor);
    folder.write("darker/node.ron", DARKER);
    folder.write("darker/darker.wgsl", &shader("0.5"));
    let look = "Pipeline(inputs: { \"scene\": Color }, outputs: { \"display\": \"display\" }, nodes: { \
        \"darker\": Darker(source: \"scene\"), \
        \"exposed\": Exposure(source: \"darker\", stops: 0.0), \
        \"mapped\": ToneMap(source: \"exposed\", curve: Reinhard), \
        \"display\": Encode(source: \"mapped\", transfer: Srgb) })";
    let file = folder.write("look.ron", look);
    let mut post = open(&gpu, &file);
    // A factor of a half is one stop less.
    assert_same(&shown(&gpu, &mut post), &exposed("-1.0"));
    folder.write("darker/darker.wgsl", &shader("0.0625"));
    assert!(post.reload_if_changed().unwrap());
    assert_same(&shown(&gpu, &mut post), &exposed("-4.0"));
    // The same from a folder that the host names.
    let text = Source::text("look", look);
    assert!(refused(Post::open(&gpu, text.clone())).contains("Darker"));
    assert_same(&shown(&gpu, &mut open(&gpu, text.folder(&folder.0))), &exposed("-4.0"));

    let outside = folder.write("elsewhere/base.ron", &exposure("-2.0"));
    let file = folder.write("looks/own.ron", "Pipeline(extends: \"../elsewhere/base.ron\")");
    let error = refused(Post::open(&gpu, &file));
    assert!(error.contains("`allow`"), "{error}");
    let source = Source::from(&file).allow(outside.parent().unwrap_or(Path::new("")));
    assert_same(&shown(&gpu, &mut open(&gpu, source)), &exposed("-2.0"));
}

/// What a driver has compiled in one run is there in the next one; damaged bytes are ignored.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_cache_of_the_driver_is_loaded_when_a_pipeline_is_opened() {
    let gpu = gpu();
    let mut first = open(&gpu, Source::from("caracal").pipeline_cache(*b"damaged"));
    let wanted = shown(&gpu, &mut first);
    let has_cache = gpu.device.features().contains(wgpu::Features::PIPELINE_CACHE);
    let Some(data) = first.executor().pipeline_cache_data().filter(|_| has_cache) else {
        assert!(!has_cache, "the cache was opened");
        return;
    };
    let mut second = open(&gpu, Source::from("caracal").pipeline_cache(data.clone()));
    let before = second.executor().pipeline_cache_data().expect("the device has a cache");
    assert!(before.len() >= data.len() && open(&gpu, "caracal").executor().pipeline_cache_data().is_none());
    assert_same(&shown(&gpu, &mut second), &wanted);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_governor_takes_tiers_by_name_and_keeps_its_choice_over_a_reload() {
    let gpu = gpu();
    let folder = Folder::new("governed");
    let file = folder.write("look.ron", &exposure("-1.0"));
    let mut post = open(&gpu, &file);
    let error = post.govern(4.0, &["low", "best"]).unwrap_err().to_string();
    assert!(error.contains("`best`") && post.governor().is_none(), "{error}");
    post.govern(4.0, &["high", "low"]).unwrap();
    assert_eq!(post.tier(), Some("high"));
    assert_same(&shown(&gpu, &mut post), &exposed("-5.0"));
    folder.write("look.ron", &exposure("-1.0").replace("-5.0", "-3.125"));
    assert!(post.reload_if_changed().unwrap());
    assert!(post.governor().is_some());
    assert_same(&shown(&gpu, &mut post), &exposed("-3.125"));
    post.stop_governing();
    assert_eq!(post.tier(), Some("high"));
    // A view has files and tiers of its own.
    let mut view = post.clone_for_view();
    view.set_tier("low").unwrap();
    assert_same(&shown(&gpu, &mut view), &exposed("-4.0"));
    assert_same(&shown(&gpu, &mut post), &exposed("-3.125"));
    folder.write("look.ron", &exposure("-1.0").replace("-4.0", "-0.0625"));
    assert!(view.reload_if_changed().unwrap() && post.reload_if_changed().unwrap());
    assert_same(&shown(&gpu, &mut view), &exposed("-0.0625"));
}

/// An engine loads its files by itself: first those that the text names, then those that these name.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_host_that_loads_files_by_itself_gives_a_snapshot() {
    let gpu = gpu();
    let loaded = |stops: &str| {
        let mut snapshot = Snapshot::of_text("looks/own.ron", "Pipeline(extends: \"../base.ron\")", &[]).unwrap();
        assert_eq!(snapshot.missing().into_iter().collect::<Vec<_>>(), ["base.ron"]);
        snapshot.insert("base.ron".into(), Ok("Pipeline(extends: \"shared/all.ron\")".as_bytes().into()));
        assert_eq!(snapshot.missing().into_iter().collect::<Vec<_>>(), ["shared/all.ron"]);
        let before = snapshot.clone();
        snapshot.insert("shared/all.ron".into(), Ok(exposure(stops).as_bytes().into()));
        assert!(snapshot.missing().is_empty());
        assert!(before.check(None, &[]).is_err(), "an earlier clone is as it was");
        assert!(snapshot.is_same(&snapshot.clone()));
        snapshot
    };
    let executor = Executor::with_caps(&gpu.device, &gpu.queue, caps(&gpu.adapter, &gpu.device));
    let (first, second) = (loaded("-1.0"), loaded("-2.25"));
    assert!(!first.is_same(&second));
    let mut post = Post::of_snapshot(executor, first, Some("low")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(post.tier(), Some("low"));
    assert_same(&shown(&gpu, &mut post), &exposed("-4.0"));
    assert!(!post.reload_if_changed().unwrap());
    post.reload(second.clone()).unwrap();
    assert_same(&shown(&gpu, &mut post), &exposed("-4.0"));
    post.set_tier(None).unwrap();
    assert_same(&shown(&gpu, &mut post), &exposed("-2.25"));
    // What has no such tier, or lacks a file, changes nothing.
    let mut lacking = Snapshot::of_text("own.ron", "Pipeline(extends: \"base.ron\")", &[]).unwrap();
    lacking.insert("base.ron".into(), Err("the network is down".into()));
    assert!(post.replace(lacking, None).unwrap_err().to_string().contains("the network is down"));
    assert!(post.replace(loaded("-3.0"), Some("best")).is_err());
    assert_same(&shown(&gpu, &mut post), &exposed("-2.25"));
    post.replace(loaded("-3.0"), Some("high")).unwrap();
    assert_same(&shown(&gpu, &mut post), &exposed("-5.0"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn kinds_in_rust_are_known() {
    let gpu = gpu();
    let dots = "nodes: {\n\"dots\": Halftone(source: \"mapped\", pitch: 4.0),\n";
    let text = exposure("-1.0")
        .replace("nodes: {\n", dots)
        .replace("source: \"mapped\", transfer", "source: \"dots\", transfer");
    assert!(refused(Post::open(&gpu, Source::text("dots", text.as_str()))).contains("Halftone"));
    let mut post = open(&gpu, Source::text("dots", text.as_str()).kinds(halftone::ALL));
    let dotted = shown(&gpu, &mut post);
    assert_same(&dotted, &Host::new(graph(&text)).shown());
    assert!(dotted != exposed("-1.0"));
}

/// A host of 120 frames moves a parameter in each, states a fact, resizes, changes its tier, takes an edited file and
/// loses its device. After each of these it shows what a host shows that begins there.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_host_shows_after_each_change_what_a_new_one_shows() {
    let second = gpu();
    let first = another_device(&second, wanted_features(&second.adapter), second.adapter.limits());
    let folder = Folder::new("host");
    let mut text = std::fs::read_to_string(pipelines().join("caracal.ron")).unwrap();
    let file = folder.write("look.ron", &text);
    let (mut gpu, mut size) = (first.clone(), Size::new(96, 54));
    let mut post = open(&gpu, &file);
    let strength = post.parameter::<f32>("lit.strength").unwrap();
    for frame in 0..120_u8 {
        post.set(strength, f32::from(frame) / 128.0).unwrap();
        match frame {
            20 => post.set_fact("emissive", false),
            40 => size = Size::new(64, 48),
            60 => post.set_tier("ultra").unwrap(),
            80 => {
                text = text.replace("spread: 0.85", "spread: 0.5");
                folder.write("look.ron", &text);
                post.set_fact("emissive", true);
            }
            100 => {
                first.device.destroy();
                assert!(post.check_device().is_err());
                gpu = Gpu::clone(&second);
                post.rebuild(&gpu);
            }
            _ => {}
        }
        assert_eq!(post.reload_if_changed().unwrap(), frame == 80);
        let scene = scene(&gpu, size);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame_inputs = Frame { inputs: &[("scene", &scene)], dt: 0.1, ..Frame::default() };
        post.encode(&mut encoder, &frame_inputs).unwrap_or_else(|error| panic!("frame {frame}: {error}"));
        gpu.queue.submit([encoder.finish()]);
        if frame % 20 == 10 {
            let mut new = open(&second, &file);
            let strength = new.parameter::<f32>("lit.strength").unwrap();
            new.set(strength, f32::from(frame) / 128.0).unwrap();
            if frame >= 20 {
                new.set_fact("emissive", frame >= 80);
            }
            new.set_tier(if frame < 60 { None } else { Some("ultra") }).unwrap();
            assert_same(&shown_at(size, &gpu, &mut post), &shown_at(size, &second, &mut new));
        }
    }
}
