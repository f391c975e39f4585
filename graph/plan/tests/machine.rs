//! An interpreter of plans that shares no code with the planner. It runs frames with terms in the place of pixels: the
//! term of a value says which function made it, at which size, from which other terms. Two plans that give equal terms
//! compute the same, whatever was fused, ordered, or laid over each other in memory.
//!
//! Memory is that of a device: who writes to bytes ends what others held there. What a pass writes can be read after a
//! barrier only, and the passes of a batch see nothing of each other.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use afterimage_graph::image::Size;
use afterimage_graph::node::{
    Arg, Argument, BufferId, BufferLife, Drawing, ImageId, KernelCall, Origin, PassKind, Resource, Subresource,
    WarpPart,
};
use afterimage_plan::{Alias, Batch, Plan, PlannedPass, Refresh};

/// What an image or a buffer holds.
pub type Term = u64;

/// The outputs of a frame, in the order of the plan.
pub type Shown = Vec<(String, Term)>;

const BLACK: Term = 0;

fn term(of: impl Hash) -> Term {
    let mut hasher = DefaultHasher::new();
    of.hash(&mut hasher);
    hasher.finish()
}

/// A device that runs a plan.
pub struct Machine<'p> {
    plan: &'p Plan,
    contents: BTreeMap<Resource, Term>,
    /// Which image has which memory; what several have had is cut into pieces.
    owners: Vec<(Range<u64>, ImageId)>,
    /// What a barrier has made ready for reads since it was written.
    ready: BTreeSet<Resource>,
    /// What images held at the ends of frames, newest first.
    past: BTreeMap<ImageId, Vec<Term>>,
    /// What warps have made: it is known at any place, also between pixels.
    warps: BTreeMap<Term, Warp>,
    /// The number of the frame.
    number: u32,
    cached: BTreeMap<Resource, Refresh>,
}

/// The kernels of a warp, and what they read.
#[derive(Clone)]
struct Warp {
    kernels: Vec<KernelCall>,
    size: Size,
    read: BTreeMap<Resource, Term>,
}

/// What a kernel function is called with beside its arguments.
#[derive(Clone, Copy)]
struct Call<'a> {
    /// The values of the kernels before.
    values: &'a [Term],
    size: Size,
    /// The place of the pixel.
    place: Term,
    read: &'a dyn Fn(Resource) -> Result<Term, String>,
}

impl<'p> Machine<'p> {
    pub fn new(plan: &'p Plan) -> Self {
        let (contents, ready, past, warps) = (BTreeMap::new(), BTreeSet::new(), BTreeMap::new(), BTreeMap::new());
        let cached = plan.cached_results();
        Self { plan, contents, owners: Vec::new(), ready, past, warps, number: 0, cached }
    }

    /// The outputs of some frames, or what went wrong.
    pub fn frames(plan: &Plan, count: usize) -> Result<Vec<Shown>, String> {
        let mut machine = Machine::new(plan);
        (0..count).map(|_| machine.frame()).collect()
    }

    /// Runs a frame.
    pub fn frame(&mut self) -> Result<Shown, String> {
        self.begin();
        self.plan.batches.iter().try_for_each(|batch| self.batch(batch))?;
        self.plan.exports.iter().for_each(|export| _ = self.ready.insert(export.resource));
        let outputs = self.plan.outputs.iter();
        let shown = outputs.map(|output| Ok((output.name.clone(), self.image(output.image)?))).collect();
        self.end();
        self.number += 1;
        shown
    }

    /// Whether passes with this refresh run in the frame. All run in the first one; LUTs are evaluated in each.
    fn is_due(&self, refresh: &Refresh) -> bool {
        self.number == 0
            || match *refresh {
                Refresh::EachFrame | Refresh::OnChange => true,
                Refresh::Every { every, phase } => self.number % every == phase,
                Refresh::Once => false,
            }
    }

    fn begin(&mut self) {
        self.owners.clear();
        self.ready.clear();
        self.contents
            .retain(|resource, _| matches!(resource, Resource::Buffer(_)) || self.cached.contains_key(resource));
        for (number, buffer) in self.plan.buffers.iter().enumerate() {
            let resource = Resource::Buffer(BufferId(number as u32));
            if self.cached.get(&resource).is_some_and(|refresh| !self.is_due(refresh)) {
                continue;
            }
            match &buffer.life {
                BufferLife::Frame => drop(self.contents.remove(&resource)),
                BufferLife::Zeroed => drop(self.contents.insert(resource, BLACK)),
                BufferLife::Persistent => drop(self.contents.entry(resource).or_insert(BLACK)),
                BufferLife::Constant(bytes) => drop(self.contents.insert(resource, term(bytes))),
            }
        }
    }

