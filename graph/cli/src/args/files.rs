//! Options of the image files that `render` reads and writes.

use afterimage_graph::check::GraphInput;
use afterimage_graph::image::ColorState;
use afterimage_media::sequence::StandIn;
use afterimage_media::{Budget, ColorSpace, ExrCompression, ReadOptions};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::headings::{INPUT_FILES, OUTPUT_FILES};
use super::options::parse_scale;

/// Options of the commands that read sequences for a render.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = INPUT_FILES)]
pub(crate) struct ReadArgs {
    /// What the numbers of the images mean, whatever the files state: `ACEScg`, or for one input `albedo=Rec709`; one
    /// of Rec709, P3, Rec2020, ACEScg and ACES2065-1 (linear light), and for PNG also sRGB, DisplayP3, Rec2100-PQ and
    /// Rec2100-HLG
    #[arg(long, value_name = "[INPUT=]SPACE", value_parser = parse_input_space)]
    pub(crate) input_space: Vec<InputSpace>,
    /// What takes the place of missing frames of a sequence
    #[arg(long, value_enum, default_value_t = MissingFrames::Error)]
    pub(crate) missing: MissingFrames,
    /// Which pixels of EXR files are the picture. With `data`, overscan passes through the pipeline, and an EXR file
    /// that is written has both windows
    #[arg(long, value_enum, default_value_t = WindowChoice::Display)]
    pub(crate) window: WindowChoice,
    /// What becomes of frames whose size is not that of the first one
    #[arg(long, value_enum, default_value_t = OtherSize::Error)]
    pub(crate) resize: OtherSize,
    /// Render smaller: images are scaled to this share of their width and height, such as `0.5` or `25%`. What
    /// parameters and images state in pixels stays
    #[arg(long, value_name = "SHARE", value_parser = parse_scale)]
    pub(crate) scale: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MissingFrames {
    /// Nothing: the run ends before it begins
    #[default]
    Error,
    /// The last frame before them
    Hold,
    /// Black of that size
    Black,
}

impl MissingFrames {
    /// The file that stands for a missing frame; `None` if none does.
    pub(crate) fn stand_in(self) -> Option<StandIn> {
        match self {
            Self::Error => None,
            Self::Hold => Some(StandIn::Before),
            Self::Black => Some(StandIn::Any),
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum OtherSize {
    /// They cannot be rendered
    #[default]
    Error,
    /// They are scaled into that size, with black beside them
    Fit,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum WindowChoice {
    /// Those of the display window, with zeros where a file has none
    #[default]
    Display,
    /// Those of the data window, which all frames must have in one size
    Data,
}

/// The color space of the files of an input, or of all inputs but those of data.
#[derive(Clone, Debug)]
pub(crate) struct InputSpace {
    pub(crate) input: Option<String>,
    space: ColorSpace,
    /// The color space of the OpenColorIO config; `space` is linear Rec.709 then, so that numbers are read as they are.
    #[cfg_attr(not(feature = "ocio"), expect(dead_code, reason = "no config has spaces"))]
    of_config: Option<String>,
}

impl ReadArgs {
    /// The options for reading the files of an input.
    pub(crate) fn options(&self, budget: Budget, space: Option<ColorSpace>) -> ReadOptions {
        ReadOptions { space, data_window: self.window == WindowChoice::Data, ..budget.into() }
    }

    /// The options for reading the files of an input; `None` for one that the pipeline does not have.
    pub(crate) fn options_for(&self, budget: Budget, input: Option<&GraphInput>) -> ReadOptions {
        let space = input.and_then(|input| self.space_of(input));
        // A mask in alpha says nothing about the light beside it.
        let is_mask = input.is_some_and(|input| input.needs_alpha || input.state == ColorState::Data);
        ReadOptions { premultiplied: !is_mask, ..self.options(budget, space) }
    }

    /// The space that the command line states for the files of an input; that with its name counts first.
    pub(crate) fn space_of(&self, input: &GraphInput) -> Option<ColorSpace> {
        self.given_for(input).map(|given| given.space)
    }

    /// The color space of the OpenColorIO config that the command line states for the files of an input.
    #[cfg(feature = "ocio")]
    pub(crate) fn config_space_of(&self, input: &GraphInput) -> Option<&str> {
        self.given_for(input)?.of_config.as_deref()
    }

    /// The color spaces of the OpenColorIO config that the command line states.
    #[cfg(feature = "ocio")]
    pub(crate) fn config_spaces(&self) -> impl Iterator<Item = &str> {
        self.input_space.iter().filter_map(|given| given.of_config.as_deref())
    }

    fn given_for(&self, input: &GraphInput) -> Option<&InputSpace> {
        let named = self.input_space.iter().find(|given| given.input.as_ref() == Some(&input.name));
        let is_color = input.state != ColorState::Data;
        let of_all = || self.input_space.iter().find(|given| given.input.is_none() && is_color);
        named.or_else(of_all)
    }
}

/// The variable that stands for `--output-space`.
pub(crate) const OUTPUT_SPACE: &str = "AFTERIMAGE_OUTPUT_SPACE";

/// Options of the EXR files that `render` writes.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = OUTPUT_FILES)]
pub(crate) struct ExrArgs {
    /// The color space of EXR files; Rec709 by default. ACES2065-1 in halves with `--compression none` is an ACES
    /// container (SMPTE ST 2065-4)
    #[arg(long, value_name = "SPACE", ignore_case = true, value_parser = linear_spaces())]
    #[arg(env = OUTPUT_SPACE)]
    pub(crate) output_space: Option<ColorSpace>,
    /// True if the space is that of the environment, which holds for all runs, also those that write no EXR.
    #[arg(skip)]
    pub(crate) is_space_of_all_runs: bool,
    /// The compression of EXR files; `zip` by default. b44, b44a, dwaa and dwab lose details, pxr24 those of floats
    #[arg(long, value_parser = compressions())]
    pub(crate) compression: Option<ExrCompression>,
    /// Write the result alone. By default an EXR that is made from one keeps the other layers and parts of that file
    /// bit for bit, and a line says what it cannot keep
    #[arg(long)]
    pub(crate) drop_layers: bool,
}

impl ExrArgs {
    /// The first option that is given, which is a mistake if no EXR file is written.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let options = [
            ("--output-space", self.output_space.is_some() && !self.is_space_of_all_runs),
            ("--compression", self.compression.is_some()),
            ("--drop-layers", self.drop_layers),
        ];
        options.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name)
    }
}

fn linear_spaces() -> impl TypedValueParser<Value = ColorSpace> {
    let linear = ColorSpace::ALL.iter().filter(|space| space.is_linear());
    let names: Vec<&str> = linear.map(|space| space.name).collect();
    PossibleValuesParser::new(names).map(|name| ColorSpace::named(&name).expect("it is one of the names"))
}

fn compressions() -> impl TypedValueParser<Value = ExrCompression> {
    let names = ExrCompression::ALL.map(ExrCompression::name);
    PossibleValuesParser::new(names).map(|name| ExrCompression::named(&name).expect("it is one of the names"))
}

/// `ACEScg` or `albedo=ACEScg`.
pub(crate) fn parse_input_space(text: &str) -> Result<InputSpace, String> {
    let (input, name) = text.split_once('=').map_or((None, text), |(input, name)| (Some(input.to_owned()), name));
    if let Some(space) = ColorSpace::named(name) {
        return Ok(InputSpace { input, space, of_config: None });
    }
    if cfg!(feature = "ocio") {
        let [space, ..] = ColorSpace::ALL;
        return Ok(InputSpace { input, space, of_config: Some(name.to_owned()) });
    }
    let names = ColorSpace::ALL.map(|space| space.name);
    Err(format!(
        "no color space is called so; known are {}; those of cameras need a program with `--features ocio`",
        names.join(", ")
    ))
}
