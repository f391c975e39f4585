//! Writes rendered texels to files.

use std::path::Path;

use afterimage_gpu::Texels;
use afterimage_graph::image::{ColorState, Format};
use half::f16;

use crate::failure::Failure;
use afterimage_media::{EncodedPixels, ExrOptions, Metadata, Picture, Pixels, PngOptions, write_exr, write_png};

/// How images are written.
#[derive(Default)]
pub(crate) struct SaveOptions {
    pub(crate) png: PngOptions,
    pub(crate) exr: ExrOptions,
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
