//! The user interface: panels around the picture. A window or a page passes events in and draws the output.

mod arrangement;
mod completion;
mod controls;
mod cost;
mod curves;
mod entry;
mod export;
mod fault_search;
mod graph;
mod help;
mod inputs;
mod keys;
mod list_keys;
mod measurement;
mod message;
mod missing_image;
pub(crate) mod new_file;
mod parameters;
mod picture;
mod pixel_inspector;
mod proposals;
mod recent;
mod save_dialogs;
mod scopes;
mod selection;
mod tabs;
mod text;
mod text_colors;
mod text_find;
mod text_place;
mod theme;
mod toolbar;
mod white_picker;
mod wire_bar;

use std::path::PathBuf;

use afterimage_gpu::wgpu;
use egui::{CentralPanel, Context, Panel, RichText, ScrollArea, Ui};

use crate::model::{InputFile, Model, Project, Rendered};
use crate::render::Painter;
use cost::CostPanel;
use export::Exporter;
pub use export::{ExportKind, Exported};
use fault_search::FaultSearch;
use graph::GraphPanel;
use inputs::{InputPanel, Told, give};
use measurement::Measurement;
pub use measurement::{MeasureDifference, MeasuredPicture};
use message::Message;
pub use new_file::{FileRequest, MakeProject, NewFiles};
use parameters::Parameters;
pub use picture::{Comparison, PictureView, Subject};
use pixel_inspector::PixelInspector;
pub use recent::RecentFiles;
use recent::RecentMenu;
use save_dialogs::{Pending, SaveDialogs};
use scopes::ScopePanel;
pub use tabs::{Tab, Tabs};
use text::TextPanel;
use white_picker::WhitePicker;

/// The viewer: a model and the panels that show it.
pub struct Viewer {
    pub model: Model,
    /// Placement and appearance of the picture.
    pub picture: PictureView,
    pub tabs: Tabs,
    pub shows_scopes: bool,
    /// The values of the pixel under the pointer are shown for every node.
    pub inspects_pixels: bool,
    /// The picture is shown alone, without panels.
    pub is_bare: bool,
    shows_help: bool,
    /// The panels have been shown: nothing is rendered before, so that the window appears at once.
    was_shown: bool,
    painter: Painter,
    parameters: Parameters,
    inputs: InputPanel,
    graph: GraphPanel,
    cost: CostPanel,
    text: TextPanel,
    scopes: ScopePanel,
    pixel_inspector: PixelInspector,
    fault_search: FaultSearch,
    white_picker: WhitePicker,
    /// The shown image is another one than the scopes have sampled.
    is_sample_due: bool,
    /// A file that the user wants to choose.
    file_request: Option<FileRequest>,
    exporter: Exporter,
    measurement: Measurement,
    save_dialogs: SaveDialogs,
    recent: RecentMenu,
    message: Message,
}

impl Viewer {
    /// A viewer that draws into targets of that format.
    pub fn new(model: Model, target: wgpu::TextureFormat, new_files: NewFiles) -> Self {
        let gpu = model.gpu().clone();
        Self {
            model,
            picture: PictureView::default(),
            tabs: Tabs::default(),
            shows_scopes: true,
            inspects_pixels: false,
            is_bare: false,
            shows_help: false,
            was_shown: false,
            painter: Painter::new(&gpu, target),
            parameters: Parameters::default(),
            inputs: InputPanel::default(),
            graph: GraphPanel::default(),
            cost: CostPanel::default(),
            text: TextPanel::default(),
            scopes: ScopePanel::new(&gpu.device),
            pixel_inspector: PixelInspector::default(),
            fault_search: FaultSearch::new(&gpu.device),
            white_picker: WhitePicker::default(),
            is_sample_due: true,
            file_request: None,
            exporter: Exporter::default(),
            measurement: Measurement::default(),
            save_dialogs: SaveDialogs::new(new_files),
            recent: RecentMenu::default(),
            message: Message::default(),
        }
    }

