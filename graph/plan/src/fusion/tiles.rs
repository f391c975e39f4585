//! Chains of images become one dispatch, in which a workgroup keeps a tile of each in its own memory.
//!
//! A pass joins the pass before it when it reads nothing else of its chain, its reach is known, and the joined dispatch
//! costs less: the edges of every tile are made more than once, but a dispatch and one trip of an image through memory
//! are saved.

use std::collections::BTreeSet;

use super::one_module::fit_one_module;
use super::pass_graph::PassGraph;
use super::tile_cost::{INVOCATIONS, JoinedCost, separate_cost};
use crate::builder::PlanBuilder;
use crate::plan::Fused;
use afterimage_base::caps::Caps;
use afterimage_base::image::{ImageDesc, Size};
use afterimage_graph::node::{
    Arg, ImageId, KernelCall, Origin, Pass, PassKind, PassResult, Recording, Resource, TileStage, TiledChain,
};

/// Sides of tiles that are tried.
const TILES: [u32; 3] = [32, 16, 8];
/// Readers of an image that are tried as the next member of a chain.
const MAX_CANDIDATES: usize = 64;
/// Resources that the search for another way from a chain to its next member may visit; after that the member counts as
/// dependent and does not join. This keeps planning linear.
const MAX_VISITED: usize = 128;

pub(super) fn chain_in_tiles(builder: &mut PlanBuilder, caps: &Caps, always: bool) {
    let graph = PassGraph::new(builder);
    let passes = graph.len();
    let mut tiler = Tiler { graph, recording: &builder.recording, caps, always };
    let mut chain = |first: usize| tiler.grow(first).map(|chain| tiler.merge(chain));
    let fused: Vec<Fused> = (0..passes).filter_map(&mut chain).flatten().collect();
    tiler.graph.finish(builder);
    builder.fused.extend(fused);
}

/// The passes, and what is known of them.
struct Tiler<'a> {
    graph: PassGraph,
    recording: &'a Recording,
    caps: &'a Caps,
    /// Whether chains are made even where they cost more.
    always: bool,
}

/// Passes that one dispatch could make, and the cheapest way to do it.
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

