//! Sizes that come later: their plans are made before, while the present one renders.

use std::sync::Arc;

use afterimage_graph::image::Size;
use afterimage_plan::{HostInputs, Plan};

use super::running::NextSize;
use super::{Post, PostError};
use crate::platform::Worker;

/// Sizes that are prepared at most: plans are kept for a few facts, too.
const MOST: usize = 16;

impl Post {
    /// Makes and compiles plans for other sizes of the frame in the background, one after another, also after each
    /// change of facts, tiers and pipelines. A frame of such a size then needs memory for its images only. Images of
    /// the size of the present frame are taken to have the new size, and others to keep theirs.
    ///
    /// # Panics
    /// If there are more than 16 sizes.
    pub fn expect_sizes(&mut self, sizes: &[Size]) {
        assert!(sizes.len() <= MOST, "at most {MOST} sizes can be expected");
        self.sizes.expected = sizes.to_vec();
        self.sizes.renew();
    }

    /// Whether the plans of all [expected sizes](Self::expect_sizes) are made.
    pub fn has_expected_sizes(&self) -> bool {
        self.sizes.missing.is_empty() && self.sizes.next.is_none()
    }

    /// The plan of an expected size, if it is made and the present facts want it.
    pub fn expected_plan(&mut self, size: Size) -> Option<Arc<Plan>> {
        let wish = self.wish(of_size(&self.running.as_ref()?.given, size));
        let device = self.executor.device().clone();
        let (known, _) = wish.on(&device, |request| self.plans.known(request));
        known.map(|known| known.plan.clone())
    }

    /// Takes the plan of a size that is finished, and begins the next. Returns why one has failed.
    pub(super) fn prepare_sizes(&mut self) -> Option<PostError> {
        if let Some(next) = self.sizes.next.take_if(|next| next.worker.is_finished()) {
            match next.worker.join().map_err(PostError::from).and_then(|new| new) {
                Ok(new) if next.age == self.age => {
                    let unkept = self.plans.keep(new.key, new.planned);
                    unkept.into_iter().for_each(|unkept| self.executor.drop_later(unkept));
                }
                Ok(_) => {}
                Err(error) => return Some(error),
            }
        }
        while self.sizes.next.is_none() && !self.is_changing() {
            let given = of_size(&self.running.as_ref()?.given, self.sizes.missing.last().copied()?);
            self.sizes.missing.pop();
            let wish = self.wish(given);
            let device = self.executor.device().clone();
            let (known, wish) = wish.on(&device, |request| self.plans.known(request));
            if known.is_none() {
                let (graph, compile) = (self.plans.shared_graph(), self.executor.compilation_ahead());
                let work = move || {
                    span!("afterimage::prepare");
                    let (new, _) = wish.planned(&device, &graph)?;
                    compile(&new.planned.plan)?;
                    Ok(new)
                };
                let worker = Worker::new(self.executor.pool.as_ref(), work);
                self.sizes.next = Some(NextSize { age: self.age, worker });
            }
        }
        None
    }
}

/// What the host gives at another size of the frame.
fn of_size(given: &HostInputs, size: Size) -> HostInputs {
    let mut other = HostInputs { size, ..given.clone() };
    let inputs = other.inputs.values_mut().filter(|image| image.desc.size == given.size);
    inputs.for_each(|image| image.desc.size = size);
    other
}
