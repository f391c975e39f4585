//! The executor: a loaded plan becomes commands in the host's encoder.

use std::ops::Range;
use std::sync::Arc;

use afterimage_graph::image::ImageDesc;
use afterimage_graph::node::{BufferLife, ImageId, Origin, Resource, Work};
use afterimage_graph::plan::{Alias, Caps, Plan, PlanOutput, Requirement, Stage, Use};
use afterimage_graph::shader::{
    Composed, FRAGMENT_SIZE_BINDING, SlotKind, compose_entry, compose_steps, compose_tiling,
};
use rustc_hash::FxHashMap;
use wgpu::{
    BindGroup, BindGroupEntry, BindingResource, Buffer, BufferUsages, CommandEncoder, Device, Queue, TextureView,
};

use crate::GpuError;
use crate::cache;
use crate::device::texture_format;
use crate::heap::{self, Heap};
use crate::layout::{Pipeline, bind_group_layout, bound_slots, by_hand};
use crate::pipelines::{Built, Order, PipelineKey, Pipelines};
use crate::store::{self, Store, TextureKey};
use crate::timing::Timing;

/// One frame's inputs, outputs and time.
#[derive(Clone, Copy, Default)]
pub struct Frame<'a> {
    /// The host's images, by the names of the pipeline's inputs.
    pub inputs: &'a [(&'a str, &'a TextureView)],
    /// Where the host wants outputs, by their names; the executor keeps a texture for each output that is not named.
    pub outputs: &'a [(&'a str, &'a TextureView)],
    /// Seconds since the start.
    pub time: f32,
    /// Seconds since the frame before.
    pub dt: f32,
    /// Whether this frame has nothing to do with the one before: a cut, a teleport.
    pub reset: bool,
}

/// Runs plans on the host's device.
pub struct Executor {
    device: Device,
    queue: Queue,
    caps: Caps,
    store: Store,
    pipelines: Pipelines,
    linear: wgpu::Sampler,
    nearest: wgpu::Sampler,
    frame_uniform: Buffer,
    loaded: Option<Loaded>,
    frame_index: u32,
    fresh: bool,
}

/// Where an image of the plan lies.
enum Holding {
    /// No pass mentions it.
    Unused,
    /// The host's image for this input.
    Input(usize),
    /// The host's image for this output, or else ours.
    Output(usize, TextureKey),
    /// Always the same texture.
    Fixed(TextureKey),
    /// A texture of a ring, so many frames behind the newest.
    Ring(Vec<TextureKey>, u32),
}

struct Loaded {
    plan: Arc<Plan>,
    passes: Vec<LoadedPass>,
    uniforms: Buffer,
    holdings: Vec<Holding>,
    buffers: Vec<Buffer>,
    zeroed: Vec<usize>,
    persistent: Vec<usize>,
    phases: u32,
    sets: Vec<HostSet>,
    timing: Option<Timing>,
    placed: Option<Placed>,
}

/// The heap of a plan and the textures in it. The textures go before the heap does.
struct Placed {
    keys: Vec<TextureKey>,
    heap: Heap,
}

struct LoadedPass {
    composed: Composed,
    groups: [u32; 3],
    /// Where its uniform begins in the one uniform buffer, and its bytes.
    uniform: (u64, u64),
    writes_image: Option<ImageId>,
    by_hand: bool,
}

/// The bind groups for one choice of host images.
struct HostSet {
    views: Vec<TextureView>,
    runs: Vec<Run>,
    /// For each pass that opens a wave, what must be brought into its state before the wave, for each phase.
    touches: Vec<Vec<Vec<Touch>>>,
}

/// A texture and the state that a wave wants it in.
struct Touch {
    view: TextureView,
    state: wgpu::TextureUses,
}

struct Run {
    pipeline: Pipeline,
    /// For each phase.
    groups: Vec<BindGroup>,
    /// The attachments of a draw, for each phase.
    attachments: Vec<Option<TextureView>>,
}

/// How many choices of host images are remembered: the images of a swap chain.
const MOST_SETS: usize = 4;
/// Uniform offsets are multiples of this everywhere.
const UNIFORM_ALIGNMENT: u64 = 256;

impl Executor {
    /// An executor on the host's device, which relies only on what every device has.
    pub fn new(device: &Device, queue: &Queue) -> Self {
        let caps = Caps {
            filter_32_bit: device.features().contains(wgpu::Features::FLOAT32_FILTERABLE),
            max_side: device.limits().max_texture_dimension_2d,
            max_volume_side: device.limits().max_texture_dimension_3d,
            ..Caps::default()
        };
        Self::with_caps(device, queue, caps)
    }

