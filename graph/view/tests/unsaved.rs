//! Unsaved text and values are never lost without a question.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;

use crate::support::{Window, of, parameter, render, settle};
use afterimage_graph::check::Saver;
use afterimage_graph::diagnostic::{Diagnostic, Diagnostics};
use afterimage_graph::value::Value;
use afterimage_view::{
    Checked, Comparison, Conflict, InspectedWire, Model, NewFiles, Project, Resolution, Tab, TextProject,
};
use egui::{Event, Key, Modifiers, pos2};

/// The texts of a file that is not there, and of one that cannot be read.
const GONE: &str = "";
const UNREADABLE: &str = "\0";

/// A pipeline in a file that other programs change, too.
struct Shared {
    file: Rc<RefCell<String>>,
    seen: String,
    inner: TextProject,
}

impl Project for Shared {
    fn name(&self) -> String {
        "shared.ron".into()
    }

    fn read(&mut self) -> Result<Option<String>, Diagnostics> {
        match self.file.borrow().as_str() {
            UNREADABLE => {
                let mut diagnostics = Diagnostics::default();
                diagnostics.push(Diagnostic::error("unreadable-file", "it is no text"));
                Err(diagnostics)
            }
            text => Ok((text != GONE).then(|| text.to_owned())),
        }
    }

    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        self.inner.check(text, tier)
    }

    fn has_changed(&mut self) -> bool {
        let before = std::mem::replace(&mut self.seen, self.file.borrow().clone());
        before != self.seen
    }

    fn with_saver(&self, text: &str, ask: &mut dyn FnMut(&Saver<'_>)) -> Result<(), Diagnostics> {
        self.inner.with_saver(text, ask)
    }

    fn file(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.inner.file(path)
    }

    fn has_place(&self) -> bool {
        true
    }

    fn write(&mut self, text: &str) -> Result<String, String> {
        self.file.replace(text.to_owned());
        self.seen = text.to_owned();
        Ok("shared.ron".into())
    }
}

/// The text of `lynx.ron` with other numbers.
fn lynx(strength: &str) -> String {
    let text = TextProject::built_in("lynx").unwrap().text().to_owned();
    // Without the comments at its beginning, into which a click would put the cursor.
    let text = &text[text.find("\nPipeline(").unwrap() + 1..];
    let changed = text.replace("strength: 0.15", &format!("strength: {strength}"));
    assert!(changed.contains(strength));
    changed
}

fn shared() -> (Model, Rc<RefCell<String>>) {
    let text = lynx("0.15");
    let file = Rc::new(RefCell::new(text.clone()));
    let project = Shared { file: file.clone(), seen: text.clone(), inner: TextProject::new("shared.ron", &text) };
    (of(Box::new(project)), file)
}

#[test]
fn a_typed_text_is_not_replaced_by_that_of_the_file() {
    for (resolution, strength) in [(Resolution::KeepMine, "0.3"), (Resolution::TakeFile, "0.6")] {
        let (mut model, file) = shared();
        model.edit(&lynx("0.3"));
        file.replace(lynx("0.6"));
        assert!(model.follow_files(None));
        assert_eq!(model.editor().conflict(), Some(&Conflict::Text(lynx("0.6"))));
        assert_eq!(model.editor().text(), lynx("0.3"));
        assert!(model.save(None).is_err(), "the user has not chosen yet");
        assert_eq!(*file.borrow(), lynx("0.6"));
        model.resolve(resolution);
        assert_eq!((model.editor().text(), model.editor().conflict()), (&*lynx(strength), None));
        assert_eq!(model.editor().changes().is_empty(), resolution == Resolution::TakeFile);
        model.save(None).unwrap();
        assert_eq!(*file.borrow(), lynx(strength));
        if resolution == Resolution::TakeFile {
            model.undo();
            assert_eq!(model.editor().text(), lynx("0.3"), "undo has the user's text");
        }
    }
}

