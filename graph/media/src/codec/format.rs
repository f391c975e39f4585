//! The formats of image files: endings of names, signatures of contents, and the depths that can be written.

use std::io::{BufRead, Read as _, Seek};
use std::path::Path;

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

impl ImageFormat {
    /// The formats that this program reads.
    pub fn readable() -> impl Iterator<Item = Self> {
        let has = |format: Self, is_built: bool| move |known: &Self| is_built || *known != format;
        Self::ALL
            .into_iter()
            .filter(has(Self::Jxl, cfg!(feature = "jxl")))
            .filter(has(Self::Avif, cfg!(feature = "avif")))
    }

    /// The endings of file names, in lower case; the usual one first.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Exr => &["exr", "sxr", "mxr"],
            Self::Hdr => &["hdr"],
            Self::Png => &["png"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::Tiff => &["tif", "tiff"],
            Self::Dpx => &["dpx"],
            Self::Jxl => &["jxl"],
            Self::Avif => &["avif"],
        }
    }

    /// The first bytes of files, of an AVIF those after the length of its first box.
    fn signatures(self) -> &'static [&'static [u8]] {
        match self {
            Self::Exr => &[b"\x76\x2f\x31\x01"],
            Self::Hdr => &[b"#?RADIANCE", b"#?RGBE"],
            Self::Png => &[b"\x89PNG\r\n\x1a\n"],
            Self::Jpeg => &[b"\xff\xd8\xff"],
            Self::Tiff => &[b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"],
            Self::Dpx => &[b"SDPX", b"XPDS"],
            Self::Jxl => &[b"\xff\x0a", b"\0\0\0\x0cJXL \r\n\x87\n"],
            Self::Avif => &[b"ftypavif", b"ftypavis"],
        }
    }

    /// The name for users.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exr => "EXR",
            Self::Hdr => "Radiance HDR",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
            Self::Dpx => "DPX",
            Self::Jxl => "JPEG XL",
            Self::Avif => "AVIF",
        }
    }

    /// The bits of a channel that can be written, in codes or, for EXR and the 32 of TIFF, in floats; none for a format
    /// that is read only.
    pub fn depths(self) -> &'static [u32] {
        match self {
            Self::Exr => &[16, 32],
            Self::Hdr | Self::Dpx | Self::Jxl | Self::Avif => &[],
            Self::Png => &[8, 16],
            Self::Jpeg => &[8],
            Self::Tiff => &[8, 16, 32],
        }
    }

    /// Returns whether files hold codes of a transfer function, of a TIFF those without floats; otherwise they hold
    /// linear color.
    pub fn is_encoded(self) -> bool {
        match self {
            Self::Exr | Self::Hdr => false,
            Self::Png | Self::Jpeg | Self::Tiff | Self::Dpx | Self::Jxl | Self::Avif => true,
        }
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
        let is_signed = |format: &Self| {
            let from = if *format == Self::Avif { 4 } else { 0 };
            let start = start.get(from..).unwrap_or_default();
            format.signatures().iter().any(|signature| start.starts_with(signature))
        };
        if let Some(format) = Self::readable().find(is_signed) {
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
    let names: Vec<&str> = ImageFormat::readable().map(ImageFormat::name).collect();
    let (last, others) = names.split_last().expect("there are formats");
    CodecError::new(ErrorKind::Unsupported, UNKNOWN)
        .hint(format!("{} and {last} files are read; convert it to one of them", others.join(", ")))
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