    /// An executor that relies on `caps`, from [`caps`](crate::caps).
    pub fn with_caps(device: &Device, queue: &Queue, caps: Caps) -> Self {
        let sampler = |filter| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("afterimage"),
                mag_filter: filter,
                min_filter: filter,
                ..Default::default()
            })
        };
        let frame_uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: 16,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            linear: sampler(wgpu::FilterMode::Linear),
            nearest: sampler(wgpu::FilterMode::Nearest),
            device: device.clone(),
            queue: queue.clone(),
            caps,
            store: Store::default(),
            pipelines: Pipelines::default(),
            frame_uniform,
            loaded: None,
            frame_index: 0,
            fresh: true,
        }
    }

    /// The same executor with a cache of the driver's pipelines, which begins with what [`pipeline_cache_data`](Self::pipeline_cache_data) gave
    /// once: then the driver need not compile them again. Bytes that are damaged, or of another adapter, driver or version, are left aside, and so is
    /// the cache where the device has none.
    pub fn with_pipeline_cache(mut self, data: &[u8]) -> Self {
        self.pipelines.cache = cache::open(&self.device, data);
        self
    }

    /// The driver's pipelines as bytes, for the next run of the program; `None` without a cache.
    pub fn pipeline_cache_data(&self) -> Option<Vec<u8>> {
        cache::seal(self.pipelines.cache.as_ref()?)
    }

    /// What plans for this executor may rely on.
    pub fn caps(&self) -> &Caps {
        &self.caps
    }

    /// What the device wants for an image: the planner asks this through [`Setting`](afterimage_graph::plan::Setting).
    pub fn requirement(&self, desc: &ImageDesc) -> Requirement {
        heap::requirement(&self.device, desc)
    }

    /// The plan in use.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.loaded.as_ref().map(|loaded| &loaded.plan)
    }

    /// Makes a plan the one that runs. Textures, histories, buffers and pipelines that are equal in both are kept.
    /// On an error the old plan stays; where it was the device that refused the new one, the old one's histories and adaptation begin anew.
    pub fn load(&mut self, plan: Arc<Plan>) -> Result<(), GpuError> {
        if let Some(loaded) = self.loaded.as_mut().filter(|loaded| differs_in_uniforms_only(&loaded.plan, &plan)) {
            let bytes = uniform_bytes(&plan, &loaded.passes);
            self.queue.write_buffer(&loaded.uniforms, 0, &bytes);
            loaded.plan = plan;
            return Ok(());
        }
        let before = self.loaded.as_ref().map(|loaded| loaded.plan.clone());
        let (loaded, refused) = self.prepare_watched(&plan);
        if let Some(error) = refused {
            self.restore(before);
            return Err(error);
        }
        self.loaded = Some(loaded?);
        self.store.sweep();
        Ok(())
    }

    /// A plan made ready, and what the device said against it.
    fn prepare_watched(&mut self, plan: &Arc<Plan>) -> (Result<Loaded, GpuError>, Option<GpuError>) {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let loaded = self.prepare(plan);
        let refused = pollster::block_on(validation.pop());
        let out_of_memory = pollster::block_on(memory.pop());
        let out_of_memory =
            out_of_memory.map(|error| GpuError::OutOfMemory { what: format!("the images of the plan ({error})") });
        let refused = refused.map(|error| GpuError::Refused { what: "the plan".into(), why: error.to_string() });
        (loaded, out_of_memory.or(refused))
    }

    /// Brings the old plan back, on textures of its own: some of those it had may be in the plan that was refused, and broken.
    fn restore(&mut self, plan: Option<Arc<Plan>>) {
        self.store = Store::default();
        self.fresh = true;
        self.loaded = plan.and_then(|plan| match self.prepare_watched(&plan) {
            (Ok(loaded), None) => Some(loaded),
            _ => None,
        });
    }

    /// Starts histories and adaptation anew with the next frame.
    pub fn reset(&mut self) {
        self.fresh = true;
    }

    /// Measures the GPU time of each pass from now on, if the device can.
    pub fn enable_timing(&mut self) -> bool {
        let Some(loaded) = &mut self.loaded else { return false };
        loaded.timing = Timing::new(&self.device, &self.queue, loaded.passes.len() as u32);
        loaded.timing.is_some()
    }

    /// Milliseconds of each pass of the last submitted frame. Waits for it.
    pub fn pass_times(&self) -> Option<Vec<f64>> {
        self.loaded.as_ref()?.timing.as_ref()?.read(&self.device)
    }

    /// The texture of an output that the host gave no image for.
    pub fn output(&self, name: &str) -> Option<&wgpu::Texture> {
        let loaded = self.loaded.as_ref()?;
        let output = loaded.plan.output(Some(name))?;
        match &loaded.holdings[output.image.0 as usize] {
            Holding::Output(_, key) => Some(&self.store.get(*key).texture),
            _ => None,
        }
    }

    /// Records one pass of a frame and no other, for measurements on devices whose timestamps cannot be trusted. What it reads is what the frames
    /// before have left, and time does not go on.
    pub fn encode_pass(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        pass: usize,
    ) -> Result<(), GpuError> {
        if self.loaded.is_none() {
            return Err(GpuError::NoPlan);
        }
        let set = self.host_set(frame)?;
        let loaded = self.loaded.as_ref().expect("checked above");
        let phase = (self.frame_index % loaded.phases) as usize;
        record(loaded, &loaded.sets[set], phase, pass..pass + 1, encoder);
        Ok(())
    }

    /// Records one frame.
    pub fn encode(&mut self, encoder: &mut CommandEncoder, frame: &Frame<'_>) -> Result<(), GpuError> {
        if self.loaded.is_none() {
            return Err(GpuError::NoPlan);
        }
        let reset = self.fresh || frame.reset;
        self.write_frame(frame, reset);
        let set = self.host_set(frame)?;
        let loaded = self.loaded.as_ref().expect("checked above");
        if reset {
            clear_memory(&self.device, &self.store, loaded, encoder);
        }
        for &buffer in &loaded.zeroed {
            encoder.clear_buffer(&loaded.buffers[buffer], 0, None);
        }
        let phase = (self.frame_index % loaded.phases) as usize;
        record(loaded, &loaded.sets[set], phase, 0..loaded.passes.len(), encoder);
        if let Some(timing) = &loaded.timing {
            timing.resolve(encoder);
        }
        self.frame_index = self.frame_index.wrapping_add(1);
        self.fresh = false;
        Ok(())
    }

    fn write_frame(&self, frame: &Frame<'_>, reset: bool) {
        let words =
            [frame.time.to_bits(), frame.dt.to_bits(), self.frame_index, u32::from(reset)].map(u32::to_le_bytes);
        self.queue.write_buffer(&self.frame_uniform, 0, words.as_flattened());
    }
}

