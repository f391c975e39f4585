//! The menu of a node, the sources of an input, and the kinds of a new node, over the graph.

use afterimage_graph::check::{Candidate, Edit, Reader};
use afterimage_graph::value::Value;
use egui::{Area, Button, Context, Frame, Id, Key, Layout, Modifiers, Order, Pos2, RichText, ScrollArea, TextEdit, Ui};

use super::super::list_keys::choose_by_keys;
use super::super::theme::{DIM, ERROR};
use super::drag::{connection, reason};
use super::kinds::{KindList, TakenKind};
use super::wire::wire_text;
use crate::Problem;
use crate::model::{InspectedWire, Model, Target};

/// The width of the menu in points.
const WIDTH: f32 = 300.0;
/// The height of a list, of which more is scrolled.
const HEIGHT: f32 = 300.0;

/// A menu that is open.
pub(super) struct Menu {
    at: Pos2,
    page: Page,
    /// The error of the last choice.
    error: Option<String>,
    /// It has not been shown yet.
    is_new: bool,
}

/// Content of a menu.
enum Page {
    /// The actions on a node.
    Node(String),
    /// The field of a new name.
    Rename { node: String, name: String },
    /// The wires that an input or output could read.
    Sources { reader: Reader, candidates: Vec<Candidate> },
    /// The kinds of a new node: between an input or output and what it reads, or anywhere.
    Kinds { before: Option<Reader>, list: KindList },
}

/// An action that was chosen.
enum Choice {
    Edit(Edit),
    Switch {
        node: String,
        on: bool,
    },
    Inspect(String),
    Rename(String),
    Sources(Reader),
    /// A kind on the page of kinds.
    Kind(TakenKind),
}

/// A step that the menu has taken.
pub(super) enum Outcome {
    /// It stays open.
    Open,
    /// It was closed by a key or by a choice that changes nothing.
    Closed,
    /// The user has gone elsewhere.
    Left,
    /// It is done, and this node is selected.
    Made(Option<String>),
}

impl Menu {
    fn new(at: Pos2, page: Page) -> Self {
        Self { at, page, error: None, is_new: true }
    }

    pub(super) fn node(at: Pos2, node: &str) -> Self {
        Self::new(at, Page::Node(node.to_owned()))
    }

    pub(super) fn rename(at: Pos2, node: &str) -> Self {
        Self::new(at, Page::Rename { node: node.to_owned(), name: node.to_owned() })
    }

    /// The kinds that fit between an input or output and what it reads.
    pub(super) fn insert(at: Pos2, model: &Model, reader: Reader) -> Result<Self, Problem> {
        let fitting = model.kinds_between(&reader)?;
        let mut others = model.kinds()?;
        others.retain(|kind| !fitting.iter().any(|fitting| fitting.name() == kind.name()));
        let list = KindList::new(fitting, others);
        Ok(Self::new(at, Page::Kinds { before: Some(reader), list }))
    }

    /// All kinds.
    pub(super) fn add(at: Pos2, model: &Model) -> Result<Self, Problem> {
        Ok(Self::new(at, Page::Kinds { before: None, list: KindList::new(model.kinds()?, Vec::new()) }))
    }

    fn sources(at: Pos2, model: &Model, reader: Reader) -> Result<Self, Problem> {
        let mut candidates = model.candidates(model.sources(&reader, 0)?)?;
        candidates.sort_by_key(|candidate| candidate.refusal.is_some());
        Ok(Self::new(at, Page::Sources { reader, candidates }))
    }

