//! The white picker: a click on a part of the picture that should be gray sets the parameters of a node.

use afterimage_gpu::wgpu;
use afterimage_graph::check::Source;
use afterimage_graph::node::Fallback;

use super::graph::wire_name;
use super::picture::PictureView;
use crate::model::{InspectedWire, Model};
use crate::render::{TexelReader, TexelRequest};

/// The side of the square of texels around a click whose mean is made gray: one texel may be noise.
const SIDE: i32 = 5;

/// A place that was clicked, until the colors there have arrived.
#[derive(Default)]
pub(super) struct WhitePicker {
    /// The node, and the place in parts of the picture.
    picked: Option<(String, [f32; 2])>,
    reader: TexelReader,
}

impl WhitePicker {
    /// True while a color is read.
    pub(super) fn is_reading(&self) -> bool {
        self.picked.is_some()
    }

    /// Takes the click that chose a place, and ends the choice.
    pub(super) fn take_click(&mut self, picture: &mut PictureView) {
        if let Some(place) = picture.picked.take() {
            self.picked = picture.picks.take().map(|node| (node, place));
        }
    }

    /// Records copies of the colors at the place, once all images are stored.
    pub(super) fn record(&mut self, model: &Model, encoder: &mut wgpu::CommandEncoder) {
        let Some((node, [x, y])) = &self.picked else { return };
        if model.inspector().stored().is_none() || model.inspector().is_compiling() {
            return;
        }
        let Some(image) = source_image(model, node) else { return };
        let offsets = (0..SIDE * SIDE).map(|index| [index % SIDE - SIDE / 2, index / SIDE - SIDE / 2]);
        let texels = offsets.filter_map(|[right, down]| {
            let moved = |place: f32, by: i32, side: u32| (place + by as f32 / side as f32).clamp(0.0, 1.0);
            let place = [moved(*x, right, image.width()), moved(*y, down, image.height())];
            TexelRequest::new(node, &image, place)
        });
        let texels: Vec<TexelRequest<'_>> = texels.collect();
        self.reader.record(&model.gpu().device, encoder, &texels);
    }

    /// Requests the colors that were copied, and sets the parameters from those that have arrived; call it after the
    /// commands are submitted. Returns a message about them.
    pub(super) fn finish(&mut self, model: &mut Model) -> Option<String> {
        self.reader.request();
        let texels = self.reader.take()?;
        let (node, _) = self.picked.take()?;
        let finite = texels.iter().filter(|texel| texel.value.iter().all(|number| number.is_finite()));
        let (count, sum) = finite.fold((0.0, [0.0; 3]), |(count, sum), texel| {
            (count + 1.0, std::array::from_fn(|channel| sum[channel] + f64::from(texel.value[channel])))
        });
        Some(match model.make_gray(&node, sum.map(|number| number / count)) {
            true => format!("`{node}` makes this gray."),
            false => "No light gives gray this color: choose a part that should be gray, and is not black.".into(),
        })
    }
}

/// The image that a node reads at its first input: of a node that is skipped, what its readers get in its place.
fn source_image(model: &Model, node: &str) -> Option<wgpu::Texture> {
    let graph = model.editor().graph()?;
    let mut source = (*graph.node(node)?.1.wires.first()?)?;
    loop {
        if let Some((_, image)) = model.wire_image(&InspectedWire::new(wire_name(graph, source))) {
            return Some(image);
        }
        let Source::Node { node, output, .. } = source else { return None };
        let node = &graph.nodes[node];
        let Fallback::Input(input) = &node.kind().outputs()[output].fallback else { return None };
        let read = node.kind().inputs().iter().position(|port| *port.name == **input)?;
        source = node.wires[read]?;
    }
}
