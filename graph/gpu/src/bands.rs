//! Images that exceed the limits of the device, rendered in bands of rows: see [`Plan::banding`].

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};

use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::{BlockData, BufferLife, Origin, Resource};
use afterimage_plan::codegen::{CodeOptions, Composed, SlotKind, compose_pass};
use afterimage_plan::{
    Band, BandLimits, Banding, Halos, InputRows, Plan, PlanError, PlanOutput, PlannedImage, Stage, Sweep,
};
use afterimage_wgsl::{BandedModule, banded};
use wgpu::{BindGroupEntry, BufferUsages, ShaderStages};

use crate::bind_group::{PassBindings, Samplers, part};
use crate::buffer::{buffer, filled_buffer};
use crate::device::BLOCK;
use crate::executor::cores;
use crate::executor::loaded::uniforms::UNIFORMS;
use crate::frame_constants::{FrameConstants, code_options};
use crate::full_screen::color_pass;
use crate::heap;
use crate::layout::Pipeline;
use crate::pipelines::{Built, PipelineRequest, Pipelines};
use crate::platform::{submit, wait, watched};
use crate::store::{self, Stored};
use crate::stream::RowUpload;
use crate::texture_format::texture_format;
use crate::{FrameStep, Gpu, GpuError, Readback};

/// Source of image rows. Called on a prefetch thread.
pub trait BandReader: Send {
    /// The errors of files.
    type Error: From<GpuError> + From<PlanError> + Send;

    /// Puts the texels of some rows of the image of an input, without gaps, into `texels`, which holds those of an
    /// earlier call. Rows are asked for from the top to the bottom, with some rows again, and in several sweeps: no
    /// later call of a sweep asks for a row before `needed`, which is `rows.start` at most.
    ///
    /// # Errors
    /// The rows cannot be read.
    fn read(&mut self, input: &str, rows: Range<u32>, needed: u32, texels: &mut Vec<u8>) -> Result<(), Self::Error>;
}

/// Sink of image rows. Called on a writer thread.
pub trait BandWriter: Send {
    /// The errors of files.
    type Error: Send;

    /// Takes the texels of some rows of an output, without gaps, from the top to the bottom. The first row comes again
    /// when the image is rendered again with taller bands. The memory of `texels` is reused, whatever is left in it.
    ///
    /// # Errors
    /// The rows cannot be written.
    fn write(&mut self, output: &str, rows: Range<u32>, texels: &mut Vec<u8>) -> Result<(), Self::Error>;
}

/// Statistics of an image that was rendered in bands.
#[derive(Clone, Debug, PartialEq)]
pub struct BandStats {
    /// Number of sweeps over the image.
    pub sweeps: usize,
    /// Number of bands of all sweeps.
    pub bands: usize,
    /// Number of attempts: the first one, and one for each time that bands had to be taller.
    pub starts: usize,
    /// Planned bytes of images and buffers on the device, with staging buffers and memory that was in use before.
    pub bytes: u64,
    /// Bytes that wgpu has allocated for them and for everything else, with host-visible memory, if the backend knows
    /// it.
    pub allocated: Option<u64>,
    /// The requested values; `None` for one that the plan does not have.
    pub values: Vec<Option<[f32; 4]>>,
}

/// Blocks that small images and buffers do not fill: one of each kind of memory, and one more.
const SHARED_BLOCKS: u64 = 4;

/// Bands of rows that are ready on each side of the device.
const AHEAD: usize = 1;

/// A frame that is rendered in bands, except for its images.
pub struct BandedFrame<'a> {
    /// Its position in time. Histories are black, as in a first frame.
    pub step: FrameStep,
    /// The number from which noise is made.
    pub number: u32,
    /// The host blocks, by the names of the inputs.
    pub blocks: &'a BTreeMap<String, BlockData>,
    /// The values of nodes to read after the frame, by `node.port`.
    pub values: &'a [String],
}

