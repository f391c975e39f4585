//! The longest vectors of an image by tiles, for kinds that gather along them.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("tiles");

/// The vectors that the texels of an image hold.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Vectors {
    /// Radii, in x.
    Radii,
    /// Paths of any direction, in x and y.
    Paths,
}

/// The side of tiles for vectors of at most this many texels: none reaches beyond the next tile.
pub(crate) fn side(longest: f64) -> u32 {
    (longest.ceil() as u32 + 1).max(8)
}

/// Records the image of the longest vectors in each tile of an image and in the eight tiles around it.
pub(crate) fn longest_around(pass: &mut Recorder<'_>, image: ImageId, vectors: Vectors, side: u32) -> ImageId {
    let size = pass.desc(image).size;
    let rows = Size::new(size.width.div_ceil(side), size.height);
    let tiles = Size::new(rows.width, size.height.div_ceil(side));
    let mask = if vectors == Vectors::Radii { [1.0, 0.0] } else { [1.0, 1.0] };
    let steps = [
        ("tiles_row", "vectors", "rows", rows),
        ("tiles_column", "rows", "tiles", tiles),
        ("tiles_around", "tiles", "around", tiles),
    ];
    steps.into_iter().fold(image, |image, (function, argument, name, size)| {
        let desc = ImageDesc::new(size);
        let result = match vectors {
            Vectors::Radii => pass.transient(name, desc),
            Vectors::Paths => pass.transient_signed(name, desc),
        };
        let call = pass.function(&SHADER, function).set("side", side).set("mask", mask);
        call.read(argument, image).write_to(result);
        result
    })
}
