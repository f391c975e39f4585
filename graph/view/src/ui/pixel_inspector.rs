//! The pixel inspector: the pixel under the pointer at every input and node, and that of the 32-bit reference.

use std::collections::BTreeSet;

use afterimage_gpu::wgpu;
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::Pass;
use egui::{RichText, ScrollArea, Ui};

use super::theme::{ACCENT, DIM};
use crate::model::{FrameImages, Model, PipelineInstance, belongs};
use crate::render::{TexelReader, TexelRequest, TexelValue};

/// Reads the pixel from two pipelines: as stored, and in 32 bits.
#[derive(Default)]
pub(super) struct PixelInspector {
    stored: TexelReader,
    exact: TexelReader,
    values: Vec<TexelValue>,
    references: Vec<TexelValue>,
}

/// Numbers that differ by more than this part of the reference, and of 0.001, are marked.
const APART: f32 = 0.02;

impl PixelInspector {
    /// Records copies of the texels at a place.
    pub(super) fn record(&mut self, model: &Model, encoder: &mut wgpu::CommandEncoder, place: [f32; 2]) {
        let device = &model.gpu().device;
        let inspector = model.inspector();
        for (reader, instance) in [(&mut self.stored, inspector.stored()), (&mut self.exact, inspector.reference())] {
            if let Some(instance) = instance {
                let textures = textures(model.frame_images(), instance);
                let texels: Vec<TexelRequest<'_>> =
                    textures.iter().filter_map(|(name, texture)| TexelRequest::new(name, texture, place)).collect();
                reader.record(device, encoder, &texels);
            }
        }
    }

    /// Requests the texels that were copied, and takes those that have arrived; call it after the commands are
    /// submitted.
    pub(super) fn request(&mut self) {
        self.stored.request();
        self.exact.request();
        self.values = self.stored.take().unwrap_or(std::mem::take(&mut self.values));
        self.references = self.exact.take().unwrap_or(std::mem::take(&mut self.references));
    }

    /// The names of the values, in their order.
    pub(super) fn names(&self) -> Vec<&str> {
        self.values.iter().map(|value| &*value.name).collect()
    }

    pub(super) fn show(&self, ui: &mut Ui, place: Option<[f32; 2]>, is_pinned: bool, size: [u32; 2]) {
        let Some([x, y]) = place else {
            ui.label(RichText::new("Point at the picture to read its values; a click pins the place.").color(DIM));
            return;
        };
        let (x, y) = ((x * size[0] as f32) as u32, (y * size[1] as f32) as u32);
        let pinned = if is_pinned { ", pinned" } else { "" };
        let text = format!("Pixel {x}, {y}{pinned}: stored, and in 32 bits where that differs");
        ui.label(RichText::new(text).small());
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            for value in &self.values {
                let reference = self.references.iter().find(|reference| reference.name == value.name);
                line(ui, value, reference);
            }
        });
    }
}

fn line(ui: &mut Ui, stored: &TexelValue, reference: Option<&TexelValue>) {
    ui.label(RichText::new(&stored.name).color(DIM).small());
    ui.add(egui::Label::new(RichText::new(numbers(stored.value)).monospace()).extend());
    if let Some(reference) = reference
        && stored.value.iter().zip(reference.value).any(|(a, b)| are_apart(*a, b))
    {
        let text = RichText::new(numbers(reference.value)).monospace().color(ACCENT);
        ui.add(egui::Label::new(text).extend());
    }
}

/// True if a number differs noticeably from its reference. Two that are NaN do not.
fn are_apart(number: f32, reference: f32) -> bool {
    let distance = (number - reference).abs();
    number.is_nan() != reference.is_nan() || distance > APART * (reference.abs() + 1e-3)
}

fn numbers(value: [f32; 4]) -> String {
    value.map(|number| format!("{:>7}", short(number))).join(" ")
}

/// Four digits, whatever the size.
fn short(number: f32) -> String {
    match number.abs() {
        0.0 => "0".into(),
        large if large >= 1e4 => format!("{number:.1e}"),
        middle if middle >= 100.0 => format!("{number:.1}"),
        middle if middle >= 10.0 => format!("{number:.2}"),
        middle if middle >= 0.001 => format!("{number:.3}"),
        small if small > 0.0 => format!("{number:.1e}"),
        _ => number.to_string(),
    }
}

/// Each image along the chain, by name: the inputs, then of each node after those that it reads. The texels of a baked
/// LUT are of no pixel.
pub(super) fn textures<'t>(
    images: &'t FrameImages,
    instance: &'t PipelineInstance,
) -> Vec<(String, &'t wgpu::Texture)> {
    let inputs = images.images.iter().map(|(name, view)| (name.clone(), view.texture()));
    let mut textures: Vec<_> = inputs.collect();
    let Some(plan) = instance.plan() else { return textures };
    let names = plan.image_names();
    let luts: Vec<String> = plan.savings.baked.iter().map(|baked| format!("{}.table", baked.nodes[0])).collect();
    let written: BTreeSet<usize> =
        plan.work().flat_map(Pass::writes).filter_map(|resource| Some(resource.image()?.0 as usize)).collect();
    for node in chain(instance.graph()) {
        let of_node = written.iter().filter(|index| belongs(&names[**index], node) && !luts.contains(&names[**index]));
        let of_node = of_node.filter_map(|index| Some((names[*index].clone(), instance.image(&names[*index])?)));
        textures.extend(of_node);
    }
    textures
}

/// The names of the nodes, each after those that it reads.
fn chain(graph: &Graph) -> Vec<&str> {
    fn visit<'g>(graph: &'g Graph, node: usize, seen: &mut [bool], chain: &mut Vec<&'g str>) {
        if std::mem::replace(&mut seen[node], true) {
            return;
        }
        for source in graph.nodes[node].wires.iter().flatten() {
            if let Source::Node { node, previous: 0, .. } = source {
                visit(graph, *node, seen, chain);
            }
        }
        chain.push(&graph.nodes[node].name);
    }
    let (mut seen, mut nodes) = (vec![false; graph.nodes.len()], Vec::new());
    let outputs = graph.outputs.iter().filter_map(|output| match output.source {
        Source::Node { node, .. } => Some(node),
        Source::Input(_) => None,
    });
    for node in outputs.chain(0..graph.nodes.len()) {
        visit(graph, node, &mut seen, &mut nodes);
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_few_digits_at_any_size() {
        let shown = [0.0, 0.18, -0.5, 123.456, 65504.0, 1e-7, f32::INFINITY].map(short);
        assert_eq!(shown, ["0", "0.180", "-0.500", "123.5", "6.6e4", "1.0e-7", "inf"]);
        assert_eq!(short(f32::NAN), "NaN");
    }
}
