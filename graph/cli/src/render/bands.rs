//! Images that exceed the limits of the device or of memory: rows are read from files, rendered and written band by
//! band.

use std::mem;
use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

use afterimage::offline::Session;
use afterimage_gpu::{BandReader, BandWriter, Texels};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_media::{
    Encoding, ImageFile, ImageFormat, Metadata, ReadOptions, Repairs, Source, left_out, read_within,
};
use afterimage_plan::{BandLimits, HostLimits, Plan, PlanOutput};

use super::jobs::Job;
use super::metered::names;
use super::read::InputPicture;
use super::readings::{Reading, reading, value_of};
use super::request::Request;
use super::write::original;
use crate::args::Crop;
use crate::failure::Failure;
use crate::process::pool;
use crate::save::{ImageInfo, is_color, write_rows};
use crate::terminal::note;

/// Source of the rows of all inputs.
struct Inputs<'a> {
    inputs: Vec<InputRows<'a>>,
    pool: rayon::ThreadPool,
    busy: Duration,
}

/// An input that is read row by row.
struct InputRows<'a> {
    input: &'a InputPicture,
    /// The decoded rows, if the file is streamed, and the number of the first.
    decoded: Vec<u8>,
    first: u32,
    /// Rows end at a multiple of this, so that no block of the file is decoded twice.
    unit: u32,
    /// The pixels that are repaired, and the row up to which they are counted.
    repairs: Repairs,
    counted: u32,
}

/// Sink of the rows of all outputs.
struct Outputs<'a> {
    outputs: Vec<OutputRows<'a>>,
    busy: Duration,
}

/// An output that is written row by row.
struct OutputRows<'a> {
    output: PlanOutput,
    /// The description of the written part.
    desc: ImageDesc,
    crop: Crop,
    /// The file that is streamed to.
    file: Option<(&'a Path, Encoding, Option<Metadata>)>,
    open: Option<ImageFile>,
    /// The rows of an output that is not streamed.
    bytes: Vec<u8>,
}

/// The results of a frame that was rendered in bands.
pub(super) struct RenderedBands {
    /// The outputs in the order of the targets; their texels, unless they are in their files.
    pub(super) outputs: Vec<(PlanOutput, Option<Texels>)>,
    /// The repaired pixels of each input.
    pub(super) repairs: Vec<Repairs>,
    pub(super) exposure: Vec<Reading>,
    /// Time of reading and of writing files, while the device worked.
    pub(super) read: Duration,
    pub(super) write: Duration,
}

/// Bytes of the decoder of an EXR file besides its rows: three times what it decodes at a time.
const DECODER: u64 = 48 << 20;

/// Renders a frame in bands.
pub(super) fn render(
    request: &Request<'_>,
    session: &mut Session,
    plan: &Plan,
    job: &Job,
    pictures: &[InputPicture],
    meters: &[String],
) -> Result<RenderedBands, Failure> {
    check_state(request, plan)?;
    let mut outputs = Vec::new();
    for (target, file) in request.targets.iter().zip(&job.out) {
        let output = plan.output(Some(&target.output)).expect("the graph has this output").clone();
        let desc = plan.image(output.image).desc;
        let crop = crop(request, desc)?;
        let desc = desc.sized(Size::new(crop.size.0, crop.size.1));
        let is_streamed = pictures.iter().any(|input| input.streamed.is_some());
        let is_large = is_streamed || desc.bytes() > request.args.images.budget().0;
        let meta = pictures.first().map(|input| input.picture.meta.clone());
        let stated = ImageInfo { meta, frame: job.frame.unwrap_or(0), ..ImageInfo::of(&output) };
        let encoding = target.saving.encoding(&stated);
        let is_file = target.film.is_none() && !target.is_standard_output();
        let file = (is_large && is_file && !encoding.needs_all_rows())
            .then(|| (file.as_path(), encoding, stated.attributes()));
        if file.is_some() && encoding.format == ImageFormat::Exr && is_color(output.state) {
            note_left_out(request, job)?;
        }
        outputs.push(OutputRows { output, desc, crop, file, open: None, bytes: Vec::new() });
    }
    let mut inputs =
        Inputs { inputs: pictures.iter().map(InputRows::new).collect(), pool: pool("decode")?, busy: Duration::ZERO };
    let mut outputs = Outputs { outputs, busy: Duration::ZERO };
    let rows = request.args.crop.map(|Crop { corner: (_, y), size: (_, height) }| [y, y + height]);
    let host = host_limits(request, &inputs.inputs, &outputs.outputs);
    let limits = BandLimits { rows, host, ..session.gpu().band_limits() };
    let frame = job.frame.unwrap_or(0);
    let values: Vec<String> = meters.iter().map(|meter| value_of(meter)).collect();
    let (step, files) = (request.step(frame, None, true), (&mut inputs, &mut outputs));
    let stats = session.render_in_bands(plan, limits, step, frame, &values, files)?;
    if stats.bands > stats.sweeps {
        note(&format!(
            "note: image exceeds the memory limit; rendering {} bands in {} sweep{}, with {} MiB",
            stats.bands,
            stats.sweeps,
            if stats.sweeps == 1 { "" } else { "s" },
            stats.allocated.unwrap_or(stats.bytes).div_ceil(1 << 20)
        ));
    }
    let repairs = inputs.inputs.iter().map(|rows| rows.repairs).collect();
    let exposure = meters.iter().zip(stats.values).filter_map(|(meter, value)| reading(meter, value)).collect();
    let (read, mut write) = (inputs.busy, outputs.busy);
    let start = Instant::now();
    let finished = outputs.outputs.into_iter().map(OutputRows::finish).collect::<Result<_, _>>()?;
    write += start.elapsed();
    Ok(RenderedBands { outputs: finished, repairs, exposure, read, write })
}

