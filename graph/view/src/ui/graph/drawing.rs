//! The drawing of a graph: boxes, wires and their ends.

use std::collections::BTreeMap;

use afterimage_graph::check::{Edit, Graph, GraphNode, Reader, Source};
use egui::epaint::CubicBezierShape;
use egui::text::{LayoutJob, TextWrapping};
use egui::{Align2, Color32, FontId, Pos2, Rect, Response, RichText, Sense, Shape, Stroke, StrokeKind, Ui, Vec2};

use super::super::theme::{ACCENT, DIM, FIELD, wire_color};
use super::drag::{Drag, Held};
use super::layout::{Item, Placed, THUMBNAIL, has_image};
use super::thumbnail::Thumbnails;
use super::wire::{input_of, wire_name, wire_text, wired_inputs};
use crate::model::Model;

/// The distance from boxes at which a wire goes around them, in points.
const DETOUR: f32 = 8.0;
/// The colors of passes that hold several nodes.
const GROUNDS: [Color32; 4] = [
    Color32::from_rgb(0xf2, 0xb1, 0x34),
    Color32::from_rgb(0x5a, 0xa0, 0xe0),
    Color32::from_rgb(0x8a, 0xc9, 0x66),
    Color32::from_rgb(0xc0, 0x80, 0xd8),
];

/// Points between columns, the width of a box, and the height of a row.
pub(super) const COLUMN: f32 = 130.0;
pub(super) const WIDTH: f32 = 104.0;
pub(super) const ROW: f32 = 15.0;

/// The distance from a wire in points at which the pointer is on it.
const REACH: f32 = 5.0;
/// The side of the area around an end that can be clicked.
const END: f32 = 13.0;
/// The brightness of wires that are not those of the selected node.
const FADED: f32 = 0.35;
/// The color of ends that the dragged wire cannot get.
const REFUSED: Color32 = Color32::from_gray(0x4c);

/// Something that the user does with the drawing.
pub(super) enum Act {
    /// A wire is shown in place of the picture.
    Inspect(String),
    Select(String),
    /// The menu of a node opens.
    Menu(String),
    /// The end of a wire is held.
    Grab(Held, Pos2),
    /// It is let go, over an end that makes this edit.
    Drop(Option<Edit>),
    Deselect,
}

/// A drawing of a graph.
pub(super) struct Drawing<'d> {
    pub(super) model: &'d Model,
    pub(super) graph: &'d Graph,
    pub(super) placed: &'d [Placed],
    /// The first pass that a node shares with others.
    pub(super) fused: &'d BTreeMap<String, usize>,
    pub(super) inspected: Option<&'d str>,
    pub(super) selected: Option<&'d str>,
    pub(super) drag: Option<&'d Drag>,
    /// The size of the names of nodes.
    pub(super) name_size: f32,
    pub(super) thumbnails: Option<Thumbnails<'d>>,
}

/// A wire of the drawing.
struct Wire {
    reader: Reader,
    /// The node that reads it.
    node: Option<usize>,
    source: Source,
    from: Pos2,
    to: Pos2,
}

