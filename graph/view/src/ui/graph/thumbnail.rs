//! Small pictures of what wires carry, in the boxes of what makes them.

use afterimage_graph::check::{Graph, Source};
use egui::{Rect, Ui};

use super::super::fault_search::FaultSearch;
use super::super::picture::{PictureView, Subject, paint, size_of};
use super::super::theme::FIELD;
use super::wire::wire_name;
use crate::model::{InspectedWire, Model};
use crate::render::{Painter, Shown};

/// Points between a thumbnail and the border of its box.
const MARGIN: f32 = 5.0;

/// Draws images as the picture does, data by its range.
#[derive(Clone, Copy)]
pub(in super::super) struct Thumbnails<'v> {
    pub(in super::super) painter: &'v Painter,
    pub(in super::super) view: &'v PictureView,
    pub(in super::super) ranges: &'v FaultSearch,
}

impl Thumbnails<'_> {
    /// Draws what a wire carries at the bottom of a box: of a pyramid the first level, of a volume the middle slice.
    /// The place stays empty while there is no image.
    pub(super) fn show(&self, ui: &Ui, bottom: Rect, graph: &Graph, model: &Model, source: Source) {
        let area = bottom.shrink(MARGIN);
        ui.painter().rect_filled(area, 2.0, FIELD);
        let mut wire = InspectedWire::new(wire_name(graph, source));
        let Some((image, _)) = model.wire_image(&wire) else { return };
        wire.slice = image.desc.size.depth / 2;
        let Some((name, subject)) = Subject::of_wire(model, &wire) else { return };
        let size = size_of(&subject);
        let area = Rect::from_center_size(area.center(), size * (area.size() / size).min_elem());
        let to_window = ui.ctx().layer_transform_to_global(ui.layer_id()).unwrap_or_default();
        let in_window = (to_window * area) * ui.pixels_per_point();
        let placement = self.view.thumbnail(&subject, self.ranges.range(&name), in_window);
        let shown = Shown { image: &subject.image, other: None, placement };
        paint(ui, area, self.painter.drawn(&shown));
    }
}
