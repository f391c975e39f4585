//! Allocates a plan's textures and buffers, reusing those of the previous plan with equal descriptors.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::image::ImageDesc;
use afterimage_graph::node::{BufferId, BufferLife, Drawing, Geometry, ImageId, Origin, Pass, Resource, VirtualBuffer};
use afterimage_plan::{HeapPlacement, Plan, PlannedImage};
use rustc_hash::FxHashMap;
use wgpu::{Buffer, BufferUsages, Device, Queue};

use crate::buffer::buffer;
use crate::error::GpuError;
use crate::executor::loaded::residency::{ImageBinding, Residency, ring_place};
use crate::heap::Placed;
use crate::platform::caught;
use crate::store::{self, Stored};

/// Allocates the memory of a plan.
pub(crate) struct ResidencyBuilder<'a> {
    pub(crate) device: &'a Device,
    pub(crate) queue: &'a Queue,
    /// The previous plan, which may render meanwhile.
    pub(crate) old: Option<(&'a Plan, &'a Residency)>,
    /// The number of the next frame, where it matters: see [`Residency::keeps_places`].
    pub(crate) frame: u32,
}

/// The memory of a plan.
pub(crate) struct NewResidency {
    pub(crate) residency: Arc<Residency>,
    /// Memory that no frame has written yet.
    pub(crate) uninitialized: Vec<Resource>,
}

/// Memory that a plan can reuse, and that is allocated for it.
struct Memory<'a> {
    device: &'a Device,
    queue: &'a Queue,
    frame: u32,
    /// Textures of the old plan that the new one may take.
    spare: Vec<Stored>,
    /// Constant images of both plans.
    constants: Vec<(&'a [u8], Stored)>,
    uninitialized: Vec<Resource>,
}

impl<'a> ResidencyBuilder<'a> {
    /// Allocates the textures and buffers of a plan.
    pub(crate) fn allocate(
        self,
        plan: &'a Plan,
        placement: HeapPlacement,
        placed: Option<Placed>,
    ) -> Result<NewResidency, GpuError> {
        let Self { device, queue, old, frame } = self;
        let mut memory =
            Memory { device, queue, frame, spare: Vec::new(), constants: Vec::new(), uninitialized: Vec::new() };
        let rings = old.map_or_else(FxHashMap::default, |(plan, old)| memory.retire(plan, old));
        let buffers = memory.buffers(plan, old)?;
        let bindings = memory.bind_images(plan, &placement, placed.as_ref(), rings)?;
        let inputs = plan.inputs.len();
        let residency = Residency { placement, placed, bindings, buffers, ring_length: ring_length(plan), inputs };
        Ok(NewResidency { residency: Arc::new(residency), uninitialized: memory.uninitialized })
    }
}

impl<'a> Memory<'a> {
    /// Offers the old plan's textures, and returns those of its histories by the names of their images.
    fn retire(&mut self, plan: &'a Plan, old: &'a Residency) -> FxHashMap<&'a str, &'a [Stored]> {
        let mut rings = FxHashMap::default();
        let is_in_heap = |stored: &Stored| old.heap_textures().any(|texture| *texture == stored.texture);
        for (image, binding) in plan.images.iter().zip(&old.bindings) {
            match (binding, &image.origin) {
                (ImageBinding::Ring(ring, 0), _) => {
                    rings.insert(image.label.as_str(), ring.as_slice());
                }
                (ImageBinding::Output(_, stored), _) => self.offer(stored),
                (ImageBinding::Fixed(stored), Origin::Constant(bytes)) => {
                    self.constants.push((bytes, stored.clone()));
                }
                (ImageBinding::Fixed(stored), _) if !is_in_heap(stored) => self.offer(stored),
                _ => {}
            }
        }
        rings
    }

    /// Offers a texture of the old plan, once: several images of a plan may share a texture.
    fn offer(&mut self, stored: &Stored) {
        if !self.spare.iter().any(|spare| spare.texture == stored.texture) {
            self.spare.push(stored.clone());
        }
    }

    /// A texture of that description, from the old plan or new. Its contents are undefined.
    fn take(&mut self, desc: ImageDesc, label: &str) -> Stored {
        match self.spare.iter().position(|spare| spare.desc == desc) {
            Some(at) => self.spare.swap_remove(at),
            None => store::create(self.device, desc, label),
        }
    }

