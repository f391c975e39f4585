//! The group of inputs: one row for each input of the pipeline, with its file.

use std::path::{Path, PathBuf};

use afterimage_graph::check::GraphInput;
use afterimage_graph::image::ColorState;
use afterimage_media::ImageFormat;
use afterimage_media::sequence::split_layer;
use egui::{ComboBox, Context, Id, Modal, RichText, Ui};

use super::controls::path_line;
use super::list_keys::choose_by_keys;
use super::new_file::FileRequest;
use super::theme::DIM;
use crate::Problem;
use crate::model::{InputFile, Model, SCENE_NAME};

/// The rows of inputs, and the question for the input of a file.
#[derive(Default)]
pub(super) struct InputPanel {
    /// The file of an input that the user has named.
    pub(super) named: Option<(String, PathBuf)>,
    /// The input whose file the user wants to choose in a dialog.
    pub(super) asked_file: Option<FileRequest>,
    /// The input whose row is under the pointer.
    hovered: Option<String>,
    /// Files that were dropped, and the time since which they are there.
    dropped: Vec<InputFile>,
    dropped_at: Option<f64>,
    /// Dropped files that several inputs can take.
    asked: Vec<InputFile>,
}

impl InputPanel {
    /// True while the user is asked for the input of a file.
    pub(super) fn asks(&self) -> bool {
        !self.asked.is_empty()
    }

    /// No row is under the pointer before one is shown there.
    pub(super) fn forget_place(&mut self) {
        self.hovered = None;
    }

