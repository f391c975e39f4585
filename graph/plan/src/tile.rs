//! Step 4b: chains of images become one dispatch, in which a workgroup keeps a tile of each in its own memory.
//!
//! A pass joins the pass before it when it reads nothing else of its chain, its reach is known, and the joined dispatch is cheaper: the halo
//! of every tile is made more than once, but a dispatch and the trip of an image through memory are saved. The figures of the cost model were
//! measured on an H200 (`graph/docs/performance.md`).

use std::collections::BTreeSet;

use crate::pass_graph::PassGraph;
use crate::{Caps, Fused, PlanBuilder};
use afterimage_base::image::{ImageDesc, Size};
use afterimage_graph::node::{Arg, ImageId, Origin, Pass, Recording, Resource, Step, TileStage, Tiling, Work};

/// What a dispatch costs however little it does, in nanoseconds.
const DISPATCH_NS: f64 = 2000.0;
/// What one byte through memory costs.
const BYTE_NS: f64 = 0.00037;
/// What one texel costs that is read through the device's filter, all units at work.
const TEXTURE_READ_NS: f64 = 0.0007;
/// What one texel costs that is read from a tile: it must be found, unpacked and filtered by hand.
const TILE_READ_NS: f64 = 0.0024;
/// What one read costs a workgroup that has nobody to hide behind.
const LONE_READ_NS: f64 = 30.0;
/// Invocations of a workgroup.
const INVOCATIONS: f64 = 256.0;
/// Sides of tiles that are tried.
const TILES: [u32; 3] = [32, 16, 8];

pub(crate) fn tile(draft: &mut PlanBuilder, caps: &Caps, always: bool) -> Vec<Fused> {
    let web = PassGraph::new(draft);
    let mut loom = Loom { web, recording: &draft.recording, caps, always };
    let mut fused = Vec::new();
    for first in 0..loom.web.len() {
        if let Some(chain) = loom.grow(first) {
            fused.extend(loom.merge(chain));
        }
    }
    let Loom { web, .. } = loom;
    web.finish(draft);
    fused
}

/// The passes, and what is known of them.
struct Loom<'a> {
    web: PassGraph,
    recording: &'a Recording,
    caps: &'a Caps,
    /// Whether chains are made even where they do not pay.
    always: bool,
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

