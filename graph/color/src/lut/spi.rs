//! `.spi1d` and `.spi3d` files of Sony Pictures Imageworks.

use super::text::{lines, numbers, short};
use super::{Lut, LutError, MAX_CUBE, MAX_CURVE, Table, entry};

/// Parses a `.spi1d` file: a 1-D table of one to three components over the domain `From`. One component counts for
/// every channel.
///
/// # Errors
/// The first error: an unknown or missing keyword, a length outside of 2 to 65536, a domain that is empty, numbers that
/// cannot be parsed or exceed half floats, too few or too many entries.
pub fn parse_spi1d(text: &str) -> Result<Lut, LutError> {
    let mut header = Header::default();
    let mut rest = lines(text);
    for (number, line) in rest.by_ref() {
        if line == "{" {
            break;
        }
        header.keyword(number, line)?;
    }
    let Header { domain, length, components } = header;
    let (Some(length), Some(components)) = (length, components) else {
        return Err(LutError::new(header_end(text), "`Length` and `Components` must stand before `{`"));
    };
    let mut entries = Vec::with_capacity(length);
    let mut last = 0;
    for (number, line) in rest.take_while(|(_, line)| *line != "}") {
        last = number;
        if entries.len() == length {
            return Err(LutError::new(number, format!("there are more than the {length} entries of the table")));
        }
        entries.push(components.read(number, line)?);
    }
    if entries.len() < length {
        return Err(LutError::new(last, format!("the table ends after {} of {length} entries", entries.len())));
    }
    let [low, high] = domain.map(|bound| [bound; 3]);
    let table = Table { size: length, entries, low, high };
    Ok(Lut { curve: Some(table), cube: None, tolerance: 1e-6 })
}

/// The line at which the header of a file ends.
fn header_end(text: &str) -> usize {
    lines(text).find(|(_, line)| *line == "{").or_else(|| lines(text).last()).map_or(1, |(number, _)| number)
}

/// How many numbers an entry has.
#[derive(Clone, Copy)]
enum Components {
    One,
    Two,
    Three,
}

impl Components {
    fn read(self, number: usize, line: &str) -> Result<[f32; 3], LutError> {
        let values = match self {
            Self::One => [numbers::<1>(number, line, "an entry")?[0]; 3],
            Self::Two => {
                let [red, green] = numbers(number, line, "an entry")?;
                [red, green, 0.0]
            }
            Self::Three => numbers(number, line, "an entry")?,
        };
        entry(number, values)
    }
}

struct Header {
    domain: [f32; 2],
    length: Option<usize>,
    components: Option<Components>,
}

impl Default for Header {
    fn default() -> Self {
        Self { domain: [0.0, 1.0], length: None, components: None }
    }
}

impl Header {
    fn keyword(&mut self, number: usize, line: &str) -> Result<(), LutError> {
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match keyword {
            "Version" if rest == "1" => {}
            "Version" => return Err(LutError::new(number, format!("the version is 1, not `{}`", short(rest)))),
            "From" => self.domain = domain(number, rest)?,
            "Length" => self.length = Some(length(number, rest, MAX_CURVE)?),
            "Components" => self.components = Some(components(number, rest)?),
            _ => {
                let known = "`Version`, `From`, `Length` and `Components`";
                let message = format!("`{}` is no keyword of a .spi1d file; there are {known}", short(keyword));
                return Err(LutError::new(number, message));
            }
        }
        Ok(())
    }
}

fn domain(number: usize, text: &str) -> Result<[f32; 2], LutError> {
    let [low, high] = numbers(number, text, "`From`")?;
    match high > low && (high - low).is_finite() {
        true => Ok([low, high]),
        false => Err(LutError::new(number, "the domain must end above its beginning")),
    }
}

fn length(number: usize, text: &str, most: usize) -> Result<usize, LutError> {
    let length = text.parse::<usize>().ok().filter(|length| (2..=most).contains(length));
    length.ok_or_else(|| {
        LutError::new(number, format!("the length must be a whole number from 2 to {most}, not `{}`", short(text)))
    })
}

fn components(number: usize, text: &str) -> Result<Components, LutError> {
    match text {
        "1" => Ok(Components::One),
        "2" => Ok(Components::Two),
        "3" => Ok(Components::Three),
        _ => Err(LutError::new(number, format!("the number of components is 1, 2 or 3, not `{}`", short(text)))),
    }
}

/// Parses a `.spi3d` file: a 3-D table over 0 to 1. Each entry states its place.
///
/// # Errors
/// The first error: another header, a side outside of 2 to 256 or sides that differ, numbers that cannot be parsed or
/// exceed half floats, an entry outside of the table, twice or missing.
pub fn parse_spi3d(text: &str) -> Result<Lut, LutError> {
    let mut lines = lines(text);
    let mut next = |what: &str| lines.next().ok_or_else(|| LutError::new(1, format!("the file ends before {what}")));
    let (number, first) = next("its first line")?;
    if !first.starts_with("SPILUT") {
        return Err(LutError::new(number, format!("the first line is `SPILUT 1.0`, not `{}`", short(first))));
    }
    let (number, components) = next("the numbers of components")?;
    if components.split_ascii_whitespace().ne(["3", "3"]) {
        return Err(LutError::new(number, format!("the components are `3 3`, not `{}`", short(components))));
    }
    let (number, sides) = next("the sides of the table")?;
    let size = side(number, sides)?;
    // A short file with a large side is refused before the table is allocated.
    let (found, last) = lines.clone().fold((0, number), |(found, _), (number, _)| (found + 1, number));
    if found < size.pow(3) {
        return Err(LutError::new(last, format!("the file ends after {found} of {} entries", size.pow(3))));
    }
    let mut table = vec![None; size.pow(3)];
    for (number, line) in lines {
        place(&mut table, size, number, line)?;
    }
    // As many entries as places, and none twice: every place has one.
    let entries = table.into_iter().map(Option::unwrap_or_default).collect();
    let cube = Table { size, entries, low: [0.0; 3], high: [1.0; 3] };
    Ok(Lut { curve: None, cube: Some(cube), tolerance: 1e-6 })
}

fn side(number: usize, text: &str) -> Result<usize, LutError> {
    let sides: Vec<&str> = text.split_ascii_whitespace().collect();
    match sides.as_slice() {
        [red, green, blue] if red == green && green == blue => length(number, red, MAX_CUBE),
        _ => Err(LutError::new(number, format!("the table has three equal sides, not `{}`", short(text)))),
    }
}

/// Puts the entry of a line into the table. Red varies fastest in the table.
fn place(table: &mut [Option<[f32; 3]>], size: usize, number: usize, line: &str) -> Result<(), LutError> {
    let [r, g, b, values @ ..]: [f32; 6] = numbers(number, line, "an entry")?;
    let inside = |x: f32| (x >= 0.0 && x < size as f32 && x.fract() == 0.0).then_some(x as usize);
    let (Some(r), Some(g), Some(b)) = (inside(r), inside(g), inside(b)) else {
        return Err(LutError::new(number, format!("a place in the table is three whole numbers below {size}")));
    };
    match table[r + size * (g + size * b)].replace(entry(number, values)?) {
        None => Ok(()),
        Some(_) => Err(LutError::new(number, format!("the entry {r} {g} {b} is there twice"))),
    }
}
