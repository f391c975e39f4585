//! Look-up tables and color corrections as data, and the files that contain them.

pub(crate) mod cdl_file;
mod cube;
mod picture;
mod table_image;
pub(crate) mod text;
mod write;
pub(crate) mod xml;

use afterimage_graph::prelude::*;
use half::f16;

pub use cdl_file::{ColorCorrection, parse_correction};
pub use cube::parse_cube;
pub use picture::{PngLayout, parse_png};
pub use table_image::TableImage;
pub use write::{WrittenFormat, WrittenLut};

/// Maximum row length of a 1-D table's texture, in texels. Longer tables take several rows.
pub(crate) const ROW: usize = 4096;

/// Maximum number of entries per side of a 3-D table.
pub(crate) const MAX_CUBE: usize = 256;

/// Maximum number of entries of a 1-D table.
pub(crate) const MAX_CURVE: usize = 65536;

/// The largest half float. Entries are limited to it.
pub(crate) const LARGEST: f32 = 65504.0;

/// The content of a table's file: one table or, in some `.cube` files, a 1-D table before a 3-D table.
#[derive(Clone, Debug, PartialEq)]
pub struct Lut {
    /// One curve per channel.
    pub curve: Option<Table>,
    /// A table over colors. Red varies fastest.
    pub cube: Option<Table>,
    /// Half of the step in which the file's numbers are written. Smaller differences are rounding errors.
    pub tolerance: f32,
}

choices! {
    /// The interpolation of a 3-D table.
    pub enum Interpolation {
        /// Between the four corners of a tetrahedron, as grading programs do: grays stay gray and gradients stay
        /// linear.
        Tetrahedral,
        /// Between the eight corners of a cell.
        Trilinear,
    }
}

/// Entries at equal steps over a domain.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Number of entries per side.
    pub size: usize,
    /// The entries: `size` of a curve, `size` cubed of a cube.
    pub entries: Vec<[f32; 3]>,
    /// The input of the first entry.
    pub low: [f32; 3],
    /// The input of the last entry.
    pub high: [f32; 3],
}

/// An error in the file of a look-up table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LutError {
    /// The line, from 1. 0 where a file has no lines.
    pub line: usize,
    /// The error, and how to correct it.
    pub message: String,
}

impl LutError {
    pub fn new(line: usize, message: impl Into<String>) -> Self {
        Self { line, message: message.into() }
    }
}

impl std::fmt::Display for LutError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            0 => f.write_str(&self.message),
            line => write!(f, "line {line}: {}", self.message),
        }
    }
}

impl std::error::Error for LutError {}

impl Lut {
    /// A 3-D table from a function of the indices along red, green and blue.
    pub fn of(size: usize, entry: impl Fn([usize; 3]) -> [f32; 3]) -> Self {
        let steps = |i: usize| [i % size, i / size % size, i / size / size];
        let entries = (0..size * size * size).map(|i| entry(steps(i))).collect();
        let cube = Table { size, entries, low: [0.0; 3], high: [1.0; 3] };
        Self { curve: None, cube: Some(cube), tolerance: 1e-6 }
    }

    /// The identity.
    pub fn identity() -> Self {
        Self::of(2, |steps| steps.map(|step| step as f32))
    }

    /// True if the table changes nothing within its domain, up to the rounding of the file.
    pub fn is_identity(&self) -> bool {
        let flat = |table: &Option<Table>| table.as_ref().is_none_or(|table| table.is_identity(self.tolerance));
        flat(&self.curve) && flat(&self.cube)
    }

    /// The identity over the domain of this one, from the ends of the domain alone: without the rounding of the file.
    pub fn ends(&self) -> Self {
        let cube = self.cube.as_ref().map(|table| {
            let entry = |index: usize| std::array::from_fn(|channel| table.end(channel, index >> channel & 1));
            Table { size: 2, entries: (0..8).map(entry).collect(), ..*table }
        });
        let curve = self.curve.as_ref().map(|table| {
            let entry = |index: usize| std::array::from_fn(|channel| table.end(channel, index));
            Table { size: 2, entries: (0..2).map(entry).collect(), ..*table }
        });
        Self { curve, cube, tolerance: self.tolerance }
    }
}

impl Table {
    fn is_identity(&self, tolerance: f32) -> bool {
        let is_cube = self.entries.len() > self.size;
        self.entries.iter().enumerate().all(|(index, entry)| {
            let steps = if is_cube { [index, index / self.size, index / self.size / self.size] } else { [index; 3] };
            (0..3).all(|channel| (entry[channel] - self.input(channel, steps[channel] % self.size)).abs() <= tolerance)
        })
    }

    /// The input of an entry along one channel.
    fn input(&self, channel: usize, step: usize) -> f32 {
        let share = step as f64 / (self.size - 1) as f64;
        let (low, high) = (f64::from(self.low[channel]), f64::from(self.high[channel]));
        (low + share * (high - low)) as f32
    }

    /// The first or the last input along one channel.
    fn end(&self, channel: usize, index: usize) -> f32 {
        if index == 0 { self.low[channel] } else { self.high[channel] }
    }

    /// The reciprocal of the domain's size, per channel.
    pub fn scale(&self) -> [f64; 3] {
        std::array::from_fn(|channel| 1.0 / (f64::from(self.high[channel]) - f64::from(self.low[channel])))
    }

    /// The texels, in half floats or 32 bits, padded with black to `count`.
    pub fn bytes(&self, half: bool, count: usize) -> Vec<u8> {
        texels(&self.entries, count, half)
    }
}

/// Entries as texels, in half floats or 32 bits, padded with black to `count`.
fn texels(entries: &[[f32; 3]], count: usize, half: bool) -> Vec<u8> {
    let padding = std::iter::repeat_n(&[0.0; 3], count - entries.len());
    let channels = entries.iter().chain(padding).flat_map(|[r, g, b]| [*r, *g, *b, 1.0]);
    let finite = channels.map(|x| x.clamp(-LARGEST, LARGEST));
    if half {
        finite.flat_map(|x| f16::from_f32(x).to_le_bytes()).collect()
    } else {
        finite.flat_map(f32::to_le_bytes).collect()
    }
}
