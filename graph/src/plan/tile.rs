//! Step 4b: chains of images become one dispatch, in which a workgroup keeps a tile of each in its own memory.
//!
//! A pass joins the pass before it when it reads nothing else of its chain, its reach is known, and the joined dispatch is cheaper: the halo
//! of every tile is made more than once, but a dispatch and the trip of an image through memory are saved. The figures of the cost model were
//! measured on an H200 (`graph/docs/performance.md`).

use super::{Caps, Draft, Fused};
use crate::image::{ImageDesc, Size};
use crate::node::{Arg, ImageId, Origin, Pass, Resource, Step, TileStage, Tiling, Work};

/// What a dispatch costs however little it does, in nanoseconds.
const DISPATCH_NS: f64 = 5000.0;
/// What one byte through memory costs.
const BYTE_NS: f64 = 0.00033;
/// What one texel read from a tile or through a filter costs, all units of the device at work.
const READ_NS: f64 = 0.00035;
/// What one read costs a workgroup that has nobody to hide behind.
const LONE_READ_NS: f64 = 1.5;
/// Invocations of a workgroup.
const INVOCATIONS: f64 = 256.0;
/// Sides of tiles that are tried.
const TILES: [u32; 3] = [32, 16, 8];

pub(crate) fn tile(draft: &mut Draft, caps: &Caps) -> Vec<Fused> {
    let mut fused = Vec::new();
    let mut first = 0;
    while first < draft.recording.passes.len() {
        let chain = grow(draft, caps, first);
        if chain.members.len() > 1 {
            fused.extend(merge(draft, chain));
        }
        first += 1;
    }
    sort(draft);
    fused
}

/// Passes that one dispatch could make, and the best way to do it.
struct Chain {
    members: Vec<usize>,
    shape: Shape,
}

/// The geometry of a chain.
#[derive(Clone, Default)]
struct Shape {
    tile: u32,
    extents: Vec<[u32; 2]>,
    cost: f64,
}

fn grow(draft: &Draft, caps: &Caps, first: usize) -> Chain {
    let alone = Shape { tile: 16, extents: Vec::new(), cost: separate_cost(draft, &draft.recording.passes[first]) };
    let mut chain = Chain { members: vec![first], shape: alone };
    if link(draft, &draft.recording.passes[first]).is_none() {
        return chain;
    }
    while let Some(next) = next_member(draft, &chain.members) {
        let mut members = chain.members.clone();
        members.push(next);
        let separate = chain.shape.cost + separate_cost(draft, &draft.recording.passes[next]);
        match best_shape(draft, caps, &members) {
            Some(shape) if shape.cost < separate => chain = Chain { members, shape },
            _ => break,
        }
    }
    chain
}

/// What a pass of steps offers to a chain: its result and the steps.
fn link<'a>(draft: &'a Draft, pass: &'a Pass) -> Option<(ImageId, &'a [Step])> {
    match &pass.work {
        Work::Steps { steps, result } if !draft.recording.image(*result).desc.volume => Some((*result, steps)),
        _ => None,
    }
}

/// The step that reads `image` as a texture, if the pass reads no other texture and does not read the image in any other way.
fn reader_of(steps: &[Step], image: ImageId) -> Option<usize> {
    let reads = |step: &Step| step.args.contains(&Arg::Texture(image));
    let index = steps.iter().position(reads)?;
    let textures = |step: &Step| step.args.iter().filter(|arg| matches!(arg, Arg::Texture(_))).count();
    let elsewhere = steps.iter().enumerate().any(|(at, step)| {
        step.args.contains(&Arg::Pixel(image)) || at != index && step.args.contains(&Arg::Texture(image))
    });
    (textures(&steps[index]) == 1 && steps[index].reach.is_some() && !elsewhere).then_some(index)
}

/// The pass that can follow the last of the chain.
fn next_member(draft: &Draft, members: &[usize]) -> Option<usize> {
    let passes = &draft.recording.passes;
    let (result, _) = link(draft, &passes[*members.last()?])?;
    let origin = &draft.recording.image(result).origin;
    if *origin != Origin::Transient {
        return None;
    }
    (0..passes.len()).find(|at| {
        let Some((_, steps)) = link(draft, &passes[*at]) else { return false };
        reader_of(steps, result).is_some() && !members.contains(at) && !depends_otherwise(draft, members, *at, result)
    })
}

/// Whether a pass needs something of the chain other than the image that it joins by.
fn depends_otherwise(draft: &Draft, members: &[usize], next: usize, joint: ImageId) -> bool {
    let passes = &draft.recording.passes;
    let mut pending: Vec<Resource> =
        passes[next].reads().into_iter().filter(|resource| *resource != Resource::Image(joint)).collect();
    let mut seen = pending.clone();
    while let Some(resource) = pending.pop() {
        for (at, pass) in passes.iter().enumerate().filter(|(_, pass)| pass.writes().contains(&resource)) {
            if members.contains(&at) {
                return true;
            }
            for read in pass.reads() {
                if !seen.contains(&read) {
                    seen.push(read);
                    pending.push(read);
                }
            }
        }
    }
    false
}

