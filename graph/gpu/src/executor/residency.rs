//! Residency: the textures and buffers of a plan. A new plan takes those of the old one where they are the same.

use afterimage_graph::node::{BufferId, BufferLife, ImageId, Origin, Pass, Resource, VirtualBuffer};
use afterimage_plan::codegen::SlotKind;
use afterimage_plan::{HeapPlacement, Plan, PlannedImage};
use rustc_hash::FxHashMap;
use wgpu::{Buffer, BufferUsages, Device, Queue};

use super::loaded::{ImageBinding, Loaded};
use super::prepare::CompiledPlan;
use super::rectangle::HeldRectangles;
use crate::GpuError;
use crate::buffer::buffer;
use crate::heap::Placed;
use crate::platform::caught;
use crate::store::{Store, TextureKey};
use crate::timing::Timing;

/// A change of plan. The old plan stays as it is until the new one has all that it needs.
pub(super) struct PlanSwap<'a> {
    pub(super) device: &'a Device,
    pub(super) queue: &'a Queue,
    pub(super) store: &'a mut Store,
    pub(super) old: Option<&'a Loaded>,
    /// The number of the frame that comes next.
    pub(super) frame: u32,
    pub(super) uninitialized: Vec<Resource>,
}

impl PlanSwap<'_> {
    /// The plan on textures and buffers of its own and of the old plan.
    pub(super) fn settle(mut self, parts: CompiledPlan) -> Result<Loaded, GpuError> {
        let CompiledPlan { plan, placement, passes, uniforms, placed, shares_old_heap } = parts;
        let rings = self.retire();
        let buffers = self.buffers(&plan)?;
        let heap_textures = self.store_heap(placed.as_ref());
        let bindings = self.bind_images(&plan, &placement, rings, &heap_textures)?;
        let lives = |wanted: fn(&BufferLife) -> bool| {
            let buffers = plan.buffers.iter().enumerate();
            buffers.filter(|(_, b)| wanted(&b.life)).map(|(index, _)| index).collect::<Vec<_>>()
        };
        let binds_frame = passes.iter().any(|pass| pass.composed.slots.iter().any(|slot| slot.kind == SlotKind::Frame));
        let timed = self.old.is_some_and(|old| old.timing.is_some());
        Ok(Loaded {
            zeroed: lives(|life| *life == BufferLife::Zeroed),
            persistent: lives(|life| *life == BufferLife::Persistent),
            ring_length: ring_length(&plan),
            host_views: host_views(&plan, &bindings),
            timing: timed.then(|| Timing::new(self.device, self.queue, passes.len() as u32)).flatten(),
            labels: None,
            rectangles: HeldRectangles::none(&plan),
            blocks: plan.blocks.iter().map(|planned| vec![0; planned.block.bytes()]).collect(),
            plan,
            placement,
            passes,
            uniforms,
            bindings,
            buffers,
            sets: Vec::new(),
            placed,
            binds_frame,
            heap_textures,
            uninitialized: self.uninitialized,
            shares_old_heap,
        })
    }

    /// Offers the old plan's textures, and returns those of its histories by the names of their images.
    fn retire(&mut self) -> FxHashMap<String, Vec<TextureKey>> {
        let mut rings = FxHashMap::default();
        let Some(old) = self.old else { return rings };
        for (image, binding) in old.plan.images.iter().zip(&old.bindings) {
            match binding {
                ImageBinding::Ring(keys, 0) => {
                    rings.insert(image.label.clone(), keys.clone());
                }
                ImageBinding::Output(_, key) => self.store.retire([*key]),
                ImageBinding::Fixed(key)
                    if !matches!(image.origin, Origin::Constant(_)) && !old.heap_textures.contains(key) =>
                {
                    self.store.retire([*key]);
                }
                _ => {}
            }
        }
        rings
    }

    /// Buffers of the plan; those that outlive frames keep their contents where the old plan had the same.
    fn buffers(&mut self, plan: &Plan) -> Result<Vec<Buffer>, GpuError> {
        let mut kept: FxHashMap<(&str, u64), Buffer> = FxHashMap::default();
        if let Some(old) = self.old {
            let lasting = old.plan.buffers.iter().zip(&old.buffers);
            let lasting = lasting.filter(|(described, _)| described.life == BufferLife::Persistent);
            kept.extend(
                lasting.map(|(described, buffer)| ((described.label.as_str(), described.bytes), buffer.clone())),
            );
        }
        let mut buffers = Vec::with_capacity(plan.buffers.len());
        for (index, described) in plan.buffers.iter().enumerate() {
            let lasts = described.life == BufferLife::Persistent;
            let known = lasts.then(|| kept.remove(&(described.label.as_str(), described.bytes))).flatten();
            if lasts && known.is_none() {
                self.uninitialized.push(Resource::Buffer(BufferId(index as u32)));
            }
            buffers.push(known.map_or_else(|| make_buffer(self.device, self.queue, described), Ok)?);
        }
        Ok(buffers)
    }

    /// Stores the textures of the heap.
    fn store_heap(&mut self, placed: Option<&Placed>) -> Vec<TextureKey> {
        placed.map_or(Vec::new(), |placed| {
            placed.images.iter().map(|(_, stored)| self.store.insert(stored.clone())).collect()
        })
    }

    fn bind_images(
        &mut self,
        plan: &Plan,
        placement: &HeapPlacement,
        mut rings: FxHashMap<String, Vec<TextureKey>>,
        heap_textures: &[TextureKey],
    ) -> Result<Vec<ImageBinding>, GpuError> {
        let mut in_heap = heap_textures.iter().copied();
        let mut slots: Vec<Option<TextureKey>> = vec![None; plan.memory.slots.len()];
        let mut bindings: Vec<ImageBinding> = Vec::with_capacity(plan.images.len());
        let remembered: Vec<ImageId> = plan.images.iter().filter_map(|image| image.origin.previous_of()).collect();
        for (index, image) in plan.images.iter().enumerate() {
            let id = ImageId(index as u32);
            let output = plan.outputs.iter().position(|output| output.image == id);
            bindings.push(match (self.bind_given(plan, image)?, output) {
                (Some(binding), _) => binding,
                (None, _) if remembered.contains(&id) => {
                    let known = rings.remove(&image.label);
                    ImageBinding::Ring(self.ring(plan, id, known), 0)
                }
                (None, Some(output)) => {
                    ImageBinding::Output(output, self.store.take(self.device, image.desc, &image.label))
                }
                (None, None) => {
                    let in_heap = placement.offsets[index].and_then(|_| in_heap.next());
                    ImageBinding::Fixed(in_heap.unwrap_or_else(|| self.pooled(plan, image, &mut slots)))
                }
            });
        }
        self.bind_histories(plan, &mut bindings);
        self.store.retire(rings.into_values().flatten());
        Ok(bindings)
    }

    /// The binding of an image that no pass writes; `None` for one that a pass writes. Images of earlier frames are
    /// bound once the image of this frame has its ring.
    fn bind_given(&mut self, plan: &Plan, image: &PlannedImage) -> Result<Option<ImageBinding>, GpuError> {
        Ok(match &image.origin {
            _ if image.lifetime.is_none() => Some(ImageBinding::Unused),
            Origin::Previous { .. } => Some(ImageBinding::Unused),
            Origin::Input(name) => {
                let input = plan.inputs.iter().position(|(input, _)| input == name);
                Some(ImageBinding::Input(input.expect("every input image is listed")))
            }
            Origin::Constant(bytes) => {
                Some(ImageBinding::Fixed(self.store.constant(self.device, self.queue, image.desc, bytes)?))
            }
            Origin::Transient => None,
        })
    }

    /// The pooled texture of an image that lives within the frame.
    fn pooled(&mut self, plan: &Plan, image: &PlannedImage, slots: &mut [Option<TextureKey>]) -> TextureKey {
        let slot = image.slot.expect("a transient that is used has a slot") as usize;
        let desc = plan.memory.slots[slot].desc;
        *slots[slot].get_or_insert_with(|| self.store.take(self.device, desc, "transients"))
    }

    /// The ring of textures of a history. What earlier frames have left in those of the old plan keeps its age.
    fn ring(&mut self, plan: &Plan, id: ImageId, known: Option<Vec<TextureKey>>) -> Vec<TextureKey> {
        let image = plan.image(id);
        let (known, unfit) = match known {
            Some(known) if self.store.get(known[0]).desc == image.desc => (known, Vec::new()),
            unfit => (Vec::new(), unfit.unwrap_or_default()),
        };
        self.store.retire(unfit);
        if known.is_empty() {
            self.uninitialized.push(Resource::Image(id));
            let pasts = plan.images.iter().enumerate().filter(|(_, image)| image.origin.previous_of() == Some(id));
            self.uninitialized.extend(pasts.map(|(index, _)| Resource::Image(ImageId(index as u32))));
        }
        let length = ring_length(plan) as usize;
        let at = |age: usize, length: usize| (self.frame as usize % length + length - age % length) % length;
        let mut ring = vec![TextureKey::default(); length];
        for age in 0..length {
            ring[at(age, length)] = match known.len() {
                had if age < had => known[at(age, had)],
                _ => self.store.black(self.device, image.desc, &image.label),
            };
        }
        let left = (length..known.len()).map(|age| known[at(age, known.len())]);
        self.store.retire(left);
        ring
    }

    fn bind_histories(&mut self, plan: &Plan, bindings: &mut [ImageBinding]) {
        for (index, image) in plan.images.iter().enumerate() {
            let Origin::Previous { of, frames } = image.origin else { continue };
            if image.lifetime.is_none() {
                continue;
            }
            bindings[index] = match &bindings[of.0 as usize] {
                ImageBinding::Ring(keys, _) => ImageBinding::Ring(keys.clone(), frames),
                // The image is never written in this plan: its past is black.
                _ => ImageBinding::Fixed(self.store.black(self.device, image.desc, &image.label)),
            };
        }
    }
}