#[test]
fn a_text_that_is_being_typed_counts_as_typed() {
    let (mut model, file) = shared();
    file.replace(lynx("0.6"));
    model.follow_files(Some(&lynx("0.3")));
    assert_eq!((model.editor().text(), model.editor().conflict()), (&*lynx("0.3"), Some(&Conflict::Text(lynx("0.6")))));
}

#[test]
fn a_file_that_changes_before_it_is_looked_at_is_not_overwritten() {
    let (mut model, file) = shared();
    model.edit(&lynx("0.3"));
    file.replace(lynx("0.6"));
    assert!(model.save(None).is_err());
    assert_eq!(*file.borrow(), lynx("0.6"));
    assert!(model.editor().conflict().is_some());
}

#[test]
fn a_value_that_was_changed_here_and_in_the_file_asks() {
    for (resolution, strength) in [(Resolution::KeepMine, 0.3), (Resolution::TakeFile, 0.6)] {
        let (mut model, file) = shared();
        model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
        model.release();
        file.replace(lynx("0.6"));
        model.follow_files(None);
        assert_eq!(model.editor().conflict(), Some(&Conflict::Values(vec![parameter("lit.strength")])));
        assert!(model.save(None).is_err(), "the user has not chosen yet");
        assert_eq!(*file.borrow(), lynx("0.6"));
        model.resolve(resolution);
        assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(strength)));
        model.save(None).unwrap();
        assert_eq!(*file.borrow(), lynx(&strength.to_string()));
    }
}

#[test]
fn changes_of_different_values_are_merged_without_a_question() {
    let (mut model, file) = shared();
    model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
    let other = lynx("0.15").replacen("Pipeline(", "// A comment.\nPipeline(", 1);
    file.replace(other.clone());
    model.follow_files(None);
    assert_eq!(model.editor().conflict(), None);
    model.save(None).unwrap();
    assert_eq!(*file.borrow(), other.replace("strength: 0.15", "strength: 0.3"));
    // The same value on both sides is no change any more.
    model.set(&parameter("lit.strength"), Some(Value::Float(0.6)));
    file.replace(lynx("0.6"));
    model.follow_files(None);
    assert_eq!((model.editor().conflict(), model.editor().changes().is_empty()), (None, true));
}

#[test]
fn undo_goes_back_through_controls_text_and_a_save() {
    let (mut model, file) = shared();
    settle(&mut model);
    model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
    model.release();
    model.save(None).unwrap();
    assert!(model.editor().changes().is_empty());
    model.edit(&lynx("0.6"));
    assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(0.6)));
    for strength in [0.3, 0.3, 0.15] {
        model.undo();
        assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(strength)));
        assert_eq!(render(&mut model), afterimage_view::Rendered::New);
    }
    assert!(!model.editor().changes().can_undo());
    assert_eq!(
        (model.editor().text(), model.editor().changes().is_empty()),
        (&*lynx("0.15"), false),
        "the file has 0.3"
    );
    assert_eq!(*file.borrow(), lynx("0.3"));
    for strength in [0.3, 0.3, 0.6] {
        model.redo();
        assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(strength)));
    }
}

#[test]
fn a_tier_that_was_saved_is_gone_after_undo() {
    let (mut model, _) = shared();
    model.set(&parameter("lit.strength"), Some(Value::Float(0.45)));
    model.save(Some("strong")).unwrap();
    assert_eq!(model.editor().tier(), Some("strong"));
    model.undo();
    assert_eq!((model.editor().tier(), model.editor().value("lit.strength")), (None, Some(Value::Float(0.45))));
    assert!(model.problem().is_none(), "{:?}", model.problem());
    model.redo();
    assert_eq!((model.editor().tier(), model.editor().changes().len()), (Some("strong"), 0));
}

#[test]
fn a_broken_text_can_be_saved_and_values_wait() {
    let (mut model, file) = shared();
    model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
    let broken = lynx("0.15").replace("Composite(", "Compositor(");
    model.edit(&broken);
    model.save(None).unwrap();
    assert_eq!(*file.borrow(), broken);
    assert_eq!((model.editor().changes().len(), model.editor().changes().is_text_changed()), (1, false));
    model.edit(&lynx("0.15"));
    model.save(None).unwrap();
    assert_eq!(*file.borrow(), lynx("0.3"));
}

