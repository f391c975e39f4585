//! The contract of node kinds, with code generation: every pass that a kind records becomes a module that naga accepts.

use std::collections::BTreeSet;

use afterimage_base::image::Format;
use afterimage_graph::node::{CellReduce, ImageId, NodeKind, Pass, PassKind, Recording, Resource, for_each_recording};
use afterimage_wgsl::{SampleMode, ShaderFeatures};

use crate::builder::copy_kernel;
use crate::codegen::{CodeOptions, compose_pass};
use crate::fusion::{row_kernel, row_pass};

/// The contract of [`afterimage_graph::node::contract`], and beyond it: every pass becomes a valid module, in every way
/// in which its textures may be sampled and its numbers computed.
///
/// # Errors
/// All complaints, one sentence each, with the kind's name in front.
pub fn contract(kinds: &[NodeKind]) -> Result<(), Vec<String>> {
    let mut complaints = afterimage_graph::node::contract(kinds).err().unwrap_or_default();
    let complaint = |kind: &NodeKind, complaint: String| format!("`{}`: {complaint}", kind.name());
    for complaint in kinds.iter().flat_map(|kind| of_modules(kind).into_iter().map(|text| complaint(kind, text))) {
        if !complaints.contains(&complaint) {
            complaints.push(complaint);
        }
    }
    if complaints.is_empty() { Ok(()) } else { Err(complaints) }
}

fn of_modules(kind: &NodeKind) -> Vec<String> {
    let (mut shapes, mut modules, mut complaints) = (BTreeSet::new(), BTreeSet::new(), Vec::new());
    for_each_recording(kind, &mut |recording| {
        let new = recording.passes.iter().filter(|pass| shapes.insert(shape(pass, recording)));
        new.for_each(|pass| module(pass, recording, &mut modules, &mut complaints));
    });
    complaints
}

/// All of a pass that its module depends on.
fn shape(pass: &Pass, recording: &Recording) -> String {
    let format = |resource: Resource| resource.image().map(|image| recording.image(image).desc.format);
    let formats: Vec<Option<Format>> = pass.writes().into_iter().map(format).collect();
    let calls: Vec<_> = pass.kernels.iter().map(|kernel| (&kernel.shader, &kernel.function, &kernel.args)).collect();
    format!("{calls:?} {:?} {formats:?}", pass.kind)
}

/// What every device understands.
const PLAIN: ShaderFeatures = ShaderFeatures { half: false, subgroups: false };
/// What few do not.
const RICH: ShaderFeatures = ShaderFeatures { half: true, subgroups: true };
/// Every way in which a module may be composed.
const WAYS: [(SampleMode, ShaderFeatures); 6] = [
    (SampleMode::Plain, PLAIN),
    (SampleMode::ByHand, PLAIN),
    (SampleMode::Sanitized, PLAIN),
    (SampleMode::SanitizedLight, PLAIN),
    (SampleMode::SanitizedSigned, PLAIN),
    (SampleMode::Plain, RICH),
];

/// The pass as a module, for every way in which its textures may be read and its numbers may be made.
fn module(pass: &Pass, recording: &Recording, modules: &mut BTreeSet<String>, complaints: &mut Vec<String>) {
    let desc_of = |image: ImageId| recording.image(image).desc;
    for (reading, features) in WAYS {
        let options = CodeOptions { features, immediates: features == RICH };
        let fault = match compose_pass(pass, &desc_of, &|_| reading, options) {
            Ok(composed) if !modules.insert(composed.source.clone()) => None,
            Ok(composed) => composed.validate().err().map(|error| format!("no valid module: {error}")),
            Err(error) => Some(format!("no module: {error}")),
        };
        complaints.extend(fault.map(|fault| format!("the pass `{}` is {fault}", pass.label)));
    }
    by_rows(pass).into_iter().chain(by_cells(pass)).for_each(|pass| module(&pass, recording, modules, complaints));
}

/// The pass in its form by rows, if it has one.
fn by_rows(pass: &Pass) -> Option<Pass> {
    let (image, [kernel]) = (pass.function_result()?, pass.kernels.as_slice()) else { return None };
    let by = kernel.by_rows?;
    let kernels = vec![copy_kernel(&kernel.node, kernel.textures().next()?), row_kernel(&kernel.node, by)];
    Some(row_pass(pass.nodes.clone(), pass.label.clone(), kernels, image, (by, 1)))
}

/// The pass in its form by cells, twice, so that names which the framework does not keep apart clash.
fn by_cells(pass: &Pass) -> Option<Pass> {
    let [kernel] = pass.kernels.as_slice() else { return None };
    let by = kernel.by_cells?;
    kernel.arg(by.source)?;
    let invocations = [CellReduce::MOST_INVOCATIONS, 1];
    let kind = CellReduce { coarsest: by.cells, finest: by.cells, invocations, stride: by.stride };
    let kernels = vec![kernel.clone(), kernel.clone()];
    Some(Pass { kernels, kind: PassKind::CellReduce(kind), ..pass.clone() })
}
