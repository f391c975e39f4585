//! A picture that is larger than the device, or than the memory for it: rows come from its files and go to its files,
//! band by band.

use std::borrow::Cow;
use std::ops::Range;

use afterimage::offline::quantize::with_encoded_pixels;
use afterimage_gpu::{BandFiles, Session, Texels};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_media::{PngFile, PngOptions, ReadOptions, read_within};
use afterimage_plan::{BandLimits, Plan, PlanOutput};

use super::jobs::Job;
use super::read::InputPicture;
use super::readings::{Reading, reading, value_of};
use super::repairs::Repairs;
use super::request::Request;
use super::state;
use crate::args::Crop;
use crate::failure::Failure;
use crate::save::Stated;
use crate::terminal::note;

/// The files of a picture.
pub(super) struct PictureFiles<'a> {
    pictures: &'a [InputPicture],
    /// The pixels of each input that are repaired, and the row up to which they are counted.
    repairs: Vec<(Repairs, u32)>,
    outputs: Vec<OutputRows<'a>>,
}

/// An output of which rows come one after another.
struct OutputRows<'a> {
    output: PlanOutput,
    /// Of what is written.
    desc: ImageDesc,
    crop: Crop,
    /// The file that takes them.
    png: Option<(&'a std::path::Path, PngOptions)>,
    open: Option<PngFile>,
    /// Otherwise they are kept.
    bytes: Vec<u8>,
}

/// A picture that was made in bands.
pub(super) struct Made {
    /// The outputs in the order of the targets; their texels, unless they are in their files.
    pub(super) outputs: Vec<(PlanOutput, Option<Texels>)>,
    /// The repaired pixels of each input.
    pub(super) repairs: Vec<Repairs>,
    pub(super) exposure: Vec<Reading>,
}

/// Renders a picture in bands.
pub(super) fn render(
    request: &Request<'_>,
    session: &mut Session,
    plan: &Plan,
    job: &Job,
    pictures: &[InputPicture],
    meters: &[String],
) -> Result<Made, Failure> {
    check_state(request, plan)?;
    let mut outputs = Vec::new();
    for (target, file) in request.targets.iter().zip(&job.out) {
        let output = plan.output(Some(&target.output)).expect("the graph has this output").clone();
        let desc = plan.image(output.image).desc;
        let crop = crop(request, desc)?;
        let desc = desc.sized(Size::new(crop.size.0, crop.size.1));
        let png = target.saving.png_rows(Stated::of(&output).colorimetry, job.frame.unwrap_or(0));
        let is_streamed = pictures.iter().any(|input| input.streamed.is_some());
        let is_large = is_streamed || desc.bytes() > request.args.images.budget().0;
        let png = png.filter(|options| is_large && afterimage_media::PngRows::<std::fs::File>::can_write(options));
        let png = png.map(|options| (file.as_path(), options));
        outputs.push(OutputRows { output, desc, crop, png, open: None, bytes: Vec::new() });
    }
    let repairs = pictures.iter().map(|input| (input.repairs, 0)).collect();
    let mut files = PictureFiles { pictures, repairs, outputs };
    let rows = request.args.crop.map(|Crop { corner: (_, y), size: (_, height) }| [y, y + height]);
    let (bytes, side) = (session.gpu().caps.max_memory, session.gpu().caps.max_side);
    let limits = BandLimits { bytes, side, filters: session.gpu().is_processor(), least: 1, rows };
    let frame = job.frame.unwrap_or(0);
    let values: Vec<String> = meters.iter().map(|meter| value_of(meter)).collect();
    let made = session.render_in_bands(plan, limits, request.step(frame, None, true), frame, &values, &mut files)?;
    if made.bands > made.sweeps {
        note(&format!(
            "note: the picture is larger than the device or `--gpu-memory`: it is made in {} bands of {} sweeps, with \
             {} MiB",
            made.bands,
            made.sweeps,
            made.bytes.div_ceil(1 << 20)
        ));
    }
    let repairs = files.repairs.iter().map(|(repairs, _)| *repairs).collect();
    let exposure = meters.iter().zip(made.values).filter_map(|(meter, value)| reading(meter, value)).collect();
    let mut outputs = Vec::new();
    for rows in files.outputs {
        let texels = match rows.open {
            Some(png) => {
                png.finish()?;
                None
            }
            None => Some(Texels { desc: rows.desc, bytes: rows.bytes }),
        };
        outputs.push((rows.output, texels));
    }
    Ok(Made { outputs, repairs, exposure })
}

