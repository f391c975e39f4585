//! Look-ups in tables in double precision.

use glam::DVec3;
use half::f16;

use crate::lut::{Interpolation, Table};

/// The lower entry around a position in a table, and the distance to it.
fn cell(table: &Table, channel: usize, x: f64) -> (usize, f64) {
    let low = f64::from(table.low[channel]);
    let place = ((x - low) * table.scale()[channel]).clamp(0.0, 1.0) * (table.size - 1) as f64;
    let index = (place.floor() as usize).min(table.size - 2);
    (index, place - index as f64)
}

fn between(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// A channel of a 1-D table, linear between the entries.
pub(super) fn curve(table: &Table, channel: usize, x: f64) -> f64 {
    let (index, t) = cell(table, channel, x);
    let entry = |index: usize| f64::from(table.entries[index][channel]);
    between(entry(index), entry(index + 1), t)
}

/// The code of the largest half float.
const MAX_CODE: usize = 0x7bff;

/// A channel of a table with one entry per code of a half float, linear between the two nearest halves.
pub(super) fn half_curve(entries: &[[f32; 3]], channel: usize, x: f64) -> f64 {
    let magnitude = x.abs().min(f64::from(f16::MAX));
    let nearest = f16::from_f64(magnitude);
    // The half at or below the magnitude.
    let code = usize::from(nearest.to_bits()) - usize::from(nearest.to_f64() > magnitude);
    let next = (code + 1).min(MAX_CODE);
    let value = |code: usize| f16::from_bits(code as u16).to_f64();
    let t = if next == code { 0.0 } else { (magnitude - value(code)) / (value(next) - value(code)) };
    let sign = if x < 0.0 { 0x8000 } else { 0 };
    let entry = |code: usize| f64::from(entries[sign + code][channel]);
    between(entry(code), entry(next), t)
}

pub(super) fn cube(table: &Table, interpolation: Interpolation, v: DVec3) -> DVec3 {
    let cells = [0, 1, 2].map(|channel| cell(table, channel, v[channel]));
    match interpolation {
        Interpolation::Trilinear => trilinear(table, cells),
        Interpolation::Tetrahedral => tetrahedral(table, cells),
    }
}

fn entry(table: &Table, [r, g, b]: [usize; 3]) -> DVec3 {
    let [r, g, b] = table.entries[r + table.size * (g + table.size * b)].map(f64::from);
    DVec3::new(r, g, b)
}

fn trilinear(table: &Table, cells: [(usize, f64); 3]) -> DVec3 {
    (0..8).fold(DVec3::ZERO, |sum, corner| {
        let far = [0, 1, 2].map(|axis| corner >> axis & 1);
        let weight = |axis: usize| if far[axis] == 1 { cells[axis].1 } else { 1.0 - cells[axis].1 };
        sum + entry(table, [0, 1, 2].map(|axis| cells[axis].0 + far[axis])) * weight(0) * weight(1) * weight(2)
    })
}

/// From the lowest corner of the cell along the axis of the largest distance, then of the middle one, then of the
/// smallest.
fn tetrahedral(table: &Table, cells: [(usize, f64); 3]) -> DVec3 {
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| cells[*b].1.total_cmp(&cells[*a].1));
    let distances = axes.map(|axis| cells[axis].1);
    let mut corner = cells.map(|(index, _)| index);
    let mut sum = entry(table, corner) * (1.0 - distances[0]);
    for (step, axis) in axes.into_iter().enumerate() {
        corner[axis] += 1;
        sum += entry(table, corner) * (distances[step] - distances.get(step + 1).unwrap_or(&0.0));
    }
    sum
}
