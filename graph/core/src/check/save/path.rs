//! Paths in files of other folders.

use crate::check::files::join;

/// A path that a file names, joined to the folder of the file; no path stays none.
pub(super) fn join_written(file: &str, path: &str) -> String {
    if path.is_empty() { String::new() } else { join(file, path) }
}

/// A joined path as a file names it. A path that the file cannot reach stays as it is.
pub(super) fn relative(file: &str, joined: &str) -> String {
    let is_absolute = joined.starts_with(['/', '\\']) || joined.get(1..2) == Some(":");
    let file = join("", file);
    if joined.is_empty() || is_absolute && !file.starts_with('/') {
        return joined.to_owned();
    }
    let mut folder: Vec<&str> = file.split('/').collect();
    folder.pop();
    let parts: Vec<&str> = joined.split('/').collect();
    let shared = folder.iter().zip(&parts).take_while(|(a, b)| a == b).count();
    let up = &folder[shared..];
    if up.contains(&"..") || up.contains(&"") {
        return joined.to_owned();
    }
    up.iter().map(|_| "..").chain(parts[shared..].iter().copied()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::{join_written, relative};

    #[test]
    fn a_relative_path_joins_to_the_path() {
        for (file, joined, written) in [
            ("a.ron", "b.cube", "b.cube"),
            ("a.ron", "looks/b.cube", "looks/b.cube"),
            ("x/a.ron", "x/b.cube", "b.cube"),
            ("x/a.ron", "b.cube", "../b.cube"),
            ("x/y/a.ron", "x/z/b.cube", "../z/b.cube"),
            ("./x/a.ron", "x/b.cube", "b.cube"),
            ("../x/a.ron", "../y/b.cube", "../y/b.cube"),
            ("/x/a.ron", "/x/b.cube", "b.cube"),
            ("/x/a.ron", "/b.cube", "../b.cube"),
            ("x/a.ron", "/b.cube", "/b.cube"),
            ("x/a.ron", "c:/b.cube", "c:/b.cube"),
            ("x/a.ron", "", ""),
        ] {
            assert_eq!(relative(file, joined), written, "`{joined}` in `{file}`");
            assert_eq!(join_written(file, written), joined, "`{written}` in `{file}`");
        }
    }

    #[test]
    fn a_path_that_cannot_be_reached_stays() {
        assert_eq!(relative("../x/a.ron", "b.cube"), "b.cube");
    }
}