/// Texels that a texel of this pass reads, roughly.
fn weight(steps: &[Step]) -> f64 {
    let one = |step: &Step| {
        let taps = step.reach.map_or(4.0, |reach| (2.0 * f64::from(reach) + 2.0).powi(2));
        let has_texture = step.args.iter().any(|arg| matches!(arg, Arg::Texture(_)));
        if has_texture { taps } else { 2.0 }
    };
    steps.iter().map(one).sum()
}

fn desc(draft: &Draft, pass: usize) -> ImageDesc {
    let (result, _) = link(draft, &draft.recording.passes[pass]).expect("members of chains are passes of steps");
    draft.recording.image(result).desc
}

fn separate_cost(draft: &Draft, pass: &Pass) -> f64 {
    let Some((result, steps)) = link(draft, pass) else { return DISPATCH_NS };
    let desc = draft.recording.image(result).desc;
    let moved: u64 = pass.reads().into_iter().chain(pass.writes()).map(|resource| bytes(draft, resource)).sum();
    DISPATCH_NS + (desc.size.texels() as f64 * weight(steps) * READ_NS).max(moved as f64 * BYTE_NS)
}

fn bytes(draft: &Draft, resource: Resource) -> u64 {
    match resource {
        Resource::Image(image) => draft.recording.image(image).desc.bytes(),
        Resource::Buffer(buffer) => draft.recording.buffer(buffer).bytes,
    }
}

