//! Names of inputs and outputs: `shot.####.exr#diffuse` and `--frames 1-96x2` become the files
//! of the frames.
//!
//! A placeholder is a run of `#`, one for each digit, or `%04d` as printf has it. It stands in the
//! name of the file, not of a folder. What follows `.exr#` is a layer, so `shot.####.exr#diffuse`
//! has both. A file whose own name holds a `#` is taken as it is if it exists.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::regular;
use crate::codec::{ErrorKind, ForeignFormat, ImageFormat};
use crate::{FileError, Source};

/// The most digits of a frame's number. File systems have no longer names.
const MAX_DIGITS: usize = 255;

/// The most frames of a sequence.
const MOST_FRAMES: u32 = 1_000_000;

/// The files of an input argument.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// One image.
    Single(Source),
    /// Numbered images, ascending or as `--frames` lists them; all of them exist.
    Sequence(Vec<(u32, Source)>),
}

/// The file that stands for a frame that is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StandIn {
    /// That of the last frame before it.
    Before,
    /// The same, or that of the first frame that there is: its size is what counts.
    Any,
}

impl StandIn {
    fn of(self, there: &BTreeSet<u32>, frame: u32) -> Option<u32> {
        let before = there.range(..=frame).next_back();
        let first = there.first().filter(|_| self == Self::Any);
        before.or(first).copied()
    }
}

/// The files of frames, with their numbers.
type NumberedSources = Vec<(u32, Source)>;

impl Input {
    /// Finds the files of `name`. `frames` is the argument of `--frames`: `1-96`, `1-96x2`,
    /// `7`, or several of these with commas; without it, the folder is searched.
    ///
    /// A frame that is missing, also between the first and last found, is an error that names it.
    pub fn find(name: &str, frames: Option<&str>) -> Result<Self, FileError> {
        let FrameFiles { pattern, file, layer, .. } = FrameFiles::new(name)?;
        match (pattern, frames) {
            (Some(pattern), _) => pattern.find_all(frames, layer).map(Self::Sequence),
            (None, None) => Ok(Self::Single(Source { path: file, layer })),
            (None, Some(_)) => Err(FileError::new(&file, ErrorKind::Naming, "`--frames` needs a numbered input")
                .hint("put a placeholder into the name, for example `shot.####.exr`")),
        }
    }

    /// As [`Input::find`], but another file stands for a frame that is missing. Returns those frames, too.
    ///
    /// # Errors
    /// As [`Input::find`]; a frame for which no file can stand is missing.
    pub fn find_filled(
        name: &str,
        frames: Option<&str>,
        stand_in: StandIn,
    ) -> Result<(Self, BTreeSet<u32>), FileError> {
        let FrameFiles { pattern, layer, .. } = FrameFiles::new(name)?;
        match pattern {
            None => Ok((Self::find(name, frames)?, BTreeSet::new())),
            Some(pattern) => {
                let (frames, missing) = pattern.fill_all(frames, layer.as_ref(), stand_in)?;
                Ok((Self::Sequence(frames), missing))
            }
        }
    }

    /// Frame numbers and sources; a single image has no number.
    pub fn sources(&self) -> Vec<(Option<u32>, Source)> {
        match self {
            Self::Single(source) => vec![(None, source.clone())],
            Self::Sequence(frames) => frames.iter().map(|(frame, source)| (Some(*frame), source.clone())).collect(),
        }
    }

    /// The output of each source, in the order of [`Input::sources`]. A sequence of several frames needs a placeholder
    /// in `output`, a single image must have none.
    pub fn outputs(&self, output: &str) -> Result<Vec<PathBuf>, FileError> {
        match (self, Pattern::parse(output)?) {
            (Self::Single(_), None) => Ok(vec![output.into()]),
            (Self::Sequence(frames), None) if frames.len() == 1 => Ok(vec![output.into()]),
            (Self::Sequence(frames), Some(pattern)) => Ok(frames.iter().map(|(frame, _)| pattern.at(*frame)).collect()),
            (Self::Sequence(frames), None) => {
                let message = format!("{} frames cannot go into one file", frames.len());
                let hint = format!("number the output, for example `{}`", numbered(output));
                Err(naming(output, message).hint(hint))
            }
            (Self::Single(_), Some(_)) => {
                Err(naming(output, "the output is numbered, but the input is a single image")
                    .hint("leave the placeholder out, or give a sequence as input"))
            }
        }
    }
}

