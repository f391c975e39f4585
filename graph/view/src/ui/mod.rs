//! The user interface: panels around the picture. A window or a page passes events in and draws the output.

mod arrangement;
mod controls;
mod cost;
mod export;
mod exporter;
mod graph;
mod help;
mod keys;
mod leave;
pub(crate) mod new_files;
mod parameters;
mod pending;
mod picture;
mod probe;
mod save;
mod scopes;
mod tap;
mod text;
mod theme;
mod toolbar;

use afterimage_gpu::wgpu;
use egui::{CentralPanel, Panel, RichText, ScrollArea, Ui};

use crate::model::{Model, Rendered};
use crate::render::{GRID, Grid, Painter};
use cost::CostPanel;
use exporter::Exporter;
pub use exporter::{ExportKind, Exported};
use graph::GraphPanel;
use new_files::NewFile;
pub use new_files::{MakeProject, NewFiles};
use parameters::Parameters;
use pending::Pending;
pub use picture::{Comparison, PictureView, Subject};
use probe::ProbePanel;
use scopes::ScopePanel;
use text::TextPanel;

/// The tabs below the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tab {
    #[default]
    Graph,
    /// The text of the pipeline.
    Text,
    Cost,
    Messages,
    /// The parameters, in a window that is too narrow to show them next to the picture.
    Parameters,
    /// The scopes and the probe, likewise.
    Scopes,
}

/// The viewer: what is shown, and how.
pub struct Viewer {
    pub model: Model,
    /// How the picture is placed and made visible.
    pub picture: PictureView,
    /// The tab below the picture; `None` while it is closed.
    pub tab: Option<Tab>,
    /// The value of `tab` before a problem opened the messages, to go back to once it is solved.
    tab_before_problem: Option<Option<Tab>>,
    /// Whether all panels are tabs, because the window is narrow.
    is_narrow: bool,
    /// The value of `tab` in the wide window.
    tab_of_wide: Option<Tab>,
    /// Whether the last frame had a problem.
    had_problem: bool,
    /// Whether the scopes are shown.
    pub shows_scopes: bool,
    /// Whether the pixel under the pointer is read at every node.
    pub shows_probe: bool,
    /// Whether the picture is shown alone, without panels.
    pub is_bare: bool,
    shows_help: bool,
    /// What waits until the user has answered whether to save.
    pending: Option<Pending>,
    is_leaving: bool,
    new_files: NewFiles,
    /// The open question for the path of a new file.
    new_file: Option<NewFile>,
    /// Whether the panels have been shown: nothing is rendered before, so that the window appears at once.
    was_shown: bool,
    painter: Painter,
    parameters: Parameters,
    graph: GraphPanel,
    cost: CostPanel,
    text: TextPanel,
    scopes: ScopePanel,
    grid: Grid,
    probe: ProbePanel,
    exporter: Exporter,
    /// A message to the user, and when it was shown first.
    message: Option<(String, f64)>,
    /// Why the last attempt to save wrote nothing.
    save_error: Option<String>,
    /// The name of a tier that is being typed.
    tier_name: String,
}

/// Seconds for which a message is shown.
const MESSAGE_SECONDS: f64 = 6.0;

impl Viewer {
    /// A viewer that draws into targets of that format.
    pub fn new(model: Model, target: wgpu::TextureFormat, new_files: NewFiles) -> Self {
        let gpu = model.gpu().clone();
        Self {
            model,
            picture: PictureView::default(),
            tab: Some(Tab::Graph),
            tab_before_problem: None,
            is_narrow: false,
            tab_of_wide: None,
            had_problem: false,
            shows_scopes: true,
            shows_probe: false,
            is_bare: false,
            shows_help: false,
            pending: None,
            is_leaving: false,
            new_files,
            new_file: None,
            was_shown: false,
            painter: Painter::new(&gpu, target),
            parameters: Parameters::default(),
            graph: GraphPanel::default(),
            cost: CostPanel::default(),
            text: TextPanel::default(),
            scopes: ScopePanel::default(),
            grid: Grid::new(&gpu.device),
            probe: ProbePanel::default(),
            exporter: Exporter::default(),
            message: None,
            save_error: None,
            tier_name: String::new(),
        }
    }