/// Whether the new plan can run with the resources of the old one and other uniforms.
fn differs_in_uniforms_only(old: &Plan, new: &Plan) -> bool {
    let blank = |plan: &Plan| {
        let mut plan = plan.clone();
        for pass in &mut plan.recording.passes {
            match &mut pass.work {
                Work::Steps { steps, .. } => steps.iter_mut().for_each(|step| step.uniform.fill(0)),
                Work::Tiled(tiling) => {
                    tiling.stages.iter_mut().flat_map(|s| &mut s.steps).for_each(|step| step.uniform.fill(0));
                }
                Work::Entry(call) => call.uniform.fill(0),
            }
        }
        plan
    };
    blank(old) == blank(new)
}

fn clear_memory(device: &Device, store: &Store, loaded: &Loaded, encoder: &mut CommandEncoder) {
    for &buffer in &loaded.persistent {
        encoder.clear_buffer(&loaded.buffers[buffer], 0, None);
    }
    for holding in &loaded.holdings {
        let Holding::Ring(keys, 0) = holding else { continue };
        for key in keys {
            store::blacken(device, store.get(*key), encoder);
        }
    }
}

fn record(loaded: &Loaded, set: &HostSet, phase: usize, passes: Range<usize>, encoder: &mut CommandEncoder) {
    let mut index = passes.start;
    while index < passes.end {
        match &set.runs[index].pipeline {
            Pipeline::Compute(_) => index = record_dispatches(loaded, set, phase, index..passes.end, encoder),
            Pipeline::Render(pipeline) => {
                touch_for_draw(&set.touches[index], phase, encoder);
                record_draw(loaded, &set.runs[index], pipeline, phase, index, encoder);
                index += 1;
            }
        }
    }
}

/// One compute pass for the dispatches that these passes begin with; the index after it.
fn record_dispatches(
    loaded: &Loaded,
    set: &HostSet,
    phase: usize,
    passes: Range<usize>,
    encoder: &mut CommandEncoder,
) -> usize {
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("afterimage"), timestamp_writes: None });
    let mut index = passes.start;
    if let Some(timing) = &loaded.timing {
        pass.write_timestamp(&timing.queries, index as u32);
    }
    while let Some(Run { pipeline: Pipeline::Compute(pipeline), groups, .. }) = set.runs[..passes.end].get(index) {
        let [x, y, z] = loaded.passes[index].groups;
        if let Some(touches) = set.touches[index].get(phase) {
            let textures = touches.iter().map(|touch| wgpu::TextureTransition {
                texture: &touch.view,
                selector: None,
                state: touch.state,
            });
            pass.transition_resources(std::iter::empty(), textures);
        }
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &groups[phase], &[]);
        pass.dispatch_workgroups(x, y, z);
        index += 1;
        if let Some(timing) = &loaded.timing {
            pass.write_timestamp(&timing.queries, index as u32);
        }
    }
    index
}