/// The files that look like frames of a sequence, but whose numbers its pattern would not write so: with other digits,
/// a sign, more than 32 bits, or the letters of the name in another case. They are no frames of it.
pub fn other_numbers(name: &str) -> Vec<String> {
    let pattern = FrameFiles::new(name).ok().and_then(|files| files.pattern);
    pattern.map_or_else(Vec::new, |pattern| pattern.other_numbers())
}

/// Finds the files of single frames of an input argument. The folder is read once, so that a sequence takes time in
/// proportion to its frames.
#[derive(Debug)]
pub struct FrameFiles {
    /// `None` for one image, which is that of all frames.
    pattern: Option<Pattern>,
    file: PathBuf,
    layer: Option<String>,
    there: OnceLock<BTreeSet<u32>>,
}

impl FrameFiles {
    /// The files of `name`, which is written as for [`Input::find`].
    ///
    /// # Errors
    /// The name has a placeholder in the wrong place.
    pub fn new(name: &str) -> Result<Self, FileError> {
        let (file, layer) = split_layer(name);
        let pattern = if Path::new(file).is_file() { None } else { Pattern::parse(file)? };
        Ok(Self { pattern, file: file.into(), layer, there: OnceLock::new() })
    }

    /// The file of a frame; `None` if there is none.
    pub fn find(&self, frame: u32) -> Option<Source> {
        let path = self.pattern.as_ref().map_or(self.file.clone(), |pattern| pattern.at(frame));
        regular::check(&path).is_ok().then(|| self.source(path))
    }

    /// The file of a frame, or that which stands for it, and whether it is its own. `None` if no file can.
    pub fn find_filled(&self, frame: u32, stand_in: StandIn) -> Option<(Source, bool)> {
        let Some(pattern) = &self.pattern else { return Some((self.source(self.file.clone()), true)) };
        let found = stand_in.of(self.there(pattern), frame)?;
        Some((self.source(pattern.at(found)), found == frame))
    }

    /// True if a sequence has a frame of this number, or some before and after it.
    pub fn spans(&self, frame: u32) -> bool {
        let there = self.pattern.as_ref().map(|pattern| self.there(pattern));
        there.and_then(|there| Some(there.first()?..=there.last()?)).is_some_and(|range| range.contains(&&frame))
    }

    fn there(&self, pattern: &Pattern) -> &BTreeSet<u32> {
        self.there.get_or_init(|| pattern.frames().unwrap_or_default().into_iter().collect())
    }

    fn source(&self, path: PathBuf) -> Source {
        Source { path, layer: self.layer.clone() }
    }
}

/// True if a name is that of a sequence: it has a placeholder, and no file has the name itself.
pub fn is_numbered(name: &str) -> bool {
    FrameFiles::new(name).is_ok_and(|files| files.pattern.is_some())
}

/// A file name with a place for the frame number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    /// Digits at least; shorter numbers are filled with zeros.
    digits: usize,
    after: String,
}