impl Drawing<'_> {
    /// Draws it, and returns what the user does with its boxes and ends. `pointer` is a place in the drawing.
    pub(super) fn show(&self, ui: &mut Ui, pointer: Option<Pos2>) -> Vec<Act> {
        self.grounds(ui);
        let under_pointer = pointer.and_then(|at| self.wire_at(at));
        for wire in self.wires() {
            self.wire(ui, &wire, under_pointer.as_ref() == Some(&wire.reader));
        }
        let mut acts = Vec::new();
        for placed in self.placed {
            self.item(ui, placed, &mut acts);
        }
        if let (Some(drag), Some(pointer)) = (self.drag, pointer) {
            let (from, to) =
                if matches!(drag.held, Held::Wire(_)) { (drag.from, pointer) } else { (pointer, drag.from) };
            ui.painter().add(curve(from, to, Stroke::new(2.0, ACCENT)));
        }
        acts
    }

    pub(super) fn rect_of(&self, item: Item) -> Rect {
        self.placed.iter().find(|placed| placed.item == item).map_or(Rect::ZERO, rect)
    }

    /// The end of a wire at a node.
    fn input_at(&self, node: usize, row: usize) -> Pos2 {
        let rect = self.rect_of(Item::Node(node));
        Pos2::new(rect.min.x, rect.min.y + (1.7 + row as f32) * ROW)
    }

    /// The beginning of a wire.
    pub(super) fn output_at(&self, source: Source) -> Pos2 {
        match source {
            Source::Input(input) => self.rect_of(Item::Input(input)).right_center(),
            Source::Node { node, output, .. } => {
                let rect = self.rect_of(Item::Node(node));
                Pos2::new(rect.max.x, rect.min.y + (1.7 + output as f32) * ROW)
            }
        }
    }

    /// The place of the end of a wire at what reads it.
    pub(super) fn place_of(&self, reader: &Reader) -> Option<Pos2> {
        self.wires().into_iter().find(|wire| wire.reader == *reader).map(|wire| wire.to)
    }

    fn wires(&self) -> Vec<Wire> {
        let mut wires = Vec::new();
        for (index, node) in self.graph.nodes.iter().enumerate() {
            for (row, (port, source)) in wired_inputs(node).enumerate() {
                let (from, to) = (self.output_at(source), self.input_at(index, row));
                wires.push(Wire { reader: input_of(node, port), node: Some(index), source, from, to });
            }
        }
        for (index, output) in self.graph.outputs.iter().enumerate() {
            let (from, to) = (self.output_at(output.source), self.rect_of(Item::Output(index)).left_center());
            let reader = Reader::Output(output.name.clone());
            wires.push(Wire { reader, node: None, source: output.source, from, to });
        }
        wires
    }

    /// The end of the wire at a place.
    pub(super) fn wire_at(&self, at: Pos2) -> Option<Reader> {
        if self.drag.is_some() || self.placed.iter().any(|placed| rect(placed).expand(END / 2.0).contains(at)) {
            return None;
        }
        let distance = |wire: &Wire| {
            let points = points(&self.route(wire, Stroke::NONE));
            points.windows(2).map(|pair| distance_to(at, pair[0], pair[1])).fold(f32::MAX, f32::min)
        };
        let near = self.wires().into_iter().map(|wire| (distance(&wire), wire)).filter(|(apart, _)| *apart < REACH);
        near.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, wire)| wire.reader)
    }

    /// The curve of a wire. One that boxes would hide goes above or below them, where it crosses fewer others.
    fn route(&self, wire: &Wire, stroke: Stroke) -> CubicBezierShape {
        let direct = curve(wire.from, wire.to, stroke);
        let between = self.placed.iter().map(rect);
        let between: Vec<Rect> = between.filter(|area| area.min.x > wire.from.x && area.max.x < wire.to.x).collect();
        let hidden_by = |curve: &CubicBezierShape| {
            let points = points(curve);
            between.iter().filter(|area| points.iter().any(|point| area.contains(*point))).copied().collect::<Vec<_>>()
        };
        let hidden = hidden_by(&direct);
        let Some(around) = hidden.iter().copied().reduce(Rect::union) else { return direct };
        let middle = wire.from.lerp(wire.to, 0.5).y;
        let detours = [around.min.y - DETOUR, around.max.y + DETOUR].map(|lane| {
            // The middle of the curve is three parts of four of the way to its inner points.
            let inner = middle + (lane - middle) / 0.75;
            let mut detour = direct.clone();
            detour.points[1].y = inner;
            detour.points[2].y = inner;
            (hidden_by(&detour).len(), (lane - middle).abs(), detour)
        });
        let [above, below] = detours;
        if (above.0, above.1) < (below.0, below.1) { above.2 } else { below.2 }
    }

    fn wire(&self, ui: &Ui, wire: &Wire, is_under_pointer: bool) {
        let is_past = matches!(wire.source, Source::Node { previous: 1.., .. });
        let is_inspected = self.inspected == Some(&wire_name(self.graph, wire.source));
        let ends = [wire.node, if let Source::Node { node, .. } = wire.source { Some(node) } else { None }];
        let is_of_selected = ends.into_iter().flatten().any(|node| self.selected == Some(&self.graph.nodes[node].name));
        let color = wire_color(self.graph.port_type(wire.source));
        let color = if is_past { color.gamma_multiply(0.4) } else { color };
        let stroke = match (is_inspected, is_under_pointer || is_of_selected) {
            (true, _) => Stroke::new(3.0, ACCENT),
            (_, true) => Stroke::new(2.5, color.lerp_to_gamma(Color32::WHITE, 0.35)),
            _ if self.drag.is_some() || self.selected.is_some() => Stroke::new(1.5, color.gamma_multiply(FADED)),
            _ => Stroke::new(1.5, color),
        };
        ui.painter().add(self.route(wire, stroke));
        if is_under_pointer {
            plus(ui, curve(wire.from, wire.to, stroke).sample(0.5));
        }
    }

    /// A background behind the nodes of one pass, in its own color.
    fn grounds(&self, ui: &Ui) {
        for placed in self.placed {
            let Item::Node(node) = placed.item else { continue };
            let Some(pass) = self.fused.get(&self.graph.nodes[node].name) else { continue };
            let color = GROUNDS[pass % GROUNDS.len()];
            let wide = rect(placed).expand2(Vec2::new((COLUMN - WIDTH) / 2.0, 5.0));
            ui.painter().rect_filled(wide, 5.0, color.gamma_multiply(0.22));
        }
    }

    /// Draws a box with its ends.
    fn item(&self, ui: &mut Ui, placed: &Placed, acts: &mut Vec<Act>) {
        let rect = rect(placed);
        match placed.item {
            Item::Input(input) => {
                let name = &self.graph.inputs[input].name;
                let is_fit = self.drag.is_none_or(|drag| drag.of_wire(name).is_some_and(|fit| fit.refusal.is_none()));
                let response = self.frame(ui, rect, name, (!is_fit, self.inspected == Some(name), false));
                acts.extend(response.clicked().then(|| Act::Inspect(name.clone())));
                self.thumbnail(ui, rect, Source::Input(input));
                self.output(ui, Source::Input(input), acts);
            }
            Item::Output(output) => {
                let reader = Reader::Output(self.graph.outputs[output].name.clone());
                let is_fit =
                    self.drag.is_none_or(|drag| drag.of_reader(&reader).is_some_and(|fit| fit.refusal.is_none()));
                let name = &self.graph.outputs[output].name;
                let response = self.frame(ui, rect, name, (!is_fit, false, false));
                response.on_hover_text("An output of the pipeline");
                let color = wire_color(self.graph.port_type(self.graph.outputs[output].source));
                self.input(ui, rect.left_center(), (reader, color), acts);
            }
            Item::Node(node) => self.node(ui, rect, node, acts),
        }
    }

    /// Draws what a wire carries at the bottom of a box, if it is an image and thumbnails are shown.
    fn thumbnail(&self, ui: &Ui, rect: Rect, source: Source) {
        if let Some(thumbnails) = self.thumbnails.filter(|_| has_image(self.graph.port_type(source))) {
            let bottom = rect.with_min_y(rect.max.y - THUMBNAIL * ROW);
            thumbnails.show(ui, bottom, self.graph, self.model, source);
        }
    }

    fn node(&self, ui: &mut Ui, rect: Rect, index: usize, acts: &mut Vec<Act>) {
        let node = &self.graph.nodes[index];
        let skipped = self.model.skip_reason(&node.name);
        let outputs = node.kind().outputs();
        let names: Vec<String> = outputs.iter().map(|port| format!("{}.{}", node.name, port.name)).collect();
        let is_inspected = names.iter().any(|name| self.inspected == Some(name));
        let is_dim = if self.drag.is_some() { !self.takes_part(node, index) } else { skipped.is_some() };
        let is_selected = self.selected == Some(&node.name);
        let response = self.frame(ui, rect, &node.name, (is_dim, is_inspected, is_selected));
        if response.double_clicked() {
            acts.push(Act::Inspect(names[0].clone()));
        } else if response.clicked() {
            acts.push(Act::Select(node.name.clone()));
        } else if response.secondary_clicked() {
            acts.push(Act::Menu(node.name.clone()));
        }
        self.thumbnail(ui, rect, Source::Node { node: index, output: 0, previous: 0 });
        if self.drag.is_none() {
            response.on_hover_ui(|ui| about(ui, node, skipped));
        }
        for (row, (port, _)) in wired_inputs(node).enumerate() {
            let (at, input) = (self.input_at(index, row), &node.kind().inputs()[port]);
            text(ui, at + Vec2::new(7.0, 0.0), Align2::LEFT_CENTER, &input.name, is_dim);
            self.input(ui, at, (input_of(node, port), wire_color(input.ty)), acts);
        }
        for (output, port) in outputs.iter().enumerate() {
            let source = Source::Node { node: index, output, previous: 0 };
            if outputs.len() > 1 {
                let at = self.output_at(source) - Vec2::new(7.0, 0.0);
                text(ui, at, Align2::RIGHT_CENTER, &port.name, is_dim);
            }
            self.output(ui, source, acts);
        }
    }

    /// Returns whether the dragged wire may end at a node.
    fn takes_part(&self, node: &GraphNode, index: usize) -> bool {
        let Some(drag) = self.drag else { return true };
        match &drag.held {
            Held::Wire(wire) => {
                let is_source = wire.split('.').next() == Some(&node.name);
                is_source || drag.of_node(&node.name).any(|candidate| candidate.refusal.is_none())
            }
            Held::Reader(reader) => {
                let is_reader = matches!(reader, Reader::Input { node: name, .. } if *name == node.name);
                let outputs = 0..node.kind().outputs().len();
                let wire = |output| wire_text(self.graph, Source::Node { node: index, output, previous: 0 });
                is_reader || outputs.map(wire).any(|wire| drag.of_wire(&wire).is_some_and(|fit| fit.refusal.is_none()))
            }
        }
    }

    /// The end of a wire at what reads it.
    fn input(&self, ui: &mut Ui, at: Pos2, (reader, color): (Reader, Color32), acts: &mut Vec<Act>) {
        let area = Rect::from_center_size(at, Vec2::splat(END));
        let response = ui.interact(area, ui.id().with(("input", reader.to_string())), Sense::click_and_drag());
        let fit = self.drag.map(|drag| drag.of_reader(&reader).is_some_and(|candidate| candidate.refusal.is_none()));
        end(ui, at, (3.0, color), fit, response.hovered());
        let response = match self.drag {
            None => response.on_hover_text(format!("{reader}: drag to another output")),
            Some(_) => response,
        };
        if response.drag_started() {
            acts.push(Act::Grab(Held::Reader(reader), at));
        }
    }

    /// The end of a wire at what makes it. A click shows what it carries.
    fn output(&self, ui: &mut Ui, source: Source, acts: &mut Vec<Act>) {
        let (at, name, wire) = (self.output_at(source), wire_name(self.graph, source), wire_text(self.graph, source));
        let area = Rect::from_center_size(at, Vec2::splat(END));
        let response = ui.interact(area, ui.id().with(("output", &name)), Sense::click_and_drag());
        let fit = self.drag.map(|drag| drag.of_wire(&wire).is_some_and(|candidate| candidate.refusal.is_none()));
        end(ui, at, (3.5, wire_color(self.graph.port_type(source))), fit, response.hovered());
        let doc = match source {
            Source::Node { node, output, .. } => self.graph.nodes[node].kind().outputs()[output].doc.to_string(),
            Source::Input(_) => "An input of the pipeline.".to_owned(),
        };
        let response = match self.drag {
            None => response.on_hover_text(format!("{name}: {doc}\nA click shows it; drag it to an input.")),
            Some(_) => response,
        };
        if response.drag_started() {
            acts.push(Act::Grab(Held::Wire(wire), at));
        } else if response.clicked() {
            acts.push(Act::Inspect(name));
        }
    }

    fn frame(
        &self,
        ui: &mut Ui,
        rect: Rect,
        name: &str,
        (is_dim, is_inspected, is_selected): (bool, bool, bool),
    ) -> Response {
        let response = ui.allocate_rect(rect, Sense::click());
        let fill = match (is_dim, is_selected) {
            (true, _) => FIELD,
            (false, true) => Color32::from_gray(0x3c),
            (false, false) => Color32::from_gray(0x2c),
        };
        let line = match (is_inspected, is_selected, response.hovered()) {
            (true, ..) => Stroke::new(2.0, ACCENT),
            (_, true, _) => Stroke::new(2.0, Color32::from_gray(0xe4)),
            (_, _, true) => Stroke::new(1.0, Color32::from_gray(0xa0)),
            _ => Stroke::new(1.0, Color32::from_gray(0x48)),
        };
        ui.painter().rect(rect, 4.0, fill, line, StrokeKind::Inside);
        let color = if is_dim { Color32::from_gray(0x70) } else { Color32::from_gray(0xe4) };
        let mut line = LayoutJob::simple_singleline(name.to_owned(), FontId::proportional(self.name_size), color);
        line.wrap = TextWrapping::truncate_at_width(rect.width() - 10.0);
        let line = ui.painter().layout_job(line);
        ui.painter().galley(rect.min + Vec2::new(7.0, 1.0), line, color);
        response
    }
}

