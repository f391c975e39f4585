//! A pipeline in a file, with the files that it names.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage::host::LIBRARY;
use afterimage_graph::check::{Loader as _, Saver};
use afterimage_graph::diagnostic::{Diagnostics, shown};
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_media::{FileWatch, rewrite};
use afterimage_view::{Checked, NamedFile, Project, Wake};

use crate::args::KindOptions;
use crate::failure::Failure;
use crate::files::{Files, registry, text, with_own};
use crate::pipelines::write_with_files;
use crate::watch::RecordingLoader;

/// A pipeline in a file.
pub(super) struct FileProject {
    path: PathBuf,
    options: KindOptions,
    kinds: Vec<NodeKind>,
    /// The kinds as they were when their files changed last. Kinds that are read again are others to a plan.
    registry: Option<Registry>,
    files: FileWatch,
    /// The files that the first write makes beside a pipeline that is no file yet.
    new: Option<Vec<NamedFile>>,
}

impl FileProject {
    pub(super) fn new(path: PathBuf, options: KindOptions, kinds: Vec<NodeKind>, wake: &Wake) -> Self {
        let wake = wake.clone();
        let mut files = FileWatch::new(move || wake.call());
        let KindOptions { nodes, .. } = with_own(&options, Some(&path));
        let libraries = nodes.iter().map(|folder| folder.join("..").join(LIBRARY));
        files.extend(nodes.iter().cloned().chain(libraries).chain([path.clone()]));
        Self { path, options, kinds, registry: None, files, new: None }
    }

    /// The same for a file that is made by the first write, with those that the pipeline names.
    pub(super) fn new_file(self, named: Vec<NamedFile>) -> Result<Self, String> {
        if self.path.extension().is_none_or(|ending| ending != "ron") {
            return Err("the name of a pipeline ends in `.ron`".into());
        }
        if self.path.symlink_metadata().is_ok() {
            return Err(format!("`{}` exists already: choose another name", self.path.display()));
        }
        Ok(Self { new: Some(named), ..self })
    }

    /// Reads the kinds again if one of their files has changed.
    fn forget(&mut self, changed: &BTreeSet<PathBuf>) {
        let is_shader = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "wgsl" || ending == "wesl");
        let is_of_a_kind = |path: &PathBuf| path.ends_with("node.ron") || is_shader(path);
        if changed.iter().any(is_of_a_kind) {
            self.registry = None;
        }
    }

    fn read_kinds(&self) -> Result<Registry, Failure> {
        registry(&[&self.kinds], &self.options, Some(&self.path))
    }

    /// The files that the pipeline may name. The viewer saves the pipeline alone, which replaces none of them.
    fn files_of_pipeline(&self) -> Files {
        Files::of(&self.path, &self.options)
    }

    fn checked(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Failure> {
        let registry = match self.registry.take() {
            Some(known) => known,
            None => self.read_kinds()?,
        };
        let loader = RecordingLoader::new(self.files_of_pipeline());
        let checked = Checked::of(&self.path.to_string_lossy(), text, tier, &registry, &loader);
        // While the file has errors, the files that it named before may be the ones to be corrected.
        self.files.extend(loader.named());
        self.registry = Some(registry);
        Ok(checked?)
    }
}

impl Project for FileProject {
    fn name(&self) -> String {
        shown(&self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy()).into_owned()
    }

    fn read(&mut self) -> Result<Option<String>, Diagnostics> {
        if matches!(self.path.metadata(), Err(error) if error.kind() == ErrorKind::NotFound) {
            return Ok(None);
        }
        text(&self.path, "pipeline").map(Some).map_err(Failure::into_diagnostics)
    }

    fn check(&mut self, text: &str, tier: Option<&str>) -> Result<Checked, Diagnostics> {
        self.checked(text, tier).map_err(Failure::into_diagnostics)
    }

    fn has_changed(&mut self) -> bool {
        let changed = self.files.changed();
        self.forget(&changed);
        !changed.is_empty()
    }

