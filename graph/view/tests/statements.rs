//! The window states what is true.

use crate::support::{Window, flat, model, of, parameter, picture, render, settle, texels};
use afterimage_graph::check::Fact;
use afterimage_graph::value::Value;
use afterimage_view::{CompareWith, InspectedWire, PipelineInstance, Subject, Tab, TextProject};

fn open(name: &str) -> Window {
    let mut window = Window::new(model(name));
    frames(&mut window);
    window
}

/// Draws until the plan is there, and a few frames more.
fn frames(window: &mut Window) {
    settle(&mut window.ui.viewer.model);
    (0..4).for_each(|_| window.frame(Vec::new()));
}

#[test]
fn a_time_is_that_of_a_whole_frame_and_none_is_no_lack_of_timestamps() {
    let mut window = open("lynx");
    window.ui.viewer.tabs.open = Some(Tab::Cost);
    assert!(window.says("No whole frame is timed yet") || window.says("ms a frame, median of"));
    assert!(!window.says("no timestamps"));
    let shown = |window: &Window| window.ui.viewer.model.shown().and_then(PipelineInstance::pass_times).cloned();
    let slide = |window: &mut Window| {
        for index in 0..12 {
            // The clock stands: each frame runs the passes that the value reaches.
            window.ui.viewer.model.set(&parameter("lit.strength"), Some(Value::Float(0.1 + f64::from(index) * 0.01)));
            window.frame(Vec::new());
            let _ = crate::support::gpu().wait();
        }
        shown(window)
    };
    let first = slide(&mut window);
    assert_eq!(slide(&mut window), first, "no whole frame was timed since");
    for _ in 0..12 {
        window.ui.viewer.model.clock().step();
        window.frame(Vec::new());
        let _ = crate::support::gpu().wait();
    }
    assert_ne!(shown(&window), first);
    assert!(window.says("ms a frame, median of") && !window.says("GPU 0.000 ms"));
}

#[test]
fn times_are_those_of_the_plan_that_is_shown() {
    let mut window = open("lynx");
    window.ui.viewer.tabs.open = Some(Tab::Cost);
    for _ in 0..12 {
        window.ui.viewer.model.clock().step();
        window.frame(Vec::new());
        let _ = crate::support::gpu().wait();
    }
    assert!(window.says("ms a frame"));
    window.ui.viewer.model.open(Box::new(TextProject::built_in("caracal").unwrap()));
    settle(&mut window.ui.viewer.model);
    window.frame(Vec::new());
    assert!(!window.says("ms a frame"), "those were times of another pipeline");
}

#[test]
fn as_saved_is_the_file_also_after_a_save_that_was_undone() {
    let mut model = model("lynx");
    model.set(&parameter("lit.strength"), Some(Value::Float(1.0)));
    settle(&mut model);
    let strong = picture(&model);
    model.save(None).unwrap();
    model.undo();
    model.undo();
    assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(0.15)));
    model.set_compared(Some(CompareWith::Written));
    model.clock().cut();
    settle(&mut model);
    let saved = texels(model.compared_picture().unwrap());
    assert!(crate::support::apart(&saved, &strong) <= 1, "the file has the strong bloom");
    assert!(crate::support::apart(&picture(&model), &strong) > 5);
}

#[test]
fn a_wire_without_an_image_shows_none() {
    let mut window = open("tsushima");
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("metered.result")));
    frames(&mut window);
    assert!(Subject::of(&window.ui.viewer.model).is_none() && window.says("A value has no image"));
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("vignette.result")));
    frames(&mut window);
    assert!(Subject::of(&window.ui.viewer.model).is_some());
    window.ui.viewer.model.set(&afterimage_view::Target::Node("vignette".into()), Some(Value::Bool(false)));
    while window.ui.viewer.model.inspector().is_compiling() {
        window.frame(Vec::new());
    }
    frames(&mut window);
    assert!(Subject::of(&window.ui.viewer.model).is_none());
    assert!(window.says("No pass of the plan makes it"), "{:?}", window.texts());
    window.ui.viewer.model.inspect_wire(None);
    frames(&mut window);
    assert!(Subject::of(&window.ui.viewer.model).is_some());
}

