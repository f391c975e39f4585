//! `render --watch`: renders again whenever an input file changes.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::Loader;
use afterimage_graph::node::NodeKind;
use afterimage_media::{FileWatch, sequence};

use crate::args::{PipelineOptions, RenderArgs};
use crate::failure::Failure;
use crate::files::{FileLoader, Files, begin_run, read_document, registry, with_own};
use crate::pipeline::PipelineFile;
use crate::render::{self, WatchCache};
use crate::terminal::note;

/// `afterimage render`: once, or with `--watch` again after each change.
pub(crate) fn run(args: &RenderArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.watch { watch(args, tables) } else { render::run(args, tables, None) }
}

/// Renders, and renders again after each change. Prints errors and waits for the next change. Never returns.
fn watch(args: &RenderArgs, tables: &[&[NodeKind]]) -> ! {
    let mut files = FileWatch::new(|| {});
    let (mut cache, mut changed) = (None::<WatchCache>, BTreeSet::new());
    loop {
        // A change during rendering counts: it may not be in the result.
        changed.extend(files.look());
        if let Some(cache) = &mut cache {
            cache.forget(&changed);
        }
        #[cfg(feature = "ocio")]
        if crate::ocio::forget(&changed) {
            cache = None;
        }
        begin_run();
        // While a file has errors, the files that it named before may be the ones to be corrected.
        files.extend(places(args, tables));
        match render::run(args, tables, Some(&mut cache)) {
            Ok(()) => note(&format!("wrote {}; waiting for changes, Ctrl-C ends it", written(args))),
            Err(failure) => {
                failure.report();
            }
        }
        changed = files.wait();
    }
}

/// The files that are written, in words.
fn written(args: &RenderArgs) -> String {
    let named = args.outputs.iter().filter_map(|output| output.split_once('=')).map(|(_, file)| file);
    let files: Vec<String> = args.out.as_deref().into_iter().chain(named).map(|file| format!("`{file}`")).collect();
    files.join(", ")
}

/// The files to watch: the pipeline and the files that it names, folders of kinds, images, and files of OpenColorIO.
fn places(args: &RenderArgs, tables: &[&[NodeKind]]) -> BTreeSet<PathBuf> {
    let mut places = files_of(&args.pipeline, tables, &args.options);
    places.extend(with_own(&args.options.kinds, Some(&args.pipeline)).nodes);
    let named = args.inputs.iter().filter_map(|input| input.split_once('=')).map(|(_, file)| file);
    for file in args.input.as_deref().into_iter().chain(named) {
        match sequence::Input::find(file, args.frames.as_deref()).or_else(|_| sequence::Input::find(file, None)) {
            Ok(input) => places.extend(input.sources().into_iter().map(|(_, source)| source.path)),
            Err(_) => drop(places.insert(file.into())),
        }
    }
    #[cfg(feature = "ocio")]
    {
        // Those of the pipeline have been made with it. The command reports the errors.
        args.reading.config_spaces().for_each(|space| drop(crate::ocio::check_space(space)));
        places.extend(crate::ocio::files());
    }
    places
}

/// Records which files are loaded, also those that do not exist.
pub(crate) struct RecordingLoader {
    files: Files,
    named: RefCell<BTreeSet<PathBuf>>,
}

impl RecordingLoader {
    pub(crate) fn new(files: Files) -> Self {
        Self { files, named: RefCell::default() }
    }

    /// The files that were loaded.
    pub(crate) fn named(self) -> BTreeSet<PathBuf> {
        self.named.into_inner()
    }
}

impl Loader for RecordingLoader {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.named.borrow_mut().insert(path.into());
        self.files.load(path)
    }

    fn load_override(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.named.borrow_mut().insert(path.into());
        self.files.load_override(path)
    }
}

impl FileLoader for RecordingLoader {
    fn name(&self, path: &str) {
        self.files.name(path);
    }
}

/// The pipeline file and the files that it names: extended and used pipelines, looks, tables. Files that cannot be read
/// name no others.
fn files_of(path: &Path, tables: &[&[NodeKind]], options: &PipelineOptions) -> BTreeSet<PathBuf> {
    let loader = RecordingLoader::new(Files::of(path, &options.kinds));
    if let (Ok(registry), Ok(document)) = (registry(tables, &options.kinds, Some(path)), read_document(path)) {
        let file = PipelineFile::new(&document, &registry, &loader);
        // The command that uses the pipeline reports its errors.
        let _ = file.check(&PipelineOptions { sets: Vec::new(), facts: Vec::new(), ..options.clone() });
    }
    let mut files = loader.named();
    files.insert(path.to_owned());
    files
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::args::{Arguments, Command};

    fn places_of(words: &[&str]) -> BTreeSet<PathBuf> {
        match Arguments::try_parse_from(["afterimage", "render"].iter().chain(words)).unwrap().command {
            Command::Render(args) => places(&args, &[afterimage_nodes::ALL]),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_a_picture_is_made_from_is_seen_to_change_and_the_picture_is_not() {
        let folder = std::env::temp_dir().join(format!("afterimage-watch-{}", std::process::id()));
        let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
        std::fs::create_dir_all(folder.join("kinds/gray")).unwrap();
        std::fs::create_dir_all(folder.join("night")).unwrap();
        let base = "Pipeline(inputs: { \"scene\": Encoded }, outputs: { \"display\": \"look\" }, \
                    nodes: { \"look\": ColorLut(source: \"scene\", file: \"dusk.png\") })";
        std::fs::write(file("base.ron"), base).unwrap();
        std::fs::write(file("night/a.ron"), "Pipeline(extends: \"../base.ron\")").unwrap();
        std::fs::write(file("shot.0001.exr"), "a picture").unwrap();
        let (kinds, pipeline, shot, out) =
            (file("kinds"), file("night/a.ron"), file("shot.####.exr"), file("kinds/o.png"));
        let words = [pipeline.as_str(), &shot, "-o", &out];
        let root = folder.to_str().unwrap();
        let words = [&words[..], &["--allow", root]].concat();
        let places = places_of(&[&words[..], &["--nodes", &kinds]].concat());
        // A folder without kinds is a mistake, and is waited for all the same.
        assert!(places.contains(&folder.join("kinds")) && places.contains(&folder.join("night/a.ron")), "{places:?}");
        let places: BTreeSet<PathBuf> = places.into_iter().chain(places_of(&words)).collect();
        let mut files = FileWatch::new(|| {});
        files.extend(places);
        for name in ["base.ron", "dusk.png", "night/a.ron", "shot.0001.exr", "kinds/gray/gray.wgsl"] {
            std::fs::write(file(name), "something of another length").unwrap();
            let changed = files.wait();
            assert!(changed.iter().any(|path| path.ends_with(name)), "{name}: {changed:?}");
        }
        std::fs::write(&out, "the picture").unwrap();
        std::fs::write(file("base.ron"), "a change that ends the wait").unwrap();
        let changed = files.wait();
        assert!(changed.iter().all(|path| path.ends_with("base.ron")), "{changed:?}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
