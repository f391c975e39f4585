//! The graph is edited: each gesture is one step of undo, and undo gives the bytes of before.

use crate::support::{Window, apart, model, parameter, picture, settle};
use afterimage_graph::check::{Edit, Reader, Source};
use afterimage_graph::value::Value;
use afterimage_view::{InspectedWire, Model, Tab};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};

fn rewire(node: &str, port: &str, wire: &str) -> Edit {
    Edit::Connect { reader: Reader::input(node, port), wire: Some(wire.into()) }
}

/// The wire of an input, as the graph has it.
fn reads(model: &Model, node: &str, port: &str) -> String {
    let graph = model.editor().graph().unwrap();
    let (_, found) = graph.node(node).unwrap();
    let index = found.kind().inputs().iter().position(|input| &*input.name == port).unwrap();
    match found.wires[index].unwrap() {
        Source::Input(input) => graph.inputs[input].name.clone(),
        Source::Node { node, previous, .. } => format!("{}@{previous}", graph.nodes[node].name),
    }
}

#[test]
fn gestures_are_steps_of_undo_and_undo_gives_the_bytes_of_before() {
    let mut model = model("tsushima");
    settle(&mut model);
    let (text, first) = (model.editor().text().to_owned(), picture(&model));
    let gestures = [
        rewire("mapped", "source", "white"),
        Edit::Insert { kind: "Sharpen".into(), name: "sharp".into(), reader: Reader::input("graded", "source") },
        Edit::Rename { node: "lit".into(), name: "glowing".into() },
        Edit::Remove { node: "vignette".into() },
        Edit::Add { kind: "Vignette".into(), name: "again".into(), inputs: vec![("source".into(), "white".into())] },
    ];
    let mut texts = vec![text.clone()];
    for gesture in &gestures {
        model.edit_graph(gesture).unwrap_or_else(|problem| panic!("{gesture:?}: {problem}"));
        assert!(model.problem().is_none(), "{gesture:?}");
        texts.push(model.editor().text().to_owned());
    }
    assert_eq!(reads(&model, "graded", "source"), "sharp@0");
    assert_eq!(reads(&model, "white", "source"), "glowing@0");
    settle(&mut model);
    assert!(apart(&first, &picture(&model)) > 1, "the picture is another one");
    for before in texts.iter().rev().skip(1) {
        model.undo();
        assert_eq!(model.editor().text(), before);
    }
    assert!(model.editor().is_saved() && !model.editor().changes().can_undo());
    settle(&mut model);
    assert!(apart(&first, &picture(&model)) <= 1);
    (0..gestures.len()).for_each(|_| model.redo());
    assert_eq!(Some(model.editor().text()), texts.last().map(|text| &**text));
}

#[test]
fn changed_values_and_the_shown_wire_follow_a_name() {
    let mut model = model("lynx");
    model.set(&parameter("lit.strength"), Some(Value::Float(0.45)));
    model.release();
    model.inspect_wire(Some(InspectedWire::new("lit.result")));
    model.edit_graph(&Edit::Rename { node: "lit".into(), name: "glow".into() }).unwrap();
    assert_eq!(model.editor().value("glow.strength"), Some(Value::Float(0.45)));
    assert_eq!(model.editor().changes().get(&parameter("lit.strength")), None);
    assert_eq!(model.inspector().wire().unwrap().wire, "glow.result");
    model.save(None).unwrap();
    assert!(model.editor().text().contains("\"glow\": Composite(") && model.editor().text().contains("strength: 0.45"));
    model.undo();
    model.undo();
    assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(0.45)));
}

#[test]
fn what_is_not_possible_changes_nothing_and_says_why() {
    let mut model = model("lynx");
    let before = model.editor().text().to_owned();
    let problem = model.edit_graph(&rewire("exposed", "source", "display")).unwrap_err().to_string();
    assert!(problem.contains("display"), "{problem}");
    assert_eq!(model.editor().text(), before);
    assert!(!model.editor().changes().can_undo() && model.problem().is_none());
    let sources = model.sources(&Reader::input("exposed", "source"), 0).unwrap();
    let candidates = model.candidates(sources).unwrap();
    let scene = candidates.iter().find(|candidate| candidate.wire == "scene").unwrap();
    let display = candidates.iter().find(|candidate| candidate.wire == "display").unwrap();
    assert!(scene.refusal.is_none() && display.refusal.is_some());
}

