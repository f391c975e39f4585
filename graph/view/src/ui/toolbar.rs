//! The bars above and below the picture: pipeline, comparison, appearance, and time.

use afterimage_media::ImageFormat;
use egui::{Button, ComboBox, RichText, Ui};

use super::export::{self, ExportChoice};
use super::list_keys::choose_by_keys;
use super::measurement::Measurement;
use super::picture::{Comparison, PictureView, Subject};
use super::theme::{ACCENT, DIM};
use super::{FileRequest, Viewer};
use crate::model::{CompareWith, Editor, Model, Slot, TextProject};

/// The length of the time bar where no sequence of images has one.
const TIME_BAR_SECONDS: f64 = 40.0;
/// The least width of a bar of the time in one row, if there is room for two.
pub(super) const MIN_TIME_BAR: f32 = 620.0;
/// The width of the time and the number of the frame beside the slider.
const TIME_LABEL: f32 = 250.0;

impl Viewer {
    pub(super) fn top_bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            self.pipeline_menu(ui);
            tier_menu(ui, &mut self.model);
            ui.separator();
            self.history_buttons(ui);
            self.save_button(ui);
            self.save_as_tier_button(ui);
            self.export_menu(ui);
            ui.separator();
            compare_menu(ui, &mut self.model, &mut self.picture, &mut self.measurement);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                self.help_button(ui);
                ui.toggle_value(&mut self.shows_scopes, "Scopes").on_hover_text("S");
                ui.toggle_value(&mut self.inspects_pixels, "Probe").on_hover_text("P: the pixel at every node");
            });
        });
    }

    /// The same in two rows for a narrow window, where scopes are a tab.
    pub(super) fn narrow_bars(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            self.pipeline_menu(ui);
            tier_menu(ui, &mut self.model);
            self.history_buttons(ui);
            self.save_button(ui);
        });
        ui.horizontal_wrapped(|ui| {
            self.save_as_tier_button(ui);
            self.export_menu(ui);
            compare_menu(ui, &mut self.model, &mut self.picture, &mut self.measurement);
            ui.toggle_value(&mut self.inspects_pixels, "Probe").on_hover_text("P: the pixel at every node");
            self.help_button(ui);
        });
    }

    fn history_buttons(&mut self, ui: &mut Ui) {
        let can_undo = self.model.editor().changes().can_undo() || self.text.typed().is_some();
        if ui.add_enabled(can_undo, Button::new("Undo")).on_hover_text("Ctrl+Z").clicked() {
            self.undo();
        }
        let can_redo = self.model.editor().changes().can_redo();
        if ui.add_enabled(can_redo, Button::new("Redo")).on_hover_text("Ctrl+Shift+Z").clicked() {
            self.redo();
        }
    }

    fn help_button(&mut self, ui: &mut Ui) {
        if ui.button("Help").on_hover_text("F1").clicked() {
            self.shows_help = !self.shows_help;
        }
    }

    fn pipeline_menu(&mut self, ui: &mut Ui) {
        let mut name = self.model.editor().project().name();
        if self.is_unsaved() {
            name += " *";
        }
        name += " ▾";
        let (mut chosen, mut opens, mut saves) = (None, false, false);
        let has_paths = self.save_dialogs.has_paths();
        ui.menu_button(RichText::new(name).strong(), |ui| {
            if has_paths {
                opens = ui.button("Open…").on_hover_text("Choose the file of a pipeline").clicked();
                saves = ui.button("Save as…").on_hover_text("Ctrl+Shift+S: a new file").clicked();
                ui.separator();
            }
            self.recent.show(ui);
            ui.label(RichText::new("Built-in pipelines").color(DIM).small());
            let entries: Vec<_> =
                afterimage_pipelines::PIPELINES.iter().map(|(name, _)| (ui.button(*name), *name)).collect();
            chosen = choose_by_keys(ui, &entries, 0).map(|index| entries[index].1);
            ui.separator();
            ui.label(RichText::new("Drop a .ron file to open it,\nor an image to see it.").color(DIM))
                .on_hover_text(ImageFormat::readable_names());
        });
        if opens {
            self.file_request = Some(FileRequest::Pipeline);
        }
        if saves {
            self.save_as(ui.ctx());
        }
        if let Some(project) = chosen.and_then(TextProject::built_in) {
            self.open(Box::new(project));
        }
    }

    fn save_button(&mut self, ui: &mut Ui) {
        if ui.add_enabled(self.is_unsaved(), Button::new("Save")).on_hover_text(SAVE).clicked() {
            self.save(ui.ctx());
        }
    }

    fn save_as_tier_button(&mut self, ui: &mut Ui) {
        if ui.add_enabled(self.is_unsaved(), Button::new("Save as tier")).clicked() {
            self.text.apply(&mut self.model);
            self.save_dialogs.ask_for_tier();
        }
    }

    fn export_menu(&mut self, ui: &mut Ui) {
        match export::menu(ui, Subject::of(&self.model).is_some()) {
            Some(ExportChoice::Image(kind)) => self.export(kind),
            Some(ExportChoice::Pipeline) => self.export_pipeline(),
            None => {}
        }
    }
}

