//! Pictures as a film.

use std::ffi::OsString;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ChildStdin;

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};

use super::Film;
use super::ffmpeg::{FILES_ONLY, Process, named, probe};
use super::matroska;
use super::preset::Preset;
use super::probe::{DISPLAY, count_frames};
use super::timecode;
use super::timeline::Timeline;
use crate::codec::cicp::Cicp;
use crate::codec::signals::{Layout, Weights};
use crate::codec::{CodecError, ErrorKind};
use crate::files::{AtomicFile, FileError};

/// The film whose sound and other data a new one has, and its first and its last frame there.
#[derive(Clone, Debug)]
pub struct Sound {
    film: PathBuf,
    aspect: Option<String>,
    /// The time code of the first frame.
    timecode: Option<String>,
    /// The seconds of the film where it begins and where it ends.
    span: (f64, f64),
    is_whole: bool,
}

impl Sound {
    /// That of the frames from `first` to `last`, by their indices.
    pub fn of(film: &Film, first: usize, last: usize) -> Self {
        let times = &film.times;
        let span = (times.seconds(first), times.seconds(last) + times.frame_seconds());
        let is_whole = first == 0 && last + 1 == times.frames();
        let (step, before) = (times.frame_seconds(), span.0 - times.seconds(0));
        let timecode = timecode::after(&film.timecode, (before / step).round() as u64, 1.0 / step);
        Self { film: film.path.clone(), aspect: film.aspect.clone(), timecode, span, is_whole }
    }

    /// True if some of it is not encoded.
    fn is_raw(&self) -> Result<bool, FileError> {
        let words = ["-select_streams", "a", "-show_entries", "stream=codec_name", "-of", "csv=p=0"];
        Ok(probe(&self.film, &words)?.lines().any(|codec| codec.starts_with("pcm_")))
    }
}

/// A film that is written frame by frame. It is at its place when it is [finished](Self::finish); dropped before, it
/// leaves nothing.
pub struct FilmWriter {
    path: PathBuf,
    file: AtomicFile,
    /// The file that the encoder writes, until it takes its place.
    temporary: PathBuf,
    process: Process,
    frames: BufWriter<ChildStdin>,
    layout: Layout,
    weights: Weights,
    times: Timeline,
    pixels: usize,
    /// The number of frames that are written.
    count: usize,
}

impl FilmWriter {
    /// Starts the encoder of frames with these times. `more` are further options of `ffmpeg`. Returns the film, and
    /// sentences about what is changed of the sound.
    ///
    /// # Errors
    /// No film can have these colors, there is no `ffmpeg`, or the file cannot be written.
    pub fn create(
        path: &Path,
        size: (u32, u32),
        color: &Colorimetry,
        (preset, more): (Preset, &[String]),
        times: Timeline,
        sound: Option<&Sound>,
    ) -> Result<(Self, Vec<String>), FileError> {
        preset.check_size(path, size, more)?;
        let tags = Tags::of(color).map_err(|error| FileError::at(path, error))?;
        let (file, temporary) = AtomicFile::for_program(path)?;
        let mut words = Vec::new();
        let mut add = |all: &[&str]| words.extend(all.iter().map(OsString::from));
        // A film that begins with a part keeps the distance of its sound.
        let delay = sound.filter(|sound| sound.is_whole).map_or(0.0, |sound| sound.span.0);
        add(&["-itsoffset", &format!("{delay:.6}"), "-f", "matroska", "-i", "pipe:0"]);
        if let Some(sound) = sound {
            if !sound.is_whole {
                let (from, to) = sound.span;
                add(&["-ss", &format!("{from:.6}"), "-t", &format!("{:.6}", to - from)]);
            }
            add(&FILES_ONLY);
            add(&["-i"]);
            words.push(named(&sound.film));
        }
        let mut add = |all: &[&str]| words.extend(all.iter().map(OsString::from));
        add(&["-map", "0:v:0"]);
        let mut notes = Vec::new();
        if let Some(sound) = sound {
            add(&["-map", "1:a?", "-map_metadata", "1"]);
            if let Some(timecode) = &sound.timecode {
                add(&["-timecode", timecode]);
            }
            add(&["-c:a"]);
            if preset.container(path) == "mp4" && sound.is_raw()? {
                add(&["aac", "-b:a", "320k"]);
                notes.push("the sound is encoded as AAC: players take no PCM in a .mp4; .mov and .mkv keep it".into());
            } else {
                add(&["copy"]);
            }
        }
        let range = if preset.layout().is_narrow { "tv" } else { "pc" };
        let aspect = sound.and_then(|sound| sound.aspect.clone());
        let aspect = aspect.map_or_else(String::new, |aspect| format!("setsar={aspect},"));
        let Tags { primaries, transfer, matrix } = tags;
        let matrix = if preset.layout().is_rgb { 0 } else { matrix };
        add(&[
            "-vf",
            &format!(
                "setparams=range={range}:color_primaries={primaries}:color_trc={transfer}:colorspace={matrix},{aspect}\
             scale=in_range={range}:out_range={range}:flags=bicubic+accurate_rnd+full_chroma_int,format={}",
                preset.samples
            ),
        ]);
        let [primaries, transfer, matrix] = [primaries, transfer, matrix].map(|code| code.to_string());
        add(&["-color_range", range, "-color_primaries", &primaries, "-color_trc", &transfer, "-colorspace", &matrix]);
        let second = times.tick.1.to_string();
        add(&["-fps_mode", "passthrough", "-enc_time_base", &format!("{}/{second}", times.tick.0)]);
        add(&["-video_track_timescale", &second]);
        add(&preset.options(path));
        add(&more.iter().map(String::as_str).collect::<Vec<_>>());
        words.push(named(&temporary));
        let mut process = Process::start(path, &words)?;
        let input = process.child.stdin.take().expect("it is a pipe");
        let layout = preset.layout();
        let mut frames = BufWriter::new(input);
        let usual = (times.frame_seconds() * 1e9).round() as u64;
        if matroska::begin(&mut frames, size, layout.code(), usual).is_err() {
            return Err(process.failure());
        }
        let pixels = size.0 as usize * size.1 as usize;
        let (path, weights) = (path.into(), tags.weights());
        Ok((Self { path, file, temporary, process, frames, layout, weights, times, pixels, count: 0 }, notes))
    }