/// Before a draw there is no compute pass to touch things in. Reading is the state from which a barrier waits for all shaders before.
fn touch_for_draw(touches: &[Vec<Touch>], phase: usize, encoder: &mut CommandEncoder) {
    let Some(touches) = touches.get(phase) else { return };
    let new = touches.iter().filter(|touch| touch.state != wgpu::TextureUses::RESOURCE);
    let textures = new.map(|touch| wgpu::TextureTransition {
        texture: touch.view.texture(),
        selector: None,
        state: wgpu::TextureUses::RESOURCE,
    });
    encoder.transition_resources(std::iter::empty(), textures);
}

fn record_draw(
    loaded: &Loaded,
    run: &Run,
    pipeline: &wgpu::RenderPipeline,
    phase: usize,
    index: usize,
    encoder: &mut CommandEncoder,
) {
    let view = run.attachments[phase].as_ref().expect("a draw has an attachment");
    if let Some(timing) = &loaded.timing {
        encoder.write_timestamp(&timing.queries, index as u32);
    }
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("afterimage"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            // The triangle covers every pixel.
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &run.groups[phase], &[]);
    pass.draw(0..3, 0..1);
    drop(pass);
    if let Some(timing) = &loaded.timing {
        encoder.write_timestamp(&timing.queries, index as u32 + 1);
    }
}

