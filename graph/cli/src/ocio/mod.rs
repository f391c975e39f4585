//! OpenColorIO: the config of a run, what reads images in its color spaces, and the node kind of its views and looks.

mod config;
mod function;
mod node;

use afterimage_graph::diagnostic::did_you_mean;
use afterimage_graph::node::NodeKind;
use afterimage_media::{ColorSpace, Picture, Pixels};
use ocio::{Config, OptimizationFlags};

use crate::failure::Failure;
use config::{LIGHT, config, sentence};

pub(crate) use config::choose;

/// The kinds of configs.
pub(crate) static KINDS: &[NodeKind] = &[NodeKind::of::<node::OcioTransform>()];

/// What makes linear Rec.709 of a color space of the config.
fn to_light(config: &Config, space: &str) -> Result<ocio::Processor, String> {
    if config.get_color_space(space).is_none() {
        let known: Vec<&str> = (0..config.num_color_spaces()).map(|at| config.color_space_name_by_index(at)).collect();
        let names = [known, ColorSpace::ALL.map(|space| space.name).to_vec()].concat();
        let meant = did_you_mean(space, names).map_or(String::new(), |name| format!("; {name}"));
        return Err(format!("the config has no color space `{space}`{meant}"));
    }
    Config::get_processor_to_builtin_color_space(config, space, LIGHT).map_err(|error| sentence(&error))
}

/// Checks that images in this color space can be read.
pub(crate) fn check_space(space: &str) -> Result<(), Failure> {
    let processor = config().and_then(|config| to_light(config, space));
    processor.map(|_| ()).map_err(|error| Failure::user(format!("`--input-space {space}`: {error}")))
}

/// A picture whose numbers are in this color space, as linear light.
pub(crate) fn light_of(mut picture: Picture, space: &str) -> Result<Picture, Failure> {
    let processor = config().and_then(|config| to_light(config, space)).map_err(Failure::user)?;
    let mut numbers = picture.pixels.to_f32();
    processor.optimized_cpu_processor(OptimizationFlags::LOSSLESS).apply_rgba_slice(&mut numbers);
    picture.pixels = Pixels::Float(numbers);
    Ok(picture)
}
