//! The content of a plan, as JSON shows it and as the hash is taken of it. Keys are in alphabetical order.

use serde_json::{Value, json};

use super::colorimetry::colorimetry;
use super::drawings::drawing;
use super::fnv::fnv1a;
use super::kernels::KernelView;
use super::names::Names;
use crate::plan::{Batch, CachedResults, Plan, PlanOutput, PlannedImage, PlannedPass, Transition};
use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{BufferLife, Origin, Resource};

/// The content of a plan without its hash.
pub(super) fn content(plan: &Plan) -> Value {
    let names = &Names::new(plan);
    let mut content = json!({
        "barriers": plan.batches.iter().map(|batch| barriers(batch, names)).collect::<Value>(),
        "batches": plan.batches.iter().map(|batch| batch.passes.clone().collect::<Vec<_>>()).collect::<Value>(),
        "buffers": buffers(plan, names),
        "exports": transitions(&plan.exports, names),
        "fused": plan.fused,
        "images": images(plan, names),
        "memory": plan.memory,
        "options": plan.options,
        "outputs": plan.outputs.iter().map(|shown| output(shown, names)).collect::<Value>(),
        "passes": passes(plan, names),
        "shared_reads": plan.shared_reads,
        "size": [plan.size.width, plan.size.height],
        "skipped": plan.skipped,
    });
    if !plan.blocks.is_empty() {
        content["blocks"] =
            plan.blocks.iter().map(|block| json!({ "name": block.name, "type": block.block.name })).collect();
    }
    if !plan.rectangles.is_empty() {
        content["rectangles"] =
            plan.rectangles.iter().map(|input| json!({ "input": input.name, "part": input.part })).collect();
    }
    if !plan.baked.is_empty() {
        content["baked"] = json!(plan.baked);
    }
    if !plan.cached.is_empty() {
        content["cached"] = plan.cached.iter().map(|results| cached(results, names)).collect();
    }
    if !plan.dynamic.is_empty() {
        content["dynamic"] = json!(plan.dynamic);
    }
    // Nothing to do, unless another crate asks `serde_json` to keep the order of insertion.
    content.sort_all_objects();
    content
}

fn output(output: &PlanOutput, names: &Names) -> Value {
    let mut content = json!({
        "colorimetry": colorimetry(output.colorimetry),
        "image": names.image(output.image),
        "name": output.name,
        "state": output.state.name(),
    });
    if output.in_rectangle {
        content["in_rectangle"] = json!(true);
    }
    content
}

fn cached(cached: &CachedResults, names: &Names) -> Value {
    let results: Value = cached.results.iter().map(|result| names.of(*result)).collect();
    json!({ "node": cached.node, "refresh": cached.refresh, "results": results })
}

fn barriers(batch: &Batch, names: &Names) -> Value {
    let mut aliasing = Vec::new();
    for barrier in &batch.aliasing {
        let owners: Value = barrier.owners.iter().map(|image| names.image(*image)).collect();
        aliasing.push(json!({ "image": names.image(barrier.image), "owners": owners }));
    }
    json!({ "aliasing": aliasing, "transitions": transitions(&batch.transitions, names) })
}

fn transitions(transitions: &[Transition], names: &Names) -> Value {
    let views = transitions.iter().map(|t| json!({ "from": t.from, "resource": names.of(t.resource), "to": t.to }));
    views.collect()
}

fn buffers(plan: &Plan, names: &Names) -> Value {
    let named = plan.buffers.iter().zip(names.buffers());
    named.map(|(buffer, name)| json!({ "bytes": buffer.bytes, "life": life(&buffer.life), "name": name })).collect()
}

fn life(life: &BufferLife) -> String {
    match life {
        BufferLife::Constant(bytes) => constant(bytes),
        other => format!("{other:?}").to_lowercase(),
    }
}

/// Constants are part of the plan by their contents.
fn constant(bytes: &[u8]) -> String {
    format!("constant {:032x}", fnv1a(bytes))
}

fn passes(plan: &Plan, names: &Names) -> Value {
    let batches = plan.batches.iter().enumerate();
    let placed = batches.flat_map(|(number, batch)| batch.passes.clone().map(move |at| (number, at)));
    placed.map(|(number, at)| pass(plan, names, number, at)).collect()
}

fn pass(plan: &Plan, names: &Names, batch: usize, at: usize) -> Value {
    let PlannedPass { pass, stage, .. } = &plan.passes[at];
    let target = pass.written_image().map(|image| plan.image(image).desc);
    let named = |resources: Vec<Resource>| resources.into_iter().map(|resource| names.of(resource)).collect::<Value>();
    let runs: Vec<KernelView<'_>> = pass.kernels.iter().map(|kernel| KernelView::new(kernel, names)).collect();
    let mut content = json!({
        "batch": batch,
        "bytes_moved": plan.bytes_moved_by(at),
        "format": target.map(|desc| desc.format.name()),
        "label": pass.label,
        "nodes": pass.nodes,
        "reads": named(pass.reads()),
        "runs": runs,
        "size": target.map(|desc| desc.size.to_string()),
        "stage": format!("{stage:?}"),
        "writes": named(pass.writes()),
    });
    if let Some(drawing) = drawing(&plan.passes[at], names) {
        content["drawing"] = drawing;
    }
    content
}

fn images(plan: &Plan, names: &Names) -> Value {
    plan.images.iter().zip(&names.images).map(|(planned, name)| image(planned, name, names)).collect()
}

fn image(image: &PlannedImage, name: &str, names: &Names) -> Value {
    let ImageDesc { size, format, volume, samples, levels, layers } = image.desc;
    let mut value = json!({
        "bytes": image.desc.bytes(),
        "format": format.name(),
        // The first and the last batch; the number of batches for what leaves the frame.
        "lives": image.lifetime.map(|lifetime| [lifetime.first, lifetime.last]),
        "name": name,
        "offset": image.offset,
        "origin": origin(&image.origin, names),
        "required": image.requirement.map(|requirement| requirement.bytes),
        "sample_mode": format!("{:?}", image.sample_mode),
        "size": size.to_string(),
        "slot": image.slot,
        "volume": volume,
    });
    for (name, count) in [("samples", samples), ("levels", levels), ("layers", layers)] {
        if count > 1 {
            value[name] = count.into();
        }
    }
    value
}

fn origin(origin: &Origin, names: &Names) -> String {
    match origin {
        Origin::Transient => "transient".to_owned(),
        Origin::Input(name) => format!("input {name}"),
        Origin::Constant(bytes) => constant(bytes),
        Origin::Baked => "table".to_owned(),
        Origin::Cached => "cached".to_owned(),
        Origin::Previous { of, frames } => format!("{} {frames} frames ago", names.image(*of)),
    }
}
