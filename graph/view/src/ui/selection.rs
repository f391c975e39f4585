//! The graph among the other panels: they follow the node that is selected in it.

use egui::{Context, Ui};

use super::Viewer;
use super::graph::Thumbnails;
use super::tabs::Tab;

impl Viewer {
    pub(super) fn show_graph(&mut self, ui: &mut Ui) {
        let thumbnails = Thumbnails { painter: &self.painter, view: &self.picture, ranges: &self.fault_search };
        let message = self.graph.show(ui, &mut self.model, thumbnails);
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

    /// True while the graph shows what wires carry.
    pub(super) fn shows_thumbnails(&self) -> bool {
        self.graph.shows_thumbnails && self.tabs.open == Some(Tab::Graph) && !self.is_bare
    }

    /// The switch of the small pictures of wires, for which all images are stored.
    pub(super) fn thumbnails_button(&mut self, ui: &mut Ui) {
        ui.toggle_value(&mut self.graph.shows_thumbnails, "Thumbnails")
            .on_hover_text("What each wire carries, in the box that makes it. Every image is stored meanwhile.");
    }

    /// Other panels go to a node that was selected.
    pub(super) fn follow_selection(&mut self) {
        if let Some(node) = self.graph.take_new_selection() {
            self.text.reveal();
            self.parameters.reveal(node);
        }
    }
}
