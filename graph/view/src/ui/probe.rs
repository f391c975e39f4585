//! The panel of the probe: the pixel under the pointer at every node, and the reference's.

use egui::{RichText, ScrollArea, Ui};

use super::theme::{ACCENT, DIM};
use crate::model::{Chain, Model};
use crate::render::{Probe, Reading, TexelRequest};

/// Reads the pixel from two pipelines: as stored, and in 32 bits.
#[derive(Default)]
pub(super) struct ProbePanel {
    stored: Probe,
    exact: Probe,
    readings: Vec<Reading>,
    references: Vec<Reading>,
}

/// Numbers that differ by more than this part of the reference, and of 0.001, are marked.
const APART: f32 = 0.02;

impl ProbePanel {
    /// Records copies of the texels at a place.
    pub(super) fn record(
        &mut self,
        model: &Model,
        encoder: &mut afterimage_gpu::wgpu::CommandEncoder,
        place: [f32; 2],
    ) {
        let device = &model.gpu().device;
        for (probe, chain) in [(&mut self.stored, model.inspected()), (&mut self.exact, model.reference())] {
            if let Some(chain) = chain {
                probe.record(device, encoder, place, &texels(chain));
            }
        }
    }

    /// Requests the texels that were copied, and takes those that have arrived; call it after the commands are
    /// submitted.
    pub(super) fn request(&mut self) {
        self.stored.request();
        self.exact.request();
        self.readings = self.stored.take().unwrap_or(std::mem::take(&mut self.readings));
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
            for reading in &self.readings {
                let reference = self.references.iter().find(|reference| reference.name == reading.name);
                self.line(ui, reading, reference);
            }
        });
    }

    fn line(&self, ui: &mut Ui, reading: &Reading, reference: Option<&Reading>) {
        ui.label(RichText::new(&reading.name).color(DIM).small());
        ui.add(egui::Label::new(RichText::new(numbers(reading.value)).monospace()).extend());
        if let Some(reference) = reference
            && reading.value.iter().zip(reference.value).any(|(a, b)| are_apart(*a, b))
        {
            let text = RichText::new(numbers(reference.value)).monospace().color(ACCENT);
            ui.add(egui::Label::new(text).extend());
        }
    }
}

/// Whether a number differs noticeably from its reference. Two that are NaN do not.
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
fn texels(chain: &Chain) -> Vec<TexelRequest<'_>> {
    let Some(plan) = chain.plan() else { return Vec::new() };
    let names = plan.image_names();
    let mut texels: Vec<TexelRequest<'_>> = Vec::new();
    for pass in plan.work() {
        for image in pass.writes().iter().filter_map(|resource| resource.image()) {
            let name = &names[image.0 as usize];
            if texels.iter().any(|known| known.name == *name) {
                continue;
            }
            if let Some(texture) = chain.image(name) {
                let desc = plan.image(image).desc;
                // A slice in the middle: which one belongs to a pixel is the node's affair.
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
