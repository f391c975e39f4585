//! Between two frames: the textures and buffers of a new plan, those of the old one taken over where they are the same.

use afterimage_graph::node::{BufferId, BufferLife, ImageId, Origin, Resource, VirtualBuffer, VirtualImage};
use afterimage_plan::Plan;
use afterimage_plan::codegen::SlotKind;
use rustc_hash::FxHashMap;
use wgpu::{Buffer, BufferUsages, Device, Queue};

use super::loaded::{ImageBinding, Loaded};
use super::prepare::CompiledPlan;
use crate::heap::Placed;
use crate::store::{Store, TextureKey};
use crate::timing::Timing;

/// A swap in the making. The old plan stays as it is until the new one has all that it needs.
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
    pub(super) fn settle(mut self, parts: CompiledPlan) -> Loaded {
        let CompiledPlan { plan, passes, uniforms, regions, placed, moved_in } = parts;
        let rings = self.retire();
        let buffers = self.buffers(&plan);
        let residents = self.move_in(placed.as_ref());
        let bindings = self.hold(&plan, rings, &residents);
        let lives = |wanted: fn(&BufferLife) -> bool| {
            let buffers = plan.recording.buffers.iter().enumerate();
            buffers.filter(|(_, b)| wanted(&b.life)).map(|(index, _)| index).collect::<Vec<_>>()
        };
        let binds_frame = passes.iter().any(|pass| pass.composed.slots.iter().any(|slot| slot.kind == SlotKind::Frame));
        let timed = self.old.is_some_and(|old| old.timing.is_some());
        Loaded {
            zeroed: lives(|life| *life == BufferLife::Zeroed),
            persistent: lives(|life| *life == BufferLife::Persistent),
            ring_length: ring_length(&plan),
            timing: timed.then(|| Timing::new(self.device, self.queue, passes.len() as u32)).flatten(),
            plan,
            passes,
            uniforms,
            regions,
            bindings,
            buffers,
            sets: Vec::new(),
            placed,
            binds_frame,
            residents,
            uninitialized: self.uninitialized,
            moved_in,
        }
    }

    /// Offers the old plan's textures, and returns those of its histories by the names of their images.
    fn retire(&mut self) -> FxHashMap<String, Vec<TextureKey>> {
        let mut rings = FxHashMap::default();
        let Some(old) = self.old else { return rings };
        for (image, binding) in old.plan.recording.images.iter().zip(&old.bindings) {
            match binding {
                ImageBinding::Ring(keys, 0) => {
                    rings.insert(image.label.clone(), keys.clone());
                }
                ImageBinding::Output(_, key) => self.store.retire([*key]),
                ImageBinding::Fixed(key)
                    if !matches!(image.origin, Origin::Constant(_)) && !old.residents.contains(key) =>
                {
                    self.store.retire([*key]);
                }
                _ => {}
            }
        }
        rings
    }

    /// Buffers of the plan; those that outlive frames keep what they hold where the old plan had the same.
    fn buffers(&mut self, plan: &Plan) -> Vec<Buffer> {
        let mut kept: FxHashMap<(&str, u64), Buffer> = FxHashMap::default();
        if let Some(old) = self.old {
            let lasting = old.plan.recording.buffers.iter().zip(&old.buffers);
            let lasting = lasting.filter(|(described, _)| described.life == BufferLife::Persistent);
            kept.extend(
                lasting.map(|(described, buffer)| ((described.label.as_str(), described.bytes), buffer.clone())),
            );
        }
        let mut buffers = Vec::with_capacity(plan.recording.buffers.len());
        for (index, described) in plan.recording.buffers.iter().enumerate() {
            let lasts = described.life == BufferLife::Persistent;
            let known = lasts.then(|| kept.remove(&(described.label.as_str(), described.bytes))).flatten();
            if lasts && known.is_none() {
                self.uninitialized.push(Resource::Buffer(BufferId(index as u32)));
            }
            buffers.push(known.unwrap_or_else(|| make_buffer(self.device, self.queue, described)));
        }
        buffers
    }

    fn move_in(&mut self, placed: Option<&Placed>) -> Vec<TextureKey> {
        placed.map_or(Vec::new(), |placed| {
            placed.images.iter().map(|(_, stored)| self.store.insert(stored.clone())).collect()
        })
    }

    fn hold(
        &mut self,
        plan: &Plan,
        mut rings: FxHashMap<String, Vec<TextureKey>>,
        residents: &[TextureKey],
    ) -> Vec<ImageBinding> {
        let mut in_heap = residents.iter().copied();
        let mut slots: Vec<Option<TextureKey>> = vec![None; plan.memory.slots.len()];
        let mut bindings: Vec<ImageBinding> = Vec::with_capacity(plan.recording.images.len());
        let remembered: Vec<ImageId> = plan.recording.images.iter().filter_map(past_of).collect();
        for (index, image) in plan.recording.images.iter().enumerate() {
            let id = ImageId(index as u32);
            let output = plan.outputs.iter().position(|output| output.image == id);
            let binding = match (&image.origin, plan.lifetimes[index], output) {
                // Pasts are filled in below, once the image that they are the past of has its ring.
                (_, None, _) | (Origin::Previous { .. }, ..) => ImageBinding::Unused,
                (Origin::Input(name), ..) => {
                    let input = plan.inputs.iter().position(|(input, _)| input == name);
                    ImageBinding::Input(input.expect("every input image is listed"))
                }
                (Origin::Constant(bytes), ..) => {
                    ImageBinding::Fixed(self.store.constant(self.device, self.queue, image.desc, bytes))
                }
                (Origin::Transient, ..) if remembered.contains(&id) => {
                    let known = rings.remove(&image.label);
                    ImageBinding::Ring(self.ring(plan, id, known), 0)
                }
                (Origin::Transient, _, Some(output)) => {
                    ImageBinding::Output(output, self.store.take(self.device, image.desc, &image.label))
                }
                (Origin::Transient, Some(_), None) => {
                    ImageBinding::Fixed(self.transient(plan, index, &mut in_heap, &mut slots))
                }
            };
            bindings.push(binding);
        }
        self.hold_pasts(plan, &mut bindings);
        self.store.retire(rings.into_values().flatten());
        bindings
    }

    /// The texture of an image that lives within the frame.
    fn transient(
        &mut self,
        plan: &Plan,
        index: usize,
        in_heap: &mut dyn Iterator<Item = TextureKey>,
        slots: &mut [Option<TextureKey>],
    ) -> TextureKey {
        if let Some(next) = plan.memory.offset_of[index].and_then(|_| in_heap.next()) {
            return next;
        }
        let slot = plan.memory.slot_of[index].expect("a transient that is used has a slot") as usize;
        let desc = plan.memory.slots[slot].desc;
        *slots[slot].get_or_insert_with(|| self.store.take(self.device, desc, "transients"))
    }

    /// The textures that an image takes in turn. What earlier frames have left in those of the old plan stays at its age.
    fn ring(&mut self, plan: &Plan, id: ImageId, known: Option<Vec<TextureKey>>) -> Vec<TextureKey> {
        let image = plan.recording.image(id);
        let (known, unfit) = match known {
            Some(known) if self.store.get(known[0]).desc == image.desc => (known, Vec::new()),
            unfit => (Vec::new(), unfit.unwrap_or_default()),
        };
        self.store.retire(unfit);
        if known.is_empty() {
            self.uninitialized.push(Resource::Image(id));
            let pasts = plan.recording.images.iter().enumerate().filter(|(_, image)| past_of(image) == Some(id));
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

    fn hold_pasts(&mut self, plan: &Plan, bindings: &mut [ImageBinding]) {
        for (index, image) in plan.recording.images.iter().enumerate() {
            let Origin::Previous { of, frames } = image.origin else { continue };
            if plan.lifetimes[index].is_none() {
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

fn past_of(image: &VirtualImage) -> Option<ImageId> {
    match image.origin {
        Origin::Previous { of, .. } => Some(of),
        _ => None,
    }
}

/// Ring length: one texture for this frame and one for each that is remembered. All rings have the same, so that one ring_index fits all.
fn ring_length(plan: &Plan) -> u32 {
    let depth = plan.recording.images.iter().map(|image| match image.origin {
        Origin::Previous { frames, .. } => frames,
        _ => 0,
    });
    1 + depth.max().unwrap_or(0)
}

fn make_buffer(device: &Device, queue: &Queue, buffer: &VirtualBuffer) -> Buffer {
    let made = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&buffer.label),
        size: buffer.bytes.next_multiple_of(16),
        usage: BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    if let BufferLife::Constant(bytes) = &buffer.life {
        queue.write_buffer(&made, 0, bytes);
    }
    made
}