/// The area of a box.
pub(super) fn rect(placed: &Placed) -> Rect {
    let corner = Pos2::new(placed.rank as f32 * COLUMN, placed.row * ROW);
    Rect::from_min_size(corner, Vec2::new(WIDTH, placed.rows * ROW))
}

fn curve(from: Pos2, to: Pos2, stroke: Stroke) -> CubicBezierShape {
    let bend = Vec2::new(((to.x - from.x).abs() * 0.5).clamp(18.0, 90.0), 0.0);
    CubicBezierShape::from_points_stroke([from, from + bend, to - bend, to], false, Color32::TRANSPARENT, stroke)
}

/// Points along a curve, near each other.
fn points(curve: &CubicBezierShape) -> Vec<Pos2> {
    (0..=24).map(|step| curve.sample(step as f32 / 24.0)).collect()
}

/// The distance of a place from a line between two others.
fn distance_to(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let line = to - from;
    let along = ((at - from).dot(line) / line.length_sq().max(1e-6)).clamp(0.0, 1.0);
    (at - (from + along * line)).length()
}

/// Draws an end. `fit` is true for one that the dragged wire may get, and none while nothing is dragged.
fn end(ui: &Ui, at: Pos2, (radius, color): (f32, Color32), fit: Option<bool>, is_hovered: bool) {
    let (radius, color) = match fit {
        None if is_hovered => (radius + 1.5, color),
        None => (radius, color),
        Some(true) => (radius + 2.0, color),
        Some(false) => (radius, REFUSED),
    };
    ui.painter().circle_filled(at, radius, color);
    if fit == Some(true) {
        ui.painter().circle_stroke(at, radius + 2.0, Stroke::new(1.0, ACCENT));
    }
}

/// The mark of a wire that a click opens.
fn plus(ui: &Ui, at: Pos2) {
    ui.painter().circle_filled(at, 6.5, ACCENT);
    let stroke = Stroke::new(1.5, Color32::from_gray(0x17));
    for arm in [Vec2::new(3.0, 0.0), Vec2::new(0.0, 3.0)] {
        ui.painter().add(Shape::line_segment([at - arm, at + arm], stroke));
    }
}

fn text(ui: &Ui, at: Pos2, align: Align2, text: &str, is_dim: bool) {
    let color = Color32::from_gray(if is_dim { 0x58 } else { 0x98 });
    ui.painter().text(at, align, text, FontId::proportional(9.0), color);
}

/// The description of a node, and the reason if it is skipped.
fn about(ui: &mut Ui, node: &GraphNode, skipped: Option<&str>) {
    ui.label(RichText::new(format!("{}: {}", node.name, node.kind().name())).strong());
    ui.label(node.kind().doc().trim_start().split("\n\n").next().unwrap_or_default());
    if let Some(why) = skipped {
        ui.label(RichText::new(format!("skipped: {why}")).color(ACCENT));
    }
    ui.label(RichText::new("A click selects it, a second one shows its result; the right button has more.").color(DIM));
}
