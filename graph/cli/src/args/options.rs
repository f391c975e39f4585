//! Options that several commands have.

use std::path::{Path, PathBuf};

use afterimage_graph::node::Bake;
use afterimage_media::{Budget, default_budget};
use afterimage_plan::{Alias, Options, When};
use clap::Args;
use clap::builder::{FalseyValueParser, Resettable};

use super::headings::{MACHINE, PIPELINE};

/// Options of every command that reads a pipeline.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = PIPELINE)]
pub(crate) struct PipelineOptions {
    /// Override a parameter: `--set bloom.strength=0.4`; the value is RON, as in the file
    #[arg(long = "set", value_name = "NODE.PARAMETER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Set a fact about the scene: `--fact emissive=false`, `--fact illuminance=3.5`
    #[arg(long = "fact", value_name = "NAME=VALUE")]
    pub(crate) facts: Vec<String>,
    /// The tier to use
    #[arg(long)]
    pub(crate) tier: Option<String>,
    #[command(flatten)]
    pub(crate) kinds: KindOptions,
}

/// The variable that stands for `--nodes`.
pub(crate) const NODES: &str = "AFTERIMAGE_NODES";

/// Folders of the command line: of node kinds, and of files that pipelines and kinds may name.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = PIPELINE)]
pub(crate) struct KindOptions {
    /// A folder of node kinds in WGSL, or of one: a `node.ron`, a `.wgsl` file named like the kind, and those that it
    /// imports, also from a folder `lib` next to it. Kinds beside the pipeline, or in whose folder it is, need none
    #[arg(long, value_name = "DIR", env = NODES)]
    pub(crate) nodes: Vec<PathBuf>,
    /// A folder whose files, and those below it, a pipeline may name; by default only those of its own folder and below
    #[arg(long, value_name = "DIR", value_parser = parse_folder)]
    pub(crate) allow: Vec<PathBuf>,
}

/// Options of the commands that show, measure or run one plan.
#[derive(Clone, Debug, Args)]
pub(crate) struct PlanOptions {
    /// Store every intermediate in 32-bit floats, and filter them in the shader
    #[arg(long, help_heading = Resettable::Reset)]
    pub(crate) exact: bool,
    /// Settings for developers of the planner, such as `fuse=off,alias=pool`
    #[arg(long, value_name = "SETTINGS", value_parser = parse_settings, hide = true, help_heading = Resettable::Reset)]
    plan: Option<PlanSettings>,
}

impl PlanOptions {
    /// The options of the planner.
    pub(crate) fn options(&self) -> Options {
        Options { exact: self.exact, ..self.plan.unwrap_or_default().options }
    }

    /// Returns whether point passes are draws instead of dispatches on every device.
    pub(crate) fn draws(&self) -> bool {
        self.plan.unwrap_or_default().draws
    }

    /// Returns whether one image has the tables of colors that it would have in a sequence.
    pub(crate) fn bakes_stills(&self) -> bool {
        self.plan.unwrap_or_default().bakes_stills
    }
}

/// The settings of `--plan`.
#[derive(Clone, Copy, Debug, Default)]
struct PlanSettings {
    options: Options,
    draws: bool,
    bakes_stills: bool,
}

/// Settings with commas between them.
fn parse_settings(text: &str) -> Result<PlanSettings, String> {
    let PlanSettings { mut options, mut draws, mut bakes_stills } = PlanSettings::default();
    for setting in text.split(',') {
        match setting {
            "alias=none" => options.alias = Alias::None,
            "alias=pool" => options.alias = Alias::Pool,
            "bake=still" => bakes_stills = true,
            "batches=fewest" => options.batches_first = true,
            "batches=serial" => options.serial = true,
            "bounds_checks=on" => options.bounds_checks = true,
            "draws=on" => draws = true,
            "fuse=off" => options.fuse = false,
            "row_downsample=off" => options.row_downsample = When::Never,
            _ => {
                let size = setting.strip_prefix("bake=").and_then(Bake::named);
                options.bake = Some(size.ok_or(
                    "known are alias=none or pool, bake=Off, Auto, 33, 48, 64 or still, batches=fewest or serial, \
                     bounds_checks=on, draws=on, fuse=off, row_downsample=off",
                )?);
            }
        }
    }
    Ok(PlanSettings { options, draws, bakes_stills })
}

/// Options of every command that runs on a GPU.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = MACHINE)]
pub(crate) struct DeviceOptions {
    /// Part of the name of the graphics adapter to use; `NAME#2` is the second of equal ones
    #[arg(long, value_name = "NAME", env = "AFTERIMAGE_ADAPTER")]
    pub(crate) adapter: Option<String>,
    /// End with status 2 rather than render on the processor
    #[arg(long, env = "AFTERIMAGE_REQUIRE_GPU", value_parser = FalseyValueParser::new())]
    pub(crate) require_gpu: bool,
    /// Memory that the images of a frame may take, such as `2G`; by default three quarters of a card's memory,
    /// or half of the system's. `render` makes larger pictures in bands, with the same pixels
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes, env = "AFTERIMAGE_GPU_MEMORY")]
    pub(crate) gpu_memory: Option<Budget>,
}

/// Options of every command that reads images.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = MACHINE)]
pub(crate) struct ImageOptions {
    /// Memory that decoding one image may take, such as `512M` or `4G`; a quarter of the machine's memory by default.
    /// `render` reads larger EXR images in bands, whose rows take no more
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes, env = "AFTERIMAGE_MEMORY")]
    memory: Option<Budget>,
}

impl ImageOptions {
    pub(crate) fn budget(&self) -> Budget {
        self.memory.unwrap_or_else(default_budget)
    }
}

