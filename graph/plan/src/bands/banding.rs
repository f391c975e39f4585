//! A plan in bands, as a value.

use std::collections::BTreeMap;
use std::ops::Range;

use afterimage_graph::node::ImageId;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Banding {
    /// The sizes of the images of which textures hold a band.
    pub sizes: Vec<BandedSize>,
    /// For each image the place of its size, if its texture holds a band.
    pub images: Vec<Option<usize>>,
    /// The rows of the texture of each such image: fewer than those of the size for one that no pass reads.
    pub rows: Vec<u32>,
    /// The sweeps in their order.
    pub sweeps: Vec<Sweep>,
    /// For each image, true if it has a texture: before the first sweep, in it, before the second one, and so on.
    pub lives: Vec<Vec<bool>>,
    /// Bytes of a copy from or to the host, unless a row has more.
    pub piece: u64,
    /// Bytes that are taken, of all that the limits count.
    pub bytes: u64,
    /// Bytes that the rows on their way take on the host.
    pub host_bytes: u64,
}

/// Images of one size that are in textures band by band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BandedSize {
    /// Width and height of the images.
    pub size: [u32; 2],
    /// Rows of the textures that passes read.
    pub rows: u32,
}

/// One way over the picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sweep {
    /// The passes that run before it, over whole images.
    pub before: Vec<usize>,
    pub bands: Vec<Band>,
}

/// One step of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Band {
    /// For each size, the row that is the first of the textures.
    pub first: Vec<u32>,
    /// The rows of host images that it needs.
    pub inputs: Vec<(ImageId, Range<u32>)>,
    /// The passes that run, in order.
    pub passes: Vec<BandPass>,
    /// The rows of images of the host that it makes, by the places of the outputs.
    pub outputs: Vec<(usize, Range<u32>)>,
}

/// Rows of an input for a band.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputRows {
    pub image: ImageId,
    pub rows: Range<u32>,
    /// The first row that this band or a later one of the sweep needs.
    pub needed: u32,
}

impl Sweep {
    /// The rows of inputs that its bands need, in their order.
    pub fn inputs(&self) -> Vec<InputRows> {
        let mut needed = BTreeMap::new();
        let mut all = Vec::new();
        for (image, rows) in self.bands.iter().flat_map(|band| &band.inputs).rev() {
            let first = needed.entry(image.0).or_insert(u32::MAX);
            *first = rows.start.min(*first);
            all.push(InputRows { image: *image, rows: rows.clone(), needed: *first });
        }
        all.reverse();
        all
    }
}

/// A pass in a band.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BandPass {
    pub pass: usize,
    /// Rows of workgroups.
    pub groups: Range<u32>,
    /// Rows of its first result; of no meaning for one that is not made row by row.
    pub rows: Range<u32>,
    /// For each size, the rows that all images which it reads have texels for.
    pub known: Vec<Range<u32>>,
}
