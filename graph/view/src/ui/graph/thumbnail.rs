//! Small pictures of what wires carry, in the boxes of what makes them.

use afterimage_graph::check::Source;
use egui::{Rect, Ui};

use super::super::fault_search::FaultSearch;
use super::super::picture::{PictureView, Subject, paint, size_of};
use super::super::theme::FIELD;
use super::drawing::{Drawing, ROW};
use super::layout::{THUMBNAIL, has_image};
use super::wire::wire_name;
use crate::model::InspectedWire;
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

impl Drawing<'_> {
    /// Draws what a wire carries at the bottom of a box: of a pyramid the first level, of a volume the middle slice. The
    /// place stays empty while there is no image.
    pub(super) fn thumbnail(&self, ui: &Ui, rect: Rect, source: Source) {
        let Some(thumbnails) = self.thumbnails.filter(|_| has_image(self.graph.port_type(source))) else { return };
        let area = rect.with_min_y(rect.max.y - THUMBNAIL * ROW).shrink(MARGIN);
        ui.painter().rect_filled(area, 2.0, FIELD);
        let mut wire = InspectedWire::new(wire_name(self.graph, source));
        let Some((image, _)) = self.model.wire_image(&wire) else { return };
        wire.slice = image.desc.size.depth / 2;
        let Some((name, subject)) = Subject::of_wire(self.model, &wire) else { return };
        let size = size_of(&subject);
        let area = Rect::from_center_size(area.center(), size * (area.size() / size).min_elem());
        let to_window = ui.ctx().layer_transform_to_global(ui.layer_id()).unwrap_or_default();
        let in_window = (to_window * area) * ui.pixels_per_point();
        let placement = thumbnails.view.thumbnail(&subject, thumbnails.ranges.range(&name), in_window);
        let shown = Shown { image: &subject.image, other: None, placement };
        paint(ui, area, thumbnails.painter.drawn(&shown));
    }
}
