//! What changes while an app runs, and what is said of it.

use bevy::camera::CameraMainTextureUsages;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::post_process::auto_exposure::AutoExposure;
use bevy::post_process::bloom::Bloom;
use bevy::prelude::*;
use bevy::reflect::TypeRegistry;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy_afterimage::{Afterimage, AfterimagePlugin, AfterimageStatus, Setting};

use crate::program::differing;
use crate::shown::{Folder, Shown, pipelines};

fn lynx() -> String {
    std::fs::read_to_string(pipelines().join("lynx.ron")).expect("it is in the repository")
}

#[test]
fn changes_come_in_while_the_program_runs() {
    let own = Folder::new("changes");
    own.write("look.ron", &lynx());
    let mut shown = Shown::with_camera(&own.0, "look.ron", TextureFormat::Rgba8UnormSrgb, |look| look);
    let first = shown.settled();
    let set = |shown: &mut Shown, strength: Option<f32>| {
        shown.change(|look| {
            look.parameters.clear();
            look.parameters.extend(strength.map(|strength| ("lit.strength".to_owned(), strength.into())));
        });
    };
    set(&mut shown, Some(0.9));
    shown.once("more of the bloom is seen", |now| differing(&first, now).1 > 20);
    set(&mut shown, None);
    shown.once("the value of the file is back", |now| differing(&first, now) == (0, 0));
    // A file that is wrong changes nothing.
    own.write("look.ron", &lynx().replace("Composite(", "Compsite("));
    for _ in 0..20 {
        shown.run(5);
        assert_eq!(differing(&first, &shown.shown()), (0, 0));
    }
    let status = shown.until("an error of the file", |status| status.files.is_some());
    assert!(status.files.is_some_and(|error| error.contains("Compsite")));
    assert!(status.is_running);
    own.write("look.ron", &lynx().replace("strength: 0.15", "strength: 0.9"));
    shown.once("the file is read again", |now| differing(&first, now).1 > 20);
    shown.until("no error", |status| status.files.is_none());
}

const CONDITIONAL: &str = r#"Pipeline(
    inputs: { "scene": Color },
    facts: { "bright": "Whether the light is on." },
    nodes: {
        "lit": Exposure(source: "scene", stops: 2.0, when: "bright"),
        "out": Vignette(source: "lit", amount: 0.1),
    },
    outputs: { "out": "out" },
    tiers: { "dark": { "out.amount": 1.0 } },
)"#;

/// A tier, a fact and a cut; what is wrong with settings is said and changes nothing.
#[test]
fn settings_change_and_are_checked() {
    let own = Folder::new("settings");
    own.write("look.ron", CONDITIONAL);
    let without = |look: Afterimage| look.fact("bright", false);
    let mut shown = Shown::with_camera(&own.0, "look.ron", TextureFormat::Rgba8UnormSrgb, without);
    let first = shown.settled();
    shown.change(|look| look.tier = Some("dark".into()));
    shown.once("the tier is darker", |now| sum(now) < sum(&first) * 3 / 4);
    shown.change(|look| look.tier = None);
    shown.once("the file is back", |now| *now == first);
    shown.change(|look| _ = look.facts.insert("bright".into(), true.into()));
    shown.once("the fact makes it brighter", |now| sum(now) > sum(&first) * 3 / 2);
    shown.change(|look| {
        look.facts.insert("bright".into(), "yes".into());
        look.parameters.insert("out.amont".into(), 1.0.into());
        look.parameters.insert("out.amount".into(), 1e9.into());
    });
    let status = shown.until("what is refused", |status| status.settings.len() == 3);
    for (word, index) in [("fact", 0), ("amont", 1), ("out.amount", 2)] {
        assert!(status.settings[index].contains(word), "{status:?}");
    }
    shown.change(|look| {
        look.parameters.clear();
        look.facts.clear();
        look.tier = Some("none".into());
    });
    let status = shown.until("an unknown tier", |status| status.files.is_some());
    assert!(status.settings.len() == 3, "the settings before stay");
    shown.change(|look| {
        look.tier = None;
        look.facts.insert("bright".into(), false.into());
        look.cuts += 1;
    });
    shown.until("nothing is wrong", |status| status.settings.is_empty() && status.files.is_none());
    shown.once("all is as at first", |now| *now == first);
}

fn sum(bytes: &[u8]) -> u64 {
    bytes.as_chunks::<4>().0.iter().flat_map(|texel| &texel[..3]).map(|byte| u64::from(*byte)).sum()
}

