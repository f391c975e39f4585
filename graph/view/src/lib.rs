//! The viewer: a window to look at pipelines and to turn their parameters, and the same in a browser.
//!
//! [`Model`] is what is shown, without a window: a pipeline, what feeds it, what the user has changed, and when.

#[cfg(not(target_family = "wasm"))]
mod desktop;
mod model;
#[cfg(all(target_family = "wasm", feature = "page"))]
pub mod page;
mod problem;
pub mod render;
pub mod scopes;
#[cfg(not(target_family = "wasm"))]
mod stage;
mod ui;

#[cfg(not(target_family = "wasm"))]
pub use desktop::{Desktop, MakeImages, Wake};
pub use model::*;
pub use problem::Problem;
#[cfg(not(target_family = "wasm"))]
pub use stage::{OpenFile, Opened, Stage, Target as FrameTarget};
pub use ui::{Comparison, ExportKind, Exported, PictureView, Subject, Tab, Viewer};
