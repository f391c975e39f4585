//! The files of earlier runs that `--skip-existing` keeps.

use std::collections::BTreeMap;
use std::path::Path;

use afterimage_graph::image::Size;
use afterimage_media::{ChannelDescription, PartDescription, Source, Window, read_description, read_whole};
use afterimage_plan::Plan;

use super::frames;
use super::jobs::Job;
use super::prepared::{Prepared, has_state, typical_size};
use super::read::read_options;
use super::request::{Request, is_picture};
use super::target::{FilmTarget, Target};
use crate::args::files::OtherSize;
use crate::failure::Failure;

/// For each job, whether all of its files are there and whole: they are decoded, and have the size and the numbers that
/// would be written. Also, whether frames leave something for later ones.
pub(super) fn done(prepared: &Prepared<'_>) -> (Vec<bool>, bool) {
    let request = &prepared.request;
    let typical = prepared.typical_plan();
    let has_state = has_state(typical.as_ref());
    let mut plans = BTreeMap::from([(typical_size(), typical)]);
    let mut first = None;
    let mut done = Vec::new();
    for job in &request.jobs {
        let size = match (first, request.args.reading.resize) {
            (Some(first), OtherSize::Fit) => Some(first),
            _ => size(request, job),
        };
        first = first.or(size);
        let is_there = job.is_written && job.out.iter().all(|file| file.exists());
        let Some(size) = size.filter(|_| is_there) else {
            done.push(false);
            continue;
        };
        let plan = plans.entry(size).or_insert_with(|| prepared.plan(size));
        let mut files = job.out.iter().zip(&request.targets);
        done.push(plan.as_ref().is_some_and(|plan| {
            files.all(|(file, target)| is_whole(request, file, target, output_size(request, plan, target)))
        }));
    }
    (done, has_state)
}

/// Refuses films whose codec has no frames of their size, as far as the size is known before a frame is rendered.
pub(super) fn check_films(prepared: &Prepared<'_>) -> Result<(), Failure> {
    let request = &prepared.request;
    let films = request.targets.iter().filter_map(|target| Some((target, target.film.as_ref()?)));
    let mut plan = None;
    for (target, FilmTarget { preset, more }) in films {
        let Some(size) = request.jobs.first().and_then(|job| size(request, job)) else { return Ok(()) };
        let plan = plan.get_or_insert_with(|| prepared.plan(size));
        if let Some(size) = plan.as_ref().and_then(|plan| output_size(request, plan, target)) {
            preset.check_size(Path::new(&target.file), size, more)?;
        }
    }
    Ok(())
}

/// The size of a job's first image, from the headers of its file.
fn size(request: &Request<'_>, job: &Job) -> Option<Size> {
    let is_image = |name: &str| request.inputs.iter().any(|input| input.name == name && is_picture(input));
    let Some((name, source)) = job.sources.iter().find(|(name, _)| is_image(name)) else {
        return Some(frames::size(request, std::iter::empty()));
    };
    if let Some(film) = request.films.get(name) {
        let scale = request.args.reading.scale.unwrap_or(1.0);
        let (width, height) = film.size;
        let [width, height] = [width, height].map(|side| (f64::from(side) * scale).round().max(1.0) as u32);
        return Some(Size::new(width, height));
    }
    // A file that cannot be read is reported when it is.
    let description = read_description(source).ok()?;
    let part = description.parts.get(description.picture.map_or(0, |picture| picture.part))?;
    let window = if read_options(request, name).data_window { part.data } else { part.display };
    let scale = request.args.reading.scale.unwrap_or(1.0);
    let [width, height] = [window.width, window.height].map(|side| (side as f64 * scale).round().max(1.0) as u32);
    Some(Size::new(width, height))
}

fn output_size(request: &Request<'_>, plan: &Plan, target: &Target) -> Option<(u32, u32)> {
    let size = plan.image(plan.output(Some(&target.output))?.image).desc.size;
    Some(request.args.crop.map_or((size.width, size.height), |crop| crop.size))
}

/// True if a file holds a whole picture of its format in this size.
fn is_whole(request: &Request<'_>, file: &Path, target: &Target, size: Option<(u32, u32)>) -> bool {
    let Some(size) = size else { return false };
    let Ok(found) = read_whole(&Source::file(file), request.args.images.budget()) else { return false };
    let is_written = |part: &PartDescription| {
        let Window { width, height, .. } = part.data;
        (width, height) == (size.0.into(), size.1.into()) && has_channels(&part.channels, target)
    };
    found.format == target.saving.encoding.format.name() && found.parts.iter().any(is_written)
}

/// True if a part has red, green and blue in the numbers of the target. An EXR file may have them in a layer.
fn has_channels(channels: &[ChannelDescription], target: &Target) -> bool {
    let encoding = &target.saving.encoding;
    let samples = match (encoding.has_codes(), encoding.bits) {
        (false, 32) => "float",
        (false, _) => "half",
        (true, 9..) => "16 bits",
        (true, _) => "8 bits",
    };
    let is_there = |letter: &str| {
        let name = |channel: &ChannelDescription| {
            let last = channel.name.rsplit('.').next().unwrap_or_default();
            last.get(..1).is_some_and(|first| first.eq_ignore_ascii_case(letter)) && channel.samples == samples
        };
        channels.iter().any(name)
    };
    ["r", "g", "b"].iter().all(|letter| is_there(letter))
}
