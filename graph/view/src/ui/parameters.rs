//! The panel of parameters: one group for each node, one row for each parameter.

use afterimage_graph::check::{Fact, FactKind, Graph, GraphNode, ParameterId};
use afterimage_graph::value::{Param, Value};
use egui::{RichText, ScrollArea, Ui};

use super::controls::{ControlChange, control};
use super::curves::{PointChange, curves, plot};
use super::graph::wire_name;
use super::text::note_errors;
use super::theme::{ACCENT, DIM};
use crate::model::{Model, Target, balances_white};

#[derive(Default)]
pub(super) struct Parameters {
    search: String,
    /// Only changed parameters are shown.
    only_changed: bool,
    /// The node to which the panel goes.
    goal: Option<String>,
    /// The node for which the user wants to choose what is gray.
    pub(super) balanced: Option<String>,
}

/// An action of the user in the panel.
enum PanelAction {
    Set(Target, Option<Value>),
    Release,
    /// A node is selected.
    Select(String),
    /// A color that a node makes gray is to be chosen in the picture.
    Balance(String),
}

impl Parameters {
    /// Goes to the parameters of a node, and opens them.
    pub(super) fn reveal(&mut self, node: String) {
        self.goal = Some(node);
    }

    /// Shows the panel, with the group of inputs, and applies what the user changes. `selected` is the node that is
    /// pointed out. Returns the node that the user selects.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        model: &mut Model,
        selected: Option<&str>,
        inputs: impl FnOnce(&mut Ui, &mut Model),
    ) -> Option<String> {
        ui.horizontal(|ui| {
            let search =
                egui::TextEdit::singleline(&mut self.search).hint_text("Find a parameter").desired_width(168.0);
            ui.add(search).labelled_by(ui.id());
            let text = format!("Changed {}", model.editor().changes().len());
            ui.toggle_value(&mut self.only_changed, text).on_hover_text("Show only what differs from the file");
        });
        ui.separator();
        let Some(graph) = model.editor().graph().cloned() else {
            ui.label(RichText::new("The pipeline has errors: see Messages.").color(DIM));
            return None;
        };
        let mut chosen = None;
        note_errors(ui, model);
        // Rows that are wider than the panel are scrolled: they do not widen it, which would move the picture.
        ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            inputs(ui, model);
            facts(ui, model, &graph);
            let mut actions = Vec::new();
            self.usual(ui, model, &graph, &mut actions);
            for index in 0..graph.nodes.len() {
                self.node(ui, model, (&graph, index), selected, &mut actions);
            }
            self.goal = None;
            if self.is_empty(model, &graph) {
                ui.label(RichText::new("No parameter, description or kind contains this.").color(DIM));
            }
            for action in actions {
                match action {
                    PanelAction::Set(target, value) => model.set(&target, value),
                    PanelAction::Release => model.release(),
                    PanelAction::Select(node) => chosen = Some(node),
                    PanelAction::Balance(node) => self.balanced = Some(node),
                }
            }
        });
        chosen
    }

    fn is_empty(&self, model: &Model, graph: &Graph) -> bool {
        !(0..graph.nodes.len()).any(|node| self.rows(model, graph, node).next().is_some())
    }

    /// The parameters of a node that are shown.
    fn rows<'r>(&'r self, model: &'r Model, graph: &'r Graph, node: usize) -> impl Iterator<Item = ParameterId> + 'r {
        let count = graph.nodes[node].kind().params().len();
        let search = self.search.to_lowercase();
        let is_shown = move |parameter: &ParameterId| {
            let name = graph.parameter_name(*parameter);
            let is_changed = model.editor().changes().get(&Target::Parameter(name.clone())).is_some();
            let text = searched(graph, *parameter);
            search.split_whitespace().all(|word| text.contains(word)) && (is_changed || !self.only_changed)
        };
        (0..count).map(move |index| ParameterId { node, index }).filter(is_shown)
    }

    /// The parameters that the pipeline declares as usual, above the rest.
    fn usual(&self, ui: &mut Ui, model: &Model, graph: &Graph, actions: &mut Vec<PanelAction>) {
        let Some(checked) = model.editor().checked().filter(|_| !self.is_searched()) else { return };
        let found = checked.usual.iter().filter_map(|(name, meaning)| Some((graph.parameter(name).ok()?, meaning)));
        let found: Vec<(ParameterId, &String)> = found.collect();
        if found.is_empty() {
            return;
        }
        ui.label(RichText::new("Usual").strong())
            .on_hover_text("What people change first, as the pipeline declares it");
        for (parameter, meaning) in found {
            let name = graph.parameter_name(parameter);
            // The same parameter has another row below.
            ui.push_id(("usual", &name), |ui| {
                row(ui, model, graph, &RowText { parameter, name: &name, meaning }, actions);
            });
        }
        ui.separator();
    }

    fn is_searched(&self) -> bool {
        !self.search.is_empty() || self.only_changed
    }

    fn node(
        &self,
        ui: &mut Ui,
        model: &Model,
        (graph, index): (&Graph, usize),
        selected: Option<&str>,
        actions: &mut Vec<PanelAction>,
    ) {
        let node = &graph.nodes[index];
        let rows: Vec<ParameterId> = self.rows(model, graph, index).collect();
        if rows.is_empty() {
            return;
        }
        // What is found is open. The end of the search brings back what was open before.
        let is_searched = self.is_searched();
        let id = ui.make_persistent_id((if is_searched { "found" } else { "node" }, &node.name));
        let is_open = is_searched || graph.nodes.len() < 6;
        let mut state = egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, is_open);
        let is_goal = self.goal.as_deref() == Some(&node.name);
        if is_goal {
            state.set_open(true);
        }
        let is_selected = selected == Some(&node.name);
        let header = state.show_header(ui, |ui| header(ui, model, (node, is_selected), actions));
        let (_, shown, _) = header.body(|ui| {
            let hidden = if is_searched { Vec::new() } else { curve_of(ui, model, graph, index, actions) };
            for parameter in rows.into_iter().filter(|parameter| !hidden.contains(&parameter.index)) {
                let name = &graph.declaration(parameter).name;
                row(ui, model, graph, &RowText { parameter, name, meaning: "" }, actions);
            }
        });
        if is_goal {
            ui.scroll_to_rect(shown.response.rect, Some(egui::Align::Min));
        }
    }
}

