//! The bar of the inspected wire: its levels, slices and numbers.

use afterimage_graph::node::PortType;
use egui::{Color32, ComboBox, Pos2, RichText, Sense, Stroke, Ui, Vec2};

use super::list_keys::choose_by_keys;
use super::missing_image::lacking;
use super::picture::{PictureView, Subject};
use super::scopes::ScopePanel;
use super::theme::{DIM, FIELD, wire_color};
use crate::model::Model;

/// Shows the bar, if a wire is inspected. The user chooses one of its images, and the range of its numbers.
pub(super) fn show(ui: &mut Ui, model: &mut Model, picture: &mut PictureView, scopes: &ScopePanel) {
    let Some(mut inspected) = model.inspector().wire().cloned() else { return };
    let before = inspected.clone();
    ui.horizontal(|ui| {
        ui.label(RichText::new(&inspected.wire).strong());
        match model.editor().checked().and_then(|checked| checked.wire_type(&inspected.wire)) {
            Some(PortType::Table) => return table(ui, &model.inspected_bytes().unwrap_or_default()),
            Some(PortType::Value) => return value(ui, &model.inspected_bytes().unwrap_or_default()),
            _ => {}
        }
        if let Some(text) = lacking(model) {
            ui.label(RichText::new(text).color(DIM));
            return;
        }
        let images = model.inspector().images(&inspected.wire);
        if images.len() > 1 {
            let shown = images.get(inspected.index).map_or(String::new(), |image| image.name.clone());
            ComboBox::from_id_salt("inspected image").selected_text(shown).width(170.0).show_ui(ui, |ui| {
                let present = inspected.index;
                let mut entries = Vec::new();
                for (index, image) in images.iter().enumerate() {
                    let text = format!("{}  {}", image.name, image.desc.size);
                    entries.push((ui.selectable_value(&mut inspected.index, index, text), &*image.name));
                }
                choose_by_keys(ui, &entries, present);
            });
        }
        if let Some((image, _)) = model.inspected_image() {
            if image.desc.volume {
                let last = image.desc.size.depth - 1;
                ui.add(egui::Slider::new(&mut inspected.slice, 0..=last).text("slice"));
            }
            ui.label(RichText::new(format!("{} {}", image.desc.size, image.desc.format.name())).color(DIM));
        }
        if Subject::of(model).is_some_and(|subject| subject.is_data()) {
            range(ui, &mut picture.range, scopes);
        }
    });
    if inspected != before {
        model.inspect_wire(Some(inspected));
    }
}

/// The range of data that is shown from black to white.
fn range(ui: &mut Ui, range: &mut (f32, f32), scopes: &ScopePanel) {
    ui.label("shown from");
    ui.add(egui::DragValue::new(&mut range.0).speed(0.01));
    ui.label("to");
    ui.add(egui::DragValue::new(&mut range.1).speed(0.01));
    if ui.button("Range of the image").clicked() {
        *range = scopes.range().unwrap_or(*range);
    }
}

fn value(ui: &mut Ui, bytes: &[u8]) {
    let numbers: Vec<f32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    let text = numbers.iter().map(|number| format!("{number:>12.6}")).collect::<Vec<_>>().join(" ");
    ui.label(RichText::new(text).monospace());
}

/// A table as a plot of its first words.
fn table(ui: &mut Ui, bytes: &[u8]) {
    let numbers = words(bytes);
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
