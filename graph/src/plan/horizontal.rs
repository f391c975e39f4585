//! Step 5b: horizontal fusion. Passes of one batch wait for nothing from each other, so that one dispatch can run several side by side: its workgroups
//! are shared out among them.
//!
//! Where each of them is too small to fill the device this saves a dispatch. Passes over the whole picture read it at the same time, each
//! part once for all of them as far as caches reach; but a workgroup takes the registers and the memory of the greediest: on an H200 the
//! halving and the lattices of `tsushima.ron` take 0.082 ms so at 4K, and 0.078 in two dispatches.

use std::ops::Range;

use super::features::features;
use super::order::Order;
use super::{Caps, Draft, Options, Stage};
use crate::node::{Arg, EntryCall, ImageId, Pass, Recording, Resource, Step, Work};
use crate::shader::{CELLS_LANES, ShaderFeatures, GlobalKind, ROW_LANES, SampleMode, Shader, can_tell};

/// Which passes share a dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Horizontal {
    /// None.
    Never,
    /// Those that are too small to fill a device.
    Small,
    /// All that can: passes of one batch read large images together.
    Always,
}

/// A pass of more invocations keeps a large device busy by itself.
const SMALL: u64 = 1 << 17;
/// More would hardly save anything, and cost the registers of all.
const MOST_PASSES: usize = 4;
/// A pass joins one of so many groups before it, which keeps a batch of thousands linear.
const OPEN: usize = 16;
/// What every device has room for.
const MOST_TEXTURES: usize = 16;
const MOST_BUFFERS: usize = 8;
/// Workgroups of one dispatch, so that a product of two of their numbers fits into 32 bits.
const MOST_WORKGROUPS: u64 = 0xffff;

/// Brings the passes that share a dispatch together inside their batches. The passes of each dispatch or draw.
pub(super) fn launches(
    draft: &mut Draft,
    stages: &mut [Stage],
    order: &mut Order,
    sample_modes: &[SampleMode],
    caps: &Caps,
    options: &Options,
) -> Vec<Range<usize>> {
    // Invocations of a subgroup would have to be those of one pass.
    let is_asked = options.horizontal != Horizontal::Never && options.fuse && !options.subgroups;
    let mut launches = Vec::new();
    for batch in order.batches.clone() {
        let mut groups: Vec<Group> = Vec::new();
        for pass in batch.clone() {
            let demand = if is_asked { Demand::new(draft, stages[pass], sample_modes, options, pass) } else { None };
            let mut latest = groups.iter_mut().rev().take(OPEN);
            match latest.find_map(|group| group.joined(demand.as_ref()?, caps).map(|joined| (group, joined))) {
                Some((group, joined)) => {
                    group.passes.push(pass);
                    group.demand = Some(joined);
                }
                None => groups.push(Group { passes: vec![pass], demand }),
            }
        }
        let mut end = batch.start;
        for group in &groups {
            group.adapt(&mut draft.recording);
            launches.push(end..end + group.passes.len());
            end += group.passes.len();
        }
        let moved: Vec<usize> = groups.into_iter().flat_map(|group| group.passes).collect();
        if moved.iter().copied().ne(batch.clone()) {
            rearrange(&mut draft.recording.passes, &batch, &moved);
            rearrange(stages, &batch, &moved);
            rearrange(&mut order.recorded, &batch, &moved);
        }
    }
    launches
}

/// Puts the elements of a range into another order.
fn rearrange<T: Clone>(all: &mut [T], range: &Range<usize>, order: &[usize]) {
    let moved: Vec<T> = order.iter().map(|at| all[*at].clone()).collect();
    all[range.clone()].clone_from_slice(&moved);
}

/// Passes of one dispatch.
struct Group {
    passes: Vec<usize>,
    /// What they need together; nothing for a pass that must stay alone.
    demand: Option<Demand>,
}

impl Group {
    /// What the group would need with one more pass, if that is possible.
    fn joined(&self, one: &Demand, caps: &Caps) -> Option<Demand> {
        let all = self.demand.as_ref()?;
        let lanes = all.lanes.together(one.lanes)?;
        let sum = Demand {
            reading: all.reading.or(one.reading),
            lanes,
            workgroups: all.workgroups + one.workgroups,
            textures: all.textures + one.textures,
            storage: all.storage + one.storage,
            buffers: all.buffers + one.buffers,
            bytes: all.bytes + one.bytes,
            ..*all
        };
        let reads_alike = all.reading.is_none() || one.reading.is_none() || all.reading == one.reading;
        let alike = reads_alike && all.features == one.features;
        let fits = self.passes.len() < MOST_PASSES
            && sum.workgroups <= MOST_WORKGROUPS
            && sum.textures <= MOST_TEXTURES
            && sum.buffers <= MOST_BUFFERS
            && sum.storage <= caps.max_storage_images as usize
            && sum.bytes <= caps.workgroup_bytes
            && lanes.count <= caps.workgroup_invocations;
        (alike && fits).then_some(sum)
    }

    /// OutputState those passes as many invocations as the others have that can do with any number.
    fn adapt(&self, recording: &mut Recording) {
        let Some(lanes) = self.demand.as_ref().map(|demand| demand.lanes.count).filter(|_| self.passes.len() > 1)
        else {
            return;
        };
        for pass in &self.passes {
            match &mut recording.passes[*pass].work {
                Work::Rows(rows) => rows.lanes = lanes,
                Work::Cells(cells) => cells.lanes[1] *= lanes / cells.workgroup(),
                Work::Steps { .. } | Work::Tiled(_) | Work::Entry(_) => {}
            }
        }
    }
}