/// The plot of one of the curves of a node, if it has any, and the choice among them. Returns the parameters of the
/// other curves, whose rows are hidden.
fn curve_of(ui: &mut Ui, model: &Model, graph: &Graph, node: usize, actions: &mut Vec<PanelAction>) -> Vec<usize> {
    let curves = curves(graph.nodes[node].kind().params());
    if curves.is_empty() {
        return Vec::new();
    }
    let name = |index| graph.parameter_name(ParameterId { node, index });
    let id = ui.id().with("shown curve");
    let mut shown = ui.data(|data| data.get_temp(id)).unwrap_or(0);
    ui.horizontal(|ui| {
        for (index, curve) in curves.iter().enumerate() {
            let is_changed = |point: &usize| model.editor().changes().get(&Target::Parameter(name(*point))).is_some();
            let text = RichText::new(&curve.name);
            let text = if curve.points.iter().any(is_changed) { text.color(ACCENT) } else { text };
            ui.selectable_value(&mut shown, index, text);
        }
    });
    ui.data_mut(|data| data.insert_temp(id, shown));
    let value = |index: &usize| match model.editor().value(&name(*index)) {
        Some(Value::Vector([x, y, ..], _)) => Some([x, y]),
        _ => None,
    };
    let points: Option<Vec<[f64; 2]>> = curves[shown].points.iter().map(value).collect();
    if let Some(PointChange { point, change }) = points.and_then(|points| plot(ui, &curves[shown], &points)) {
        let target = Target::Parameter(name(curves[shown].points[point]));
        let is_done = change.as_ref().is_none_or(|change| change.is_done);
        actions.push(PanelAction::Set(target, change.map(|change| change.value)));
        if is_done {
            actions.push(PanelAction::Release);
        }
    }
    curves.iter().enumerate().filter(|(index, _)| *index != shown).flat_map(|(_, curve)| curve.points.clone()).collect()
}

/// The text that is searched for a parameter, in lower case: its name and description, the kind of its node, and the
/// inputs and wires of the node.
fn searched(graph: &Graph, parameter: ParameterId) -> String {
    let node = &graph.nodes[parameter.node];
    let mut text = format!("{} {}", graph.parameter_name(parameter), graph.declaration(parameter).doc);
    text += &format!(" {}", node.kind().name());
    for (port, source) in node.kind().inputs().iter().zip(&node.wires) {
        if let Some(source) = source {
            text += &format!(" {} {}", port.name, wire_name(graph, *source));
        }
    }
    text.to_lowercase()
}

