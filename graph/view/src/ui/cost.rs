//! The cost panel: GPU time of passes and frames, memory, batches.

use std::collections::VecDeque;
use std::sync::{Arc, Weak};

use afterimage_gpu::wgpu;
use afterimage_plan::Plan;
use egui::{Color32, Pos2, Rect, RichText, ScrollArea, Sense, Stroke, Ui, Vec2};

use super::theme::{ACCENT, DIM, FIELD};
use crate::model::{Model, PipelineInstance};

/// Frames that the plot shows.
const FRAMES: usize = 240;
/// The least width of the two columns; a narrower panel is scrolled.
const MIN_WIDTH: f32 = 560.0;
/// Weight of a new time in the running means of the table.
const NEW: f64 = 0.1;

#[derive(Default)]
pub(super) struct CostPanel {
    /// Milliseconds of the last frames.
    frames: VecDeque<f64>,
    /// The number of the last frame that was taken.
    last: u64,
    /// The plan of these frames.
    plan: Weak<Plan>,
    /// Running means of the passes, in milliseconds.
    passes: Vec<f64>,
    /// Milliseconds of the viewer's own work in a frame, without the pipeline.
    own: f64,
}

impl CostPanel {
    pub(super) fn take(&mut self, model: &Model, own_ms: f64) {
        self.own += NEW * (own_ms - self.own);
        let Some(plan) = model.shown().and_then(PipelineInstance::plan) else { return };
        let times = model.shown().and_then(PipelineInstance::pass_times);
        if !std::ptr::eq(self.plan.as_ptr(), Arc::as_ptr(plan)) {
            // The times that are there are still those of the plan before.
            (self.plan, self.last) = (Arc::downgrade(plan), times.map_or(0, |times| times.frame));
            self.frames.clear();
            self.passes.clear();
        }
        let times = times.filter(|times| times.frame != self.last && times.ms.len() == plan.passes.len());
        let Some(times) = times else { return };
        self.last = times.frame;
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(times.sum());
        // What a pass draws on a processor counts as time of a later one.
        if model.gpu().is_processor() {
            return;
        }
        if self.passes.len() == times.ms.len() {
            self.passes.iter_mut().zip(&times.ms).for_each(|(mean, new)| *mean += NEW * (new - *mean));
        } else {
            self.passes.clone_from(&times.ms);
        }
    }

    /// The median of the last frames, in milliseconds.
    pub(super) fn median(&self) -> Option<f64> {
        let mut sorted: Vec<f64> = self.frames.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }

    pub(super) fn show(&self, ui: &mut Ui, model: &Model) {
        let Some(plan) = model.shown().and_then(PipelineInstance::plan).cloned() else {
            ui.label(RichText::new("Nothing runs yet.").color(DIM));
            return;
        };
        if ui.available_width() < MIN_WIDTH {
            ScrollArea::horizontal().show(ui, |ui| {
                ui.set_width(MIN_WIDTH);
                self.columns(ui, &plan, model);
            });
        } else {
            self.columns(ui, &plan, model);
        }
    }

    fn columns(&self, ui: &mut Ui, plan: &Plan, model: &Model) {
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(280.0);
                self.summary(ui, plan, model);
            });
            ui.separator();
            ScrollArea::vertical().id_salt("passes").auto_shrink([false, false]).show(ui, |ui| self.table(ui, plan));
        });
    }

    fn summary(&self, ui: &mut Ui, plan: &Plan, model: &Model) {
        match self.median() {
            Some(median) => ui.label(format!("GPU {median:.3} ms a frame, median of {}", self.frames.len())),
            None => ui.label(RichText::new(untimed(model)).color(DIM)),
        };
        self.plot(ui);
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let [transient, kept] = [plan.memory.bytes(plan.options.alias), plan.memory.kept].map(mib);
        ui.label(format!("{} passes in {} batches at {}", plan.passes.len(), plan.batches.len(), plan.size));
        let moved = mib(plan.bytes_moved());
        ui.label(format!("{transient:.1} MiB of transient images, {kept:.1} MiB kept, {moved:.1} MiB moved"));
        let own = format!("{:.2} ms of the processor for a frame of the viewer", self.own);
        ui.label(RichText::new(own).color(DIM));
        ui.label(RichText::new(model.gpu().name()).color(DIM));
        ui.label(RichText::new(lacking(model)).color(DIM).small());
    }

    fn plot(&self, ui: &mut Ui) {
        let (rect, _) = ui.allocate_exact_size(Vec2::new(270.0, 56.0), Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, FIELD);
        let most = self.frames.iter().copied().fold(1e-3, f64::max) * 1.15;
        let point = |(frame, ms): (usize, &f64)| {
            let x = rect.min.x + rect.width() * frame as f32 / (FRAMES - 1) as f32;
            Pos2::new(x, rect.max.y - rect.height() * (ms / most) as f32)
        };
        painter.line(self.frames.iter().enumerate().map(point).collect(), Stroke::new(1.2, ACCENT));
        let at = rect.left_top() + Vec2::new(4.0, 2.0);
        let text = format!("{most:.2} ms");
        painter.text(at, egui::Align2::LEFT_TOP, text, egui::FontId::proportional(9.0), Color32::from_gray(0x80));
    }

    fn table(&self, ui: &mut Ui, plan: &Plan) {
        let most = self.passes.iter().copied().fold(1e-6, f64::max);
        for (index, name) in plan.pass_names().iter().enumerate() {
            let ms = self.passes.get(index).copied();
            ui.horizontal(|ui| {
                bar(ui, ms.map_or(0.0, |ms| (ms / most) as f32));
                let text = ms.map_or("–".to_owned(), |ms| format!("{ms:.3} ms"));
                ui.add_sized([62.0, 16.0], egui::Label::new(RichText::new(text).monospace()));
                ui.add(egui::Label::new(name).truncate());
            });
        }
    }
}

/// The reason for which there is no time of a frame.
fn untimed(model: &Model) -> &'static str {
    match model.shown().is_some_and(PipelineInstance::lacks_timestamps) {
        true => "This adapter has no timestamps inside passes.",
        false => "No whole frame is timed yet: press Play or Step.",
    }
}

/// Features that plans on this device lack.
fn lacking(model: &Model) -> String {
    let is_vulkan = model.gpu().adapter.get_info().backend == wgpu::Backend::Vulkan;
    let memory = if is_vulkan { "" } else { "Plans here have no placed memory. " };
    let times = if model.gpu().is_processor() { "A processor does not time single passes." } else { "" };
    format!("{memory}{times}")
}

fn bar(ui: &mut Ui, part: f32) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(90.0, 10.0), Sense::hover());
    ui.painter().rect_filled(rect, 1.0, FIELD);
    let full = Rect::from_min_size(rect.min, Vec2::new(rect.width() * part, rect.height()));
    ui.painter().rect_filled(full, 1.0, ACCENT.gamma_multiply(0.8));
}