#[test]
fn panels_state_that_they_show_an_earlier_text() {
    const NOTE: &str = "The text has errors: this is the last one without.";
    let mut window = open("lynx");
    window.ui.viewer.tabs.open = Some(Tab::Graph);
    assert!(!window.says(NOTE));
    let good = window.ui.viewer.model.editor().text().to_owned();
    window.ui.viewer.model.edit(&good.replace("Composite(", "Compositor("));
    frames(&mut window);
    window.ui.viewer.tabs.open = Some(Tab::Graph);
    let notes =
        |window: &mut Window| window.texts().iter().filter(|(text, _)| text.starts_with("The text has")).count();
    assert_eq!(notes(&mut window), 2, "of the graph and of the parameters");
    window.ui.viewer.model.edit(&good);
    frames(&mut window);
    window.ui.viewer.tabs.open = Some(Tab::Graph);
    assert_eq!(notes(&mut window), 0);
}

#[test]
fn a_click_on_a_pyramid_states_the_level() {
    let mut window = open("lynx");
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("mips.result")));
    frames(&mut window);
    assert!(window.says("level 1 of 2"));
    window.ui.viewer.model.inspect_wire(Some(InspectedWire { index: 1, ..InspectedWire::new("mips.result") }));
    frames(&mut window);
    assert!(window.says("level 2 of 2"));
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("exposed.result")));
    frames(&mut window);
    assert!(!window.says("level "));
}

#[test]
fn nodes_that_are_skipped_say_so_in_the_parameters() {
    let mut window = open("lynx");
    let skipped = |window: &mut Window| window.texts().iter().filter(|(text, _)| text.starts_with("skipped: ")).count();
    let before = skipped(&mut window);
    assert_eq!(window.ui.viewer.model.skip_reason("bright"), None);
    window.ui.viewer.model.set_fact("emissive", Some(Fact::Flag(false)));
    frames(&mut window);
    assert!(window.ui.viewer.model.skip_reason("bright").is_some());
    assert!(skipped(&mut window) > before + 2, "the bloom is not computed");
}

#[test]
fn an_image_with_nan_is_not_called_right() {
    let mut window = Window::new(of(Box::new(TextProject::built_in("lynx").unwrap())));
    window.ui.viewer.tabs.open = Some(Tab::Messages);
    let nan = flat("wrong.exr", || Ok([f32::NAN, 0.5, 0.5, 1.0]));
    window.ui.viewer.model.set_input(None, Some(nan)).unwrap();
    frames(&mut window);
    assert!(!window.says("Nothing is wrong") && window.says("12900 NaN, 0 infinite, 0 negative"));
    window.ui.viewer.model.set_input(None, None).unwrap();
    frames(&mut window);
    assert!(window.says("Nothing is wrong"));
}

#[test]
fn the_pixel_inspector_begins_with_the_input_and_follows_the_chain_without_tables() {
    let mut window = open("tsushima");
    window.ui.viewer.inspects_pixels = true;
    window.ui.viewer.shows_scopes = false;
    window.ui.viewer.picture.inspected_place = Some([0.5, 0.5]);
    window.ui.viewer.picture.is_pinned = true;
    frames(&mut window);
    for _ in 0..200 {
        window.ui.viewer.model.clock().step();
        window.frame(Vec::new());
        let _ = crate::support::gpu().wait();
        if window.ui.viewer.pixel_names().len() > 3 {
            break;
        }
    }
    let names = window.ui.viewer.pixel_names();
    assert_eq!(names.first().copied(), Some("scene"), "{names:?}");
    assert!(names.iter().all(|name| !name.ends_with(".table")), "{names:?}");
    let place =
        |node: &str| names.iter().position(|name| name.starts_with(node)).unwrap_or_else(|| panic!("{names:?}"));
    for (before, after) in [("exposed.", "lit."), ("bloom", "lit."), ("lit.", "encoded."), ("encoded.", "display.")] {
        assert!(place(before) < place(after), "{before} {after}: {names:?}");
    }
}

#[test]
fn words_find_a_parameter_by_what_its_node_reads() {
    let mut window = open("lynx");
    let field = window.place_of("Find a parameter");
    window.click(field);
    window.frame(vec![egui::Event::Text("bloom strength".into())]);
    window.frame(Vec::new());
    assert!(window.says("strength") && window.says("Composite"));
    assert!(!window.says("threshold"), "it has another name");
    assert_eq!(render(&mut window.ui.viewer.model), afterimage_view::Rendered::Same);
}

#[test]
fn the_time_bar_has_the_number_of_the_frame() {
    let mut window = open("lynx");
    assert!(window.says("frame 0"));
    (0..3).for_each(|_| {
        window.ui.viewer.model.clock().step();
        window.frame(Vec::new());
    });
    assert!(window.says("frame 3"));
}
