//! The pixel inspector: the pixel under the pointer at every node, and that of the 32-bit reference.

use egui::{RichText, ScrollArea, Ui};

use super::theme::{ACCENT, DIM};
use crate::model::{Model, PipelineInstance};
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
    pub(super) fn record(
        &mut self,
        model: &Model,
        encoder: &mut afterimage_gpu::wgpu::CommandEncoder,
        place: [f32; 2],
    ) {
        let device = &model.gpu().device;
        let inspector = model.inspector();
        for (reader, instance) in [(&mut self.stored, inspector.stored()), (&mut self.exact, inspector.reference())] {
            if let Some(instance) = instance {
                reader.record(device, encoder, place, &texels(instance));
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

/// A texel of each image, in the order of the passes.
fn texels(instance: &PipelineInstance) -> Vec<TexelRequest<'_>> {
    let Some(plan) = instance.plan() else { return Vec::new() };
    let names = plan.image_names();
    let mut texels: Vec<TexelRequest<'_>> = Vec::new();
    for pass in plan.work() {
        for image in pass.writes().iter().filter_map(|resource| resource.image()) {
            let name = &names[image.0 as usize];
            if texels.iter().any(|known| known.name == *name) {
                continue;
            }
            if let Some(texture) = instance.image(name) {
                let desc = plan.image(image).desc;
                // The middle slice: only the node knows which one belongs to a pixel.
                texels.push(TexelRequest { name: name.clone(), texture, desc, slice: desc.size.depth / 2 });
            }
        }
    }
    texels
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