    /// Draws into targets of another format from now on, or on another device.
    pub fn set_target(&mut self, target: wgpu::TextureFormat) {
        self.grid = Grid::new(&self.model.gpu().device);
        (self.probe, self.exporter) = (ProbePanel::default(), Exporter::default());
        self.painter = Painter::new(self.model.gpu(), target);
    }

    /// Sets the look of a context.
    pub fn style(ctx: &egui::Context) {
        theme::apply(ctx);
    }

    /// Records what the pipelines render, `elapsed` seconds after the last frame.
    pub fn render(&mut self, encoder: &mut wgpu::CommandEncoder, elapsed: f64) -> Rendered {
        if !std::mem::replace(&mut self.was_shown, true) {
            return Rendered::Later;
        }
        self.model.follow_files(self.text.typed());
        self.model.set_probes(self.shows_probe);
        let rendered = self.model.render(encoder, elapsed);
        self.update_messages_tab();
        self.record_readbacks(encoder);
        self.record_export(encoder);
        rendered
    }

    /// Opens the messages while there is a problem, unless the text is open, which shows its errors itself.
    fn update_messages_tab(&mut self) {
        let has_problem = self.model.problem().is_some();
        let had_problem = std::mem::replace(&mut self.had_problem, has_problem);
        if has_problem && !had_problem && self.tab != Some(Tab::Text) {
            self.tab_before_problem = Some(self.tab.replace(Tab::Messages));
        }
        if let Some(before) = self.tab_before_problem.take_if(|_| !has_problem)
            && self.tab == Some(Tab::Messages)
        {
            self.tab = before;
        }
    }

    /// Records the copies that the scopes and the probe read.
    fn record_readbacks(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let Some(subject) = Subject::of(&self.model) else { return };
        if self.shows_scopes || subject.is_data() {
            let device = &self.model.gpu().device;
            self.grid.record(device, &self.painter, encoder, &subject.image, subject.slice);
        }
        if let Some(place) = self.picture.probed.filter(|_| self.shows_probe) {
            self.probe.record(&self.model, encoder, place);
        }
    }

    /// Requests the copies that `render` has recorded, and shows those that have arrived; call it after the commands
    /// are submitted. `own_ms` is the CPU time of the viewer's last frame.
    pub fn after_submit(&mut self, ctx: &egui::Context, own_ms: f64) {
        self.grid.request();
        self.probe.request();
        // Mapped buffers arrive while the device is polled, and nothing waits for them.
        let _ = self.model.gpu().device.poll(wgpu::PollType::Poll);
        let is_light = Subject::of(&self.model).is_some_and(|subject| subject.is_light());
        if let Some(pixels) = self.grid.take() {
            self.scopes.set(ctx, &pixels, GRID[0] as usize, is_light);
        }
        self.cost.take(&self.model, own_ms);
        self.finish_export(ctx);
    }

    pub fn show(&mut self, ui: &mut Ui) {
        self.keys(ui.ctx());
        if !self.is_bare {
            self.panels(ui);
        }
        CentralPanel::no_frame().show(ui, |ui| {
            self.picture.show(ui, &self.painter, &self.model, self.shows_probe);
        });
        help::show(ui.ctx(), &mut self.shows_help);
        if self.model.conflict().is_some() {
            self.ask_about_conflict(ui.ctx());
        } else if self.new_file.is_some() {
            self.ask_for_new_file(ui.ctx());
        } else {
            self.ask_to_save(ui.ctx());
        }
        self.show_message(ui);
    }

    fn right_panel(&mut self, ui: &mut Ui) {
        ui.take_available_width();
        match (self.shows_scopes, self.shows_probe) {
            (true, true) => {
                let half = ui.available_height() / 2.0;
                Panel::bottom("probe").resizable(true).default_size(half).show(ui, |ui| self.show_probe(ui));
                ScrollArea::vertical().show(ui, |ui| self.scopes.show(ui));
            }
            (false, true) => self.show_probe(ui),
            _ => drop(ScrollArea::vertical().show(ui, |ui| self.scopes.show(ui))),
        }
    }

    fn show_probe(&self, ui: &mut Ui) {
        ui.take_available_height();
        let size = Subject::of(&self.model).map_or([1, 1], |subject| [subject.image.width(), subject.image.height()]);
        self.probe.show(ui, self.picture.probed, self.picture.is_pinned, size);
    }