/// The file that a pipeline extends, and one that it has as a node.
#[test]
fn files_that_a_pipeline_names_are_followed() {
    let own = Folder::new("named");
    let node = |amount: f32| {
        format!(
            "Pipeline(inputs: {{ \"light\": Exposed }}, nodes: {{ \"out\": Vignette(source: \"light\", amount: {amount}) }},
                outputs: {{ \"out\": \"out\" }})"
        )
    };
    let base = |stops: f32| {
        format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, outputs: {{ \"out\": \"dark\" }}, nodes: {{
                \"lit\": Exposure(source: \"scene\", stops: {stops}),
                \"dark\": Pipeline(file: \"../parts/dark.ron\", light: \"lit\"),
            }})"
        )
    };
    own.write("parts/dark.ron", &node(0.1));
    own.write("looks/base.ron", &base(0.0));
    own.write("looks/look.ron", "Pipeline(extends: \"base.ron\")");
    let same = |look| look;
    let mut shown = Shown::with_camera(&own.0, "looks/look.ron", TextureFormat::Rgba8UnormSrgb, same);
    let first = shown.settled();
    own.write("looks/base.ron", &base(2.0));
    shown.once("the base is brighter", |now| sum(now) > sum(&first) * 3 / 2);
    own.write("looks/base.ron", &base(0.0));
    shown.once("as at first", |now| *now == first);
    own.write("parts/dark.ron", &node(1.0));
    shown.once("the node is darker", |now| sum(now) < sum(&first) * 3 / 4);
    // What is no file of the assets is an error, and no panic of the loader.
    for (wrong, why) in [("../../base.ron", "not in the folder of assets"), ("base.ron#", "Asset label")] {
        own.write("looks/look.ron", &format!("Pipeline(extends: \"{wrong}\")"));
        let status = shown.until(why, |status| status.files.as_ref().is_some_and(|error| error.contains(why)));
        assert!(status.is_running, "{status:?}");
    }
}

/// A kind in a folder, with a file that it imports, and a `.cube` table: all are followed.
#[test]
fn node_folders_and_tables_are_followed() {
    let own = Folder::new("folders");
    own.write("nodes/tinted/node.ron", NODE);
    own.write("nodes/tinted/tinted.wgsl", SHADER);
    own.write("nodes/lib/tint.wgsl", "fn tint() -> vec3f { return vec3f(1.0, 1.0, 1.0); }");
    own.write("looks/look.cube", &cube(1.0));
    own.write("look.ron", LOOK);
    let plugin = AfterimagePlugin { node_folders: vec!["nodes/tinted".into()], ..default() };
    let mut shown = Shown::with_plugin(&own.0, TextureFormat::Rgba8UnormSrgb, plugin);
    let look = shown.look("look.ron");
    shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
    shown.until("a frame", |status| status.is_running);
    let first = shown.settled();
    let channel = |bytes: &[u8], channel: usize| -> u64 {
        bytes.as_chunks::<4>().0.iter().map(|texel| u64::from(texel[channel])).sum()
    };
    own.write("nodes/lib/tint.wgsl", "fn tint() -> vec3f { return vec3f(1.0, 0.1, 1.0); }");
    // The curve keeps hues, so the other channels change a little.
    let is_less = |now: &[u8], less: usize, others: [usize; 2]| {
        let has = |at: usize| channel(now, at) * 3 > channel(&first, at) * 2;
        !has(less) && others.into_iter().all(has)
    };
    shown.once("less green", |now| is_less(now, 1, [0, 2]));
    own.write("nodes/tinted/tinted.wgsl", &SHADER.replace("tint()", "vec3f(0.1, 1.0, 1.0)"));
    shown.once("less red", |now| is_less(now, 0, [1, 2]));
    own.write("nodes/tinted/tinted.wgsl", "fn tinted(");
    let status = shown.until("an error", |status| status.files.is_some());
    assert!(status.files.is_some_and(|error| error.contains("tinted.wgsl")) && status.is_running);
    own.write("nodes/tinted/tinted.wgsl", SHADER);
    own.write("nodes/lib/tint.wgsl", "fn tint() -> vec3f { return vec3f(1.0, 1.0, 1.0); }");
    shown.once("as at first", |now| *now == first);
    own.write("looks/look.cube", &cube(0.1));
    shown.once("less blue", |now| is_less(now, 2, [0, 1]));
}

const NODE: &str = r#"Kind(
    name: "Tinted",
    doc: "Multiplies light by a color.",
    inputs: { "source": Image(doc: "The light.", accepts: [Scene, Exposed, DisplayLinear]) },
    outputs: { "result": Image(doc: "The light in the color.", state: Same("source")) },
)"#;

const SHADER: &str = "import package::lib::tint::tint;
fn tinted(source: vec4f) -> vec4f { return vec4f(source.rgb * tint(), source.a); }";

const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "tinted": Tinted(source: "scene"),
        "exposed": Exposure(source: "tinted", stops: 0.0),
        "mapped": ToneMap(source: "exposed", curve: Reinhard),
        "encoded": Encode(source: "mapped", transfer: Srgb),
        "look": ColorLut(source: "encoded", file: "looks/look.cube"),
    },
    outputs: { "display": "look" },
)"#;