#[test]
fn a_file_that_is_gone_is_not_saved_until_it_is_written_again() {
    let (mut model, file) = shared();
    file.replace(GONE.to_owned());
    model.follow_files(None);
    assert!(!model.editor().is_saved() && model.editor().changes().is_empty());
    assert!(model.problem().is_some_and(|problem| problem.to_string().contains("is gone")), "{:?}", model.problem());
    let mut window = window(model);
    file.replace(GONE.to_owned());
    window.ui.viewer.close();
    assert!(!window.ui.viewer.is_closing(), "the text is nowhere");
    window.key(Key::Escape, Modifiers::NONE);
    window.key(Key::S, Modifiers::COMMAND);
    assert_eq!(*file.borrow(), lynx("0.15"));
    assert!(window.ui.viewer.model.editor().is_saved() && window.ui.viewer.model.problem().is_none());
    file.replace(GONE.to_owned());
    window.ui.viewer.close();
    assert!(!window.ui.viewer.is_closing(), "also if it has gone since the last frame");
}

#[test]
fn a_file_that_cannot_be_read_is_not_replaced() {
    let (mut model, file) = shared();
    model.edit(&lynx("0.3"));
    file.replace(UNREADABLE.to_owned());
    assert!(model.save(None).is_err());
    assert_eq!((&**file.borrow(), model.editor().is_saved()), (UNREADABLE, false));
    model.follow_files(None);
    assert!(model.save(Some("strong")).is_err());
    assert_eq!((&**file.borrow(), model.editor().is_saved()), (UNREADABLE, false));
}

#[test]
fn a_pipeline_that_is_not_there_is_opened_without_the_text_of_the_one_before() {
    let (mut model, before) = shared();
    model.edit(&lynx("0.15").replace("Composite(", "Compositor("));
    assert!(model.problem().is_some(), "the text has errors");
    let file = Rc::new(RefCell::new(GONE.to_owned()));
    let inner = TextProject::new("shared.ron", "");
    model.open(Box::new(Shared { file: file.clone(), seen: GONE.into(), inner }));
    assert!(model.problem().is_some_and(|problem| problem.to_string().contains("there is no file")));
    assert!(model.save(None).is_err(), "there is no text, with errors or without");
    file.replace(lynx("0.6"));
    model.follow_files(None);
    assert!(model.problem().is_none(), "{:?}", model.problem());
    assert_eq!(model.editor().value("lit.strength"), Some(Value::Float(0.6)));
    assert_eq!(*before.borrow(), lynx("0.15"));
}

/// A window on a built-in pipeline with a changed value.
fn changed_built_in(name: &str) -> Window {
    let mut model = of(Box::new(TextProject::built_in(name).unwrap()));
    model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
    model.release();
    assert!(model.save(None).is_err() && !model.editor().is_saved(), "it has no file");
    window(model)
}

#[test]
fn a_built_in_pipeline_is_saved_into_a_file_that_the_user_names() {
    let mut window = changed_built_in("lynx");
    window.key(Key::S, Modifiers::COMMAND);
    assert!(window.disk.borrow().is_empty() && !window.ui.viewer.model.editor().is_saved());
    window.key(Key::Escape, Modifiers::NONE);
    window.ui.viewer.close();
    window.frame(Vec::new());
    assert!(!window.ui.viewer.is_closing(), "it is in no file");
    window.key(Key::Escape, Modifiers::NONE);
    window.key(Key::S, Modifiers::COMMAND);
    // Closing waits for the name.
    window.ui.viewer.close();
    window.frame(vec![Event::Text("-mine.ron".into())]);
    window.key(Key::Enter, Modifiers::NONE);
    let (name, text) = window.disk.borrow().first_key_value().map(|(name, text)| (name.clone(), text.clone())).unwrap();
    assert!(name.ends_with("lynx.ron-mine.ron") && text.contains("strength: 0.3"), "{name}");
    assert_eq!(window.ui.viewer.model.editor().project().name(), name);
    assert!(window.ui.viewer.model.editor().is_saved() && window.ui.viewer.is_closing());
}

