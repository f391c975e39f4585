//! Which plan renders, when the next one is made, and when it comes in.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{GivenImage, HostInputs, NeedsPlan, Part, Plan, PlanError, Planned};
use wgpu::TextureView;

use super::fade_skip_reason::FadeSkipReason;
use super::running::{ActivePlan, OwnedPlanRequest, PendingPlan, Ready};
use super::uniforms::Uniforms;
use super::{Post, PostError};
use crate::device::image_format;
use crate::executor::{MULTISAMPLED, PlanWithUniforms, VOLUME};
use crate::platform::Worker;
use crate::{Executor, Frame, GpuError, Rectangle};

impl Post {
    /// Brings in the plan for these images if there is another one than the one that renders. Returns why one that was
    /// being made has failed.
    pub(super) fn update_plan(&mut self, frame: &Frame<'_>) -> Result<Option<PostError>, PostError> {
        if !self.fits(frame)? {
            let given = self.given(frame)?;
            self.end_fade(FadeSkipReason::NewImages);
            self.load_for(given)?;
            return Ok(None);
        }
        if frame.reset || self.executor.is_fresh() {
            self.end_fade(FadeSkipReason::NewBeginning);
        }
        let next = self.next.take_if(|next| !self.fade.goes_on() && next.worker.is_finished());
        let failure = match next {
            Some(next) => self.activate(next, Some(frame)).err(),
            None => None,
        };
        if self.is_stale && self.next.is_none() {
            self.is_stale = false;
            self.start_pending();
        }
        Ok(failure.or_else(|| self.prepare_sizes()))
    }

    /// Whether the plan that renders is for the host's images.
    fn fits(&self, frame: &Frame<'_>) -> Result<bool, GpuError> {
        let Some(running) = &self.running else { return Ok(false) };
        for input in &self.plans.graph().inputs {
            if input.block.is_some() {
                if gives_block(frame, input) != running.given.blocks.contains(&input.name) {
                    return Ok(false);
                }
                continue;
            }
            let (given, part) = self.image_of(frame, input)?.unzip();
            if given != running.given.inputs.get(&input.name).map(|given| given.desc)
                || part.flatten() != running.given.parts.get(&input.name).copied()
            {
                return Ok(false);
            }
        }
        for output in &self.plans.graph().outputs {
            if self.is_linear(frame, &output.name) != running.given.linear.contains(&output.name)
                || is_in_rectangle(frame, &output.name) != running.given.rectangles.contains(&output.name)
            {
                return Ok(false);
            }
        }
        Ok(!running.given.inputs.is_empty()
            || output_size(frame).or(self.size).is_none_or(|size| size == running.given.size))
    }

    /// Whether the image of an output holds linear light: the host says so, or the device encodes it.
    fn is_linear(&self, frame: &Frame<'_>, output: &str) -> bool {
        let view = frame.outputs.iter().find(|(name, _)| *name == output).map(|(_, view)| *view);
        let format = frame.stated_format(output).or(view.map(|view| view.texture().format()));
        self.linear.contains(output) || format.is_some_and(|format| format.is_srgb())
    }

    /// What the host gives. The size is that of the first image, or else of the first output, or the stated one.
    fn given(&self, frame: &Frame<'_>) -> Result<HostInputs, PostError> {
        let (mut inputs, mut parts, mut blocks) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        let mut size = None;
        for input in &self.plans.graph().inputs {
            if gives_block(frame, input) {
                blocks.insert(input.name.clone());
            }
            let Some((desc, part)) = self.image_of(frame, input)? else { continue };
            // A volume says nothing of the frame.
            size = size.or(Some(desc.size).filter(|_| !desc.volume));
            parts.extend(part.map(|part| (input.name.clone(), part)));
            inputs.insert(input.name.clone(), GivenImage { desc, finite: self.finite.contains(&input.name) });
        }
        let outputs = self.plans.graph().outputs.iter().filter(|output| self.is_linear(frame, &output.name));
        let linear = outputs.map(|output| output.name.clone()).collect();
        let outputs = self.plans.graph().outputs.iter().filter(|output| is_in_rectangle(frame, &output.name));
        let rectangles = outputs.map(|output| output.name.clone()).collect();
        let first = self.plans.graph().inputs.iter().find(|input| input.block.is_none());
        let missing =
            || PostError::from(PlanError::MissingInput(first.map_or(String::new(), |input| input.name.clone())));
        let size = size.or(output_size(frame)).or(self.size).ok_or_else(missing)?;
        Ok(HostInputs { size, inputs, blocks, linear, parts, rectangles })
    }

