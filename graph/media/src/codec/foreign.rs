//! Formats that are not read, and the ways in.

use std::path::Path;

/// A format that people bring and that is not read as an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignFormat {
    /// The name of the format with its article: `a WebP`.
    pub what: &'static str,
    /// The hint of a way to read such a file.
    pub way: &'static str,
    /// The endings of names, in lower case.
    endings: &'static [&'static str],
    /// Bytes, and where they are; several where a file has one of them.
    signatures: &'static [(usize, &'static [u8])],
}

/// Films are no images, but frames of them are.
const FILM: ForeignFormat = ForeignFormat {
    what: "a film",
    way: "`afterimage render PIPELINE IN.mov -o out.mov` reads a whole film, by `ffmpeg`; elsewhere take frames of it: \
          `ffmpeg -i IN.mov frame.%04d.png`",
    endings: &["mov", "mp4", "mkv", "m4v", "mxf", "webm", "avi", "mts", "m2ts", "wmv", "flv"],
    signatures: &[(4, b"ftyp"), (4, b"moov"), (0, b"\x1a\x45\xdf\xa3"), (8, b"AVI "), (0, b"\x06\x0e\x2b\x34")],
};

/// In the order in which contents are compared.
const ALL: [ForeignFormat; 10] = [
    ForeignFormat {
        what: "a raw file of a camera",
        way: "develop it to light first: `darktable-cli IN.raw OUT.exr`, or `rawtherapee-cli`",
        endings: &["raw", "dng", "cr2", "cr3", "nef", "arw", "raf", "rw2", "orf", "pef", "x3f"],
        signatures: &[
            (4, b"ftypcrx"),
            (8, b"CR\x02\0"),
            (0, b"FUJIFILMCCD-RAW"),
            (0, b"IIU\0"),
            (0, b"IIRO"),
            (0, b"FOVb"),
        ],
    },
    ForeignFormat {
        what: "an AVIF",
        way: "a program that was built with `--features avif` reads it; else convert it with its colors: \
              `avifdec --depth 16 IN.avif OUT.png`",
        endings: &["avif"],
        signatures: &[(4, b"ftypavif"), (4, b"ftypavis")],
    },
    ForeignFormat {
        what: "a HEIF",
        way: "convert it with its colors: `heif-dec IN.heic OUT.png`",
        endings: &["heic", "heif"],
        signatures: &[(4, b"ftyphei"), (4, b"ftypmif1"), (4, b"ftyphev")],
    },
    FILM,
    ForeignFormat {
        what: "a WebP",
        way: "convert it: `ffmpeg -i IN.webp OUT.png`",
        endings: &["webp"],
        signatures: &[(8, b"WEBP")],
    },
    ForeignFormat {
        what: "a JPEG XL",
        way: "a program that was built with `--features jxl` reads it; else convert it with all of its bits: \
              `djxl IN.jxl OUT.png`, or `OUT.exr` for light",
        endings: &["jxl"],
        signatures: &[(0, b"\xff\x0a"), (4, b"JXL ")],
    },
    ForeignFormat {
        what: "a Cineon file",
        way: "convert its codes: `oiiotool IN.cin -d uint10 -o OUT.dpx`",
        endings: &["cin"],
        signatures: &[(0, b"\x80\x2a\x5f\xd7")],
    },
    ForeignFormat {
        what: "a file of Photoshop",
        way: "export it as a PNG of 16 bits, or convert its flat picture: `magick 'IN.psd[0]' OUT.png`",
        endings: &["psd", "psb"],
        signatures: &[(0, b"8BPS")],
    },
    ForeignFormat {
        what: "a GIF",
        way: "convert its frames: `ffmpeg -i IN.gif frame.%04d.png`",
        endings: &["gif"],
        signatures: &[(0, b"GIF8")],
    },
    ForeignFormat {
        what: "a picture of 8 bits",
        way: "convert it: `magick IN OUT.png`",
        endings: &["bmp", "tga", "ppm", "pgm"],
        signatures: &[],
    },
];

/// True if a file that starts so has one of the signatures: bytes after so many others.
pub(super) fn is_signed(start: &[u8], signatures: &[(usize, &[u8])]) -> bool {
    signatures.iter().any(|(at, bytes)| start.get(*at..).is_some_and(|rest| rest.starts_with(bytes)))
}

impl ForeignFormat {
    /// The format by the first 16 bytes of a file.
    pub fn of_content(start: &[u8]) -> Option<Self> {
        ALL.into_iter().find(|format| is_signed(start, format.signatures))
    }

    /// The format by the ending of a name.
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let ending = path.as_ref().extension()?.to_string_lossy().to_ascii_lowercase();
        ALL.into_iter().find(|format| format.endings.contains(&&*ending))
    }

    /// The endings of names of all such files.
    pub(crate) fn all_endings() -> impl Iterator<Item = &'static str> {
        ALL.iter().flat_map(|format| format.endings).copied()
    }

    /// True for films.
    pub fn is_film(&self) -> bool {
        *self == FILM
    }
}
