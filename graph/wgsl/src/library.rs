//! Files of WGSL, and libraries of files that others import by name.

use std::sync::OnceLock;

use afterimage_base::Shared;

use crate::error::ShaderError;
use crate::module::Module;

/// One file of WGSL; it is parsed once.
#[derive(Debug)]
pub(crate) struct SourceFile {
    name: Shared<str>,
    text: Shared<str>,
    untrusted: bool,
    has_workgroups: bool,
    module: OnceLock<Result<Module, ShaderError>>,
}

impl SourceFile {
    pub(crate) const fn new(name: Shared<str>, text: Shared<str>) -> Self {
        Self { name, text, untrusted: false, has_workgroups: false, module: OnceLock::new() }
    }

    /// A file that is not trusted.
    pub(crate) fn untrusted(name: Shared<str>, text: Shared<str>) -> Self {
        Self { untrusted: true, ..Self::new(name, text) }
    }

    pub(crate) fn is_untrusted(&self) -> bool {
        self.untrusted
    }

    /// Returns whether functions of the file and of those that it imports may share memory of a workgroup, although it
    /// is not trusted.
    pub(crate) fn has_workgroups(&self) -> bool {
        self.has_workgroups
    }

    pub(crate) fn permit_workgroups(&mut self) {
        self.has_workgroups = true;
    }

    /// The name that errors show.
    pub(crate) fn name(&self) -> &Shared<str> {
        &self.name
    }

    pub(crate) fn text(&self) -> &Shared<str> {
        &self.text
    }

    pub(crate) fn module(&self) -> Result<&Module, ShaderError> {
        let parse = if self.untrusted { Module::parse_untrusted } else { Module::parse };
        let module = self.module.get_or_init(|| parse(&self.name, &self.text));
        module.as_ref().map_err(Clone::clone)
    }

    /// Name for `#import`: the file's name without folders and ending.
    pub(crate) fn stem(&self) -> &str {
        let name = self.name.rsplit(['/', '\\']).next().unwrap_or(&self.name);
        name.strip_suffix(".wgsl").unwrap_or(name)
    }
}

/// Files that `#import` finds, by their names without folders and ending.
///
/// A node crate has one as a constant ([`Library::new`]), a folder of files has one at run time
/// ([`Library::of_files`]). A file of a library may import others of it and those of the framework's library.
#[derive(Debug)]
pub struct Library {
    built_in: &'static [(&'static str, &'static str)],
    files: OnceLock<Vec<SourceFile>>,
}

impl Library {
    /// A library of texts in the program: the name and the text of each file.
    pub const fn new(files: &'static [(&'static str, &'static str)]) -> Self {
        Self { built_in: files, files: OnceLock::new() }
    }

    /// A library of untrusted files: the path and the text of each.
    pub fn of_files(files: impl IntoIterator<Item = (String, String)>) -> Self {
        let file = |(name, text): (String, String)| SourceFile::untrusted(name.into(), text.into());
        Self { built_in: &[], files: OnceLock::from(files.into_iter().map(file).collect::<Vec<_>>()) }
    }

    fn files(&self) -> &[SourceFile] {
        let file = |(stem, text): &(&'static str, &'static str)| {
            let name = if stem.ends_with(".wgsl") { (*stem).into() } else { format!("{stem}.wgsl").into() };
            SourceFile::new(name, (*text).into())
        };
        self.files.get_or_init(|| self.built_in.iter().map(file).collect())
    }

    pub(crate) fn file(&self, name: &str) -> Option<&SourceFile> {
        self.files().iter().find(|file| file.stem() == name)
    }

    /// Returns whether the file is one of these.
    pub(crate) fn holds(&self, file: &SourceFile) -> bool {
        self.files().iter().any(|own| std::ptr::eq(own, file))
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.files().iter().map(SourceFile::stem)
    }
}

/// The library that every file may import.
pub(crate) static FRAMEWORK: Library = Library::new(afterimage_shaders::LIBRARY);

/// A library that a file brings.
#[derive(Debug, Default)]
pub(crate) enum ImportedName {
    #[default]
    Nothing,
    Static(&'static Library),
    Owned(Box<Library>),
}

/// A file with the library that it brings.
#[derive(Debug)]
pub struct Source {
    pub(crate) file: SourceFile,
    pub(crate) brought: ImportedName,
}

impl Source {
    pub(crate) fn library(&self) -> Option<&Library> {
        match &self.brought {
            ImportedName::Nothing => None,
            ImportedName::Static(library) => Some(library),
            ImportedName::Owned(library) => Some(library),
        }
    }

    /// Returns whether both bring the same files.
    pub(crate) fn has_library_of(&self, other: &Self) -> bool {
        let texts = |source: &Self| -> Vec<(String, String)> {
            let files = source.library().map_or(&[][..], Library::files);
            files.iter().map(|file| (file.name.to_string(), file.text.to_string())).collect()
        };
        match (&self.brought, &other.brought) {
            (ImportedName::Nothing, ImportedName::Nothing) => true,
            (ImportedName::Static(own), ImportedName::Static(other)) => std::ptr::eq(*own, *other),
            _ => texts(self) == texts(other),
        }
    }
}
