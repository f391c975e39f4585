//! Files for the inputs of a pipeline.

use std::cell::Cell;
use std::rc::Rc;

use crate::support::{SIZE, Window, flat, image, model, of, picture, render, settle};
use afterimage_graph::check::GraphInput;
use afterimage_graph::node::Camera;
use afterimage_view::{InputData, InputFile, Model, Problem, TextProject};
use egui::{Event, Key, Modifiers};

fn open(name: &str) -> Window {
    let mut window = Window::new(model(name));
    (0..4).for_each(|_| window.frame(Vec::new()));
    window
}

/// What each input gets, by the names of files.
fn given(model: &Model) -> Vec<(String, String)> {
    let inputs = &model.editor().graph().unwrap().inputs;
    let of = |input: &GraphInput| Some((input.name.clone(), model.images().name(input, inputs)?.to_owned()));
    inputs.iter().filter_map(of).collect()
}

/// The input whose file has this name.
fn input_of(window: &Window, file: &str) -> Option<String> {
    given(&window.ui.viewer.model).into_iter().find(|(_, name)| name.ends_with(file)).map(|(input, _)| input)
}

fn camera() -> InputFile {
    let unit = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let camera = Camera {
        view: unit,
        projection: unit,
        previous_view: unit,
        previous_projection: unit,
        jitter: [0.0; 2],
        previous_jitter: [0.0; 2],
    };
    let data = camera.data().unwrap();
    InputFile::still("camera.json", Box::new(move |_, _| Ok(InputData::Block(data.clone()))))
}

#[test]
fn each_input_gets_its_file_and_the_scene_is_back_without_any() {
    let mut model = model("cookbook");
    settle(&mut model);
    let scene = picture(&model);
    model.set_input(None, Some(flat("photo.exr", || Ok([0.2, 0.4, 0.6, 1.0])))).unwrap();
    model.set_input(Some("depth"), Some(flat("z.exr", || Ok([3.0, 0.0, 0.0, 1.0])))).unwrap();
    model.set_input(Some("camera"), Some(camera())).unwrap();
    let names = [("scene", "photo.exr"), ("depth", "z.exr"), ("camera", "camera.json")];
    assert_eq!(given(&model), names.map(|(input, file)| (input.to_owned(), file.to_owned())));
    settle(&mut model);
    assert!(model.problem().is_none(), "{:?}", model.problem());
    let frame = model.frame_images();
    let images: Vec<&str> = frame.images.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((images, frame.blocks.len()), (vec!["scene", "depth"], 1));
    // The row of an input replaces a file that it has got as the first.
    model.set_input(Some("scene"), Some(flat("other.exr", || Ok([0.9, 0.4, 0.1, 1.0])))).unwrap();
    assert_eq!(given(&model)[0].1, "other.exr");
    for input in ["scene", "depth"] {
        model.set_input(Some(input), None).unwrap();
    }
    render(&mut model);
    assert!(model.problem().is_some_and(|problem| problem.to_string().contains("its input `scene`")));
    model.set_input(Some("camera"), None).unwrap();
    settle(&mut model);
    assert!(model.problem().is_none() && given(&model).iter().all(|(_, name)| name == "built-in scene"));
    assert_eq!(picture(&model).desc, scene.desc);
}

#[test]
fn a_file_that_cannot_be_read_leaves_the_one_before() {
    let mut model = model("lynx");
    model.set_input(None, Some(flat("photo.exr", || Ok([0.5; 4])))).unwrap();
    settle(&mut model);
    let before = picture(&model);
    let broken = flat("broken.exr", || Err(Problem::message("half a file")));
    let refused = model.set_input(None, Some(broken)).unwrap_err();
    assert!(refused.to_string().contains("half a file"), "{refused}");
    assert_eq!(given(&model)[0].1, "photo.exr");
    model.clock().cut();
    settle(&mut model);
    assert!(crate::support::apart(&picture(&model), &before) <= 1);
}

#[test]
fn frames_of_several_sequences_are_those_of_one_number() {
    let seen = Rc::new(Cell::new((0, 0)));
    let (first, second) = (seen.clone(), seen.clone());
    let colors = move |_: &GraphInput, index: usize| {
        first.set((index, first.get().1));
        Ok(image([0.5, 0.5, 0.5, 1.0]))
    };
    let depths = move |_: &GraphInput, index: usize| {
        second.set((second.get().0, index));
        Ok(image([3.0, 0.0, 0.0, 1.0]))
    };
    let mut model = model("cookbook");
    let colors = InputFile { numbers: (10..20).collect(), ..InputFile::still("c.####.exr", Box::new(colors)) };
    let depths = InputFile { numbers: vec![10, 12, 16], ..InputFile::still("z.####.exr", Box::new(depths)) };
    model.set_input(None, Some(colors)).unwrap();
    model.set_input(Some("depth"), Some(depths)).unwrap();
    for (frame, wanted) in [(2, (2, 1)), (5, (5, 1)), (9, (9, 2)), (0, (0, 0))] {
        model.clock().seek(f64::from(frame) / 24.0);
        settle(&mut model);
        assert!(model.problem().is_none(), "{:?}", model.problem());
        assert_eq!(model.images().frame_number(), Some(10 + frame));
        assert_eq!(model.images().title(), format!("c.####.exr 150x86 frame {}", 10 + frame));
        // What is on the device is not read again: the last of these is the first.
        assert!(frame == 0 || seen.get() == wanted, "{:?} {wanted:?}", seen.get());
    }
}