impl Loom<'_> {
    /// The longest chain from a pass that pays, if any does.
    fn grow(&self, first: usize) -> Option<Chain> {
        self.link(first)?;
        let alone = Shape { tile: 16, extents: Vec::new(), cost: self.separate_cost(first) };
        let mut chain = Chain { members: vec![first], shape: alone };
        while let Some(next) = self.next_member(&chain.members) {
            let mut members = chain.members.clone();
            members.push(next);
            let separate = chain.shape.cost + self.separate_cost(next);
            match self.best_shape(&members) {
                Some(shape) if self.always || shape.cost < separate => chain = Chain { members, shape },
                _ => break,
            }
        }
        (chain.members.len() > 1).then_some(chain)
    }

    /// What a pass of steps offers to a chain: its result and the steps.
    fn link(&self, number: usize) -> Option<(ImageId, &[Step])> {
        match &self.web.get(number)?.work {
            Work::Steps { steps, result } => {
                let suits = !self.recording.image(*result).desc.volume && !self.web.is_output(*result);
                suits.then_some((*result, steps))
            }
            _ => None,
        }
    }

    fn member(&self, number: usize) -> (ImageId, &[Step]) {
        self.link(number).expect("members of chains are passes of steps")
    }

    /// The pass that can follow the last of the chain.
    fn next_member(&self, members: &[usize]) -> Option<usize> {
        let (result, _) = self.link(*members.last()?)?;
        if self.recording.image(result).origin != Origin::Transient {
            return None;
        }
        self.web.readers(Resource::Image(result)).find(|number| {
            let Some((_, steps)) = self.link(*number) else { return false };
            reader_of(steps, result).is_some()
                && !members.contains(number)
                && !self.depends_otherwise(members, *number, result)
        })
    }

    /// Whether a pass needs something of the chain other than the image that it joins by.
    fn depends_otherwise(&self, members: &[usize], next: usize, joint: ImageId) -> bool {
        let reads = |number: usize| self.web.get(number).map(Pass::reads).unwrap_or_default();
        let mut pending: Vec<Resource> = reads(next).into_iter().filter(|r| *r != Resource::Image(joint)).collect();
        let mut seen: BTreeSet<Resource> = pending.iter().copied().collect();
        // Numbers follow the order of recording, so nothing before the chain can need it.
        let first = members.iter().copied().min().unwrap_or(0);
        while let Some(resource) = pending.pop() {
            for writer in self.web.writers(resource).filter(|writer| *writer >= first) {
                if members.contains(&writer) {
                    return true;
                }
                pending.extend(reads(writer).into_iter().filter(|read| seen.insert(*read)));
            }
        }
        false
    }

    fn desc(&self, number: usize) -> ImageDesc {
        self.recording.image(self.member(number).0).desc
    }

    fn bytes(&self, resource: Resource) -> u64 {
        match resource {
            Resource::Image(image) => self.recording.image(image).desc.bytes(),
            Resource::Buffer(buffer) => self.recording.buffer(buffer).bytes,
        }
    }

    fn separate_cost(&self, number: usize) -> f64 {
        let (result, steps) = self.member(number);
        let texels = self.recording.image(result).desc.size.texels() as f64;
        let pass = self.web.get(number).expect("members of chains are there");
        let moved: u64 = pass.reads().into_iter().chain(pass.writes()).map(|resource| self.bytes(resource)).sum();
        DISPATCH_NS + (texels * weight(steps) * TEXTURE_READ_NS).max(moved as f64 * BYTE_NS)
    }

    fn best_shape(&self, members: &[usize]) -> Option<Shape> {
        let stored = members.iter().filter(|number| self.is_stored(members, **number)).count();
        if stored > self.caps.max_storage_images as usize || self.caps.workgroup_invocations < INVOCATIONS as u32 {
            return None;
        }
        let shapes = TILES.into_iter().filter_map(|tile| self.shape(members, tile));
        shapes.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Whether anybody outside the chain needs what this member makes.
    fn is_stored(&self, members: &[usize], number: usize) -> bool {
        let (result, _) = self.member(number);
        let mut readers = self.web.readers(Resource::Image(result));
        Some(&number) == members.last() || self.web.is_kept(result) || readers.any(|reader| !members.contains(&reader))
    }

    /// How far member `index + 1` reads in the image of member `index`.
    fn reach(&self, members: &[usize], index: usize) -> f32 {
        let (joint, _) = self.member(members[index]);
        let (_, steps) = self.member(members[index + 1]);
        let reader = reader_of(steps, joint).expect("each member reads the one before");
        let declared = steps[reader].reach.expect("a reader of a tile has a reach");
        // A member that is stored must make its whole share, which lies within half a footprint of the next image's texels.
        let (this, next) = (self.desc(members[index]).size, self.desc(members[index + 1]).size);
        let ratio = ratio(this.width, next.width).max(ratio(this.height, next.height)) as f32;
        declared.max((ratio - 1.0) / 2.0 + 0.5)
    }

    fn halves(&self, members: &[usize]) -> bool {
        members.iter().all(|number| !self.desc(*number).format.is_32_bit())
    }

    fn shape(&self, members: &[usize], tile: u32) -> Option<Shape> {
        let sizes: Vec<Size> = members.iter().map(|number| self.desc(*number).size).collect();
        let mut extents = vec![[tile, tile]];
        for index in (0..members.len() - 1).rev() {
            let reach = f64::from(self.reach(members, index));
            let [width, height] = extents[0];
            let (this, next) = (sizes[index], sizes[index + 1]);
            // The texels under the next tile, the reach on both sides, the second texel of a filtered tap, and one for rounding.
            let across = |extent: u32, ratio: f64| (f64::from(extent - 1) * ratio + 2.0 * reach).ceil() as u32 + 3;
            extents.insert(
                0,
                [across(width, ratio(this.width, next.width)), across(height, ratio(this.height, next.height))],
            );
        }
        let texel_bytes = if self.halves(members) { 8 } else { 16 };
        if tile_memory(&extents) * texel_bytes > self.caps.workgroup_bytes {
            return None;
        }
        let cost = self.joined_cost(members, &extents, tile);
        Some(Shape { tile, extents, cost })
    }

    fn joined_cost(&self, members: &[usize], extents: &[[u32; 2]], tile: u32) -> f64 {
        let last = self.desc(*members.last().expect("a chain has members")).size;
        let groups = last.div_up(tile).texels() as f64;
        let (mut reads, mut lone, mut moved) = (0.0, 0.0, 0);
        let mut joint = None;
        for (number, extent) in members.iter().zip(extents) {
            let (result, steps) = self.member(*number);
            let texels = f64::from(extent[0]) * f64::from(extent[1]);
            let read = if joint.is_some() { TILE_READ_NS } else { TEXTURE_READ_NS };
            reads += texels * groups * weight(steps) * read;
            lone += (texels / INVOCATIONS).ceil() * weight(steps) * LONE_READ_NS;
            let all = self.web.get(*number).map(Pass::reads).unwrap_or_default();
            let outside = all.into_iter().filter(|read| joint != Some(*read));
            moved += outside.map(|resource| self.bytes(resource)).sum::<u64>();
            if self.is_stored(members, *number) {
                moved += self.recording.image(result).desc.bytes();
            }
            joint = Some(Resource::Image(result));
        }
        DISPATCH_NS + reads.max(moved as f64 * BYTE_NS).max(lone)
    }

    fn merge(&mut self, Chain { members, shape }: Chain) -> Vec<Fused> {
        let last = *members.last().expect("a chain has members");
        let reach = |index: usize| if index + 1 < members.len() { self.reach(&members, index) } else { 0.0 };
        let reaches: Vec<f32> = (0..members.len()).map(reach).collect();
        let stored: Vec<bool> = members.iter().map(|number| self.is_stored(&members, *number)).collect();
        let halves = self.halves(&members);
        let (mut stages, mut fused, mut labels) = (Vec::new(), Vec::new(), Vec::new());
        let mut nodes: Vec<String> = Vec::new();
        let mut joint = None;
        for (index, number) in members.iter().enumerate() {
            let pass = self.web.take(*number).expect("members of chains are there");
            let Work::Steps { mut steps, result } = pass.work else {
                unreachable!("members of chains are passes of steps")
            };
            let args = steps.iter_mut().flat_map(|step| &mut step.args);
            args.filter(|arg| joint == Some(**arg)).for_each(|arg| *arg = Arg::Tile);
            let image = self.recording.image(result);
            if *number != last {
                let trips = if stored[index] { 1 } else { 2 };
                fused.push(Fused {
                    image: image.label.clone(),
                    nodes: Vec::new(),
                    bytes_saved: trips * image.desc.bytes(),
                });
            }
            let result_if_read = stored[index].then_some(result);
            stages.push(TileStage {
                steps,
                size: image.desc.size,
                extent: shape.extents[index],
                reach: reaches[index],
                result: result_if_read,
            });
            let new: Vec<String> = pass.nodes.into_iter().filter(|node| !nodes.contains(node)).collect();
            nodes.extend(new);
            labels.push(pass.label);
            joint = Some(Arg::Texture(result));
        }
        fused.iter_mut().for_each(|entry| entry.nodes.clone_from(&nodes));
        let work = Work::Tiled(Tiling { stages, tile: shape.tile, halves });
        self.web.put(last, Pass { nodes, label: labels.join(" > "), work });
        fused
    }
}

/// The step that reads `image` as a texture, if it reads no other texture and nothing else reads the image.
fn reader_of(steps: &[Step], image: ImageId) -> Option<usize> {
    let index = steps.iter().position(|step| step.args.contains(&Arg::Texture(image)))?;
    let textures = steps[index].args.iter().filter(|arg| matches!(arg, Arg::Texture(_))).count();
    let elsewhere = steps.iter().enumerate().any(|(at, step)| {
        step.args.contains(&Arg::Pixel(image)) || at != index && step.args.contains(&Arg::Texture(image))
    });
    (textures == 1 && steps[index].reach.is_some() && !elsewhere).then_some(index)
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

fn ratio(from: u32, to: u32) -> f64 {
    f64::from(from) / f64::from(to)
}

/// Texels of workgroup memory: images lie in it by turns, the even ones at the beginning.
fn tile_memory(extents: &[[u32; 2]]) -> u32 {
    let kept = &extents[..extents.len() - 1];
    let largest = |parity: usize| kept.iter().skip(parity).step_by(2).map(|[w, h]| w * h).max().unwrap_or(0);
    largest(0) + largest(1)
}