    /// Lets comparisons be measured.
    pub fn measure_by(&mut self, measure: MeasureDifference) {
        self.measurement.measure = Some(measure);
    }

    /// Lists the pipelines that were opened last.
    pub fn list_recent_by(&mut self, files: RecentFiles) {
        self.recent.files = Some(files);
    }

    /// Draws into targets of another format from now on, or on another device.
    pub fn set_target(&mut self, target: wgpu::TextureFormat) {
        self.scopes.rebuild(&self.model.gpu().device);
        self.is_sample_due = true;
        (self.pixel_inspector, self.exporter) = (PixelInspector::default(), Exporter::default());
        (self.fault_search, self.white_picker) = (FaultSearch::new(&self.model.gpu().device), WhitePicker::default());
        self.painter = Painter::new(self.model.gpu(), target);
    }

    /// Sets the look of a context.
    pub fn style(ctx: &Context) {
        theme::apply(ctx);
    }

    /// Records what the pipelines render, `elapsed` seconds after the last frame.
    pub fn render(&mut self, encoder: &mut wgpu::CommandEncoder, elapsed: f64) -> Rendered {
        if !std::mem::replace(&mut self.was_shown, true) {
            return Rendered::Later;
        }
        self.model.follow_files(self.text.typed());
        let is_white_chosen = self.picture.picks.is_some() || self.white_picker.is_reading();
        self.model.inspect_pixels(self.inspects_pixels || is_white_chosen);
        self.model.show_wires(self.shows_thumbnails());
        let rendered = self.model.render(encoder, elapsed);
        self.tabs.follow_problem(self.model.problem().is_some());
        if rendered == Rendered::New {
            self.is_sample_due = true;
            self.fault_search.begin();
        }
        self.record_readbacks(encoder);
        self.exporter.record(encoder, &self.model, &self.picture);
        self.measurement.record(encoder, &self.model);
        rendered
    }

    /// Records the copies for the scopes, the pixel inspector, the white picker and the search for faults.
    fn record_readbacks(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.white_picker.record(&self.model, encoder);
        self.fault_search.record(&self.model, &self.painter, encoder);
        let Some(subject) = Subject::of(&self.model) else { return self.scopes.forget() };
        if self.is_sample_due {
            let is_sampled = self.scopes.record(&self.model.gpu().device, &self.painter, encoder, &subject);
            self.is_sample_due = !is_sampled;
        }
        if let Some(place) = self.picture.inspected_place.filter(|_| self.inspects_pixels) {
            self.pixel_inspector.record(&self.model, encoder, place);
        }
    }

    /// Requests the copies that `render` has recorded, and shows those that have arrived; call it after the commands
    /// are submitted. `own_ms` is the CPU time of the viewer's last frame.
    pub fn after_submit(&mut self, ctx: &Context, own_ms: f64) {
        self.scopes.request();
        self.pixel_inspector.request();
        // Mapped buffers arrive while the device is polled, and nothing waits for them.
        let _ = self.model.gpu().device.poll(wgpu::PollType::Poll);
        let is_linear = Subject::of(&self.model).is_some_and(|subject| subject.is_linear_color());
        self.scopes.take(ctx, is_linear);
        self.fault_search.take();
        if let Some(message) = self.white_picker.finish(&mut self.model) {
            self.tell(ctx, message);
        }
        self.cost.take(&self.model, own_ms);
        if let Err(why) = self.exporter.finish() {
            self.tell(ctx, format!("Nothing is exported: {why}"));
        }
        self.measurement.finish(ctx);
        if self.exporter.is_pending() {
            ctx.request_repaint();
        }
    }