/// Limits on rows in host memory, from `--memory`.
fn host_limits(request: &Request<'_>, inputs: &[InputRows<'_>], outputs: &[OutputRows<'_>]) -> HostLimits {
    let budget = request.args.images.budget().0;
    let streamed = inputs.iter().filter(|rows| rows.input.streamed.is_some());
    let decoded = streamed.map(|rows| rows.unit).max();
    let written = outputs.iter().filter_map(|output| Some(output.file.as_ref()?.1.block_rows()));
    HostLimits {
        bytes: if decoded.is_some() { budget.saturating_sub(DECODER) } else { budget },
        decoded: decoded.unwrap_or(0),
        written: written.max().unwrap_or(1),
    }
}

/// Notes the layers of the original that a streamed EXR does not keep.
fn note_left_out(request: &Request<'_>, job: &Job) -> Result<(), Failure> {
    if let Some(original) = original(request, job) {
        let notes = left_out(&original.source, "the file is written in bands, and they would have to be in memory")?;
        notes.iter().for_each(|text| note(&format!("note: {text}")));
    }
    Ok(())
}

/// The part of an output that is written, checked against its size.
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

/// The part of a whole picture that is written.
pub(super) fn part(request: &Request<'_>, texels: Texels) -> Result<Texels, Failure> {
    let Crop { corner: (x, y), size: (width, height) } = crop(request, texels.desc)?;
    let texel = texels.desc.format.bytes() as usize;
    let row = texel * texels.desc.size.width as usize;
    let columns = texel * x as usize..texel * (x + width) as usize;
    let rows = &texels.bytes[row * y as usize..row * (y + height) as usize];
    Ok(Texels { desc: texels.desc.sized(Size::new(width, height)), bytes: cut_columns(rows, row, &columns) })
}

/// A range of bytes of each row.
fn cut_columns(rows: &[u8], row: usize, columns: &Range<usize>) -> Vec<u8> {
    rows.chunks_exact(row).flat_map(|row| &row[columns.clone()]).copied().collect()
}

/// True if no frame of the request depends on those before.
pub(super) fn is_free(request: &Request<'_>, plan: &Plan) -> bool {
    let is_alone = request.jobs.len() == 1 && request.measured.is_empty();
    is_alone || plan.state().is_empty()
}

/// Refuses a frame of a sequence that depends on those before: their histories are not kept.
fn check_state(request: &Request<'_>, plan: &Plan) -> Result<(), Failure> {
    if is_free(request, plan) {
        return Ok(());
    }
    let names = names(&plan.state());
    Err(Failure::user(format!("frames that are rendered in bands leave no state for the next one: {names}"))
        .hint("render them whole, with more memory: `--gpu-memory SIZE`"))
}

/// Rows that keep all cores busy with blocks of few rows.
const MANY_ROWS: u32 = 256;

impl<'a> InputRows<'a> {
    fn new(input: &'a InputPicture) -> Self {
        let bytes = input.streamed.as_ref().map_or(0, |(_, options)| options.budget.0.saturating_sub(DECODER));
        let block = input.picture.meta.block_rows.unwrap_or(1).max(1);
        // Many blocks are decoded at a time, unless they would take much of the memory.
        let units = [MANY_ROWS.next_multiple_of(block), block];
        let is_small = |rows: &u32| u64::from(*rows).saturating_mul(8 * input.row() as u64) <= bytes;
        let unit = units.into_iter().find(is_small).unwrap_or(1);
        Self { input, decoded: Vec::new(), first: 0, unit, repairs: input.repairs, counted: 0 }
    }