// Loading.
impl Executor {
    fn prepare(&mut self, plan: &Arc<Plan>) -> Result<Loaded, GpuError> {
        let mut passes = Vec::with_capacity(plan.recording.passes.len());
        let mut offset = 0;
        for index in 0..plan.recording.passes.len() {
            let pass = load_pass(plan, index, offset)?;
            offset += pass.uniform.1.next_multiple_of(UNIFORM_ALIGNMENT) + UNIFORM_ALIGNMENT;
            passes.push(pass);
        }
        let uniforms = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: offset.max(UNIFORM_ALIGNMENT),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&uniforms, 0, &uniform_bytes(plan, &passes));
        let old = self.loaded.take();
        let (buffers, old_holdings, timed) = self.make_buffers(plan, old);
        let placed = self.place(plan);
        let holdings = self.hold(plan, old_holdings, placed.as_ref());
        let lives = |wanted: fn(&BufferLife) -> bool| {
            let buffers = plan.recording.buffers.iter().enumerate();
            buffers.filter(|(_, b)| wanted(&b.life)).map(|(index, _)| index).collect::<Vec<_>>()
        };
        let mut loaded = Loaded {
            zeroed: lives(|life| *life == BufferLife::Zeroed),
            persistent: lives(|life| *life == BufferLife::Persistent),
            phases: phases(plan),
            plan: plan.clone(),
            passes,
            uniforms,
            holdings,
            buffers,
            sets: Vec::new(),
            timing: None,
            placed,
        };
        if timed {
            loaded.timing = Timing::new(&self.device, &self.queue, loaded.passes.len() as u32);
        }
        self.build_all(&loaded);
        Ok(loaded)
    }

    /// Buffers of the plan; those that outlive frames keep what they hold where the old plan had the same.
    fn make_buffers(
        &mut self,
        plan: &Plan,
        old: Option<Loaded>,
    ) -> (Vec<Buffer>, FxHashMap<String, Vec<TextureKey>>, bool) {
        let mut kept: FxHashMap<(String, u64), Buffer> = FxHashMap::default();
        let mut rings = FxHashMap::default();
        let timed = old.as_ref().is_some_and(|old| old.timing.is_some());
        if let Some(mut old) = old {
            // Bind groups hold views; they go before the heap under the textures does.
            old.sets.clear();
            if let Some(Placed { keys, heap }) = old.placed.take() {
                keys.into_iter().for_each(|key| self.store.remove(key));
                drop(heap);
            }
            for (virtual_buffer, buffer) in old.plan.recording.buffers.iter().zip(old.buffers) {
                if virtual_buffer.life == BufferLife::Persistent {
                    kept.insert((virtual_buffer.label.clone(), virtual_buffer.bytes), buffer);
                }
            }
            for (image, holding) in old.plan.recording.images.iter().zip(old.holdings) {
                match holding {
                    Holding::Ring(keys, 0) => {
                        rings.insert(image.label.clone(), keys);
                    }
                    Holding::Output(_, key) => self.store.retire([key]),
                    Holding::Fixed(key) if !matches!(image.origin, Origin::Constant(_)) && self.store.has(key) => {
                        self.store.retire([key]);
                    }
                    _ => {}
                }
            }
        }
        let make = |buffer: &afterimage_graph::node::VirtualBuffer| {
            let known = kept.remove(&(buffer.label.clone(), buffer.bytes));
            known.unwrap_or_else(|| make_buffer(&self.device, &self.queue, buffer))
        };
        (plan.recording.buffers.iter().map(make).collect(), rings, timed)
    }

    /// The plan's transient images in one heap, where the plan and the backend allow it.
    fn place(&mut self, plan: &Plan) -> Option<Placed> {
        let residents = plan.memory.offset_of.iter().enumerate().filter_map(|(index, at)| Some((index, (*at)?)));
        let residents: Vec<(usize, u64)> = residents.collect();
        if plan.options.alias != Alias::Placed || residents.is_empty() {
            return None;
        }
        let descs: Vec<ImageDesc> = residents.iter().map(|(index, _)| plan.recording.images[*index].desc).collect();
        let heap = Heap::new(&self.device, plan.memory.heap, &descs)?;
        let mut keys = Vec::new();
        for ((index, offset), desc) in residents.iter().zip(descs) {
            match heap.place(desc, *offset, &plan.recording.images[*index].label) {
                Some(stored) => keys.push(self.store.insert(stored)),
                None => {
                    keys.into_iter().for_each(|key| self.store.remove(key));
                    return None;
                }
            }
        }
        Some(Placed { keys, heap })
    }

    fn hold(
        &mut self,
        plan: &Plan,
        mut old_rings: FxHashMap<String, Vec<TextureKey>>,
        placed: Option<&Placed>,
    ) -> Vec<Holding> {
        let mut in_heap = placed.map(|placed| placed.keys.iter().copied());
        let mut slots: Vec<Option<TextureKey>> = vec![None; plan.memory.slots.len()];
        let mut holdings: Vec<Holding> = Vec::with_capacity(plan.recording.images.len());
        let length = phases(plan);
        for (index, image) in plan.recording.images.iter().enumerate() {
            let id = ImageId(index as u32);
            let remembered =
                plan.recording.images.iter().any(|i| matches!(i.origin, Origin::Previous { of, .. } if of == id));
            let output = plan.outputs.iter().position(|output| output.image == id);
            let holding = match (&image.origin, plan.lifetimes[index]) {
                (_, None) => Holding::Unused,
                (Origin::Input(name), _) => {
                    let input = plan.inputs.iter().position(|(input, _)| input == name);
                    Holding::Input(input.expect("every input image is listed"))
                }
                (Origin::Constant(bytes), _) => {
                    Holding::Fixed(self.store.constant(&self.device, &self.queue, image.desc, bytes))
                }
                // Filled in below, once the image that it is the past of has its ring.
                (Origin::Previous { .. }, _) => Holding::Unused,
                (Origin::Transient, _) if remembered => {
                    let known = old_rings.remove(&image.label);
                    let fits = known
                        .filter(|keys| keys.len() == length as usize && self.store.get(keys[0]).desc == image.desc);
                    let ring = fits.unwrap_or_else(|| {
                        self.fresh = true;
                        (0..length).map(|_| self.store.take(&self.device, image.desc, &image.label)).collect()
                    });
                    Holding::Ring(ring, 0)
                }
                (Origin::Transient, _) => match output {
                    Some(output) => Holding::Output(output, self.store.take(&self.device, image.desc, &image.label)),
                    None if plan.memory.offset_of[index].is_some() && in_heap.is_some() => {
                        let next = in_heap.as_mut().and_then(Iterator::next);
                        Holding::Fixed(next.expect("the heap was filled in the order of the images"))
                    }
                    None => {
                        let slot = plan.memory.slot_of[index].expect("a transient that is used has a slot") as usize;
                        let key = *slots[slot].get_or_insert_with(|| {
                            self.store.take(&self.device, plan.memory.slots[slot].desc, "transients")
                        });
                        Holding::Fixed(key)
                    }
                },
            };
            holdings.push(holding);
        }
        for (index, image) in plan.recording.images.iter().enumerate() {
            let Origin::Previous { of, frames } = image.origin else { continue };
            if let Holding::Ring(keys, _) = &holdings[of.0 as usize] {
                holdings[index] = Holding::Ring(keys.clone(), frames);
            } else {
                // The image is never written in this plan: its past is black, as a new texture is.
                let black = store::create(&self.device, image.desc, &image.label);
                holdings[index] = Holding::Fixed(self.store.insert(black));
            }
        }
        self.store.retire(old_rings.into_values().flatten());
        holdings
    }

    fn order<'a>(&self, loaded: &'a Loaded, index: usize, attachment: Option<wgpu::TextureFormat>) -> Order<'a> {
        let (plan, pass) = (&loaded.plan, &loaded.passes[index]);
        let stage = if attachment.is_some() { Stage::Fragment } else { Stage::Compute };
        let constants = match &plan.recording.passes[index].work {
            Work::Entry(call) => call.constants.iter().map(|(name, value)| (*name, value.to_bits())).collect(),
            Work::Steps { .. } | Work::Tiled(_) => Vec::new(),
        };
        let readings = pass.composed.slots.iter().map(|slot| match slot.kind {
            SlotKind::Texture(image) => format!("{:?}", plan.readings[image.0 as usize]),
            _ => String::new(),
        });
        let layout: Vec<String> = readings.collect();
        Order {
            key: PipelineKey {
                source: pass.composed.source.clone(),
                entry: pass.composed.compute,
                constants,
                attachment,
                layout: layout.join(","),
            },
            composed: &pass.composed,
            stage,
            layout: bind_group_layout(&self.device, plan, &pass.composed, stage),
            label: &plan.recording.passes[index].label,
            // Tilings write every texel of a tile that they read; whole kernels are their authors' own.
            zero_workgroup_memory: matches!(plan.recording.passes[index].work, Work::Entry(_)),
        }
    }

    fn planned_attachment(loaded: &Loaded, index: usize) -> Option<wgpu::TextureFormat> {
        let image = loaded.passes[index].writes_image.filter(|_| loaded.plan.stages[index] == Stage::Fragment)?;
        Some(texture_format(loaded.plan.format(image)))
    }

    fn build_all(&mut self, loaded: &Loaded) {
        let orders = (0..loaded.passes.len())
            .map(|index| self.order(loaded, index, Self::planned_attachment(loaded, index)))
            .collect();
        self.pipelines.build(&self.device, orders);
    }

    /// The bind groups for this frame's host images: remembered, or made.
    fn host_set(&mut self, frame: &Frame<'_>) -> Result<usize, GpuError> {
        let loaded = self.loaded.as_ref().expect("a plan is loaded");
        if let Some(known) = loaded.sets.iter().position(|set| same_views(&self.store, loaded, set, frame)) {
            return Ok(known);
        }
        let views = chosen_views(&self.store, loaded, frame)?;
        let set = self.make_set(views);
        let loaded = self.loaded.as_mut().expect("a plan is loaded");
        if loaded.sets.len() == MOST_SETS {
            loaded.sets.remove(0);
        }
        loaded.sets.push(set);
        Ok(loaded.sets.len() - 1)
    }

    fn make_set(&mut self, views: Vec<TextureView>) -> HostSet {
        let loaded = self.loaded.take().expect("a plan is loaded");
        let runs = (0..loaded.passes.len()).map(|index| self.make_run(&loaded, index, &views)).collect();
        let touches = (0..loaded.passes.len()).map(|index| self.make_touches(&loaded, index, &views)).collect();
        self.loaded = Some(loaded);
        HostSet { views, runs, touches }
    }

    /// What must happen before the wave that this pass opens. Images that several passes of the wave read change their state in one batch, so
    /// that the passes can overlap. A new resident of shared memory is touched: its first mention in the frame records a state only, and the
    /// write that follows is then a second one, before which the device must wait for all that ran before.
    fn make_touches(&self, loaded: &Loaded, index: usize, views: &[TextureView]) -> Vec<Vec<Touch>> {
        let plan = &loaded.plan;
        let Some(wave) = plan.waves.iter().position(|wave| wave.start == index) else { return Vec::new() };
        let mut wanted: Vec<(ImageId, wgpu::TextureUses)> = Vec::new();
        if plan.waves[wave].len() > 1 {
            let read = plan.barriers[wave].transitions.iter().filter(|t| t.to == Use::Read);
            wanted.extend(read.filter_map(|t| match t.resource {
                Resource::Image(image) => Some((image, wgpu::TextureUses::RESOURCE)),
                Resource::Buffer(_) => None,
            }));
        }
        if loaded.placed.is_some() {
            let new = plan.barriers[wave].hand_overs.iter().map(|hand_over| hand_over.image);
            wanted.extend(new.map(|image| (image, wgpu::TextureUses::STORAGE_WRITE_ONLY)));
        }
        if wanted.is_empty() {
            return Vec::new();
        }
        let touch = |(image, state): &(ImageId, wgpu::TextureUses), phase| {
            let view = self.view(loaded, *image, views, phase).clone();
            let storable = view.texture().usage().contains(wgpu::TextureUsages::STORAGE_BINDING);
            let state = if storable { *state } else { wgpu::TextureUses::RESOURCE };
            Touch { view, state }
        };
        (0..loaded.phases).map(|phase| wanted.iter().map(|wanted| touch(wanted, phase)).collect()).collect()
    }

    fn make_run(&mut self, loaded: &Loaded, index: usize, views: &[TextureView]) -> Run {
        let pass = &loaded.passes[index];
        let host_attachment = pass.writes_image.and_then(|image| attachment_of_host(loaded, image, views));
        let attachment = host_attachment.or_else(|| Self::planned_attachment(loaded, index));
        let order = self.order(loaded, index, attachment);
        let key = order.key.clone();
        self.pipelines.build(&self.device, vec![order]);
        let Built { pipeline, layout } = self.pipelines.get(&key).expect("it was built above").clone();
        let stage = if attachment.is_some() { Stage::Fragment } else { Stage::Compute };
        let phases = 0..loaded.phases;
        let groups = phases.clone().map(|phase| self.bind_group(loaded, pass, stage, &layout, views, phase)).collect();
        let target = |phase| match (stage, pass.writes_image) {
            (Stage::Fragment, Some(image)) => Some(self.view(loaded, image, views, phase).clone()),
            _ => None,
        };
        Run { pipeline, groups, attachments: phases.map(target).collect() }
    }

    fn view<'a>(&'a self, loaded: &'a Loaded, image: ImageId, views: &'a [TextureView], phase: u32) -> &'a TextureView {
        match &loaded.holdings[image.0 as usize] {
            Holding::Input(index) => &views[*index],
            Holding::Output(index, _) => &views[loaded.plan.inputs.len() + index],
            Holding::Fixed(key) => &self.store.get(*key).view,
            Holding::Ring(keys, behind) => {
                let length = keys.len() as u32;
                &self.store.get(keys[((phase + length - behind % length) % length) as usize]).view
            }
            Holding::Unused => panic!("image {image:?} is bound but no pass mentions it"),
        }
    }

    fn bind_group(
        &self,
        loaded: &Loaded,
        pass: &LoadedPass,
        stage: Stage,
        layout: &wgpu::BindGroupLayout,
        views: &[TextureView],
        phase: u32,
    ) -> BindGroup {
        let (offset, bytes) = pass.uniform;
        let region = |offset, bytes| {
            BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &loaded.uniforms,
                offset,
                size: std::num::NonZeroU64::new(bytes),
            })
        };
        let resource = |kind| match kind {
            SlotKind::Frame => self.frame_uniform.as_entire_binding(),
            SlotKind::Params => region(offset, bytes),
            SlotKind::Sampler => BindingResource::Sampler(if pass.by_hand { &self.nearest } else { &self.linear }),
            SlotKind::Texture(image) | SlotKind::Storage(image) => {
                BindingResource::TextureView(self.view(loaded, image, views, phase))
            }
            SlotKind::Buffer(buffer, _) => loaded.buffers[buffer.0 as usize].as_entire_binding(),
        };
        let mut entries: Vec<BindGroupEntry<'_>> = bound_slots(&pass.composed, stage)
            .map(|slot| BindGroupEntry { binding: slot.binding, resource: resource(slot.kind) })
            .collect();
        if stage == Stage::Fragment {
            let size_at = offset + bytes.next_multiple_of(UNIFORM_ALIGNMENT);
            entries.push(BindGroupEntry { binding: FRAGMENT_SIZE_BINDING, resource: region(size_at, 16) });
        }
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}

