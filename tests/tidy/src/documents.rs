//! What documents link to and name, compared with the repository.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::workspace::{Workspace, files_in, read};

/// Names in documents that are no names of this repository: of examples, of other programs, of files.
const FOREIGN: [&str; 15] = [
    "IndexedRange",
    "a_black_frame_keeps_the_exposure",
    "depth_left",
    "draw_shadows",
    "forward_left",
    "g22_rec709_scene",
    "g24_rec709_scene",
    "hlg_rec2020_display",
    "my_nodes",
    "new_crate",
    "pq_p3d65_display",
    "pq_rec2020_display",
    "rgba_left",
    "srgb_p3d65_scene",
    "srgb_rec709_scene",
];

/// Folders of the repository with documents and code. Others hold builds.
const FOLDERS: [&str; 6] = [".github", "graph", "nodes", "pipelines", "shaders", "tests"];

/// The Markdown files of the repository.
pub fn all(workspace: &Workspace) -> Vec<PathBuf> {
    let mut files = in_folders(workspace, &["md"]);
    files.push(workspace.root.join("README.md"));
    files
}

/// Links of a document to files and headings that do not exist, a sentence each.
pub fn broken_links(workspace: &Workspace, document: &Path) -> Vec<String> {
    let text = without_blocks(&read(document));
    let folder = document.parent().expect("a document lies in a folder");
    let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
    let mut found = Vec::new();
    for link in links.filter(|link| !link.contains("://")) {
        let (path, heading) = link.split_once('#').unwrap_or((link, ""));
        let target = if path.is_empty() { document.to_owned() } else { folder.join(path) };
        let has_heading = || heading.is_empty() || headings(&read(&target)).iter().any(|known| known == heading);
        if !target.exists() || !has_heading() {
            found.push(format!("{}: `{link}` leads nowhere", workspace.short(document).display()));
        }
    }
    found
}

/// Names in the code of a document that no other file of the repository has, a sentence each. A name has an underscore,
/// or a capital letter behind a small one.
pub fn unknown_names(workspace: &Workspace, document: &Path, known: &BTreeSet<String>) -> Vec<String> {
    let text = read(document);
    let blocks = text.split("```").skip(1).step_by(2);
    let prose = without_blocks(&text);
    let spans = prose.split('`').skip(1).step_by(2);
    let names: BTreeSet<&str> = blocks.chain(spans).flat_map(words).filter(|name| is_name(name)).collect();
    let unknown = names.into_iter().filter(|name| !known.contains(*name) && !FOREIGN.contains(name));
    unknown.map(|name| format!("{}: nothing is called `{name}`", workspace.short(document).display())).collect()
}

/// The words of all code, pipelines and scripts.
pub fn words_of_code(workspace: &Workspace) -> BTreeSet<String> {
    let mut files = in_folders(workspace, &["rs", "wgsl", "ron", "toml", "sh", "py", "html", "js", "json", "txt"]);
    files.retain(|file| !file.ends_with("tidy/src/documents.rs"));
    files.iter().flat_map(|file| words(&read(file)).map(str::to_owned).collect::<Vec<_>>()).collect()
}

fn in_folders(workspace: &Workspace, extensions: &[&str]) -> Vec<PathBuf> {
    let in_builds = |file: &PathBuf| file.components().any(|part| part.as_os_str() == "target");
    let folders = FOLDERS.iter().flat_map(|folder| files_in(&workspace.root.join(folder), extensions));
    folders.filter(|file| !in_builds(file)).collect()
}

/// The text without its code blocks.
fn without_blocks(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// The anchors of a document's headings, as GitHub makes them.
fn headings(text: &str) -> Vec<String> {
    let text = without_blocks(text);
    let heads = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| {
        let kept = line.trim_start_matches(['#', ' ']).to_lowercase();
        kept.chars().filter(|c| c.is_alphanumeric() || "_- ".contains(*c)).collect::<String>().replace(' ', "-")
    };
    heads.map(anchor).collect()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|character: char| !character.is_alphanumeric() && character != '_').filter(|word| !word.is_empty())
}

fn is_name(word: &str) -> bool {
    let mut pairs = word.chars().zip(word.chars().skip(1));
    word.contains('_') || pairs.any(|(first, second)| first.is_lowercase() && second.is_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_an_underscore_or_a_capital_inside() {
        let names: Vec<&str> =
            words("pass.is_zero(port), ToneMap(curve: AgX) Scene rgb").filter(|w| is_name(w)).collect();
        assert_eq!(names, ["is_zero", "ToneMap", "AgX"]);
    }

    #[test]
    fn headings_become_anchors() {
        let text = "# A file\n```sh\n# no heading\n```\n## `Taa` over time: 2\n";
        assert_eq!(headings(text), ["a-file", "taa-over-time-2"]);
    }

    #[test]
    fn what_does_not_exist_is_found() {
        let folder = std::env::temp_dir().join(format!("afterimage-documents-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("the folder can be made");
        let file = folder.join("a.md");
        let text = "# One\n[a](#one) [b](#two) [c](a.md#one) [d](b.md) [e](https://x.org/y) `my_value` `OtherName`\n";
        std::fs::write(&file, text).expect("the file can be written");
        let workspace = Workspace { root: folder.clone(), crates: Vec::new() };
        assert_eq!(broken_links(&workspace, &file), ["a.md: `#two` leads nowhere", "a.md: `b.md` leads nowhere"]);
        let known = BTreeSet::from(["my_value".to_owned()]);
        assert_eq!(unknown_names(&workspace, &file, &known), ["a.md: nothing is called `OtherName`"]);
        std::fs::remove_dir_all(folder).expect("the folder can be removed");
    }
}
