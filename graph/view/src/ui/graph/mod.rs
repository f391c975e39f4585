//! The graph panel: nodes and wires, skipped and fused nodes, and the inspected wire.

mod layout;

use std::collections::BTreeMap;

use afterimage_graph::check::{Graph, Source};
use afterimage_plan::Plan;
use egui::text::{LayoutJob, TextWrapping};
use egui::{Color32, FontId, Pos2, Rect, Response, RichText, Sense, Stroke, Ui, Vec2};

use super::text::note_errors;
use super::theme::{ACCENT, DIM, FIELD, wire_color};
use crate::model::{InspectedWire, Model, PipelineInstance};
use layout::{Item, Placed, layout};

/// The colors of passes that hold several nodes.
const GROUNDS: [Color32; 4] = [
    Color32::from_rgb(0xf2, 0xb1, 0x34),
    Color32::from_rgb(0x5a, 0xa0, 0xe0),
    Color32::from_rgb(0x8a, 0xc9, 0x66),
    Color32::from_rgb(0xc0, 0x80, 0xd8),
];

/// The scales at which a graph is shown.
const SCALES: (f32, f32) = (0.25, 2.0);
/// The largest scale at which a small graph fills the panel.
const LARGEST_FIT: f32 = 1.2;
/// Points around the drawing.
const MARGIN: f32 = 10.0;

/// Points between columns, the width of a box, and the height of a row.
const COLUMN: f32 = 130.0;
const WIDTH: f32 = 104.0;
const ROW: f32 = 15.0;

#[derive(Default)]
pub(super) struct GraphPanel {
    /// The part of the drawing that the user has chosen; `None` for all of it.
    view: Option<Rect>,
    placed: Vec<Placed>,
    /// The names of the placed inputs and nodes.
    names: Vec<String>,
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

impl GraphPanel {
    /// Shows the graph; a click on an output inspects its wire.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model) {
        let Some(graph) = model.editor().graph().cloned() else {
            ui.label(RichText::new("The pipeline has errors: see Messages.").color(DIM));
            return;
        };
        self.place(&graph);
        let fused = fused(model.shown().and_then(PipelineInstance::plan).map(|plan| &**plan));
        let inspected = model.inspector().wire().map(|wire| wire.wire.clone());
        note_errors(ui, model);
        let mut chosen = None;
        let panel = ui.available_rect_before_wrap();
        let before = self.zoomed(ui, panel);
        let mut view = before;
        let drawn = egui::Scene::new().zoom_range(SCALES.0..=SCALES.1).show(ui, &mut view, |ui| {
            let (graph, placed, fused, inspected) = (&*graph, &*self.placed, &fused, inspected.as_deref());
            // Names are larger in a drawing that is made smaller, as far as their boxes have room.
            let name_size = (11.5 * before.width() / panel.width()).clamp(11.5, 15.0);
            chosen = Drawing { model, graph, placed, fused, inspected, name_size }.show(ui);
        });
        if drawn.response.double_clicked() {
            self.view = None;
        } else if view != before {
            self.view = Some(self.kept_in_view(view));
        }
        if let Some(wire) = chosen {
            let again = inspected.as_deref() == Some(&wire);
            model.inspect_wire(if again { None } else { Some(InspectedWire::new(wire)) });
        }
    }

    /// The area of all nodes.
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
        let Some(at) = ui.input(|input| input.pointer.hover_pos()).filter(|at| panel.contains(*at)) else {
            return view;
        };
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

    /// Places the nodes anew if they are others.
    fn place(&mut self, graph: &Graph) {
        let inputs = graph.inputs.iter().map(|input| input.name.clone());
        let names: Vec<String> = inputs.chain(graph.nodes.iter().map(|node| node.name.clone())).collect();
        if names != self.names {
            (self.placed, self.names, self.view) = (layout(graph), names, None);
        }
    }
}