    pub fn show(&mut self, ui: &mut Ui) {
        self.keys(ui.ctx());
        self.inputs.forget_place();
        self.recent.follow(&self.model);
        if !self.is_bare {
            self.panels(ui);
        }
        self.picture.figures = self.measurement.figures(&self.model);
        CentralPanel::no_frame().show(ui, |ui| {
            self.picture.show(ui, &self.painter, &self.model, self.inspects_pixels);
        });
        self.white_picker.take_click(&mut self.picture);
        self.show_graph_menu(ui.ctx());
        help::show(ui.ctx(), &mut self.shows_help);
        if let Some(message) = self.save_dialogs.show(ui.ctx(), &mut self.model) {
            self.tell(ui.ctx(), message);
        }
        let dropped = self.inputs.give_dropped(ui.ctx(), &mut self.model);
        let told = self.inputs.ask(ui.ctx(), &mut self.model).or(dropped);
        told.into_iter().for_each(|told| self.tell_of_input(ui.ctx(), told));
        self.message.show(ui);
    }

    /// Shows a message for a few seconds.
    pub fn tell(&mut self, ctx: &Context, text: impl Into<String>) {
        self.message.set(ctx, text.into());
    }
}

impl Viewer {
    /// Closes the window, or asks first if changes would be lost.
    pub fn close(&mut self) {
        self.request(Pending::Close);
    }

    /// Opens another pipeline, or asks first if changes would be lost.
    pub fn open(&mut self, project: Box<dyn Project>) {
        self.request(Pending::Open(project));
    }

    /// Shows a file as an input. Without a name, that of the file tells the input, or the user is asked.
    pub fn open_input(&mut self, ctx: &Context, file: InputFile, input: Option<&str>) {
        let told = match input {
            Some(input) => Some(give(&mut self.model, file, Some(input))),
            None => self.inputs.give_to_one(&mut self.model, file, false),
        };
        told.into_iter().for_each(|told| self.tell_of_input(ctx, told));
    }

    /// Shows a file as the input on which it was dropped, once the place of the drop is known.
    pub fn drop_input(&mut self, ctx: &Context, file: InputFile) {
        self.inputs.drop_file(ctx, file);
    }

    fn tell_of_input(&mut self, ctx: &Context, told: Told) {
        match told {
            // The picture alone shows that it is there.
            Ok(_) if self.is_bare => {}
            Ok(message) | Err(message) => self.tell(ctx, message),
        }
    }

    /// The path that the user has named for an input, or that of a pipeline, for the shell to open.
    pub fn take_named_file(&mut self) -> Option<(Option<String>, PathBuf)> {
        let of_input = self.inputs.named.take().map(|(input, path)| (Some(input), path));
        of_input.or_else(|| Some((None, self.recent.chosen.take()?)))
    }

    /// A file that the user wants to choose, for the shell to ask.
    pub fn take_file_request(&mut self) -> Option<FileRequest> {
        self.file_request.take().or_else(|| self.inputs.asked_file.take())
    }

    /// True while the user is asked something.
    fn asks(&self) -> bool {
        self.model.editor().conflict().is_some() || self.save_dialogs.asks() || self.inputs.asks()
    }

    fn request(&mut self, pending: Pending) {
        self.text.apply(&mut self.model);
        self.save_dialogs.request(&mut self.model, pending);
    }

    /// True once the window is to be closed.
    pub fn is_closing(&self) -> bool {
        self.save_dialogs.is_closing()
    }

    /// The names of the inspected values, in the order in which they are shown.
    pub fn pixel_names(&self) -> Vec<&str> {
        self.pixel_inspector.names()
    }

    /// True if the text or a value differs from the file.
    pub fn is_unsaved(&self) -> bool {
        let editor = self.model.editor();
        !editor.is_saved() || self.text.typed().is_some_and(|typed| typed != editor.text())
    }

    /// The title of the window: the pipeline, whether it is unsaved, and the image with its size and frame.
    pub fn title(&self) -> String {
        let mark = if self.is_unsaved() { " *" } else { "" };
        let (name, shown) = (self.model.editor().project().name(), self.model.images().title());
        format!("{name}{mark} – {shown} – Afterimage")
    }