#[test]
fn a_kind_that_does_not_fit_on_a_wire_goes_on_the_nearest_one_that_takes_it() {
    let mut model = model("lynx");
    let scene = Reader::input("exposed", "source");
    assert!(model.kinds_between(&scene).unwrap().iter().all(|kind| kind.name() != "Dither"));
    let place = model.nearest_place("Dither", &scene).unwrap().expect("a wire takes it");
    model.insert_node("Dither", place).unwrap();
    assert!(model.problem().is_none());
    // A kind that fits there goes there, and one that reads no image goes nowhere.
    assert_eq!(model.nearest_place("Vignette", &scene).unwrap(), Some(scene.clone()));
    assert_eq!(model.nearest_place("DemoScene", &scene).unwrap(), None);
}

fn open(name: &str) -> Window {
    let mut window = Window::new(model(name));
    window.ui.viewer.tabs.open = Some(Tab::Graph);
    for _ in 0..4 {
        window.frame(Vec::new());
    }
    window
}

/// The box of a node, by its name in the panel of the graph.
fn place(window: &mut Window, node: &str) -> egui::Rect {
    let texts = window.texts();
    let found = texts.iter().find(|(text, area)| text == node && area.min.y > 500.0);
    found.unwrap_or_else(|| panic!("no `{node}`")).1
}

/// Points of the drawing that one row of a box has.
fn row(window: &mut Window) -> f32 {
    let (from, to) = (place(window, "mapped").min, place(window, "graded").min);
    (to.x - from.x) / 130.0 * 15.0
}

/// The end of the first wire at a node, and the beginning of that of its first output.
fn ends(window: &mut Window, node: &str) -> (Pos2, Pos2) {
    let (name, row) = (place(window, node).min, row(window));
    let scale = row / 15.0;
    let corner = name - scale * vec2(7.0, 1.0);
    let middle = corner + vec2(0.0, 1.7 * row);
    (middle, middle + vec2(104.0 * scale, 0.0))
}

fn right_click(window: &mut Window, at: Pos2) {
    window.frame(vec![Event::PointerMoved(at)]);
    for pressed in [true, false] {
        let (pos, button, modifiers) = (at, PointerButton::Secondary, Modifiers::NONE);
        window.frame(vec![Event::PointerButton { pos, button, pressed, modifiers }]);
    }
    window.frame(Vec::new());
}

#[test]
fn a_wire_is_dragged_to_another_output_and_refused_at_one_that_does_not_fit() {
    let mut window = open("tsushima");
    let before = window.ui.viewer.model.editor().text().to_owned();
    let (input, _) = ends(&mut window, "mapped");
    let (_, white) = ends(&mut window, "white");
    window.drag(input, white);
    window.frame(Vec::new());
    assert_eq!(reads(&window.ui.viewer.model, "mapped", "source"), "white@0");
    window.key(Key::Z, Modifiers::COMMAND);
    assert_eq!(window.ui.viewer.model.editor().text(), before);
    // The other way: from the output to an input, whose state does not fit. The reason is under the pointer.
    let (_, output) = ends(&mut window, "encoded");
    let (white, _) = ends(&mut window, "white");
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.frame(vec![Event::PointerMoved(output)]);
    window.frame(vec![button(output, true)]);
    window.frame(vec![Event::PointerMoved(output.lerp(white, 0.5))]);
    window.frame(vec![Event::PointerMoved(white)]);
    window.frame(Vec::new());
    assert!(window.says("accepts `Scene`"), "{:?}", window.texts());
    window.frame(vec![button(white, false)]);
    window.frame(Vec::new());
    assert_eq!(window.ui.viewer.model.editor().text(), before);
    assert!(window.says("Not changed: "));
}

#[test]
fn a_node_is_inserted_on_a_wire_by_search_and_removed_by_a_key() {
    let mut window = open("tsushima");
    let before = window.ui.viewer.model.editor().text().to_owned();
    let (input, _) = ends(&mut window, "graded");
    let (_, output) = ends(&mut window, "mapped");
    window.click(input.lerp(output, 0.5));
    window.frame(Vec::new());
    assert!(window.says("Insert before"));
    for letter in "sharp".chars() {
        window.frame(vec![Event::Text(letter.to_string())]);
    }
    window.frame(Vec::new());
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    assert_eq!(reads(&window.ui.viewer.model, "graded", "source"), "sharpen@0");
    assert!(!window.says("Insert before"));
    // It is selected, and its parameters are shown.
    (0..30).for_each(|_| window.frame(Vec::new()));
    assert!(window.texts().iter().any(|(text, area)| text == "sharpen" && area.max.x < 320.0 && area.min.y > 40.0));
    let node = place(&mut window, "sharpen").center();
    window.click(node);
    window.key(Key::Delete, Modifiers::NONE);
    assert_eq!(window.ui.viewer.model.editor().text(), before);
    window.key(Key::Z, Modifiers::COMMAND);
    assert_eq!(reads(&window.ui.viewer.model, "graded", "source"), "sharpen@0");
    window.key(Key::Z, Modifiers::COMMAND);
    assert_eq!(window.ui.viewer.model.editor().text(), before);
}