/// `512M`, `4G`, `4GiB` or `1000000`.
fn parse_bytes(text: &str) -> Result<Budget, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let shift = match text[digits.len()..].to_ascii_uppercase().trim_end_matches("IB") {
        "" => Some(0),
        "K" => Some(10),
        "M" => Some(20),
        "G" => Some(30),
        "T" => Some(40),
        _ => None,
    };
    let number: Option<u64> = digits.trim().parse().ok().filter(|number| *number > 0);
    let bytes = number.zip(shift).and_then(|(number, shift)| number.checked_mul(1 << shift));
    bytes.map(Budget).ok_or_else(|| "a size of memory is a whole number with `K`, `M`, `G` or `T`, such as 512M".into())
}

/// A folder that exists.
fn parse_folder(text: &str) -> Result<PathBuf, String> {
    let path = Path::new(text);
    match path.metadata() {
        Ok(meta) if meta.is_dir() => Ok(path.to_owned()),
        Ok(_) => Err("this is no folder".into()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Err("there is no such folder".into()),
        Err(error) => Err(error.to_string()),
    }
}

/// `1920x1080`.
pub(crate) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parts =
        text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    match parts {
        Some((width @ 1.., height @ 1..)) => Ok((width, height)),
        _ => Err("a size is two whole numbers from 1, such as 1920x1080".into()),
    }
}

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crop {
    /// The first column and row.
    pub(crate) corner: (u32, u32),
    /// Columns and rows.
    pub(crate) size: (u32, u32),
}

/// `100,50,640x360`.
pub(crate) fn parse_crop(text: &str) -> Result<Crop, String> {
    part(text).ok_or_else(|| "a part is its corner and its size, such as 100,50,640x360".into())
}

fn part(text: &str) -> Option<Crop> {
    let (x, rest) = text.split_once(',')?;
    let (y, size) = rest.split_once(',')?;
    let corner = (x.trim().parse().ok()?, y.trim().parse().ok()?);
    Some(Crop { corner, size: parse_size(size).ok()? })
}

/// Frames per second, above 0 and finite.
pub(crate) fn parse_fps(text: &str) -> Result<f32, String> {
    let fps = text.parse().ok().filter(|fps: &f32| fps.is_normal() && *fps > 0.0);
    fps.ok_or_else(|| "frames per second are a number above 0, such as 24 or 23.976".into())
}

/// `0.5` or `25%`: above 0, and 1 at most.
pub(crate) fn parse_scale(text: &str) -> Result<f64, String> {
    let (number, whole) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 100.0));
    let share = number.trim().parse().ok().map(|number: f64| number / whole);
    share
        .filter(|share| *share > 0.0 && *share <= 1.0)
        .ok_or_else(|| "a share of the size is above 0 and at most 1, such as 0.5 or 25%".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_size_are_numbers_or_percentages() {
        assert_eq!(
            ["0.5", "25%", "1", "100 %"].map(|text| parse_scale(text).ok()),
            [Some(0.5), Some(0.25), Some(1.0), Some(1.0)]
        );
        for text in ["", "0", "%", "-0.5", "1.5", "150%", "NaN", "inf"] {
            assert!(parse_scale(text).is_err(), "{text}");
        }
    }

    #[test]
    fn parts_are_a_corner_and_a_size() {
        assert_eq!(parse_crop("3, 4,5x6"), Ok(Crop { corner: (3, 4), size: (5, 6) }));
        for text in ["", "3,4", "3,4,5", "3,4,0x6", "-3,4,5x6", "5x6"] {
            assert!(parse_crop(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_columns_and_rows() {
        let sizes = ["1920x1080", "1920X1080", "1920×1080", " 1920 x 1080 "].map(|text| parse_size(text).ok());
        assert_eq!(sizes, [Some((1920, 1080)); 4]);
        for text in ["", "x", "3", "0x3", "3x0", "-3x3", "3.5x3", "3x3x3", "4294967296x1"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        assert_eq!(["24", "23.976", "0.5"].map(|text| parse_fps(text).ok()), [Some(24.0), Some(23.976), Some(0.5)]);
    }

    /// Each setting changes its own field, and none that is not named.
    #[test]
    fn settings_of_the_planner_are_those_that_are_named() {
        let plain = format!("{:?}", PlanSettings::default());
        let all = "alias=none,alias=pool,bake=still,bake=33,batches=fewest,batches=serial,bounds_checks=on,draws=on,\
                   fuse=off,row_downsample=off";
        let shown = |text: &str| format!("{:?}", parse_settings(text).expect("it is known"));
        let alone: std::collections::BTreeSet<String> = all.split(',').map(shown).collect();
        assert!(alone.len() == 10 && !alone.contains(&plain), "{alone:?}");
        let both = parse_settings("draws=on,fuse=off").expect("they are known");
        assert!(both.draws && !both.options.fuse && !both.options.serial && !both.bakes_stills);
        assert!(["", "fuse=on", "bake=34", "serial"].iter().all(|text| parse_settings(text).is_err()));
    }

    #[test]
    fn sizes_of_memory_have_binary_units() {
        let bytes = |text| parse_bytes(text).map(|budget| budget.0).ok();
        assert_eq!(bytes("4G"), Some(4 << 30));
        assert_eq!(bytes("4GiB"), Some(4 << 30));
        assert_eq!(bytes("512m"), Some(512 << 20));
        assert_eq!(bytes("1000"), Some(1000));
        for text in ["", "G", "0", "-1G", "1.5G", "1x", "1GB", "99999999T", "1iB4"] {
            assert_eq!(bytes(text), None, "{text}");
        }
    }
}
