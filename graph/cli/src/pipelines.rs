//! `afterimage pipelines`: the built-in pipelines.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use afterimage_graph::check::Loader;
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_media::write_atomic;
use afterimage_pipelines::{BuiltIn, PIPELINES};

use crate::args::PipelinesArgs;
use crate::built_in::hint;
use crate::failure::Failure;
use crate::pipeline::PipelineFile;
use crate::run_files::RunFiles;
use crate::terminal::{note, say};

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
            say(text);
            Ok(())
        }
    }
}

/// The error for a name that no built-in pipeline has.
fn unknown(name: &str) -> Failure {
    Failure::user(format!("there is no built-in pipeline `{name}`")).hint(hint(name))
}

/// The first paragraph of the comment at the head of a pipeline.
fn caption(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix("//")).map(str::trim);
    let lines: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
    lines.join(" ")
}

/// Writes a pipeline, and the files that it names next to it, unless they are there.
fn write(name: &str, text: &str, file: &Path, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = Registry::new(tables).map_err(Failure::user)?;
    let document = parse(&format!("{name}.ron"), text)?;
    let loader = RecordingBuiltIn::default();
    PipelineFile::new(&document, &registry, &loader).check(&Default::default())?;
    let run = RunFiles::default();
    run.writes(file)?;
    write_atomic(file, text.as_bytes())?;
    write_beside(file, &loader.0.into_inner().into_iter().collect::<Vec<_>>(), &run)
}

/// Writes the files that a built-in pipeline names next to its file, unless they are there.
pub(crate) fn write_beside(file: &Path, named: &[(String, Arc<[u8]>)], run: &RunFiles) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(Path::new(""));
    for (name, bytes) in named {
        let beside = folder.join(name);
        if beside.exists() {
            continue;
        }
        if let Some(folder) = beside.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)
                .map_err(|error| Failure::machine(format!("cannot make the folder `{}`: {error}", folder.display())))?;
        }
        run.writes(&beside)?;
        write_atomic(&beside, bytes)?;
        note(&format!("note: `{}`, which it uses, is beside it", beside.display()));
    }
    Ok(())
}

/// Notes the files that a built-in pipeline names.
#[derive(Default)]
struct RecordingBuiltIn(RefCell<BTreeMap<String, Arc<[u8]>>>);

impl Loader for RecordingBuiltIn {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let bytes = BuiltIn.load(path)?;
        self.0.borrow_mut().insert(path.to_owned(), bytes.clone());
        Ok(bytes)
    }
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
