//! Writes rendered texels to files.

use std::path::Path;

use afterimage::offline::quantize::{Noise, with_samples};
use afterimage_gpu::Texels;
use afterimage_graph::color::Colorimetry;
use afterimage_graph::image::ColorState;
use afterimage_media::{
    Encoding, Image, ImageFile, ImageFormat, Metadata, ReadOptions, Samples, Source, left_out, write_beside,
    write_image, write_standard_output,
};
use afterimage_plan::PlanOutput;

use crate::failure::Failure;

/// The name of standard input and standard output.
pub(crate) const STANDARD: &str = "-";

/// Properties of the files of a target. The output of the pipeline adds its color, and the frame its noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SaveOptions {
    pub(crate) encoding: Encoding,
    /// The noise of the dither.
    pub(crate) noise: Noise,
}

impl SaveOptions {
    /// The options of `demo` for files of a format: dithered to eight bits, without alpha, which is a mask there; half
    /// floats in EXR.
    pub(crate) fn plain(format: ImageFormat) -> Self {
        let encoding = match format {
            ImageFormat::Png | ImageFormat::Tiff => Encoding { format, ..Encoding::PNG },
            ImageFormat::Jpeg => Encoding::JPEG,
            _ => Encoding::EXR,
        };
        Self { encoding, noise: Noise::default() }
    }

    /// The encoding of an image.
    pub(crate) fn encoding(&self, stated: &ImageInfo) -> Encoding {
        Encoding {
            dither: self.encoding.dither.map(|_| self.noise.seed(stated.frame)),
            color: is_color(stated.state).then_some(stated.colorimetry),
            scene: matches!(stated.state, ColorState::Scene | ColorState::Exposed),
            ..self.encoding
        }
    }
}

/// Properties of an image besides its texels.
pub(crate) struct ImageInfo {
    pub(crate) state: ColorState,
    pub(crate) colorimetry: Colorimetry,
    /// The attributes of the input, for EXR.
    pub(crate) meta: Option<Metadata>,
    /// The number of the frame in its sequence; 0 for a single image.
    pub(crate) frame: u32,
    /// The file whose layers an EXR preserves.
    pub(crate) original: Option<Original>,
    /// The image to which the gain map of a JPEG leads.
    pub(crate) hdr: Option<(Texels, Colorimetry)>,
}

/// A file that was read.
pub(crate) struct Original {
    pub(crate) source: Source,
    pub(crate) reading: ReadOptions,
}

impl ImageInfo {
    /// A single image of an output.
    pub(crate) fn of(output: &PlanOutput) -> Self {
        Self { state: output.state, colorimetry: output.colorimetry, meta: None, frame: 0, original: None, hdr: None }
    }

    /// The attributes that hold for the image: the luminance that the input states is that of its own color.
    pub(crate) fn attributes(&self) -> Option<Metadata> {
        let mut meta = self.meta.clone()?;
        if self.state != ColorState::Scene {
            meta.layer.white_luminance = None;
            meta.layer.adopted_neutral = None;
        }
        Some(meta)
    }
}

/// Writes an image. Returns sentences about what is left out.
pub(crate) fn save(
    path: &Path,
    texels: &Texels,
    stated: &ImageInfo,
    options: &SaveOptions,
) -> Result<Vec<String>, Failure> {
    let (encoding, meta) = (options.encoding(stated), stated.attributes());
    let has_layers = encoding.format == ImageFormat::Exr && is_color(stated.state);
    let size = (texels.desc.size.width, texels.desc.size.height);
    let write = |samples: Samples<'_>, hdr: Option<(Samples<'_>, Colorimetry)>| {
        let image = Image { size, samples, meta: meta.as_ref(), hdr };
        if path == Path::new(STANDARD) {
            let mut notes = write_standard_output(image, &encoding)?;
            if let Some(Original { source, .. }) = stated.original.as_ref().filter(|_| has_layers) {
                notes.extend(left_out(source, "standard output takes the picture alone")?);
            }
            return Ok(notes);
        }
        match stated.original.as_ref().filter(|_| has_layers) {
            Some(Original { source, reading }) => write_beside(path, image, &encoding, source, reading),
            None => write_image(path, image, &encoding),
        }
    };
    let notes = with_samples(texels, |samples| match &stated.hdr {
        Some((texels, color)) => with_samples(texels, |hdr| write(samples, Some((hdr, *color)))),
        None => write(samples, None),
    });
    Ok(notes?)
}

/// True if an image in this state is color, which has primaries.
pub(crate) fn is_color(state: ColorState) -> bool {
    !matches!(state, ColorState::Data | ColorState::LogLuminance)
}

/// Writes the next rows of a file.
pub(crate) fn write_rows(file: &mut ImageFile, rows: &Texels) -> Result<(), Failure> {
    Ok(with_samples(rows, |samples| file.write(samples))?)
}