/// Ring length: one texture for this frame and one for each that is remembered. It is the same for all rings, so that
/// one ring index is valid for all.
fn ring_length(plan: &Plan) -> u32 {
    let depth = plan.images.iter().map(|image| match image.origin {
        Origin::Previous { frames, .. } => frames,
        _ => 0,
    });
    1 + depth.max().unwrap_or(0)
}

fn make_buffer(device: &Device, queue: &Queue, wanted: &VirtualBuffer) -> Result<Buffer, GpuError> {
    let copies = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let usage = BufferUsages::STORAGE | BufferUsages::VERTEX | BufferUsages::INDEX | copies;
    let made = buffer(device, &wanted.label, wanted.bytes.next_multiple_of(16), usage);
    if let BufferLife::Constant(bytes) = &wanted.life {
        caught("a table", || queue.write_buffer(&made, 0, bytes))?;
    }
    Ok(made)
}

/// For each pass the places of the images that it names among the host's views.
fn host_views(plan: &Plan, bindings: &[ImageBinding]) -> Vec<Vec<usize>> {
    let of_pass = |pass: &Pass| {
        let images = pass.resources().filter_map(Resource::image);
        images.filter_map(|image| bindings[image.0 as usize].host_view(plan)).collect()
    };
    plan.work().map(of_pass).collect()
}