fn best_shape(draft: &Draft, caps: &Caps, members: &[usize]) -> Option<Shape> {
    let stored = members.iter().filter(|at| is_stored(draft, members, **at)).count();
    if stored > caps.max_storage_images as usize || caps.workgroup_invocations < INVOCATIONS as u32 {
        return None;
    }
    let shapes = TILES.into_iter().filter_map(|tile| shape(draft, caps, members, tile));
    shapes.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Whether anybody outside the chain needs what this member makes.
fn is_stored(draft: &Draft, members: &[usize], at: usize) -> bool {
    let passes = &draft.recording.passes;
    let Some((result, _)) = link(draft, &passes[at]) else { return true };
    let outside = |index: usize, pass: &Pass| !members.contains(&index) && pass.reads().contains(&Resource::Image(result));
    Some(&at) == members.last()
        || draft.is_kept(result)
        || passes.iter().enumerate().any(|(index, pass)| outside(index, pass))
}

/// How far member `index + 1` reads in the image of member `index`.
fn reach(draft: &Draft, members: &[usize], index: usize) -> f32 {
    let passes = &draft.recording.passes;
    let joint = link(draft, &passes[members[index]]).map(|(result, _)| result);
    let next = link(draft, &passes[members[index + 1]]).map(|(_, steps)| steps);
    let (joint, steps) = joint.zip(next).expect("members of chains are passes of steps");
    let reader = reader_of(steps, joint).expect("each member reads the one before");
    let declared = steps[reader].reach.expect("a reader of a tile has a reach");
    // A member that is stored must make its whole share, which lies within half a texel's footprint of the next image's texels.
    let (this, next) = (desc(draft, members[index]).size, desc(draft, members[index + 1]).size);
    let ratio = ratio(this.width, next.width).max(ratio(this.height, next.height)) as f32;
    declared.max((ratio - 1.0) / 2.0 + 0.5)
}

fn ratio(from: u32, to: u32) -> f64 {
    f64::from(from) / f64::from(to)
}

fn shape(draft: &Draft, caps: &Caps, members: &[usize], tile: u32) -> Option<Shape> {
    let sizes: Vec<Size> = members.iter().map(|at| desc(draft, *at).size).collect();
    let mut extents = vec![[tile, tile]];
    for index in (0..members.len() - 1).rev() {
        let reach = f64::from(reach(draft, members, index));
        let [width, height] = extents[0];
        let (this, next) = (sizes[index], sizes[index + 1]);
        // The texels under the next tile, the reach on both sides, the second texel of a filtered tap, and one for rounding.
        let across = |next_extent: u32, ratio: f64| (f64::from(next_extent - 1) * ratio + 2.0 * reach).ceil() as u32 + 3;
        let extent = [across(width, ratio(this.width, next.width)), across(height, ratio(this.height, next.height))];
        extents.insert(0, extent);
    }
    let halves = members.iter().all(|at| !desc(draft, *at).format.is_32_bit());
    let texel_bytes = if halves { 8 } else { 16 };
    if tile_memory(&extents) * texel_bytes > caps.workgroup_bytes {
        return None;
    }
    let cost = joined_cost(draft, members, &extents, tile);
    Some(Shape { tile, extents, cost })
}

/// Texels of workgroup memory: images lie in it by turns, the even ones at the beginning.
pub(crate) fn tile_memory(extents: &[[u32; 2]]) -> u32 {
    let largest = |parity: usize| {
        let kept = &extents[..extents.len() - 1];
        kept.iter().skip(parity).step_by(2).map(|[w, h]| w * h).max().unwrap_or(0)
    };
    largest(0) + largest(1)
}

fn joined_cost(draft: &Draft, members: &[usize], extents: &[[u32; 2]], tile: u32) -> f64 {
    let passes = &draft.recording.passes;
    let last = desc(draft, *members.last().expect("a chain has members")).size;
    let groups = last.div_ceil_tiles(tile);
    let mut reads = 0.0;
    let mut lone = 0.0;
    let mut moved = 0;
    for (index, (at, extent)) in members.iter().zip(extents).enumerate() {
        let (result, steps) = link(draft, &passes[*at]).expect("members of chains are passes of steps");
        let texels = f64::from(extent[0]) * f64::from(extent[1]);
        reads += texels * groups * weight(steps);
        lone += (texels / INVOCATIONS).ceil() * weight(steps) * LONE_READ_NS;
        let joint = index.checked_sub(1).and_then(|before| link(draft, &passes[members[before]])).map(|(image, _)| image);
        let outside = passes[*at].reads().into_iter().filter(|r| joint.is_none_or(|joint| *r != Resource::Image(joint)));
        moved += outside.map(|resource| bytes(draft, resource)).sum::<u64>();
        if is_stored(draft, members, *at) {
            moved += draft.recording.image(result).desc.bytes();
        }
    }
    DISPATCH_NS + (reads * READ_NS).max(moved as f64 * BYTE_NS).max(lone)
}

impl Size {
    fn div_ceil_tiles(self, tile: u32) -> f64 {
        self.div_up(tile).texels() as f64
    }
}

fn merge(draft: &mut Draft, chain: Chain) -> Vec<Fused> {
    let Chain { members, shape } = chain;
    let reaches: Vec<f32> = (0..members.len()).map(|i| if i + 1 < members.len() { reach(draft, &members, i) } else { 0.0 }).collect();
    let stored: Vec<bool> = members.iter().map(|at| is_stored(draft, &members, *at)).collect();
    let halves = members.iter().all(|at| !desc(draft, *at).format.is_32_bit());
    let mut stages = Vec::new();
    let mut nodes: Vec<String> = Vec::new();
    let mut labels = Vec::new();
    let mut fused = Vec::new();
    let mut joint = None;
    for (index, at) in members.iter().enumerate() {
        let pass = draft.recording.passes[*at].clone();
        let Work::Steps { mut steps, result } = pass.work else { unreachable!("members of chains are passes of steps") };
        if let Some(joint) = joint {
            let args = steps.iter_mut().flat_map(|step| &mut step.args);
            args.filter(|arg| **arg == Arg::Texture(joint)).for_each(|arg| *arg = Arg::Tile);
        }
        let image = draft.recording.image(result);
        if index + 1 < members.len() {
            let trips = if stored[index] { 1 } else { 2 };
            fused.push(Fused { image: image.label.clone(), nodes: Vec::new(), bytes_saved: trips * image.desc.bytes() });
        }
        stages.push(TileStage {
            steps,
            size: image.desc.size,
            extent: shape.extents[index],
            reach: reaches[index],
            result: stored[index].then_some(result),
        });
        nodes.extend(pass.nodes.into_iter().filter(|node| !nodes.contains(node)).collect::<Vec<_>>());
        labels.push(pass.label);
        joint = Some(result);
    }
    fused.iter_mut().for_each(|entry| entry.nodes.clone_from(&nodes));
    let work = Work::Tiled(Tiling { stages, tile: shape.tile, halves });
    let last = *members.last().expect("a chain has members");
    draft.recording.passes[last] = Pass { nodes, label: labels.join(" > "), work };
    let mut others = members;
    others.retain(|at| *at != last);
    others.sort_unstable();
    for at in others.into_iter().rev() {
        draft.recording.passes.remove(at);
    }
    fused
}

/// Brings passes back behind what they read, and moves nothing that need not move.
fn sort(draft: &mut Draft) {
    let mut waiting: Vec<Pass> = std::mem::take(&mut draft.recording.passes);
    let mut sorted = Vec::with_capacity(waiting.len());
    while !waiting.is_empty() {
        let ready = |at: &usize| {
            let reads = waiting[*at].reads();
            let blocked = |other: (usize, &Pass)| {
                let writes = other.1.writes();
                other.0 != *at
                    && writes.iter().any(|written| match written {
                        Resource::Image(_) => reads.contains(written),
                        // Buffers are written in place: their passes keep their order.
                        Resource::Buffer(_) => other.0 < *at && (reads.contains(written) || waiting[*at].writes().contains(written)),
                    })
            };
            !waiting.iter().enumerate().any(blocked)
        };
        let at = (0..waiting.len()).find(ready).expect("joining passes makes no circle");
        sorted.push(waiting.remove(at));
    }
    draft.recording.passes = sorted;
}
