//! The graph panel: nodes and wires, skipped and fused nodes, the inspected wire, and edits of all of them.

mod drag;
mod drawing;
mod keys;
mod kinds;
mod layout;
mod menu;
mod target;
mod thumbnail;
mod wire;

use std::collections::BTreeMap;

use afterimage_graph::check::{Edit, Graph, Reader};
use afterimage_plan::Plan;
use egui::emath::TSTransform;
use egui::{Context, Id, Pos2, Rect, RichText, Sense, Ui};

use super::text::note_errors;
use super::theme::{ACCENT, DIM, ERROR};
use crate::Problem;
use crate::model::{InspectedWire, Model, PipelineInstance};
use drag::{Drag, connection, reason};
use drawing::{Act, COLUMN, Drawing, ROW, WIDTH};
use layout::{Item, Placed, layout};
use menu::{Menu, Outcome, refusal};
use target::is_near;
pub(super) use thumbnail::Thumbnails;
pub(super) use wire::wire_name;

/// The scales at which a graph is shown.
const SCALES: (f32, f32) = (0.25, 2.0);
/// The largest scale at which a small graph fills the panel.
const LARGEST_FIT: f32 = 1.2;
/// Points around the drawing.
const MARGIN: f32 = 10.0;

#[derive(Default)]
pub(super) struct GraphPanel {
    /// The part of the drawing that the user has chosen; `None` for all of it.
    view: Option<Rect>,
    placed: Vec<Placed>,
    /// The names of the placed inputs, nodes and outputs, and what they read.
    placed_names: Vec<String>,
    has_room: bool,
    /// The node whose parameters and wires are pointed out.
    selected: Option<String>,
    /// The selection is new: other panels go to it.
    is_new_selection: bool,
    drag: Option<Drag>,
    menu: Option<Menu>,
    /// The images of wires are shown in the boxes.
    pub(super) shows_thumbnails: bool,
    /// From the drawing to the window.
    to_window: TSTransform,
}

/// The first pass that a node shares with others, for each fused node.
fn fused(plan: Option<&Plan>) -> BTreeMap<String, usize> {
    let mut fused = BTreeMap::new();
    let passes = plan.into_iter().flat_map(Plan::work).enumerate();
    for (index, pass) in passes.filter(|(_, pass)| pass.nodes.len() > 1) {
        for node in &pass.nodes {
            fused.entry(node.clone()).or_insert(index);
        }
    }
    fused
}

/// Identity of the graph as what has the keyboard.
fn field() -> Id {
    Id::new("graph of the pipeline")
}

impl GraphPanel {
    /// True if keys are those of the graph.
    pub(super) fn has_focus(ctx: &Context) -> bool {
        ctx.memory(|memory| memory.has_focus(field()))
    }

    /// True while a menu of the graph is open, or a wire is dragged.
    pub(super) fn is_busy(&self) -> bool {
        self.menu.is_some() || self.drag.is_some()
    }

    /// The selected node.
    pub(super) fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    pub(super) fn select(&mut self, node: Option<String>) {
        self.is_new_selection = node.is_some();
        self.selected = node;
    }

    /// The node that was selected since the last call.
    pub(super) fn take_new_selection(&mut self) -> Option<String> {
        std::mem::take(&mut self.is_new_selection).then(|| self.selected.clone()).flatten()
    }

    /// Opens the list of kinds for a new node.
    pub(super) fn add(&mut self, model: &Model, at: Pos2) -> Option<String> {
        self.open(Menu::add(at, model))
    }

    fn open(&mut self, menu: Result<Menu, Problem>) -> Option<String> {
        match menu {
            Ok(menu) => {
                self.menu = Some(menu);
                None
            }
            Err(problem) => Some(refusal(&problem)),
        }
    }