/// The part of an output that is written.
fn crop(request: &Request<'_>, desc: ImageDesc) -> Result<Crop, Failure> {
    let (width, height) = (desc.size.width, desc.size.height);
    let crop = request.args.crop.unwrap_or(Crop { corner: (0, 0), size: (width, height) });
    let ends = [(crop.corner.0, crop.size.0, width), (crop.corner.1, crop.size.1, height)];
    let is_inside = ends.iter().all(|(first, count, all)| first.checked_add(*count).is_some_and(|end| end <= *all));
    match is_inside {
        true => Ok(crop),
        false => Err(Failure::user(format!("`--crop` is a part beyond the {width}x{height} pixels of the picture"))
            .hint(format!("the whole is `--crop 0,0,{width}x{height}`"))),
    }
}

/// Refuses a frame of a sequence that depends on those before: their histories are not kept.
fn check_state(request: &Request<'_>, plan: &Plan) -> Result<(), Failure> {
    let is_alone = request.jobs.len() == 1 && request.state.is_none() && request.measured.is_empty();
    let items = plan.state();
    if items.is_empty() || is_alone && request.args.state_out.is_none() {
        return Ok(());
    }
    let names = state::names(&items);
    Err(Failure::user(format!("frames that are made in bands, or cropped, leave no state for the next one: {names}"))
        .hint("render them whole, with more memory: `--gpu-memory SIZE`"))
}

impl BandFiles for PictureFiles<'_> {
    type Error = Failure;

    fn read(&mut self, input: &str, rows: Range<u32>) -> Result<Cow<'_, [u8]>, Failure> {
        let index = self.pictures.iter().position(|picture| picture.name == input).expect("the plan has its inputs");
        let InputPicture { picture, desc, streamed, signedness, .. } = &self.pictures[index];
        let row = desc.size.width as usize * desc.format.bytes() as usize;
        let Some((source, options)) = streamed else {
            return Ok(Cow::Borrowed(&picture.bytes()[rows.start as usize * row..rows.end as usize * row]));
        };
        let options = ReadOptions { rows: Some([rows.start, rows.end - rows.start]), ..*options };
        let part = read_within(source, options)?;
        if part.bytes().len() != row * (rows.end - rows.start) as usize {
            return Err(Failure::user(format!("{}: the file has changed", source.path.display())));
        }
        let (repairs, counted) = &mut self.repairs[index];
        if rows.end > *counted {
            let new = counted.saturating_sub(rows.start);
            *repairs = repairs.and(Repairs::below(&part, new, *signedness));
            *counted = rows.end;
        }
        Ok(Cow::Owned(part.bytes().to_vec()))
    }

    fn write(&mut self, output: &str, rows: Range<u32>, texels: &[u8]) -> Result<(), Failure> {
        let to = self.outputs.iter_mut().find(|rows| rows.output.name == output);
        let OutputRows { desc, crop, png, open, bytes, .. } = to.expect("the plan has the outputs of targets");
        let row = texels.len() / (rows.end - rows.start) as usize;
        let Crop { corner: (x, y), size: (width, height) } = *crop;
        let (first, end) = (rows.start.max(y), rows.end.min(y + height));
        if first >= end {
            return Ok(());
        }
        let texel = desc.format.bytes() as usize;
        let texels = &texels[(first - rows.start) as usize * row..(end - rows.start) as usize * row];
        let columns = texel * x as usize..texel * (x + width) as usize;
        let texels: Cow<'_, [u8]> = match columns.len() == row {
            true => Cow::Borrowed(texels),
            false => texels.chunks_exact(row).flat_map(|row| &row[columns.clone()]).copied().collect(),
        };
        let Some((path, options)) = png else {
            if first == y {
                bytes.clear();
                bytes.reserve_exact(desc.bytes() as usize);
            }
            bytes.extend_from_slice(&texels);
            return Ok(());
        };
        if first == y {
            *open = Some(PngFile::begin(path, (desc.size.width, desc.size.height), options)?);
        }
        let size = Size { height: end - first, ..desc.size };
        let texels = Texels { desc: ImageDesc { size, ..*desc }, bytes: texels.into_owned() };
        let file = open.as_mut().expect("the first row comes first");
        Ok(with_encoded_pixels(&texels, |pixels| file.write(pixels))?)
    }
}
