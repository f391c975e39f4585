//! The whole viewer, driven by events and drawn into a texture.

use crate::support::{SIZE, WINDOW, Window, model, picture, settle, texels};
use afterimage_graph::check::Fact;
use afterimage_graph::color::Transfer;
use afterimage_graph::value::Value;
use afterimage_view::{CompareWith, Comparison, ExportKind, InspectedWire, Tab, Target};
use egui::{Event, Key, Modifiers, pos2, vec2};

/// A place in the picture.
const PLACE: egui::Pos2 = pos2(660.0, 230.0);

fn open(name: &str) -> Window {
    let mut window = Window::new(model(name));
    for _ in 0..4 {
        window.frame(Vec::new());
    }
    window
}

#[test]
fn keys_do_what_the_sheet_says() {
    let mut window = open("lynx");
    window.key(Key::Space, Modifiers::NONE);
    assert!(window.ui.viewer.model.clock().is_playing);
    window.key(Key::Space, Modifiers::NONE);
    assert!(!window.ui.viewer.model.clock().is_playing);
    for (key, tab) in [(Key::T, Tab::Text), (Key::K, Tab::Cost), (Key::M, Tab::Messages), (Key::G, Tab::Graph)] {
        window.key(key, Modifiers::NONE);
        assert_eq!(window.ui.viewer.tabs.open, Some(tab), "{key:?}");
    }
    window.key(Key::R, Modifiers::NONE);
    assert_eq!(window.ui.viewer.model.compared(), Some(&CompareWith::Reference));
    for (key, mode) in [(Key::B, Comparison::SideBySide), (Key::D, Comparison::Difference), (Key::W, Comparison::Wipe)]
    {
        window.key(key, Modifiers::NONE);
        assert_eq!(window.ui.viewer.picture.comparison, mode);
    }
    window.key(Key::Num1, Modifiers::NONE);
    assert_eq!(window.ui.viewer.picture.zoom, Some(1.0));
    window.key(Key::F, Modifiers::NONE);
    assert_eq!(window.ui.viewer.picture.zoom, None);
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("scene")));
    window.key(Key::Escape, Modifiers::NONE);
    assert!(window.ui.viewer.model.inspector().wire().is_none());
}

#[test]
fn keys_undo_redo_and_save() {
    let mut window = open("lynx");
    let strength = Target::Parameter("lit.strength".into());
    window.ui.viewer.model.set(&strength, Some(Value::Float(0.31)));
    window.ui.viewer.model.release();
    window.key(Key::Z, Modifiers::COMMAND);
    assert!(window.ui.viewer.model.editor().changes().is_empty());
    window.key(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
    assert_eq!(window.ui.viewer.model.editor().value("lit.strength"), Some(Value::Float(0.31)));
    window.key(Key::S, Modifiers::COMMAND);
    assert!(window.ui.viewer.model.editor().text().contains("strength: 0.31"));
    assert!(window.ui.viewer.model.editor().changes().is_empty());
}

#[test]
fn a_drag_moves_the_picture_and_a_wheel_enlarges_what_is_under_the_pointer() {
    let mut window = open("lynx");
    window.frame(vec![Event::PointerMoved(PLACE)]);
    window.frame(Vec::new());
    let under = window.ui.viewer.picture.pointer.unwrap();
    for _ in 0..12 {
        let wheel = Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: vec2(0.0, 60.0),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
        };
        window.frame(vec![wheel]);
    }
    (0..60).for_each(|_| window.frame(Vec::new()));
    let zoom = window.ui.viewer.picture.zoom.unwrap();
    assert!(zoom > 8.0, "{zoom}");
    let still = window.ui.viewer.picture.pointer.unwrap();
    assert!((0..2).all(|axis| (under[axis] - still[axis]).abs() < 0.01), "{under:?} {still:?}");
    window.drag(PLACE, PLACE + vec2(80.0, 0.0));
    let moved = window.ui.viewer.picture.pointer.unwrap();
    assert!((0..2).all(|axis| (under[axis] - moved[axis]).abs() < 0.02), "{under:?} {moved:?}");
    assert_eq!(window.ui.viewer.picture.zoom, Some(zoom));
}

