//! Drawing of pictures, and reading of texels for scopes, the pixel inspector and exports.

pub(crate) mod device;
mod grid;
mod image_copy;
mod picture;
mod readback;
mod screen;
mod texel_reader;

pub use grid::{GRID, Grid};
pub use image_copy::ImageCopy;
pub use picture::{Drawn, Flags, Painter, Placement, Shown};
pub use screen::{DRAWN, SDR_WHITE, Screen};
pub use texel_reader::{TexelReader, TexelRequest, TexelValue};
