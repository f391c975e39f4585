//! The plug-in in apps without a window.

mod live;
mod pixels;
mod program;
mod shown;
mod views;
