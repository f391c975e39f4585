//! The content of the file of a `ColorLut`, with its textures. It is kept with the file's bytes: hosts set the node's
//! parameters in every frame.

use std::sync::{Arc, LazyLock, OnceLock};

use afterimage_graph::prelude::*;

use crate::lut::{Lut, LutError, PngLayout, TableImage};
use crate::lut_file::{LutFile, parse_lut_file};

/// The content of a file, and its textures.
pub struct Decoded {
    layout: PngLayout,
    /// The content of the file, or the error of reading it.
    pub content: Result<LutFile, LutError>,
    /// The textures of a table in 32 bits, and in half floats, once they are requested.
    images: [OnceLock<Vec<TableImage>>; 2],
}

static NO_FILE: LazyLock<Arc<Decoded>> =
    LazyLock::new(|| Arc::new(Decoded::new(PngLayout::Tiles, Ok(LutFile::Table(Lut::identity())))));

impl Decoded {
    /// The table of a file; `layout` is that of a PNG. Without a file, the identity.
    pub fn of(file: &FileValue, layout: PngLayout) -> Arc<Self> {
        let Some(bytes) = &file.bytes else { return NO_FILE.clone() };
        let accepts = |known: &Self| known.layout == layout;
        bytes.read(accepts, |bytes| Self::new(layout, parse_lut_file(bytes, layout)))
    }

    fn new(layout: PngLayout, content: Result<LutFile, LutError>) -> Self {
        let exact = |file| match file {
            LutFile::Table(lut) if lut.is_identity() => LutFile::Table(lut.ends()),
            file => file,
        };
        Self { layout, content: content.map(exact), images: Default::default() }
    }

    /// The textures of a table: of its 1-D table, then of its 3-D table.
    pub fn images(&self, lut: &Lut, half: bool) -> &[TableImage] {
        self.images[usize::from(half)].get_or_init(|| {
            let curve = lut.curve.as_ref().map(|table| TableImage::curve("curve", &table.entries, half));
            let cube = lut.cube.as_ref().map(|table| TableImage::cube("cube", table, half));
            curve.into_iter().chain(cube).collect()
        })
    }
}
