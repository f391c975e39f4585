//! The device of a command, and the planner's options on it.

use afterimage_gpu::{Gpu, Opening};
use afterimage_lab::bench::Gain;
use afterimage_plan::Options;

use crate::args::{ArithmeticOptions, DeviceOptions};
use crate::cache;
use crate::failure::Failure;
use crate::terminal::note;

/// Opens the device that the command line names.
pub(crate) fn open(options: &DeviceOptions) -> Result<Gpu, Failure> {
    let mut gpu = Gpu::open(&Opening { adapter: options.adapter.clone(), validation: false })?;
    // Without a calibration: on lavapipe whole pipelines are a third faster with draws, which single passes do not
    // show.
    let drawn = cache::calibration(&gpu).map_or(gpu.is_processor(), |calibration| calibration.prefers_fragment());
    gpu.caps.prefer_fragment = options.fragment || drawn;
    Ok(gpu)
}

/// The planner's options on this device. Options that the command line does not set are on if a calibration found
/// them to be faster. Prints a note for each requested option without effect.
pub(crate) fn options_on(gpu: &Gpu, requested: Options, arithmetic: &ArithmeticOptions) -> Options {
    let calibration = cache::calibration(gpu).unwrap_or_default();
    let pays = |gain: Option<Gain>| gain.is_some_and(Gain::pays);
    let half = pays(calibration.half) && !requested.exact;
    let calibrated = Options { half, subgroups: pays(calibration.subgroups), ..requested };
    let (options, ignored) = arithmetic.over(calibrated).granted(&gpu.caps);
    ignored.iter().for_each(|ignored| note(&format!("note: `--{}` has no effect: {}", ignored.switch, ignored.why)));
    options
}
