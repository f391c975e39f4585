//! Intermediate images, tables and values.
//!
//! A second pipeline with the same graph stores every image of every node in memory of its own. The shown picture is
//! planned as for a host, and does not change.

use afterimage_gpu::wgpu;
use afterimage_graph::check::Source;
use afterimage_graph::image::{ColorState, ImageDesc};
use afterimage_graph::node::PortType;

use super::tap::{Tap, TapImage};
use super::{Chain, Model, Purpose};

impl Model {
    /// The intermediate result that is shown instead of the result.
    pub fn tap(&self) -> Option<&Tap> {
        self.tap.as_ref()
    }

    /// Shows an intermediate image, table or value; `None` shows the result.
    pub fn set_tap(&mut self, tap: Option<Tap>) {
        let is_buffer = |tap: &Tap| matches!(self.wire_type(&tap.wire), Some(PortType::Table | PortType::Value));
        let watched = tap.as_ref().filter(|tap| is_buffer(tap)).map(|tap| tap.wire.clone());
        self.watched = watched.and_then(|wire| Some(self.chains.shown.as_mut()?.post().watch(&wire)));
        self.tap = tap;
        self.update_inspections();
    }

    /// The newest bytes of the table or value that the tap shows: those of the shown picture itself.
    pub fn tapped_bytes(&mut self) -> Option<Vec<u8>> {
        let watch = self.watched?;
        Some(self.chains.shown.as_mut()?.post().reading(watch).ok()??.bytes.clone())
    }

    /// Stores the values at every node, and those of the reference, so that they can be read.
    pub fn set_probes(&mut self, on: bool) {
        if self.probes != on {
            self.probes = on;
            self.update_inspections();
        }
    }

    /// Makes the pipelines whose images are read, and drops those that nothing reads.
    fn update_inspections(&mut self) {
        let inspects = self.tap.is_some() || self.probes;
        if self.chains.inspected.is_some() != inspects {
            self.chains.inspected = if inspects { self.inspection(Purpose::Inspect) } else { None };
        }
        if self.chains.reference.is_some() != self.probes {
            self.chains.reference = if self.probes { self.inspection(Purpose::Reference) } else { None };
        }
        self.is_stale = true;
    }

    fn inspection(&self, purpose: Purpose) -> Option<Chain> {
        let mut chain = Chain::new(&self.gpu, self.present_graph()?, purpose);
        chain.post().set_facts(self.facts.clone());
        chain.set_changes(&self.changes);
        Some(chain)
    }

    /// The pipeline that stores all images, while they are read.
    pub fn inspected(&self) -> Option<&Chain> {
        self.chains.inspected.as_ref()
    }

    /// The pipeline that stores all images in 32 bits, while they are read.
    pub fn reference(&self) -> Option<&Chain> {
        self.chains.reference.as_ref()
    }

    /// The images of a wire, as the run stores them: levels of a pyramid and histories, then the other images of its
    /// node.
    pub fn tap_images(&self, wire: &str) -> Vec<TapImage> {
        let Some(plan) = self.chains.inspected.as_ref().and_then(Chain::plan) else { return Vec::new() };
        let node = wire.rsplit_once('.').map_or(wire, |(node, _)| node);
        let named = plan.image_names().into_iter().zip(&plan.images);
        let used = named.filter(|(_, image)| image.lifetime.is_some());
        let of_node = used.filter(|(name, _)| belongs(name, node));
        let mut images: Vec<TapImage> = of_node.map(|(name, image)| TapImage { name, desc: image.desc }).collect();
        images.sort_by_key(|image| !belongs(&image.name, wire));
        images
    }

    /// The image that the tap shows, once a frame has made it.
    pub fn tapped(&self) -> Option<(TapImage, wgpu::Texture)> {
        let tap = self.tap.as_ref()?;
        if let Some((_, view)) = self.fed.images.iter().find(|(name, _)| *name == tap.wire) {
            let texture = view.texture().clone();
            let size = afterimage_graph::image::Size::new(texture.width(), texture.height());
            return Some((TapImage { name: tap.wire.clone(), desc: ImageDesc::new(size) }, texture));
        }
        let images = self.tap_images(&tap.wire);
        let image = images.get(tap.index.min(images.len().checked_sub(1)?))?.clone();
        let texture = self.chains.inspected.as_ref()?.image(&image.name)?.clone();
        Some((image, texture))
    }

    /// Whether the plan that stores the tap's image is still being made.
    pub fn is_tap_compiling(&self) -> bool {
        self.chains.inspected.as_ref().is_some_and(|chain| chain.plan().is_none() || chain.is_changing())
    }

    /// What the numbers of a wire mean; `None` for tables and values, and for wires that the graph does not have.
    pub fn wire_state(&self, wire: &str) -> Option<ColorState> {
        let graph = self.graph.as_ref()?;
        if let Some(input) = graph.inputs.iter().find(|input| input.name == wire) {
            return input.block.is_none().then_some(input.state);
        }
        let (node, port) = wire.rsplit_once('.')?;
        let (_, node) = graph.node(node)?;
        let output = node.kind().outputs().iter().position(|output| output.name == port)?;
        *node.states.get(output)?
    }

    /// What a wire carries.
    pub fn wire_type(&self, wire: &str) -> Option<PortType> {
        let graph = self.graph.as_ref()?;
        if let Some(input) = graph.inputs.iter().position(|input| input.name == wire) {
            return Some(graph.port_type(Source::Input(input)));
        }
        let (node, port) = wire.rsplit_once('.')?;
        let (_, node) = graph.node(node)?;
        Some(node.kind().outputs().iter().find(|output| output.name == port)?.ty)
    }
}

/// Whether an image is that of a wire or a node, one of its levels or steps, or its past.
fn belongs(image: &str, owner: &str) -> bool {
    image.strip_prefix(owner).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '@', '#']))
}