    /// Buffers of the plan; those that outlive frames keep their contents where the old plan had the same.
    fn buffers(&mut self, plan: &Plan, old: Option<(&Plan, &Residency)>) -> Result<Vec<Buffer>, GpuError> {
        let mut kept: FxHashMap<(&str, u64), &Buffer> = FxHashMap::default();
        if let Some((plan, old)) = old {
            let persistent = plan.buffers.iter().zip(&old.buffers);
            let persistent = persistent.filter(|(described, _)| described.life == BufferLife::Persistent);
            kept.extend(persistent.map(|(described, buffer)| ((described.label.as_str(), described.bytes), buffer)));
        }
        let ranges = buffers_of_ranges(plan);
        let mut buffers = Vec::with_capacity(plan.buffers.len());
        for (index, described) in plan.buffers.iter().enumerate() {
            let id = BufferId(index as u32);
            let usage = if ranges.contains(&id) { USAGE | BufferUsages::INDIRECT } else { USAGE };
            let is_persistent = described.life == BufferLife::Persistent;
            let known = is_persistent.then(|| kept.remove(&(described.label.as_str(), described.bytes))).flatten();
            let known = known.filter(|known| known.usage().contains(usage));
            if is_persistent && known.is_none() {
                self.uninitialized.push(Resource::Buffer(id));
            }
            buffers.push(match known {
                Some(known) => known.clone(),
                None => make_buffer(self.device, self.queue, described, usage)?,
            });
        }
        Ok(buffers)
    }

    fn bind_images(
        &mut self,
        plan: &'a Plan,
        placement: &HeapPlacement,
        placed: Option<&Placed>,
        mut rings: FxHashMap<&str, &[Stored]>,
    ) -> Result<Vec<ImageBinding>, GpuError> {
        let mut in_heap = placed.map_or(&[][..], |placed| &placed.images).iter();
        let mut slots: Vec<Option<Stored>> = vec![None; plan.memory.slots.len()];
        let mut bindings: Vec<ImageBinding> = Vec::with_capacity(plan.images.len());
        let remembered: Vec<ImageId> = plan.images.iter().filter_map(|image| image.origin.previous_of()).collect();
        for (index, image) in plan.images.iter().enumerate() {
            let id = ImageId(index as u32);
            let output = plan.outputs.iter().position(|output| output.image == id);
            bindings.push(match (self.bind_given(plan, image)?, output) {
                (Some(binding), _) => binding,
                (None, _) if remembered.contains(&id) => {
                    let known = rings.remove(image.label.as_str());
                    ImageBinding::Ring(self.ring(plan, id, known.unwrap_or_default()), 0)
                }
                (None, Some(output)) => ImageBinding::Output(output, self.take(image.desc, &image.label)),
                (None, None) if image.origin == Origin::Retained => {
                    ImageBinding::Fixed(self.take(image.desc, &image.label))
                }
                (None, None) => {
                    let in_heap = placement.offsets[index].and_then(|_| in_heap.next());
                    let in_heap = in_heap.map(|(_, stored)| stored.clone());
                    ImageBinding::Fixed(in_heap.unwrap_or_else(|| self.pooled(plan, image, &mut slots)))
                }
            });
        }
        self.bind_histories(plan, &mut bindings);
        Ok(bindings)
    }

    /// The binding of an image that no pass writes; `None` for one that a pass writes. History images are bound once
    /// the image of this frame has its ring.
    fn bind_given(&mut self, plan: &'a Plan, image: &'a PlannedImage) -> Result<Option<ImageBinding>, GpuError> {
        Ok(match &image.origin {
            _ if image.lifetime.is_none() => Some(ImageBinding::Unused),
            Origin::Previous { .. } => Some(ImageBinding::Unused),
            Origin::Input(name) => {
                let input = plan.inputs.iter().position(|(input, _)| input == name);
                Some(ImageBinding::Input(input.expect("every input image is listed")))
            }
            Origin::Constant(bytes) => Some(ImageBinding::Fixed(self.constant(image.desc, bytes)?)),
            Origin::Transient | Origin::Retained => None,
        })
    }

