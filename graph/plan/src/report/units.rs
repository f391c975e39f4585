//! Numbers for people.

/// Bytes in MiB with one digit; small numbers with three.
pub(super) fn mebibytes(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if bytes == 0 || mebibytes >= 0.1 { format!("{mebibytes:.1} MiB") } else { format!("{mebibytes:.3} MiB") }
}

/// A number of things, with the plural where it is due.
pub(super) fn count(number: usize, one: &str) -> String {
    let plural = match one {
        _ if number == 1 => "",
        one if one.ends_with('s') || one.ends_with("ch") => "es",
        _ => "s",
    };
    format!("{number} {one}{plural}")
}
