//! Files of the viewer: saved values, texts and images that change.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

use crate::support::{apart, flat, model, of, parameter, picture, render, settle};
use afterimage_gpu::Texels;
use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::{Type, Value};
use afterimage_view::{InputFile, Model, Problem, Project, Target, TextProject};

/// The first frame, as a program that is just started shows it.
fn first_frame(model: &mut Model) -> Texels {
    model.clock().cut();
    settle(model);
    model.clock().cut();
    render(model);
    picture(model)
}

/// The largest difference between two pictures of any format, in codes of 8 bits.
fn codes(a: &Texels, b: &Texels) -> f32 {
    assert_eq!(a.desc, b.desc);
    a.to_floats()
        .iter()
        .flatten()
        .zip(b.to_floats().iter().flatten())
        .map(|(a, b)| (a - b).abs() * 255.0)
        .fold(0.0, f32::max)
}

/// Other values, near the present one.
fn near(graph: &Graph, id: ParameterId) -> Vec<Value> {
    match graph.value(id) {
        Value::Float(x) => [x * 1.1 + 0.01, x * 0.9 - 0.01, x * 0.9].map(Value::Float).into(),
        Value::Vector(v, n) => [1.05, 0.95].map(|by| Value::Vector(v.map(|x| x * by), *n)).into(),
        _ => Vec::new(),
    }
}

/// Switches off the nodes whose noise is another one in every frame.
fn switch_noise_off(model: &mut Model) {
    let graph = model.editor().graph().unwrap().clone();
    for node in graph.nodes.iter().filter(|node| ["Dither", "FilmGrain"].contains(&node.kind().name())) {
        model.set(&Target::Node(node.name.clone()), Some(Value::Bool(false)));
    }
}

/// Changes every number of a pipeline that takes another value; returns how many there are.
fn change_all_numbers(model: &mut Model) -> usize {
    let graph = model.editor().graph().unwrap().clone();
    let before = model.editor().changes().len();
    for id in graph.parameters() {
        let name = graph.parameter_name(id);
        for value in near(&graph, id) {
            model.set(&parameter(&name), Some(value));
            if model.problem().is_none() {
                break;
            }
        }
    }
    model.release();
    model.editor().changes().len() - before
}

/// The present values of all parameters, by name.
fn values(model: &Model) -> Vec<(String, Value)> {
    let graph = model.editor().graph().unwrap();
    let names = graph.parameters().map(|id| graph.parameter_name(id));
    names.map(|name| (name.clone(), model.editor().value(&name).unwrap())).collect()
}

#[test]
fn a_saved_pipeline_has_the_values_that_were_set() {
    for (name, _) in afterimage_pipelines::PIPELINES {
        let mut model = model(name);
        let changed = change_all_numbers(&mut model);
        assert!(changed > 5, "{name}: {changed} numbers");
        let set = values(&model);
        model.save(None).unwrap_or_else(|problem| panic!("{name}: {problem}"));
        assert!(model.editor().changes().is_empty());
        let opened = of(Box::new(TextProject::new("saved.ron", model.editor().text())));
        assert_eq!(values(&opened), set, "{name}");
    }
}

#[test]
fn a_saved_pipeline_renders_the_same_picture() {
    let mut model = model("lynx");
    switch_noise_off(&mut model);
    let written = first_frame(&mut model);
    change_all_numbers(&mut model);
    let shown = first_frame(&mut model);
    assert!(codes(&shown, &written) > 1.0, "the changes are seen");
    model.save(None).unwrap();
    let mut opened = of(Box::new(TextProject::new("saved.ron", model.editor().text())));
    let apart = codes(&first_frame(&mut opened), &shown);
    assert!(apart <= 1.0, "{apart}");
}

#[test]
fn every_parameter_of_every_pipeline_has_a_present_value() {
    for (name, _) in afterimage_pipelines::PIPELINES {
        let mut project = TextProject::built_in(name).unwrap();
        let text = project.text().to_owned();
        let graph = project.check(&text, None).unwrap().graph;
        let model = model(name);
        for parameter in graph.parameters() {
            let name = graph.parameter_name(parameter);
            let declared = graph.declaration(parameter);
            let value = model.editor().value(&name).unwrap();
            assert!(matches!(declared.ty, Type::File) || declared.accepts(&value).is_ok(), "{name}");
        }
    }
}

#[test]
fn a_number_that_changes_in_the_text_again_needs_no_plan() {
    let with = |strength: &str| {
        let text = TextProject::built_in("lynx").unwrap().text().to_owned();
        let changed = text.replace("strength: 0.15", &format!("strength: {strength}"));
        assert_ne!(text, changed);
        changed
    };
    let mut model = model("lynx");
    let before = first_frame(&mut model);
    model.edit(&with("0.3"));
    settle(&mut model);
    let plan = model.shown().unwrap().plan().unwrap().clone();
    model.edit(&with("0.9"));
    assert!(!model.shown().unwrap().is_changing(), "the value alone is different");
    let shown = first_frame(&mut model);
    assert!(Arc::ptr_eq(&plan, model.shown().unwrap().plan().unwrap()));
    assert!(apart(&shown, &before) > 5);
    let mut opened = of(Box::new(TextProject::new("lynx.ron", &with("0.9"))));
    assert!(apart(&shown, &first_frame(&mut opened)) <= 1);
    assert_eq!(model.editor().written(&parameter("lit.strength")), Some(Value::Float(0.9)));
    // What the user has set holds, and the text returns when it is taken back.
    model.set(&parameter("lit.strength"), Some(Value::Float(0.0)));
    model.edit(&with("0.5"));
    assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(0.0)));
    let without = first_frame(&mut model);
    assert!(apart(&without, &shown) > 5);
    model.set(&parameter("lit.strength"), None);
    let mut opened = of(Box::new(TextProject::new("lynx.ron", &with("0.5"))));
    assert!(apart(&first_frame(&mut model), &first_frame(&mut opened)) <= 1);
}

#[test]
fn an_image_that_changes_is_read_again_and_a_broken_one_leaves_the_picture() {
    let (gray, is_new) = (Rc::new(Cell::new(Ok(0.2_f32))), Rc::new(Cell::new(false)));
    let (read_gray, asked) = (gray.clone(), is_new.clone());
    let read = move || {
        let level = read_gray.get().map_err(|()| Problem::message("half a file"))?;
        Ok([level, level, level, 1.0])
    };
    let file = InputFile { have_changed: Box::new(move || asked.take()), ..flat("gray.exr", read) };
    let mut model = model("lynx");
    model.set_input(None, Some(file)).unwrap();
    let dark = first_frame(&mut model);
    gray.set(Ok(0.6));
    model.follow_files(None);
    assert_eq!(apart(&first_frame(&mut model), &dark), 0, "nobody has said that it changed");
    is_new.set(true);
    model.follow_files(None);
    let light = first_frame(&mut model);
    assert!(apart(&light, &dark) > 50);
    gray.set(Err(()));
    is_new.set(true);
    model.follow_files(None);
    assert!(model.problem().unwrap().to_string().contains("half a file"));
    render(&mut model);
    assert_eq!(apart(&picture(&model), &light), 0);
}