#[test]
fn a_pipeline_with_a_file_is_saved_as_another_one_and_the_first_stays() {
    let mut window = Window::new(crate::support::model("lynx"));
    window.frame(Vec::new());
    window.ui.viewer.model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
    window.key(Key::S, Modifiers::COMMAND | Modifiers::SHIFT);
    assert!(window.disk.borrow().is_empty() && !window.ui.viewer.model.editor().is_saved());
    window.frame(Vec::new());
    window.frame(vec![Event::Text("-second.ron".into())]);
    window.key(Key::Enter, Modifiers::NONE);
    let files: Vec<(String, String)> = window.disk.borrow().clone().into_iter().collect();
    assert_eq!(files.len(), 1);
    assert!(files[0].0.ends_with("lynx.ron-second.ron") && files[0].1.contains("strength: 0.3"), "{files:?}");
    assert_eq!(window.ui.viewer.model.editor().project().name(), files[0].0);
    assert!(window.ui.viewer.model.editor().is_saved());
}

#[test]
fn the_file_of_a_built_in_pipeline_replaces_none_and_those_that_it_names_lie_beside_it() {
    let mut window = changed_built_in("tsushima-night");
    window.disk.borrow_mut().insert("tsushima-night.ron".into(), "mine".into());
    window.key(Key::S, Modifiers::COMMAND);
    window.key(Key::Enter, Modifiers::NONE);
    assert_eq!(window.disk.borrow().len(), 1);
    assert!(!window.ui.viewer.model.editor().is_saved(), "a file of this name is there");
    window.frame(vec![Event::Text(".ron".into())]);
    window.key(Key::Enter, Modifiers::NONE);
    let disk = window.disk.borrow();
    let names: Vec<&str> = disk.keys().map(String::as_str).collect();
    assert_eq!(names, ["tsushima-night.ron", "tsushima-night.ron.ron", "tsushima.ron"]);
    assert_eq!(disk["tsushima-night.ron"], "mine");
    assert!(window.ui.viewer.model.editor().is_saved());
}

#[test]
fn a_page_saves_by_a_download_and_not_if_there_is_none() {
    let (disk, is_refused) = (Rc::new(RefCell::new(String::new())), Rc::new(Cell::new(true)));
    let (stored, refused) = (disk.clone(), is_refused.clone());
    let make = move |path: &std::path::Path, _| {
        let (stored, refused) = (stored.clone(), refused.clone());
        let store = move |_: &str, text: &str| match refused.get() {
            true => Err("the browser refuses".into()),
            false => Ok(stored.replace(text.to_owned())),
        };
        let project = TextProject::new(&path.to_string_lossy(), "").stored_by(Box::new(store));
        Ok(Box::new(project) as Box<dyn Project>)
    };
    let mut model = of(Box::new(TextProject::built_in("lynx").unwrap()));
    model.set(&parameter("lit.strength"), Some(Value::Float(0.3)));
    model.release();
    let mut window = Window::with_new_files(model, NewFiles::Downloaded(Box::new(make)));
    window.key(Key::S, Modifiers::COMMAND);
    assert!(disk.borrow().is_empty() && !window.ui.viewer.model.editor().is_saved());
    is_refused.set(false);
    for strength in [0.3, 0.6] {
        window.ui.viewer.model.set(&parameter("lit.strength"), Some(Value::Float(strength)));
        window.key(Key::S, Modifiers::COMMAND);
        assert!(disk.borrow().contains(&format!("strength: {strength}")) && window.ui.viewer.model.editor().is_saved());
    }
    assert_eq!(window.ui.viewer.model.editor().project().name(), "lynx.ron");
}

fn window(model: Model) -> Window {
    let mut window = Window::new(model);
    for _ in 0..4 {
        window.frame(Vec::new());
    }
    window
}

/// A place in the text, below the tabs.
const TEXT: egui::Pos2 = pos2(420.0, 560.0);