    /// The description of the host's image for an input, and how large its rectangle is if it has one.
    fn image_of(&self, frame: &Frame<'_>, input: &GraphInput) -> Result<Option<(ImageDesc, Option<Part>)>, GpuError> {
        let Some(view) = view_of(frame, input) else { return Ok(None) };
        let desc = desc_of(input, view)?;
        let has_factor = frame.factors.iter().any(|(name, _)| *name == input.name);
        Ok(Some(match (frame.rectangle(&input.name), self.size) {
            (Some(_), Some(size)) => (ImageDesc { size, ..desc }, Some(Part::Scaled)),
            (Some(rectangle), None) => (ImageDesc { size: rectangle.size(), ..desc }, Some(Part::Rectangle)),
            (None, _) => (desc, has_factor.then_some(Part::Rectangle)),
        }))
    }

    /// Makes the plan for what the host gives and loads it, if it is not the one that renders.
    ///
    /// # Errors
    /// The graph cannot be planned for it, or the device refuses the plan.
    pub(crate) fn load_for(&mut self, given: HostInputs) -> Result<&Arc<Plan>, PostError> {
        self.next = None;
        if self.is_stale {
            self.sizes.renew();
        }
        let planned = self.planned(given.clone())?;
        if self.running.as_ref().is_none_or(|running| !Arc::ptr_eq(&running.plan, &planned.plan)) {
            let changed = self.dynamic().map(|parameter| parameter.node).collect();
            let running = ActivePlan::new(self.age.graph, given, &planned, (self.plans.graph(), changed));
            self.executor.load_at(running.wanted())?;
            if self.running.replace(running).is_some() {
                self.fade.miss(FadeSkipReason::NewImages);
            }
        }
        self.is_stale = false;
        Ok(self.plan().expect("it runs"))
    }

    fn planned(&mut self, given: HostInputs) -> Result<Arc<Planned>, PlanError> {
        span!("afterimage::plan");
        let device = self.executor.device().clone();
        let wish = self.wish(given);
        wish.on(&device, |request| self.plans.planned(request)).0
    }

    /// The plan for what the host would give, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned for it.
    pub fn plan_for(&mut self, given: HostInputs) -> Result<Arc<Plan>, PlanError> {
        Ok(self.planned(given)?.plan.clone())
    }

    pub(super) fn wish(&self, given: HostInputs) -> OwnedPlanRequest {
        OwnedPlanRequest {
            given,
            facts: self.facts.clone(),
            caps: self.executor.caps().clone(),
            options: self.options,
            dynamic: self.dynamic().collect(),
        }
    }

    /// Begins to make the plan that the present facts and values ask for, unless it is the one that renders.
    fn start_pending(&mut self) {
        self.sizes.renew();
        let Some(running) = &self.running else { return };
        let wish = self.wish(running.given.clone());
        let device = self.executor.device().clone();
        let (known, wish) = wish.on(&device, |request| self.plans.known(request));
        if known.as_ref().is_some_and(|known| Arc::ptr_eq(&known.plan, &running.plan)) {
            return;
        }
        let (graph, compile) = (self.plans.shared_graph(), self.executor.compilation());
        let (number, fade_parts) = (self.age.graph, self.fade_parts());
        let work = move || {
            span!("afterimage::prepare");
            let (planned, new, wish) = match known {
                Some(planned) => (planned, None, wish),
                None => {
                    let (new, wish) = wish.planned(&device, &graph)?;
                    (new.planned.clone(), Some(new), wish)
                }
            };
            let changed = wish.dynamic.iter().map(|parameter| parameter.node).collect();
            let running = ActivePlan::new(number, wish.given, &planned, (&graph, changed));
            let prepared = compile(running.wanted())?;
            Ok(Ready { running, prepared, new, parts: fade_parts.map(|make| make()) })
        };
        let worker = Worker::new(self.executor.pool.as_ref(), work);
        self.next = Some(PendingPlan { age: self.age, changed: Vec::new(), worker });
    }

    /// Brings in a plan that was made in the background, with the frame that is its first; without a frame if the host
    /// waits for the plan.
    fn activate(&mut self, next: PendingPlan, frame: Option<&Frame<'_>>) -> Result<(), PostError> {
        if next.age.graph != self.age.graph {
            // The plan for the present graph is made after it.
            self.executor.drop_later(next.worker);
            return Ok(());
        }
        let Ready { mut running, prepared, new, parts } = next.worker.join()??;
        let beginning = self.beginning(&running.plan, frame, parts);
        let old = self.executor.install(prepared)?;
        let unkept = new.filter(|_| next.age == self.age).and_then(|new| self.plans.keep(new.key, new.planned));
        next.changed.into_iter().for_each(|node| running.uniforms.change(node));
        let before = self.running.replace(running);
        let before = before.and_then(|before| self.begin_fade(beginning, before));
        self.executor.drop_later((old, before, unkept));
        Ok(())
    }