/// The line of a node: its switch, its name and its kind.
fn header(ui: &mut Ui, model: &Model, (node, is_selected): (&GraphNode, bool), actions: &mut Vec<PanelAction>) {
    let mut on = model.editor().is_on(&node.name);
    if ui.checkbox(&mut on, "").on_hover_text("Whether the node runs").changed() {
        actions.push(PanelAction::Set(Target::Node(node.name.clone()), Some(Value::Bool(on))));
        actions.push(PanelAction::Release);
    }
    let skipped = model.skip_reason(&node.name);
    let name = RichText::new(&node.name);
    let name = if skipped.is_some() { name.color(DIM) } else { name.strong() };
    let name = if is_selected { name.background_color(SELECTED) } else { name };
    let name = ui.add(egui::Label::new(name).sense(egui::Sense::click()));
    if name.on_hover_text("A click selects the node in the graph").clicked() {
        actions.push(PanelAction::Select(node.name.clone()));
    }
    ui.label(RichText::new(node.kind().name()).color(DIM)).on_hover_text(first_sentence(node.kind().doc()));
    if balances_white(node) {
        let button = ui.small_button("pick gray");
        if button.on_hover_text("A click on what should be gray in the picture sets the light").clicked() {
            actions.push(PanelAction::Balance(node.name.clone()));
        }
    }
    if let Some(when) = &node.when {
        ui.label(RichText::new("when").color(DIM).small()).on_hover_text(when.to_string());
    }
    if let Some(why) = skipped {
        let text = RichText::new(format!("skipped: {why}")).color(ACCENT).small();
        ui.add(egui::Label::new(text).truncate()).on_hover_text(why);
    }
}

/// The background of the name of the selected node.
const SELECTED: egui::Color32 = egui::Color32::from_gray(0x48);

/// The opacity of what has no effect at present.
const DIMMED: f32 = 0.45;

/// In less width than this, in points, a unit would be two letters; the text over the name states it anyway.
const NARROWEST_UNIT: f32 = 36.0;

/// The width of the names of parameters, in points.
const NAME_WIDTH: f32 = 100.0;

/// The name of a parameter, without its node where both do not fit.
fn fitting(ui: &Ui, name: &str) -> String {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = ui.painter().layout_no_wrap(name.to_owned(), font, ACCENT).size().x;
    match name.rsplit_once('.') {
        Some((_, parameter)) if width > NAME_WIDTH => format!("…{parameter}"),
        _ => name.to_owned(),
    }
}

/// A parameter as a row names it.
struct RowText<'a> {
    parameter: ParameterId,
    name: &'a str,
    /// The sentence of the pipeline about it; empty without one.
    meaning: &'a str,
}

/// A row: a name, marked if the parameter is changed, and the control. It is dim while the parameter does nothing.
fn row(ui: &mut Ui, model: &Model, graph: &Graph, text: &RowText<'_>, actions: &mut Vec<PanelAction>) {
    let RowText { parameter, name: shown_name, meaning } = *text;
    let (name, param) = (graph.parameter_name(parameter), graph.declaration(parameter));
    let Some(value) = model.editor().value(&name) else { return };
    let target = Target::Parameter(name);
    let is_changed = model.editor().changes().get(&target).is_some();
    ui.horizontal(|ui| {
        let skipped = model.skip_reason(&graph.nodes[parameter.node].name);
        let skipped = skipped.map(|why| format!("The node is skipped: {why}."));
        let inactive_reason = skipped.or_else(|| model.inactive_reason(parameter));
        if inactive_reason.is_some() {
            ui.multiply_opacity(DIMMED);
        }
        let color = if is_changed { ACCENT } else { ui.visuals().text_color() };
        let marked = RichText::new(fitting(ui, shown_name)).color(color);
        let text = egui::Label::new(marked).sense(egui::Sense::click()).truncate();
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(egui::vec2(NAME_WIDTH, 20.0), layout, |ui| {
            ui.set_min_width(NAME_WIDTH);
            ui.add(text)
        });
        let label = label.inner.on_hover_ui(|ui| {
            if shown_name.contains('.') {
                ui.label(RichText::new(shown_name).strong());
            }
            if let Some(why) = &inactive_reason {
                ui.label(RichText::new(why).color(ACCENT));
            }
            if !meaning.is_empty() {
                ui.label(RichText::new(meaning).strong());
            }
            ui.label(about(param, model.editor().written(&target).as_ref()));
        });
        if label.double_clicked() && is_changed {
            actions.push(PanelAction::Set(target.clone(), None));
            actions.push(PanelAction::Release);
        }
        if let Some(ControlChange { value, is_done }) = control(ui, param, &value) {
            actions.push(PanelAction::Set(target, Some(value)));
            if is_done {
                actions.push(PanelAction::Release);
            }
        }
        let mark = if param.replan { "new plan" } else { "" };
        for note in [&*param.unit, mark] {
            if !note.is_empty() && ui.available_width() > NARROWEST_UNIT {
                ui.add(egui::Label::new(RichText::new(note).color(DIM).small()).truncate());
            }
        }
    });
}

