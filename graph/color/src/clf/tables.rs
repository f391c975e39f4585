//! Process nodes that are tables.

use half::f16;
use roxmltree::Node;

use super::depth::only;
use crate::lut::text::short;
use crate::lut::xml::{self, attribute, error, fill, number};
use crate::lut::{Interpolation, LARGEST, LutError, MAX_CUBE, MAX_CURVE, Table};
use crate::process::Step;

/// The number of codes of a half float.
const HALF_CODES: usize = 65536;

/// A 1-D table. `scale` is the number that stands for 1 in its entries.
pub(super) fn curve(node: Node<'_, '_>, scale: f64) -> Result<Step, LutError> {
    if let Some(map) = xml::element(node, &["IndexMap"])? {
        return Err(error(map, "version 3 has no `IndexMap`: write a `Range` before the `LUT1D`"));
    }
    only(node, &["interpolation", "halfDomain", "rawHalfs"], &["Array"])?;
    if let Some(other) = node.attribute("interpolation").filter(|name| *name != "linear") {
        return Err(error(node, format!("a 1-D table is interpolated `linear`, not `{}`", short(other))));
    }
    let (is_half, raw) = (flag(node, "halfDomain")?, flag(node, "rawHalfs")?);
    let array = xml::required(node, &["Array"])?;
    let (size, components) = curve_dim(array)?;
    if is_half && size != HALF_CODES {
        return Err(error(array, format!("a table with `halfDomain` has {HALF_CODES} entries, not {size}")));
    }
    let mut entries: Vec<[f32; 3]> = Vec::new();
    fill(array, size * components, |index, word| {
        let place = index / components;
        let value = if raw { half_code(word)? } else { number_or_infinity(word, is_half, place)? };
        if index % components == 0 {
            entries.push([0.0; 3]);
        }
        let value = stored(value / if raw { 1.0 } else { scale }, is_half)?;
        let channels = if components == 1 { 0..3 } else { index % 3..index % 3 + 1 };
        entries[place][channels].fill(value);
        Ok(())
    })?;
    Ok(match is_half {
        true => Step::HalfCurve(entries),
        false => Step::Curve(Table { size, entries, low: [0.0; 3], high: [1.0; 3] }),
    })
}

fn flag(node: Node<'_, '_>, key: &str) -> Result<bool, LutError> {
    match node.attribute(key) {
        None => Ok(false),
        Some("true") => Ok(true),
        Some(other) => Err(error(node, format!("`{key}` is `true` or not there, not `{}`", short(other)))),
    }
}

fn curve_dim(array: Node<'_, '_>) -> Result<(usize, usize), LutError> {
    let dim = attribute(array, "dim")?;
    let numbers: Vec<Option<usize>> = dim.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
    match numbers.as_slice() {
        [Some(size), Some(components @ (1 | 3))] if (2..=MAX_CURVE).contains(size) => Ok((*size, *components)),
        _ => {
            let expected = format!("`N 1` or `N 3`, with N from 2 to {MAX_CURVE}");
            Err(error(array, format!("`dim` of a 1-D table is {expected}, not `{}`", short(dim))))
        }
    }
}

/// The half float of a code.
fn half_code(word: &str) -> Result<f64, String> {
    let code = word.parse::<u16>().map_err(|_| format!("`{}` is no code of a half float", short(word)))?;
    let value = f16::from_bits(code).to_f64();
    if value.is_nan() { Err(format!("`{}` is the code of a NaN", short(word))) } else { Ok(value) }
}

/// A number. A table with an entry for each half float may contain infinities, and anything at the codes that are not
/// finite, which are never read.
fn number_or_infinity(word: &str, is_half: bool, place: usize) -> Result<f64, String> {
    let is_read = f16::from_bits(place as u16).is_finite();
    match word.parse::<f64>() {
        Ok(x) if is_half && x.is_infinite() => Ok(x),
        Ok(_) if is_half && !is_read => Ok(0.0),
        _ => number(word),
    }
}

/// An entry. Infinities of half floats become the largest half float.
fn stored(value: f64, is_half: bool) -> Result<f32, String> {
    let limit = f64::from(LARGEST);
    match value.abs() <= limit {
        true => Ok(value as f32),
        false if is_half || value.is_infinite() => Ok(value.clamp(-limit, limit) as f32),
        false => Err(format!("the entry {value:e} is beyond {LARGEST}, the largest half float")),
    }
}

/// A 3-D table. In the file blue varies fastest.
pub(super) fn cube(node: Node<'_, '_>, scale: f64) -> Result<Step, LutError> {
    if let Some(map) = xml::element(node, &["IndexMap"])? {
        return Err(error(map, "version 3 has no `IndexMap`: write a `Range` before the `LUT3D`"));
    }
    only(node, &["interpolation"], &["Array"])?;
    let interpolation = match node.attribute("interpolation") {
        None | Some("trilinear") => Interpolation::Trilinear,
        Some("tetrahedral") => Interpolation::Tetrahedral,
        Some(other) => {
            let known = "`trilinear` or `tetrahedral`";
            return Err(error(node, format!("a 3-D table is interpolated {known}, not `{}`", short(other))));
        }
    };
    let array = xml::required(node, &["Array"])?;
    let size = cube_dim(array)?;
    let mut numbers: Vec<f32> = Vec::new();
    fill(array, 3 * size.pow(3), |_, word| {
        numbers.push(stored(number(word)? / scale, false)?);
        Ok(())
    })?;
    let (entries, _) = numbers.as_chunks::<3>();
    let place = |index: usize| (index % size * size + index / size % size) * size + index / size / size;
    let entries = (0..size.pow(3)).map(|index| entries[place(index)]).collect();
    Ok(Step::Cube(Table { size, entries, low: [0.0; 3], high: [1.0; 3] }, interpolation))
}

fn cube_dim(array: Node<'_, '_>) -> Result<usize, LutError> {
    let dim = attribute(array, "dim")?;
    let numbers: Vec<Option<usize>> = dim.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
    match numbers.as_slice() {
        [Some(r), Some(g), Some(b), Some(3)] if r == g && g == b && (2..=MAX_CUBE).contains(r) => Ok(*r),
        _ => {
            let expected = format!("`N N N 3`, with N from 2 to {MAX_CUBE}");
            Err(error(array, format!("`dim` of a 3-D table is {expected}, not `{}`", short(dim))))
        }
    }
}
