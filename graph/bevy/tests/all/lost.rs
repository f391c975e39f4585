//! The loss of the device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use afterimage::wgpu;
use bevy::core_pipeline::schedule::Core3d;
use bevy::light::cluster::GlobalClusterSettings;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::error_handler::{ErrorType, RenderErrorHandler, RenderErrorPolicy};
use bevy::render::render_resource::TextureFormat;
use bevy::render::renderer::RenderDevice;
use bevy::render::settings::RenderCreation;
use bevy_afterimage::AfterimageSystems;

use crate::program::differing;
use crate::shown::{Shown, pipelines};

/// How often Bevy has opened another device.
#[derive(Resource, Default)]
struct Losses(usize);

/// A camera of an app that opens another device after a loss.
fn recovering() -> Shown {
    let look = |look: bevy_afterimage::Afterimage| look.set("lit.strength", 0.5);
    let mut shown = Shown::with_camera(&pipelines(), "lynx.ron", TextureFormat::Rgba8UnormSrgb, look);
    // Bevy reads this back, and panics where the device is lost meanwhile.
    shown.app.world_mut().resource_mut::<GlobalClusterSettings>().gpu_clustering = None;
    shown.app.init_resource::<Losses>().insert_resource(RenderErrorHandler(|error, world, _| {
        assert!(matches!(error.ty, ErrorType::DeviceLost), "{error:?}");
        world.resource_mut::<Losses>().0 += 1;
        RenderErrorPolicy::Recover(RenderCreation::default())
    }));
    shown
}

fn lose(device: &RenderDevice) {
    device.wgpu_device().destroy();
    // wgpu tells Bevy of the loss now.
    drop(device.poll(wgpu::PollType::Poll));
}

/// The pipeline is made again on the new device.
fn assert_recovered(shown: &mut Shown, losses: usize, first: &[u8]) {
    for _ in 0..100 {
        shown.run(1);
        if shown.app.world().resource::<Losses>().0 == losses {
            break;
        }
    }
    assert_eq!(shown.app.world().resource::<Losses>().0, losses);
    shown.run(3);
    assert_eq!(differing(&shown.settled(), first), (0, 0));
    let status = shown.status();
    assert!(status.is_running && status.frame.is_none() && status.settings.is_empty(), "{status:?}");
}

#[test]
fn the_same_picture_comes_back_after_a_loss() {
    let mut shown = recovering();
    let first = shown.settled();
    for losses in 1..=2 {
        lose(shown.app.world().resource::<RenderDevice>());
        assert_recovered(&mut shown, losses, &first);
    }
}

/// The device is lost just before a pipeline is recorded, when Bevy has prepared the frame.
#[test]
fn a_loss_before_a_pipeline_is_recorded_is_no_panic() {
    let mut shown = recovering();
    let is_due = Arc::new(AtomicBool::new(false));
    let due = is_due.clone();
    let strike = move |device: Res<RenderDevice>| {
        if due.swap(false, Ordering::Relaxed) {
            lose(&device);
        }
    };
    let render = shown.app.sub_app_mut(RenderApp);
    render.add_systems(Core3d, strike.before(AfterimageSystems::Record));
    let first = shown.settled();
    is_due.store(true, Ordering::Relaxed);
    assert_recovered(&mut shown, 1, &first);
    assert!(!is_due.load(Ordering::Relaxed));
}