    /// Shows the menu, and does what is chosen. `selected` is the node whose output a new node reads, if it can.
    pub(super) fn show(&mut self, ctx: &Context, model: &mut Model, selected: Option<&str>) -> Outcome {
        let is_new = std::mem::take(&mut self.is_new);
        let is_closed_by_key = ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape));
        let area = Area::new(Id::new("menu of the graph")).order(Order::Foreground).fixed_pos(self.at);
        let area = area.constrain(true).fade_in(false);
        let shown = area.show(ctx, |ui| {
            Frame::menu(ui.style()).show(ui, |ui| {
                ui.set_width(WIDTH);
                ui.with_layout(Layout::top_down_justified(egui::Align::LEFT), |ui| self.page(ui, model, is_new)).inner
            })
        });
        let pressed = ctx.input(|input| input.pointer.any_pressed().then(|| input.pointer.interact_pos()).flatten());
        let is_left = pressed.is_some_and(|at| !is_new && !shown.response.rect.contains(at));
        match shown.inner.inner {
            Some(choice) => self.choose(model, choice, selected),
            None if is_closed_by_key => Outcome::Closed,
            None if is_left => Outcome::Left,
            None => Outcome::Open,
        }
    }

    fn page(&mut self, ui: &mut Ui, model: &Model, is_new: bool) -> Option<Choice> {
        let choice = match &mut self.page {
            Page::Node(node) => node_page(ui, model, node),
            Page::Rename { node, name } => rename_page(ui, node, name, is_new),
            Page::Sources { reader, candidates } => sources_page(ui, reader, candidates),
            Page::Kinds { before, list } => kinds_page(ui, before.as_ref(), list, is_new),
        };
        if let Some(error) = &self.error {
            ui.add_space(4.0);
            ui.add(egui::Label::new(RichText::new(error).color(ERROR)).wrap());
        }
        choice
    }

    fn choose(&mut self, model: &mut Model, choice: Choice, selected: Option<&str>) -> Outcome {
        let made = match choice {
            Choice::Edit(edit) => model.edit_graph(&edit).map(|()| match edit {
                Edit::Rename { name, .. } => Some(name),
                Edit::SwitchAtTier { node, .. } => Some(node),
                Edit::Connect { reader: Reader::Input { node, .. }, .. } => Some(node),
                _ => None,
            }),
            Choice::Switch { node, on } => {
                model.set(&Target::Node(node.clone()), Some(Value::Bool(on)));
                model.release();
                Ok(Some(node))
            }
            Choice::Inspect(wire) => {
                model.inspect_wire(Some(InspectedWire::new(wire)));
                return Outcome::Closed;
            }
            Choice::Rename(node) => {
                *self = Self::rename(self.at, &node);
                return Outcome::Open;
            }
            Choice::Sources(reader) => match Self::sources(self.at, model, reader) {
                Ok(menu) => {
                    *self = menu;
                    return Outcome::Open;
                }
                Err(problem) => Err(problem),
            },
            Choice::Kind(TakenKind { name, is_elsewhere }) => match &self.page {
                Page::Kinds { before: Some(reader), .. } if is_elsewhere => insert_near(model, &name, reader),
                Page::Kinds { before: Some(reader), .. } => model.insert_node(&name, reader.clone()).map(Some),
                _ => model.add_node(&name, selected).map(Some),
            },
        };
        match made {
            Ok(node) => Outcome::Made(node),
            Err(problem) => {
                self.error = Some(refusal(&problem));
                Outcome::Open
            }
        }
    }
}

/// Inserts a node on the wire that takes it and is nearest to another one.
fn insert_near(model: &mut Model, kind: &str, reader: &Reader) -> Result<Option<String>, Problem> {
    match model.nearest_place(kind, reader)? {
        Some(place) => model.insert_node(kind, place).map(Some),
        None => Err(Problem::message(format!("no wire of the pipeline takes a `{kind}`"))),
    }
}

/// The reason why an edit was not made.
pub(super) fn refusal(problem: &Problem) -> String {
    match problem {
        Problem::Pipeline(errors) => format!("Not changed: {}", reason(errors)),
        other => format!("Not changed: {other}"),
    }
}

fn title(ui: &mut Ui, name: &str, more: &str) {
    ui.horizontal(|ui| {
        ui.add(egui::Label::new(RichText::new(name).strong()).truncate());
        ui.add(egui::Label::new(RichText::new(more).color(DIM)).truncate());
    });
    ui.separator();
}

