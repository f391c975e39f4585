//! Which plan renders, when the next one is made, and when it comes in.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::GraphInput;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{GivenImage, NeedsPlan, Plan, PlanError, Planned};
use wgpu::TextureView;

use super::running::{Next, Running, Wish};
use super::uniforms::Uniforms;
use super::{Post, PostError};
use crate::device::image_format;
use crate::platform::Worker;
use crate::{Frame, GpuError};

impl Post {
    /// Brings in the plan for these images if there is another one than the one that renders. Returns why one that was
    /// being made has failed.
    pub(super) fn follow(&mut self, frame: &Frame<'_>) -> Result<Option<PostError>, PostError> {
        if !self.fits(frame)? {
            let (size, inputs) = self.given(frame)?;
            self.load_for(size, inputs)?;
            return Ok(None);
        }
        let failure = match self.next.take_if(|next| next.worker.is_finished()) {
            Some(next) => self.bring_in(next).err(),
            None => None,
        };
        if self.is_stale && self.next.is_none() {
            self.is_stale = false;
            self.begin_next();
        }
        Ok(failure)
    }

    /// Whether the plan that renders is for the host's images.
    fn fits(&self, frame: &Frame<'_>) -> Result<bool, GpuError> {
        let Some(running) = &self.running else { return Ok(false) };
        for input in &self.plans.graph().inputs {
            let given = view_of(frame, input).map(|view| desc_of(&input.name, view)).transpose()?;
            if given != running.inputs.get(&input.name).map(|given| given.desc) {
                return Ok(false);
            }
        }
        Ok(!running.inputs.is_empty() || output_size(frame).is_none_or(|size| size == running.size))
    }

    /// The size of the frame and the host's images. The size is that of the first input, or else of the first output.
    fn given(&self, frame: &Frame<'_>) -> Result<(Size, BTreeMap<String, GivenImage>), PostError> {
        let mut inputs = BTreeMap::new();
        let mut size = None;
        for input in &self.plans.graph().inputs {
            let Some(view) = view_of(frame, input) else { continue };
            let desc = desc_of(&input.name, view)?;
            size = size.or(Some(desc.size));
            inputs.insert(input.name.clone(), GivenImage { desc, finite: self.finite.contains(&input.name) });
        }
        let first = self.plans.graph().inputs.first();
        let missing =
            || PostError::from(PlanError::MissingInput(first.map_or(String::new(), |input| input.name.clone())));
        Ok((size.or(output_size(frame)).ok_or_else(missing)?, inputs))
    }

    /// Makes the plan for images of these descriptions and loads it, if it is not the one that renders.
    ///
    /// # Errors
    /// The graph cannot be planned for them, or the device refuses the plan.
    pub(crate) fn load_for(
        &mut self,
        size: Size,
        inputs: BTreeMap<String, GivenImage>,
    ) -> Result<&Arc<Plan>, PostError> {
        self.next = None;
        let planned = self.planned(size, inputs.clone())?;
        if self.running.as_ref().is_none_or(|running| !Arc::ptr_eq(&running.planned.plan, &planned.plan)) {
            self.executor.load(planned.plan.clone())?;
            self.run(size, inputs, planned);
        }
        self.is_stale = false;
        Ok(self.plan().expect("it runs"))
    }

    /// The plan for images of these descriptions, without loading it.
    fn planned(&mut self, size: Size, inputs: BTreeMap<String, GivenImage>) -> Result<Planned, PlanError> {
        let device = self.executor.device().clone();
        let wish = self.wish(size, inputs);
        wish.on(&device, |request| self.plans.planned(request))
    }

    /// The plan for images of these descriptions, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned for them.
    pub fn plan_for(&mut self, size: Size, inputs: BTreeMap<String, GivenImage>) -> Result<Arc<Plan>, PlanError> {
        Ok(self.planned(size, inputs)?.plan)
    }

