//! The arguments of `measure` and `tune`.

use std::path::PathBuf;

use afterimage_graph::diagnostic::quote;
use afterimage_lab::metrics::Display;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::headings::{INPUT_FILES, OUTPUT_FILES, SEQUENCES};
use super::options::{DeviceOptions, ImageOptions, PipelineOptions, parse_size};

/// The meaning of each figure, below the options. The terminal's width wraps the lines.
const FIGURES: &str = "\
The reference is the same pipeline with f32 intermediates and every quality switch at its most accurate. \
Each figure is the worst over the images; JSON also has the figures of each image. \
Errors of an encoded output are measured before dither and quantization.

time: the GPU time of a frame, at full clock frequency, as in `bench`; the median of the samples. \
On a processor, where timestamps cannot be trusted, the time on the host
MiB: the most bytes that transient images hold at once; moved: bytes that all passes of a frame read and write
max: the largest error of a channel, in 8-bit codes (PU21 codes for HDR outputs, 256 of them up to 100 cd/m2)
p99.9: the error that one pixel in a thousand exceeds, in codes
PSNR: in decibels
SSIM: structural similarity, 1 is equal
FLIP: the visible difference of alternating images, 0 to 1
JOD: what is seen of the whole sequence at `--fps` on the display, by ColorVideoVDP: 10 is no difference, and at 9 \
three of four people prefer the reference
dE2000: mean color difference (dE ITP for HDR outputs); 1 is just noticeable
flicker: the change between two frames that the reference does not have: 99.9th percentile, in codes

`--explain` makes each change of the variant on its own, in the frame with the largest p99.9 and there in the pixels \
around the largest error. The share of a change is the projection of its signed error on that of the variant, and \
codes is its largest. Shares and the remainder, which is what the changes do not add up to, are 100 % together. A \
negative share makes the error smaller";

/// The meaning of a claim, below the options of `tune`.
const CLAIMS: &str = "\
Claims state errors a tenth above the worst that was measured, because other images can be a little worse, at least \
0.05 codes, 0.003 of FLIP and 0.02 JOD worse, and name the image. The search sees every other image and six of the \
charts of `--charts`. What it finds is measured on all of them; if it is beyond the goal on one that was not seen, the \
search goes on.";

/// The images that a pipeline is measured on.
#[derive(Debug, Args)]
pub(crate) struct SequenceArgs {
    /// Images for the pipeline's first input, or folders of them; `shot.####.exr` is a sequence; without images, the
    /// built-in scene
    #[arg(value_name = "IN")]
    pub(crate) images: Vec<String>,
    /// The image for another input: `--input albedo=albedo.exr`
    #[arg(help_heading = INPUT_FILES, long = "input", value_name = "NAME=FILE")]
    pub(crate) inputs: Vec<String>,
    /// Also measure a walk through the built-in scene
    #[arg(long)]
    pub(crate) scene: bool,
    /// Also measure built-in pictures that break meters and halvings: lines, dots, suns of one pixel, charts, white,
    /// black, night; and sequences that break what is kept from frame to frame: lamps that are switched or move, a pan,
    /// cuts without notice
    #[arg(long)]
    pub(crate) charts: bool,
    /// Pixels of the built-in scene; can be repeated, and each size is measured
    #[arg(long = "size", value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) sizes: Vec<(u32, u32)>,
    /// Frames of the walk through the built-in scene, and of a still image in a pipeline that reads earlier images;
    /// with a meter or cached results alone a still has 2
    #[arg(long, value_name = "FRAMES", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) walk: u32,
    /// Frames of a sequence: `1-96`, `1-96x2`, `7,12-20`
    #[arg(help_heading = SEQUENCES, long, value_name = "RANGE")]
    pub(crate) frames: Option<String>,
    /// Frames per second, for adaptation over time, and of the video whose differences are seen
    #[arg(help_heading = SEQUENCES, long, default_value_t = 24.0)]
    pub(crate) fps: f32,
    /// The output to compare; by default the first encoded one, or the first
    #[arg(long, value_name = "NAME")]
    pub(crate) output: Option<String>,
    /// The display of the visible differences in JOD; by default `desk`, for HDR outputs `tv-hdr`
    #[arg(long, value_parser = displays())]
    pub(crate) display: Option<Display>,
    /// Samples of each time; 50 on a GPU and 7 on a processor by default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) repeats: Option<u32>,
    #[command(flatten)]
    pub(crate) decoding: ImageOptions,
    #[command(flatten)]
    pub(crate) options: PipelineOptions,
    #[command(flatten)]
    pub(crate) device: DeviceOptions,
}

