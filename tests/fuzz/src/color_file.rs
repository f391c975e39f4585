//! Color files: refused with a message, or evaluated to finite numbers.

use afterimage_color::lut::{Interpolation, LutError, PngLayout, parse_correction};
use afterimage_color::lut_file::{LutFile, parse_lut_file};
use afterimage_color::process::Process;

/// Colors at which functions are undefined, overflow or bend.
const COLORS: [[f64; 3]; 4] = [[0.0, 1.0, 0.18], [-1.0, -0.0, 65504.0], [-65504.0, 1e-30, 0.5], [1e-7, 2.0, -0.01]];

/// True if the text is a color file.
pub(crate) fn survives(text: &str) -> bool {
    let correction = checked(text, parse_correction(text, "")).map(Process::from);
    let file = checked(text, parse_lut_file(text.as_bytes(), PngLayout::Tiles)).map(|file| match file {
        LutFile::Process(process) => process,
        LutFile::Table(lut) => Process::of_table(&lut, Interpolation::Tetrahedral),
    });
    let processes = [correction, file];
    processes.iter().flatten().for_each(stays_finite);
    processes.iter().any(Option::is_some)
}

fn checked<T>(text: &str, parsed: Result<T, LutError>) -> Option<T> {
    parsed
        .inspect_err(|error| {
            assert!(!error.message.is_empty());
            assert!(error.line <= text.split(['\n', '\r']).count(), "{error}");
        })
        .ok()
}

fn stays_finite(process: &Process) {
    for color in COLORS {
        let result = process.apply(color);
        assert!(result.iter().all(|value| value.is_finite()), "{color:?} becomes {result:?}");
    }
}
