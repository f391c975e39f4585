//! Runs plans of the kinds of this test on the CPU: pass by pass in the planned order, into the planned memory.

use std::collections::BTreeMap;

use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin, Pass, Resource};
use afterimage_plan::Plan;
use afterimage_wgsl::SampleMode;

use super::kinds::{Value, kernel, reads_texels_as_they_are};
use super::reference::image::{Image, center_uv};
use super::reference::sanitize::{MAX_HALF, sanitize_rgb, sanitized};
use crate::machine::memory;

pub struct Executor<'p> {
    plan: &'p Plan,
    /// The picture that the host gives in this frame.
    picture: Image,
    contents: BTreeMap<ImageId, Image>,
    /// What was held at the ends of earlier frames, the last one first.
    past: Vec<BTreeMap<ImageId, Image>>,
}

impl<'p> Executor<'p> {
    /// The outputs of some frames, each with that picture.
    pub fn frames(plan: &'p Plan, pictures: &[Image]) -> Vec<Vec<(String, Image)>> {
        let mut executor = Self { plan, picture: pictures[0].clone(), contents: BTreeMap::new(), past: Vec::new() };
        pictures.iter().map(|picture| executor.frame(picture)).collect()
    }

    fn frame(&mut self, picture: &Image) -> Vec<(String, Image)> {
        self.picture = picture.clone();
        for batch in &self.plan.batches {
            // Memory that goes to another image holds nothing that may be read.
            batch.aliasing.iter().for_each(|barrier| self.take_memory(barrier.image));
            for planned in &self.plan.passes[batch.passes.clone()] {
                let result = planned.pass.results[0].image;
                let image = self.pass(&planned.pass);
                self.take_memory(result);
                self.contents.insert(result, image);
            }
        }
        let shown = self.plan.outputs.iter().map(|output| (output.name.clone(), self.image(output.image))).collect();
        self.past.insert(0, std::mem::take(&mut self.contents));
        shown
    }

    /// Drops what other images hold in the memory of this one.
    fn take_memory(&mut self, image: ImageId) {
        let Some(taken) = memory(self.plan, image) else { return };
        let meets = |other: ImageId| {
            memory(self.plan, other).is_some_and(|range| range.start < taken.end && taken.start < range.end)
        };
        self.contents.retain(|other, _| !meets(*other));
    }

    fn pass(&self, pass: &Pass) -> Image {
        let result = pass.results[0];
        let size = self.plan.image(result.image).desc.size;
        let (width, height) = (size.width as usize, size.height as usize);
        let images = pass.reads().into_iter().filter_map(Resource::image);
        let read: BTreeMap<ImageId, [Image; 2]> = images.map(|image| (image, self.read(image))).collect();
        Image::new(width, height, |x, y| {
            let mut values: Vec<[f64; 4]> = Vec::new();
            for call in &pass.kernels {
                let args: Vec<Value<'_>> = call
                    .args
                    .iter()
                    .map(|arg| match arg.value {
                        Arg::Kernel(kernel) => Value::Number(values[kernel]),
                        Arg::PointOf(kernel) => Value::At([values[kernel][0], values[kernel][1]]),
                        Arg::Point => Value::At(center_uv(x, y, width, height)),
                        Arg::Pixel(image) => Value::Number(read[&image][1].texel(x as i64, y as i64)),
                        Arg::Texture(image) => Value::Texture(texture(&read[&image], call)),
                        Arg::Zero(_) => Value::Number([0.0; 4]),
                        Arg::Sampler => Value::Nothing,
                        other => panic!("no kind of this test reads {other:?}"),
                    })
                    .collect();
                values.push(kernel(&call.function, &args, [width as f64, height as f64]));
            }
            values[result.kernel]
        })
    }

    /// What an image holds, and how the library reads it.
    fn read(&self, id: ImageId) -> [Image; 2] {
        let image = self.image(id);
        let library = match self.plan.image(id).sample_mode {
            SampleMode::Plain | SampleMode::ByHand => image.clone(),
            SampleMode::Sanitized => image.map_rgb(sanitize_rgb),
            SampleMode::SanitizedLight => sanitized(&image),
            SampleMode::SanitizedSigned => {
                let limited = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(-MAX_HALF, MAX_HALF) };
                image.map(|pixel| pixel.map(limited))
            }
        };
        [image, library]
    }

    /// What an image holds: NaN if it was not written, or if another one has its memory.
    fn image(&self, id: ImageId) -> Image {
        let planned = self.plan.image(id);
        let size = planned.desc.size;
        let filled = |number| Image::new(size.width as usize, size.height as usize, |_, _| [number; 4]);
        match &planned.origin {
            Origin::Input(_) => self.picture.clone(),
            Origin::Transient | Origin::Retained => self.contents.get(&id).cloned().unwrap_or_else(|| filled(f64::NAN)),
            Origin::Previous { of, frames } => {
                let past = self.past.get(*frames as usize - 1).map(|past| past.get(of).cloned());
                past.map_or_else(|| filled(0.0), |image| image.unwrap_or_else(|| filled(f64::NAN)))
            }
            Origin::Constant(_) => panic!("no kind of this test has a table"),
        }
    }
}

fn texture<'a>([unchanged, library]: &'a [Image; 2], call: &KernelCall) -> &'a Image {
    if reads_texels_as_they_are(&call.function) { unchanged } else { library }
}