/// Renders one frame in bands, bit-identical to the plan on whole images.
///
/// # Errors
/// A node cannot run in bands, no band is small enough, or the device or the files fail.
pub fn render_in_bands<R: BandReader, W: BandWriter<Error = R::Error>>(
    gpu: &Gpu,
    plan: &Plan,
    limits: BandLimits,
    frame: &BandedFrame<'_>,
    (reader, writer): (&mut R, &mut W),
) -> Result<BandStats, R::Error> {
    let device = &gpu.device;
    let mut halos = Halos::default();
    let limits = BandLimits { side: limits.side.min(device.limits().max_texture_dimension_2d), ..limits };
    for starts in 1.. {
        let banding = plan.banding(limits, &halos, &|desc| heap::requirement(device, desc))?;
        let compiled = compile::<R::Error>(device, plan, &banding, &gpu.pipelines)?;
        let constants = FrameConstants::new(frame.step.time, frame.step.dt, frame.number, true);
        let mut renderer = BandRenderer::new(gpu, plan, &banding, &compiled, &constants, frame.blocks)?;
        if let Some(missing) = renderer.probe()? {
            // Bands elsewhere may begin at another fraction of a row.
            widen(&mut halos, plan, &banding, missing, |rows| rows + 1);
        } else if let Some(missing) = renderer.render(reader, writer)? {
            // The halo depends on pixels, and others may need a larger one.
            widen(&mut halos, plan, &banding, missing, |rows| 2 * rows);
        } else {
            let bands = banding.sweeps.iter().map(|sweep| sweep.bands.len()).sum();
            let sweeps = banding.sweeps.iter().filter(|sweep| !sweep.bands.is_empty()).count();
            let values = renderer.values(frame.values, &Readback::new(device, &gpu.queue))?;
            let allocated = device.generate_allocator_report().map(|report| report.total_reserved_bytes);
            return Ok(BandStats { sweeps, bands, starts, bytes: banding.bytes, allocated, values });
        }
        // The memory is freed before the next attempt allocates.
        drop(renderer);
        wait(device, None)?;
    }
    unreachable!("in the end a band is the whole image")
}

/// Bytes of device memory for a frame of whole images, with its staging buffers.
pub fn bytes_of_whole_frame(gpu: &Gpu, plan: &Plan, inputs: &[(&str, ImageDesc)]) -> u64 {
    let readback = Readback::new(&gpu.device, &gpu.queue);
    let inputs = inputs.iter().map(|(_, desc)| heap::requirement(&gpu.device, desc).bytes + desc.bytes());
    let buffers = plan.buffers.iter().map(|buffer| buffer.bytes);
    let outputs = plan.outputs.iter().map(|output| readback.bytes_of(&plan.image(output.image).desc));
    let images = plan.memory.bytes(plan.options.alias) + plan.memory.kept;
    images + inputs.chain(buffers).sum::<u64>() + outputs.max().unwrap_or(0) + SHARED_BLOCKS * BLOCK
}

/// Rows that a pass lacks, above and below, in images of a size.
type Missing = (usize, usize, [u32; 2]);

/// A pass that is compiled.
struct Compiled {
    composed: Composed,
    built: Built,
}

/// Renders the bands of one image: textures, bind groups, commands and transfers.
struct BandRenderer<'a> {
    gpu: &'a Gpu,
    plan: &'a Plan,
    banding: &'a Banding,
    images: Vec<Option<Stored>>,
    buffers: Vec<wgpu::Buffer>,
    compiled: &'a BTreeMap<usize, Compiled>,
    /// The bind groups of the passes that may run.
    groups: BTreeMap<usize, Vec<wgpu::BindGroup>>,
    samplers: Samplers,
    frame: wgpu::Buffer,
    window_layout: wgpu::BindGroupLayout,
    /// The first rows of the bands, one region for each pass.
    windows: wgpu::Buffer,
    missing: wgpu::Buffer,
    uniforms: wgpu::Buffer,
    upload: RowUpload,
}

/// Rows in transfer: the name of the output, its rows, and their texels.
type Rows<'a> = (&'a str, Range<u32>, Vec<u8>);

/// Channels of the prefetch and writer threads, with those that return memory for reuse.
struct Streams<'a, E> {
    read: Receiver<Result<Vec<u8>, E>>,
    uploaded: Sender<Vec<u8>>,
    write: SyncSender<Rows<'a>>,
    written: Receiver<Vec<u8>>,
}

/// A pass, its workgroups, and the rows of the target that a draw covers; `None` for all rows.
type Run = (usize, [u32; 3], Option<Range<u32>>);

const STORAGE: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_DST).union(BufferUsages::COPY_SRC);

