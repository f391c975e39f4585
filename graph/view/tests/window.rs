//! The whole viewer, driven by events and drawn into a texture.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
#![allow(dead_code, reason = "each test program uses a part of the support")]

mod support;

use afterimage_graph::value::Value;
use afterimage_view::{Beside, Comparison, Tab, Tap, Target};
use egui::{Event, Key, Modifiers, pos2, vec2};
use support::{WINDOW, Window, model};

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
    assert!(window.stage.viewer.model.clock().is_playing);
    window.key(Key::Space, Modifiers::NONE);
    assert!(!window.stage.viewer.model.clock().is_playing);
    for (key, tab) in [(Key::T, Tab::Text), (Key::K, Tab::Cost), (Key::M, Tab::Messages), (Key::G, Tab::Graph)] {
        window.key(key, Modifiers::NONE);
        assert_eq!(window.stage.viewer.tab, Some(tab), "{key:?}");
    }
    window.key(Key::R, Modifiers::NONE);
    assert_eq!(window.stage.viewer.model.beside(), Some(&Beside::Reference));
    for (key, mode) in [(Key::B, Comparison::Beside), (Key::D, Comparison::Difference), (Key::W, Comparison::Wipe)] {
        window.key(key, Modifiers::NONE);
        assert_eq!(window.stage.viewer.picture.comparison, mode);
    }
    window.key(Key::Num1, Modifiers::NONE);
    assert_eq!(window.stage.viewer.picture.zoom, Some(1.0));
    window.key(Key::F, Modifiers::NONE);
    assert_eq!(window.stage.viewer.picture.zoom, None);
    window.stage.viewer.model.set_tap(Some(Tap::new("scene")));
    window.key(Key::Escape, Modifiers::NONE);
    assert!(window.stage.viewer.model.tap().is_none());
}

#[test]
fn keys_undo_redo_and_save() {
    let mut window = open("lynx");
    let strength = Target::Parameter("lit.strength".into());
    window.stage.viewer.model.set(&strength, Some(Value::Float(0.31)));
    window.stage.viewer.model.release();
    window.key(Key::Z, Modifiers::COMMAND);
    assert!(window.stage.viewer.model.changes().is_empty());
    window.key(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
    assert_eq!(window.stage.viewer.model.value("lit.strength"), Some(Value::Float(0.31)));
    window.key(Key::S, Modifiers::COMMAND);
    assert!(window.stage.viewer.model.project().text().contains("strength: 0.31"));
    assert!(window.stage.viewer.model.changes().is_empty());
}

#[test]
fn a_drag_moves_the_picture_and_a_wheel_enlarges_what_is_under_the_pointer() {
    let mut window = open("lynx");
    window.frame(vec![Event::PointerMoved(PLACE)]);
    window.frame(Vec::new());
    let under = window.stage.viewer.picture.pointer.unwrap();
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
    let zoom = window.stage.viewer.picture.zoom.unwrap();
    assert!(zoom > 8.0, "{zoom}");
    let still = window.stage.viewer.picture.pointer.unwrap();
    assert!((0..2).all(|axis| (under[axis] - still[axis]).abs() < 0.01), "{under:?} {still:?}");
    window.drag(PLACE, PLACE + vec2(80.0, 0.0));
    let moved = window.stage.viewer.picture.pointer.unwrap();
    assert!((0..2).all(|axis| (under[axis] - moved[axis]).abs() < 0.02), "{under:?} {moved:?}");
    assert_eq!(window.stage.viewer.picture.zoom, Some(zoom));
}

#[test]
fn the_line_of_a_wipe_is_dragged_and_both_pictures_are_shown() {
    let mut window = open("lynx");
    let model = &mut window.stage.viewer.model;
    model.set(&Target::Parameter("lit.strength".into()), Some(Value::Float(1.0)));
    model.set_beside(Some(Beside::Written));
    (0..6).for_each(|_| window.frame(Vec::new()));
    let before = window.stage.viewer.picture.wipe;
    assert!((before - 0.5).abs() < 1e-6);
    // The picture lies between the panels, whose widths are those of the first frame.
    let (left, right) = picture_columns(&window);
    let line = pos2((left + right) / 2.0, PLACE.y);
    window.drag(line, line - vec2(100.0, 0.0));
    let after = window.stage.viewer.picture.wipe;
    let wanted = 0.5 - 100.0 / (right - left);
    assert!((after - wanted).abs() < 0.02, "{after} {wanted}");
}

/// The columns between which the picture is shown: what surrounds it has a grey of its own.
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
    window.stage.viewer.shows_probe = true;
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