fn make_buffer(device: &Device, queue: &Queue, buffer: &afterimage_graph::node::VirtualBuffer) -> Buffer {
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

/// Ring length: one texture for this frame and one for each that is remembered. All rings have the same, so that one phase fits all.
fn phases(plan: &Plan) -> u32 {
    let depth = plan.recording.images.iter().map(|image| match image.origin {
        Origin::Previous { frames, .. } => frames,
        _ => 0,
    });
    1 + depth.max().unwrap_or(0)
}

fn load_pass(plan: &Plan, index: usize, offset: u64) -> Result<LoadedPass, GpuError> {
    let pass = &plan.recording.passes[index];
    let reading = |image: ImageId| plan.readings[image.0 as usize];
    let format = |image: ImageId| plan.format(image);
    let (composed, groups) = match &pass.work {
        Work::Steps { steps, result } => {
            let composed = compose_steps(steps, *result, format(*result), &reading);
            let size = plan.recording.image(*result).desc.size.div_up(16);
            (composed, [size.width, size.height, 1])
        }
        Work::Tiled(tiling) => {
            let last = tiling.stages.last().expect("a tiling has stages").size.div_up(tiling.tile);
            (compose_tiling(tiling, &format, &reading), [last.width, last.height, 1])
        }
        Work::Entry(call) => (compose_entry(call, &format, &reading), call.groups),
    };
    let composed = composed.map_err(GpuError::Shader)?;
    let writes_image = pass.writes().into_iter().find_map(|resource| match resource {
        Resource::Image(image) => Some(image),
        Resource::Buffer(_) => None,
    });
    let by_hand = by_hand(&composed);
    Ok(LoadedPass { composed, groups, uniform: (offset, pass_uniform(&pass.work).len() as u64), writes_image, by_hand })
}

/// The uniform of a pass: its steps' structs, each at a multiple of 16.
fn pass_uniform(work: &Work) -> Vec<u8> {
    let mut bytes = Vec::new();
    let parts: Vec<&[u8]> = match work {
        Work::Steps { steps, .. } => steps.iter().map(|step| step.uniform.as_slice()).collect(),
        Work::Tiled(tiling) => {
            for stage in &tiling.stages {
                let size = [stage.size.width, stage.size.height, 0, 0];
                bytes.extend(size.iter().flat_map(|x| x.to_le_bytes()));
            }
            tiling.stages.iter().flat_map(|stage| &stage.steps).map(|step| step.uniform.as_slice()).collect()
        }
        Work::Entry(call) => vec![&call.uniform],
    };
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        bytes.resize(bytes.len().next_multiple_of(16), 0);
        bytes.extend_from_slice(part);
    }
    bytes.resize(bytes.len().next_multiple_of(16), 0);
    bytes
}

