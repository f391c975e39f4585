//! Keys of the graph, while it has the focus.

use afterimage_graph::check::{Edit, Graph, Reader};
use afterimage_graph::value::Value;
use egui::{EventFilter, Key, Modifiers, Pos2, Ui};

use super::drawing::rect;
use super::layout::{Item, Placed};
use super::menu::Menu;
use super::wire::wired_inputs;
use super::{GraphPanel, field};
use crate::model::{InspectedWire, Model, Target};

impl GraphPanel {
    /// Runs the commands of pressed keys. Returns the reason if one is not possible.
    pub(super) fn keys(&mut self, ui: &Ui, model: &mut Model, graph: &Graph) -> Option<String> {
        if !Self::has_focus(ui.ctx()) || self.is_busy() {
            return None;
        }
        let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(field(), filter));
        let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        for (key, step) in [
            (Key::ArrowLeft, (-1.0, 0.0)),
            (Key::ArrowRight, (1.0, 0.0)),
            (Key::ArrowUp, (0.0, -1.0)),
            (Key::ArrowDown, (0.0, 1.0)),
        ] {
            if pressed(key) {
                self.go(graph, step);
            }
        }
        let at =
            |item: Item| self.to_window * self.placed_at(item).map_or(Pos2::ZERO, |placed| rect(placed).left_bottom());
        if pressed(Key::A) {
            let place = ui.max_rect().left_top();
            return self.open(Menu::add(place, model));
        }
        let node = self.selected.clone()?;
        let (index, found) = graph.node(&node)?;
        let place = at(Item::Node(index));
        if pressed(Key::F2) {
            self.menu = Some(Menu::rename(place, &node));
        } else if pressed(Key::Space) {
            self.menu = Some(Menu::node(place, &node));
        } else if pressed(Key::I) {
            let (port, _) = wired_inputs(found).next()?;
            let reader = Reader::input(&node, &found.kind().inputs()[port].name);
            return self.open(Menu::insert(place, model, reader));
        } else if pressed(Key::Enter) {
            let output = found.kind().outputs().first()?;
            model.inspect_wire(Some(InspectedWire::new(format!("{node}.{}", output.name))));
        } else if pressed(Key::D) {
            let is_on = model.editor().is_on(&node);
            model.set(&Target::Node(node), Some(Value::Bool(!is_on)));
            model.release();
        } else if pressed(Key::Delete) || pressed(Key::Backspace) {
            return self.edit(model, &Edit::Remove { node });
        }
        None
    }

    fn placed_at(&self, item: Item) -> Option<&Placed> {
        self.placed.iter().find(|placed| placed.item == item)
    }

    /// Selects the nearest node in a direction.
    fn go(&mut self, graph: &Graph, (x, y): (f32, f32)) {
        let present = self.selected.as_deref().and_then(|name| graph.node(name)).map(|(index, _)| Item::Node(index));
        let Some(from) = present.and_then(|item| self.placed_at(item)).map(|placed| rect(placed).center()) else {
            return self.select(graph.nodes.first().map(|node| node.name.clone()));
        };
        let nodes = self.placed.iter().filter_map(|placed| match placed.item {
            Item::Node(node) => Some((node, rect(placed).center() - from)),
            Item::Input(_) | Item::Output(_) => None,
        });
        // Twice as far aside is as near as once ahead.
        let ahead = nodes.filter_map(|(node, way)| {
            let (along, aside) = (way.x * x + way.y * y, (way.x * y).abs() + (way.y * x).abs());
            (along > 1.0).then_some((node, along + 2.0 * aside))
        });
        if let Some((node, _)) = ahead.min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            self.select(Some(graph.nodes[node].name.clone()));
        }
    }
}
