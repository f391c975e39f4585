//! Whether this adapter draws or dispatches a point pass faster, by the format of the result, and whether half floats and subgroups make it faster.

use afterimage_gpu::{Executor, Gpu, texture_format};
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::Options;
use wgpu::{BindGroupEntry, BindingResource, TextureUsages, TextureView};

use super::clock::{Record, Stopwatch};
use super::inputs::Inputs;
use super::plain::{compute_pipeline, draw, draw_pipeline, group, groups, module, target};
use super::report::table;
use super::runner::Runner;
use crate::args::PipelineOptions;
use crate::cache::{Calibration, Gain, Pair, keep_calibration};
use crate::failure::Failure;
use crate::pipeline::check_text;

/// Measures, remembers, and says what was found.
pub(super) fn run(gpu: &Gpu, registry: &Registry, frames: u32) -> Result<String, Failure> {
    let stopwatch = Stopwatch::new(gpu);
    let side = if gpu.is_processor() { (1280, 720) } else { (3840, 2160) };
    let size = Size::new(side.0.min(gpu.caps.max_side), side.1.min(gpu.caps.max_side));
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let source = target(gpu, size, wgpu::TextureFormat::Rgba16Float, usage);
    let mut calibration = Calibration::default();
    for format in Format::ALL {
        if gpu.caps.storage.contains(&format) && gpu.caps.renderable.contains(&format) {
            let pair = compare(gpu, &stopwatch, &source, size, format, frames)?;
            calibration.formats.insert(format.name().to_owned(), pair);
        }
    }
    let gain = |text, switched| gain(gpu, registry, &stopwatch, (text, size), frames, switched);
    if gpu.caps.half_arithmetic {
        calibration.half = Some(gain(PYRAMID, Options { half: true, ..Options::default() })?);
    }
    if gpu.caps.subgroups {
        calibration.subgroups = Some(gain(METER, Options { subgroups: true, ..Options::default() })?);
    }
    let kept = keep_calibration(gpu, &calibration);
    Ok(describe(&calibration, &gpu.name(), size, kept.as_deref()))
}

fn compare(
    gpu: &Gpu,
    stopwatch: &Stopwatch<'_>,
    source: &TextureView,
    size: Size,
    format: Format,
    frames: u32,
) -> Result<Pair, Failure> {
    let module = module(gpu, &include_str!("calibrate.wgsl").replace("FORMAT", format.wgsl()));
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let result = target(gpu, size, texture_format(format), usage);
    let entry = |binding, view| BindGroupEntry { binding, resource: BindingResource::TextureView(view) };
    let dispatched = compute_pipeline(gpu, &module, "dispatched");
    let [x, y] = groups(size);
    let bound = group(gpu, &dispatched.get_bind_group_layout(0), &[entry(0, source), entry(1, &result)]);
    let compute_ms = stopwatch.median(frames, |encoder| {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&dispatched);
        pass.set_bind_group(0, &bound, &[]);
        pass.dispatch_workgroups(x, y, 1);
        Ok(())
    })?;
    let drawn = draw_pipeline(gpu, &module, "drawn", texture_format(format));
    let bound = group(gpu, &drawn.get_bind_group_layout(0), &[entry(0, source)]);
    let fragment_ms = stopwatch.median(frames, |encoder| {
        draw(encoder, &drawn, &bound, &result);
        Ok(())
    })?;
    Ok(Pair { compute_ms, fragment_ms })
}

/// Sums of taps and little else.
const PYRAMID: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "mips": Downsample(source: "scene", levels: 6, filter: Tap13),
        "bloom": Upsample(source: "mips", filter: Tent, radius: 1.0),
        "lit": Composite(base: "scene", bloom: "bloom", blend: Mix, strength: 0.1),
    },
    outputs: { "lit": "lit" },
)"#;

/// Sums over workgroups and little else.
const METER: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "mean": MeanLuminance(source: "scene"),
        "lit": Exposure(source: "scene", meter: "mean"),
    },
    outputs: { "lit": "lit" },
)"#;

/// The same work without a switch and with it, twice by turns: what is slow for another reason once is hardly so again.
fn gain(
    gpu: &Gpu,
    registry: &Registry,
    stopwatch: &Stopwatch<'_>,
    (text, size): (&str, Size),
    frames: u32,
    switched: Options,
) -> Result<Gain, Failure> {
    let none = PipelineOptions { sets: Vec::new(), facts: Vec::new(), tier: None, nodes: Vec::new() };
    let (graph, _) = check_text("calibration.ron", text, registry, &none)?;
    let inputs = Inputs::new(gpu, registry, &graph, size)?;
    let runner = |options| {
        let executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
        Runner::new(gpu, &inputs, &graph, Default::default(), options, executor)
    };
    let (mut without, mut with) = (runner(Options::default())?, runner(switched)?);
    let mut works: [Record<'_>; 2] =
        [Box::new(|encoder| without.encode(encoder)), Box::new(|encoder| with.encode(encoder))];
    let mut round = || stopwatch.medians(frames, &mut works);
    let (first, second) = (round()?, round()?);
    Ok(Gain { without_ms: first[0].min(second[0]), with_ms: first[1].min(second[1]) })
}

fn describe(calibration: &Calibration, adapter: &str, size: Size, kept: Option<&std::path::Path>) -> String {
    let row = |(format, pair): (&String, &Pair)| {
        vec![format.clone(), format!("{:.4}", pair.compute_ms), format!("{:.4}", pair.fragment_ms)]
    };
    let table = table(&["result", "dispatched, ms", "drawn, ms"], calibration.formats.iter().map(row));
    let verdict = if calibration.prefers_fragment() { "drawn" } else { "dispatched" };
    let switches = [("half", "a pyramid", calibration.half), ("subgroups", "a meter", calibration.subgroups)];
    let gains: String =
        switches.iter().filter_map(|(switch, work, gain)| Some(sentence(switch, work, (*gain)?))).collect();
    let memory = kept.map_or("nothing could be remembered".into(), |path| format!("remembered in {}", path.display()));
    format!(
        "one point pass at {size} on {adapter}\n{table}\npoint passes are {verdict} here from now on\n{gains}{memory}"
    )
}

fn sentence(switch: &str, work: &str, gain: Gain) -> String {
    let Gain { without_ms, with_ms } = gain;
    let verdict = if gain.pays() { "on" } else { "off" };
    format!(
        "{work} takes {with_ms:.4} ms with `--{switch}` and {without_ms:.4} without: {verdict} from now on where it is not given\n"
    )
}