    /// Writes the uniforms that have changed, in one range.
    pub(super) fn write_uniforms(&mut self) -> Result<(), PostError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        // A plan of another graph renders on with the values that it had.
        if running.graph == self.age.graph
            && running.uniforms.update(&mut running.dynamic, self.plans.graph()) == Err(NeedsPlan)
        {
            self.plans.clear();
            self.age.values += 1;
            self.is_stale = true;
        }
        running.write(&mut self.executor)?;
        Ok(())
    }

    /// Waits for the plan that the present facts and values ask for, and brings it in. A [fade](Self::set_fade) ends.
    ///
    /// # Errors
    /// It cannot be made, or the device refuses it: the old plan renders on.
    pub fn finish_changes(&mut self) -> Result<(), PostError> {
        self.end_fade(FadeSkipReason::Awaited);
        while self.is_changing() && self.running.is_some() {
            if let Some(next) = self.next.take() {
                self.activate(next, None)?;
            }
            if std::mem::take(&mut self.is_stale) {
                self.start_pending();
            }
        }
        Ok(())
    }
}

impl ActivePlan {
    /// A plan at the values of a graph, which has that number. `changed` are nodes that may have others in the plan.
    fn new(number: u64, given: HostInputs, planned: &Planned, (graph, changed): (&Graph, Vec<usize>)) -> Self {
        let (plan, mut dynamic) = (planned.plan.clone(), planned.dynamic.clone());
        let uniforms = Uniforms::at(&plan, &mut dynamic, graph, changed);
        Self { graph: number, given, plan, dynamic, uniforms }
    }

    pub(super) fn wanted(&self) -> PlanWithUniforms {
        PlanWithUniforms { plan: self.plan.clone(), uniforms: self.uniforms.bytes.clone() }
    }

    /// Writes the uniforms that the executor of this plan lacks.
    pub(super) fn write(&mut self, executor: &mut Executor) -> Result<(), GpuError> {
        let Some(unwritten) = self.uniforms.unwritten.clone() else { return Ok(()) };
        executor.write_uniforms(unwritten.start as u64, &self.uniforms.bytes[unwritten])?;
        self.uniforms.unwritten = None;
        Ok(())
    }
}

fn view_of<'f>(frame: &Frame<'f>, input: &GraphInput) -> Option<&'f TextureView> {
    frame.inputs.iter().find(|(name, _)| *name == input.name).map(|(_, view)| *view)
}

fn gives_block(frame: &Frame<'_>, input: &GraphInput) -> bool {
    input.block.is_some() && frame.blocks.iter().any(|(name, _)| *name == input.name)
}

fn output_size(frame: &Frame<'_>) -> Option<Size> {
    let (name, view) = frame.outputs.first()?;
    Some(frame.rectangle(name).unwrap_or(Rectangle::of_texture(view.texture())).size())
}

/// Whether an output goes into a rectangle of the host's image.
fn is_in_rectangle(frame: &Frame<'_>, output: &str) -> bool {
    frame.rectangle(output).is_some() && frame.outputs.iter().any(|(name, _)| *name == output)
}

/// The description of the host's texture for an input.
fn desc_of(input: &GraphInput, view: &TextureView) -> Result<ImageDesc, GpuError> {
    let texture = view.texture();
    let unfit = |why: String| GpuError::UnfitImage { port: input.name.clone(), why };
    let unknown = || unfit(format!("its format, {:?}, is none that plans have", texture.format()));
    let format = image_format(texture.format()).ok_or_else(unknown)?;
    let samples = texture.sample_count();
    match (input.multisampled, samples > 1) {
        (true, false) => return Err(unfit("it has one sample in each pixel, and the pipeline wants more".into())),
        (false, true) => return Err(unfit(MULTISAMPLED.into())),
        _ => {}
    }
    let is_volume = texture.dimension() == wgpu::TextureDimension::D3;
    match (input.volume, is_volume) {
        (true, false) => return Err(unfit("it is no 3-D texture, and the pipeline wants a volume".into())),
        (false, true) => return Err(unfit(VOLUME.into())),
        _ => {}
    }
    let depth = if is_volume { texture.depth_or_array_layers() } else { 1 };
    let size = Size::volume(texture.width(), texture.height(), depth);
    let desc = if is_volume { ImageDesc::volume(size) } else { ImageDesc::new(size) };
    Ok(desc.format(format).multisampled(samples))
}
