//! `afterimage pipelines`: the built-in pipelines.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::Loader;
use afterimage_graph::diagnostic::{shown, shown_path};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_lab::shell_word;
use afterimage_media::write_new;
use afterimage_pipelines::{BuiltIn, PIPELINES};

use crate::args::PipelinesArgs;
use crate::built_in::hint;
use crate::failure::Failure;
use crate::files::FileLoader;
use crate::pipeline::PipelineFile;
use crate::terminal::{note, say, say_text};

pub(crate) fn run(args: &PipelinesArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let Some(name) = &args.name else {
        let width = PIPELINES.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, text) in PIPELINES {
            say(&format!("{name:width$}  {}", caption(text)));
        }
        return Ok(());
    };
    let name = name.trim_end_matches(".ron");
    let (_, text) = PIPELINES.iter().find(|(known, _)| *known == name).ok_or_else(|| unknown(name))?;
    match &args.write {
        Some(file) => write(name, text, file, tables),
        None => {
            say_text(text);
            Ok(())
        }
    }
}

/// The pipeline of `new`.
const TEMPLATE: &str = include_str!("scaffold/look.ron");

/// Writes a new pipeline from the template, and tells what to do with it.
pub(crate) fn new(file: &Path) -> Result<(), Failure> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let path = shown_path(file);
    write_with_files(file, &TEMPLATE.replace("NAME", &shown(&name)).replace("FILE", &path), &[])?;
    say(&path);
    for line in ["check FILE", "render FILE scene.exr -o out.png", "view FILE scene.exr"] {
        note(&format!("  afterimage {}", line.replace("FILE", &shell_word(&path))));
    }
    Ok(())
}

/// The error for a name that no built-in pipeline has.
fn unknown(name: &str) -> Failure {
    Failure::user(format!("there is no built-in pipeline `{name}`")).hint(hint(name))
}

/// The first paragraph of the comment at the head of a pipeline.
pub(crate) fn caption(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix("//")).map(str::trim);
    let lines: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
    lines.join(" ")
}

/// Writes a built-in pipeline, and the files that it names next to it.
fn write(name: &str, text: &str, file: &Path, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = Registry::new(tables).map_err(Failure::user)?;
    let document = parse(&format!("{name}.ron"), text)?;
    let loader = RecordingBuiltIn::default();
    PipelineFile::new(&document, &registry, &loader).check(&Default::default())?;
    write_with_files(file, text, &loader.0.into_inner().into_iter().collect::<Vec<_>>())
}

/// Writes a new pipeline, and the files that it names next to it: all of them or none. What is there is not replaced.
pub(crate) fn write_with_files(file: &Path, text: &str, named: &[(String, Arc<[u8]>)]) -> Result<(), Failure> {
    if file.extension().is_some_and(|ending| ending != "ron") {
        return Err(Failure::user(format!("`{}` is no name of a pipeline", file.display())).hint("it ends in `.ron`"));
    }
    let own = file.file_name().ok_or_else(|| Failure::user(format!("`{}` is no name of a file", file.display())))?;
    let mut files = vec![(PathBuf::from(own), text.as_bytes().to_vec())];
    files.extend(named.iter().map(|(name, bytes)| (name.into(), bytes.to_vec())));
    let folder = file.parent().unwrap_or(Path::new(""));
    let are_new = write_new(folder, &files)?;
    for ((name, _), _) in files.iter().zip(are_new).skip(1).filter(|(_, is_new)| *is_new) {
        note(&format!("note: `{}`, which it uses, is beside it", folder.join(name).display()));
    }
    Ok(())
}

/// Records the files that a built-in pipeline names.
#[derive(Default)]
struct RecordingBuiltIn(RefCell<BTreeMap<String, Arc<[u8]>>>);

impl Loader for RecordingBuiltIn {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let bytes = BuiltIn.load(path)?;
        self.0.borrow_mut().insert(path.to_owned(), bytes.clone());
        Ok(bytes)
    }
}

impl FileLoader for RecordingBuiltIn {
    fn name(&self, _: &str) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_a_caption() {
        for (name, text) in PIPELINES {
            let caption = caption(text);
            assert!(caption.len() > 20 && caption.ends_with(['.', ':']), "{name}: {caption}");
        }
    }
}
