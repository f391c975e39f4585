//! Tables as images of a plan.

use std::sync::Arc;

use afterimage_graph::prelude::*;

use super::{ROW, Table, texels};

/// A table as a constant image, for an argument of a kernel function. Copies share the texels.
#[derive(Clone, Debug)]
pub struct TableImage {
    pub argument: Arc<str>,
    /// The label of the image.
    pub name: &'static str,
    pub desc: ImageDesc,
    pub bytes: Arc<[u8]>,
}

impl TableImage {
    /// The entries of a 1-D table in rows, in half floats or 32 bits.
    pub fn curve(name: &'static str, entries: &[[f32; 3]], half: bool) -> Self {
        let (width, rows) = (entries.len().min(ROW), entries.len().div_ceil(ROW));
        let desc = ImageDesc::new(Size::new(width as u32, rows as u32));
        let bytes = texels(entries, width * rows, half).into();
        Self { argument: name.into(), name, desc: stored(desc, half), bytes }
    }

    /// A 3-D table as a volume.
    pub fn cube(argument: impl Into<Arc<str>>, table: &Table, half: bool) -> Self {
        let side = table.size as u32;
        let desc = ImageDesc::volume(Size::volume(side, side, side));
        let bytes = table.bytes(half, table.entries.len()).into();
        Self { argument: argument.into(), name: "cube", desc: stored(desc, half), bytes }
    }
}

fn stored(desc: ImageDesc, half: bool) -> ImageDesc {
    desc.format(if half { Format::Rgba16Float } else { Format::Rgba32Float })
}
