//! What is logged, and Bevy's diagnostics.

use std::fmt::Write;
use std::sync::{Mutex, Once, PoisonError};

use bevy::diagnostic::DiagnosticsStore;
use bevy::log::tracing::field::{Field, Visit};
use bevy::log::tracing::{Event, Level, Metadata, Subscriber, subscriber};
use bevy::log::tracing_subscriber::layer::{Context, SubscriberExt};
use bevy::log::tracing_subscriber::{Layer, registry};
use bevy::post_process::auto_exposure::AutoExposure;
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy_afterimage::AfterimagePlugin;

use crate::shown::{Folder, Shown, pipelines};

/// Warnings and errors of all apps of this process, a line each.
static LINES: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Listener;

impl<S: Subscriber> Layer<S> for Listener {
    fn enabled(&self, metadata: &Metadata<'_>, _: Context<'_, S>) -> bool {
        *metadata.level() <= Level::WARN
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut line = Line(event.metadata().target().to_owned());
        event.record(&mut line);
        LINES.lock().unwrap_or_else(PoisonError::into_inner).push(line.0);
    }
}

struct Line(String);

impl Visit for Line {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        if field.name() == "message" {
            write!(self.0, ": {value:?}").expect("a text can be written to");
        }
    }
}

/// Keeps warnings and errors from now on.
pub(crate) fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| subscriber::set_global_default(registry().with(Listener)).expect("nothing else listens"));
}

/// How many lines have this text. Other tests log, too.
pub(crate) fn times(part: &str) -> usize {
    LINES.lock().unwrap_or_else(PoisonError::into_inner).iter().filter(|line| line.contains(part)).count()
}

#[test]
fn what_is_wrong_is_logged_once() {
    listen();
    let own = Folder::new("logged");
    own.write("wrong.ron", "Pipeline(inputs: { \"scene\": Color }, nodes: { \"out\": Vignet(source: \"scene\") })");
    let mut shown = Shown::new(&pipelines(), TextureFormat::Rgba8UnormSrgb);
    // No other test has a camera of this number.
    (0..5000).for_each(|_| _ = shown.app.world_mut().spawn_empty());
    let look = shown.look("lynx.ron").set("lit.strenght", 0.2);
    let camera = shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
    shown.until("a frame", |status| status.is_running);
    shown.app.world_mut().entity_mut(camera).insert(AutoExposure::default());
    shown.until("a warning", |status| !status.others.is_empty());
    shown.run(20);
    assert_eq!(times("bevy_afterimage::running: `lit` has no parameter `strenght`"), 1);
    assert_eq!(times(&format!("camera {camera} has a pipeline and Bevy's `AutoExposure`")), 1);
    // What Bevy logs of a file has its excerpt.
    let mut shown = Shown::with_camera(&own.0, "wrong.ron", TextureFormat::Rgba8UnormSrgb, |look| look);
    shown.until("an error", |status| status.files.is_some());
    shown.run(20);
    assert_eq!(times("Vignet(source"), 1);
}

/// Times are data of Bevy's diagnostics.
#[test]
fn times_are_diagnostics() {
    let plugins = (AfterimagePlugin::default(), RenderDiagnosticsPlugin);
    let mut shown = Shown::with_plugin(&pipelines(), TextureFormat::Rgba8UnormSrgb, plugins);
    let look = shown.look("lynx.ron");
    shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
    shown.until("a frame", |status| status.is_running);
    shown.run(30);
    let diagnostics = shown.app.world().resource::<DiagnosticsStore>();
    let time = |name: &str| {
        let found = diagnostics.iter().find(|diagnostic| diagnostic.path().as_str() == name);
        found.and_then(|diagnostic| diagnostic.value()).unwrap_or_default()
    };
    for name in ["render/afterimage/elapsed_cpu", "render/afterimage/elapsed_gpu"] {
        let known: Vec<_> = diagnostics.iter().map(|diagnostic| diagnostic.path().as_str()).collect();
        assert!(time(name) > 0.0, "{name}: {known:?}");
    }
}
