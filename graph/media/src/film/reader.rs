//! Frames of a film as pictures.

use std::io::Read;
use std::process::ChildStdout;

use super::Film;
use super::ffmpeg::{FILES_ONLY, Process, named};
use crate::codec::limits::zeroed;
use crate::codec::{ColorSpace, Colors, ErrorKind, Picture, Pixels, ReadOptions};
use crate::files::FileError;

/// Decodes the frames of a film from the first one on.
pub struct FilmReader {
    film: Film,
    process: Process,
    frames: ChildStdout,
    next: usize,
    space: Option<ColorSpace>,
}

impl FilmReader {
    /// Starts the decoder. The space of `options` takes the place of what the film states.
    ///
    /// # Errors
    /// There is no `ffmpeg`, or a frame is larger than the budget.
    pub fn new(film: &Film, options: &ReadOptions) -> Result<Self, FileError> {
        let (width, height) = film.size;
        let frame = film.layout.frame_bytes(width as usize * height as usize) as u64;
        let checked = options.budget.check((width.into(), height.into()), 4, frame);
        checked.map_err(|error| FileError::at(&film.path, error))?;
        let range = if film.layout.is_narrow { "tv" } else { "pc" };
        // With one range there is no conversion but that of the size of planes.
        let filter = format!(
            "scale=in_range={range}:out_range={range}:flags=bicubic+accurate_rnd+full_chroma_int,format={}",
            film.layout.name()
        );
        let input = named(&film.path);
        let arguments: Vec<&std::ffi::OsStr> = vec![
            FILES_ONLY[0].as_ref(),
            FILES_ONLY[1].as_ref(),
            "-i".as_ref(),
            &input,
            "-map".as_ref(),
            "0:v:0".as_ref(),
            "-fps_mode".as_ref(),
            "passthrough".as_ref(),
            "-vf".as_ref(),
            filter.as_ref(),
            "-f".as_ref(),
            "rawvideo".as_ref(),
            "-".as_ref(),
        ];
        let mut process = Process::start(&film.path, &arguments)?;
        drop(process.child.stdin.take());
        let frames = process.child.stdout.take().expect("it is a pipe");
        Ok(Self { film: film.clone(), process, frames, next: 0, space: options.space })
    }

    /// The frame of this index, which is not before the last one that was read.
    ///
    /// # Errors
    /// The decoder fails, or has fewer frames than the film states.
    pub fn frame(&mut self, index: usize) -> Result<Picture, FileError> {
        let (width, height) = self.film.size;
        let bytes = self.film.layout.frame_bytes(width as usize * height as usize);
        let mut frame = zeroed(bytes).map_err(|error| FileError::at(&self.film.path, error))?;
        while self.next <= index {
            if self.frames.read_exact(&mut frame).is_err() {
                let count = self.next;
                self.process.finish()?;
                let what = format!("it has {count} frames that can be decoded, and frame {} is asked for", index + 1);
                return Err(FileError::new(&self.film.path, ErrorKind::Broken, what));
            }
            self.next += 1;
        }
        let (primaries, transfer) = self.space.map_or(self.film.color, |space| (space.primaries, space.transfer));
        let colors = Colors::new(Some((primaries, transfer)), None);
        let pixels = self.film.layout.signals(&frame, self.film.weights, |pixels| colors.decode(pixels));
        let notes = self.film.notes.clone();
        let notes = if self.space.is_some() {
            notes.into_iter().filter(|note| !note.contains("--input-space")).collect()
        } else {
            notes
        };
        Ok(Picture { stated: colors.stated, notes, ..Picture::new(width, height, Pixels::Float(pixels)) })
    }
}