fn tier_menu(ui: &mut Ui, model: &mut Model) {
    let Some(checked) = model.editor().checked().filter(|checked| !checked.tiers.is_empty()) else { return };
    let mut tier = model.editor().tier().map(str::to_owned);
    let shown = tier.clone().unwrap_or_else(|| "no tier".into());
    ComboBox::from_id_salt("tier").selected_text(shown).width(82.0).show_ui(ui, |ui| {
        let present = checked.tiers.iter().position(|name| Some(name) == tier.as_ref()).map_or(0, |index| index + 1);
        let mut entries = vec![(ui.selectable_value(&mut tier, None, "no tier"), "no tier")];
        for name in &checked.tiers {
            let entry = ui.selectable_value(&mut tier, Some(name.clone()), name);
            let claim = checked.claims.iter().find(|(of, _)| of == name);
            entries.push((claim.map_or(entry.clone(), |(_, claim)| entry.on_hover_text(claim.to_string())), name));
        }
        choose_by_keys(ui, &entries, present);
    });
    model.set_tier(tier);
}

fn compare_menu(ui: &mut Ui, model: &mut Model, picture: &mut PictureView, measurement: &mut Measurement) {
    let present = model.compared().cloned();
    let mut chosen = present.clone();
    let shown = present.as_ref().map_or("compare with…".into(), CompareWith::name);
    ComboBox::from_id_salt("compare with").selected_text(shown).width(130.0).height(420.0).show_ui(ui, |ui| {
        let others = comparable(model.editor());
        let names: Vec<String> = others.iter().map(CompareWith::name).collect();
        let place = others.iter().position(|other| Some(other) == present.as_ref()).map_or(0, |index| index + 1);
        let mut entries = vec![(ui.selectable_value(&mut chosen, None, "nothing"), "nothing")];
        for (compared, name) in others.into_iter().zip(&names) {
            entries.push((ui.selectable_value(&mut chosen, Some(compared), name), name));
        }
        choose_by_keys(ui, &entries, place);
    });
    if chosen != present {
        model.set_compared(chosen);
    }
    if model.compared().is_some() {
        let modes = [
            ("Wipe", Comparison::Wipe),
            ("Side by side", Comparison::SideBySide),
            ("Difference", Comparison::Difference),
        ];
        // An intermediate image is shown alone.
        let is_compared = model.inspector().wire().is_none();
        for (name, mode) in modes {
            let label = Button::selectable(is_compared && picture.comparison == mode, name);
            let button = ui.add_enabled(is_compared, label);
            if button.on_disabled_hover_text("Esc goes back to the result, which is compared").clicked() {
                picture.comparison = mode;
            }
        }
        measurement.button(ui);
    }
}

fn comparable(editor: &Editor) -> Vec<CompareWith> {
    let own = editor.project().name();
    let others = afterimage_pipelines::PIPELINES.iter().map(|(name, _)| (*name).to_owned());
    let others = others.filter(|name| own != format!("{name}.ron")).map(CompareWith::Pipeline);
    let tiers = editor.tiers().iter().map(|tier| CompareWith::Tier(Some(tier.clone())));
    let snapshots = Slot::ALL.into_iter().filter(|slot| editor.snapshot(*slot).is_some()).map(CompareWith::Snapshot);
    let first = std::iter::once(CompareWith::Written).chain(snapshots).chain([CompareWith::Reference]);
    first.chain(tiers).chain(others).collect()
}