/// The description of a parameter, its domain, and its value in the file.
fn about(param: &Param, written: Option<&Value>) -> String {
    let mut text = param.doc.clone();
    match param.domain {
        Some((low, high)) => text += &format!("\n\n{low} to {high} {}", param.unit),
        None if param.unit.is_empty() => {}
        None => text += &format!("\n\nin {}", param.unit),
    }
    if let Some(neutral) = &param.neutral {
        text += &format!("\nchanges nothing at {neutral}");
    }
    if let Some(written) = written {
        text += &format!("\nin the file {written}; a double click goes back to it");
    }
    if param.replan {
        text += "\na change needs a new plan; the old picture stays until it is ready";
    }
    text
}

fn first_sentence(doc: &str) -> String {
    doc.trim_start().split("\n\n").next().unwrap_or(doc).to_owned()
}

/// The facts that the conditions of the pipeline test: unknown until the user states them.
fn facts(ui: &mut Ui, model: &mut Model, graph: &Graph) {
    let facts = graph.facts();
    if facts.is_empty() {
        return;
    }
    let hint =
        "A node runs unless its condition is known not to hold: while a fact is unknown, what depends on it runs";
    ui.label(RichText::new("Facts about the scene").strong()).on_hover_text(hint);
    for (name, kind) in facts {
        let present = model.fact(&name);
        let mut fact = present;
        ui.horizontal(|ui| {
            let layout = egui::Layout::left_to_right(egui::Align::Center);
            ui.allocate_ui_with_layout(egui::vec2(94.0, 20.0), layout, |ui| {
                ui.set_min_width(94.0);
                ui.add(egui::Label::new(&name).truncate()).on_hover_text(about_fact(graph, &name));
            });
            ui.selectable_value(&mut fact, None, "unknown");
            match kind {
                FactKind::Flag => {
                    ui.selectable_value(&mut fact, Some(Fact::Flag(false)), "no");
                    ui.selectable_value(&mut fact, Some(Fact::Flag(true)), "yes");
                }
                FactKind::Number => number_of_fact(ui, &mut fact),
            }
        });
        if let Some(meaning) = model.editor().checked().and_then(|checked| checked.fact_meaning(&name)) {
            ui.label(RichText::new(meaning).color(DIM).small());
        }
        if fact != present {
            model.set_fact(&name, fact);
        }
    }
    ui.separator();
}

/// The number of a fact; dim while it is unknown.
fn number_of_fact(ui: &mut Ui, fact: &mut Option<Fact>) {
    let known = if let Some(Fact::Number(number)) = fact { Some(*number) } else { None };
    let mut number = known.unwrap_or(0.0);
    ui.scope(|ui| {
        if known.is_none() {
            ui.multiply_opacity(DIMMED);
        }
        let response = ui.add(egui::DragValue::new(&mut number).speed(0.05));
        // Enter also accepts the number that is shown while the fact is unknown.
        let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if response.changed() || is_entered {
            *fact = Some(Fact::Number(number));
        }
    });
}

/// The nodes whose conditions ask for a fact.
fn about_fact(graph: &Graph, name: &str) -> String {
    let mut text = "Asked for by".to_owned();
    for node in &graph.nodes {
        if let Some(when) = node.when.as_ref().filter(|when| when.facts().contains(&name)) {
            text += &format!("\n{}, when: {when}", node.name);
        }
    }
    text
}