/// The contents of the one uniform buffer: for each pass its uniform, then the size of its result.
fn uniform_bytes(plan: &Plan, passes: &[LoadedPass]) -> Vec<u8> {
    let mut all = Vec::new();
    for (pass, loaded) in plan.recording.passes.iter().zip(passes) {
        all.extend(pass_uniform(&pass.work));
        all.resize(all.len().next_multiple_of(UNIFORM_ALIGNMENT as usize), 0);
        let size = loaded.writes_image.map_or([1.0; 2], |image| {
            let size = plan.recording.image(image).desc.size;
            [size.width as f32, size.height as f32]
        });
        all.extend(size.iter().flat_map(|x| x.to_le_bytes()));
        all.resize(all.len().next_multiple_of(UNIFORM_ALIGNMENT as usize), 0);
    }
    all
}

fn named<'a>(views: &[(&str, &'a TextureView)], name: &str) -> Option<&'a TextureView> {
    views.iter().find(|(known, _)| *known == name).map(|(_, view)| *view)
}

/// Whether a set was made for exactly these host images.
fn same_views(store: &Store, loaded: &Loaded, set: &HostSet, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = set.views.split_at(loaded.plan.inputs.len());
    let same_input = |((name, _), view): (&(String, ImageId), &TextureView)| named(frame.inputs, name) == Some(view);
    let same_output =
        |(output, view): (&PlanOutput, &TextureView)| output_view(store, loaded, output, frame) == Some(view);
    loaded.plan.inputs.iter().zip(inputs).all(same_input) && loaded.plan.outputs.iter().zip(outputs).all(same_output)
}