impl Pattern {
    /// `None` where `name` holds no placeholder; an error where it holds several, or one in the
    /// name of a folder.
    pub fn parse(name: &str) -> Result<Option<Self>, FileError> {
        let folder_length = name.rfind(std::path::is_separator).map_or(0, |at| at + 1);
        let (folder, file) = name.split_at(folder_length);
        if placeholder(folder).is_some_and(|found| found.is_certain) && !Path::new(folder).is_dir() {
            return Err(
                naming(name, "a folder cannot be numbered").hint("put the placeholder into the name of the file")
            );
        }
        let Some(found) = placeholder(file) else { return Ok(None) };
        if ForeignFormat::of_name(file).is_some_and(|format| format.is_film()) {
            return Err(naming(name, "a film has all of its frames in one file").hint("leave the placeholder out"));
        }
        let (before, after) = (&file[..found.start], &file[found.end..]);
        if placeholder(after).is_some() {
            return Err(
                naming(name, "the name has more than one placeholder").hint("keep one run of `#`, or one `%04d`")
            );
        }
        if found.digits > MAX_DIGITS {
            let message = format!("the placeholder has {} digits, and at most {MAX_DIGITS} are written", found.digits);
            return Err(naming(&shortened(name), message).hint("`####` is for numbers up to 9999"));
        }
        let (before, after) = (before.to_owned(), after.to_owned());
        Ok(Some(Self { folder: folder.into(), before, digits: found.digits, after }))
    }

    /// The file of a frame.
    pub fn at(&self, frame: u32) -> PathBuf {
        let Self { before, digits, after, .. } = self;
        self.folder.join(format!("{before}{frame:0digits$}{after}"))
    }

    fn find_all(&self, frames: Option<&str>, layer: Option<String>) -> Result<NumberedSources, FileError> {
        let wanted = match frames {
            Some(text) => parse_frames("--frames", text)?,
            None => self.discover()?,
        };
        let source = |frame| Source { path: self.at(frame), layer: layer.clone() };
        let found: Vec<_> = wanted.into_iter().map(|frame| (frame, source(frame))).collect();
        for (frame, source) in &found {
            match regular::check(&source.path) {
                Err(error) if error.kind == ErrorKind::Missing => {
                    return Err(missing(&source.path, *frame).hint("render it, or choose other frames with `--frames`"));
                }
                checked => checked?,
            }
        }
        Ok(found)
    }

    /// The wanted frames, or all from the first to the last, and those of them that are missing.
    fn fill_all(
        &self,
        frames: Option<&str>,
        layer: Option<&String>,
        stand_in: StandIn,
    ) -> Result<(NumberedSources, BTreeSet<u32>), FileError> {
        let there: BTreeSet<u32> = self.frames()?.into_iter().collect();
        let (first, last) = (there.first().copied().unwrap_or(0), there.last().copied().unwrap_or(0));
        let wanted = match frames {
            Some(text) => parse_frames("--frames", text)?,
            None if last - first >= MOST_FRAMES => return Err(self.too_long(first, last)),
            None => (first..=last).collect(),
        };
        let mut found = Vec::new();
        for &frame in &wanted {
            let Some(other) = stand_in.of(&there, frame) else {
                return Err(missing(&self.at(frame), frame)
                    .hint("no frame before it can take its place; `--missing black` puts black there"));
            };
            found.push((frame, Source { path: self.at(other), layer: layer.cloned() }));
        }
        Ok((found, wanted.into_iter().filter(|frame| !there.contains(frame)).collect()))
    }

    /// Every frame on disk, ascending, without a gap.
    fn discover(&self) -> Result<Vec<u32>, FileError> {
        let frames = self.frames()?;
        match frames.windows(2).find(|pair| pair[1] != pair[0] + 1) {
            None => Ok(frames),
            Some(pair) => Err(self.gap(&frames, pair[0] + 1)),
        }
    }

    /// Every frame on disk, ascending; an error if there is none.
    pub fn frames(&self) -> Result<Vec<u32>, FileError> {
        let frames: BTreeSet<u32> = self.names()?.filter_map(|name| self.frame_of(&name)).collect();
        if frames.is_empty() {
            let pattern = self.folder.join(self.shown());
            let others = self.other_numbers();
            let hint = match others.first() {
                Some(other) => format!("`{other}` is there: a `#` stands for each digit of a number"),
                None => "check the folder, and that there is a `#` for each digit".to_owned(),
            };
            return Err(FileError::new(&pattern, ErrorKind::Missing, "no file fits this pattern").hint(hint));
        }
        Ok(frames.into_iter().collect())
    }