impl<'a> BandRenderer<'a> {
    fn new(
        gpu: &'a Gpu,
        plan: &'a Plan,
        banding: &'a Banding,
        compiled: &'a BTreeMap<usize, Compiled>,
        constants: &FrameConstants,
        blocks: &BTreeMap<String, BlockData>,
    ) -> Result<Self, GpuError> {
        let device = &gpu.device;
        watched(device, "an image in bands", || {
            let missing_bytes = 8 * (plan.passes.len() * banding.sizes.len()).max(1) as u64;
            let mut renderer = Self {
                gpu,
                plan,
                banding,
                images: vec![None; plan.images.len()],
                buffers: Vec::new(),
                compiled,
                groups: BTreeMap::new(),
                samplers: Samplers::new(device),
                frame: filled_buffer(device, "frame", constants.bytes(true), UNIFORMS)?,
                window_layout: window_layout(device),
                windows: buffer(device, "bands", region(banding) * plan.passes.len() as u64, UNIFORMS),
                missing: buffer(device, "missing rows", missing_bytes, STORAGE),
                uniforms: filled_buffer(device, "uniforms", &uniforms(plan, blocks), UNIFORMS)?,
                upload: RowUpload::new(
                    gpu,
                    banding.piece,
                    plan.inputs.iter().map(|(_, image)| plan.image(*image).desc),
                ),
            };
            renderer.buffers = renderer.buffers()?;
            Ok(renderer)
        })
    }

    /// Allocates the textures of the passes before a sweep, or of its bands, and frees all others.
    fn enter(&mut self, sweep: usize, in_bands: bool) -> Result<(), GpuError> {
        let device = &self.gpu.device;
        let lives = &self.banding.lives[2 * sweep + usize::from(in_bands)];
        self.groups.clear();
        let mut is_any_gone = false;
        for (stored, _) in self.images.iter_mut().zip(lives).filter(|(stored, lives)| stored.is_some() && !**lives) {
            *stored = None;
            is_any_gone = true;
        }
        if is_any_gone {
            // Their memory is free when nothing uses it.
            wait(device, None)?;
        }
        watched(device, "the images of a sweep", || {
            for image in (0..lives.len()).filter(|image| lives[*image]) {
                if self.images[image].is_none() {
                    self.images[image] = Some(self.texture(image)?);
                }
            }
            let sweep = &self.banding.sweeps[sweep];
            let bands = sweep.bands.iter().flat_map(|band| &band.passes).map(|run| run.pass);
            let passes: BTreeSet<usize> =
                if in_bands { bands.collect() } else { sweep.before.iter().copied().collect() };
            self.groups = passes.into_iter().map(|pass| (pass, self.bind(pass, in_bands))).collect();
            Ok(())
        })
    }

    fn texture(&self, image: usize) -> Result<Stored, GpuError> {
        let PlannedImage { desc, label, origin, .. } = &self.plan.images[image];
        let rows = self.banding.images[image].map_or(desc.size.height, |_| self.banding.rows[image]);
        let desc = ImageDesc { size: Size { height: rows, ..desc.size }, ..*desc };
        let stored = store::create(&self.gpu.device, desc, label);
        if let Origin::Constant(bytes) = origin {
            store::upload(&self.gpu.queue, &stored.texture, desc, bytes)?;
        }
        Ok(stored)
    }

    fn buffers(&self) -> Result<Vec<wgpu::Buffer>, GpuError> {
        let mut buffers = Vec::new();
        for described in &self.plan.buffers {
            let bytes = described.bytes.next_multiple_of(16);
            buffers.push(match &described.life {
                BufferLife::Constant(bytes) => filled_buffer(&self.gpu.device, &described.label, bytes, STORAGE)?,
                _ => buffer(&self.gpu.device, &described.label, bytes, STORAGE),
            });
        }
        Ok(buffers)
    }

    fn image(&self, image: usize) -> &Stored {
        self.images[image].as_ref().expect("the images of a pass have textures")
    }

    /// The index of the size of an image in bands.
    fn place(&self, resource: Resource) -> Option<usize> {
        self.banding.images[resource.image()?.0 as usize]
    }

