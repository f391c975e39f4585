//! `afterimage nodes --new`: the files of a new node kind, which runs at once.

use std::path::{Path, PathBuf};

use afterimage_graph::node::{Registry, kind_file_name};
use afterimage_media::{real_path, write_new};

use crate::failure::Failure;

/// A file's path and its text, for a kind that is called `MyKind`.
type Template = (&'static str, &'static str);

const PIPELINE: Template = ("my_kind.ron", include_str!("scaffold/my_kind.ron"));

/// The shader of a kind, in a folder and in a crate.
const SHADER: &str = include_str!("scaffold/crate/src/my_kind.wgsl");

const FOLDER: [Template; 3] =
    [("node.ron", include_str!("scaffold/folder/node.ron")), ("my_kind.wgsl", SHADER), PIPELINE];

const CRATE: [Template; 6] = [
    ("Cargo.toml", include_str!("scaffold/crate/Cargo.toml.txt")),
    ("src/lib.rs", include_str!("scaffold/crate/src/lib.rs")),
    ("src/my_kind.wgsl", SHADER),
    ("tests/contract.rs", include_str!("scaffold/crate/tests/contract.rs")),
    ("examples/program.rs", include_str!("scaffold/crate/examples/program.rs")),
    PIPELINE,
];

/// Folders of the repository with the crates on which a crate depends.
const DEPENDENCIES: [&str; 4] = ["graph/core", "graph/plan", "graph/cli", "nodes"];

/// Names that a crate cannot have: words of Rust, and crates that every program has.
const WORDS_OF_RUST: [&str; 44] = [
    "abstract", "alloc", "as", "async", "await", "become", "box", "break", "const", "continue", "core", "crate", "do",
    "dyn", "else", "enum", "extern", "false", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro", "match",
    "mod", "move", "mut", "pub", "ref", "return", "static", "std", "struct", "test", "trait", "true", "try", "type",
    "use", "while",
];

/// Writes a folder with a kind of that name; returns what to do with it.
pub(crate) fn folder(name: &str, registry: &Registry) -> Result<String, Failure> {
    let file = checked(name, registry)?;
    write(&file, &FOLDER, &|text| renamed(text, name, &file))?;
    let run = format!("afterimage render {file}/{file}.ron -o {file}.png --size 640x360");
    let test = format!("afterimage stress --kind {name} --quick --nodes {file}");
    Ok(report(name, &file, &FOLDER, &[("Render it", &run), ("Test it", &test)]))
}

/// Writes a crate with a kind of that name; returns what to do with it. It depends on the crates of a repository, if
/// there is one, and else on packages of this version.
pub(crate) fn rust_crate(name: &str, registry: &Registry, repository: Option<&Path>) -> Result<String, Failure> {
    let file = checked(name, registry)?;
    if WORDS_OF_RUST.contains(&file.as_str()) {
        return Err(Failure::user(format!("a crate cannot be called `{file}`, which is a word of Rust")));
    }
    let repository = match repository {
        Some(given) if !is_repository(given) => {
            return Err(Failure::user(format!("`{}` is not the repository of Afterimage", given.display())));
        }
        Some(given) => Some(given.to_owned()),
        None => find_repository(),
    };
    let repository = repository.map(|path| real_path(&path)).transpose();
    let repository = repository.map_err(|error| Failure::unreadable(error.message))?;
    let source = |folder: &str| match &repository {
        Some(path) => format!("{{ path = \"{}/{folder}\" }}", path.to_string_lossy().replace('\\', "/")),
        None => concat!('"', env!("CARGO_PKG_VERSION"), '"').to_owned(),
    };
    write(&file, &CRATE, &|text| {
        let placeholder = |folder: &str| format!("\"REPOSITORY/{folder}\"");
        DEPENDENCIES.iter().fold(renamed(text, name, &file), |text, at| text.replace(&placeholder(at), &source(at)))
    })?;
    let run = format!("cd {file} && cargo run --example program -- render {file}.ron -o {file}.png --size 640x360");
    let test = format!("cd {file} && cargo test");
    Ok(report(name, &file, &CRATE, &[("Render it", &run), ("Test it", &test)]))
}

/// The name of the kind's files.
fn checked(name: &str, registry: &Registry) -> Result<String, Failure> {
    if let Some(kind) = registry.get(name) {
        return Err(Failure::user(format!("there is a kind `{}`", kind.name())).hint("choose another name"));
    }
    kind_file_name(name).map_err(|why| Failure::user(format!("no kind can be called `{name}`: {why}")))
}

fn renamed(text: &str, name: &str, file: &str) -> String {
    text.replace("MyKind", name).replace("my_kind", file)
}

/// Writes the files into a folder that must not exist, all of them or none.
fn write(file: &str, templates: &[Template], fill: &dyn Fn(&str) -> String) -> Result<(), Failure> {
    let folder = Path::new(file);
    if folder.symlink_metadata().is_ok() {
        return Err(
            Failure::user(format!("`{file}` exists, and nothing in it is replaced")).hint("choose another name")
        );
    }
    let mut files = Vec::new();
    for (path, text) in templates {
        files.push((folder.join(path.replace("my_kind", file)), fill(text).into_bytes()));
    }
    write_new(Path::new(""), &files)?;
    Ok(())
}

fn report(name: &str, file: &str, templates: &[Template], commands: &[(&str, &str)]) -> String {
    let files = templates.iter().map(|(path, _)| format!("  {file}/{}\n", path.replace("my_kind", file)));
    let commands = commands.iter().map(|(what, command)| format!("{what}:\n  {command}\n"));
    format!("The kind `{name}` is written:\n{}{}", files.collect::<String>(), commands.collect::<String>())
}

/// The repository in a folder above this one or above the program.
fn find_repository() -> Option<PathBuf> {
    let places = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    let above = |place: &PathBuf| place.ancestors().find(|folder| is_repository(folder)).map(Path::to_owned);
    places.iter().flatten().find_map(above)
}

fn is_repository(folder: &Path) -> bool {
    ["graph/cli/Cargo.toml", "graph/plan/Cargo.toml", "nodes/Cargo.toml"].iter().all(|file| folder.join(file).is_file())
}
