//! The bar of the shown wire: its levels, slices and numbers.

use afterimage_graph::node::PortType;
use egui::{Color32, ComboBox, Pos2, RichText, Sense, Stroke, Ui, Vec2};

use super::Viewer;
use super::picture::Subject;
use super::theme::{DIM, FIELD, wire_color};

impl Viewer {
    /// Which of the wire's images is shown, and how its numbers are made visible.
    pub(super) fn tap_bar(&mut self, ui: &mut Ui) {
        let Some(mut tap) = self.model.tap().cloned() else { return };
        let before = tap.clone();
        ui.horizontal(|ui| {
            ui.label(RichText::new(&tap.wire).strong());
            match self.model.wire_type(&tap.wire) {
                Some(PortType::Table) => return self.table(ui),
                Some(PortType::Value) => return self.value(ui),
                Some(PortType::Block) => {
                    ui.label(RichText::new("A host gives this block: it has no image.").color(DIM));
                    return;
                }
                Some(PortType::Multisampled) => {
                    ui.label(RichText::new("A host gives this image: look at its `Resolve`.").color(DIM));
                    return;
                }
                _ => {}
            }
            let images = self.model.tap_images(&tap.wire);
            if images.len() > 1 {
                let shown = images.get(tap.index).map_or(String::new(), |image| image.name.clone());
                ComboBox::from_id_salt("tapped").selected_text(shown).width(170.0).show_ui(ui, |ui| {
                    for (index, image) in images.iter().enumerate() {
                        ui.selectable_value(&mut tap.index, index, format!("{}  {}", image.name, image.desc.size));
                    }
                });
            }
            if let Some((image, _)) = self.model.tapped() {
                if image.desc.volume {
                    let last = image.desc.size.depth - 1;
                    ui.add(egui::Slider::new(&mut tap.slice, 0..=last).text("slice"));
                }
                ui.label(RichText::new(format!("{} {}", image.desc.size, image.desc.format.name())).color(DIM));
            } else if self.model.is_tap_compiling() {
                ui.label(RichText::new("Compiling…").color(DIM));
            } else {
                let text = "No pass of the plan makes it: the node is skipped, or nothing reads it.";
                ui.label(RichText::new(text).color(DIM));
            }
            self.range(ui);
        });
        if tap != before {
            self.model.set_tap(Some(tap));
        }
    }

    /// The range that is shown from black to white, for numbers that are no light.
    fn range(&mut self, ui: &mut Ui) {
        if !Subject::of(&self.model).is_some_and(|subject| subject.is_data()) {
            return;
        }
        ui.label("shown from");
        let (low, high) = &mut self.picture.range;
        ui.add(egui::DragValue::new(low).speed(0.01));
        ui.label("to");
        ui.add(egui::DragValue::new(high).speed(0.01));
        if ui.button("Range of the image").clicked() {
            self.picture.range = self.scopes.range().unwrap_or(self.picture.range);
        }
    }

    fn value(&mut self, ui: &mut Ui) {
        let bytes = self.model.tapped_bytes().unwrap_or_default();
        let numbers: Vec<f32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        let text = numbers.iter().map(|number| format!("{number:>12.6}")).collect::<Vec<_>>().join(" ");
        ui.label(RichText::new(text).monospace());
    }

    /// A table as a plot of its first words.
    fn table(&mut self, ui: &mut Ui) {
        let bytes = self.model.tapped_bytes().unwrap_or_default();
        let numbers = words(&bytes);
        let (rect, _) = ui.allocate_exact_size(Vec2::new(ui.available_width() - 90.0, 60.0), Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, FIELD);
        let most = numbers.iter().copied().fold(1e-9, f64::max);
        let step = (rect.width() / numbers.len().max(1) as f32).max(0.1);
        for (index, number) in numbers.iter().enumerate() {
            let x = rect.min.x + (index as f32 + 0.5) * step;
            let height = (number / most).clamp(0.0, 1.0) as f32 * (rect.height() - 2.0);
            let ends = [Pos2::new(x, rect.max.y), Pos2::new(x, rect.max.y - height)];
            painter.line_segment(ends, Stroke::new(step.max(1.0), wire_color(PortType::Table)));
        }
        let text = format!("{} numbers, at most {most:.4}", numbers.len());
        painter.text(
            rect.left_top() + Vec2::new(4.0, 2.0),
            egui::Align2::LEFT_TOP,
            text,
            egui::FontId::proportional(10.0),
            Color32::GRAY,
        );
    }
}

/// The numbers of a table: counts if they are small integers, floats otherwise.
fn words(bytes: &[u8]) -> Vec<f64> {
    let words: Vec<u32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    let is_count = words.iter().all(|word| *word < 1 << 28);
    let number = |word: &u32| if is_count { f64::from(*word) } else { f64::from(f32::from_bits(*word)) };
    words.iter().map(number).filter(|number| number.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_counts_and_of_floats_are_told_apart() {
        assert_eq!(words(bytemuck::cast_slice(&[3u32, 0, 70_000])), [3.0, 0.0, 70_000.0]);
        assert_eq!(words(bytemuck::cast_slice(&[0.5f32, 2.0])), [0.5, 2.0]);
    }
}
