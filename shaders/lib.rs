//! The WGSL text that ships with Afterimage, as data.

include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// The text of the file of a built-in kind, by its stem.
///
/// # Panics
/// Where there is no such file: a name in Rust that fits no file is an error of ours, found when the crate is compiled in a constant.
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
