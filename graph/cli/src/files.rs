//! Reads pipelines, folders of node kinds, and the files that pipelines name.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage::host::{KindFiles, built_in, is_kind, kind_folders, kinds_in};
use afterimage_graph::check::Loader;
use afterimage_graph::document::{Document, parse};
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_media::{
    FileError, ForeignFormat, ImageFormat, Permit, read_permitted, read_permitted_text, read_text, real_path, run_files,
};
use afterimage_pipelines::BuiltIn;

use crate::args::KindOptions;
use crate::built_in::{MAX_TEXT, hint};
use crate::failure::Failure;

/// Begins the list of files of a run, with those of OpenColorIO, which are not read again.
pub(crate) fn begin_run() {
    run_files::begin();
    #[cfg(feature = "ocio")]
    crate::ocio::list_files();
}

/// The most bytes of all files together that one pipeline names. The largest table has about 450 MiB as text.
const MAX_BYTES: u64 = 1 << 30;

/// Reads the files that a pipeline names.
pub(crate) trait FileLoader: Loader {
    /// Reports a file that the pipeline names, for this tier or for another.
    fn name(&self, path: &str);
}

impl FileLoader for BuiltIn {
    fn name(&self, _: &str) {}
}

/// Reads the files that an untrusted file may name: those in its folder and below, and in the folders of `--allow`.
pub(crate) struct Files {
    /// The description of the first of the folders, for errors.
    own: &'static str,
    folders: Vec<PathBuf>,
    /// The number of bytes that may still be read.
    left: Cell<u64>,
    /// The description of a file in the list of the run.
    what: &'static str,
    /// True if the pipeline is a built-in one: the files that it names are built in, too.
    built_in: bool,
}

impl Files {
    /// The files that a pipeline may name. The list of the run has the pipeline from now on.
    pub(crate) fn of(pipeline: &Path, options: &KindOptions) -> Self {
        run_files::reads(pipeline, "the pipeline");
        // The parent of a bare name is empty, and means the current folder.
        let folder = pipeline.parent().unwrap_or(Path::new(""));
        let folders = folders(folder, &options.allow);
        let (own, what) = ("the folder of the pipeline", "a file that the pipeline names");
        let built_in = built_in(pipeline).is_some();
        Self { own, folders, left: Cell::new(MAX_BYTES), what, built_in }
    }

    /// The files of a folder of kinds. A link may lead out of it.
    fn of_kinds(folder: &Path, allow: &[PathBuf]) -> Self {
        let folders = folders(folder, allow);
        let (own, what) = ("the folder of `--nodes`", "a file of a node kind");
        Self { own, folders, left: Cell::new(MAX_BYTES), what, built_in: false }
    }

    /// Permits a file to be read, by its path without links, or returns the reason why not.
    fn permit(&self, real: &Path) -> Result<(), String> {
        if self.folders.iter().any(|folder| real.starts_with(folder)) {
            return Ok(());
        }
        let folder = real.parent().unwrap_or(real);
        Err(format!("only files in {} and below are read; `--allow {}` permits this one", self.own, folder.display()))
    }

    fn bytes(&self, path: &Path, permit: Permit<'_>) -> Result<Arc<[u8]>, String> {
        let bytes = read_permitted(path, self.left.get(), permit).map_err(|error| error.message)?;
        self.left.set(self.left.get() - bytes.len() as u64);
        run_files::reads(path, self.what);
        Ok(bytes.into())
    }
}

/// The folders whose files may be read, without links. A folder that does not exist permits nothing; that it has no
/// files is reported elsewhere.
fn folders(own: &Path, allow: &[PathBuf]) -> Vec<PathBuf> {
    let all = [own].into_iter().chain(allow.iter().map(PathBuf::as_path));
    all.filter_map(|folder| real_path(folder).ok()).collect()
}

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        if self.built_in {
            return BuiltIn.load(path);
        }
        self.bytes(Path::new(path), &|real| self.permit(real))
    }

    fn load_override(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.bytes(Path::new(path), &|_| Ok(()))
    }
}

impl FileLoader for Files {
    fn name(&self, path: &str) {
        if !self.built_in {
            run_files::reads(Path::new(path), self.what);
        }
    }
}

impl KindFiles for Files {
    type Error = Failure;

    fn list(&self, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
        let entries = std::fs::read_dir(folder)
            .map_err(|error| Failure::unreadable(format!("`{}` has no node kinds: {error}", folder.display())))?;
        let mut paths: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort();
        Ok(paths)
    }

    fn text(&self, path: &Path, what: &str) -> Result<String, Failure> {
        let text = read_permitted_text(path, MAX_TEXT, &|real| self.permit(real));
        run_files::reads(path, self.what);
        text.map_err(|error| unreadable(path, what, error))
    }

    fn permits(&self, path: &Path) -> bool {
        real_path(path).is_ok_and(|real| self.permit(&real).is_ok())
    }

    fn no_kind(&self, message: String, hint: &str) -> Failure {
        Failure::user(message).hint(hint)
    }
}

/// The text of a file that the user names; `what` names it in the error.
pub(crate) fn text(path: &Path, what: &str) -> Result<String, Failure> {
    read_text(path, MAX_TEXT).map_err(|error| unreadable(path, what, error))
}