/// Types a letter, as a keyboard does.
fn type_letter(window: &mut Window, key: Key) {
    let text = Event::Text(key.name().to_lowercase());
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
    window.frame(vec![event(true), text]);
    window.frame(vec![event(false)]);
}

/// Longer than the text waits for the next key.
fn pause(window: &mut Window) {
    for _ in 0..30 {
        window.frame(Vec::new());
    }
}

fn typing() -> (Window, Rc<RefCell<String>>) {
    let (model, file) = shared();
    let mut window = window(model);
    window.ui.viewer.tabs.open = Some(Tab::Text);
    window.frame(Vec::new());
    window.click(TEXT);
    (window, file)
}

#[test]
fn an_error_in_the_text_does_not_take_the_keyboard_from_it() {
    let (mut window, _) = typing();
    type_letter(&mut window, Key::X);
    pause(&mut window);
    assert!(window.ui.viewer.model.problem().is_some(), "a letter more is an error");
    let comparison = window.ui.viewer.picture.comparison;
    for key in [Key::D, Key::K, Key::H] {
        type_letter(&mut window, key);
    }
    pause(&mut window);
    assert!(window.ui.viewer.model.editor().text().contains("xdkh"), "{}", window.ui.viewer.model.editor().text());
    assert_eq!(window.ui.viewer.picture.comparison, comparison);
    assert_ne!(comparison, Comparison::Difference);
    assert_eq!((window.ui.viewer.tabs.open, window.ui.viewer.is_bare), (Some(Tab::Text), false));
}

#[test]
fn undo_in_the_text_is_that_of_the_controls() {
    let (mut window, _) = typing();
    let strength = parameter("lit.strength");
    window.ui.viewer.model.set(&strength, Some(Value::Float(0.3)));
    window.ui.viewer.model.release();
    type_letter(&mut window, Key::X);
    pause(&mut window);
    window.key(Key::Z, Modifiers::COMMAND);
    assert_eq!(window.ui.viewer.model.editor().text(), lynx("0.15"));
    assert_eq!(window.ui.viewer.model.editor().value("lit.strength"), Some(Value::Float(0.3)));
    window.key(Key::Z, Modifiers::COMMAND);
    assert_eq!(window.ui.viewer.model.editor().value("lit.strength"), Some(Value::Float(0.15)));
    window.key(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
    window.key(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
    pause(&mut window);
    assert!(window.ui.viewer.model.problem().is_some(), "the letter is back");
}

#[test]
fn closing_and_opening_ask_while_a_text_is_not_saved() {
    let (mut window, file) = typing();
    type_letter(&mut window, Key::X);
    // Before the text is tried: it is typed, and would be lost.
    window.ui.viewer.close();
    assert!(!window.ui.viewer.is_closing());
    window.key(Key::Escape, Modifiers::NONE);
    window.drop_file("somewhere/caracal.ron");
    assert_eq!(window.ui.viewer.model.editor().project().name(), "shared.ron", "the question is open");
    window.key(Key::Escape, Modifiers::NONE);
    window.key(Key::S, Modifiers::COMMAND);
    assert_eq!(*file.borrow(), window.ui.viewer.model.editor().text(), "with its error");
    window.drop_file("somewhere/caracal.ron");
    assert_eq!(window.ui.viewer.model.editor().project().name(), "caracal.ron");
    window.ui.viewer.close();
    assert!(window.ui.viewer.is_closing());
}

#[test]
fn a_wire_whose_plan_is_made_compiles_and_a_skipped_one_is_made_by_no_pass() {
    let mut model = of(Box::new(TextProject::built_in("tsushima").unwrap()));
    settle(&mut model);
    assert!(!model.inspector().is_compiling());
    model.inspect_wire(Some(InspectedWire::new("vignette.result")));
    assert!(model.inspected_image().is_none() && model.inspector().is_compiling());
    settle(&mut model);
    assert!(model.inspected_image().is_some());
    let vignette = afterimage_view::Target::Node("vignette".into());
    model.set(&vignette, Some(Value::Bool(false)));
    while model.inspector().is_compiling() {
        render(&mut model);
    }
    assert!(model.inspected_image().is_none());
}
