//! Writes rendered texels to files.

use std::path::Path;

use afterimage_gpu::Texels;
use afterimage_graph::image::{ColorState, Format};
use half::f16;

use crate::args::RenderArgs;
use crate::failure::Failure;
use afterimage_media::{
    EncodedPixels, ExrOptions, Metadata, Picture, Pixels, PngDepth, PngOptions, write_exr, write_png,
};

/// How images are written.
#[derive(Default)]
pub(crate) struct SaveOptions {
    png: PngOptions,
    exr: ExrOptions,
}

impl SaveOptions {
    pub(crate) fn new(args: &RenderArgs) -> Result<Self, Failure> {
        let png = Self::is_png(&args.out);
        if !png && !ends_with(&args.out, ".exr") {
            return Err(Failure::user(format!("`{}` ends neither in `.png` nor in `.exr`", args.out))
                .hint("`.png` takes an encoded output, `.exr` a linear one"));
        }
        let depth = match (png, args.depth) {
            (true, None | Some(8)) | (false, None | Some(16)) => false,
            (true, Some(16)) | (false, Some(32)) => true,
            (true, Some(depth)) => return Err(Failure::user(format!("a PNG has 8 or 16 bits, not {depth}"))),
            (false, Some(depth)) => return Err(Failure::user(format!("an EXR has 16 or 32 bits, not {depth}"))),
        };
        Ok(Self {
            png: PngOptions {
                depth: if png && depth { PngDepth::Sixteen } else { PngDepth::Eight },
                dither: (!args.no_dither).then_some(0),
                ..PngOptions::default()
            },
            exr: ExrOptions { float: !png && depth, ..ExrOptions::default() },
        })
    }

    /// Whether the file name is that of a PNG.
    pub(crate) fn is_png(out: &str) -> bool {
        ends_with(out, ".png")
    }
}

fn ends_with(name: &str, ending: &str) -> bool {
    name.to_lowercase().ends_with(ending)
}

/// Writes an image: encoded ones as PNG, others as EXR.
pub(crate) fn save(
    path: &Path,
    texels: &Texels,
    state: ColorState,
    meta: Option<Metadata>,
    options: &SaveOptions,
) -> Result<(), Failure> {
    let size = (texels.desc.size.width, texels.desc.size.height);
    if state == ColorState::Encoded {
        return match texels.desc.format {
            Format::Rgba8Unorm => Ok(write_png(path, size, EncodedPixels::Byte(&texels.bytes), &options.png)?),
            Format::Rgba16Float => Ok(write_png(path, size, EncodedPixels::Half(&halves(texels)), &options.png)?),
            _ => Ok(write_png(path, size, EncodedPixels::Float(texels.to_floats().as_flattened()), &options.png)?),
        };
    }
    let pixels = match texels.desc.format {
        Format::Rgba16Float => Pixels::Half(halves(texels)),
        _ => Pixels::Float(texels.to_floats().as_flattened().to_vec()),
    };
    let mut picture = Picture::new(size.0, size.1, pixels);
    if let Some(meta) = meta {
        picture.meta = meta;
    }
    Ok(write_exr(path, &picture, &options.exr)?)
}

fn halves(texels: &Texels) -> Vec<f16> {
    bytemuck::pod_collect_to_vec(&texels.bytes)
}