fn unreadable(path: &Path, what: &str, error: FileError) -> Failure {
    let failure = Failure::unreadable(format!("cannot read the {what} `{}`: {}", path.display(), error.message));
    match error.hint {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}

/// The kinds of the program, of plug-in folders, and of the folder of a pipeline.
pub(crate) fn registry(
    tables: &[&[NodeKind]],
    options: &KindOptions,
    pipeline: Option<&Path>,
) -> Result<Registry, Failure> {
    let from_folders = folder_kinds(&with_own(options, pipeline))?;
    let mut all = tables.to_vec();
    all.push(&from_folders);
    let hint = "a kind of `--nodes` needs a name that no other kind has; `afterimage nodes` lists the built-in ones";
    Registry::new(&all).map_err(|error| Failure::user(error).hint(hint))
}

/// The options with the folder of the pipeline, if kinds lie there.
pub(crate) fn with_own(options: &KindOptions, pipeline: Option<&Path>) -> KindOptions {
    let own = pipeline.filter(|path| built_in(path).is_none()).and_then(Path::parent);
    let mut nodes: Vec<PathBuf> = kind_folders(own, &options.nodes).into_iter().map(Path::to_owned).collect();
    nodes.retain(|folder| options.nodes.contains(folder) || has_kinds(folder));
    KindOptions { nodes, allow: options.allow.clone() }
}

fn has_kinds(folder: &Path) -> bool {
    let mut entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    is_kind(folder) || entries.any(|entry| is_kind(&entry.path()))
}

/// The kinds of the folders.
pub(crate) fn folder_kinds(folders: &KindOptions) -> Result<Vec<NodeKind>, Failure> {
    let mut kinds = Vec::new();
    for folder in &folders.nodes {
        let found = kinds_in(folder, &Files::of_kinds(folder, &folders.allow))?;
        if found.is_empty() {
            return Err(Failure::user(format!("no folder in `{}` has a `node.ron`", folder.display())));
        }
        kinds.extend(found);
    }
    Ok(kinds)
}

/// Reads and parses a pipeline file, or parses a built-in pipeline.
pub(crate) fn read_document(path: &Path) -> Result<Document, Failure> {
    if let Some((name, text)) = built_in(path) {
        return Ok(parse(&format!("{name}.ron"), text)?);
    }
    if path.symlink_metadata().is_err() && path.extension().is_none() {
        let failure = Failure::unreadable(format!("there is no pipeline `{}`", path.display()));
        return Err(failure.hint(hint(&path.to_string_lossy())));
    }
    if path.is_dir() {
        let failure = Failure::unreadable(format!("cannot read the pipeline `{}`: it is a folder", path.display()));
        return Err(failure.hint("name a .ron file in it, or a built-in pipeline: `afterimage pipelines` lists them"));
    }
    let document = text(path, "pipeline").and_then(|text| Ok(parse(&path.to_string_lossy(), &text)?));
    // Names can end in anything: only a file that is no pipeline is one of something else.
    document.map_err(|failure| if path.is_file() { other_file(path).unwrap_or(failure) } else { failure })
}

/// True if a file is an image, by its name, also of a format that is not read.
pub(crate) fn is_image_name(path: &Path) -> bool {
    ImageFormat::of_name(path).is_some() || ForeignFormat::of_name(path).is_some()
}

/// Descriptions of files that are no pipelines, by the endings of their names.
const OTHER_FILES: [(&[&str], &str, &str); 3] = [
    (
        &["cube", "spi1d", "spi3d", "clf", "ctf", "3dl", "csp", "vf", "cdl", "cc", "ccc"],
        "a color file",
        "a node reads it: `\"look\": ColorLut(source: \"display\", file: \"look.cube\")`, or `Cdl`",
    ),
    (
        &["ini", "fx", "slangp", "slang", "glslp", "glsl", "cgp", "hlsl", "xmp", "lrtemplate", "look", "json", "toml"],
        "a preset or a shader of another program",
        "a pipeline is a text that begins with `Pipeline(`; `afterimage nodes` lists the kinds of its nodes",
    ),
    (&["wgsl", "wesl"], "a shader", "a folder with a `node.ron` and its shader is a kind: `--nodes FOLDER`"),
];

/// The error of a file that is something else than a pipeline.
fn other_file(path: &Path) -> Option<Failure> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    const FIRST: &str = "the pipeline comes first: `afterimage render PIPELINE.ron IMAGE -o out.png`";
    let (what, hint) = match OTHER_FILES.iter().find(|(endings, ..)| endings.contains(&ending.as_str())) {
        Some((_, what, hint)) => (*what, (*hint).to_owned()),
        None => match ForeignFormat::of_name(path) {
            Some(film) if film.is_film() => (film.what, FIRST.replace("IMAGE", "FILM").replace("out.png", "out.mov")),
            Some(foreign) => (foreign.what, format!("{FIRST}; {}", foreign.way)),
            None => ImageFormat::of_name(path).map(|_| ("an image", FIRST.to_owned()))?,
        },
    };
    Some(Failure::user(format!("`{}` is {what}, not a pipeline", path.display())).hint(hint))
}