    fn bottom_panel(&mut self, ui: &mut Ui) {
        self.apply_hidden_text();
        if let Some(tab) = self.tab {
            Panel::bottom("tabs").resizable(true).default_size(206.0).size_range(90.0..=600.0).show(ui, |ui| {
                ui.take_available_height();
                self.tabs(ui);
                ui.separator();
                self.tab_content(ui, tab);
            });
        } else {
            Panel::bottom("closed tabs").show(ui, |ui| self.tabs(ui));
        }
    }

    /// Gives the model what was typed before the text was hidden.
    fn apply_hidden_text(&mut self) {
        if self.tab != Some(Tab::Text) {
            self.text.apply(&mut self.model);
        }
    }

    fn tab_content(&mut self, ui: &mut Ui, tab: Tab) {
        match tab {
            Tab::Parameters => self.parameters.show(ui, &mut self.model),
            Tab::Scopes => self.right_panel(ui),
            Tab::Graph => self.graph.show(ui, &mut self.model),
            Tab::Text => self.show_text(ui),
            Tab::Cost => self.cost.show(ui, &self.model),
            Tab::Messages => {
                if let Some(line) = text::messages(ui, &self.model, self.save_error.as_deref()) {
                    self.text.go_to(line);
                    self.tab = Some(Tab::Text);
                }
            }
        }
    }

    /// The text, with what is wrong beside it.
    fn show_text(&mut self, ui: &mut Ui) {
        if text::has_messages(&self.model) || self.save_error.is_some() {
            let panel = match self.is_narrow {
                true => Panel::bottom("errors below the text").default_size(0.4 * ui.available_height()),
                false => Panel::right("errors of the text").default_size(440.0).size_range(200.0..=900.0),
            };
            panel.resizable(true).show(ui, |ui| {
                if let Some(line) = text::messages(ui, &self.model, self.save_error.as_deref()) {
                    self.text.go_to(line);
                }
            });
        }
        self.text.show(ui, &mut self.model);
    }

    fn tabs(&mut self, ui: &mut Ui) {
        let tabs = [("Graph", Tab::Graph), ("Text", Tab::Text), ("Cost", Tab::Cost), ("Messages", Tab::Messages)];
        let narrow = [("Parameters", Tab::Parameters), ("Scopes", Tab::Scopes)];
        let narrow = if self.is_narrow { &narrow[..] } else { &[] };
        ui.horizontal(|ui| {
            for (name, tab) in narrow.iter().copied().chain(tabs) {
                let is_wrong = tab == Tab::Messages && (self.model.problem().is_some() || self.save_error.is_some());
                let text = RichText::new(name);
                let text = if is_wrong { text.color(theme::ERROR) } else { text };
                if ui.selectable_label(self.tab == Some(tab), text).clicked() {
                    self.tab = if self.tab == Some(tab) { None } else { Some(tab) };
                }
            }
            if self.model.problem().is_some() && Subject::of(&self.model).is_some() {
                let text = "The last good picture is shown.";
                ui.label(RichText::new(text).color(theme::ERROR).small());
            }
            if let Some(median) = self.cost.median().filter(|_| !self.is_narrow) {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(format!("{median:.2} ms")).color(theme::DIM));
                });
            }
        });
    }

    /// Shows a message for a few seconds.
    pub fn tell(&mut self, ctx: &egui::Context, text: impl Into<String>) {
        self.message = Some((text.into(), ctx.input(|input| input.time)));
    }

    fn show_message(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        self.message.take_if(|(_, since)| now - *since > MESSAGE_SECONDS);
        let Some((text, _)) = &self.message else { return };
        let anchor = egui::Align2::CENTER_BOTTOM;
        egui::Area::new("message".into()).anchor(anchor, [0.0, -280.0]).show(ui.ctx(), |ui| {
            ui.set_max_width((ui.ctx().content_rect().width() - 48.0).max(120.0));
            egui::Frame::popup(ui.style()).show(ui, |ui| match text.contains('\n') {
                // Excerpts of a text are aligned by their letters.
                true => ui.monospace(text),
                false => ui.label(text),
            });
        });
    }
}
