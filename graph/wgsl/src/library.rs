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
    /// The path of the folder that it is in: what `super` means in it.
    folder: &'static str,
    untrusted: bool,
    has_workgroups: bool,
    module: OnceLock<Result<Module, ShaderError>>,
}

impl SourceFile {
    pub(crate) const fn new(name: Shared<str>, text: Shared<str>) -> Self {
        Self { name, text, folder: PACKAGE, untrusted: false, has_workgroups: false, module: OnceLock::new() }
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

    /// Returns whether both have the same text and import the same files if they bring the same library.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || (self.folder == other.folder && self.name == other.name && self.text == other.text)
    }

    /// A file in a folder of its package.
    fn in_folder(self, folder: &'static str) -> Self {
        Self { folder, ..self }
    }

    /// The file is that of a kind's folder, and other files of the folder are beside it.
    pub(crate) fn set_of_kind(&mut self) {
        self.folder = SUPER;
    }

    /// Returns whether the file is one of the framework's library.
    pub(crate) fn is_framework(&self) -> bool {
        self.folder == FRAMEWORK_PACKAGE
    }

    /// The library and the file that a path names, for an import in this file, which brings that library.
    pub(crate) fn find<'a>(
        &self,
        library: Option<&'a Library>,
        path: &[&str],
    ) -> Option<(&'a SourceFile, Option<&'a Library>)> {
        let (stem, folder) = path.split_last()?;
        let (first, rest) = folder.split_first()?;
        let package = if self.is_framework() { FRAMEWORK_PACKAGE } else { PACKAGE };
        let first = match *first {
            SUPER => self.folder,
            PACKAGE => package,
            first => first,
        };
        let is_of = |file: &&SourceFile| {
            file.stem() == *stem && first.split("::").chain(rest.iter().copied()).eq(file.folder.split("::"))
        };
        if first == FRAMEWORK_PACKAGE {
            return Some((FRAMEWORK.files().iter().find(is_of)?, None));
        }
        Some((library?.files().iter().find(is_of)?, library))
    }

    /// The last name of its path: the file's name without folders and ending.
    pub(crate) fn stem(&self) -> &str {
        let name = self.name.rsplit(['/', '\\']).next().unwrap_or(&self.name);
        name.strip_suffix(".wgsl").or_else(|| name.strip_suffix(".wesl")).unwrap_or(name)
    }
}

/// The first name of a path in the package of the file that imports, in the folder of that file, and in the framework's
/// library.
const PACKAGE: &str = "package";
const SUPER: &str = "super";
const FRAMEWORK_PACKAGE: &str = "afterimage";
/// The folder that kinds share.
pub(crate) const SHARED: &str = "package::lib";

/// Files that others import, by their names without folders and ending.
///
/// A node crate has one as a constant ([`Library::new`]): `import package::noise::hash;` imports from its file `noise`.
/// The folder of a kind has one at run time ([`Library::of_files`]): `super::noise` is the file beside the kind's, and
/// `package::lib::noise` the one that several kinds share. A file of a library may import others of it, and those of
/// the framework's library: `afterimage::noise`.
#[derive(Debug)]
pub struct Library {
    built_in: &'static [(&'static str, &'static str)],
    folder: &'static str,
    files: OnceLock<Vec<SourceFile>>,
}

impl Library {
    /// A library of texts in the program: the name and the text of each file.
    pub const fn new(files: &'static [(&'static str, &'static str)]) -> Self {
        Self { built_in: files, folder: PACKAGE, files: OnceLock::new() }
    }

    /// A library of untrusted files, the path and the text of each: those beside the file of a kind, and those that
    /// kinds share.
    pub fn of_files(
        own: impl IntoIterator<Item = (String, String)>,
        shared: impl IntoIterator<Item = (String, String)>,
    ) -> Self {
        let file = |folder| {
            move |(name, text): (String, String)| SourceFile::untrusted(name.into(), text.into()).in_folder(folder)
        };
        let files = own.into_iter().map(file(SUPER)).chain(shared.into_iter().map(file(SHARED)));
        Self { built_in: &[], folder: PACKAGE, files: OnceLock::from(files.collect::<Vec<_>>()) }
    }

    fn files(&self) -> &[SourceFile] {
        let file = |(stem, text): &(&'static str, &'static str)| {
            let name = if stem.ends_with(".wgsl") { (*stem).into() } else { format!("{stem}.wgsl").into() };
            SourceFile::new(name, (*text).into()).in_folder(self.folder)
        };
        self.files.get_or_init(|| self.built_in.iter().map(file).collect())
    }

    pub(crate) fn file(&self, name: &str) -> Option<&SourceFile> {
        self.files().iter().find(|file| file.stem() == name)
    }

    /// The paths of its files.
    pub(crate) fn paths(&self) -> impl Iterator<Item = String> {
        self.files().iter().map(|file| format!("{}::{}", file.folder, file.stem()))
    }
}

/// The library that every file may import.
pub(crate) static FRAMEWORK: Library =
    Library { built_in: afterimage_shaders::LIBRARY, folder: FRAMEWORK_PACKAGE, files: OnceLock::new() };

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
        match (&self.brought, &other.brought) {
            (ImportedName::Nothing, ImportedName::Nothing) => true,
            (ImportedName::Static(own), ImportedName::Static(other)) => std::ptr::eq(*own, *other),
            _ => {
                let [own, other] = [self, other].map(|source| source.library().map_or(&[][..], Library::files));
                own.len() == other.len() && own.iter().zip(other).all(|(own, other)| own.is_same(other))
            }
        }
    }
}
