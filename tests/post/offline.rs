//! Pipelines that the crate `afterimage` renders from memory to memory, compared with those of a host's device.

use afterimage::FrameKind;
use afterimage::host::kinds::{AutoExposure, Curve, Encode, Exposure, Histogram, ToneMap, Transfer, WhiteBalance};
use afterimage::host::{FrameStep, ImageDesc, Size};
use afterimage::offline::{ComponentType, Encoding, Offline, OfflineFrame, OfflineImage, Rendered};
use afterimage::{Pipeline, Source};
use afterimage_gpu::Texels;

use super::{Host, assert_same, scene_texels};
use crate::support::gpu::graph;

/// Light at two tiers, with a node that a fact switches off, and its display.
fn look(stops: &str) -> String {
    format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, outputs: {{ \"display\": \"exposed\", \"codes\": \"codes\" }},\n\
         nodes: {{\n\
         \"bins\": Histogram(source: \"scene\"),\n\
         \"metered\": AutoExposure(histogram: \"bins\"),\n\
         \"red\": WhiteBalance(source: \"scene\", temperature: 4000.0, when: \"red\"),\n\
         \"exposed\": Exposure(source: \"red\", meter: \"metered\", stops: {stops}),\n\
         \"mapped\": ToneMap(source: \"exposed\", curve: Reinhard),\n\
         \"codes\": Encode(source: \"mapped\", transfer: Srgb),\n}},\n\
         tiers: {{ \"low\": {{ \"exposed.stops\": -4.0 }} }})"
    )
}

fn open(stops: &str) -> Offline {
    Offline::open(Source::text("look.ron", look(stops))).unwrap_or_else(|error| panic!("{error}"))
}

fn frame(look: &mut Offline) -> Rendered {
    let texels = scene_texels(Size::new(96, 54));
    let images = &[OfflineImage { input: "scene", desc: texels.desc, bytes: &texels.bytes }];
    let frame = OfflineFrame { images, values: &["metered"], ..OfflineFrame::default() };
    look.render(&frame).unwrap_or_else(|error| panic!("{error}"))
}

/// The light that a host's device has.
fn light(stops: &str, red: Option<bool>) -> Vec<u8> {
    let mut host = Host::new(graph(&look(stops)));
    if let Some(red) = red {
        host.post.set_fact("red", red);
    }
    host.shown()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_has_the_light_of_a_host() {
    let mut look = open("-1.0");
    let first = frame(&mut look);
    assert_eq!((first.outputs[0].name.as_str(), first.outputs[0].data.ty()), ("display", ComponentType::F16));
    assert_same(first.outputs[0].data.bytes(), &light("-1.0", None));
    let [stops, _, _, valid] = first.values[0].expect("the meter has a value");
    assert!(stops != 0.0 && valid == 1.0, "{stops} {valid}");
    assert_eq!(look.value("metered").unwrap(), first.values[0]);
    look.set("exposed.stops", "-2.25").unwrap();
    assert_same(frame(&mut look).outputs[0].data.bytes(), &light("-2.25", None));
    look.set_fact("red", false).unwrap();
    assert_same(frame(&mut look).outputs[0].data.bytes(), &light("-2.25", Some(false)));
    look.unset("exposed.stops").unwrap();
    look.set_tier(Some("low")).unwrap();
    assert_eq!((look.tier(), look.tiers()), (Some("low"), vec!["low".to_owned()]));
    assert_same(frame(&mut look).outputs[0].data.bytes(), &light("-4.0", Some(false)));
    look.set("red", "Off").unwrap();
    look.set_fact("red", true).unwrap();
    assert_same(frame(&mut look).outputs[0].data.bytes(), &light("-4.0", Some(false)));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_display_has_the_numbers_that_are_wanted() {
    let mut look = open("0.0");
    look.set_outputs(vec!["codes".to_owned()]).unwrap();
    let mut numbers = |encoding, ty, channels| {
        look.set_encoding(encoding);
        let mut rendered = frame(&mut look);
        let image = rendered.outputs.pop().expect("there is one output");
        assert_eq!((image.name.as_str(), image.data.ty(), image.channels), ("codes", ty, channels));
        assert!(rendered.outputs.is_empty());
        image.data.bytes().to_vec()
    };
    let floats = numbers(Encoding::Float, ComponentType::F32, 4);
    let floats: Vec<f32> = floats.as_chunks::<4>().0.iter().map(|bytes| f32::from_ne_bytes(*bytes)).collect();
    let rounded = |last: f32| {
        let colors = floats.as_chunks::<4>().0.iter().flat_map(|pixel| &pixel[..3]);
        colors.map(|number| (number.clamp(0.0, 1.0) * last + 0.5) as u16).collect::<Vec<u16>>()
    };
    let sixteen = numbers(Encoding::Codes16, ComponentType::U16, 3);
    let sixteen: Vec<u16> = sixteen.as_chunks::<2>().0.iter().map(|bytes| u16::from_ne_bytes(*bytes)).collect();
    assert_eq!(sixteen, rounded(65535.0));
    assert!(sixteen.iter().max() > sixteen.iter().min());
    // These come from half floats.
    let eight = numbers(Encoding::Codes, ComponentType::U8, 3);
    assert!(eight.iter().zip(rounded(255.0)).all(|(code, wanted)| u16::from(*code).abs_diff(wanted) <= 1));
    assert_eq!(numbers(Encoding::Codes8, ComponentType::U8, 3), eight);
    assert_eq!(numbers(Encoding::Half, ComponentType::F16, 4).len(), 96 * 54 * 8);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_sequence_goes_on_until_a_first_frame() {
    let (mut look, bright) = (Offline::open("exposure").unwrap(), scene_texels(Size::new(32, 18)));
    let dark = Texels::from_floats_as_half(32, 18, &[[0.01, 0.01, 0.01, 1.0]; 32 * 18]);
    let mut metered = |texels: &Texels, step: FrameStep| {
        let scene = OfflineImage { input: "scene", desc: texels.desc, bytes: &texels.bytes };
        let frame = OfflineFrame { images: &[scene], step, values: &["meter"], ..OfflineFrame::default() };
        look.render(&frame).unwrap().values[0].expect("the meter has a value")[0]
    };
    let first = metered(&bright, FrameStep::FIRST);
    let adapting = metered(&dark, FrameStep { time: 0.1, dt: 0.1, kind: FrameKind::Next });
    let adapted = metered(&dark, FrameStep { time: 100.0, dt: 100.0, kind: FrameKind::Next });
    assert!(adapting != adapted, "{first} {adapting} {adapted}");
    assert_eq!(metered(&bright, FrameStep::FIRST), first);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_does_not_fit_is_an_error_and_changes_nothing() {
    let mut look = open("-1.0");
    let before = frame(&mut look).outputs.remove(0).data;
    let errors = [
        (look.set("exposed.stop", "1").unwrap_err(), "`stops`"),
        (look.set("exposed.stops", "much").unwrap_err(), "stops"),
        (look.set_tier(Some("lo")).unwrap_err(), "`low`"),
        (look.set_fact("rad", true).unwrap_err(), "`red`"),
        (look.set_outputs(vec!["code".to_owned()]).unwrap_err(), "it has `display`, `codes`"),
        (look.value("meter").unwrap_err(), "`metered`"),
        (look.value("metered.exposure").unwrap_err(), "it has `result`"),
    ];
    for (error, text) in errors {
        assert!(error.to_string().contains(text), "{text}: {error}");
    }
    let texels = scene_texels(Size::new(8, 4));
    let mut refused = |input: &str, desc: ImageDesc, bytes: &[u8], text: &str| {
        let images = &[OfflineImage { input, desc, bytes }];
        let Err(error) = look.render(&OfflineFrame { images, ..OfflineFrame::default() }) else { panic!("{text}") };
        assert!(error.to_string().contains(text), "{text}: {error}");
    };
    refused("seen", texels.desc, &texels.bytes, "no input `seen`; it has `scene`");
    refused("scene", texels.desc, &texels.bytes[1..], "255 bytes, not the 256 of its size");
    let Err(missing) = look.render(&OfflineFrame::default()) else { panic!("no image is needed") };
    assert!(missing.to_string().contains("needs an image for its input `scene`"), "{missing}");
    assert_same(frame(&mut look).outputs[0].data.bytes(), before.bytes());
}

/// The pipeline of [`look`], whose balance reads an image of that name.
fn in_code(source: &str) -> Pipeline {
    Pipeline::default()
        .input("scene", "Color")
        .node("bins", &Histogram::default(), &[("source", "scene")])
        .node("metered", &AutoExposure::default(), &[("histogram", "bins")])
        .node("red", &WhiteBalance { temperature: 4000.0, ..Default::default() }, &[("source", source)])
        .node("exposed", &Exposure { stops: -2.25 }, &[("source", "red"), ("meter", "metered")])
        .node("mapped", &ToneMap { curve: Curve::Reinhard, ..Default::default() }, &[("source", "exposed")])
        .node("codes", &Encode { transfer: Transfer::Srgb, ..Default::default() }, &[("source", "mapped")])
        .output("display", "exposed")
        .output("codes", "codes")
        .tier("low", &[("exposed.stops", "-4.0")])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_in_code_is_that_of_its_text() {
    let mut built = Offline::open(in_code("scene")).unwrap_or_else(|error| panic!("{error}"));
    assert_same(frame(&mut built).outputs[0].data.bytes(), &light("-2.25", None));
    built.set_tier(Some("low")).unwrap();
    assert_same(frame(&mut built).outputs[0].data.bytes(), &light("-4.0", None));
    let Err(wrong) = Offline::open(in_code("scenes")) else { panic!("no input has that name") };
    let wrong = wrong.to_string();
    assert!(wrong.contains("pipeline in code:8:") && wrong.contains("`scene`"), "{wrong}");
}