    /// The names of the files in the folder.
    fn names(&self) -> Result<impl Iterator<Item = String> + use<>, FileError> {
        let folder = if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder };
        let entries = fs::read_dir(folder).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => FileError::new(folder, ErrorKind::Missing, "there is no such folder"),
            _ => FileError::reading(folder, &error),
        })?;
        Ok(entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()))
    }

    /// The names in the folder with a number in the place of the placeholder, which are no frames.
    fn other_numbers(&self) -> Vec<String> {
        let is_other = |name: &String| self.number_of(name).is_some() && self.frame_of(name).is_none();
        // A folder that cannot be listed is reported by who needs its files.
        let mut others: Vec<String> = self.names().into_iter().flatten().filter(is_other).collect();
        others.sort();
        others
    }

    /// The number in a name that is that of the pattern in any case: digits, which may have a sign.
    fn number_of(&self, name: &str) -> Option<String> {
        let [name, before, after] = [name, &self.before, &self.after].map(str::to_lowercase);
        let number = name.strip_prefix(&before)?.strip_suffix(&after)?;
        let digits = number.strip_prefix(['-', '+']).unwrap_or(number);
        let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| number.to_owned())
    }

    fn too_long(&self, first: u32, last: u32) -> FileError {
        let pattern = self.folder.join(self.shown());
        let message =
            format!("frames {first} to {last} are on disk, and from one to the other are more than {MOST_FRAMES}");
        FileError::new(&pattern, ErrorKind::TooLarge, message).hint("choose some of them with `--frames`")
    }

    fn gap(&self, frames: &[u32], first_missing: u32) -> FileError {
        let (first, last) = (frames[0], frames[frames.len() - 1]);
        let step = frames[1] - first;
        let is_even = frames.windows(2).all(|pair| pair[1] - pair[0] == step);
        let others = self.other_numbers();
        let is_missing =
            |name: &&String| self.number_of(name).is_some_and(|number| number.parse() == Ok(first_missing));
        let other = others.iter().find(is_missing);
        let hint = if let Some(other) = other {
            format!("`{other}` is there, and this pattern writes numbers in another way: rename it")
        } else if is_even {
            format!("to take every frame that is there, add `--frames {first}-{last}x{step}`")
        } else {
            format!("render it, or choose others, for example `--frames {first}-{}`", first_missing - 1)
        };
        missing(&self.at(first_missing), first_missing).hint(hint)
    }

    /// The number in `name` if this pattern would write exactly that name for it.
    fn frame_of(&self, name: &str) -> Option<u32> {
        let digits = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let frame: u32 = digits.parse().ok()?;
        let digits_only = digits.bytes().all(|byte| byte.is_ascii_digit());
        let width = self.digits;
        (digits_only && digits == format!("{frame:0width$}")).then_some(frame)
    }

    fn shown(&self) -> String {
        format!("{}{}{}", self.before, "#".repeat(self.digits), self.after)
    }
}

struct Placeholder {
    start: usize,
    end: usize,
    digits: usize,
    /// True if it can hardly be a part of an ordinary name: `%04d`, or `##` and longer.
    is_certain: bool,
}

/// The first run of `#`, or the first `%d`, `%4d` or `%04d`.
fn placeholder(text: &str) -> Option<Placeholder> {
    let hashes = text.find('#').map(|start| {
        let digits = text[start..].bytes().take_while(|byte| *byte == b'#').count();
        Placeholder { start, end: start + digits, digits, is_certain: digits > 1 }
    });
    let printf = text.match_indices('%').find_map(|(start, _)| {
        let width: String = text[start + 1..].chars().take_while(char::is_ascii_digit).take(3).collect();
        let end = start + 1 + width.len();
        let digits = if width.is_empty() { 1 } else { width.parse().ok()? };
        text[end..].starts_with('d').then_some(Placeholder { start, end: end + 1, digits, is_certain: true })
    });
    [hashes, printf].into_iter().flatten().min_by_key(|found| found.start)
}

