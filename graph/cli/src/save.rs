//! Writes rendered texels to files.

use std::fs::File;
use std::path::Path;

use afterimage::offline::quantize::{Noise, with_encoded_pixels};
use afterimage_gpu::Texels;
use afterimage_graph::color::Colorimetry;
use afterimage_graph::image::{ColorState, Format};
use afterimage_media::{
    Alpha, ColorSpace, EncodedPixels, ExrCompression, ExrOptions, JpegOptions, Metadata, Picture, Pixels, PngDepth,
    PngOptions, PngRows, ReadOptions, RowsFile, RowsOptions, Source, png_left_out, write_exr, write_exr_beside,
    write_jpeg, write_png,
};
use afterimage_plan::PlanOutput;

use crate::failure::Failure;

/// The format of a file, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileFormat {
    Png,
    Jpeg,
    Exr,
}

impl FileFormat {
    /// The format of a file of that name; `None` if it is none that is written.
    pub(crate) fn of(name: &str) -> Option<Self> {
        let (_, ending) = name.rsplit_once('.')?;
        match &*ending.to_lowercase() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }

    /// Whether it holds encoded pictures, and not linear light.
    pub(crate) fn is_encoded(self) -> bool {
        self != Self::Exr
    }
}

/// How images are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SaveOptions {
    pub(crate) format: FileFormat,
    /// Bits of a channel.
    pub(crate) bits: u32,
    /// Whether codes are dithered; otherwise they are rounded.
    pub(crate) dither: bool,
    /// The noise of the dither.
    pub(crate) noise: Noise,
    /// For PNG.
    pub(crate) alpha: Alpha,
    /// Whether alpha is coverage that is multiplied into the light, and no mask.
    pub(crate) premultiplied: bool,
    /// For JPEG, 1 to 100; that of the format if `None`.
    pub(crate) quality: Option<u8>,
    /// For EXR.
    pub(crate) compression: ExrCompression,
    /// For EXR; that of the output if `None`.
    pub(crate) space: Option<ColorSpace>,
}

impl SaveOptions {
    /// Files of that format as `demo` writes them: dithered to eight bits, without alpha, which is a mask there; half
    /// floats in EXR.
    pub(crate) fn plain(format: FileFormat) -> Self {
        let bits = if format == FileFormat::Exr { 16 } else { 8 };
        Self {
            format,
            bits,
            dither: true,
            noise: Noise::default(),
            alpha: Alpha::Drop,
            premultiplied: true,
            quality: None,
            compression: ExrCompression::default(),
            space: None,
        }
    }

    fn seed(&self, frame: u32) -> Option<u32> {
        self.dither.then(|| self.noise.seed(frame))
    }

    fn png(&self, color: Colorimetry, frame: u32) -> PngOptions {
        let depth = if self.bits == 16 { PngDepth::Sixteen } else { PngDepth::Eight };
        PngOptions {
            depth,
            alpha: self.alpha,
            premultiplied: self.premultiplied,
            dither: self.seed(frame),
            color: Some(color),
        }
    }

    fn exr(&self, state: ColorState, color: Colorimetry) -> ExrOptions {
        ExrOptions {
            float: self.bits == 32,
            color: is_light(state).then_some(color),
            primaries: self.space.map(|space| space.primaries),
            scene: matches!(state, ColorState::Scene | ColorState::Exposed),
            compression: self.compression,
            ..ExrOptions::default()
        }
    }

    /// How an image is written row by row; `None` if its first bytes depend on all of its pixels, as those of PQ do.
    pub(crate) fn rows(&self, stated: Stated) -> Option<RowsOptions> {
        match self.format {
            FileFormat::Png => {
                let options = self.png(stated.colorimetry, stated.frame);
                PngRows::<File>::can_write(&options).then_some(RowsOptions::Png(options))
            }
            FileFormat::Jpeg => Some(RowsOptions::Jpeg(self.jpeg(stated.colorimetry, stated.frame))),
            FileFormat::Exr => {
                let options = self.exr(stated.state, stated.colorimetry);
                Some(RowsOptions::Exr(options, Box::new(kept_attributes(stated.meta?, stated.state))))
            }
        }
    }

    fn jpeg(&self, color: Colorimetry, frame: u32) -> JpegOptions {
        let default = JpegOptions::default();
        let quality = self.quality.unwrap_or(default.quality);
        JpegOptions { quality, dither: self.seed(frame), color: Some(color) }
    }
}