/// The name of a wire: an input, or `node.port`.
pub(super) fn wire_name(graph: &Graph, source: Source) -> String {
    match source {
        Source::Input(input) => graph.inputs[input].name.clone(),
        Source::Node { node, output, .. } => {
            let node = &graph.nodes[node];
            format!("{}.{}", node.name, node.kind().outputs()[output].name)
        }
    }
}

/// A drawing of a graph.
struct Drawing<'d> {
    model: &'d Model,
    graph: &'d Graph,
    placed: &'d [Placed],
    /// The first pass that a node shares with others.
    fused: &'d BTreeMap<String, usize>,
    inspected: Option<&'d str>,
    /// The size of the names of nodes.
    name_size: f32,
}

impl Drawing<'_> {
    /// Draws it, and states which wire was clicked.
    fn show(&self, ui: &mut Ui) -> Option<String> {
        self.grounds(ui);
        let mut chosen = None;
        for (index, node) in self.graph.nodes.iter().enumerate() {
            let wired = node.wires.iter().flatten().enumerate();
            for (row, source) in wired {
                self.wire(ui, *source, self.input_at(index, row));
            }
        }
        for placed in self.placed {
            chosen = self.item(ui, placed).or(chosen);
        }
        chosen
    }

    fn rect(&self, placed: &Placed) -> Rect {
        let corner = Pos2::new(placed.rank as f32 * COLUMN, placed.row * ROW);
        Rect::from_min_size(corner, Vec2::new(WIDTH, placed.rows * ROW))
    }

    fn rect_of(&self, item: Item) -> Rect {
        self.placed.iter().find(|placed| placed.item == item).map_or(Rect::ZERO, |placed| self.rect(placed))
    }

    /// The end of a wire at a node.
    fn input_at(&self, node: usize, row: usize) -> Pos2 {
        let rect = self.rect_of(Item::Node(node));
        Pos2::new(rect.min.x, rect.min.y + (1.7 + row as f32) * ROW)
    }

    /// The beginning of a wire.
    fn output_at(&self, source: Source) -> Pos2 {
        match source {
            Source::Input(input) => self.rect_of(Item::Input(input)).right_center(),
            Source::Node { node, output, .. } => {
                let rect = self.rect_of(Item::Node(node));
                Pos2::new(rect.max.x, rect.min.y + (1.7 + output as f32) * ROW)
            }
        }
    }

    fn wire(&self, ui: &Ui, source: Source, to: Pos2) {
        let from = self.output_at(source);
        let is_past = matches!(source, Source::Node { previous: 1.., .. });
        let is_inspected = self.inspected == Some(&wire_name(self.graph, source));
        let color = wire_color(self.graph.port_type(source));
        let color = if is_past { color.gamma_multiply(0.4) } else { color };
        let stroke = if is_inspected { Stroke::new(3.0, ACCENT) } else { Stroke::new(1.5, color) };
        let bend = Vec2::new(((to.x - from.x).abs() * 0.5).clamp(18.0, 90.0), 0.0);
        let curve = egui::epaint::CubicBezierShape::from_points_stroke(
            [from, from + bend, to - bend, to],
            false,
            Color32::TRANSPARENT,
            stroke,
        );
        ui.painter().add(curve);
    }

    /// A background behind the nodes of one pass, in its own color.
    fn grounds(&self, ui: &Ui) {
        for placed in self.placed {
            let Item::Node(node) = placed.item else { continue };
            let Some(pass) = self.fused.get(&self.graph.nodes[node].name) else { continue };
            let color = GROUNDS[pass % GROUNDS.len()];
            let wide = self.rect(placed).expand2(Vec2::new((COLUMN - WIDTH) / 2.0, 5.0));
            ui.painter().rect_filled(wide, 5.0, color.gamma_multiply(0.22));
        }
    }

    /// Draws a box; its outputs can be clicked.
    fn item(&self, ui: &mut Ui, placed: &Placed) -> Option<String> {
        let rect = self.rect(placed);
        match placed.item {
            Item::Input(input) => {
                let name = &self.graph.inputs[input].name;
                let response = self.frame(ui, rect, name, false, self.inspected == Some(name));
                response.clicked().then(|| name.clone())
            }
            Item::Node(node) => self.node(ui, rect, node),
        }
    }

    fn node(&self, ui: &mut Ui, rect: Rect, index: usize) -> Option<String> {
        let node = &self.graph.nodes[index];
        let skipped = self.model.skip_reason(&node.name);
        let names = node.kind().outputs().iter().map(|port| format!("{}.{}", node.name, port.name));
        let names: Vec<String> = names.collect();
        let is_inspected = names.iter().any(|name| self.inspected == Some(name));
        let response = self.frame(ui, rect, &node.name, skipped.is_some(), is_inspected);
        let response = response.on_hover_ui(|ui| about(ui, node, skipped));
        for (row, wire) in node.wires.iter().zip(node.kind().inputs()).filter(|(wire, _)| wire.is_some()).enumerate() {
            let at = self.input_at(index, row);
            let ty = wire.1.ty;
            ui.painter().circle_filled(at, 3.0, wire_color(ty));
            text(ui, at + Vec2::new(6.0, 0.0), egui::Align2::LEFT_CENTER, &wire.1.name, skipped.is_some());
        }
        let mut chosen = response.clicked().then(|| names[0].clone());
        for (output, (port, name)) in node.kind().outputs().iter().zip(&names).enumerate() {
            let at = self.output_at(Source::Node { node: index, output, previous: 0 });
            let area = Rect::from_center_size(at, Vec2::splat(12.0));
            let port_response = ui.interact(area, ui.id().with(name), Sense::click()).on_hover_text(&*port.doc);
            let radius = if port_response.hovered() { 5.0 } else { 3.5 };
            ui.painter().circle_filled(at, radius, wire_color(port.ty));
            if output > 0 || names.len() > 1 {
                text(ui, at - Vec2::new(6.0, 0.0), egui::Align2::RIGHT_CENTER, &port.name, skipped.is_some());
            }
            if port_response.clicked() {
                chosen = Some(name.clone());
            }
        }
        chosen
    }

    fn frame(&self, ui: &mut Ui, rect: Rect, name: &str, is_skipped: bool, is_inspected: bool) -> Response {
        let response = ui.allocate_rect(rect, Sense::click());
        let fill = if is_skipped { FIELD } else { Color32::from_gray(0x2c) };
        let line = match (is_inspected, response.hovered()) {
            (true, _) => Stroke::new(2.0, ACCENT),
            (false, true) => Stroke::new(1.0, Color32::from_gray(0xa0)),
            (false, false) => Stroke::new(1.0, Color32::from_gray(0x48)),
        };
        ui.painter().rect(rect, 4.0, fill, line, egui::StrokeKind::Inside);
        let color = if is_skipped { Color32::from_gray(0x70) } else { Color32::from_gray(0xe4) };
        let mut line = LayoutJob::simple_singleline(name.to_owned(), FontId::proportional(self.name_size), color);
        line.wrap = TextWrapping::truncate_at_width(rect.width() - 10.0);
        let line = ui.painter().layout_job(line);
        ui.painter().galley(rect.min + Vec2::new(7.0, 1.0), line, color);
        response
    }
}

fn text(ui: &Ui, at: Pos2, align: egui::Align2, text: &str, is_skipped: bool) {
    let color = Color32::from_gray(if is_skipped { 0x58 } else { 0x98 });
    ui.painter().text(at, align, text, FontId::proportional(9.0), color);
}

/// The description of a node, and the reason if it is skipped.
fn about(ui: &mut Ui, node: &afterimage_graph::check::GraphNode, skipped: Option<&str>) {
    ui.label(RichText::new(format!("{}: {}", node.name, node.kind().name())).strong());
    ui.label(node.kind().doc().split("\n\n").next().unwrap_or_default());
    if let Some(why) = skipped {
        ui.label(RichText::new(format!("skipped: {why}")).color(ACCENT));
    }
}