    /// Shows the rows, of which `has_paths` states that a path can be typed.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, has_paths: bool) {
        let Some(graph) = model.editor().graph().cloned().filter(|graph| !graph.inputs.is_empty()) else { return };
        ui.label(RichText::new("Inputs").strong()).on_hover_text(format!(
            "Drop a file on a row, or type its path: {}, and JSON for cameras",
            ImageFormat::readable_names()
        ));
        for input in &graph.inputs {
            let row = ui.horizontal(|ui| self.row(ui, model, input, &graph.inputs, has_paths));
            if row.response.contains_pointer() {
                self.hovered = Some(input.name.clone());
            }
            self.layers(ui, model, input, &graph.inputs);
        }
        ui.separator();
    }

    fn row(&mut self, ui: &mut Ui, model: &mut Model, input: &GraphInput, inputs: &[GraphInput], has_paths: bool) {
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(egui::vec2(94.0, 20.0), layout, |ui| {
            ui.set_min_width(94.0);
            ui.add(egui::Label::new(&input.name).truncate()).on_hover_text(about(input));
        });
        let given = model.images().name(input, inputs).map(str::to_owned);
        let is_file = given.as_deref().is_some_and(|name| name != SCENE_NAME);
        let shown = if is_file { given.as_deref().unwrap_or_default() } else { "" };
        let hint = given.clone().unwrap_or_else(|| if input.optional { "nothing" } else { "needed" }.to_owned());
        if has_paths {
            if let Some(path) = path_line(ui, &input.name, shown, &hint, if is_file { 84.0 } else { 112.0 }) {
                match path.is_empty() {
                    true => clear(model, input),
                    false => self.named = Some((input.name.clone(), path.into())),
                }
            }
            if ui.small_button("…").on_hover_text("Choose a file").clicked() {
                self.asked_file = Some(FileRequest::Input { name: input.name.clone(), endings: endings(input) });
            }
        } else {
            ui.add(egui::Label::new(RichText::new(if is_file { shown } else { &hint }).color(DIM)).truncate());
        }
        if is_file && ui.small_button("×").on_hover_text("Without this file").clicked() {
            clear(model, input);
        }
        ui.label(RichText::new(type_name(input)).color(DIM).small());
    }

    /// The layers of the file of an input, if there is a choice.
    fn layers(&mut self, ui: &mut Ui, model: &Model, input: &GraphInput, inputs: &[GraphInput]) {
        let layers = model.images().layers(input, inputs);
        let Some((path, present)) = model.images().name(input, inputs).map(split_layer) else { return };
        if layers.is_empty() {
            return;
        }
        let present = present.as_deref();
        let mut chosen = present;
        ui.horizontal(|ui| {
            ui.add_space(94.0 + ui.spacing().item_spacing.x);
            let combo = ComboBox::from_id_salt(("layer", &input.name)).selected_text(present.unwrap_or(LIKELY));
            combo.width(128.0).show_ui(ui, |ui| {
                let mut entries = vec![(ui.selectable_value(&mut chosen, None, LIKELY), LIKELY)];
                for layer in layers {
                    entries.push((ui.selectable_value(&mut chosen, Some(&**layer), layer), layer));
                }
                let place = layers.iter().position(|layer| Some(&**layer) == present).map_or(0, |place| place + 1);
                choose_by_keys(ui, &entries, place);
            });
            ui.label(RichText::new("layer").color(DIM).small());
        });
        if chosen != present {
            let name = chosen.map_or(path.to_owned(), |layer| format!("{path}#{layer}"));
            self.named = Some((input.name.clone(), name.into()));
        }
    }

    /// Takes a file that was dropped, for [`give_dropped`](Self::give_dropped).
    pub(super) fn drop_file(&mut self, ctx: &Context, file: InputFile) {
        self.dropped.push(file);
        self.dropped_at = None;
        ctx.request_repaint();
    }

    /// Gives inputs the files that were dropped, once the place of the drop is known. Call it after the rows are shown.
    pub(super) fn give_dropped(&mut self, ctx: &Context, model: &mut Model) -> Option<Told> {
        if self.dropped.is_empty() {
            return None;
        }
        let now = ctx.input(|input| input.time);
        // Frames may be longer than the pause: the next one has the events after the drop.
        if now < *self.dropped_at.get_or_insert(now) + DROP_PAUSE {
            ctx.request_repaint_after_secs(DROP_PAUSE as f32);
            return None;
        }
        let files = std::mem::take(&mut self.dropped);
        // Several files have one place, and are for several inputs.
        let is_one = files.len() == 1;
        files.into_iter().filter_map(|file| self.give_to_one(model, file, is_one)).last()
    }

    /// Gives a file to an input: with a place to that under the pointer, else to the one that the name of the file has
    /// as a word, or to the only one that needs it. Otherwise the user is asked.
    pub(super) fn give_to_one(&mut self, model: &mut Model, file: InputFile, has_place: bool) -> Option<Told> {
        let inputs = model.editor().graph().map_or(Vec::new(), |graph| graph.inputs.clone());
        let fitting: Vec<&GraphInput> = inputs.iter().filter(|input| fits(input, &file.name)).collect();
        let hovered = fitting.iter().find(|input| has_place && self.hovered.as_ref() == Some(&input.name));
        let named = || fitting.iter().find(|input| is_named_in(&file.name, &input.name));
        if let Some(input) = hovered.or_else(named) {
            return Some(give(model, file, Some(&input.name)));
        }
        let needed: Vec<&&GraphInput> = fitting.iter().filter(|input| !input.optional).collect();
        match (&needed[..], &fitting[..]) {
            // It stays when another pipeline is opened, whatever that calls its image.
            ([only], _) if only.block.is_none() => Some(give(model, file, None)),
            (_, []) => Some(give(model, file, None)),
            ([only], _) => Some(give(model, file, Some(&only.name))),
            (_, [only]) => Some(give(model, file, Some(&only.name))),
            _ => {
                self.asked.push(file);
                None
            }
        }
    }

    /// Shows the question that is open.
    pub(super) fn ask(&mut self, ctx: &Context, model: &mut Model) -> Option<Told> {
        let file = self.asked.pop()?;
        let inputs = model.editor().graph().map_or(Vec::new(), |graph| graph.inputs.clone());
        let (mut chosen, mut is_left) = (None, false);
        let modal = Modal::new(Id::new("input of a file")).show(ctx, |ui| {
            ui.label(RichText::new(format!("{} is the input:", short(&file.name))).strong());
            ui.add_space(8.0);
            ui.horizontal_wrapped(|ui| {
                for input in inputs.iter().filter(|input| fits(input, &file.name)) {
                    if ui.button(&input.name).on_hover_text(about(input)).clicked() {
                        chosen = Some(input.name.clone());
                    }
                }
                is_left = ui.button("Cancel").clicked();
            });
        });
        if let Some(input) = chosen {
            return Some(give(model, file, Some(&input)));
        }
        if !is_left && !modal.should_close() {
            self.asked.push(file);
        }
        None
    }
}

/// Seconds after a drop until its place is known. While files are dragged, the desktop has the pointer, and tells
/// nobody its place; the window learns it from the first event after the drop.
const DROP_PAUSE: f64 = 0.1;

/// The message about a file: that an input has it, or why none has.
pub(super) type Told = Result<String, String>;

/// Gives an input a file.
pub(super) fn give(model: &mut Model, file: InputFile, input: Option<&str>) -> Told {
    let name = short(&file.name);
    match (model.set_input(input, Some(file)), input) {
        (Ok(()), None) => Ok(format!("Opened: {name}")),
        (Ok(()), Some(input)) => Ok(format!("{name} is the input `{input}`")),
        (Err(problem @ Problem::Message { .. }), _) => Err(format!("{name} is not shown: {problem}")),
        (Err(problem), _) => Err(problem.to_string()),
    }
}