impl Tiler<'_> {
    /// The longest chain from a pass that costs less than its members alone, if there is one.
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

    /// The pass of that number and its result, if it can be part of a chain.
    fn link(&self, number: usize) -> Option<(&Pass, ImageId)> {
        let (pass, result) = self.graph.functions(number)?;
        let suits = !self.recording.image(result).desc.volume && !self.graph.is_output(result);
        suits.then_some((pass, result))
    }

    fn member(&self, number: usize) -> (&Pass, ImageId) {
        self.link(number).expect("members of chains are passes of functions")
    }

    /// The pass that can follow the last of the chain.
    fn next_member(&self, members: &[usize]) -> Option<usize> {
        let (_, result) = self.link(*members.last()?)?;
        if self.recording.image(result).origin != Origin::Transient {
            return None;
        }
        self.graph.readers(Resource::Image(result)).take(MAX_CANDIDATES).find(|number| {
            let Some((pass, _)) = self.link(*number) else { return false };
            reader_of(&pass.kernels, result).is_some()
                && !members.contains(number)
                && !self.depends_otherwise(members, *number, result)
        })
    }

    /// Whether a pass needs a result of the chain other than the image by which it joins.
    fn depends_otherwise(&self, members: &[usize], next: usize, joint: ImageId) -> bool {
        let reads = |number: usize| self.graph.get(number).map(Pass::reads).unwrap_or_default();
        let mut pending: Vec<Resource> = reads(next).into_iter().filter(|r| *r != Resource::Image(joint)).collect();
        let mut seen: BTreeSet<Resource> = pending.iter().copied().collect();
        // Numbers follow the order of recording, so nothing before the chain can need it.
        let first = members.iter().copied().min().unwrap_or(0);
        while let Some(resource) = pending.pop() {
            for writer in self.graph.writers(resource).filter(|writer| *writer >= first) {
                if members.contains(&writer) || seen.len() > MAX_VISITED {
                    return true;
                }
                pending.extend(reads(writer).into_iter().filter(|read| seen.insert(*read)));
            }
        }
        false
    }

    fn desc(&self, number: usize) -> ImageDesc {
        self.recording.image(self.member(number).1).desc
    }

    fn bytes(&self, resource: Resource) -> u64 {
        match resource {
            Resource::Image(image) => self.recording.image(image).desc.bytes(),
            Resource::Buffer(buffer) => self.recording.buffer(buffer).bytes,
        }
    }

    fn separate_cost(&self, number: usize) -> f64 {
        let (pass, result) = self.member(number);
        let moved = pass.resources().map(|resource| self.bytes(resource)).sum();
        separate_cost(pass, self.recording.image(result).desc.size.texels(), moved)
    }

    fn best_shape(&self, members: &[usize]) -> Option<Shape> {
        let stored = members.iter().filter(|number| self.is_stored(members, **number)).count();
        let can_store = stored <= self.caps.max_storage_images as usize;
        let passes = members.iter().map(|number| self.member(*number).0);
        let can_join = fit_one_module(passes, self.recording, self.caps);
        let can_run = can_store && can_join && self.caps.workgroup_invocations >= INVOCATIONS as u32;
        let shapes = TILES.into_iter().filter(|_| can_run).filter_map(|tile| self.shape(members, tile));
        shapes.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Whether a pass outside the chain, a later frame or the host reads the image of this member.
    fn is_stored(&self, members: &[usize], number: usize) -> bool {
        let (_, result) = self.member(number);
        let mut readers = self.graph.readers(Resource::Image(result));
        Some(&number) == members.last()
            || self.graph.is_kept(result)
            || readers.any(|reader| !members.contains(&reader))
    }

    /// How far member `index + 1` reads in the image of member `index`.
    fn reach(&self, members: &[usize], index: usize) -> f32 {
        let (_, joint) = self.member(members[index]);
        let (next, _) = self.member(members[index + 1]);
        let reader = reader_of(&next.kernels, joint).expect("each member reads the one before");
        let declared = next.kernels[reader].reach.expect("a reader of a tile has a reach");
        // A stored member must make its whole share, which lies within half a footprint of the next image's texels.
        let [across, down] = ratios(self.desc(members[index]).size, self.desc(members[index + 1]).size);
        declared.max((across.max(down) as f32 - 1.0) / 2.0 + 0.5)
    }

    fn halves(&self, members: &[usize]) -> bool {
        members.iter().all(|number| !self.desc(*number).format.is_32_bit())
    }

    fn shape(&self, members: &[usize], tile: u32) -> Option<Shape> {
        let sizes: Vec<Size> = members.iter().map(|number| self.desc(*number).size).collect();
        let mut extents = vec![[tile, tile]];
        for index in (0..members.len() - 1).rev() {
            let reach = f64::from(self.reach(members, index));
            let ([width, height], ratios) = (extents[0], ratios(sizes[index], sizes[index + 1]));
            // The texels under the next tile, the reach on both sides, the second texel of a filtered tap, and one for
            // rounding.
            let across = |extent: u32, ratio: f64| (f64::from(extent - 1) * ratio + 2.0 * reach).ceil() as u32 + 3;
            extents.insert(0, [across(width, ratios[0]), across(height, ratios[1])]);
        }
        let texel_bytes = if self.halves(members) { 8 } else { 16 };
        if tile_memory(&extents) * texel_bytes > self.caps.workgroup_bytes {
            return None;
        }
        let cost = self.joined_cost(members, &extents, tile);
        Some(Shape { tile, extents, cost })
    }

    fn joined_cost(&self, members: &[usize], extents: &[[u32; 2]], tile: u32) -> f64 {
        let groups = self.desc(*members.last().expect("a chain has members")).size.div_up(tile).texels();
        let mut cost = JoinedCost::default();
        let mut joint = None;
        for (number, extent) in members.iter().zip(extents) {
            let (pass, result) = self.member(*number);
            cost.add(pass, *extent, groups, joint.is_some());
            let outside = pass.reads().into_iter().filter(|read| joint != Some(*read));
            cost.add_bytes(outside.map(|resource| self.bytes(resource)).sum());
            if self.is_stored(members, *number) {
                cost.add_bytes(self.recording.image(result).desc.bytes());
            }
            joint = Some(Resource::Image(result));
        }
        cost.total()
    }

    /// Replaces the members by one pass in the place of the last; returns the images that need not be read back.
    fn merge(&mut self, Chain { members, shape }: Chain) -> Vec<Fused> {
        let last = members.len() - 1;
        let reach = |index: usize| if index < last { self.reach(&members, index) } else { 0.0 };
        let reaches: Vec<f32> = (0..members.len()).map(reach).collect();
        let stored: Vec<bool> = members.iter().map(|number| self.is_stored(&members, *number)).collect();
        let halves = self.halves(&members);
        let mut joined = Joined::default();
        let mut fused = Vec::new();
        for (index, number) in members.iter().enumerate() {
            let pass = self.graph.take(*number).expect("members of chains are there");
            let image = self.recording.image(pass.function_result().expect("members are passes of functions"));
            if index < last {
                let trips = if stored[index] { 1 } else { 2 };
                let bytes_saved = trips * image.desc.bytes();
                fused.push(Fused { image: image.label.clone(), nodes: Vec::new(), bytes_saved });
            }
            joined.add(pass, stored[index], image.desc.size, (shape.extents[index], reaches[index]));
        }
        fused.iter_mut().for_each(|entry| entry.nodes.clone_from(&joined.nodes));
        self.graph.put(members[last], joined.pass(shape.tile, halves));
        fused
    }
}