    fn bind(&self, pass: usize, in_bands: bool) -> Vec<wgpu::BindGroup> {
        let device = &self.gpu.device;
        let Compiled { composed, built } = &self.compiled[&pass];
        let bindings = PassBindings {
            plan: self.plan,
            pass,
            composed,
            stage: self.plan.passes[pass].stage,
            samplers: &self.samplers,
            frame: &self.frame,
            uniforms: &self.uniforms,
            buffers: &self.buffers,
            view: &|image| &self.image(image.0 as usize).view,
        };
        let mut groups = vec![bindings.bind_group(device, &built.layout)];
        if in_bands {
            let bytes = region(self.banding);
            let windows = part(&self.windows, bytes * pass as u64, bytes);
            let entries = [(0, windows), (1, self.missing.as_entire_binding())];
            let entries = &entries.map(|(binding, resource)| BindGroupEntry { binding, resource });
            let layout = &self.window_layout;
            groups.push(device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries }));
        }
        groups
    }

    fn values(&self, labels: &[String], readback: &Readback) -> Result<Vec<Option<[f32; 4]>>, GpuError> {
        let place = |label: &String| self.plan.buffers.iter().position(|buffer| buffer.label == *label);
        let value = |label| place(label).map(|index| readback.value(&self.buffers[index])).transpose();
        labels.iter().map(value).collect()
    }

    /// The rows of the inputs that are whole, in pieces.
    fn whole_inputs(&self) -> Vec<InputRows> {
        let mut rows = Vec::new();
        for (_, image) in &self.plan.inputs {
            let PlannedImage { desc, lifetime, .. } = self.plan.image(*image);
            if lifetime.is_some() && self.place(Resource::Image(*image)).is_none() {
                let Size { width, height, depth } = desc.size;
                let row = u64::from(width) * desc.format.bytes();
                let piece = (self.banding.piece / row).clamp(1, height.into()) as u32;
                // The slices of a volume are one below the other.
                for slice in 0..depth {
                    for first in (0..height).step_by(piece as usize) {
                        let (needed, end) = (slice * height + first, slice * height + (first + piece).min(height));
                        rows.push(InputRows { image: *image, rows: needed..end, needed });
                    }
                }
            }
        }
        rows
    }

    /// All rows of inputs, in the order in which they are needed.
    fn reads(&self) -> Vec<InputRows> {
        let in_bands = self.banding.sweeps.iter().flat_map(Sweep::inputs);
        self.whole_inputs().into_iter().chain(in_bands).collect()
    }

    /// Renders the image. Returns the missing rows if passes have read beyond their bands.
    fn render<R: BandReader, W: BandWriter<Error = R::Error>>(
        &mut self,
        reader: &mut R,
        writer: &mut W,
    ) -> Result<Option<Vec<Missing>>, R::Error> {
        let (reads, inputs) = (self.reads(), &self.plan.inputs);
        std::thread::scope(|scope| {
            let (read_to, read) = sync_channel(AHEAD);
            let (uploaded, used) = channel();
            let read_rows = move || {
                for InputRows { image, rows, needed } in reads {
                    let (name, _) = inputs.iter().find(|(_, input)| *input == image).expect("it is an input");
                    let mut texels = used.try_recv().unwrap_or_default();
                    let read = reader.read(name, rows, needed, &mut texels).map(|()| texels);
                    let failed = read.is_err();
                    // A receiver that is gone needs no more rows.
                    if read_to.send(read).is_err() || failed {
                        break;
                    }
                }
            };
            spawn(scope, read_rows)?;
            let (write, write_from) = sync_channel::<Rows<'a>>(AHEAD);
            let (written_to, written) = channel();
            let write_rows = move || {
                write_from.iter().try_for_each(|(output, rows, mut texels)| {
                    writer.write(output, rows, &mut texels)?;
                    let _ = written_to.send(texels);
                    Ok(())
                })
            };
            let writing = spawn(scope, write_rows)?;
            let made = self.sweeps(Streams { read, uploaded, write, written });
            writing.join().expect("the writer returns its errors").and(made)
        })
    }

    fn sweeps<E: From<GpuError>>(&mut self, streams: Streams<'a, E>) -> Result<Option<Vec<Missing>>, E> {
        let mut readback = Readback::new(&self.gpu.device, &self.gpu.queue).in_pieces_of(self.banding.piece);
        for (number, sweep) in self.banding.sweeps.iter().enumerate() {
            self.enter(number, false)?;
            if number == 0 {
                for InputRows { image, rows, .. } in self.whole_inputs() {
                    self.upload(&streams, image.0 as usize, rows.start)?;
                }
            }
            self.run(sweep.before.iter().map(|pass| (*pass, self.plan.passes[*pass].workgroups, None)))?;
            self.enter(number, true)?;
            for band in &sweep.bands {
                if let Some(missing) = self.band(band, &mut readback, &streams)? {
                    return Ok(Some(missing));
                }
            }
        }
        for output in self.plan.outputs.iter().filter(|output| self.place(Resource::Image(output.image)).is_none()) {
            let rows = 0..self.plan.image(output.image).desc.size.height;
            self.download(&mut readback, &streams, output, rows, 0)?;
        }
        Ok(None)
    }

    fn band<E: From<GpuError>>(
        &self,
        band: &Band,
        readback: &mut Readback,
        streams: &Streams<'a, E>,
    ) -> Result<Option<Vec<Missing>>, E> {
        for (image, rows) in &band.inputs {
            let index = image.0 as usize;
            let first = band.first[self.banding.images[index].expect("it is in bands")];
            self.upload(streams, index, rows.start - first)?;
        }
        if let Some(missing) = self.passes(band, readback)? {
            return Ok(Some(missing));
        }
        for (output, rows) in &band.outputs {
            let output = &self.plan.outputs[*output];
            let first = band.first[self.place(Resource::Image(output.image)).expect("it is in bands")];
            self.download(readback, streams, output, rows.clone(), first)?;
        }
        Ok(None)
    }

    /// Dry run on black images: bands in the middle of each sweep, so that each pass runs. Returns the missing rows.
    fn probe(&mut self) -> Result<Option<Vec<Missing>>, GpuError> {
        let readback = Readback::new(&self.gpu.device, &self.gpu.queue);
        for (number, sweep) in self.banding.sweeps.iter().enumerate() {
            self.enter(number, true)?;
            let middle = sweep.bands.len() / 2;
            let mut seen = BTreeSet::new();
            for band in sweep.bands[middle..].iter().chain(sweep.bands[..middle].iter().rev()) {
                let new = band.passes.iter().filter(|run| seen.insert(run.pass)).count();
                if new > 0
                    && let Some(missing) = self.passes(band, &readback)?
                {
                    return Ok(Some(missing));
                }
            }
        }
        // What passes add to begins with zeros.
        let buffers = self.plan.buffers.iter().zip(&self.buffers);
        submit(&self.gpu.device, &self.gpu.queue, "buffers of zeros", |encoder| {
            let kept = |life: &BufferLife| matches!(life, BufferLife::Constant(_));
            buffers
                .filter(|(described, _)| !kept(&described.life))
                .for_each(|(_, buffer)| encoder.clear_buffer(buffer, 0, None));
            Ok::<(), GpuError>(())
        })?;
        Ok(None)
    }

    /// Runs the passes of a band. Returns the missing rows.
    fn passes(&self, band: &Band, readback: &Readback) -> Result<Option<Vec<Missing>>, GpuError> {
        for running in &band.passes {
            let mut numbers = vec![running.groups.start as i32, 0, 0, 0];
            for ((size, first), known) in self.banding.sizes.iter().zip(&band.first).zip(&running.known) {
                numbers.extend([*first, known.start, known.end, size.rows].map(|number| number as i32));
            }
            let offset = region(self.banding) * running.pass as u64;
            self.gpu.queue.write_buffer(&self.windows, offset, bytemuck::cast_slice(&numbers));
        }
        let mut runs = Vec::new();
        for running in &band.passes {
            let planned = &self.plan.passes[running.pass];
            let place = planned.pass.results.first().and_then(|result| self.place(Resource::Image(result.image)));
            let first = place.map_or(0, |place| band.first[place]);
            if planned.stage == Stage::Fragment {
                let origin = [0.0, -(first as f32)];
                let offset = planned.uniform.extent_offset + size_of_val(&origin) as u64;
                self.gpu.queue.write_buffer(&self.uniforms, offset, bytemuck::cast_slice(&origin));
            }
            let groups = [planned.workgroups[0], running.groups.end - running.groups.start, planned.workgroups[2]];
            runs.push((running.pass, groups, Some(running.rows.start - first..running.rows.end - first)));
        }
        self.run(runs.into_iter())?;
        let bytes = readback.bytes(&self.missing, self.missing.size())?;
        let missing: &[u32] = &bytemuck::pod_collect_to_vec(&bytes);
        if missing.iter().any(|rows| *rows != 0) {
            let count = self.banding.sizes.len();
            let pairs = missing.as_chunks::<2>().0.iter().enumerate();
            return Ok(Some(pairs.map(|(index, pair)| (index / count, index % count, *pair)).collect()));
        }
        Ok(None)
    }

    /// Uploads the next rows into a texture, from its row `first` on.
    fn upload<E: From<GpuError>>(&self, streams: &Streams<'a, E>, image: usize, first: u32) -> Result<(), E> {
        let texels = streams.read.recv().expect("all rows are read until an error")?;
        self.upload.rows(self.image(image), first, &texels)?;
        // A reader that is done needs no memory.
        let _ = streams.uploaded.send(texels);
        Ok(())
    }

    /// Hands rows of an output, whose texture begins with the row `first`, to the writer.
    fn download<E: From<GpuError>>(
        &self,
        readback: &mut Readback,
        streams: &Streams<'a, E>,
        output: &'a PlanOutput,
        rows: Range<u32>,
        first: u32,
    ) -> Result<(), E> {
        let mut texels = streams.written.try_recv().unwrap_or_default();
        let texture = &self.image(output.image.0 as usize).texture;
        let own = rows.start - first..rows.end - first;
        readback.rows(texture, own, &mut texels)?;
        // A writer that is gone has failed and reports the error.
        let _ = streams.write.send((&output.name, rows, texels));
        Ok(())
    }

    fn run(&self, passes: impl Iterator<Item = Run>) -> Result<(), GpuError> {
        submit(&self.gpu.device, &self.gpu.queue, "a band", |encoder| {
            for (index, [x, y, z], rows) in passes {
                let Compiled { composed, built } = &self.compiled[&index];
                let groups = &self.groups[&index];
                let has_frame = composed.slots.iter().any(|slot| slot.kind == SlotKind::Frame);
                let offsets = |group: usize| if group == 0 && has_frame { &[0_u32][..] } else { &[] };
                if let Pipeline::Compute(pipeline) = &built.pipeline {
                    let mut pass = encoder.begin_compute_pass(&Default::default());
                    pass.set_pipeline(pipeline);
                    for (index, group) in groups.iter().enumerate() {
                        pass.set_bind_group(index as u32, group, offsets(index));
                    }
                    pass.dispatch_workgroups(x, y, z);
                }
                if let Pipeline::Render(pipeline) = &built.pipeline {
                    let image = self.plan.passes[index].pass.written_image().expect("a draw has a result");
                    let stored = self.image(image.0 as usize);
                    let load = rows.as_ref().map_or(wgpu::LoadOp::Clear(Default::default()), |_| wgpu::LoadOp::Load);
                    let mut pass = color_pass(encoder, None, &stored.view, load);
                    if let Some(rows) = rows {
                        pass.set_scissor_rect(0, rows.start, stored.desc.size.width, rows.end - rows.start);
                    }
                    pass.set_pipeline(pipeline);
                    for (index, group) in groups.iter().enumerate() {
                        pass.set_bind_group(index as u32, group, offsets(index));
                    }
                    pass.draw(0..3, 0..1);
                }
            }
            Ok::<(), GpuError>(())
        })
    }
}

