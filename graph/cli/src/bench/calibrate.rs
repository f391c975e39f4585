//! Whether this adapter draws or dispatches a point pass faster, by the format of the result.

use afterimage_gpu::{Gpu, texture_format};
use afterimage_graph::image::{Format, Size};
use wgpu::{BindGroupEntry, BindingResource, TextureUsages, TextureView};

use super::clock::Stopwatch;
use super::plain::{compute_pipeline, draw, draw_pipeline, group, groups, module, target};
use super::report::table;
use crate::cache::{Calibration, Pair, keep_calibration};
use crate::failure::Failure;

/// Measures, remembers, and says what was found.
pub(super) fn run(gpu: &Gpu, frames: u32) -> Result<String, Failure> {
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

fn describe(calibration: &Calibration, adapter: &str, size: Size, kept: Option<&std::path::Path>) -> String {
    let row = |(format, pair): (&String, &Pair)| {
        vec![format.clone(), format!("{:.4}", pair.compute_ms), format!("{:.4}", pair.fragment_ms)]
    };
    let table = table(&["result", "dispatched, ms", "drawn, ms"], calibration.formats.iter().map(row));
    let verdict = if calibration.prefers_fragment() { "drawn" } else { "dispatched" };
    let memory = kept.map_or("nothing could be remembered".into(), |path| format!("remembered in {}", path.display()));
    format!("one point pass at {size} on {adapter}\n{table}\npoint passes are {verdict} here from now on; {memory}")
}
