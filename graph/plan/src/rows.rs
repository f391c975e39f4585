//! Step 4a: a halving that has a form by rows takes it, and makes the texels of its source itself where nobody else needs them.
//!
//! On an H200 at 4K, extracting and halving take 0.039 ms so, and 0.123 ms in two passes of which the second filters thirteen times a texel.

use crate::pass_graph::PassGraph;
use crate::passes::copy_step;
use crate::{Fused, PlanBuilder};
use afterimage_graph::node::{Arg, ImageId, Origin, Pass, Recording, Resource, Rows, Step, Work};

/// Results with fewer texels leave most of the device idle, and are filtered by its texture units or in tiles.
const FEWEST_TEXELS: u64 = 100_000;

/// Filters that reach less far take so few taps that they gain nothing, unless their source need not be stored.
const WIDE: f32 = 2.0;

/// Rows of the result that a workgroup walks down: the more, the less is made twice; the fewer, the more workgroups share a small result.
fn rows_of(texels: u64) -> u32 {
    match texels {
        0..300_000 => 4,
        300_000..1_000_000 => 8,
        _ => 16,
    }
}

pub(crate) fn rows(draft: &mut PlanBuilder, always: bool) -> Vec<Fused> {
    let mut web = PassGraph::new(draft);
    let mut fused = Vec::new();
    for number in 0..web.len() {
        let Some(source) = halved(&web, &draft.recording, number, always) else { continue };
        let maker = maker(&web, &draft.recording, number, source);
        if always || maker.is_some() || reach(&web, number) >= WIDE {
            fused.extend(walk(&mut web, &draft.recording, number, source, maker));
        }
    }
    web.finish(draft);
    fused
}

/// The image that a pass halves, if it can and should do so by rows.
fn halved(web: &PassGraph, recording: &Recording, number: usize, always: bool) -> Option<ImageId> {
    let Work::Steps { steps, result } = &web.get(number)?.work else { return None };
    let [step] = steps.as_slice() else { return None };
    step.by_rows.filter(|_| !web.is_output(*result))?;
    let source = step.args.iter().find_map(|arg| match arg {
        Arg::Texture(image) => Some(*image),
        _ => None,
    })?;
    let (from, to) = (recording.image(source).desc, recording.image(*result).desc);
    let is_exact_half = from.size.width == 2 * to.size.width && from.size.height == 2 * to.size.height;
    // What neighbours hand on is rounded to half floats.
    let is_half_float = !from.format.is_32_bit() && !to.format.is_32_bit();
    (is_exact_half && is_half_float && (always || to.size.texels() >= FEWEST_TEXELS)).then_some(source)
}

fn reach(web: &PassGraph, number: usize) -> f32 {
    match web.get(number).map(|pass| &pass.work) {
        Some(Work::Steps { steps, .. }) => steps[0].reach.unwrap_or_default(),
        _ => 0.0,
    }
}

fn walk(
    web: &mut PassGraph,
    recording: &Recording,
    number: usize,
    source: ImageId,
    maker: Option<usize>,
) -> Option<Fused> {
    let brought = maker.and_then(|maker| web.take(maker));
    let halving = web.take(number).expect("a halving was found");
    let Work::Steps { steps, result } = halving.work else { unreachable!("halvings are passes of steps") };
    let by = steps[0].by_rows.expect("a halving has a form by rows");
    let rows = rows_of(recording.image(result).desc.size.texels());
    let is_brought = brought.is_some();
    let (mut nodes, label, source_steps) = match brought {
        Some(Pass { nodes, label, work: Work::Steps { steps, .. } }) => {
            (nodes, format!("{label} > {}", halving.label), steps)
        }
        _ => (Vec::new(), halving.label, vec![copy_step(&steps[0].node, source)]),
    };
    nodes.extend(halving.nodes);
    nodes.dedup();
    let work = Work::Rows(Rows { source: source_steps, by, result, rows });
    web.put(number, Pass { nodes: nodes.clone(), label, work });
    let image = recording.image(source);
    is_brought.then(|| Fused { image: image.label.clone(), nodes, bytes_saved: 2 * image.desc.bytes() })
}

/// The pass that makes the source, if it looks at single pixels and makes them for this halving alone.
fn maker(web: &PassGraph, recording: &Recording, number: usize, source: ImageId) -> Option<usize> {
    let is_ours = recording.image(source).origin == Origin::Transient && !web.is_kept(source);
    let mut readers = web.readers(Resource::Image(source));
    if !is_ours || readers.any(|reader| reader != number) {
        return None;
    }
    web.writers(Resource::Image(source)).find(|maker| match web.get(*maker).map(|pass| &pass.work) {
        Some(Work::Steps { steps, .. }) => looks_at_pixels(steps),
        _ => false,
    })
}

fn looks_at_pixels(steps: &[Step]) -> bool {
    steps.iter().flat_map(|step| &step.args).all(|arg| !matches!(arg, Arg::Texture(_)))
}
