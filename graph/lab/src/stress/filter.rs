//! The device's own filter of textures: how finely it weights two texels.

use std::sync::Arc;

use afterimage_gpu::Gpu;
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::Options;

use super::images::Extreme;
use super::render::{OutputPixels, RenderRequest, Renderer, StressFrame};
use super::target::{Overrides, Target};
use super::visible::ShowFilter;

/// A side for which no sampled weight is a multiple of a power of two.
const SIDE: u32 = 61;
/// The largest error of a weight in a filter whose errors are those of 32-bit coordinates. Eight bits of fraction, as
/// many devices have, are off by up to 1/512.
const FINE: f32 = 1.0 / 4096.0;

/// True if the device weights texels so coarsely that pixels next to a bright texel are visibly wrong.
pub(crate) fn is_coarse(gpu: &Gpu, registry: &Arc<Registry>) -> bool {
    let mut renderer = Renderer::new(gpu, true, Options::default());
    largest_error(&mut renderer, registry).is_some_and(|error| error > FINE)
}

/// The largest error of a weight between a black and a white texel.
fn largest_error(renderer: &mut Renderer, registry: &Arc<Registry>) -> Option<f32> {
    let target = Target::kind(registry, &NodeKind::of::<ShowFilter>(), false).ok()?;
    let graph = target.graph(&Overrides::new()).ok()?;
    let inputs = [StressFrame::still(Extreme::named("checkerboard")?)];
    let request =
        RenderRequest { target: &target, graph: &graph, size: Size::new(SIDE, 1), inputs: &inputs, together: true };
    let mut configuration = renderer.configure(|_, _| {}, true);
    let ran = renderer.run(&mut configuration, request).ok()?;
    let shown: &OutputPixels = ran.frames.first()?.first()?;
    let expected = |index: usize| (index as f32 + 0.5) / SIDE as f32;
    let errors = shown.pixels.iter().enumerate().map(|(index, pixel)| (pixel[0] - expected(index)).abs());
    Some(errors.fold(0.0, f32::max))
}
