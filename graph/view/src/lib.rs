//! The viewer: a window to look at pipelines and to adjust their parameters, and the same in a browser.
//!
//! [`Model`] is the state without a window: the pipeline, its images, the user's changes, and time. The feature `page`
//! is for the browser.
#![allow(missing_docs, reason = "no host uses this crate: the program and the page are its only users")]

#[cfg(any(test, all(target_family = "wasm", feature = "page")))]
mod address;
#[cfg(not(target_family = "wasm"))]
mod desktop;
mod model;
mod monotone;
#[cfg(all(target_family = "wasm", feature = "page"))]
pub mod page;
mod problem;
pub mod render;
pub mod scopes;
mod ui;
#[cfg(not(target_family = "wasm"))]
mod ui_renderer;

#[cfg(not(target_family = "wasm"))]
pub use desktop::{Desktop, Wake};
pub use model::*;
pub use monotone::monotone;
pub use problem::Problem;
pub use ui::{
    Comparison, ExportKind, Exported, FileRequest, MakeProject, MeasureDifference, MeasuredPicture, NewFiles,
    PictureView, RecentFiles, Subject, Tab, Tabs, Viewer,
};
#[cfg(not(target_family = "wasm"))]
pub use ui_renderer::{FrameTarget, OpenFile, Opened, UiRenderer};