/// Splits `shot.exr#diffuse.R` into the file and the layer. Formats without layers are split as
/// well, so that reading them can say so.
pub fn split_layer(name: &str) -> (&str, Option<String>) {
    if Path::new(name).is_file() {
        return (name, None);
    }
    let lower = name.to_ascii_lowercase();
    // A layer of a file that is not read is an error about that file.
    let readable = ImageFormat::readable().flat_map(ImageFormat::endings).copied();
    let ends = readable.chain(ForeignFormat::all_endings()).map(|ending| format!(".{ending}#"));
    match ends.filter_map(|end| Some(lower.rfind(&end)? + end.len())).max() {
        Some(at) if at < name.len() && !name[at..].starts_with('#') => (&name[..at - 1], Some(name[at..].to_owned())),
        _ => (name, None),
    }
}

/// The frames of `1-96`, `1-96x2` (or `1-96:2`), `7`, or several of these with commas, as listed. `option` is the
/// option that has the text, for errors.
pub fn parse_frames(option: &str, text: &str) -> Result<Vec<u32>, FileError> {
    let mut frames = Vec::new();
    for range in text.split(',') {
        let (first, last, step) = parse_range(range.trim())
            .ok_or_else(|| naming_frames(option, text, format!("`{}` is not a range", range.trim())))?;
        if last < first {
            let message = format!("`{first}-{last}` runs backwards");
            return Err(naming_frames(option, text, message).hint(format!("write `{last}-{first}`")));
        }
        if step == 0 {
            return Err(naming_frames(option, text, "a step of 0 never ends".to_owned()));
        }
        frames.extend((first..=last).step_by(step as usize).take(MOST_FRAMES as usize + 1));
        if frames.len() > MOST_FRAMES as usize {
            return Err(naming_frames(option, text, format!("these are more than {MOST_FRAMES} frames")));
        }
    }
    match first_repeated(&frames) {
        None => Ok(frames),
        Some(frame) => Err(naming_frames(option, text, format!("frame {frame} is named twice"))),
    }
}

fn parse_range(range: &str) -> Option<(u32, u32, u32)> {
    let (span, step) = match range.split_once(['x', ':']) {
        Some((span, step)) => (span, number(step)?),
        None => (range, 1),
    };
    let (first, last) = span.split_once('-').unwrap_or((span, span));
    Some((number(first)?, number(last)?, step))
}

fn number(text: &str) -> Option<u32> {
    let is_plain = text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| is_plain)
}

fn first_repeated(frames: &[u32]) -> Option<u32> {
    let mut seen = BTreeSet::new();
    frames.iter().copied().find(|frame| !seen.insert(*frame))
}

fn naming_frames(option: &str, text: &str, message: String) -> FileError {
    naming(&format!("{option} {text}"), message)
        .hint("write `1-96`, `1-96x2` for every second one, `7`, or several of these with commas")
}

fn naming(name: &str, message: impl Into<String>) -> FileError {
    FileError::new(Path::new(name), ErrorKind::Naming, message)
}

fn missing(path: &Path, frame: u32) -> FileError {
    FileError::new(path, ErrorKind::Missing, format!("frame {frame} is missing"))
}

/// The beginning of a long name.
fn shortened(name: &str) -> String {
    name.chars().take(60).chain(['.', '.', '.']).collect()
}

/// `out.png` as `out.####.png`.
fn numbered(output: &str) -> String {
    match output.rsplit_once('.') {
        Some((stem, extension)) if !extension.contains(std::path::is_separator) => {
            format!("{stem}.####.{extension}")
        }
        _ => format!("{output}.####"),
    }
}