    fn wish(&self, size: Size, inputs: BTreeMap<String, GivenImage>) -> Wish {
        Wish {
            size,
            inputs,
            facts: self.facts.clone(),
            caps: self.executor.caps().clone(),
            options: self.options,
            dynamic: self.dynamic().collect(),
        }
    }

    /// Begins to make the plan that the present facts and values ask for, unless it is the one that renders.
    fn begin_next(&mut self) {
        let Some(running) = &self.running else { return };
        let wish = self.wish(running.size, running.inputs.clone());
        let device = self.executor.device().clone();
        let known = wish.on(&device, |request| self.plans.known(request));
        if known.as_ref().is_some_and(|known| Arc::ptr_eq(&known.plan, &running.planned.plan)) {
            return;
        }
        let (graph, compile) = (self.plans.shared_graph(), self.executor.compilation());
        let wanted = wish.clone();
        let work = move || {
            let planned = match known {
                Some(planned) => planned,
                None => wanted.on(&device, |request| Planned::new(&graph, request))?,
            };
            let prepared = compile(planned.plan.clone())?;
            Ok((planned, prepared))
        };
        self.next = Some(Next { wish, worker: Worker::new(work) });
    }

    fn bring_in(&mut self, next: Next) -> Result<(), PostError> {
        let (planned, prepared) = next.worker.join()?;
        self.executor.put_in(prepared)?;
        let device = self.executor.device().clone();
        next.wish.on(&device, |request| self.plans.keep(request, &planned));
        self.run(next.wish.size, next.wish.inputs, planned);
        Ok(())
    }

    /// From now on this plan renders, with the present values of its dynamic parameters.
    fn run(&mut self, size: Size, inputs: BTreeMap<String, GivenImage>, planned: Planned) {
        let changed = self.dynamic().map(|parameter| parameter.node).collect();
        let uniforms = Uniforms::new(planned.plan.uniform_buffer(), changed);
        self.running = Some(Running { size, inputs, planned, uniforms });
    }

    /// Writes the uniforms that have changed, in one range.
    pub(super) fn write_uniforms(&mut self) -> Result<(), PostError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        if running.uniforms.update(&mut running.planned.dynamic, self.plans.graph()) == Err(NeedsPlan) {
            self.plans.clear();
            self.is_stale = true;
        }
        if let Some(unwritten) = running.uniforms.unwritten.clone() {
            self.executor.write_uniforms(unwritten.start as u64, &running.uniforms.bytes[unwritten])?;
            running.uniforms.unwritten = None;
        }
        Ok(())
    }

    /// Waits for the plan that the present facts and values ask for, and brings it in.
    ///
    /// # Errors
    /// It cannot be made, or the device refuses it: the old plan renders on.
    pub fn finish_changes(&mut self) -> Result<(), PostError> {
        while self.is_changing() && self.running.is_some() {
            if let Some(next) = self.next.take() {
                self.bring_in(next)?;
            }
            if std::mem::take(&mut self.is_stale) {
                self.begin_next();
            }
        }
        Ok(())
    }
}

fn view_of<'f>(frame: &Frame<'f>, input: &GraphInput) -> Option<&'f TextureView> {
    frame.inputs.iter().find(|(name, _)| *name == input.name).map(|(_, view)| *view)
}

fn output_size(frame: &Frame<'_>) -> Option<Size> {
    let texture = frame.outputs.first()?.1.texture();
    Some(Size::new(texture.width(), texture.height()))
}

/// The description of the host's image for an input.
fn desc_of(input: &str, view: &TextureView) -> Result<ImageDesc, GpuError> {
    let texture = view.texture();
    let format = image_format(texture.format()).ok_or_else(|| GpuError::UnfitImage {
        port: input.to_owned(),
        why: format!("its format, {:?}, is none that plans have", texture.format()),
    })?;
    Ok(ImageDesc::new(Size::new(texture.width(), texture.height())).format(format))
}
