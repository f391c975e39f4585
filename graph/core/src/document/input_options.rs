//! The types of inputs and their options: `Color(optional: true)`.

use super::entries::InputEntry;
use super::tree::{Item, Tree};
use super::unknown::unknown;
use afterimage_base::diagnostic::{Diagnostic, Spanned, quote};
use afterimage_base::image::ColorState;

#[derive(Clone, Copy)]
pub(super) struct ImageType {
    name: &'static str,
    pub(super) state: ColorState,
    /// Channels without which an image cannot be of the type.
    pub(super) min_channels: u8,
}

impl ImageType {
    const fn new(name: &'static str, state: ColorState) -> Self {
        Self { name, state, min_channels: 1 }
    }
}

const IMAGE_TYPES: [ImageType; 11] = [
    ImageType::new("Color", ColorState::Scene),
    ImageType::new("Exposed", ColorState::Exposed),
    ImageType::new("LogLuminance", ColorState::LogLuminance),
    ImageType::new("DisplayLinear", ColorState::DisplayLinear),
    ImageType::new("Encoded", ColorState::Encoded),
    ImageType::new("Data", ColorState::Data),
    ImageType::new("Depth", ColorState::Data),
    ImageType { min_channels: 3, ..ImageType::new("Normals", ColorState::Data) },
    ImageType { min_channels: 2, ..ImageType::new("Motion", ColorState::Data) },
    ImageType::new("Albedo", ColorState::Data),
    ImageType::new("Mask", ColorState::Data),
];

/// The type of images of that name.
pub(super) fn image_type(name: &str) -> Option<ImageType> {
    IMAGE_TYPES.into_iter().find(|known| known.name == name)
}

/// The names of all types of images.
pub fn image_type_names() -> impl Iterator<Item = &'static str> {
    IMAGE_TYPES.iter().map(|known| known.name)
}

const OPTIONS: [&str; 5] = ["optional", "multisampled", "volume", "needs_alpha", "scale"];

/// Sets an option of an input; what is wrong with it otherwise.
pub(super) fn set_option(input: &mut InputEntry, option: &Spanned<String>, value: &Item) -> Option<Diagnostic> {
    match option.value.as_str() {
        "optional" => set_flag(&mut input.optional, option, value),
        "multisampled" => set_flag(&mut input.multisampled, option, value),
        "volume" => set_flag(&mut input.volume, option, value),
        "needs_alpha" => set_flag(&mut input.needs_alpha, option, value),
        "scale" => set_factor(&mut input.scale, option, value),
        other => {
            let message = format!("an input has no option {}", quote(other));
            Some(unknown("unknown-option", message, option, "options", &OPTIONS))
        }
    }
}

/// What options of an input contradict each other, if they do: samples and volumes are limited where they are read, and
/// a factor comes before that.
pub(super) fn contradiction(input: &InputEntry) -> Option<Diagnostic> {
    let InputEntry { multisampled, volume, scale, .. } = *input;
    let (code, wrong, help) = match (multisampled, volume, scale != 1.0) {
        (true, true, _) => ("multisampled-volume", "multisampled and a volume", "devices have no such textures"),
        (true, _, true) => {
            let help = "leave `scale` out, and put an `Exposure` after the `Resolve`";
            ("multisampled-scale", "multisampled and has a scale", help)
        }
        (_, true, true) => {
            let help = "leave `scale` out, and use a factor of the kind that reads it, such as `light`";
            ("volume-scale", "a volume and has a scale", help)
        }
        _ => return None,
    };
    let message = format!("input {} is {wrong}", quote(&input.name.value));
    Some(Diagnostic::error(code, message).at(&input.name.location, "").help(help))
}

/// Sets an option that is on or off.
fn set_flag(flag: &mut bool, option: &Spanned<String>, value: &Item) -> Option<Diagnostic> {
    match value.value {
        Tree::Bool(given) => *flag = given,
        Tree::Broken => {}
        _ => return Some(wrong_option(option, value, "`true` or `false`")),
    }
    None
}

/// Sets an option that is a factor.
fn set_factor(factor: &mut f64, option: &Spanned<String>, value: &Item) -> Option<Diagnostic> {
    match value.value.number() {
        Some(given) if (MIN_FACTOR..=MAX_FACTOR).contains(&given) => *factor = given,
        _ if value.value.is_broken() => {}
        _ => return Some(wrong_option(option, value, "a number above 0, from 1e-30 to 1e30")),
    }
    None
}

/// A 32-bit float holds these factors and their inverses.
const MIN_FACTOR: f64 = 1e-30;
const MAX_FACTOR: f64 = 1e30;

fn wrong_option(option: &Spanned<String>, value: &Item, expected: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", format!("{} is {expected}", quote(&option.value)))
        .at(&value.location, format!("this is {}", value.value.describe()))
}