    fn end(&mut self) {
        for (resource, term) in &self.contents {
            if let Resource::Image(image) = resource {
                self.past.entry(*image).or_default().insert(0, *term);
            }
        }
    }

    fn batch(&mut self, batch: &Batch) -> Result<(), String> {
        let barriers: BTreeSet<Resource> = batch.transitions.iter().map(|transition| transition.resource).collect();
        self.ready.extend(&barriers);
        let passes = &self.plan.passes[batch.passes.clone()];
        self.is_apart(passes)?;
        let (mut written, mut skipped) = (BTreeMap::new(), Vec::new());
        let warps: Vec<(Term, Warp)> = passes.iter().filter_map(|planned| self.warp(planned)).collect();
        self.warps.extend(warps);
        for planned in passes {
            if !planned.refresh.iter().any(|refresh| self.is_due(refresh)) {
                // What it would have written takes its memory all the same, behind the barriers of the batch.
                let transient = |image: &ImageId| !self.cached.contains_key(&Resource::Image(*image));
                skipped.extend(planned.pass.writes().into_iter().filter_map(Resource::image).filter(transient));
                continue;
            }
            for (resource, value) in self.pass(planned)? {
                let label = &planned.pass.label;
                if !barriers.contains(&resource) {
                    return Err(format!("no barrier before `{label}` writes {resource:?}"));
                }
                if written.insert(resource, value).is_some() {
                    return Err(format!("`{label}` and another pass of its batch write {resource:?}"));
                }
            }
        }
        for image in skipped {
            self.take_memory(image, batch)?;
            self.contents.remove(&Resource::Image(image));
        }
        for (resource, value) in written {
            if let Resource::Image(image) = resource {
                self.take_memory(image, batch)?;
            }
            self.contents.insert(resource, value);
            self.ready.remove(&resource);
        }
        Ok(())
    }

    /// The passes of a batch run at once: no two images that they use share memory, and what one writes no other uses.
    fn is_apart(&self, passes: &[PlannedPass]) -> Result<(), String> {
        let images: BTreeSet<ImageId> =
            passes.iter().flat_map(|planned| planned.pass.resources()).filter_map(Resource::image).collect();
        let places: Vec<(Range<u64>, ImageId)> =
            images.into_iter().filter_map(|image| Some((memory(self.plan, image)?, image))).collect();
        for (at, (range, image)) in places.iter().enumerate() {
            if let Some((_, other)) = places[..at].iter().find(|(other, _)| meet(other, range)) {
                return Err(format!("{image:?} and {other:?} are used at once in one memory"));
            }
        }
        for (at, planned) in passes.iter().enumerate() {
            for (_, other) in passes.iter().enumerate().filter(|(other, _)| *other != at) {
                let used: Vec<Resource> = other.pass.resources().collect();
                if planned.pass.writes().iter().any(|resource| used.contains(resource)) {
                    return Err(format!("`{}` and `{}` use one thing at once", planned.pass.label, other.pass.label));
                }
            }
        }
        Ok(())
    }

    /// Gives an image its memory, which a barrier must have separated from all that had a part of it.
    fn take_memory(&mut self, image: ImageId, batch: &Batch) -> Result<(), String> {
        let Some(range) = memory(self.plan, image) else { return Ok(()) };
        if range.end > self.plan.memory.placed && self.plan.options.alias == Alias::Placed {
            return Err(format!("{image:?} lies beyond the heap"));
        }
        let barrier = batch.aliasing.iter().find(|barrier| barrier.image == image);
        let separated = barrier.map_or(&[][..], |barrier| &barrier.owners);
        let mut pieces = Vec::new();
        for (piece, owner) in std::mem::take(&mut self.owners) {
            if meet(&piece, &range) && owner != image {
                if !separated.contains(&owner) {
                    return Err(format!("nothing separates {image:?} from {owner:?}"));
                }
                self.contents.remove(&Resource::Image(owner));
            }
            let [below, above] = [piece.start..piece.end.min(range.start), piece.start.max(range.end)..piece.end];
            pieces.extend([below, above].into_iter().filter(|part| part.start < part.end).map(|part| (part, owner)));
        }
        pieces.push((range, image));
        self.owners = pieces;
        Ok(())
    }

