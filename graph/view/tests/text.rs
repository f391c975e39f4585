//! The text of the pipeline: completion, the manual of kinds, colors, and the small pictures of the graph.

use crate::support::{WINDOW, Window, model, settle};
use afterimage_view::Tab;
use egui::{Event, Key, Modifiers};

fn frames(window: &mut Window, count: usize) {
    (0..count).for_each(|_| window.frame(Vec::new()));
}

fn letters(window: &mut Window, letters: &str) {
    for letter in letters.chars() {
        window.frame(vec![Event::Text(letter.to_string())]);
    }
    frames(window, 2);
}

/// A window on a text of its own, with the cursor at its end.
fn at_the_end(text: &str) -> Window {
    let project = afterimage_view::TextProject::new("own.ron", text);
    let mut window = Window::new(crate::support::of(Box::new(project)));
    window.ui.viewer.tabs.open = Some(Tab::Text);
    frames(&mut window, 4);
    let lines = window.texts();
    let (_, area) = lines.iter().rfind(|(shown, _)| shown.contains("Pipeline(")).expect("the text is shown");
    window.click(area.left_top() + egui::vec2(20.0, 4.0));
    window.key(Key::End, Modifiers::CTRL | Modifiers::COMMAND);
    frames(&mut window, 2);
    window
}

const BEGUN: &str =
    "Pipeline(inputs: { \"scene\": Color }, nodes: { \"exposed\": Exposure(source: \"scene\"), \"new\": ";

#[test]
fn a_node_is_written_by_completion_and_its_manual_is_shown() {
    let mut window = at_the_end(BEGUN);
    letters(&mut window, "vign");
    window.key(Key::Space, Modifiers::CTRL);
    frames(&mut window, 2);
    assert!(window.texts().iter().any(|(text, _)| text.starts_with("Vignette")), "{:?}", window.texts());
    window.key(Key::Enter, Modifiers::NONE);
    frames(&mut window, 2);
    // The cursor is between the parentheses, where ports and parameters are.
    window.key(Key::Space, Modifiers::CTRL);
    letters(&mut window, "sou");
    window.key(Key::Tab, Modifiers::NONE);
    frames(&mut window, 2);
    window.key(Key::Space, Modifiers::CTRL);
    frames(&mut window, 2);
    // The image of a node comes before the input, whose type is not known while the text has errors.
    window.key(Key::ArrowDown, Modifiers::NONE);
    window.key(Key::ArrowUp, Modifiers::NONE);
    window.key(Key::Enter, Modifiers::NONE);
    assert!(window.texts().iter().any(|(text, _)| text == "Vignette"), "the manual has a title");
    letters(&mut window, ") }, outputs: { \"o\": \"new\" })");
    frames(&mut window, 40);
    let written = window.ui.viewer.model.editor().text().to_owned();
    assert!(written.ends_with("\"new\": Vignette(source: \"exposed\") }, outputs: { \"o\": \"new\" }))"), "{written}");
}

#[test]
fn the_list_closes_by_a_key_and_the_field_keeps_the_keyboard() {
    let mut window = at_the_end(BEGUN);
    window.key(Key::Space, Modifiers::CTRL);
    frames(&mut window, 2);
    // Kinds are listed with their ports.
    assert!(window.says("→"), "{:?}", window.texts());
    window.key(Key::Escape, Modifiers::NONE);
    frames(&mut window, 2);
    assert!(!window.says("→"));
    letters(&mut window, "x");
    frames(&mut window, 40);
    assert!(window.ui.viewer.model.editor().text().ends_with(": x"));
}

#[test]
fn wires_have_small_pictures_on_request() {
    let mut window = Window::new(model("lynx"));
    window.ui.viewer.tabs.open = Some(Tab::Graph);
    frames(&mut window, 4);
    settle(&mut window.ui.viewer.model);
    frames(&mut window, 4);
    // Boxes and wires have few colors; a picture has many.
    let colors = |window: &Window| {
        let texels = window.texels();
        let rows = texels.bytes.chunks_exact(4 * WINDOW[0] as usize).skip(550);
        rows.flat_map(|row| row.chunks_exact(4)).collect::<std::collections::BTreeSet<_>>().len()
    };
    let before = colors(&window);
    assert!(window.ui.viewer.model.inspector().stored().is_none());
    let button = window.place_of("Thumbnails");
    window.click(button);
    for _ in 0..600 {
        window.frame(Vec::new());
        let _ = crate::support::gpu().wait();
        if colors(&window) > 4 * before {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert!(colors(&window) > 4 * before, "{before} {}", colors(&window));
    let button = window.place_of("Thumbnails");
    window.click(button);
    frames(&mut window, 4);
    assert!(window.ui.viewer.model.inspector().stored().is_none(), "nothing is stored any longer");
    assert!(colors(&window) < 2 * before);
}