/// The bar below the picture.
pub(super) fn picture_bar(ui: &mut Ui, view: &mut PictureView) {
    if ui.selectable_label(view.zoom.is_none(), "Fit").on_hover_text("F, or a double click").clicked() {
        view.zoom = None;
    }
    if ui.selectable_label(view.zoom == Some(1.0), "1:1").on_hover_text("1").clicked() {
        view.zoom = Some(1.0);
    }
    ui.toggle_value(&mut view.smooth, "Smooth").on_hover_text("Filtered when it is made smaller");
    ui.separator();
    let mut channel = view.channel;
    for (index, name) in ["R", "G", "B", "A", "RGB"].into_iter().enumerate() {
        ui.selectable_value(&mut channel, index as u32, name);
    }
    view.channel = channel;
    ui.add(egui::DragValue::new(&mut view.stops).speed(0.02).range(-16.0..=16.0).suffix(" stops"))
        .on_hover_text("Makes the picture brighter to look at, and nothing else. Double-click to type a number.");
    ui.separator();
    ui.toggle_value(&mut view.false_color, "False color").on_hover_text("Stops from middle gray as colors");
    ui.toggle_value(&mut view.clipping, "Clipping").on_hover_text("Red: a channel at white. Blue: black.");
    ui.toggle_value(&mut view.faults, "Faults")
        .on_hover_text("Stripes: magenta for NaN, yellow for infinite, cyan for negative numbers");
    if let Some(headroom) = view.headroom {
        ui.separator();
        let text = format!("The screen shows light up to {headroom:.1} times SDR white");
        ui.toggle_value(&mut view.is_sdr, "As SDR").on_hover_text(text);
    }
}

/// The bar of the time, in one row or in two.
pub(super) fn time_bar(ui: &mut Ui, model: &mut Model, is_split: bool) {
    if is_split {
        ui.horizontal(|ui| time_buttons(ui, model));
        ui.horizontal(|ui| time_slider(ui, model));
    } else {
        ui.horizontal(|ui| {
            time_buttons(ui, model);
            time_slider(ui, model);
        });
    }
}

fn time_buttons(ui: &mut Ui, model: &mut Model) {
    let clock = model.clock();
    let text = if clock.is_playing { "Pause" } else { "Play" };
    if ui.add_sized([48.0, 20.0], Button::new(text)).on_hover_text("Space").clicked() {
        clock.is_playing = !clock.is_playing;
    }
    if ui.button("Step").on_hover_text(". : one frame").clicked() {
        clock.step();
    }
    if ui.button("Cut").on_hover_text("C: histories and adaptation start again").clicked() {
        clock.cut();
    }
    for (index, (name, hint)) in POINTS.into_iter().enumerate() {
        let is_set = clock.points()[index].is_some();
        if ui.add(Button::selectable(is_set, name)).on_hover_text(hint).clicked() {
            clock.mark(index);
        }
    }
    ui.toggle_value(&mut clock.is_looping, "Loop").on_hover_text("Play again from the beginning of the part");
}

fn time_slider(ui: &mut Ui, model: &mut Model) {
    let (length, frame) = (model.images_length(), model.frame_number());
    let clock = model.clock();
    let mut time = clock.time;
    let seconds = length.map_or(TIME_BAR_SECONDS, |(frames, fps)| (frames as f64 - 1.0) / fps);
    ui.spacing_mut().slider_width = (ui.available_width() - TIME_LABEL).max(80.0);
    let mut shown = time.rem_euclid(seconds.max(1e-3));
    let slider = ui.add(egui::Slider::new(&mut shown, 0.0..=seconds).show_value(false));
    if slider.changed() {
        time = shown;
        clock.seek(time);
    }
    mark_points(ui, slider.rect, clock.points().map(|point| point.map(|point| (point / seconds) as f32)));
    ui.label(RichText::new(format!("{:7.2} s  frame {frame}", clock.time)).monospace());
    if clock.is_cut_shown() {
        ui.label(RichText::new("without history").color(ACCENT).small())
            .on_hover_text("The time was set: adaptation and other histories begin with this frame.");
    }
}

/// Marks the ends of the part that is played, as parts of the bar.
fn mark_points(ui: &Ui, bar: egui::Rect, points: [Option<f32>; 2]) {
    // A slider's handle stays within its bar.
    let bar = bar.shrink2(egui::vec2(bar.height() / 2.5, 0.0));
    for point in points.into_iter().flatten().filter(|point| (0.0..=1.0).contains(point)) {
        let x = egui::lerp(bar.x_range(), point);
        ui.painter().vline(x, bar.y_range(), egui::Stroke::new(2.0, ACCENT));
    }
}

const POINTS: [(&str, &str); 2] = [
    ("In", "I: the part that is played begins here; again: it begins where the sequence does"),
    ("Out", "O: it ends here; again: it ends where the sequence does"),
];
const SAVE: &str = "Ctrl+S: writes the text, and the changed values into it; everything else stays as it is";