fn node_page(ui: &mut Ui, model: &Model, name: &str) -> Option<Choice> {
    let graph = model.editor().graph()?.clone();
    let (_, node) = graph.node(name)?;
    title(ui, name, node.kind().name());
    let is_on = model.editor().is_on(name);
    let remove = Edit::Remove { node: name.to_owned() };
    let mut entries = vec![
        ("Rename…".to_owned(), "F2", Choice::Rename(name.to_owned())),
        (
            if is_on { "Disable" } else { "Enable" }.to_owned(),
            "D",
            Choice::Switch { node: name.to_owned(), on: !is_on },
        ),
    ];
    if let Some(tier) = model.editor().tier() {
        let is_off = node.off;
        let text =
            if is_off { format!("On in tier “{tier}” alone") } else { format!("Off in tier “{tier}” alone") };
        let switch = |on| Choice::Edit(Edit::SwitchAtTier { node: name.to_owned(), on });
        entries.push((text, "", switch(Some(is_off))));
        entries.push((format!("As without tier “{tier}”"), "", switch(None)));
    }
    entries.push(("Delete".to_owned(), "Del", Choice::Edit(remove)));
    let output = node.kind().outputs().first().map(|output| format!("{name}.{}", output.name));
    entries.extend(output.map(|wire| ("Show its result".to_owned(), "Enter", Choice::Inspect(wire))));
    let reads = entries.len();
    for (port, input) in node.kind().inputs().iter().enumerate() {
        let reader = Reader::input(name, &input.name);
        let source = node.wires[port].map_or_else(|| "—".to_owned(), |source| wire_text(&graph, source));
        entries.push((format!("{} reads {source}…", input.name), "", Choice::Sources(reader)));
    }
    let mut responses = Vec::new();
    for (index, (text, key, _)) in entries.iter().enumerate() {
        if index == reads {
            ui.separator();
        }
        responses.push((ui.add(Button::new(&**text).shortcut_text(*key).frame_when_inactive(false)), &**text));
    }
    let chosen = choose_by_keys(ui, &responses, 0)?;
    Some(entries.swap_remove(chosen).2)
}

fn rename_page(ui: &mut Ui, node: &str, name: &mut String, is_new: bool) -> Option<Choice> {
    title(ui, "Rename", node);
    let field = ui.add(TextEdit::singleline(name).desired_width(f32::INFINITY));
    if is_new {
        field.request_focus();
    }
    ui.label(RichText::new("In every wire, override and tier of this file. Enter renames.").color(DIM).small());
    let is_done = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    is_done.then(|| Choice::Edit(Edit::Rename { node: node.to_owned(), name: name.clone() }))
}

fn sources_page(ui: &mut Ui, reader: &Reader, candidates: &[Candidate]) -> Option<Choice> {
    title(ui, "Reads", &reader.to_string());
    let mut responses = Vec::new();
    let none = Button::new("nothing").frame_when_inactive(false);
    responses.push((ui.add(none).on_hover_text("Takes the wire away, if the input can be without one"), "nothing"));
    ScrollArea::vertical().max_height(HEIGHT).show(ui, |ui| {
        for candidate in candidates {
            let button = Button::new(&*candidate.wire).frame_when_inactive(false);
            match &candidate.refusal {
                None => responses.push((ui.add(button), &*candidate.wire)),
                Some(errors) => drop(ui.add_enabled(false, button).on_disabled_hover_text(reason(errors))),
            }
        }
    });
    let chosen = choose_by_keys(ui, &responses, 1.min(responses.len() - 1))?;
    Some(Choice::Edit(match candidates.get(chosen.wrapping_sub(1)) {
        Some(candidate) => connection(candidate),
        None => Edit::Connect { reader: reader.clone(), wire: None },
    }))
}

fn kinds_page(ui: &mut Ui, before: Option<&Reader>, list: &mut KindList, is_new: bool) -> Option<Choice> {
    let Some(reader) = before else {
        title(ui, "Add a node", "It reads the selected one, if it can");
        return list.show(ui, is_new, HEIGHT).map(Choice::Kind);
    };
    title(ui, "Insert before", &reader.to_string());
    let chosen = list.show(ui, is_new, HEIGHT).map(Choice::Kind);
    ui.separator();
    let other = ui.add(Button::new("Read something else…").frame_when_inactive(false));
    other.clicked().then(|| Choice::Sources(reader.clone())).or(chosen)
}