    fn read(&self, resource: Resource) -> Result<Term, String> {
        if !self.ready.contains(&resource) {
            return Err(format!("no barrier before a read of {resource:?}"));
        }
        match resource {
            Resource::Image(image) => self.image(image),
            Resource::Buffer(_) => {
                self.contents.get(&resource).copied().ok_or_else(|| format!("{resource:?} is empty"))
            }
        }
    }

    fn image(&self, image: ImageId) -> Result<Term, String> {
        let resource = Resource::Image(image);
        match &self.plan.image(image).origin {
            Origin::Transient | Origin::Retained if self.ready.contains(&resource) => self
                .contents
                .get(&resource)
                .copied()
                .ok_or_else(|| format!("{image:?} was overwritten, or never written")),
            Origin::Transient | Origin::Retained => Err(format!("no barrier after {image:?} was written")),
            Origin::Input(name) => Ok(term(("input", name, self.number))),
            Origin::Constant(bytes) => Ok(term(bytes)),
            Origin::Previous { of, frames } => {
                let past = self.past.get(of).and_then(|past| past.get(*frames as usize - 1));
                Ok(past.copied().unwrap_or(BLACK))
            }
        }
    }

    /// What a pass writes.
    fn pass(&self, planned: &PlannedPass) -> Result<Vec<(Resource, Term)>, String> {
        let pass = &planned.pass;
        let size_of_result = || self.plan.image(pass.results[0].image).desc.size;
        let values = match &pass.kind {
            PassKind::Compute => {
                let written: Result<Vec<_>, String> =
                    pass.kernels.iter().map(|kernel| self.entry_point(kernel)).collect();
                return Ok(written?.concat());
            }
            PassKind::Drawing(drawing) => return self.drawing(planned, drawing),
            PassKind::Point | PassKind::Gather | PassKind::Workgroup(_) => {
                self.functions(&pass.kernels, size_of_result())?
            }
            PassKind::RowDownsample(rows) => {
                let [wide, high] = rows.odd;
                let Size { width, height, depth } = size_of_result();
                let (makers, others) = pass.kernels.split_at(pass.results[0].kernel);
                let mut values =
                    self.functions(makers, Size { width: 2 * width + wide, height: 2 * height + high, depth })?;
                values.push(halved(&others[0].function, *values.last().expect("a halving has a source")));
                for kernel in &others[1..] {
                    let [Argument { value: Arg::SquareOf(texel), .. }] = kernel.args[..] else {
                        return Err(format!("`{}` takes no square", kernel.function));
                    };
                    values.push(of_square(&kernel.function, values[texel]));
                }
                values
            }
        };
        Ok(pass.results.iter().map(|result| (Resource::Image(result.image), values[result.kernel])).collect())
    }

    /// What a pass makes whose kernels are all of a warp.
    fn warp(&self, planned: &PlannedPass) -> Option<(Term, Warp)> {
        let pass = &planned.pass;
        let image = pass.function_result().filter(|_| pass.kernels.iter().all(|kernel| kernel.warp.is_some()))?;
        let reads = pass.reads().into_iter().map(|resource| Some((resource, self.read(resource).ok()?)));
        let size = self.plan.image(image).desc.size;
        let made = self.functions(&pass.kernels, size).ok()?.last().copied()?;
        Some((made, Warp { kernels: pass.kernels.clone(), size, read: reads.collect::<Option<_>>()? }))
    }

    /// What a warp reads at a place: of what another warp has made, the value that its kernels give there.
    fn tapped(&self, source: Term, place: Term) -> Result<Term, String> {
        let Some(warp) = self.warps.get(&source) else { return Ok(term(("tap", source, place))) };
        let read = |resource| warp.read.get(&resource).copied().ok_or_else(|| format!("{resource:?} was not read"));
        let mut values = Vec::new();
        for kernel in &warp.kernels {
            let call = Call { values: &values, size: warp.size, place, read: &read };
            let value = self.function(kernel, call)?;
            values.push(value);
        }
        Ok(*values.last().expect("a pass has kernels"))
    }

    fn functions(&self, kernels: &[KernelCall], size: Size) -> Result<Vec<Term>, String> {
        let mut values = Vec::new();
        for kernel in kernels {
            let read = |resource| self.read(resource);
            let call = Call { values: &values, size, place: term("point"), read: &read };
            let value = self.function(kernel, call)?;
            values.push(value);
        }
        Ok(values)
    }