#[test]
fn a_node_is_renamed_disabled_and_rewired_by_its_menu() {
    let mut window = open("lynx");
    let at = place(&mut window, "lit").center();
    right_click(&mut window, at);
    let rename = window.place_of("Rename…");
    window.click(rename);
    window.frame(Vec::new());
    window.key(Key::A, Modifiers::COMMAND);
    window.frame(vec![Event::Text("glow \"x\"".into())]);
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    assert!(window.ui.viewer.model.editor().graph().unwrap().node("glow \"x\"").is_some());
    window.key(Key::Z, Modifiers::COMMAND);
    assert!(window.ui.viewer.model.editor().is_saved());
    // With keys alone: the menu opens below the node, and an arrow goes to its second entry.
    let at = place(&mut window, "lit").center();
    window.click(at);
    window.key(Key::Space, Modifiers::NONE);
    window.frame(Vec::new());
    window.key(Key::ArrowDown, Modifiers::NONE);
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    assert!(!window.ui.viewer.model.editor().is_on("lit"));
    // What an input reads is chosen from a list, in which what does not fit cannot be chosen.
    let at = place(&mut window, "mapped").center();
    right_click(&mut window, at);
    let sources = window.place_of("source reads lit…");
    window.click(sources);
    window.frame(Vec::new());
    let texts = window.texts();
    // The menu is drawn last.
    let entry = texts.iter().rev().find(|(text, _)| text == "exposed").unwrap().1.center();
    window.click(entry);
    window.frame(Vec::new());
    assert_eq!(reads(&window.ui.viewer.model, "mapped", "source"), "exposed@0");
}

#[test]
fn a_node_is_off_in_the_shown_tier_alone() {
    let mut window = open("tsushima");
    window.ui.viewer.model.set_tier(Some("high".into()));
    window.frame(Vec::new());
    let at = place(&mut window, "grain").center();
    right_click(&mut window, at);
    let off = window.place_of("Off in tier “high” alone");
    window.click(off);
    window.frame(Vec::new());
    assert!(!window.ui.viewer.model.editor().is_on("grain"));
    window.ui.viewer.model.set_tier(Some("ultra".into()));
    assert!(window.ui.viewer.model.editor().is_on("grain"));
}

#[test]
fn the_selected_node_is_shown_in_the_parameters_and_in_the_text() {
    let mut window = open("tsushima");
    let at = place(&mut window, "display").center();
    window.click(at);
    (0..30).for_each(|_| window.frame(Vec::new()));
    let is_in_parameters = |text: &str, area: &egui::Rect| text == "display" && area.max.x < 320.0;
    assert!(window.texts().iter().any(|(text, area)| is_in_parameters(text, area)));
    assert_eq!(window.ui.viewer.model.editor().lines_of("metered").map(|lines| lines.count()), Some(7));
    window.ui.viewer.tabs.open = Some(Tab::Text);
    (0..30).for_each(|_| window.frame(Vec::new()));
    // The number of its line is beside it.
    let line = window.ui.viewer.model.editor().lines_of("display").unwrap().start().to_string();
    assert!(window.texts().iter().any(|(text, area)| *text == line && area.min.y > 500.0));
    window.key(Key::F, Modifiers::COMMAND);
    window.frame(vec![Event::Text("firefl".into())]);
    window.frame(Vec::new());
    assert!(window.says("1 of 1"), "{:?}", window.texts());
}

#[test]
fn a_node_is_added_with_a_wire_to_the_selected_one() {
    let mut window = open("lynx");
    let at = place(&mut window, "mapped").center();
    window.click(at);
    let add = window.place_of("Add node…");
    window.click(add);
    window.frame(Vec::new());
    window.frame(vec![Event::Text("encode".into())]);
    window.frame(Vec::new());
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    assert_eq!(reads(&window.ui.viewer.model, "encode", "source"), "mapped@0");
    assert!(window.ui.viewer.model.problem().is_none());
}
