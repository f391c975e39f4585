//! The formats of image files: endings of names, signatures of contents, and the depths that can be written.

use std::io::{BufRead, Read as _, Seek};
use std::path::Path;

use crate::codec::foreign::is_signed;
use crate::codec::{CodecError, ErrorKind, ForeignFormat};

/// Declares an enum with an array of its values.
macro_rules! listed {
    ($(#[$attribute:meta])* pub enum $name:ident { $($(#[$doc:meta])* $value:ident,)+ }) => {
        $(#[$attribute])*
        pub enum $name { $($(#[$doc])* $value,)+ }

        impl $name {
            /// All values, in the order of their declaration.
            pub const ALL: [Self; [$(Self::$value),+].len()] = [$(Self::$value),+];
        }
    };
}
pub(super) use listed;

listed! {
    /// A format of image files.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ImageFormat {
        /// OpenEXR: linear color, or data.
        Exr,
        /// Radiance: linear color. Such files are read, and not written.
        Hdr,
        /// PNG: codes of a transfer function.
        Png,
        /// JPEG: codes of a transfer function.
        Jpeg,
        /// TIFF: codes of a transfer function, or linear color in floats.
        Tiff,
        /// DPX: codes of film, of a transfer function, or linear ones. Such files are read, and not written.
        Dpx,
        /// JPEG XL: codes of a transfer function, or linear ones. Such files are read with the feature `jxl`, and not
        /// written.
        Jxl,
        /// AVIF: codes of a transfer function. Such files are read with the feature `avif`, and not written.
        Avif,
    }
}

/// Properties of a format that all its files have.
struct Properties {
    name: &'static str,
    endings: &'static [&'static str],
    /// Bytes at the start of a file, after so many others.
    signatures: &'static [(usize, &'static [u8])],
    depths: &'static [u32],
    is_encoded: bool,
    is_readable: bool,
}

impl ImageFormat {
    fn properties(self) -> Properties {
        /// A format of codes that is read and not written.
        const READ: Properties =
            Properties { name: "", endings: &[], signatures: &[], depths: &[], is_encoded: true, is_readable: true };
        match self {
            Self::Exr => Properties {
                name: "EXR",
                endings: &["exr", "sxr", "mxr"],
                signatures: &[(0, b"\x76\x2f\x31\x01")],
                depths: &[16, 32],
                is_encoded: false,
                ..READ
            },
            Self::Hdr => Properties {
                name: "Radiance HDR",
                endings: &["hdr"],
                signatures: &[(0, b"#?RADIANCE"), (0, b"#?RGBE")],
                is_encoded: false,
                ..READ
            },
            Self::Png => Properties {
                name: "PNG",
                endings: &["png"],
                signatures: &[(0, b"\x89PNG\r\n\x1a\n")],
                depths: &[8, 16],
                ..READ
            },
            Self::Jpeg => Properties {
                name: "JPEG",
                endings: &["jpg", "jpeg"],
                signatures: &[(0, b"\xff\xd8\xff")],
                depths: &[8],
                ..READ
            },
            Self::Tiff => Properties {
                name: "TIFF",
                endings: &["tif", "tiff"],
                signatures: &[(0, b"II*\0"), (0, b"MM\0*"), (0, b"II+\0"), (0, b"MM\0+")],
                depths: &[8, 16, 32],
                ..READ
            },
            Self::Dpx => {
                Properties { name: "DPX", endings: &["dpx"], signatures: &[(0, b"SDPX"), (0, b"XPDS")], ..READ }
            }
            Self::Jxl => Properties {
                name: "JPEG XL",
                endings: &["jxl"],
                signatures: &[(0, b"\xff\x0a"), (0, b"\0\0\0\x0cJXL \r\n\x87\n")],
                is_readable: cfg!(feature = "jxl"),
                ..READ
            },
            Self::Avif => Properties {
                name: "AVIF",
                endings: &["avif"],
                signatures: &[(4, b"ftypavif"), (4, b"ftypavis")],
                is_readable: cfg!(feature = "avif"),
                ..READ
            },
        }
    }

    /// The formats that this program reads.
    pub fn readable() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|format| format.properties().is_readable)
    }

    /// The names of the formats that this program reads, as a list in a sentence.
    pub fn readable_names() -> String {
        let names: Vec<&str> = Self::readable().map(Self::name).collect();
        let (last, others) = names.split_last().expect("there are formats");
        format!("{} and {last}", others.join(", "))
    }

    /// The endings of file names, in lower case; the usual one first.
    pub fn endings(self) -> &'static [&'static str] {
        self.properties().endings
    }

    /// The name for users.
    pub fn name(self) -> &'static str {
        self.properties().name
    }

    /// The bits of a channel that can be written, in codes or, for EXR and the 32 of TIFF, in floats; none for a format
    /// that is read only.
    pub fn depths(self) -> &'static [u32] {
        self.properties().depths
    }

    /// Returns whether files hold codes of a transfer function, of a TIFF those without floats; otherwise they hold
    /// linear color.
    pub fn is_encoded(self) -> bool {
        self.properties().is_encoded
    }

    /// The format by the ending of a file's name.
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let name = path.as_ref().file_name()?.to_string_lossy().to_ascii_lowercase();
        let (_, ending) = name.rsplit_once('.')?;
        Self::readable().find(|format| format.endings().contains(&ending))
    }

    /// The format by the signature; the reader is at its start again afterwards.
    pub(crate) fn of_content(reader: &mut (impl BufRead + Seek)) -> Result<Self, CodecError> {
        let start = first_bytes(reader).map_err(|error| CodecError::reading(&error))?;
        if let Some(format) = Self::readable().find(|format| is_signed(&start, format.properties().signatures)) {
            Ok(format)
        } else if start.is_empty() {
            Err(CodecError::new(ErrorKind::Broken, "the file is empty").hint("copy or render it again"))
        } else {
            Err(unknown_format(&start))
        }
    }
}

fn first_bytes(reader: &mut (impl BufRead + Seek)) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    reader.by_ref().take(16).read_to_end(&mut start)?;
    reader.rewind()?;
    Ok(start)
}

fn unknown_format(start: &[u8]) -> CodecError {
    if let Some(ForeignFormat { what, way, .. }) = ForeignFormat::of_content(start) {
        return CodecError::new(ErrorKind::Unsupported, format!("this is {what}")).hint(way);
    }
    let names = ImageFormat::readable_names();
    CodecError::new(ErrorKind::Unsupported, UNKNOWN).hint(format!("{names} files are read; convert it to one of them"))
}

/// The error of contents that nobody knows.
const UNKNOWN: &str = "this is not an image that this program knows";

impl CodecError {
    /// The error of a file with a name. Some formats have no signature, and then the name says what a file may be.
    pub(crate) fn of_name(self, path: &Path) -> Self {
        match ForeignFormat::of_name(path).filter(|_| self.message == UNKNOWN) {
            Some(ForeignFormat { what, way, .. }) => {
                Self::new(self.kind, format!("this is {what}, by its name")).hint(way)
            }
            None => self,
        }
    }
}
