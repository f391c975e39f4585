//! The graph among the other panels: they follow the node that is selected in it.

use egui::{Context, Ui};

use super::Viewer;

impl Viewer {
    pub(super) fn show_graph(&mut self, ui: &mut Ui) {
        let message = self.graph.show(ui, &mut self.model);
        self.follow_selection();
        message.into_iter().for_each(|message| self.tell(ui.ctx(), message));
    }

    /// Shows the menu of the graph that is open, over everything else.
    pub(super) fn show_graph_menu(&mut self, ctx: &Context) {
        self.graph.show_menu(ctx, &mut self.model);
        self.follow_selection();
    }

    /// The button that lists the kinds for a new node.
    pub(super) fn add_button(&mut self, ui: &mut Ui) {
        ui.separator();
        let button = ui.button("Add node…").on_hover_text("A new node, which reads the selected one if it can (A)");
        if button.clicked() {
            let message = self.graph.add(&self.model, button.rect.left_bottom());
            message.into_iter().for_each(|message| self.tell(ui.ctx(), message));
        }
    }

    /// Other panels go to a node that was selected.
    pub(super) fn follow_selection(&mut self) {
        if let Some(node) = self.graph.take_new_selection() {
            self.text.reveal();
            self.parameters.reveal(node);
        }
    }
}
