//! Validation errors: wgpu refuses what is beyond the limits of a device that was opened with less than the capabilities
//! that plans rely on.

use afterimage::host::PostError;
use afterimage::offline::Session;
use afterimage_gpu::{FrameStep, Gpu, GpuError, Opening, Texels};
use afterimage_graph::check::Facts;
use afterimage_graph::image::Size;
use afterimage_plan::Options;

use crate::support::gpu::{Picture, another_device, built_in};

/// The limit that is lowered, and its value.
type Lowered = (&'static str, fn(&mut wgpu::Limits));

const LOWERED: &[Lowered] = &[
    ("buffers", |limits| limits.max_buffer_size = 64),
    ("storage buffers", |limits| limits.max_storage_buffers_per_shader_stage = 0),
    ("bytes of storage buffers", |limits| limits.max_storage_buffer_binding_size = 16),
    ("storage textures", |limits| limits.max_storage_textures_per_shader_stage = 0),
    ("textures", |limits| limits.max_sampled_textures_per_shader_stage = 0),
    ("uniforms", |limits| limits.max_uniform_buffers_per_shader_stage = 0),
    ("bytes of uniforms", |limits| limits.max_uniform_buffer_binding_size = 4),
    ("bindings", |limits| limits.max_bindings_per_bind_group = 1),
    ("invocations", |limits| limits.max_compute_invocations_per_workgroup = 1),
    ("workgroup width", |limits| limits.max_compute_workgroup_size_x = 1),
    ("workgroups", |limits| limits.max_compute_workgroups_per_dimension = 1),
    ("sides of textures", |limits| limits.max_texture_dimension_2d = 64),
];

/// The device's objects have less than it promises.
fn open(whole: &Gpu, lower: fn(&mut wgpu::Limits)) -> Gpu {
    let mut limits = whole.device.limits();
    lower(&mut limits);
    another_device(whole, whole.device.features(), limits)
}

fn frame(session: &mut Session, picture: &Picture) -> Result<Texels, PostError> {
    let texels = Texels::from_floats_as_half(picture.width, picture.height, &picture.pixels);
    let images = [session.feed("scene", texels.desc, &texels.bytes)?];
    session.render(Size::new(picture.width, picture.height), &images, FrameStep::FIRST)?;
    Ok(session.output("display")?)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_a_device_refuses_is_an_error_and_the_old_plan_runs_on() {
    let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
    let whole = Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}"));
    let graph = built_in("exposure.ron", None);
    let session = |gpu: &Gpu| Session::new(gpu, graph.clone(), Facts::default(), Options::default());
    let scene = |width, height| Picture::new(width, height, |x, y| [0.1 + x as f32, 0.5, 0.1 * y as f32, 1.0]);
    let (small, large) = (scene(16, 9), scene(96, 54));
    let wanted = frame(&mut session(&whole), &small).unwrap_or_else(|error| panic!("{error}"));
    let mut unharmed = Vec::new();
    for (what, lower) in LOWERED {
        let mut session = session(&open(&whole, *lower));
        let first = frame(&mut session, &small);
        let second = frame(&mut session, &large);
        let refused = |error: &PostError| matches!(error, PostError::Gpu(GpuError::Refused { .. }));
        let errors: Vec<PostError> =
            [first.as_ref().err(), second.err().as_ref()].into_iter().flatten().cloned().collect();
        assert!(errors.iter().all(refused), "{what}: {errors:?}");
        if errors.is_empty() {
            unharmed.push(*what);
        }
        if let Ok(texels) = first {
            assert_eq!(texels, wanted, "{what}");
            let again = frame(&mut session, &small).unwrap_or_else(|error| panic!("{what}: {error}"));
            assert_eq!(again, wanted, "{what}: the old plan");
        }
    }
    assert_eq!(unharmed, Vec::<&str>::new(), "these limits change nothing");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_executor_that_could_not_be_made_says_so_for_every_plan() {
    let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
    let whole = Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}"));
    let gpu = open(&whole, |limits| limits.max_buffer_size = 4);
    let picture = Picture::new(4, 2, |x, y| [x as f32, y as f32, 0.5, 1.0]);
    let mut session = Session::new(&gpu, built_in("exposure.ron", None), Facts::default(), Options::default());
    for _ in 0..2 {
        let error = frame(&mut session, &picture).expect_err("the executor has no buffers");
        let PostError::Gpu(GpuError::Refused { what, .. }) = error else { panic!("{error}") };
        assert_eq!(what, "the executor");
    }
}