    /// The texture with these constant texels, of either plan; or a new one.
    fn constant(&mut self, desc: ImageDesc, bytes: &'a [u8]) -> Result<Stored, GpuError> {
        let same = |(known, stored): &&(&[u8], Stored)| stored.desc == desc && *known == bytes;
        if let Some((_, stored)) = self.constants.iter().find(same) {
            return Ok(stored.clone());
        }
        let stored = store::create(self.device, desc, "constant");
        store::upload(self.queue, &stored.texture, desc, bytes)?;
        self.constants.push((bytes, stored.clone()));
        Ok(stored)
    }

    /// The pooled texture of an image that lives within the frame.
    fn pooled(&mut self, plan: &Plan, image: &PlannedImage, slots: &mut [Option<Stored>]) -> Stored {
        let slot = image.slot.expect("a transient that is used has a slot") as usize;
        let desc = plan.memory.slots[slot].desc;
        slots[slot].get_or_insert_with(|| self.take(desc, "transients")).clone()
    }

    /// The ring of textures of a history. Those of the old plan keep their age in frames.
    fn ring(&mut self, plan: &Plan, id: ImageId, known: &[Stored]) -> Vec<Stored> {
        let image = plan.image(id);
        let known = if known.first().is_some_and(|first| first.desc == image.desc) { known } else { &[] };
        if known.is_empty() {
            self.uninitialized.push(Resource::Image(id));
            let pasts = plan.images.iter().enumerate().filter(|(_, image)| image.origin.previous_of() == Some(id));
            self.uninitialized.extend(pasts.map(|(index, _)| Resource::Image(ImageId(index as u32))));
        }
        let length = ring_length(plan) as usize;
        let mut ring: Vec<Option<Stored>> = vec![None; length];
        for age in 0..length.min(known.len()) {
            let [to, from] = [length, known.len()].map(|length| ring_place(length, self.frame, age as u32));
            ring[to] = Some(known[from].clone());
        }
        ring.into_iter().map(|known| known.unwrap_or_else(|| self.black(image))).collect()
    }

    /// A new texture, which holds zeros.
    fn black(&self, image: &PlannedImage) -> Stored {
        store::create(self.device, image.desc, &image.label)
    }

    fn bind_histories(&mut self, plan: &Plan, bindings: &mut [ImageBinding]) {
        for (index, image) in plan.images.iter().enumerate() {
            let Origin::Previous { of, frames } = image.origin else { continue };
            if image.lifetime.is_none() {
                continue;
            }
            bindings[index] = match &bindings[of.0 as usize] {
                ImageBinding::Ring(ring, _) => ImageBinding::Ring(ring.clone(), frames),
                // This plan never writes the image: its history is black.
                _ => ImageBinding::Fixed(self.black(image)),
            };
        }
    }
}

/// Ring length: one texture for this frame and one for each that is remembered.
pub(crate) fn ring_length(plan: &Plan) -> u32 {
    let depth = plan.images.iter().map(|image| match image.origin {
        Origin::Previous { frames, .. } => frames,
        _ => 0,
    });
    1 + depth.max().unwrap_or(0)
}

/// The usages of every buffer of a plan.
const USAGE: BufferUsages = BufferUsages::STORAGE
    .union(BufferUsages::VERTEX)
    .union(BufferUsages::INDEX)
    .union(BufferUsages::COPY_DST)
    .union(BufferUsages::COPY_SRC);

/// The buffers with ranges of draws, for which wgpu makes bind groups of its own.
fn buffers_of_ranges(plan: &Plan) -> BTreeSet<BufferId> {
    let geometries = plan.work().filter_map(Pass::drawing).filter_map(Drawing::geometry);
    geometries.filter_map(Geometry::indirect).map(|indirect| indirect.buffer).collect()
}

fn make_buffer(
    device: &Device,
    queue: &Queue,
    described: &VirtualBuffer,
    usage: BufferUsages,
) -> Result<Buffer, GpuError> {
    let made = buffer(device, &described.label, described.bytes.next_multiple_of(16), usage);
    if let BufferLife::Constant(bytes) = &described.life {
        caught("a table", || queue.write_buffer(&made, 0, bytes))?;
    }
    Ok(made)
}