    /// Writes the changes into the file.
    fn save(&mut self, ctx: &Context) {
        self.text.apply(&mut self.model);
        if let Some(message) = self.save_dialogs.save(&mut self.model, None) {
            self.tell(ctx, message);
        }
    }

    /// Writes the text with the changes into a new file.
    fn save_as(&mut self, ctx: &Context) {
        self.text.apply(&mut self.model);
        if let Some(message) = self.save_dialogs.save_as(&mut self.model, None) {
            self.tell(ctx, message);
        }
    }

    /// Makes a file of what is seen in one of the next frames: see [`take_export`](Self::take_export).
    pub fn export(&mut self, kind: ExportKind) {
        self.exporter.requested = Some(kind);
    }

    /// Makes a file of the text with the changed values in it: see [`take_export`](Self::take_export).
    pub fn export_pipeline(&mut self) {
        self.text.apply(&mut self.model);
        let editor = self.model.editor();
        let (name, bytes) = (editor.project().name(), editor.text_with_changes().into_bytes());
        self.exporter.finished = Some(Exported { name, bytes });
    }

    /// A file that is finished, for the shell to store.
    pub fn take_export(&mut self) -> Option<Exported> {
        self.exporter.finished.take()
    }
}

impl Viewer {
    fn right_panel(&mut self, ui: &mut Ui) {
        ui.take_available_width();
        match (self.shows_scopes, self.inspects_pixels) {
            (true, true) => {
                let half = ui.available_height() / 2.0;
                let panel = Panel::bottom("pixel inspector").resizable(true).default_size(half);
                panel.show(ui, |ui| self.show_pixel_inspector(ui));
                ScrollArea::vertical().show(ui, |ui| self.scopes.show(ui));
            }
            (false, true) => self.show_pixel_inspector(ui),
            _ => drop(ScrollArea::vertical().show(ui, |ui| self.scopes.show(ui))),
        }
    }

    fn show_pixel_inspector(&self, ui: &mut Ui) {
        ui.take_available_height();
        let size = Subject::of(&self.model).map_or([1, 1], |subject| [subject.image.width(), subject.image.height()]);
        self.pixel_inspector.show(ui, self.picture.inspected_place, self.picture.is_pinned, size);
    }

    fn bottom_panel(&mut self, ui: &mut Ui) {
        self.apply_hidden_text();
        if let Some(tab) = self.tabs.open {
            // Pictures in the boxes of the graph need more room than names.
            let (name, height) = match self.shows_thumbnails() {
                true => ("tabs with thumbnails", 330.0),
                false => ("tabs", 206.0),
            };
            Panel::bottom(name).resizable(true).default_size(height).size_range(90.0..=600.0).show(ui, |ui| {
                ui.take_available_height();
                self.tab_bar(ui);
                ui.separator();
                self.tab_content(ui, tab);
            });
        } else {
            Panel::bottom("closed tabs").show(ui, |ui| self.tab_bar(ui));
        }
    }

    /// Gives the model what was typed before the text was hidden.
    fn apply_hidden_text(&mut self) {
        if self.tabs.open != Some(Tab::Text) {
            self.text.apply(&mut self.model);
        }
    }

    /// A press in a panel takes the focus from the picture.
    fn take_focus_by_press(&mut self, ui: &Ui) {
        let is_pressed = ui.input(|input| input.pointer.any_pressed());
        if is_pressed && !self.asks() && ui.rect_contains_pointer(ui.max_rect()) {
            self.picture.has_focus = false;
        }
    }

    fn show_parameters(&mut self, ui: &mut Ui) {
        self.take_focus_by_press(ui);
        let has_paths = self.save_dialogs.has_paths();
        let selected = self.graph.selected();
        let chosen = self.parameters.show(ui, &mut self.model, selected, |ui, model| {
            self.inputs.show(ui, model, has_paths);
        });
        if chosen.is_some() {
            self.graph.select(chosen);
            self.follow_selection();
        }
        if let Some(node) = self.parameters.balanced.take() {
            self.picture.picks = Some(node);
        }
    }