    fn function(&self, kernel: &KernelCall, call: Call<'_>) -> Result<Term, String> {
        let Call { values, size, place, read } = call;
        let earlier = |kernel: usize| values.get(kernel).copied().ok_or("a kernel reads one behind it");
        let value = |arg: &Argument| {
            Ok::<Term, String>(match arg.value {
                Arg::Kernel(kernel) => earlier(kernel)?,
                Arg::PointOf(kernel) => term(("place", earlier(kernel)?)),
                Arg::Point => place,
                Arg::Pixel(image) | Arg::Texture(image) => read(Resource::Image(image))?,
                Arg::Value(buffer, components) => term((components, read(Resource::Buffer(buffer))?)),
                other => term(format!("{other:?}")),
            })
        };
        let values: Vec<Term> = kernel.args.iter().map(value).collect::<Result<_, _>>()?;
        if kernel.shader.file() == "copy.wgsl" {
            return Ok(values[0]);
        }
        if kernel.warp == Some(WarpPart::Tap) {
            let at =
                |name| kernel.args.iter().position(|arg| arg.name == name).expect("a tap has a source and a place");
            return self.tapped(values[at("source")], values[at("at")]);
        }
        if let Some(by) = &kernel.by_rows {
            let reads = |arg: &Argument| matches!(arg.value, Arg::Texture(_));
            let source = kernel.args.iter().position(reads).expect("a halving reads a texture");
            return Ok(halved(by.function, values[source]));
        }
        if let Some(form) = kernel.quad_variant {
            return Ok(of_square(form, values[0]));
        }
        if let Some(form) = kernel.by_neighbors {
            let args = kernel.args.iter().zip(&values).filter(|(arg, _)| arg.value != Arg::Around);
            let args: BTreeMap<&String, &Term> = args.map(|(arg, value)| (&arg.name, value)).collect();
            return Ok(term((form.function, args, size.width, size.height)));
        }
        let names: Vec<&String> = kernel.args.iter().map(|arg| &arg.name).collect();
        let rest = format!("{:?} {:?} {:?} {size}", kernel.defines, kernel.constants, kernel.limited);
        Ok(term((kernel.shader.file(), &*kernel.function, &kernel.uniform, names, values, rest)))
    }

    /// What a drawing pass leaves in its images: each depends on all that the pass reads and keeps. What is not stored
    /// is nothing that a later pass can read.
    fn drawing(&self, planned: &PlannedPass, drawing: &Drawing) -> Result<Vec<(Resource, Term)>, String> {
        let PlannedPass { pass, stores, .. } = planned;
        let read: Vec<Term> = pass.reads().into_iter().map(|resource| self.read(resource)).collect::<Result<_, _>>()?;
        let kernels: Vec<_> = pass.kernels.iter().map(|kernel| (kernel.shader.file(), &kernel.uniform)).collect();
        let all = term((kernels, read, format!("{drawing:?}")));
        let written = |(at, target): (usize, Subresource)| {
            (Resource::Image(target.image), if stores[at] { term((all, at)) } else { term("dropped") })
        };
        Ok(drawing.targets().enumerate().map(written).collect())
    }

    /// What a compute kernel writes: each of its results depends on all that it reads.
    fn entry_point(&self, kernel: &KernelCall) -> Result<Vec<(Resource, Term)>, String> {
        let mut read = Vec::new();
        for arg in &kernel.args {
            read.push(match arg.value {
                // It may be written without being read.
                Arg::Buffer(buffer, true) => self.contents.get(&Resource::Buffer(buffer)).copied().unwrap_or(BLACK),
                value => value.read().map_or(Ok(BLACK), |resource| self.read(resource))?,
            });
        }
        let all =
            term((kernel.shader.file(), &*kernel.function, &kernel.uniform, read, format!("{:?}", kernel.constants)));
        let written = |arg: &Argument| Some((arg.value.written()?, term((all, &arg.name))));
        Ok(kernel.args.iter().filter_map(written).collect())
    }
}

/// A halving has two forms, which compute the same.
fn halved(function: &str, source: Term) -> Term {
    term(("halved", function, source))
}

/// So has what needs a square alone.
fn of_square(form: &str, source: Term) -> Term {
    term(("square", form, source))
}

fn meet(one: &Range<u64>, other: &Range<u64>) -> bool {
    one.start < other.end && other.start < one.end
}

/// The bytes of an image in the heap, or its texture of the pool; `None` if its memory is its own.
pub fn memory(plan: &Plan, image: ImageId) -> Option<Range<u64>> {
    let planned = plan.image(image);
    let start = match plan.options.alias {
        Alias::None => return None,
        Alias::Pool => return planned.slot.map(|slot| u64::from(slot)..u64::from(slot) + 1),
        Alias::Placed => planned.offset?,
    };
    Some(start..start + planned.requirement?.bytes)
}