#[test]
fn a_dropped_file_goes_to_the_input_of_its_name_or_to_the_only_one_that_needs_it() {
    let mut window = open("cookbook");
    window.drop_file("shots/a/photo.exr");
    assert_eq!(input_of(&window, "photo.exr").as_deref(), Some("scene"));
    window.drop_file("shots/depth/shot010_normal.exr");
    assert_eq!(input_of(&window, "shot010_normal.exr").as_deref(), Some("normal"));
    assert_eq!(input_of(&window, "photo.exr").as_deref(), Some("scene"));
    window.drop_file("shots/b/other.exr");
    assert_eq!((input_of(&window, "other.exr").as_deref(), input_of(&window, "photo.exr")), (Some("scene"), None));
    // Also where the file before has the name of the input.
    window.drop_file("shots/scene.exr");
    assert_eq!((input_of(&window, "scene.exr").as_deref(), input_of(&window, "other.exr")), (Some("scene"), None));
    window.drop_file("shots/a/photo.exr");
    assert_eq!((input_of(&window, "photo.exr").as_deref(), input_of(&window, "scene.exr")), (Some("scene"), None));
    assert!(window.ui.viewer.model.images().title().starts_with("photo.exr"));
    window.frame(Vec::new());
    assert!(window.ui.viewer.model.problem().is_none(), "{:?}", window.ui.viewer.model.problem());
}

#[test]
fn a_file_that_is_dropped_on_a_row_goes_to_its_input_and_several_go_to_those_of_their_names() {
    let mut window = open("cookbook");
    // The pointer was elsewhere before: nobody tells its place while a file is dragged.
    window.frame(vec![Event::PointerMoved(egui::pos2(700.0, 250.0))]);
    let row = window.place_of("depth");
    window.drop_files(&["shots/a/0001.exr"], row);
    assert_eq!(input_of(&window, "0001.exr").as_deref(), Some("depth"));
    window.drop_files(&["shots/photo_normal.exr", "shots/photo.exr"], row);
    assert_eq!(input_of(&window, "photo_normal.exr").as_deref(), Some("normal"));
    assert_eq!(input_of(&window, "photo.exr").as_deref(), Some("scene"));
    assert_eq!(input_of(&window, "0001.exr").as_deref(), Some("depth"));
}

#[test]
fn a_file_that_several_inputs_can_take_is_asked_about_and_letters_are_no_commands_then() {
    let text = r#"Pipeline(
        inputs: { "front": Color, "back": Color },
        nodes: {
            "lit": Composite(base: "front", bloom: "back", blend: Add),
            "exposed": Exposure(source: "lit", stops: 0.0),
            "mapped": ToneMap(source: "exposed"),
            "display": Encode(source: "mapped"),
        },
        outputs: { "display": "display" },
    )"#;
    let mut window = Window::new(of(Box::new(TextProject::new("two.ron", text))));
    (0..4).for_each(|_| window.frame(Vec::new()));
    window.drop_file("something.exr");
    window.frame(Vec::new());
    assert_eq!(input_of(&window, "something.exr"), None);
    assert!(window.says("something.exr is the input:"));
    window.key(Key::H, Modifiers::NONE);
    assert!(!window.ui.viewer.is_bare);
    let buttons = window.texts();
    let (_, area) = buttons.iter().rfind(|(text, _)| text == "back").unwrap();
    window.click(area.center());
    assert_eq!(input_of(&window, "something.exr").as_deref(), Some("back"));
    window.frame(Vec::new());
    assert!(window.ui.viewer.model.problem().is_some_and(|problem| problem.to_string().contains("its input `front`")));
    window.drop_file("front.exr");
    (0..2).for_each(|_| window.frame(Vec::new()));
    assert!(window.ui.viewer.model.problem().is_none(), "{:?}", window.ui.viewer.model.problem());
    assert!(!window.says("is the input:"));
}

#[test]
fn the_path_of_a_file_is_typed_into_the_row_of_an_input_and_taken_away_by_its_button() {
    let mut window = open("lynx");
    let field = window.place_of("built-in scene");
    window.click(field);
    window.frame(vec![Event::Text("shots/mine.exr".into())]);
    window.key(Key::Enter, Modifiers::NONE);
    window.frame(Vec::new());
    assert_eq!(input_of(&window, "mine.exr").as_deref(), Some("scene"));
    window.frame(Vec::new());
    let button = window.place_of("×");
    window.click(button);
    window.frame(Vec::new());
    assert_eq!(given(&window.ui.viewer.model), [("scene".to_owned(), "built-in scene".to_owned())]);
    assert_eq!(window.ui.viewer.model.images().size(), SIZE);
}
