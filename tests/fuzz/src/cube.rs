//! Tables: refused at a line, or whole and finite.

use afterimage_color::lut::{Table, parse_cube};

/// True if the text is a table.
pub(crate) fn survives(text: &str) -> bool {
    match parse_cube(text) {
        Ok(lut) => {
            assert!(lut.curve.is_some() || lut.cube.is_some());
            lut.curve.iter().for_each(|curve| holds(curve, curve.size));
            lut.cube.iter().for_each(|cube| holds(cube, cube.size.pow(3)));
            assert!(lut.tolerance.is_finite() && lut.tolerance >= 0.0);
            let _ = lut.is_identity();
            true
        }
        Err(error) => {
            assert!(!error.message.is_empty());
            assert!((1..=text.split(['\n', '\r']).count()).contains(&error.line), "{error}");
            false
        }
    }
}

fn holds(table: &Table, entries: usize) {
    assert!(table.size >= 2);
    assert_eq!(table.entries.len(), entries);
    assert!(table.entries.as_flattened().iter().all(|entry| entry.is_finite()));
    assert!((0..3).all(|c| table.low[c].is_finite() && table.high[c].is_finite() && table.low[c] < table.high[c]));
}
