//! What ends a fade, what waits for its end, and what it leaves.

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::PostError;
use afterimage_gpu::{Gpu, GpuError, Opening, wgpu};
use afterimage_graph::image::Size;

use super::{BGRA, FRAMES, Host, LOOK, SIZE, all, hosts, one_frame, until_the_change};
use crate::support::gpu::{Shared, graph};

/// Until two frames of the fade are recorded.
fn fading() -> [Host; 3] {
    let mut hosts = hosts(FRAMES);
    all(&mut hosts);
    until_the_change(&mut hosts, true);
    one_frame(&mut hosts, 1, FRAMES);
    one_frame(&mut hosts, 2, FRAMES);
    hosts
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_reset_ends_a_fade() {
    let [_, mut new, mut faded] = fading();
    assert!(new.codes(true) == faded.codes(true), "the new plan alone");
    assert!(faded.missed("does not follow"));
    assert!(new.shown() == faded.shown());
    let [_, mut new, mut faded] = fading();
    for host in [&mut new, &mut faded] {
        host.post.executor().reset();
    }
    assert!(new.shown() == faded.shown());
    assert!(faded.missed("does not follow"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn another_size_ends_a_fade() {
    let [_, mut new, mut faded] = fading();
    let size = Size::new(64, 40);
    for host in [&mut new, &mut faded] {
        host.scenes = host.scenes_of(size);
        host.show_in(size, BGRA);
    }
    for _ in 0..3 {
        assert!(new.shown() == faded.shown(), "the new plan alone");
        assert!(faded.missed("have changed"));
    }
}

/// The view of another texture of the same size is no other image; one of another format is drawn to in its own.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fade_goes_on_in_other_views() {
    let mut hosts = fading();
    for (number, format) in [(3, BGRA), (4, wgpu::TextureFormat::Rgba8Unorm)] {
        hosts.iter_mut().for_each(|host| host.show_in(SIZE, format));
        one_frame(&mut hosts, number, FRAMES);
    }
    let [_, new, faded] = &mut hosts;
    assert!(new.shown() == faded.shown());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_host_that_waits_ends_a_fade() {
    let [_, mut new, mut faded] = fading();
    faded.post.finish_changes().unwrap();
    assert!(faded.missed("has waited"));
    assert!(new.shown() == faded.shown());
}

/// The second change begins to fade from what the first one has become.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_second_change_waits_for_the_end_of_a_fade() {
    let [mut old, mut new, mut faded] = fading();
    let night = faded.post.plan().unwrap().clone();
    faded.night(false);
    for number in 3..=FRAMES {
        let mut hosts = [old, new, faded];
        one_frame(&mut hosts, number, FRAMES);
        [old, new, faded] = hosts;
        assert!(Arc::ptr_eq(&night, faded.post.plan().unwrap()) && faded.post.is_changing(), "the change waits");
    }
    // A host that is where the first change has led to, and asks for the second one with the last frame of the fade.
    let mut late = Host::new(LOOK);
    for frame in 0..new.frame {
        if frame == 1 {
            late.night(true);
        }
        if frame + 1 == new.frame {
            late.night(false);
        }
        late.shown();
    }
    let mut hosts = [new, late, faded];
    for number in 1..=FRAMES {
        one_frame(&mut hosts, number, FRAMES);
    }
    let [_, late, faded] = &mut hosts;
    assert!(!Arc::ptr_eq(&night, faded.post.plan().unwrap()));
    assert!(late.shown() == faded.shown());
}

/// The numbers of textures, views, buffers, bind groups, samplers and pipelines.
fn held(instance: &wgpu::Instance, gpu: &Gpu) -> [usize; 6] {
    gpu.wait().unwrap();
    let report = instance.generate_report().expect("the instance is wgpu's own");
    let hub = report.hub_report();
    [&hub.textures, &hub.texture_views, &hub.buffers, &hub.bind_groups, &hub.samplers, &hub.render_pipelines]
        .map(|kind| kind.num_allocated)
}

/// The memory of a fade is given back, and changes without one have none.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fade_leaves_nothing() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let wanted = std::env::var("AFTERIMAGE_ADAPTER").ok();
    let gpu = pollster::block_on(Gpu::open_on(&instance, wanted.as_deref())).unwrap_or_else(|error| panic!("{error}"));
    let mut host = on(gpu.clone());
    let (scene, view) = (host.scenes[0].clone(), host.view.clone());
    host.scenes.fill(scene);
    // Frames until a change is over: what there is while the first one renders its plan, and afterwards.
    let mut change = |night: bool, fade: u16| {
        host.post.set_fade(fade);
        host.night(night);
        let mut frames = |count: u16| (0..count).for_each(|_| host.encode(&[("display", &view)], false).unwrap());
        frames(2);
        let during = held(&instance, &gpu);
        frames(fade + 1);
        assert!(!host.post.is_fading());
        (during, held(&instance, &gpu))
    };
    let mut last = [change(true, 0), change(false, 0)];
    for fade in [0, 3, 0, 3] {
        let [night, day] = [change(true, fade), change(false, fade)];
        assert_eq!([night.1, day.1], [last[0].1, last[1].1], "what is held after a fade of {fade} frames");
        for (during, after) in [night, day] {
            let more: Vec<bool> = during.iter().zip(after).map(|(during, after)| *during > after).collect();
            assert_eq!(more, [fade > 0; 6], "what is held during a fade of {fade} frames: {during:?}, {after:?}");
        }
        last = [night, day];
    }
}

/// A host on a device of its own.
fn on(gpu: Gpu) -> Host {
    let mut host = Host::new(LOOK);
    host.post = Post::new(&gpu, graph(LOOK));
    host.post.set_task_pool(Arc::new(|task| task()));
    host.night(false);
    host.gpu = Shared::of(gpu);
    host.scenes = host.scenes_of(SIZE);
    host.show_in(SIZE, BGRA);
    host
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_device_that_is_lost_during_a_fade_is_an_error_and_another_one_goes_on() {
    let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
    let open = || Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}"));
    for lost_before in 0..4 {
        let mut host = on(open());
        host.post.set_fade(3);
        host.shown();
        host.night(true);
        let mut errors = Vec::new();
        for frame in 0..40 {
            if frame == lost_before {
                host.gpu.device.destroy();
            }
            let view = host.view.clone();
            errors.extend(host.encode(&[("display", &view)], false).err());
        }
        assert!(!errors.is_empty(), "lost before frame {lost_before}: no error");
        for error in &errors {
            let is_lost = matches!(error, PostError::Gpu(GpuError::DeviceLost { .. }));
            assert!(is_lost, "lost before frame {lost_before}: {error}");
        }
        let mut other = on(open());
        other.night(true);
        host.gpu = other.gpu.clone();
        host.post.rebuild(&host.gpu);
        (host.scenes, host.frame) = (host.scenes_of(SIZE), 0);
        host.show_in(SIZE, BGRA);
        assert!(!host.post.is_fading());
        for _ in 0..2 {
            assert!(other.shown() == host.shown(), "lost before frame {lost_before}: another picture");
        }
    }
}