    fn with_saver(&self, text: &str, ask: &mut dyn FnMut(&Saver<'_>)) -> Result<(), Diagnostics> {
        // Kinds are read once, and not for each question.
        let read = self.registry.is_none().then(|| self.read_kinds()).transpose().map_err(Failure::into_diagnostics)?;
        let files = self.files_of_pipeline();
        for registry in self.registry.iter().chain(&read) {
            ask(&Saver::new(&self.path.to_string_lossy(), text, registry, &files)?);
        }
        Ok(())
    }

    fn file(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.files_of_pipeline().load(&folder.join(path).to_string_lossy())
    }

    fn has_place(&self) -> bool {
        true
    }

    fn path(&self) -> Option<&Path> {
        self.new.is_none().then_some(&self.path)
    }

    fn write(&mut self, text: &str) -> Result<String, String> {
        match &self.new {
            Some(named) => write_with_files(&self.path, text, named).map_err(|failure| failure.message())?,
            None => rewrite(&self.path, text.as_bytes()).map_err(|error| error.to_string())?,
        }
        self.new = None;
        // What is written here is known already.
        let changed = self.files.look();
        self.forget(&changed);
        Ok(std::path::absolute(&self.path).unwrap_or_else(|_| self.path.clone()).display().to_string())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use std::fs;

    use super::*;

    fn at(path: &Path) -> FileProject {
        FileProject::new(path.to_owned(), KindOptions::default(), Vec::new(), &Wake::default())
    }

    #[test]
    fn a_new_file_replaces_none_and_lies_beside_those_that_it_names() {
        let folder = std::env::temp_dir().join(format!("afterimage-new-file-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("mine.ron");
        assert_eq!(at(&path).read().unwrap(), None, "nothing is there");
        let named = || vec![("looks/dusk.cube".to_owned(), Arc::from(&b"a table"[..]))];
        let mut project = at(&path).new_file(named()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(project.name(), "mine.ron");
        assert!(project.write("a pipeline").unwrap().ends_with("mine.ron"));
        assert_eq!(project.read().unwrap().as_deref(), Some("a pipeline"));
        assert_eq!(fs::read(folder.join("looks/dusk.cube")).unwrap(), b"a table");
        for (taken, why) in
            [("mine.ron", "exists already"), ("mine.txt", "ends in `.ron`"), ("looks", "ends in `.ron`")]
        {
            let refused = at(&folder.join(taken)).new_file(named()).err().unwrap();
            assert!(refused.contains(why), "{refused}");
        }
        // Later writes replace the project's own file.
        project.write("another text").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "another text");
        fs::remove_dir_all(&folder).unwrap();
    }

    /// Kinds lie beside the pipeline, and their shaders change while it is shown.
    #[test]
    fn kinds_beside_the_pipeline_are_known_and_read_again() {
        let folder = std::env::temp_dir().join(format!("afterimage-own-kinds-{}", std::process::id()));
        fs::create_dir_all(folder.join("twice")).unwrap();
        let node = r#"Kind(name: "Twice", doc: "Doubles.", inputs: { "source": Image(doc: "Light.", accepts: [Scene]) },
            outputs: { "result": Image(doc: "Light.", state: Same("source")) })"#;
        let shader = |body: &str| {
            let text = format!("fn twice(source: vec4f) -> vec4f {{ {body} }}\n");
            fs::write(folder.join("twice/twice.wgsl"), text).unwrap();
        };
        fs::write(folder.join("twice/node.ron"), node).unwrap();
        shader("return 2.0 * source;");
        let path = folder.join("mine.ron");
        let text = r#"Pipeline(inputs: { "in": Color }, nodes: { "a": Twice(source: "in") }, outputs: { "out": "a" })"#;
        fs::write(&path, text).unwrap();
        let mut project = at(&path);
        let checked = project.check(text, None).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(checked.graph.nodes[0].kind().name(), "Twice");
        shader("return nothing;");
        project.forget(&[folder.join("twice/twice.wgsl")].into());
        let errors = project.check(text, None).err().expect("the shader is read again").to_string();
        assert!(errors.contains("nothing") && errors.contains("twice.wgsl:1"), "{errors}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