    fn tab_content(&mut self, ui: &mut Ui, tab: Tab) {
        self.take_focus_by_press(ui);
        match tab {
            Tab::Parameters => self.show_parameters(ui),
            Tab::Scopes => self.right_panel(ui),
            Tab::Graph => self.show_graph(ui),
            Tab::Text => self.show_text(ui),
            Tab::Cost => self.cost.show(ui, &self.model),
            Tab::Messages => {
                if let Some(line) =
                    text::messages(ui, &self.model, &self.other_problems(), &self.fault_search.statement())
                {
                    self.text.go_to(line);
                    self.tabs.open = Some(Tab::Text);
                }
            }
        }
    }

    /// The text, with the messages and the manual beside it.
    fn show_text(&mut self, ui: &mut Ui) {
        let others = self.other_problems();
        let has_messages = text::has_messages(&self.model) || !others.is_empty();
        let panel = match self.tabs.is_narrow() {
            true => Panel::bottom("errors below the text").default_size(0.4 * ui.available_height()),
            false => Panel::right("errors of the text").default_size(440.0).size_range(200.0..=900.0),
        };
        let mut line = None;
        let mut messages = |ui: &mut Ui| {
            line = text::messages(ui, &self.model, &others, &self.fault_search.statement());
        };
        match (has_messages, self.tabs.is_narrow()) {
            (true, true) => drop(panel.resizable(true).show(ui, messages)),
            (true, false) => {
                panel.resizable(true).show(ui, |ui| {
                    let half = 0.5 * ui.available_height();
                    let below = Panel::bottom("manual below errors").resizable(true).default_size(half);
                    below.show(ui, |ui| self.text.docs(ui));
                    messages(ui);
                });
            }
            (false, true) => {}
            (false, false) => drop(panel.resizable(true).show(ui, |ui| self.text.docs(ui))),
        }
        if let Some(line) = line {
            self.text.go_to(line);
        }
        self.text.show(ui, &mut self.model, self.graph.selected());
    }

    /// The error of the last attempt to save, and the images with NaN or infinities: the shown one, and all that were
    /// searched.
    fn other_problems(&self) -> Vec<String> {
        let told = |image: &str, count: u64| format!("{image} has {count} pixels with NaN or infinities");
        let shown = Some(self.scopes.faults())
            .filter(|count| *count > 0)
            .map(|count| told(self.model.inspector().wire().map_or("the picture", |wire| &*wire.wire), count));
        let elsewhere = self.fault_search.found().map(|(image, count)| told(image, count));
        let mut problems: Vec<String> =
            self.save_dialogs.error().map(str::to_owned).into_iter().chain(shown).chain(elsewhere).collect();
        // The shown image is among the others.
        problems.dedup();
        problems
    }

    fn tab_bar(&mut self, ui: &mut Ui) {
        let has_problem = self.model.problem().is_some();
        ui.horizontal(|ui| {
            self.tabs.show(ui, has_problem || !self.other_problems().is_empty());
            if !self.tabs.is_narrow() && matches!(self.tabs.open, Some(Tab::Graph | Tab::Text)) {
                self.add_button(ui);
            }
            if self.tabs.open == Some(Tab::Graph) && !self.tabs.is_narrow() {
                self.thumbnails_button(ui);
            }
            if has_problem && Subject::of(&self.model).is_some() {
                let text = "The last good picture is shown.";
                ui.label(RichText::new(text).color(theme::ERROR).small());
            }
            if let Some(median) = self.cost.median().filter(|_| !self.tabs.is_narrow()) {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(format!("{median:.2} ms")).color(theme::DIM));
                });
            }
        });
    }
}
