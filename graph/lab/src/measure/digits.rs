//! Numbers as people read them.

/// Three significant digits; small numbers have four decimal places.
pub(crate) fn significant(number: f64) -> String {
    match number.abs() {
        0.0 => "0".into(),
        n if n < 0.00005 => "<0.0001".into(),
        n if n < 1.0 => format!("{number:.4}"),
        n if n < 10.0 => format!("{number:.3}"),
        n if n < 100.0 => format!("{number:.2}"),
        n if n < 1000.0 => format!("{number:.1}"),
        _ => format!("{number:.0}"),
    }
}
