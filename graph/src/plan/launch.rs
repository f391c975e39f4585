//! The module of a launch, and its workgroups.

use std::collections::BTreeSet;

use super::{Plan, Workgroups};
use crate::image::ImageDesc;
use crate::node::{ImageId, Pass, Resource};
use crate::shader::{Beside, Composed, SampleMode, ShaderError, compose_beside, compose_pass};

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
        let reading = |image: ImageId| -> SampleMode { self.sample_modes[image.0 as usize] };
        let compose = |pass: usize| compose_pass(&self.recording.passes[pass], &desc, &reading, self.features(pass));
        let alone = self.launches[launch].clone().map(compose).collect::<Result<Vec<_>, _>>()?;
        match <[Composed; 1]>::try_from(alone) {
            Ok([composed]) => Ok(composed),
            Err(several) => {
                let passes = self.launched(launch).iter().zip(&several);
                let modules: Vec<Beside<'_>> =
                    passes.map(|(pass, composed)| Beside { composed, constants: pass.constants() }).collect();
                Ok(compose_beside(&modules, self.reads_together(launch)))
            }
        }
    }

    /// The workgroups of a launch that dispatches. The largest of its passes do the work of several of smaller ones.
    pub fn launch_workgroups(&self, launch: usize) -> [u32; 3] {
        let all: Vec<Workgroups> = self.launched(launch).iter().map(|pass| self.recording.workgroups(pass)).collect();
        match all.as_slice() {
            [alone] => alone.count,
            several => {
                let lanes = several.iter().map(|own| own.lanes).max().unwrap_or(1);
                let shared = several.iter().map(|own| own.count.iter().product::<u32>().div_ceil(lanes / own.lanes));
                [shared.sum(), 1, 1]
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
}
