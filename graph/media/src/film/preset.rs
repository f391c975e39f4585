//! The ways in which films are encoded.

use std::path::Path;

use crate::codec::ErrorKind;
use crate::codec::signals::Layout;
use crate::files::FileError;

/// A container and a codec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The name on the command line.
    pub name: &'static str,
    /// Bits of a sample.
    pub bits: u32,
    /// The endings of its files; the first is the one that chooses it.
    endings: &'static [&'static str],
    /// The format of its samples, for `ffmpeg`.
    pub(super) samples: &'static str,
    /// True for RGB, false for luma and color differences.
    is_rgb: bool,
    options: &'static [&'static str],
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self {
            name: "prores",
            bits: 10,
            endings: &["mov"],
            samples: "yuv422p10le",
            is_rgb: false,
            options: &["-c:v", "prores_ks", "-profile:v", "hq", "-vendor", "apl0"],
        },
        Self {
            name: "prores4444",
            bits: 10,
            endings: &["mov"],
            samples: "yuv444p10le",
            is_rgb: false,
            options: &["-c:v", "prores_ks", "-profile:v", "4444", "-vendor", "apl0"],
        },
        Self {
            name: "h264",
            bits: 10,
            endings: &["mp4", "mov", "m4v", "mkv"],
            samples: "yuv420p10le",
            is_rgb: false,
            options: &["-c:v", "libx264", "-crf", "14"],
        },
        Self {
            name: "hevc",
            bits: 10,
            endings: &["mp4", "mov", "m4v", "mkv"],
            samples: "yuv420p10le",
            is_rgb: false,
            options: &["-c:v", "libx265", "-crf", "14", "-x265-params", "log-level=error"],
        },
        Self {
            name: "ffv1",
            bits: 16,
            endings: &["mkv"],
            samples: "gbrp16le",
            is_rgb: true,
            options: &["-c:v", "ffv1", "-level", "3"],
        },
    ];

    /// The preset of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name == name)
    }

    /// The preset of a file by its ending; `hevc` for HDR in `.mp4`.
    pub fn of_file(file: &Path, is_hdr: bool) -> Option<Self> {
        let ending = ending(file);
        let is_first = |preset: &Self| preset.endings[0] == ending && !(is_hdr && preset.name == "h264");
        Self::ALL.into_iter().find(is_first).or_else(|| Self::ALL.into_iter().find(|preset| preset.suits(file)))
    }

    /// True if its films can have this ending.
    pub fn suits(&self, file: &Path) -> bool {
        self.endings.contains(&&*ending(file))
    }

    /// The endings of its files.
    pub fn endings(&self) -> &'static [&'static str] {
        self.endings
    }

    /// Refuses frames of a size that a codec with one color for two by two pixels does not take. `more` are further
    /// options of `ffmpeg`.
    ///
    /// # Errors
    /// A side is odd.
    pub fn check_size(&self, path: &Path, (width, height): (u32, u32), more: &[String]) -> Result<(), FileError> {
        let of_samples = ["-pix_fmt", "-vf", "-filter", "-c:", "-codec", "-vcodec"];
        let may_be_others = more.iter().any(|word| of_samples.iter().any(|option| word.starts_with(option)));
        let is_even = width.is_multiple_of(2) && height.is_multiple_of(2);
        if !self.samples.contains("420") || is_even || may_be_others {
            return Ok(());
        }
        let (name, even) = (self.name, format!("{}x{}", width & !1, height & !1));
        Err(FileError::new(
            path,
            ErrorKind::Unsupported,
            format!("{name} has even sides, and frames are {width}x{height}"),
        )
        .hint(format!("`--crop 0,0,{even}` leaves a column or a row out; a `.mov` of `--video prores` has any size")))
    }

    pub(super) fn layout(&self) -> Layout {
        Layout { bits: self.bits, is_rgb: self.is_rgb, is_narrow: !self.is_rgb }
    }

    /// The container of a file, as `ffmpeg` calls it.
    pub(super) fn container(&self, file: &Path) -> &'static str {
        match &*ending(file) {
            "mkv" => "matroska",
            "mov" => "mov",
            _ => "mp4",
        }
    }

    /// The options of `ffmpeg` for a file.
    pub(super) fn options(&self, file: &Path) -> Vec<&'static str> {
        let mut options = self.options.to_vec();
        let container = self.container(file);
        if self.name == "hevc" && container != "matroska" {
            // The name that players of Apple ask for.
            options.extend(["-tag:v", "hvc1"]);
        }
        options.extend(["-f", container]);
        options
    }
}

fn ending(file: &Path) -> String {
    file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
