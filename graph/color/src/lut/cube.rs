//! `.cube` files (Adobe 2013, and Resolve's form with a 1-D table before a 3-D table).

use super::text::{Line, lines, numbers, read, short};
use super::{Lut, LutError, MAX_CUBE, MAX_CURVE, Table};

/// Parses a `.cube` file. Red varies fastest in a 3-D table.
///
/// # Errors
/// The first error: an unknown keyword, a size outside of 2 to 256 (65536 for a 1-D table), numbers that cannot be
/// parsed or are not finite, an empty domain, too few or too many entries.
pub fn parse_cube(text: &str) -> Result<Lut, LutError> {
    let mut reader = Reader::default();
    let mut last = 1;
    for (number, line) in lines(text) {
        last = number;
        match read(number, line)? {
            Line::Keyword(keyword, rest) => reader.keyword(number, keyword, rest)?,
            Line::Entry(entry) => reader.entry(number, entry)?,
        }
    }
    reader.finish(last)
}

/// One bound of a domain, and its line in the file.
#[derive(Clone, Copy)]
struct Bound([f32; 3], usize);

#[derive(Default)]
struct Reader {
    curve_size: Option<usize>,
    cube_size: Option<usize>,
    low: Option<Bound>,
    high: Option<Bound>,
    curve_range: Option<[Bound; 2]>,
    cube_range: Option<[Bound; 2]>,
    entries: Vec<[f32; 3]>,
}

impl Reader {
    fn keyword(&mut self, number: usize, keyword: &str, rest: &str) -> Result<(), LutError> {
        if !self.entries.is_empty() {
            return Err(LutError::new(
                number,
                format!("`{}` comes after the first entry: keywords go before", short(keyword)),
            ));
        }
        match keyword {
            "TITLE" => Ok(()),
            "LUT_1D_SIZE" => once(&mut self.curve_size, number, keyword, size(number, rest, MAX_CURVE)?),
            "LUT_3D_SIZE" => once(&mut self.cube_size, number, keyword, size(number, rest, MAX_CUBE)?),
            "DOMAIN_MIN" => once(&mut self.low, number, keyword, Bound(numbers(number, rest, keyword)?, number)),
            "DOMAIN_MAX" => once(&mut self.high, number, keyword, Bound(numbers(number, rest, keyword)?, number)),
            "LUT_1D_INPUT_RANGE" => once(&mut self.curve_range, number, keyword, range(number, keyword, rest)?),
            "LUT_3D_INPUT_RANGE" => once(&mut self.cube_range, number, keyword, range(number, keyword, rest)?),
            _ => Err(LutError::new(number, unknown(keyword))),
        }
    }

    fn entry(&mut self, number: usize, entry: [f32; 3]) -> Result<(), LutError> {
        if self.curve_size.is_none() && self.cube_size.is_none() {
            return Err(LutError::new(number, "an entry comes before `LUT_3D_SIZE` or `LUT_1D_SIZE`"));
        }
        if self.entries.len() == self.expected() {
            return Err(LutError::new(
                number,
                format!("there are more than the {} entries of the table", self.expected()),
            ));
        }
        self.entries.push(entry);
        Ok(())
    }

    fn expected(&self) -> usize {
        self.curve_size.unwrap_or(0) + self.cube_size.map_or(0, |size| size.pow(3))
    }

    fn finish(mut self, last: usize) -> Result<Lut, LutError> {
        if self.expected() == 0 {
            return Err(LutError::new(last, "neither `LUT_3D_SIZE` nor `LUT_1D_SIZE` is there"));
        }
        let (found, expected) = (self.entries.len(), self.expected());
        if found < expected {
            return Err(LutError::new(last, format!("the file ends after {found} of {expected} entries")));
        }
        let [curve_domain, cube_domain] = [self.domain(self.curve_range)?, self.domain(self.cube_range)?];
        let cube_entries = self.entries.split_off(self.curve_size.unwrap_or(0));
        let table = |size, entries, [low, high]: [[f32; 3]; 2]| Table { size, entries, low, high };
        Ok(Lut {
            curve: self.curve_size.map(|size| table(size, self.entries, curve_domain)),
            cube: self.cube_size.map(|size| table(size, cube_entries, cube_domain)),
            tolerance: 1e-6,
        })
    }

    /// The domain of a table: its own range, else that of the file, else 0 to 1.
    fn domain(&self, range: Option<[Bound; 2]>) -> Result<[[f32; 3]; 2], LutError> {
        let [low, high] =
            range.unwrap_or([self.low.unwrap_or(Bound([0.0; 3], 1)), self.high.unwrap_or(Bound([1.0; 3], 1))]);
        let extends =
            (0..3).all(|channel| high.0[channel] > low.0[channel] && (high.0[channel] - low.0[channel]).is_finite());
        match extends {
            true => Ok([low.0, high.0]),
            false => Err(LutError::new(low.1.max(high.1), "the domain must end above its beginning in every channel")),
        }
    }
}

fn once<T>(slot: &mut Option<T>, number: usize, keyword: &str, value: T) -> Result<(), LutError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(LutError::new(number, format!("`{keyword}` is there twice"))),
    }
}

fn size(number: usize, text: &str, most: usize) -> Result<usize, LutError> {
    let size = text.parse::<usize>().ok().filter(|size| (2..=most).contains(size));
    size.ok_or_else(|| {
        LutError::new(number, format!("the size must be a whole number from 2 to {most}, not `{}`", short(text)))
    })
}

fn range(number: usize, keyword: &str, text: &str) -> Result<[Bound; 2], LutError> {
    let [low, high] = numbers(number, text, keyword)?;
    Ok([Bound([low; 3], number), Bound([high; 3], number)])
}

fn unknown(keyword: &str) -> String {
    let sizes = "`TITLE`, `LUT_1D_SIZE`, `LUT_3D_SIZE`, `DOMAIN_MIN`, `DOMAIN_MAX`";
    let known = format!("{sizes}, `LUT_1D_INPUT_RANGE` and `LUT_3D_INPUT_RANGE`");
    format!("`{}` is no keyword of a .cube file; there are {known}", short(keyword))
}