#[test]
fn the_line_of_a_wipe_is_dragged_and_both_pictures_are_shown() {
    let mut window = open("lynx");
    let model = &mut window.ui.viewer.model;
    model.set(&Target::Parameter("lit.strength".into()), Some(Value::Float(1.0)));
    model.set_compared(Some(CompareWith::Written));
    (0..6).for_each(|_| window.frame(Vec::new()));
    let before = window.ui.viewer.picture.wipe;
    assert!((before - 0.5).abs() < 1e-6);
    // The picture lies between the panels, whose widths are those of the first frame.
    let (left, right) = picture_columns(&window);
    let line = pos2((left + right) / 2.0, PLACE.y);
    window.drag(line, line - vec2(100.0, 0.0));
    let after = window.ui.viewer.picture.wipe;
    let wanted = 0.5 - 100.0 / (right - left);
    assert!((after - wanted).abs() < 0.02, "{after} {wanted}");
}

/// The columns between which the picture is shown: what surrounds it has a gray of its own.
fn picture_columns(window: &Window) -> (f32, f32) {
    let pixels = window.texels().to_floats();
    let row = 40 * WINDOW[0] as usize;
    let is_surround = |column: &usize| (pixels[row + column][0] * 255.0 - 23.0).abs() < 1.0;
    let columns: Vec<usize> = (0..WINDOW[0] as usize).filter(is_surround).collect();
    (*columns.first().unwrap() as f32, *columns.last().unwrap() as f32)
}

#[test]
fn nothing_is_drawn_outside_of_the_window_and_the_panels_are_there() {
    let mut window = open("tsushima");
    window.ui.viewer.inspects_pixels = true;
    window.frame(vec![Event::PointerMoved(PLACE)]);
    (0..6).for_each(|_| window.frame(Vec::new()));
    let pixels = window.texels().to_floats();
    let at = |x: usize, y: usize| pixels[y * WINDOW[0] as usize + x];
    let spread = |x: std::ops::Range<usize>, y: std::ops::Range<usize>| {
        let all: Vec<f32> = y.flat_map(|y| x.clone().map(move |x| (x, y))).map(|(x, y)| at(x, y)[1]).collect();
        let mean = all.iter().sum::<f32>() / all.len() as f32;
        all.iter().map(|value| (value - mean).abs()).sum::<f32>() / all.len() as f32
    };
    // The picture, the parameters, the scopes and the graph all show something.
    for (name, x, y) in [
        ("picture", 400..900, 80..400),
        ("parameters", 20..280, 60..400),
        ("scopes", 1040..1260, 40..400),
        ("graph", 20..1200, 560..700),
    ] {
        assert!(spread(x, y) > 0.004, "{name}");
    }
}

#[test]
fn the_probe_stays_where_the_pointer_left_and_where_it_is_pinned() {
    let mut window = open("lynx");
    window.key(Key::P, Modifiers::NONE);
    let go = |window: &mut Window, at| {
        window.frame(vec![Event::PointerMoved(at)]);
        window.frame(Vec::new());
        window.ui.viewer.picture.inspected_place
    };
    let first = go(&mut window, PLACE).unwrap();
    assert_eq!(go(&mut window, pos2(100.0, 300.0)), Some(first), "the pointer is at the parameters");
    let second = go(&mut window, PLACE + vec2(60.0, 0.0)).unwrap();
    assert!(second[0] > first[0]);
    window.click(PLACE);
    assert_eq!(go(&mut window, PLACE + vec2(60.0, 0.0)), Some(first), "a click pins it");
    // Not at the same place: a double click fits the picture.
    window.click(PLACE + vec2(0.0, 40.0));
    assert_eq!(go(&mut window, PLACE + vec2(60.0, 0.0)), Some(second), "another lets it go");
}

#[test]
fn closing_asks_while_changes_are_not_saved() {
    let mut window = open("lynx");
    let strength = Target::Parameter("lit.strength".into());
    window.ui.viewer.model.set(&strength, Some(Value::Float(0.31)));
    window.ui.viewer.close();
    window.frame(Vec::new());
    assert!(!window.ui.viewer.is_closing());
    window.key(Key::Escape, Modifiers::NONE);
    window.frame(Vec::new());
    assert!(!window.ui.viewer.is_closing());
    assert_eq!(
        window.ui.viewer.model.editor().value("lit.strength"),
        Some(Value::Float(0.31)),
        "the window stays as it was"
    );
    window.key(Key::S, Modifiers::COMMAND);
    window.ui.viewer.close();
    assert!(window.ui.viewer.is_closing());
}