/// Where an output goes: to the host's image, or to ours.
fn output_view<'a>(
    store: &'a Store,
    loaded: &Loaded,
    output: &PlanOutput,
    frame: &Frame<'a>,
) -> Option<&'a TextureView> {
    named(frame.outputs, &output.name).or_else(|| match &loaded.holdings[output.image.0 as usize] {
        Holding::Output(_, key) => Some(&store.get(*key).view),
        _ => None,
    })
}

/// The views of all inputs, then of all outputs; ours where the host gives none.
fn chosen_views(store: &Store, loaded: &Loaded, frame: &Frame<'_>) -> Result<Vec<TextureView>, GpuError> {
    let plan = &loaded.plan;
    let mut views = Vec::with_capacity(plan.inputs.len() + plan.outputs.len());
    for (name, image) in &plan.inputs {
        let view = named(frame.inputs, name).ok_or_else(|| GpuError::MissingInput(name.clone()))?;
        check_host_image(plan, name, *image, view, true)?;
        views.push(view.clone());
    }
    for output in &plan.outputs {
        let view =
            output_view(store, loaded, output, frame).expect("the planner gives each output an image of its own");
        check_host_image(plan, &output.name, output.image, view, false)?;
        views.push(view.clone());
    }
    Ok(views)
}

fn check_host_image(
    plan: &Plan,
    port: &str,
    image: ImageId,
    view: &TextureView,
    is_input: bool,
) -> Result<(), GpuError> {
    let (texture, desc) = (view.texture(), plan.recording.image(image).desc);
    let same_size = (texture.width(), texture.height()) == (desc.size.width, desc.size.height);
    let suits = if is_input {
        texture.format() == texture_format(desc.format)
    } else {
        !must_be_drawn(plan, image, texture) || can_be_drawn(plan, image)
    };
    if same_size && suits {
        return Ok(());
    }
    Err(GpuError::WrongImage {
        port: port.to_owned(),
        given: format!("{}x{} {:?}", texture.width(), texture.height(), texture.format()),
        planned: format!("{} {}", desc.size, desc.format.name()),
    })
}

/// Whether passes cannot store to the host's image for an output: it has another format, or is not made for it.
fn must_be_drawn(plan: &Plan, image: ImageId, texture: &wgpu::Texture) -> bool {
    let storable = texture.usage().contains(wgpu::TextureUsages::STORAGE_BINDING);
    texture.format() != texture_format(plan.format(image)) || !storable
}

/// Whether kernel functions make the image: whole kernels store, and cannot draw.
fn can_be_drawn(plan: &Plan, image: ImageId) -> bool {
    plan.recording.passes.iter().any(|pass| matches!(pass.work, Work::Steps { result, .. } if result == image))
}

/// The attachment's format if the host's output image must be drawn to.
fn attachment_of_host(loaded: &Loaded, image: ImageId, views: &[TextureView]) -> Option<wgpu::TextureFormat> {
    let Holding::Output(index, _) = &loaded.holdings[image.0 as usize] else { return None };
    let texture = views[loaded.plan.inputs.len() + index].texture();
    must_be_drawn(&loaded.plan, image, texture).then(|| texture.format())
}