/// Invocations of a workgroup.
#[derive(Clone, Copy)]
struct Lanes {
    count: u32,
    /// Whether there may be more, a multiple.
    grows: bool,
}

impl Lanes {
    /// Of a workgroup that can do the work of both.
    fn together(self, other: Self) -> Option<Self> {
        let (small, large) = if self.count <= other.count { (self, other) } else { (other, self) };
        let fits = large.count == small.count || small.grows && large.count.is_multiple_of(small.count);
        fits.then_some(Self { count: large.count, grows: small.grows && large.grows })
    }
}

/// What passes need of a dispatch.
#[derive(Clone, Copy)]
struct Demand {
    /// How taps read textures, if there are any.
    reading: Option<SampleMode>,
    features: ShaderFeatures,
    lanes: Lanes,
    workgroups: u64,
    textures: usize,
    storage: usize,
    buffers: usize,
    /// Of workgroup memory.
    bytes: u32,
}

impl Demand {
    /// `None` for a pass that must stay alone.
    fn new(draft: &Draft, stage: Stage, sample_modes: &[SampleMode], options: &Options, number: usize) -> Option<Self> {
        let recording = &draft.recording;
        let pass = &recording.passes[number];
        // The host may want an output drawn.
        let is_output = |resource: &Resource| draft.outputs.iter().any(|out| Resource::Image(out.image) == *resource);
        let is_free = stage == Stage::Compute && !pass.writes().iter().any(is_output);
        if !is_free || !is_trusted(pass) || knows_time(pass) || !can_be_told(pass) {
            return None;
        }
        let workgroups = recording.workgroups(pass);
        let all = workgroups.count.iter().map(|n| u64::from(*n)).product::<u64>();
        // A halving by rows is at its best in small workgroups, which it would not have.
        let is_small = all * u64::from(workgroups.lanes) <= SMALL && !matches!(pass.work, Work::Rows(_));
        if options.horizontal == Horizontal::Small && !is_small {
            return None;
        }
        let grows = match &pass.work {
            // Invocations that never wait for each other can be those of several workgroups.
            Work::Entry(call) => call.shader.reflect().is_ok_and(|known| !known.waits),
            Work::Steps { .. } | Work::Rows(_) | Work::Cells(_) => true,
            // Its memory is filled by itself.
            Work::Tiled(_) => return None,
        };
        let is_image = |resource: &Resource| matches!(resource, Resource::Image(_));
        let (reads, writes, tapped) = (pass.reads(), pass.writes(), tapped(pass));
        Some(Self {
            reading: tapped.iter().map(|image| sample_modes[image.0 as usize]).max(),
            features: features(recording, options, pass),
            lanes: Lanes { count: workgroups.lanes, grows },
            workgroups: all,
            textures: reads.iter().filter(|resource| is_image(resource)).count().max(tapped.len()),
            storage: writes.iter().filter(|resource| is_image(resource)).count(),
            buffers: reads.iter().chain(&writes).filter(|resource| !is_image(resource)).count(),
            bytes: workgroup_bytes(pass),
        })
    }
}

fn calls(pass: &Pass) -> Vec<&EntryCall> {
    match &pass.work {
        Work::Entry(call) => vec![call],
        Work::Cells(cells) => cells.readers.iter().map(|reader| &reader.call).collect(),
        Work::Steps { .. } | Work::Tiled(_) | Work::Rows(_) => Vec::new(),
    }
}

fn steps(pass: &Pass) -> &[Step] {
    match &pass.work {
        Work::Steps { steps, .. } => steps,
        Work::Rows(rows) => &rows.source,
        Work::Tiled(_) | Work::Cells(_) | Work::Entry(_) => &[],
    }
}

/// Whether the names and the loops of all of its modules are known to be in order.
fn is_trusted(pass: &Pass) -> bool {
    pass.shaders().into_iter().all(Shader::is_unchecked)
}

/// Whether the frame's time must be brought to it.
fn knows_time(pass: &Pass) -> bool {
    let binds_frame = |call: &EntryCall| {
        let globals = call.shader.reflect().map(|known| known.globals.as_slice()).unwrap_or_default();
        globals.iter().any(|global| matches!(&global.kind, GlobalKind::Uniform(ty) if ty == "Frame"))
    };
    steps(pass).iter().any(|step| step.args.contains(&Arg::Frame)) || calls(pass).into_iter().any(binds_frame)
}

/// Whether its entry point can be told what it asks for beside others.
fn can_be_told(pass: &Pass) -> bool {
    let Work::Entry(call) = &pass.work else { return true };
    let entry = call.shader.reflect().ok().and_then(|known| known.entry(call.entry));
    entry.is_some_and(|entry| entry.told.iter().all(can_tell))
}

/// The images that are read by taps, once for each binding.
fn tapped(pass: &Pass) -> Vec<ImageId> {
    let of_steps = steps(pass).iter().flat_map(|step| &step.args).filter_map(|arg| match arg {
        Arg::Texture(image) => Some(*image),
        _ => None,
    });
    let bound = calls(pass).into_iter().flat_map(|call| &call.bindings).filter(|binding| !binding.writes);
    let of_calls = bound.filter_map(|binding| match binding.resource {
        Resource::Image(image) => Some(image),
        Resource::Buffer(_) => None,
    });
    of_steps.chain(of_calls).collect()
}

/// Bytes of workgroup memory that its modules declare, with the most invocations.
fn workgroup_bytes(pass: &Pass) -> u32 {
    let bytes = |shader: &Shader| shader.reflect().map_or(0, |known| known.workgroup_bytes);
    let declared: u32 = pass.shaders().into_iter().map(bytes).sum();
    if matches!(pass.work, Work::Rows(_)) { declared * (CELLS_LANES / ROW_LANES) } else { declared }
}