#[derive(Debug, Args)]
#[command(after_help = FIGURES)]
pub(crate) struct MeasureArgs {
    /// The pipeline file
    pub(crate) pipeline: PathBuf,
    /// Measure the tiers only, not each switch
    #[arg(long)]
    pub(crate) tiers: bool,
    /// Write all figures as JSON
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write a chart of time against error, as `.svg`
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    /// Write images of the error of each variant: black below 1/16 of a code, red near 1, white from 64
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "DIR")]
    pub(crate) error_image: Option<PathBuf>,
    /// Find which changes make the worst error of this tier or variant; `--error-image` then also has pictures of it
    #[arg(long, value_name = "NAME")]
    pub(crate) explain: Option<String>,
    #[command(flatten)]
    pub(crate) sequences: SequenceArgs,
}

/// The limit that a tuned pipeline must keep.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct GoalArgs {
    /// The longest time of a frame, such as `0.8ms` or `800us`: searches the most accurate pipeline within it
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub(crate) budget: Option<f64>,
    /// The largest error to claim (99.9th percentile, in 8-bit codes): searches the fastest pipeline within it
    #[arg(long, value_name = "CODES", value_parser = parse_error)]
    pub(crate) error: Option<f64>,
    /// Searches all tiers with their names and largest errors, from the most accurate, on the images and on those of
    /// `--charts`, and leaves out tiers that are not a quarter cheaper than the one before
    #[arg(
        long,
        value_name = "NAME:CODES,...",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "ultra:0,high:1,medium:4,low:12",
        value_parser = parse_ladder
    )]
    pub(crate) tiers: Option<Ladder>,
}

#[derive(Debug, Args)]
#[command(after_help = CLAIMS)]
pub(crate) struct TuneArgs {
    /// The pipeline file
    pub(crate) pipeline: PathBuf,
    #[command(flatten)]
    pub(crate) goal: GoalArgs,
    /// Leave the charts of `--charts` out of `--tiers`; lamps, dots, lines and motion may exceed what is claimed
    #[arg(long, conflicts_with_all = ["charts", "budget", "error"])]
    pub(crate) no_charts: bool,
    /// The name of the tier
    #[arg(long, default_value = "tuned", conflicts_with = "tiers")]
    pub(crate) name: String,
    /// The file for the pipeline with the new tiers; by default standard output
    #[arg(help_heading = OUTPUT_FILES, short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// A file for the figures; a later run continues from it
    #[arg(help_heading = OUTPUT_FILES, long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) sequences: SequenceArgs,
}

/// Names of tiers and their largest errors, in codes; 0 is the most accurate choice.
#[derive(Clone, Debug)]
pub(crate) struct Ladder(pub(crate) Vec<(String, f64)>);

fn parse_ladder(text: &str) -> Result<Ladder, String> {
    let mut all: Vec<(String, f64)> = Vec::new();
    for part in text.split(',') {
        let (name, codes) = part.rsplit_once(':').ok_or("a tier is `NAME:CODES`, such as low:12")?;
        let codes = parse_error(codes)?;
        if all.iter().any(|(known, _)| known == name) {
            return Err(format!("two tiers are {}", quote(name)));
        }
        if all.last().is_some_and(|(_, before)| *before >= codes) {
            return Err(format!(
                "the most accurate tier comes first, and {} is not less accurate than the one before",
                quote(name)
            ));
        }
        all.push((name.to_owned(), codes));
    }
    Ok(Ladder(all))
}

fn displays() -> impl TypedValueParser<Value = Display> {
    let known = |name: &str| Display::ALL.into_iter().find(|display| display.name == name);
    PossibleValuesParser::new(Display::ALL.map(|display| PossibleValue::new(display.name).help(display.about)))
        .map(move |name| known(&name).expect("it is one of the names"))
}

/// Milliseconds of `0.8ms`, `800us` or `0.8`.
fn parse_time(text: &str) -> Result<f64, String> {
    let (number, unit) = match (text.strip_suffix("us").or(text.strip_suffix("µs")), text.strip_suffix("ms")) {
        (Some(number), _) => (number, 1e-3),
        (None, Some(number)) => (number, 1.0),
        (None, None) => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(time) if time.is_finite() && time > 0.0 => Ok(time * unit),
        _ => Err("a time is a number above 0 with `ms` or `us`, such as 0.8ms".into()),
    }
}

fn parse_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error.is_finite() && error >= 0.0 => Ok(error),
        _ => Err("an error is a number from 0, such as 0.5".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_milliseconds_and_errors_in_codes() {
        let times = ["0.8ms", "800us", "800 µs", "0.8", "2 ms"].map(|text| parse_time(text).ok());
        let near = |(found, wanted): (Option<f64>, f64)| found.is_some_and(|found| (found - wanted).abs() < 1e-12);
        assert!(times.into_iter().zip([0.8, 0.8, 0.8, 0.8, 2.0]).all(near), "{times:?}");
        for text in ["", "ms", "0", "0us", "-1ms", "1s", "inf", "NaNms"] {
            assert!(parse_time(text).is_err(), "{text}");
        }
        assert_eq!(["0", "0.5"].map(|text| parse_error(text).ok()), [Some(0.0), Some(0.5)]);
        assert!(["-0.1", "inf", "NaN", "1 code"].iter().all(|text| parse_error(text).is_err()));
    }
}