#[test]
fn a_fact_is_unknown_no_or_yes_and_goes_back() {
    let mut window = open("caracal");
    let mut seen = Vec::new();
    for value in ["no", "yes", "unknown"] {
        let button = window.place_of(value);
        window.click(button);
        seen.push(window.ui.viewer.model.fact("emissive"));
    }
    assert_eq!(seen, [Some(Fact::Flag(false)), Some(Fact::Flag(true)), None]);
}

/// The file that an export of the window makes.
fn exported(window: &mut Window, kind: ExportKind) -> afterimage_view::Exported {
    window.ui.viewer.export(kind);
    for _ in 0..200 {
        window.frame(Vec::new());
        if let Some(exported) = window.ui.viewer.take_export() {
            return exported;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("the export never comes");
}

fn decoded(exported: &afterimage_view::Exported) -> afterimage_media::Picture {
    let bytes = std::io::Cursor::new(&exported.bytes[..]);
    afterimage_media::codec::decode(bytes, None, afterimage_media::Budget(1 << 30)).unwrap()
}

#[test]
fn the_exported_numbers_are_those_of_the_image() {
    let mut window = open("tsushima");
    settle(&mut window.ui.viewer.model);
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("scene")));
    window.frame(Vec::new());
    let file = exported(&mut window, ExportKind::Numbers);
    assert_eq!(file.name, "tsushima-scene.exr");
    let (_, image) = window.ui.viewer.model.inspected_image().unwrap();
    let numbers = texels(&image).to_floats();
    let picture = decoded(&file);
    assert_eq!((picture.width, picture.height), (SIZE.width, SIZE.height));
    assert!(numbers.iter().any(|number| number[0] > 1.0), "the scene has highlights");
    for (index, number) in numbers.iter().enumerate() {
        let (x, y) = (index as u32 % SIZE.width, index as u32 / SIZE.width);
        assert_eq!(picture.pixel(x, y), *number, "{x},{y}");
    }
}

#[test]
fn the_exported_picture_is_what_is_seen_also_where_two_are_compared() {
    let mut window = open("lynx");
    settle(&mut window.ui.viewer.model);
    window.frame(Vec::new());
    let shown = picture(&window.ui.viewer.model);
    let file = exported(&mut window, ExportKind::Picture);
    assert_eq!(file.name, "lynx.png");
    let code = |light: f32| (Transfer::Srgb.to_signal(light.into()) * 255.0).round() as i32;
    let codes = |picture: &afterimage_media::Picture, x: u32, y: u32| picture.pixel(x, y).map(code);
    let alone = decoded(&file);
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let at = (y * SIZE.width + x) as usize * 4;
            let codes = codes(&alone, x, y);
            assert!((0..3).all(|channel| codes[channel] == i32::from(shown.bytes[at + channel])), "{x},{y}");
        }
    }
    window.ui.viewer.model.set_compared(Some(CompareWith::Pipeline("caracal".into())));
    window.ui.viewer.picture.comparison = Comparison::SideBySide;
    (0..4).for_each(|_| window.frame(Vec::new()));
    let both = decoded(&exported(&mut window, ExportKind::Picture));
    assert_eq!((both.width, both.height), (2 * SIZE.width, SIZE.height));
    let middle = SIZE.height / 2;
    let halves = (0..SIZE.width).map(|x| (codes(&both, x, middle), codes(&both, x + SIZE.width, middle)));
    let differing = halves.filter(|(left, right)| (0..3).any(|c| (left[c] - right[c]).abs() > 3)).count();
    assert!(differing > SIZE.width as usize / 4, "the other half is the other pipeline: {differing}");
    assert!((0..SIZE.width).all(|x| codes(&both, x, middle)[1].abs_diff(codes(&alone, x, middle)[1]) <= 1));
}

#[test]
fn the_exported_pipeline_is_the_text_with_the_changed_values() {
    let mut window = open("lynx");
    window.ui.viewer.model.set(&Target::Parameter("lit.strength".into()), Some(Value::Float(0.31)));
    window.ui.viewer.export_pipeline();
    let file = window.ui.viewer.take_export().unwrap();
    let text = String::from_utf8(file.bytes).unwrap();
    assert!(file.name == "lynx.ron" && text.contains("strength: 0.31"), "{}: {text}", file.name);
    assert!(!window.ui.viewer.model.editor().changes().is_empty(), "an export is no save");
}

