//! Frames of each kind of change, each in a function of its own, for a profiler that counts instructions.
//!
//! The times of `host.rs` depend on the clock and the load of a machine; instructions hardly do. With Valgrind, and the
//! path of the newest `target/release/deps/instructions-*`:
//!
//! ```text
//! cargo rustc -p afterimage --profile bench --bench instructions -- -C strip=none
//! valgrind --tool=callgrind --callgrind-out-file=frames.out PATH caracal
//! callgrind_annotate --inclusive=yes frames.out | grep 'instructions::in_which'
//! ```
//!
//! The instructions of a kind are those of its function by [`FRAMES`]. With `PATH caracal fade`, plans fade in.
#![allow(clippy::print_stdout, reason = "a benchmark's figures are its output")]

use std::error::Error;
use std::hint::black_box;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use afterimage::Post;
use afterimage::host::Parameter;
use afterimage_gpu::{Frame, Gpu, Opening, Task, TaskPool, Texels, upload, wgpu};
use afterimage_graph::check::{CheckOptions, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;

const SIZE: Size = Size { width: 64, height: 36, depth: 1 };
/// How many frames of each kind are recorded.
const FRAMES: usize = 8;
/// Frames of a fade, of which the first is the one in which a plan comes in.
const FADE: u16 = 2;

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    // `cargo test` and `cargo bench` give flags of their own.
    let mut arguments = std::env::args().skip(1).filter(|argument| !argument.starts_with('-'));
    let pipeline = arguments.next();
    let gpu = Gpu::open(&Opening::default())?;
    let mut host = Host::new(&gpu, pipeline.as_deref().unwrap_or("caracal"))?;
    let strength = host.post.parameter::<f32>("lit.strength")?;
    if arguments.next().is_some_and(|argument| argument == "fade") {
        host.post.set_fade(FADE);
    }
    host.post.set_fact("emissive", false);
    host.frame(in_which_nothing_counts)?;
    for is_emissive in [true, false] {
        host.activate(is_emissive, [in_which_nothing_counts; 4])?;
    }
    for round in 0..FRAMES {
        let kinds: [Record; 4] =
            [in_which_a_plan_is_asked_for, in_which_a_plan_comes_in, in_which_a_fade_goes_on, in_which_a_plan_is_there];
        host.activate(round % 2 == 0, kinds)?;
        host.frame(in_which_nothing_changes)?;
        host.move_parameter(strength, 0.003 + 0.001 * round as f32)?;
        host.frame(in_which_nothing_counts)?;
        host.views[1] = host.output.create_view(&Default::default());
        host.frame(in_which_the_output_is_new)?;
        host.views = [&host.input, &host.output].map(|texture| texture.create_view(&Default::default()));
        host.frame(in_which_all_views_are_new)?;
    }
    for is_emissive in [true, false] {
        host.activate(is_emissive, [in_which_nothing_counts; 4])?;
        // As many as are remembered: from then on each new one takes the place of the oldest.
        for frame in 0..16 + FRAMES / 2 {
            host.views[1] = host.output.create_view(&Default::default());
            host.frame(if frame < 16 { in_which_nothing_counts } else { in_which_the_oldest_output_is_dropped })?;
        }
    }
    println!("{FRAMES} frames of each kind");
    Ok(())
}

