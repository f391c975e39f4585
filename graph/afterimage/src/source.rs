//! Sources of pipelines.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::node::NodeKind;
use afterimage_pipelines::PIPELINES;

/// The source of a pipeline, and the files that it may use. A path or a name is one: `Post::open(&gpu, "look.ron")`.
///
/// * A path is that of a pipeline file. If there is no such file, it may be the name of a built-in pipeline, with or
///   without `.ron`: see [`PIPELINES`](crate::host::PIPELINES).
/// * A file may name files of its own folder and below: pipelines that it extends, looks, tables.
///   [`allow`](Self::allow) permits other folders. A built-in pipeline and a [text](Self::text) may name built-in ones.
/// * Folders with a `node.ron` that lie beside a file are node kinds, as is the folder of the file.
///   [`folder`](Self::folder) adds others.
///
/// ```
/// use afterimage::Source;
/// let source = Source::text("look.ron", r#"Pipeline(
///     inputs: { "scene": Color },
///     nodes: { "display": Encode(source: "scene", transfer: Srgb) },
///     outputs: { "display": "display" },
/// )"#);
/// let at_tier = Source::from("tsushima").tier("low");
/// # drop((source, at_tier));
/// ```
#[derive(Clone, Debug)]
pub struct Source {
    pub(crate) place: Place,
    pub(crate) kinds: Vec<NodeKind>,
    pub(crate) kind_folders: Vec<PathBuf>,
    pub(crate) allowed: Vec<PathBuf>,
    pub(crate) tier: Option<String>,
    pub(crate) pipeline_cache: Option<Arc<[u8]>>,
}

#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// A file, or the name of a built-in pipeline.
    Path(PathBuf),
    Text {
        name: String,
        text: String,
    },
}

impl Source {
    /// A pipeline as text. `name` is for errors.
    pub fn text(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self::of(Place::Text { name: name.into(), text: text.into() })
    }

    /// The name of the built-in pipeline, the path of the file, or the name of the text.
    #[cfg(all(feature = "offline", not(target_family = "wasm")))]
    pub(crate) fn name(&self) -> String {
        match &self.place {
            Place::Text { name, .. } => name.clone(),
            Place::Path(path) => {
                built_in(path).map_or(path.to_string_lossy().into_owned(), |(name, _)| name.to_owned())
            }
        }
    }

    fn of(place: Place) -> Self {
        Self {
            place,
            kinds: Vec::new(),
            kind_folders: Vec::new(),
            allowed: Vec::new(),
            tier: None,
            pipeline_cache: None,
        }
    }

    /// Adds node kinds in Rust to the built-in ones.
    pub fn kinds(mut self, kinds: &[NodeKind]) -> Self {
        self.kinds.extend_from_slice(kinds);
        self
    }

    /// Adds the node kinds of a folder: itself if it has a `node.ron`, or each folder in it that has one.
    pub fn folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.kind_folders.push(folder.into());
        self
    }

    /// Permits the pipeline to name files of a folder and below.
    pub fn allow(mut self, folder: impl Into<PathBuf>) -> Self {
        self.allowed.push(folder.into());
        self
    }

    /// Lets [`Post::open`](crate::Post::open) begin with the driver's cache of compiled pipelines, as
    /// [`pipeline_cache_data`](crate::host::Executor::pipeline_cache_data) of the [executor] returned it in an earlier
    /// run. Bytes that are damaged, or of another adapter, driver or version, are ignored. Browsers have a cache of
    /// their own.
    ///
    /// [executor]: crate::Post::executor
    pub fn pipeline_cache(mut self, data: impl Into<Arc<[u8]>>) -> Self {
        self.pipeline_cache = Some(data.into());
        self
    }

    /// Begins with a tier.
    pub fn tier(mut self, tier: impl Into<String>) -> Self {
        self.tier = Some(tier.into());
        self
    }
}

impl<P: AsRef<Path> + ?Sized> From<&P> for Source {
    fn from(path: &P) -> Self {
        Self::of(Place::Path(path.as_ref().to_owned()))
    }
}

/// The name and the text of the built-in pipeline that a path names, with or without `.ron`; a file of that name wins.
pub fn built_in(path: &Path) -> Option<(&'static str, &'static str)> {
    let name = path.to_str()?;
    let name = name.strip_suffix(".ron").unwrap_or(name);
    let found = PIPELINES.iter().find(|(known, _)| *known == name)?;
    // Also a link in a circle, which is reported where it is read.
    path.symlink_metadata().is_err().then_some(*found)
}

/// The names of all built-in pipelines, as a hint for a path that is none of them and no file.
pub fn built_in_hint() -> String {
    let names: Vec<&str> = PIPELINES.iter().map(|(name, _)| *name).collect();
    format!("name a .ron file, or one of the built-in pipelines: {}", names.join(", "))
}