#[test]
fn a_press_outside_of_a_field_gives_the_keys_back() {
    let mut window = open("lynx");
    // The field of the search, at the top of the parameters.
    window.click(pos2(90.0, 42.0));
    window.frame(vec![Event::Text("r".into())]);
    assert!(window.ui.ctx().egui_wants_keyboard_input());
    window.key(Key::G, Modifiers::NONE);
    assert_eq!(window.ui.viewer.tabs.open, Some(Tab::Graph), "a letter is typed, and is no command");
    window.drag(PLACE, PLACE + vec2(30.0, 0.0));
    assert!(!window.ui.ctx().egui_wants_keyboard_input());
    window.key(Key::G, Modifiers::NONE);
    assert_eq!(window.ui.viewer.tabs.open, None);
}

#[test]
fn a_problem_opens_the_messages_and_its_end_what_was_open_before() {
    for before in [Some(Tab::Cost), None] {
        let mut window = open("lynx");
        window.ui.viewer.tabs.open = before;
        let good = window.ui.viewer.model.editor().text().to_owned();
        window.ui.viewer.model.edit(&good.replace("Composite(", "Compositor("));
        window.frame(Vec::new());
        assert_eq!(window.ui.viewer.tabs.open, Some(Tab::Messages));
        window.ui.viewer.model.edit(&good);
        window.frame(Vec::new());
        assert_eq!(window.ui.viewer.tabs.open, before);
    }
}

#[test]
fn a_dropped_pipeline_is_opened_and_a_file_that_is_none_changes_nothing() {
    let mut window = open("lynx");
    window.drop_file("holiday.txt");
    assert_eq!(window.ui.viewer.model.editor().project().name(), "lynx.ron");
    window.drop_file("somewhere/caracal.ron");
    assert_eq!(window.ui.viewer.model.editor().project().name(), "caracal.ron");
    settle(&mut window.ui.viewer.model);
    assert!(window.ui.viewer.model.problem().is_none());
}

#[test]
fn narrow_windows_show_the_picture_in_their_whole_width_and_the_parameters_below_it() {
    // The parts of the windows that the picture must cover, in percent.
    for (size, least) in [([390, 844], 20), ([768, 1024], 38), ([844, 390], 25)] {
        let mut window = Window::of_size(model("lynx"), size);
        for _ in 0..4 {
            window.frame(Vec::new());
        }
        let (mut covered, mut all) = (0, 0);
        for y in (4..size[1]).step_by(62) {
            for x in (4..size[0]).step_by(82) {
                window.frame(vec![Event::PointerMoved(pos2(x as f32, y as f32))]);
                covered += u32::from(window.ui.viewer.picture.pointer.is_some());
                all += 1;
            }
        }
        assert!(100 * covered > least * all, "{size:?}: {covered} of {all}");
        assert_eq!(window.ui.viewer.tabs.open, Some(Tab::Parameters), "{size:?}");
    }
}

#[test]
fn the_picture_alone_fills_the_window() {
    let mut window = open("lynx");
    let (left, right) = picture_columns(&window);
    assert!(right - left < 900.0);
    window.key(Key::H, Modifiers::NONE);
    window.frame(Vec::new());
    window.ui.viewer.picture.zoom = Some(1.0);
    (0..2).for_each(|_| window.frame(Vec::new()));
    let (left, right) = picture_columns(&window);
    assert_eq!((left, right), (0.0, WINDOW[0] as f32 - 1.0));
}

#[test]
fn a_tier_is_named_by_keys_that_are_no_commands_and_enter_saves_it() {
    let mut window = open("lynx");
    window.ui.viewer.model.set(&Target::Parameter("lit.strength".into()), Some(Value::Float(0.45)));
    window.ui.viewer.model.release();
    window.frame(Vec::new());
    let button = window.place_of("Save as tier");
    window.click(button);
    window.frame(Vec::new());
    // A click into the field does not close it.
    let field = window.place_of("The changes become a tier of this name:") + vec2(0.0, 20.0);
    window.click(field);
    for (key, letter) in [(Key::H, "h"), (Key::G, "g"), (Key::R, "r")] {
        window.frame(vec![Event::Text(letter.into())]);
        window.key(key, Modifiers::NONE);
    }
    let viewer = &window.ui.viewer;
    assert_eq!((viewer.is_bare, viewer.tabs.open, viewer.model.compared()), (false, Some(Tab::Graph), None));
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    let editor = window.ui.viewer.model.editor();
    assert_eq!((editor.tier(), editor.is_saved()), (Some("hgr"), true));
    assert!(!window.says("become a tier"));
}

