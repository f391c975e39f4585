//! Descriptions of files, from their headers alone.

use afterimage_base::color::Colorimetry;

/// Content of the headers of an image file.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The [name](crate::ImageFormat::name) of the format.
    pub format: &'static str,
    /// The parts of an EXR file; one for other formats.
    pub parts: Vec<PartDescription>,
    /// The channels that are read as red, green, blue and alpha if no layer is named; those that are missing are left
    /// out. `None` if a layer must be named.
    pub picture: Option<PictureChannels>,
    /// Names that may follow the file's after `#`: the layers of an EXR file, the most likely one first, and the
    /// channels that are in none of them. Empty for other formats.
    pub layers: Vec<String>,
    /// The colorimetry of the picture; `None` for numbers that are no color.
    pub color: Option<Colorimetry>,
    /// The source of the colorimetry in the file: the attribute, chunk or line. `None` if nothing does, and it is
    /// assumed.
    pub stated_by: Option<&'static str>,
    /// Sentences about what reading leaves out or changes.
    pub notes: Vec<String>,
    /// The frames of a film, and their seconds.
    pub film: Option<(usize, f64)>,
}

impl Description {
    /// A file with one picture of this size, whose colors are not known yet.
    pub(crate) fn of_picture(
        format: &'static str,
        (width, height): (u32, u32),
        channels: &[&str],
        samples: &'static str,
        compression: &str,
    ) -> Self {
        let window = Window { x: 0, y: 0, width: width.into(), height: height.into() };
        let channels: Vec<String> = channels.iter().map(|name| (*name).to_owned()).collect();
        let part = PartDescription {
            name: None,
            display: window,
            data: window,
            channels: channels.iter().map(|name| ChannelDescription { name: name.clone(), samples }).collect(),
            compression: compression.to_owned(),
            tiles: None,
        };
        let picture = Some(PictureChannels { part: 0, channels });
        Self {
            format,
            parts: vec![part],
            picture,
            layers: Vec::new(),
            color: None,
            stated_by: None,
            notes: Vec::new(),
            film: None,
        }
    }
}

/// A part of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartDescription {
    /// The name of an EXR part.
    pub name: Option<String>,
    /// The pixels of the picture.
    pub display: Window,
    /// The pixels that the file holds.
    pub data: Window,
    /// The channels in the order of the file.
    pub channels: Vec<ChannelDescription>,
    /// The compression of the pixels.
    pub compression: String,
    /// The size of tiles, across and down; `None` for rows.
    pub tiles: Option<[u64; 2]>,
}

/// An area of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first column.
    pub x: i32,
    /// The first row, from the top.
    pub y: i32,
    /// Columns.
    pub width: u64,
    /// Rows.
    pub height: u64,
}

/// A channel of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelDescription {
    /// Its name, with the layer before it: `diffuse.R`.
    pub name: String,
    /// The type of a sample: `half`, `float`, `uint`, `8 bits`, `16 bits`, or `RGBE` for eight bits with a shared
    /// exponent.
    pub samples: &'static str,
}

/// The channels that make a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureChannels {
    /// The part, from 0.
    pub part: usize,
    /// The names of the channels that are there.
    pub channels: Vec<String>,
}
