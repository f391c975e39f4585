//! Tiers that follow a budget, values that are read back, states of loading, and built-in pipelines.

use afterimage::Error;
use afterimage::host::PIPELINES;
use bevy::asset::{AssetLoadError, LoadState};
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_afterimage::{Afterimage, AfterimageReadings, AfterimageStatus, Pipeline};

use crate::program::differing;
use crate::shown::{Folder, Shown, pipelines};

const TIERS: [&str; 3] = ["low", "high", "ultra"];

fn lynx(change: impl FnOnce(Afterimage) -> Afterimage) -> Shown {
    Shown::with_camera(&pipelines(), "lynx.ron", TextureFormat::Rgba8UnormSrgb, change)
}

fn is_at(tier: &'static str) -> impl Fn(&AfterimageStatus) -> bool {
    move |status| status.is_running && !status.is_changing && status.tier.as_deref() == Some(tier)
}

/// A tier, a budget that is never and one that is always exceeded, and a tier again.
#[test]
fn the_tier_follows_a_budget() {
    let [best, worst] = [2, 0].map(|tier| lynx(|look| look.tier(TIERS[tier])).settled());
    assert_ne!(best, worst);
    let mut shown = lynx(|look| look.tier("high").budget(1e6, TIERS));
    shown.until("the best tier", is_at("ultra"));
    assert_eq!(differing(&shown.settled(), &best), (0, 0));
    shown.change(|look| look.budget.as_mut().expect("it has one").ms = 1e-6);
    shown.until("the worst tier", is_at("low"));
    assert_eq!(differing(&shown.settled(), &worst), (0, 0));
    shown.change(|look| look.budget = None);
    shown.until("the tier of the camera", is_at("high"));
    // A budget of tiers that are not there changes nothing.
    for (tiers, why) in [(vec!["low", "lowest"], "lowest"), (vec![], "needs tiers")] {
        shown.change(|look| *look = look.clone().budget(1.0, tiers));
        let status = shown.until(why, |status| status.files.as_ref().is_some_and(|error| error.contains(why)));
        assert!(is_at("high")(&status), "{status:?}");
    }
    shown.change(|look| (look.budget, look.tier) = (None, None));
    shown.until("the file", |status| status.files.is_none() && status.tier.is_none());
}