/// A table that multiplies blue.
fn cube(blue: f32) -> String {
    let corners = (0..8).map(|at| format!("{} {} {}\n", at & 1, at >> 1 & 1, (at >> 2) as f32 * blue));
    format!("LUT_3D_SIZE 2\n{}", corners.collect::<String>())
}

#[test]
fn effects_of_bevy_are_replaced_named_and_given_back() {
    let mut shown = Shown::with_camera(&pipelines(), "lynx.ron", TextureFormat::Rgba8UnormSrgb, |look| look);
    shown.until("a frame", |status| status.is_running && status.passes.len() > 4);
    let world = shown.app.world_mut();
    let camera = world.query_filtered::<Entity, With<Afterimage>>().single(world).expect("there is one camera");
    assert_eq!(world.get::<Tonemapping>(camera), Some(&Tonemapping::None));
    assert_eq!(world.get::<DebandDither>(camera), Some(&DebandDither::Disabled));
    let all = (Bloom::NATURAL, AutoExposure::default(), Tonemapping::AgX, DebandDither::Enabled);
    world.entity_mut(camera).insert(all);
    let status = shown.until("warnings", |status| status.others.len() == 4);
    for (named, effect) in status.others.iter().zip(["Tonemapping", "DebandDither", "Bloom", "AutoExposure"]) {
        assert!(named.contains(effect), "{status:?}");
    }
    let world = shown.app.world_mut();
    let mut entity = world.entity_mut(camera);
    entity.insert((Tonemapping::None, DebandDither::Disabled)).remove::<(Bloom, AutoExposure)>();
    shown.until("no warnings", |status| status.others.is_empty());
    shown.app.world_mut().entity_mut(camera).remove::<Afterimage>();
    shown.run(3);
    let world = shown.app.world_mut();
    assert_eq!(world.get::<Tonemapping>(camera), Some(&Tonemapping::TonyMcMapface));
    assert_eq!(world.get::<DebandDither>(camera), Some(&DebandDither::Enabled));
    assert!(world.get::<AfterimageStatus>(camera).is_none());
    let usages = world.get::<CameraMainTextureUsages>(camera).expect("cameras have it").0;
    assert!(!usages.contains(TextureUsages::STORAGE_BINDING));
}

/// What editors and scene files do.
#[test]
fn the_component_and_its_fields_are_reflected() {
    let mut shown = Shown::with_camera(&pipelines(), "lynx.ron", TextureFormat::Rgba8UnormSrgb, |look| {
        look.set("lit.strength", 0.2)
    });
    let first = shown.settled();
    let world = shown.app.world_mut();
    let camera = world.query_filtered::<Entity, With<Afterimage>>().single(world).expect("there is one camera");
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry: &TypeRegistry = &registry.read();
    for name in ["Setting", "Target", "AfterimageStatus"] {
        assert!(registry.get_with_type_path(&format!("bevy_afterimage::{name}")).is_some(), "{name}");
    }
    let component = registry.get_with_type_path("bevy_afterimage::Afterimage").expect("it is registered");
    let component = component.data::<ReflectComponent>().expect("it is a component");
    let mut entity = world.entity_mut(camera);
    let mut look = component.reflect_mut(&mut entity).expect("the camera has it");
    let fields = look.reflect_mut().as_struct().expect("it is a struct");
    fields.field_mut("tier").expect("there is a tier").apply(&Some("low".to_owned()));
    fields.field_mut("fade").expect("there is a fade").apply(&9_u16);
    let parameters = fields.field_mut("parameters").expect("there are parameters");
    parameters.apply(&std::collections::BTreeMap::from([("lit.strength".to_owned(), Setting::Number(0.9))]));
    let look = world.get::<Afterimage>(camera).expect("it is there");
    assert_eq!((look.tier.as_deref(), &look.parameters["lit.strength"]), (Some("low"), &Setting::Number(0.9)));
    assert_eq!(look.fade, 9);
    shown.once("more bloom", |now| differing(&first, now).1 > 20);
}

/// Without a cut, the eye adapts.
#[test]
fn a_cut_begins_adaptation_anew() {
    let [with, without] = [1, 0].map(|cuts| {
        let mut shown = Shown::with_camera(&pipelines(), "exposure.ron", TextureFormat::Rgba8UnormSrgb, |look| look);
        shown.settled();
        let brighter = LinearRgba::rgb(20.0, 30.0, 40.0);
        shown.app.insert_resource(ClearColor(brighter.into()));
        shown.change(|look| look.cuts += cuts);
        shown.run(2);
        (shown.shown(), shown.settled())
    });
    assert!(differing(&with.0, &with.1).1 <= 2, "{:?}", differing(&with.0, &with.1));
    assert!(differing(&without.0, &without.1).1 > 20, "{:?}", differing(&without.0, &without.1));
}