/// Enlarges the halos of passes: by `more` of the missing rows, on each side.
fn widen(halos: &mut Halos, plan: &Plan, banding: &Banding, missing: Vec<Missing>, more: fn(u32) -> u32) {
    for (pass, place, missing) in missing {
        let more = missing.map(|rows| if rows == 0 { 0 } else { more(rows) });
        halos.learn(&plan.passes[pass].pass, pass, banding.sizes[place].size, more);
    }
}

/// The passes that run; `true` for those in bands.
fn running(banding: &Banding) -> BTreeMap<usize, bool> {
    let whole = banding.sweeps.iter().flat_map(|sweep| &sweep.before).map(|pass| (*pass, false));
    let bands = banding.sweeps.iter().flat_map(|sweep| &sweep.bands).flat_map(|band| &band.passes);
    whole.chain(bands.map(|band| (band.pass, true))).collect()
}

/// Compiles the passes that run. Pipelines of the same texts stay.
fn compile<E: From<GpuError> + From<PlanError>>(
    device: &wgpu::Device,
    plan: &Plan,
    banding: &Banding,
    pipelines: &Arc<Pipelines>,
) -> Result<BTreeMap<usize, Compiled>, E> {
    let (mut passes, mut requests) = (Vec::new(), Vec::new());
    for (pass, in_bands) in running(banding) {
        let composed = compose::<E>(plan, banding, pass, in_bands, code_options(device))?;
        let planned = &plan.passes[pass];
        let drawn = planned.pass.written_image().filter(|_| planned.stage == Stage::Fragment);
        let attachment = drawn.map(|image| texture_format(plan.image(image).desc.format));
        let windows = in_bands.then(|| window_layout(device));
        let request = PipelineRequest::new(plan, pass, &composed, attachment).with_second_layout(windows);
        passes.push((pass, composed, request.key.clone()));
        requests.push(request);
    }
    let pipelines = pipelines.build(device, requests, cores(), None)?;
    let compiled = passes.into_iter().map(|(pass, composed, key)| {
        let built = pipelines[&key].clone();
        (pass, Compiled { composed, built })
    });
    Ok(compiled.collect())
}