/// What records a frame.
type Record = fn(&mut Post, &mut wgpu::CommandEncoder, &Frame<'_>) -> Outcome;

/// Functions that differ in their names, which a profiler shows.
macro_rules! frames {
    ($($name:ident),*) => {
        $(#[inline(never)]
        fn $name(post: &mut Post, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) -> Outcome {
            // Equal functions may become one.
            black_box(stringify!($name));
            Ok(post.encode(encoder, frame)?)
        })*
    };
}

frames!(
    in_which_nothing_counts,
    in_which_nothing_changes,
    in_which_a_parameter_is_new,
    in_which_the_output_is_new,
    in_which_the_oldest_output_is_dropped,
    in_which_all_views_are_new,
    in_which_a_plan_is_asked_for,
    in_which_a_plan_comes_in,
    in_which_a_fade_goes_on,
    in_which_a_plan_is_there
);

#[inline(never)]
fn in_which_a_parameter_is_set(post: &mut Post, parameter: Parameter<f32>, value: f32) -> Outcome {
    Ok(post.set(parameter, value)?)
}

struct Host<'g> {
    gpu: &'g Gpu,
    post: Post,
    input: wgpu::Texture,
    output: wgpu::Texture,
    views: [wgpu::TextureView; 2],
    tasks: Tasks,
}

/// A pool of one thread, which knows when nothing is left to do.
#[derive(Clone, Default)]
struct Tasks(Arc<(Mutex<usize>, Condvar)>);

impl Tasks {
    fn pool(&self) -> TaskPool {
        let (sender, receiver) = std::sync::mpsc::channel::<Task>();
        let ended = self.clone();
        std::thread::spawn(move || {
            for task in receiver {
                task();
                ended.add(-1);
            }
        });
        let begun = self.clone();
        Arc::new(move |task| {
            begun.add(1);
            // The thread is there as long as the program.
            let _ = sender.send(task);
        })
    }

    fn add(&self, tasks: isize) {
        let mut left = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        *left = left.saturating_add_signed(tasks);
        self.0.1.notify_all();
    }

    fn wait(&self) {
        let mut left = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        while *left > 0 {
            left = self.0.1.wait(left).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<'g> Host<'g> {
    fn new(gpu: &'g Gpu, pipeline: &str) -> Result<Self, Box<dyn Error>> {
        let path = format!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/{}.ron"), pipeline);
        let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
        let document = parse(&path, &std::fs::read_to_string(&path)?)?;
        let (graph, _) = check(&document, &Registry::new(&[afterimage_nodes::ALL])?, &options)?;
        let pixels: Vec<_> = (0..SIZE.texels()).map(|at| [at as f32 * 1e-4, 0.5, 2.0, 1.0]).collect();
        let texels = Texels::from_floats_as_half(SIZE.width, SIZE.height, &pixels);
        let (input, output) = (upload(&gpu.device, &gpu.queue, &texels)?, screen(gpu));
        let views = [&input, &output].map(|texture| texture.create_view(&Default::default()));
        let (mut post, tasks) = (Post::new(gpu, graph), Tasks::default());
        post.set_task_pool(tasks.pool());
        Ok(Self { gpu, post, input, output, views, tasks })
    }

    fn frame(&mut self, record: Record) -> Outcome {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let (inputs, outputs) = (&[("scene", &self.views[0])], &[("display", &self.views[1])]);
        let frame = Frame { inputs, outputs, dt: 1.0 / 60.0, ..Frame::default() };
        record(&mut self.post, &mut encoder, &frame)?;
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }

    fn move_parameter(&mut self, parameter: Parameter<f32>, value: f32) -> Outcome {
        in_which_a_parameter_is_set(&mut self.post, parameter, value)?;
        self.frame(in_which_a_parameter_is_new)
    }

    /// Sets the fact that needs another plan, asks for it, and brings it in from the background.
    fn activate(&mut self, is_emissive: bool, [ask, swap, fade, follow]: [Record; 4]) -> Outcome {
        self.post.set_fact("emissive", is_emissive);
        self.frame(ask)?;
        let old = self.post.plan().map(Arc::as_ptr);
        self.tasks.wait();
        self.frame(swap)?;
        if old == self.post.plan().map(Arc::as_ptr) {
            return Err("the fact has no other plan".into());
        }
        while self.post.is_fading() {
            self.frame(fade)?;
        }
        self.frame(follow)
    }
}

fn screen(gpu: &Gpu) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("screen"),
        size: wgpu::Extent3d { width: SIZE.width, height: SIZE.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Bgra8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}