/// What is known about an image besides its texels.
pub(crate) struct Stated {
    pub(crate) state: ColorState,
    pub(crate) colorimetry: Colorimetry,
    /// The attributes of the input, for EXR.
    pub(crate) meta: Option<Metadata>,
    /// The number of the frame in its sequence; 0 for a single image.
    pub(crate) frame: u32,
    /// The file whose layers an EXR keeps.
    pub(crate) original: Option<Original>,
}

/// A file that was read.
pub(crate) struct Original {
    pub(crate) source: Source,
    pub(crate) reading: ReadOptions,
}

impl Stated {
    /// A single image of an output.
    pub(crate) fn of(output: &PlanOutput) -> Self {
        Self { state: output.state, colorimetry: output.colorimetry, meta: None, frame: 0, original: None }
    }

    /// The sentence about an aspect of pixels that no other file than an EXR states.
    pub(crate) fn square_pixels(&self) -> Option<String> {
        let aspect = self.meta.as_ref().map_or(1.0, |meta| meta.image.pixel_aspect);
        let note =
            || format!("the pixels of the image are {aspect} times as wide as high, which only an EXR file states");
        ((aspect - 1.0).abs() > 1e-6).then(note)
    }
}

/// Writes an image. Returns sentences about what is left out.
pub(crate) fn save(
    path: &Path,
    texels: &Texels,
    stated: Stated,
    options: &SaveOptions,
) -> Result<Vec<String>, Failure> {
    if options.format == FileFormat::Exr {
        return save_exr(path, texels, stated, options);
    }
    let mut left_out = with_encoded_pixels(texels, |pixels| save_encoded(path, texels, pixels, &stated, options))?;
    left_out.extend(stated.square_pixels());
    Ok(left_out)
}

fn save_encoded(
    path: &Path,
    texels: &Texels,
    pixels: EncodedPixels<'_>,
    stated: &Stated,
    options: &SaveOptions,
) -> Result<Vec<String>, Failure> {
    let size = (texels.desc.size.width, texels.desc.size.height);
    let (color, frame) = (stated.colorimetry, stated.frame);
    match options.format {
        FileFormat::Jpeg => write_jpeg(path, size, pixels, &options.jpeg(color, frame))?,
        _ => {
            let png = options.png(color, frame);
            write_png(path, size, pixels, &png)?;
            return Ok(png_left_out(pixels, &png).into_iter().collect());
        }
    }
    Ok(Vec::new())
}

fn save_exr(path: &Path, texels: &Texels, stated: Stated, options: &SaveOptions) -> Result<Vec<String>, Failure> {
    let mut picture = Picture::new(texels.desc.size.width, texels.desc.size.height, pixels(texels));
    picture.meta = stated.meta.map_or(picture.meta, |meta| kept_attributes(meta, stated.state));
    let exr = options.exr(stated.state, stated.colorimetry);
    match stated.original.filter(|_| is_light(stated.state)) {
        Some(Original { source, reading }) => Ok(write_exr_beside(path, &picture, &exr, &source, &reading)?),
        None => Ok(write_exr(path, &picture, &exr)?),
    }
}

/// Whether the numbers of such an image are light, with primaries.
pub(crate) fn is_light(state: ColorState) -> bool {
    !matches!(state, ColorState::Data | ColorState::LogLuminance)
}

/// What the input states about its luminance holds for its own light only.
fn kept_attributes(mut meta: Metadata, state: ColorState) -> Metadata {
    if state != ColorState::Scene {
        meta.layer.white_luminance = None;
        meta.layer.adopted_neutral = None;
    }
    meta
}

fn pixels(texels: &Texels) -> Pixels {
    match texels.desc.format {
        Format::Rgba16Float => Pixels::Half(bytemuck::pod_collect_to_vec(&texels.bytes)),
        _ => Pixels::Float(texels.to_floats().as_flattened().to_vec()),
    }
}

/// Writes the next rows of a file.
pub(crate) fn write_rows(file: &mut RowsFile, rows: &Texels) -> Result<(), Failure> {
    if file.is_encoded() {
        with_encoded_pixels(rows, |pixels| file.write_encoded(pixels))?;
    } else {
        file.write_light(pixels(rows))?;
    }
    Ok(())
}