/// The pass of a chain, while its members are added.
#[derive(Default)]
struct Joined {
    nodes: Vec<String>,
    labels: Vec<String>,
    kernels: Vec<KernelCall>,
    results: Vec<PassResult>,
    stages: Vec<TileStage>,
    /// The image by which the next member joins.
    joint: Option<Arg>,
}

impl Joined {
    fn add(&mut self, pass: Pass, stored: bool, size: Size, (extent, reach): ([u32; 2], f32)) {
        let image = pass.function_result().expect("members are passes of functions");
        let first = self.kernels.len();
        let joint = self.joint.replace(Arg::Texture(image));
        self.kernels.extend(pass.kernels.into_iter().map(|kernel| kernel.moved(first, joint, Arg::Tile)));
        let stage = TileStage { kernels: first..self.kernels.len(), size, extent, reach };
        self.results.extend(stored.then_some(PassResult { kernel: stage.last_kernel(), image }));
        self.stages.push(stage);
        let new: Vec<String> = pass.nodes.into_iter().filter(|node| !self.nodes.contains(node)).collect();
        self.nodes.extend(new);
        self.labels.push(pass.label);
    }

    fn pass(self, tile: u32, halves: bool) -> Pass {
        let Self { nodes, labels, kernels, results, stages, .. } = self;
        let kind = PassKind::TiledChain(TiledChain { stages, tile, halves });
        Pass { nodes, label: labels.join(" > "), kernels, results, kind }
    }
}

/// The kernel that reads `image` as a texture, if it reads no other texture and nothing else reads the image.
fn reader_of(kernels: &[KernelCall], image: ImageId) -> Option<usize> {
    let is_read = |kernel: &KernelCall| kernel.accepts(Arg::Texture(image));
    let index = kernels.iter().position(is_read)?;
    let reads_one = kernels[index].textures().count() == 1;
    let elsewhere = kernels[index + 1..].iter().any(is_read) || kernels.iter().any(|k| k.accepts(Arg::Pixel(image)));
    (reads_one && kernels[index].reach.is_some() && !elsewhere).then_some(index)
}

/// How many times as wide and as high one size is as another.
fn ratios(this: Size, next: Size) -> [f64; 2] {
    let ratio = |from: u32, to: u32| f64::from(from) / f64::from(to);
    [ratio(this.width, next.width), ratio(this.height, next.height)]
}

/// Texels of workgroup memory: images alternate between its two parts.
fn tile_memory(extents: &[[u32; 2]]) -> u32 {
    let kept = &extents[..extents.len() - 1];
    let largest = |parity: usize| kept.iter().skip(parity).step_by(2).map(|[w, h]| w * h).max().unwrap_or(0);
    largest(0) + largest(1)
}