/// Takes the file of an input away. A problem is shown with the next frame, which has no image then.
fn clear(model: &mut Model, input: &GraphInput) {
    let _ = model.set_input(Some(&input.name), None);
}

/// The entry for the layer that a file is most likely meant to show.
const LIKELY: &str = "the likely one";

/// The name without its folders.
fn short(name: &str) -> String {
    Path::new(name).file_name().map_or(name.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// The endings of the files that an input takes.
fn endings(input: &GraphInput) -> Vec<&'static str> {
    match input.block {
        Some(_) => ImageFormat::Exr.endings().iter().chain(&[JSON]).copied().collect(),
        None => ImageFormat::readable().flat_map(ImageFormat::endings).copied().collect(),
    }
}

/// The ending of files of cameras.
const JSON: &str = "json";

/// True if an input can take a file, by its ending. Images are also known by their content.
fn fits(input: &GraphInput, file: &str) -> bool {
    let ending = Path::new(split_layer(file).0).extension().unwrap_or_default().to_ascii_lowercase();
    match input.block {
        Some(_) => endings(input).iter().any(|known| ending == *known),
        None => !input.multisampled && ending != JSON,
    }
}

/// True if the name of a file has the name of an input as one of its words.
fn is_named_in(file: &str, input: &str) -> bool {
    let file = short(file).to_lowercase();
    file.split(|c: char| !c.is_alphanumeric()).any(|word| word == input.to_lowercase())
}

/// The type of an input, in a word.
fn type_name(input: &GraphInput) -> &'static str {
    match (input.block, input.state) {
        (Some(block), _) => block.name,
        (None, _) if input.multisampled => "samples",
        (None, _) if input.volume => "volume",
        (None, ColorState::Data) => "data",
        (None, _) => "color",
    }
}

/// The description of an input.
fn about(input: &GraphInput) -> String {
    let mut text = match input.block {
        Some(block) => block.doc.to_owned(),
        None => format!("An image: {}.", input.state.name()),
    };
    if input.needs_alpha {
        text += " Its alpha is a mask.";
    }
    text + if input.optional { " It may be left out." } else { "" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Project as _, TextProject};

    /// The inputs of a pipeline with an image and a camera.
    fn inputs() -> Vec<GraphInput> {
        let text = r#"Pipeline(inputs: { "image": Color, "eye": Camera }, nodes: {}, outputs: { "image": "image" })"#;
        let mut project = TextProject::new("inputs.ron", text);
        let checked = project.check(text, None).unwrap_or_else(|errors| panic!("{errors}"));
        checked.graph.inputs.clone()
    }

    #[test]
    fn the_dialog_and_a_drop_take_every_format_that_is_read() {
        let inputs = inputs();
        let [image, camera] = &inputs[..] else { panic!("{inputs:?}") };
        for name in ["a.exr", "a.hdr", "a.png", "a.jpeg", "a.tif", "a.TIFF", "a.dpx", "shot.####.exr#diffuse.R"] {
            let ending = Path::new(split_layer(name).0)
                .extension()
                .expect("a name with an ending")
                .to_string_lossy()
                .to_lowercase();
            assert!(ImageFormat::of_name(split_layer(name).0).is_some(), "{name}");
            assert!(fits(image, name) && endings(image).contains(&&*ending), "{name}");
        }
        for format in ImageFormat::ALL {
            let is_read = ImageFormat::of_name(format!("a.{}", format.endings()[0])) == Some(format);
            let is_offered = format.endings().iter().all(|ending| endings(image).contains(ending));
            assert_eq!(is_offered, is_read, "{format:?}");
            assert_eq!(ImageFormat::readable_names().contains(format.name()), is_read, "{format:?}");
        }
        for (name, has_camera) in
            [("c.json", true), ("c.JSON", true), ("c.exr", true), ("c.sxr#left", true), ("c.png", false)]
        {
            assert_eq!(fits(camera, name), has_camera, "{name}");
        }
        assert!(!fits(image, "c.json") && endings(camera).contains(&"json"));
    }

    #[test]
    fn the_name_of_a_file_tells_its_input() {
        assert!(is_named_in("/shots/a/shot010_depth.0001.exr", "depth"));
        assert!(is_named_in("Camera.json", "camera"));
        assert!(!is_named_in("/depth/photo.exr", "depth"));
        assert!(!is_named_in("indepth.exr", "depth"));
    }
}