/// Each camera of one pipeline has a tier or a budget of its own, and a file that is read again keeps both.
#[test]
fn cameras_of_one_pipeline_have_their_own_budgets() {
    let own = Folder::new("budgets");
    let text = std::fs::read_to_string(pipelines().join("lynx.ron")).expect("it is in the repository");
    own.write("lynx.ron", &text);
    let mut shown = Shown::new(&own.0, TextureFormat::Rgba8UnormSrgb);
    let looks: [fn(Afterimage) -> Afterimage; 3] =
        [|look| look.budget(1e6, TIERS), |look| look.budget(1e-6, TIERS), |look| look.tier("high")];
    for (order, change) in looks.into_iter().enumerate() {
        let look = change(shown.look("lynx.ron"));
        shown.spawn(Vec3::new(0.0, 1.0, 7.0), (Camera { order: order as isize, ..default() }, look));
    }
    let are_at = |shown: &mut Shown, passes: &dyn Fn(usize) -> bool| {
        shown.wait("the tiers", |shown| {
            shown.run(1);
            let world = shown.app.world_mut();
            let mut cameras: Vec<_> = world.query::<(&Camera, &AfterimageStatus)>().iter(world).collect();
            cameras.sort_by_key(|(camera, _)| camera.order);
            let tiers = cameras.iter().map(|(_, status)| status.tier.as_deref());
            let is_steady = cameras.iter().all(|(_, status)| !status.is_changing && passes(status.passes.len()));
            (is_steady && tiers.eq(["ultra", "low", "high"].map(Some))).then_some(())
        });
    };
    are_at(&mut shown, &|passes| passes > 2);
    // A pipeline of less work, with the same tiers.
    own.write(
        "lynx.ron",
        "Pipeline(inputs: { \"scene\": Color }, outputs: { \"display\": \"out\" },
        nodes: { \"out\": Vignette(source: \"scene\", amount: 0.5) },
        tiers: { \"low\": {}, \"high\": {}, \"ultra\": {} })",
    );
    are_at(&mut shown, &|passes| passes == 1);
}

fn readings(shown: &mut Shown) -> AfterimageReadings {
    let world = shown.app.world_mut();
    world.query::<&AfterimageReadings>().single(world).expect("there is one camera").clone()
}

fn reading(shown: &mut Shown, what: &str, is_wanted: impl Fn(Option<Vec4>) -> bool) -> Option<Vec4> {
    shown.wait(what, |shown| {
        shown.run(1);
        let value = readings(shown).0.get("meter.result").copied();
        is_wanted(value).then_some(value)
    })
}

/// The exposure of a meter: a brighter scene has less.
#[test]
fn values_are_read_back() {
    let watched = |look: Afterimage| look.watch("meter.result").watch("metre.result").fact("raining", true);
    let mut shown = Shown::with_camera(&pipelines(), "exposure.ron", TextureFormat::Rgba8UnormSrgb, watched);
    shown.settled();
    let dark = reading(&mut shown, "a value", |value| value.is_some()).expect("it has arrived");
    assert_eq!(readings(&mut shown).0.len(), 1, "a node that is not there has no value");
    let status = shown.until("names", |status| status.unknown.len() == 2);
    for name in ["`metre.result`", "`meter.result`", "`raining`"] {
        assert!(status.unknown.concat().contains(name), "{status:?}");
    }
    shown.app.insert_resource(ClearColor(LinearRgba::rgb(20.0, 30.0, 40.0).into()));
    shown.change(|look| look.cuts += 1);
    reading(&mut shown, "less", |value| value.is_some_and(|value| value.x < dark.x - 2.0 && value.is_finite()));
    shown.change(|look| look.watched.clear());
    reading(&mut shown, "nothing", |value| value.is_none());
    shown.change(|look| look.facts.clear());
}

#[test]
fn what_is_wrong_is_a_state_of_loading() {
    let own = Folder::new("states");
    own.write("look.ron", "Pipeline(inputs: { \"scene\": Color }, nodes: { \"out\": Vignet(source: \"scene\") })");
    let mut shown = Shown::with_camera(&own.0, "look.ron", TextureFormat::Rgba8UnormSrgb, |look| look);
    shown.until("an error", |status| status.files.is_some());
    let state = |shown: &mut Shown| {
        let world = shown.app.world_mut();
        let look = world.query::<&Afterimage>().single(world).expect("there is one camera").pipeline.id();
        world.resource::<AssetServer>().load_state(look)
    };
    let LoadState::Failed(error) = state(&mut shown) else { panic!("{:?}", state(&mut shown)) };
    let AssetLoadError::AssetLoaderError(error) = &*error else { panic!("{error}") };
    let ours = error.error().downcast_ref::<Error>().expect("the error is one of the facade");
    assert!(matches!(ours, Error::Wrong(_)) && ours.to_string().contains("Vignette"), "{ours}");
    own.write("look.ron", crate::program::PASS);
    shown.until("a frame", |status| status.is_running && status.files.is_none());
    assert!(state(&mut shown).is_loaded());
}

/// Also those that name a table or extend another: they are as from the files.
#[test]
fn built_in_pipelines_are_assets() {
    let mut shown = Shown::new(&pipelines(), TextureFormat::Rgba8UnormSrgb);
    let files = PIPELINES.iter().map(|(name, _)| [format!("embedded://afterimage/{name}.ron"), format!("{name}.ron")]);
    let looks: Vec<_> = files.map(|pair| pair.map(|file| shown.look(&file).pipeline)).collect();
    let loaded = |shown: &Shown, look: &Handle<Pipeline>| {
        let pipelines = shown.app.world().resource::<Assets<Pipeline>>();
        pipelines.get(look).map(|pipeline| format!("{:?}", pipeline.graph(None)))
    };
    for [built_in, file] in &looks {
        let both = (0..1000).find_map(|_| {
            shown.run(1);
            Some([loaded(&shown, built_in)?, loaded(&shown, file)?])
        });
        let [built_in, file] = both.unwrap_or_else(|| panic!("{:?} is not loaded", built_in.path()));
        assert!(built_in.starts_with("Ok"));
        assert_eq!(built_in, file);
    }
}