/// The shader module of a pass.
fn compose<E: From<GpuError> + From<PlanError>>(
    plan: &Plan,
    banding: &Banding,
    pass: usize,
    in_bands: bool,
    options: CodeOptions,
) -> Result<Composed, E> {
    let planned = &plan.passes[pass];
    let desc_of = |image| plan.image(image).desc;
    let sample_mode_of = |image| plan.image(image).sample_mode;
    // The first row of a drawn band is an origin above the texture.
    let has_origin = in_bands && planned.stage == Stage::Fragment;
    let code = CodeOptions { immediates: false, has_origin, ..options };
    let composed = compose_pass(&planned.pass, &desc_of, &sample_mode_of, code);
    let composed = composed.map_err(|error| GpuError::Shader(error.into()))?;
    if !in_bands {
        return Ok(composed);
    }
    let sizes: Vec<[u32; 2]> = banding.sizes.iter().map(|size| size.size).collect();
    let stored = composed.slots.iter().filter_map(|slot| match slot.kind {
        SlotKind::Storage(image) if planned.stage == Stage::Compute => {
            Some((slot.binding, banding.images[image.0 as usize]?))
        }
        _ => None,
    });
    let module = BandedModule {
        entry: &composed.compute,
        sizes: &sizes,
        stored: &stored.collect::<Vec<_>>(),
        workgroups: planned.workgroups,
        rows: composed.workgroup[1],
        first_counter: 2 * pass * sizes.len(),
    };
    let source = banded(&composed.source, &module).map_err(|why| {
        let node = planned.pass.nodes.join(" + ");
        PlanError::NoBands { node, why: format!("its shader {why}") }
    })?;
    Ok(Composed { source, ..composed })
}

/// Bytes of the uniform with the first rows of the bands of a pass.
fn region(banding: &Banding) -> u64 {
    (16 * (1 + banding.sizes.len() as u64)).next_multiple_of(256)
}

/// The layout of the second bind group of a pass in bands.
fn window_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entries = [wgpu::BufferBindingType::Uniform, wgpu::BufferBindingType::Storage { read_only: false }];
    let entries: Vec<_> = entries
        .into_iter()
        .enumerate()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: ShaderStages::COMPUTE | ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("bands"), entries: &entries })
}

/// The uniforms of the plan, with the host's blocks.
fn uniforms(plan: &Plan, blocks: &BTreeMap<String, BlockData>) -> Vec<u8> {
    let mut bytes = plan.uniform_buffer();
    for planned in &plan.blocks {
        if let Some(data) = blocks.get(&planned.name) {
            bytes[planned.offset as usize..][..data.bytes().len()].copy_from_slice(data.bytes());
        }
    }
    bytes
}

fn spawn<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    work: impl FnOnce() -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, T>, GpuError> {
    let started = Builder::new().spawn_scoped(scope, work);
    started.map_err(|why| GpuError::NoThreads { why: why.to_string() })
}
