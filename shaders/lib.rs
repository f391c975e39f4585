//! The WGSL files of Afterimage as text: one per built-in node kind, and the shared library.

include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// The text of a built-in kind's file, by the name of the file without its ending.
///
/// # Panics
/// If there is no such file. In a constant this is a compile error.
pub const fn kind(stem: &str) -> &'static str {
    let mut index = 0;
    while index < KINDS.len() {
        if equal(KINDS[index].0.as_bytes(), stem.as_bytes()) {
            return KINDS[index].1;
        }
        index += 1;
    }
    panic!("no shader has this name")
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut index = 0;
    while index < a.len() && index < b.len() && a[index] == b[index] {
        index += 1;
    }
    index == a.len() && index == b.len()
}