    /// Decodes the missing ones of these rows, and drops those before `needed`.
    fn decode(
        &mut self,
        (source, options): &(Source, ReadOptions),
        rows: Range<u32>,
        needed: u32,
    ) -> Result<(), Failure> {
        let row = self.input.row();
        let end = self.first + (self.decoded.len() / row) as u32;
        if self.first <= rows.start && rows.end <= end {
            return Ok(());
        }
        let kept = (self.first..end).contains(&needed);
        self.decoded.drain(..if kept { (needed - self.first) as usize * row } else { self.decoded.len() });
        self.first = needed;
        let start = if kept { end } else { needed };
        let end = rows.end.next_multiple_of(self.unit).min(self.input.desc.size.height);
        let part = read_within(source, ReadOptions { rows: Some([start, end - start]), ..*options })?;
        if part.bytes().len() != row * (end - start) as usize {
            return Err(Failure::user(format!("{}: the file has changed", source.path.display())));
        }
        if end > self.counted {
            let new = self.counted.saturating_sub(start);
            self.repairs = self.repairs.and(Repairs::below(&part, new, self.input.signedness));
            self.counted = end;
        }
        self.decoded.reserve_exact(part.bytes().len());
        self.decoded.extend_from_slice(part.bytes());
        Ok(())
    }
}

impl BandReader for Inputs<'_> {
    type Error = Failure;

    fn read(&mut self, input: &str, rows: Range<u32>, needed: u32, texels: &mut Vec<u8>) -> Result<(), Failure> {
        let start = Instant::now();
        let input = self.inputs.iter_mut().find(|rows| rows.input.name == input).expect("the plan has its inputs");
        let row = input.input.row();
        texels.clear();
        texels.reserve_exact((rows.end - rows.start) as usize * row);
        match &input.input.streamed {
            None => {
                let bytes = input.input.picture.bytes();
                texels.extend_from_slice(&bytes[rows.start as usize * row..rows.end as usize * row]);
            }
            Some(streamed) => {
                self.pool.install(|| input.decode(streamed, rows.clone(), needed))?;
                let start = (rows.start - input.first) as usize * row;
                let length = (rows.end - rows.start) as usize * row;
                texels.extend_from_slice(&input.decoded[start..][..length]);
            }
        }
        self.busy += start.elapsed();
        Ok(())
    }
}

impl BandWriter for Outputs<'_> {
    type Error = Failure;

    fn write(&mut self, output: &str, rows: Range<u32>, texels: &mut Vec<u8>) -> Result<(), Failure> {
        let start = Instant::now();
        let to = self.outputs.iter_mut().find(|rows| rows.output.name == output);
        to.expect("the plan has the outputs of targets").write(rows, texels)?;
        self.busy += start.elapsed();
        Ok(())
    }
}

impl OutputRows<'_> {
    fn write(&mut self, rows: Range<u32>, texels: &mut Vec<u8>) -> Result<(), Failure> {
        let row = texels.len() / (rows.end - rows.start) as usize;
        let Crop { corner: (x, y), size: (width, height) } = self.crop;
        let (first, end) = (rows.start.max(y), rows.end.min(y + height));
        if first >= end {
            return Ok(());
        }
        texels.truncate((end - rows.start) as usize * row);
        texels.drain(..(first - rows.start) as usize * row);
        let texel = self.desc.format.bytes() as usize;
        let columns = texel * x as usize..texel * (x + width) as usize;
        if columns.len() < row {
            *texels = cut_columns(texels, row, &columns);
        }
        let Some((path, encoding, meta)) = &self.file else {
            if first == y {
                self.bytes.clear();
                self.bytes.reserve_exact(self.desc.bytes() as usize);
            }
            self.bytes.append(texels);
            return Ok(());
        };
        if first == y {
            let size = (self.desc.size.width, self.desc.size.height);
            let file = ImageFile::begin(path, size, encoding, meta.as_ref())?;
            file.notes().iter().for_each(|text| note(&format!("note: {text}")));
            self.open = Some(file);
        }
        let size = Size { height: end - first, ..self.desc.size };
        let part = Texels { desc: ImageDesc { size, ..self.desc }, bytes: mem::take(texels) };
        let file = self.open.as_mut().expect("the first row comes first");
        write_rows(file, &part)?;
        *texels = part.bytes;
        Ok(())
    }

    /// Ends the file. Returns the output, with its texels if they were not streamed.
    fn finish(self) -> Result<(PlanOutput, Option<Texels>), Failure> {
        let texels = match self.open {
            Some(file) => {
                file.finish()?;
                None
            }
            None => Some(Texels { desc: self.desc, bytes: self.bytes }),
        };
        Ok((self.output, texels))
    }
}
