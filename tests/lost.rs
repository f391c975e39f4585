//! A device that is lost at any point of a frame's life: an error, and the right picture on another device.

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::{Control, PostError, Reading, Watch};
use afterimage_gpu::{Frame, Gpu, GpuError, Opening, Texels, download, upload, wgpu};
use afterimage_graph::image::Size;
use afterimage_graph::value::Value;

use crate::support::gpu::{Picture, changed};
use crate::support::sweep;

/// A host on a device of its own, which can be lost.
struct Host {
    gpu: Gpu,
    scenes: [wgpu::TextureView; 2],
    post: Post,
    watch: Option<Watch>,
}

fn open() -> Gpu {
    let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
    Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}"))
}

fn scenes(gpu: &Gpu) -> [wgpu::TextureView; 2] {
    [Size::new(64, 36), Size::new(80, 45)].map(|size| {
        let picture = Picture::new(size.width, size.height, |x, y| {
            [0.1 + 0.2 * x as f32, 0.3 + (0.4 * y as f32).sin().abs(), 5.0 / (1.0 + (x * y) as f32), 1.0]
        });
        let texels = Texels::from_floats_as_half(size.width, size.height, &picture.pixels);
        let texture = upload(&gpu.device, &gpu.queue, &texels).unwrap_or_else(|error| panic!("{error}"));
        texture.create_view(&Default::default())
    })
}

impl Host {
    fn new() -> Self {
        let gpu = open();
        let post = Post::new(&gpu, changed("exposure.ron", None, &[]));
        Self { scenes: scenes(&gpu), post, watch: None, gpu }
    }

    fn frame(&mut self, scene: usize) -> Result<(), PostError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let frame = Frame { inputs: &[("scene", &self.scenes[scene])], dt: 0.1, ..Frame::default() };
        let recorded = self.post.encode(&mut encoder, &frame);
        self.gpu.queue.submit([encoder.finish()]);
        recorded
    }

    fn control(&mut self) -> Control {
        self.post.control("exposed.stops").expect("it has this parameter")
    }

    /// The steps of a host.
    fn step(&mut self, step: usize) -> Result<(), PostError> {
        match step {
            3 => {
                self.control();
                Ok(())
            }
            5 => {
                let control = self.control();
                self.post.set_value(control, Value::Float(0.2))
            }
            7 => {
                self.watch = Some(self.post.watch("meter.result"));
                Ok(())
            }
            9 => {
                self.post.set_fact("emissive", false);
                Ok(())
            }
            11 => self.post.finish_changes(),
            13 => {
                self.post.change(changed("exposure.ron", Some("high"), &[]));
                Ok(())
            }
            15 => self.post.finish_changes(),
            17 => {
                let _ = self.reading();
                Ok(())
            }
            18 => self.frame(1),
            _ => self.frame(0),
        }
    }

    fn reading(&self) -> Option<&Reading> {
        self.post.reading(self.watch?).unwrap()
    }

    /// The display after a first frame of the settings at the end.
    fn shown(&mut self) -> Vec<u8> {
        self.post.finish_changes().unwrap_or_else(|error| panic!("{error}"));
        self.post.executor().count_from(0);
        self.frame(0).unwrap_or_else(|error| panic!("{error}"));
        let texels = download(&self.gpu.device, &self.gpu.queue, self.post.output("display").unwrap());
        texels.unwrap_or_else(|error| panic!("{error}")).bytes
    }
}

/// Steps of a host: what comes before the first frame, between frames, and while plans are made.
const STEPS: usize = 20;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_device_that_is_lost_at_any_point_is_an_error_and_another_one_goes_on() {
    let mut whole = Host::new();
    (0..STEPS).for_each(|step| whole.step(step).unwrap_or_else(|error| panic!("step {step}: {error}")));
    let wanted = whole.shown();
    assert!(wanted.iter().any(|byte| *byte != wanted[0]));
    // Every step in a whole sweep.
    let stride = if sweep::is_whole() { 1 } else { 4 };
    for lost_before in (0..STEPS).step_by(stride) {
        let mut host = Host::new();
        let mut errors = Vec::new();
        for step in 0..STEPS {
            if step == lost_before {
                host.gpu.device.destroy();
            }
            errors.extend(host.step(step).err());
        }
        // The steps that have failed are made again below, so a host need not know which they were.
        for _ in 0..40 {
            errors.extend(host.frame(0).err());
        }
        assert!(!errors.is_empty(), "lost before step {lost_before}: no error");
        for error in &errors {
            let is_lost = matches!(error, PostError::Gpu(GpuError::DeviceLost { .. }));
            assert!(is_lost, "lost before step {lost_before}: {error}");
            assert!(!error.to_string().contains("memory"), "lost before step {lost_before}: {error}");
        }
        host.gpu = open();
        host.scenes = scenes(&host.gpu);
        host.post.rebuild(&host.gpu);
        let (plan, shown) = (host.post.plan().cloned(), host.shown());
        assert!(plan.is_none(), "the plan of the lost device is gone");
        assert!(shown == wanted, "lost before step {lost_before}: another picture");
        let known: Arc<_> = host.post.plan().expect("it renders").clone();
        host.frame(0).unwrap_or_else(|error| panic!("{error}"));
        assert!(Arc::ptr_eq(&known, host.post.plan().expect("it renders")));
    }
}
