//! Formats: whether each pass is dispatched or drawn, and what its images need for that.
//!
//! This comes after fusion, because only passes of functions can be drawn, and before scheduling, which needs the bytes
//! of the images.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::PlanBuilder;
use crate::error::PlanError;
use crate::options::{Alias, Options};
use crate::plan::{PlannedImage, Refresh, ScheduledPass, Stage};
use crate::request::PlanRequest;
use afterimage_base::caps::Caps;
use afterimage_base::image::{Format, ImageDesc};
use afterimage_graph::node::{Drawing, ImageId, Origin, Pass, Recording, Resource, VirtualImage};
use afterimage_wgsl::SampleMode;

/// Passes and images with everything that depends on formats.
pub(crate) struct Formatted {
    /// The passes in the order of recording.
    pub(crate) passes: Vec<ScheduledPass>,
    /// The images, without their places in memory.
    pub(crate) images: Vec<PlannedImage>,
    /// The options that hold on this device for these passes.
    pub(crate) options: Options,
}

/// Chooses how each pass writes; formats that a device can neither store nor draw become wider.
pub(crate) fn formats(builder: &mut PlanBuilder, request: &PlanRequest<'_>) -> Result<Formatted, PlanError> {
    for image in &builder.recording.images {
        check_size(image, &request.caps)?;
    }
    for pass in &builder.recording.passes {
        check_uniforms(pass, &request.caps)?;
    }
    let passes = staged(builder, &request.caps);
    for planned in &passes {
        check_blends(planned, &builder.recording, &request.caps)?;
    }
    let mut options = request.options;
    if passes.iter().any(|pass| pass.stage != Stage::Compute) {
        // Images that are drawn to have layouts of their own, and images that overlap would need different ones.
        options.alias = options.alias.min(Alias::Pool);
    }
    if options.repeatable {
        options.alias = Alias::None;
    }
    let images = images(builder, request);
    Ok(Formatted { passes, images, options })
}

fn check_size(image: &VirtualImage, caps: &Caps) -> Result<(), PlanError> {
    let ImageDesc { size, volume, .. } = image.desc;
    let limit = if volume { caps.max_volume_side } else { caps.max_side };
    let fits = size.width.max(size.height).max(size.depth) <= limit;
    if fits { Ok(()) } else { Err(PlanError::TooLarge { label: image.label.clone(), size, limit }) }
}

fn check_uniforms(pass: &Pass, caps: &Caps) -> Result<(), PlanError> {
    let (count, limit) = (pass.uniform_buffers(), caps.max_uniform_buffers);
    let fits = count <= limit as usize;
    if fits { Ok(()) } else { Err(PlanError::TooManyUniformBuffers { label: pass.label.clone(), count, limit }) }
}

/// An image is as wide as its device can make it, and still no draw can blend into it.
fn check_blends(planned: &ScheduledPass, recording: &Recording, caps: &Caps) -> Result<(), PlanError> {
    let blended = planned.pass.drawing().into_iter().flat_map(Drawing::blended).map(|image| recording.image(image));
    let mut blended = blended.filter(|image| !caps.blendable.contains(&image.desc.format));
    match blended.next() {
        None => Ok(()),
        Some(VirtualImage { label, desc, .. }) => {
            Err(PlanError::NotBlendable { pass: planned.pass.label.clone(), image: label.clone(), format: desc.format })
        }
    }
}

fn staged(builder: &mut PlanBuilder, caps: &Caps) -> Vec<ScheduledPass> {
    let stores = stores(builder);
    let recording = &mut builder.recording;
    let passes = std::mem::take(&mut recording.passes);
    let mut staged = Vec::with_capacity(passes.len());
    for ((recorded, pass), stores) in passes.into_iter().enumerate().zip(stores) {
        let mut stage = Stage::Compute;
        for image in pass.writes().into_iter().filter_map(Resource::image) {
            let format = &mut recording.images[image.0 as usize].desc.format;
            stage = match pass.drawing() {
                Some(drawing) => {
                    make_renderable(format, drawing.blended().any(|blended| blended == image), caps);
                    Stage::Drawing
                }
                None => choose(format, pass.kind.is_drawable(), caps),
            };
        }
        let refresh = BTreeSet::from([Refresh::EachFrame]);
        staged.push(ScheduledPass { pass, stage, stores, recorded, refresh });
    }
    staged
}

/// For each pass and attachment whether the image is read by a later pass, or leaves the frame. What is not stored
/// costs no memory traffic on devices that draw in tiles.
fn stores(builder: &PlanBuilder) -> Vec<Vec<bool>> {
    let mut read: BTreeSet<ImageId> = builder.kept();
    let mut stores = Vec::new();
    for pass in builder.recording.passes.iter().rev() {
        let targets = pass.drawing().into_iter().flat_map(Drawing::targets);
        stores.push(targets.map(|target| read.contains(&target.image)).collect());
        read.extend(pass.reads().into_iter().filter_map(Resource::image));
    }
    stores.reverse();
    stores
}

/// Every device draws to all formats of depth.
fn make_renderable(format: &mut Format, blends: bool, caps: &Caps) {
    let fits = |format: &Format| caps.renderable.contains(format) && (!blends || caps.blendable.contains(format));
    while !format.is_depth() && !fits(format) && format.wider() != *format {
        *format = format.wider();
    }
}

fn choose(format: &mut Format, is_drawable: bool, caps: &Caps) -> Stage {
    loop {
        let (stores, draws) = (caps.storage.contains(format), is_drawable && caps.renderable.contains(format));
        match (stores, draws) {
            (_, true) if caps.prefer_fragment => return Stage::Fragment,
            (true, _) => return Stage::Compute,
            (false, true) => return Stage::Fragment,
            (false, false) if format.wider() == *format => return Stage::Compute,
            (false, false) => *format = format.wider(),
        }
    }
}

fn images(builder: &PlanBuilder, request: &PlanRequest<'_>) -> Vec<PlannedImage> {
    let kept = builder.kept();
    let mut asked = BTreeMap::new();
    let mut images = Vec::with_capacity(builder.recording.images.len());
    for (image, id) in builder.recording.images.iter().zip(0..) {
        let shares = image.origin == Origin::Transient && !kept.contains(&ImageId(id));
        let requirement =
            shares.then(|| *asked.entry(image.desc).or_insert_with(|| (request.requirement)(&image.desc)));
        images.push(PlannedImage {
            label: image.label.clone(),
            desc: image.desc,
            origin: image.origin.clone(),
            signedness: image.signedness,
            sample_mode: sample_mode(image, &request.caps, request.options.exact),
            lifetime: None,
            requirement,
            offset: None,
            slot: None,
        });
    }
    images
}

/// The sample mode of an image on this device. For exact results all filtering is done in the shader: a device's own
/// filter has eight bits of fraction.
fn sample_mode(image: &VirtualImage, caps: &Caps, exact: bool) -> SampleMode {
    let format = image.desc.format;
    let manual_filtering = exact || format.is_depth() || format.is_32_bit() && !caps.filter_32_bit;
    match (!image.finite, manual_filtering) {
        (true, _) => SampleMode::sanitizing(image.signedness),
        (false, true) => SampleMode::ByHand,
        (false, false) => SampleMode::Plain,
    }
}