    /// Shows the graph, and edits it as the user says. Returns a message, if an edit was not possible.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, thumbnails: Thumbnails<'_>) -> Option<String> {
        let Some(graph) = model.editor().graph().cloned() else {
            ui.label(RichText::new("The pipeline has errors: see Messages.").color(DIM));
            return None;
        };
        self.place(&graph);
        self.selected.take_if(|node| graph.node(node).is_none());
        note_errors(ui, model);
        let panel = ui.available_rect_before_wrap();
        ui.interact(panel, field(), Sense::focusable_noninteractive());
        let by_key = self.keys(ui, model, &graph);
        self.hold_earlier(ui, model);
        let thumbnails = self.shows_thumbnails.then_some(thumbnails);
        let (acts, wire) = self.draw(ui, model, &graph, thumbnails, panel);
        let by_act = acts.into_iter().filter_map(|act| self.act(ui, model, act)).last();
        let by_wire = wire.and_then(|(reader, at)| self.open(Menu::insert(at, model, reader)));
        by_key.or(by_act).or(by_wire)
    }

    /// Shows the menu that is open, over everything else.
    pub(super) fn show_menu(&mut self, ctx: &Context, model: &mut Model) {
        let Some(mut menu) = self.menu.take() else { return };
        let source = self.selected.clone();
        match menu.show(ctx, model, source.as_deref()) {
            Outcome::Open => return self.menu = Some(menu),
            Outcome::Left => return,
            Outcome::Made(Some(node)) => self.select(Some(node)),
            Outcome::Closed | Outcome::Made(None) => {}
        }
        ctx.memory_mut(|memory| memory.request_focus(field()));
    }

    /// Draws the graph. Returns what the user does with it, and the wire that was clicked.
    fn draw(
        &mut self,
        ui: &mut Ui,
        model: &Model,
        graph: &Graph,
        thumbnails: Option<Thumbnails<'_>>,
        panel: Rect,
    ) -> (Vec<Act>, Option<(Reader, Pos2)>) {
        let fused = fused(model.shown().and_then(PipelineInstance::plan).map(|plan| &**plan));
        let inspected = model.inspector().wire().map(|wire| wire.wire.clone());
        let before = self.zoomed(ui, panel);
        let mut view = before;
        let scale = (panel.size() / before.size()).min_elem().clamp(SCALES.0, SCALES.1);
        self.to_window = TSTransform::from_translation(panel.center().to_vec2() - scale * before.center().to_vec2())
            * TSTransform::from_scaling(scale);
        let in_window =
            ui.input(|input| input.pointer.hover_pos()).filter(|at| panel.contains(*at) && self.menu.is_none());
        let pointer = in_window.map(|at| self.to_window.inverse() * at);
        self.try_ends(ui, model, graph, pointer);
        let drawing = Drawing {
            model,
            graph,
            placed: &self.placed,
            fused: &fused,
            inspected: inspected.as_deref(),
            selected: self.selected.as_deref(),
            drag: self.drag.as_ref(),
            thumbnails,
            // Names are larger in a drawing that is made smaller, as far as their boxes have room.
            name_size: (11.5 * before.width() / panel.width()).clamp(11.5, 15.0),
        };
        let scene = egui::Scene::new().zoom_range(SCALES.0..=SCALES.1);
        let drawn = scene.show(ui, &mut view, |ui| drawing.show(ui, pointer));
        let is_clicked = drawn.response.clicked() || drawn.response.secondary_clicked();
        let wire = pointer.filter(|_| is_clicked).and_then(|at| drawing.wire_at(at));
        let dropped = self.drag.as_ref().map(|drag| (drag, pointer.and_then(|at| drawing.candidate_at(drag, at))));
        let mut acts = drawn.inner;
        if let Some((_, candidate)) = dropped {
            if let Some(candidate) = candidate {
                tell(ui, candidate);
            }
            if !ui.input(|input| input.pointer.any_down()) {
                acts.push(Act::Drop(candidate.map(connection)));
            }
        }
        if drawn.response.double_clicked() {
            self.view = None;
        } else if view != before {
            self.view = Some(self.kept_in_view(view));
        }
        if is_clicked && wire.is_none() {
            acts.push(Act::Deselect);
        }
        (acts, wire.zip(in_window))
    }

    /// Does what the user does with the drawing.
    fn act(&mut self, ui: &Ui, model: &mut Model, act: Act) -> Option<String> {
        match act {
            Act::Inspect(wire) => {
                let again = model.inspector().wire().is_some_and(|inspected| inspected.wire == wire);
                model.inspect_wire(if again { None } else { Some(InspectedWire::new(wire)) });
            }
            Act::Select(node) => {
                self.select(Some(node));
                ui.memory_mut(|memory| memory.request_focus(field()));
            }
            Act::Deselect => {
                self.select(None);
                ui.memory_mut(|memory| memory.request_focus(field()));
            }
            Act::Menu(node) => {
                let at = ui.input(|input| input.pointer.interact_pos()).unwrap_or_default();
                self.select(Some(node.clone()));
                self.menu = Some(Menu::node(at, &node));
            }
            Act::Grab(held, from) => {
                let is_earlier = ui.input(|input| input.modifiers.shift);
                match Drag::begin(model, held, from, is_earlier) {
                    Ok(drag) => self.drag = Some(drag),
                    Err(problem) => return Some(refusal(&problem)),
                }
            }
            Act::Drop(edit) => {
                self.drag = None;
                return edit.and_then(|edit| self.edit(model, &edit));
            }
        }
        None
    }

    /// Makes an edit. Returns the reason if it is not possible.
    fn edit(&mut self, model: &mut Model, edit: &Edit) -> Option<String> {
        match model.edit_graph(edit) {
            Ok(()) => None,
            Err(problem) => Some(refusal(&problem)),
        }
    }

    /// With Shift, a dragged wire is that of the frame before. Esc lets it go.
    fn hold_earlier(&mut self, ui: &Ui, model: &Model) {
        if ui.input(|input| input.key_pressed(egui::Key::Escape)) {
            self.drag = None;
        }
        if let Some(drag) = &mut self.drag {
            drag.set_earlier(model, ui.input(|input| input.modifiers.shift));
        }
    }

    /// Tries ends for the dragged wire: those under the pointer at once, the others in the next frames.
    fn try_ends(&mut self, ui: &Ui, model: &Model, graph: &Graph, pointer: Option<Pos2>) {
        let Some(drag) = &mut self.drag else { return };
        let hovered = pointer.and_then(|at| self.placed.iter().find(|placed| is_near(placed, at)));
        let name = hovered.map(|placed| match placed.item {
            Item::Input(input) => &*graph.inputs[input].name,
            Item::Node(node) => &*graph.nodes[node].name,
            Item::Output(output) => &*graph.outputs[output].name,
        });
        if drag.try_ends(model, name) {
            ui.ctx().request_repaint();
        }
    }

    /// The area of all boxes.
    fn bounds(&self) -> Rect {
        let right = self.placed.iter().map(|placed| placed.rank as f32 * COLUMN + WIDTH).fold(0.0, f32::max);
        let lower = self.placed.iter().map(|placed| (placed.row + placed.rows) * ROW).fold(0.0, f32::max);
        Rect::from_min_max(Pos2::ZERO, Pos2::new(right, lower)).expand(MARGIN)
    }

    /// The part of the drawing that fills the panel: all of it, or what the user has chosen. The wheel zooms at the
    /// pointer.
    fn zoomed(&mut self, ui: &Ui, panel: Rect) -> Rect {
        let bounds = self.bounds();
        let scale_of = |view: Rect| (panel.size() / view.size()).min_elem().clamp(SCALES.0, SCALES.1);
        let view = self.view.unwrap_or_else(|| {
            let scale = scale_of(bounds).min(LARGEST_FIT);
            Rect::from_center_size(bounds.center(), panel.size() / scale)
        });
        let pointer = ui.input(|input| input.pointer.hover_pos());
        let Some(at) = pointer.filter(|at| panel.contains(*at) && self.menu.is_none()) else { return view };
        let turned = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta).y / 200.0);
        if turned == 0.0 {
            return view;
        }
        let before = scale_of(view);
        let scale = (before * turned.exp2()).clamp(SCALES.0, SCALES.1);
        let from_center = at - panel.center();
        let center = view.center() + from_center / before - from_center / scale;
        let view = self.kept_in_view(Rect::from_center_size(center, panel.size() / scale));
        self.view = Some(view);
        view
    }

    /// The part of the drawing moved so that its middle is within the drawing: no graph is lost.
    fn kept_in_view(&self, view: Rect) -> Rect {
        let bounds = self.bounds();
        Rect::from_center_size(view.center().clamp(bounds.min, bounds.max), view.size())
    }

    /// Places the boxes anew if they, their sizes or their wires are others. All of another pipeline is shown.
    fn place(&mut self, graph: &Graph) {
        let names = placed_names(graph);
        if names == self.placed_names && self.has_room == self.shows_thumbnails {
            return;
        }
        if self.has_room != self.shows_thumbnails || !names.iter().any(|name| self.placed_names.contains(name)) {
            self.view = None;
        }
        self.has_room = self.shows_thumbnails;
        (self.placed, self.placed_names) = (layout(graph, self.has_room), names);
    }
}

/// The names of inputs, nodes and outputs, with what they read.
fn placed_names(graph: &Graph) -> Vec<String> {
    let inputs = graph.inputs.iter().map(|input| input.name.clone());
    let nodes = graph.nodes.iter().map(|node| format!("{} {:?}", node.name, node.wires));
    let outputs = graph.outputs.iter().map(|output| format!("@{} {:?}", output.name, output.source));
    inputs.chain(nodes).chain(outputs).collect()
}

/// Tells at the pointer what a drop would do, or why it would do nothing.
fn tell(ui: &Ui, candidate: &afterimage_graph::check::Candidate) {
    let id = Id::new("end of the dragged wire");
    let tooltip = egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, egui::PopupAnchor::Pointer);
    tooltip.show(|ui| match &candidate.refusal {
        Some(errors) => ui.label(RichText::new(reason(errors)).color(ERROR)),
        None => ui.label(RichText::new(format!("{} to {}", candidate.wire, candidate.reader)).color(ACCENT)),
    });
}
