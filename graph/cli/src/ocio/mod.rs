//! OpenColorIO: the config of a run, what reads images in its color spaces, and the node kind of its views and looks.

mod config;
mod function;
mod node;

use std::collections::BTreeSet;
use std::path::PathBuf;

use afterimage_graph::node::NodeKind;
use afterimage_media::{ColorSpace, Picture, Pixels};
use ocio::{Config, OptimizationFlags};

use crate::failure::Failure;
use config::{REC709, config, no_space, noted};

pub(crate) use config::{choose, files, list_files};

pub(crate) static KINDS: &[NodeKind] = &[NodeKind::of::<node::OcioTransform>()];

/// Forgets the config and all that is made from it if these files are among its own. Returns whether they are.
pub(crate) fn forget(changed: &BTreeSet<PathBuf>) -> bool {
    let is_other = config::forget(changed);
    if is_other {
        node::forget();
    }
    is_other
}

/// The processor from a color space of the config to linear Rec.709.
fn to_rec709(config: &Config, space: &str) -> Result<ocio::Processor, String> {
    if config.get_color_space(space).is_none() {
        return Err(no_space(config, space, &ColorSpace::ALL.map(|space| space.name)));
    }
    noted(Config::get_processor_to_builtin_color_space(config, space, REC709))
}

/// Checks that images in this color space can be read.
pub(crate) fn check_space(space: &str) -> Result<(), Failure> {
    let chosen = config().map_err(|error| {
        let own = ColorSpace::ALL.map(|space| space.name).join(", ");
        format!("it is none of {own}; for those of a config, {error}")
    });
    let processor = chosen.and_then(|config| to_rec709(&config, space));
    processor.map(|_| ()).map_err(|error| Failure::user(format!("`--input-space {space}`: {error}")))
}

/// Converts a picture in this color space to linear color.
pub(crate) fn to_linear(mut picture: Picture, space: &str) -> Result<Picture, Failure> {
    let processor = config().and_then(|config| to_rec709(&config, space)).map_err(Failure::user)?;
    let mut numbers = picture.pixels.to_f32();
    processor.optimized_cpu_processor(OptimizationFlags::LOSSLESS).apply_rgba_slice(&mut numbers);
    picture.pixels = Pixels::Float(numbers);
    Ok(picture)
}