    /// Writes the next frame, that of this index of the times. Its signals are those of the colors of the film.
    ///
    /// # Errors
    /// The encoder fails, or the frame has another size than the first one.
    ///
    /// # Panics
    /// If there is no time of this index.
    pub fn write(&mut self, index: usize, signals: &[[f32; 4]]) -> Result<(), FileError> {
        if signals.len() != self.pixels {
            return Err(FileError::new(&self.path, ErrorKind::Unsupported, "the frames of a film have one size")
                .hint("`--resize fit` scales images of another size"));
        }
        let time = self.times.nanoseconds(index, 0);
        let frame = self.layout.frame(signals, self.weights);
        if matroska::frame(&mut self.frames, time, &frame).is_err() {
            return Err(self.process.failure());
        }
        self.count += 1;
        Ok(())
    }

    /// Ends the film, and puts it at its place if it has all frames.
    ///
    /// # Errors
    /// The encoder fails, the film cannot be read again, or the file cannot be replaced: the file that was there stays.
    pub fn finish(self) -> Result<(), FileError> {
        let Self { path, mut process, frames, file, temporary, count, .. } = self;
        match frames.into_inner() {
            Ok(input) => drop(input),
            Err(_) => return Err(process.failure()),
        }
        process.finish()?;
        let unreadable = |what| FileError::new(&path, ErrorKind::Machine, format!("the film was written, but {what}"));
        match count_frames(&temporary) {
            Ok(found) if found == count => file.finish(),
            Ok(found) => Err(unreadable(format!("has {found} of {count} frames"))
                .hint("leave options of `--video` out that drop frames, or choose another codec")),
            Err(error) => Err(unreadable(format!("cannot be read again: {}", error.message))),
        }
    }
}

/// The codes of H.273 that a film has.
struct Tags {
    primaries: u8,
    transfer: u8,
    matrix: u8,
}

impl Tags {
    fn of(color: &Colorimetry) -> Result<Self, CodecError> {
        let of_display = color.transfer == DISPLAY;
        let transfer = if of_display { Transfer::Srgb } else { color.transfer };
        let unknown = || {
            CodecError::new(ErrorKind::Unsupported, "no film has the colors of this output").hint(
                "`Encode` makes others: `transfer: Gamma, gamma: 2.4` or `Srgb`, and `Pq` or `Hlg` with `primaries: \
                 Rec2020`",
            )
        };
        let code = Cicp::of(&color.primaries, transfer).ok_or_else(unknown)?;
        if transfer == Transfer::Linear || transfer == Transfer::Gamma(Decimal::new(2.8)) {
            return Err(unknown());
        }
        let is_wide = color.primaries == Chromaticities::REC2020;
        let transfer = match (of_display, is_wide) {
            (true, true) => 14,
            (true, false) => 1,
            (false, _) => code.transfer,
        };
        Ok(Self { primaries: code.primaries, transfer, matrix: if is_wide { 9 } else { 1 } })
    }

    fn weights(&self) -> Weights {
        if self.matrix == 9 { Weights::BT2020 } else { Weights::BT709 }
    }
}