#[test]
fn letters_are_commands_while_the_picture_has_the_focus_alone() {
    let mut window = open("lynx");
    // Beside the field, in the panel of the parameters.
    window.click(pos2(150.0, 320.0));
    for key in [Key::H, Key::G, Key::D] {
        window.frame(vec![Event::Text(key.name().to_lowercase())]);
        window.key(key, Modifiers::NONE);
    }
    let viewer = &window.ui.viewer;
    assert_eq!((viewer.is_bare, viewer.tabs.open, viewer.model.compared()), (false, Some(Tab::Graph), None));
    assert!(window.says("click it, or press Esc"));
    window.key(Key::Escape, Modifiers::NONE);
    window.key(Key::G, Modifiers::NONE);
    assert_eq!(window.ui.viewer.tabs.open, None);
    window.click(pos2(150.0, 320.0));
    window.click(PLACE);
    window.key(Key::G, Modifiers::NONE);
    assert_eq!(window.ui.viewer.tabs.open, Some(Tab::Graph));
    // While a question is open, no letter is a command.
    window.ui.viewer.model.set(&Target::Parameter("lit.strength".into()), Some(Value::Float(0.45)));
    window.ui.viewer.close();
    window.frame(Vec::new());
    window.key(Key::H, Modifiers::NONE);
    assert!(!window.ui.viewer.is_bare);
}

#[test]
fn a_list_is_chosen_from_by_keys_that_are_no_commands() {
    let mut window = open("tsushima");
    let list = window.place_of("no tier");
    window.click(list);
    window.frame(Vec::new());
    let comparison = window.ui.viewer.picture.comparison;
    window.key(Key::B, Modifiers::NONE);
    assert_eq!(window.ui.viewer.picture.comparison, comparison);
    window.key(Key::ArrowDown, Modifiers::NONE);
    window.key(Key::ArrowDown, Modifiers::NONE);
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    let second = window.ui.viewer.model.editor().tiers()[1].clone();
    assert_eq!(window.ui.viewer.model.editor().tier(), Some(&*second));
    // The first letter of an entry goes to it.
    let list = window.place_of(&second);
    window.click(list);
    window.frame(Vec::new());
    window.frame(vec![Event::Text("l".into())]);
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    assert_eq!(window.ui.viewer.model.editor().tier(), Some("low"));
}

/// Areas of the boxes of nodes that are shown, by their names.
fn nodes(window: &mut Window) -> Vec<(String, egui::Rect)> {
    let graph = window.ui.viewer.model.editor().graph().unwrap().clone();
    let below = |area: &egui::Rect| area.min.y > 500.0;
    let shown = window.texts();
    let of = |node: &afterimage_graph::check::GraphNode| {
        shown.iter().find(|(text, area)| *text == node.name && below(area)).cloned()
    };
    graph.nodes.iter().filter_map(of).collect()
}

#[test]
fn the_whole_graph_is_shown_and_the_wheel_never_loses_it() {
    for (name, _) in afterimage_pipelines::PIPELINES {
        let mut window = open(name);
        window.ui.viewer.tabs.open = Some(Tab::Graph);
        window.frame(Vec::new());
        let all = window.ui.viewer.model.editor().graph().unwrap().nodes.len();
        assert_eq!(nodes(&mut window).len(), all, "{name}");
    }
    let mut window = open("lynx");
    let before = nodes(&mut window);
    let (_, area) = before.iter().find(|(name, _)| name == "mips").unwrap().clone();
    let at = area.center();
    window.frame(vec![Event::PointerMoved(at)]);
    let wheel = |turn: f32| Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: vec2(0.0, turn),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    };
    (0..4).for_each(|_| window.frame(vec![wheel(60.0)]));
    (0..40).for_each(|_| window.frame(Vec::new()));
    let (_, enlarged) = nodes(&mut window).into_iter().find(|(name, _)| name == "mips").unwrap();
    assert!(enlarged.height() > 1.3 * area.height(), "{area:?} {enlarged:?}");
    assert!((enlarged.center() - at).length() < 30.0, "it stays under the pointer: {at:?} {enlarged:?}");
    for turn in [-120.0, 120.0] {
        (0..40).for_each(|_| window.frame(vec![wheel(turn)]));
        (0..40).for_each(|_| window.frame(Vec::new()));
        assert!(!nodes(&mut window).is_empty(), "{turn}");
    }
}
