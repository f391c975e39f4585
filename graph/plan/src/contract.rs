//! The contract of node kinds, with what code generation makes of them: every pass that a kind records becomes a module that naga accepts.

use std::collections::BTreeSet;

use afterimage_base::image::Format;
use afterimage_graph::node::{
    Arg, Cells, CellsReader, ImageId, NodeKind, Pass, Recording, Resource, Rows, Work, for_each_recording,
};
use afterimage_wgsl::{SampleMode, ShaderFeatures};

use crate::codegen::{CELLS_LANES, compose_pass};
use crate::passes::copy_step;

/// The contract of [`afterimage_graph::node::contract`], and beyond it: every pass becomes a valid module, in every way in which its textures
/// may be sampled and its numbers computed.
///
/// # Errors
/// All complaints, one sentence each, with the kind's name in front.
pub fn contract(kinds: &[NodeKind]) -> Result<(), Vec<String>> {
    let mut complaints = afterimage_graph::node::contract(kinds).err().unwrap_or_default();
    for kind in kinds {
        for complaint in of_modules(kind) {
            let complaint = format!("`{}`: {complaint}", kind.name());
            if !complaints.contains(&complaint) {
                complaints.push(complaint);
            }
        }
    }
    if complaints.is_empty() { Ok(()) } else { Err(complaints) }
}

fn of_modules(kind: &NodeKind) -> Vec<String> {
    let (mut shapes, mut modules, mut complaints) = (BTreeSet::new(), BTreeSet::new(), Vec::new());
    for_each_recording(kind, &mut |recording| {
        for pass in &recording.passes {
            if shapes.insert(shape(pass, recording)) {
                module(pass, recording, &mut modules, &mut complaints);
            }
        }
    });
    complaints
}

/// All of a pass that its module depends on.
fn shape(pass: &Pass, recording: &Recording) -> String {
    let formats: Vec<Option<Format>> = pass
        .writes()
        .into_iter()
        .map(|resource| match resource {
            Resource::Image(image) => Some(recording.image(image).desc.format),
            Resource::Buffer(_) => None,
        })
        .collect();
    match &pass.work {
        Work::Steps { steps, .. } => {
            let calls: Vec<_> = steps.iter().map(|step| (&step.shader, &step.function, &step.args)).collect();
            format!("{calls:?} {formats:?}")
        }
        Work::Tiled(tiling) => format!("{tiling:?} {formats:?}"),
        Work::Rows(rows) => format!("{rows:?} {formats:?}"),
        Work::Cells(cells) => format!("{cells:?} {formats:?}"),
        Work::Entry(call) => format!("{:?} {} {:?} {formats:?}", call.shader, call.entry, call.bindings),
    }
}

/// What every device understands.
const PLAIN: ShaderFeatures = ShaderFeatures { half: false, subgroups: false };
/// What few do not.
const RICH: ShaderFeatures = ShaderFeatures { half: true, subgroups: true };
/// Every way in which a module may be composed.
const WAYS: [(SampleMode, ShaderFeatures); 5] = [
    (SampleMode::Plain, PLAIN),
    (SampleMode::ByHand, PLAIN),
    (SampleMode::Sanitized, PLAIN),
    (SampleMode::SanitizedSigned, PLAIN),
    (SampleMode::Plain, RICH),
];

/// The pass as a module, for every way in which its textures may be read and its numbers may be made.
fn module(pass: &Pass, recording: &Recording, modules: &mut BTreeSet<String>, complaints: &mut Vec<String>) {
    let desc_of = |image: ImageId| recording.image(image).desc;
    for (reading, features) in WAYS {
        let composed = compose_pass(pass, &desc_of, &|_| reading, features);
        match composed {
            Ok(composed) if modules.insert(composed.source.clone()) => {
                if let Err(error) = composed.validate() {
                    complaints.push(format!("the pass `{}` is no valid module: {error}", pass.label));
                }
            }
            Ok(_) => {}
            Err(error) => complaints.push(format!("the pass `{}` is no module: {error}", pass.label)),
        }
    }
    by_rows(pass).into_iter().chain(by_cells(pass)).for_each(|pass| module(&pass, recording, modules, complaints));
}

/// The pass in its form by rows, if it has one.
fn by_rows(pass: &Pass) -> Option<Pass> {
    let Work::Steps { steps, result } = &pass.work else { return None };
    let [step] = steps.as_slice() else { return None };
    let source = step.args.iter().find_map(|arg| match arg {
        Arg::Texture(image) => Some(*image),
        _ => None,
    })?;
    let source = vec![copy_step(&step.node, source)];
    let work = Work::Rows(Rows { source, by: step.by_rows?, result: *result, rows: 1 });
    Some(Pass { work, ..pass.clone() })
}

/// The pass in its form by cells, twice, so that names which the framework does not tell apart clash.
fn by_cells(pass: &Pass) -> Option<Pass> {
    let Work::Entry(call) = &pass.work else { return None };
    let by = call.by_cells?;
    let source = call.bindings.iter().find_map(|binding| match binding.resource {
        Resource::Image(image) if binding.name == by.source => Some(image),
        _ => None,
    })?;
    let reader = CellsReader { node: pass.nodes[0].clone(), call: call.clone(), by };
    let readers = vec![reader.clone(), reader];
    let lanes = [CELLS_LANES, 1];
    let work = Work::Cells(Cells { source, readers, coarsest: by.cells, finest: by.cells, lanes, step: by.step });
    Some(Pass { work, ..pass.clone() })
}
