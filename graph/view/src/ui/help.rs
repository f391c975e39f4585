//! The sheet of keys.

use egui::{Grid, RichText};

use super::theme::ACCENT;

const KEYS: &[(&str, &str)] = &[
    ("Space", "play and pause"),
    (".", "one frame further"),
    ("I, O", "the first and the last frame that are played; again: all"),
    ("C", "a cut: histories and adaptation start again"),
    ("F, double click", "fit the picture into the window"),
    ("1", "a pixel of the picture is a pixel of the screen"),
    ("wheel, drag", "enlarge, and move the picture"),
    ("W, B, D", "compare by a wipe, side by side, by the difference"),
    ("R", "compare with the 32-bit reference"),
    ("Ctrl+1, Alt+1, Ctrl+Alt+1", "take snapshot A, compare with it, go back to it; 2 for B"),
    ("E", "measure the difference from the compared picture"),
    ("S, P", "scopes; the pixel under the pointer at every node (a click pins it)"),
    ("G, T, K, M", "the tabs Graph, Text, Cost and Messages"),
    ("H", "the picture alone, without panels"),
    ("Esc", "from an intermediate image back to the result"),
    ("in the graph", "arrows select a node, Enter shows its result, Space opens its menu"),
    ("F2, Del, D, I, A", "there: rename, delete, disable, insert before it, add a node"),
    ("Shift while a wire is dragged", "it is that of the frame before; Esc lets it go"),
    ("Ctrl+Space", "in the text: what can be written at the cursor"),
    ("Ctrl+F", "find in the text, while its tab is open"),
    ("Ctrl+Z, Ctrl+Shift+Z", "undo, redo"),
    ("Ctrl+S, Ctrl+Shift+S", "save, save as a new file"),
    ("Ctrl+E", "export the picture as PNG"),
    ("Ctrl+Q", "close the window"),
    ("F1", "this sheet"),
];

/// Shows the sheet in a window.
pub(super) fn show(ctx: &egui::Context, is_open: &mut bool) {
    egui::Window::new("Keys").open(is_open).collapsible(false).resizable(false).scroll(true).show(ctx, |ui| {
        Grid::new("keys").num_columns(2).spacing([24.0, 6.0]).show(ui, |ui| {
            for (key, what) in KEYS {
                ui.label(RichText::new(*key).monospace().color(ACCENT));
                ui.label(*what);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.label("Letters are commands while the picture has the focus: after a click on it, or Esc.");
        ui.label("A name in the parameters: a double click goes back to the value of the file.");
        ui.label("“new plan” after a control: the old picture stays until the plan is ready.");
        ui.label("An output in the graph: a click shows what it carries; a second click goes back; a drag wires it.");
        ui.label(
            "A wire in the graph: a click lists the nodes that fit on it. The right button opens the menu of a node.",
        );
    });
}
