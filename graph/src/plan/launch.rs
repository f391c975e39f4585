//! The module of a launch, and its workgroups.

use std::collections::BTreeSet;

use super::Plan;
use crate::image::ImageDesc;
use crate::node::{ImageId, Pass, Resource, Work};
use crate::shader::{Beside, Composed, Reading, ShaderError, compose_beside, compose_pass};

impl Plan {
    /// The number of the launch that a pass belongs to.
    pub fn launch_of(&self, pass: usize) -> usize {
        self.launches.partition_point(|launch| launch.end <= pass)
    }

    /// What its passes are called, together.
    pub fn launch_label(&self, launch: usize) -> String {
        let labels: Vec<&str> = self.launched(launch).iter().map(|pass| pass.label.as_str()).collect();
        labels.join(" & ")
    }

    /// The module that a launch runs.
    pub fn compose(&self, launch: usize) -> Result<Composed, ShaderError> {
        let desc = |image: ImageId| -> ImageDesc { self.recording.image(image).desc };
        let reading = |image: ImageId| -> Reading { self.readings[image.0 as usize] };
        let compose = |pass: usize| compose_pass(&self.recording.passes[pass], &desc, &reading, self.dialect(pass));
        let alone = self.launches[launch].clone().map(compose).collect::<Result<Vec<_>, _>>()?;
        match <[Composed; 1]>::try_from(alone) {
            Ok([composed]) => Ok(composed),
            Err(several) => Ok(compose_beside(&self.beside(launch, &several), self.reads_together(launch))),
        }
    }

    /// The workgroups of a launch that dispatches.
    pub fn launch_workgroups(&self, launch: usize) -> [u32; 3] {
        match self.launched(launch) {
            [pass] => self.recording.workgroups(pass).count,
            passes => {
                let all = passes.iter().map(|pass| self.recording.workgroups(pass));
                let lanes = all.clone().map(|own| own.lanes).max().unwrap_or(1);
                let packed = all.zip(passes).map(|(own, pass)| {
                    let count: u32 = own.count.iter().product();
                    if packs(pass) { count.div_ceil(lanes / own.lanes) } else { count }
                });
                [packed.sum(), 1, 1]
            }
        }
    }

    /// Whether several passes of a launch read one image.
    fn reads_together(&self, launch: usize) -> bool {
        let images = |pass: &Pass| pass.reads().into_iter().filter(|read| matches!(read, Resource::Image(_)));
        let mut seen = BTreeSet::new();
        self.launched(launch).iter().flat_map(images).any(|image| !seen.insert(image))
    }

    fn launched(&self, launch: usize) -> &[Pass] {
        &self.recording.passes[self.launches[launch].clone()]
    }

    fn beside<'a>(&'a self, launch: usize, several: &'a [Composed]) -> Vec<Beside<'a>> {
        let beside = |(pass, composed): (&'a Pass, &'a Composed)| Beside {
            composed,
            constants: match &pass.work {
                Work::Entry(call) => &call.constants,
                _ => &[],
            },
            packs: packs(pass),
        };
        self.launched(launch).iter().zip(several).map(beside).collect()
    }
}

/// Whether the invocations of a pass never wait for each other.
pub(super) fn packs(pass: &Pass) -> bool {
    match &pass.work {
        Work::Steps { .. } => true,
        Work::Entry(call) => !call.shader.waits(),
        Work::Tiled(_) | Work::Rows(_) | Work::Cells(_) => false,
    }
}
